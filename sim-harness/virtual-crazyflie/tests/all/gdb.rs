//! A debugger, spoken to as GDB speaks, over a socket.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use crate::image_tiny::{Nothing, machine, tiny};
use virtual_crazyflie::gdb::{Debugger, serve};
use virtual_crazyflie::log::{Log, Messages, Probe};
use virtual_crazyflie::machine::Machine;

/// What GDB does.
struct Client(TcpStream);

impl Client {
    fn connect(address: SocketAddr) -> Self {
        Self(TcpStream::connect(address).expect("the debugger listens"))
    }

    fn send(&mut self, packet: &str) {
        let sum = packet.bytes().fold(0_u8, u8::wrapping_add);
        self.0.write_all(format!("${packet}#{sum:02x}").as_bytes()).unwrap();
    }

    fn receive(&mut self) -> String {
        let mut byte = [0];
        let mut next = || {
            self.0.read_exact(&mut byte).unwrap();
            byte[0]
        };
        while next() != b'$' {}
        let mut packet = Vec::new();
        loop {
            match next() {
                b'#' => break,
                byte => packet.push(byte),
            }
        }
        let (_, _) = (next(), next());
        self.0.write_all(b"+").unwrap();
        run_lengths(&packet)
    }

    fn ask(&mut self, packet: &str) -> String {
        self.send(packet);
        self.receive()
    }

    fn pc(&mut self) -> u32 {
        word(&self.ask("pf"))
    }

    fn monitor(&mut self, command: &str) -> String {
        let hex: String = command.bytes().map(|byte| format!("{byte:02x}")).collect();
        self.send(&format!("qRcmd,{hex}"));
        let mut text = Vec::new();
        loop {
            match self.receive().strip_prefix('O') {
                Some("K") => return String::from_utf8(text).unwrap(),
                Some(hex) => text.extend(bytes(hex)),
                None => panic!("no answer to monitor {command}"),
            }
        }
    }
}

/// `0*"` is four zeros: the byte behind the star is 29 more than how often again.
fn run_lengths(packet: &[u8]) -> String {
    let mut text: Vec<u8> = Vec::new();
    let mut bytes = packet.iter();
    while let Some(byte) = bytes.next() {
        match (byte, text.last().copied()) {
            (b'*', Some(last)) => {
                let count = bytes.next().unwrap() - 29;
                text.extend(std::iter::repeat_n(last, count.into()));
            }
            _ => text.push(*byte),
        }
    }
    String::from_utf8_lossy(&text).into_owned()
}

fn bytes(hex: &str) -> Vec<u8> {
    hex.as_bytes()
        .as_chunks::<2>()
        .0
        .iter()
        .map(|pair| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap())
        .collect()
}

fn word(hex: &str) -> u32 {
    u32::from_le_bytes(bytes(&hex[..8]).try_into().unwrap())
}

fn listener() -> (TcpListener, SocketAddr) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    (listener, address)
}

/// A machine that serves GDB, and a client that has connected.
fn session() -> (Client, JoinHandle<Machine<Nothing>>) {
    let (listener, address) = listener();
    let serving = thread::spawn(move || {
        let machine = machine();
        let log = Log::new(Arc::new(Messages::of(machine.image()).unwrap()), Probe::Absent);
        serve(machine, listener, Some(log), 1_000_000_000_000).unwrap()
    });
    let mut client = Client::connect(address);
    client.ask("qSupported:swbreak+;hwbreak+;vContSupported+;xmlRegisters=arm");
    (client, serving)
}

fn address_of(name: &str) -> u32 {
    tiny().find(name).unwrap().address
}

#[test]
fn it_says_which_registers_there_are_and_what_they_hold() {
    let (mut client, serving) = session();
    assert!(client.ask("?").starts_with(['S', 'T']));
    let xml = client.ask("qXfer:features:read:target.xml:0,fff");
    assert!(xml.contains("org.gnu.gdb.arm.m-profile") && xml.contains("org.gnu.gdb.arm.vfp"));
    assert!(client.ask("qXfer:memory-map:read::0,fff").contains("rom"));
    // R0 to R15 and XPSR; sixteen D registers; FPSCR; six special ones.
    let all = bytes(&client.ask("g"));
    assert_eq!(all.len(), 17 * 4 + 16 * 8 + 4 + 6 * 4);
    assert_eq!(client.pc(), tiny().entry());
    assert_eq!(word(&client.ask("pd")), 0x2000_0400);
    // XPSR: Thumb. MSP is SP.
    assert_eq!(word(&client.ask("p19")), 1 << 24);
    assert_eq!(word(&client.ask("p2b")), 0x2000_0400);
    client.send("D");
    client.receive();
    serving.join().unwrap();
}

#[test]
fn registers_and_ram_can_be_written_and_flash_cannot() {
    let (mut client, serving) = session();
    assert_eq!(client.ask("P3=78563412"), "OK");
    assert_eq!(word(&client.ask("p3")), 0x1234_5678);
    // D7 is S14 and S15.
    assert_eq!(client.ask("P21=0102030405060708"), "OK");
    assert_eq!(client.ask("p21"), "0102030405060708");
    assert_eq!(client.ask("M20000500,4:aabbccdd"), "OK");
    assert_eq!(client.ask("m20000500,4"), "aabbccdd");
    assert_eq!(client.ask("m8004000,4"), "00040020");
    assert!(client.ask("M8004000,4:00000000").starts_with('E'));
    assert!(client.ask("m40000000,4").starts_with('E'));
    // CPUID, r0p1 (DDI 0403, B3.2.3).
    assert_eq!(client.ask("me000ed00,4"), "41c20f41");
    client.send("k");
    assert_eq!(serving.join().unwrap().cpu().register(3), 0x1234_5678);
}

#[test]
fn it_stops_at_breakpoints_and_goes_on_from_them() {
    let (mut client, serving) = session();
    let (inner, leaf) = (address_of("tiny::inner"), address_of("tiny::leaf"));
    assert_eq!(client.ask(&format!("Z1,{inner:x},2")), "OK");
    for _ in 0..3 {
        assert!(client.ask("c").contains("hwbreak"));
        assert_eq!(client.pc(), inner);
    }
    assert_eq!(client.ask(&format!("z1,{inner:x},2")), "OK");
    assert_eq!(client.ask(&format!("Z0,{leaf:x},2")), "OK");
    assert!(client.ask("c").contains("swbreak"));
    assert_eq!(client.pc(), leaf);
    assert!(client.monitor("where").contains("--- exception ---"));
    // There is no code in RAM that could be marked.
    assert!(client.ask("Z0,20000000,2").starts_with('E'));
    client.send("D");
    client.receive();
    let mut machine = serving.join().unwrap();
    assert!(!machine.program_mut().is_trapped(leaf));
}

#[test]
fn it_steps_instruction_by_instruction() {
    let (mut client, serving) = session();
    let mut alone = machine();
    for _ in 0..60 {
        assert!(client.ask("s").starts_with(['S', 'T']));
        alone.step(u64::MAX / 2).unwrap();
        assert_eq!(client.pc(), alone.cpu().pc());
    }
    client.send("k");
    assert_eq!(serving.join().unwrap().state_hash(), alone.state_hash());
}

#[test]
fn a_watched_variable_stops_it_behind_the_store() {
    let (mut client, serving) = session();
    let count = tiny().address_of("tiny::COUNT").unwrap();
    let inner = address_of("tiny::inner");
    assert_eq!(client.ask(&format!("Z1,{inner:x},2")), "OK");
    client.ask("c");
    assert_eq!(client.ask(&format!("z1,{inner:x},2")), "OK");
    assert_eq!(client.ask(&format!("m{count:x},4")), "07000000");
    assert_eq!(client.ask(&format!("Z2,{count:x},4")), "OK");
    // Reads leave nothing to see.
    assert_ne!(client.ask(&format!("Z3,{count:x},4")), "OK");
    let stopped = client.ask("c");
    assert!(stopped.contains(&format!("watch:{count:x}")), "{stopped}");
    // Adding 0 changed nothing; the supervisor adds 5.
    assert_eq!(client.ask(&format!("m{count:x},4")), "0c000000");
    assert_eq!(client.ask(&format!("z2,{count:x},4")), "OK");
    client.send("k");
    serving.join().unwrap();
}

#[test]
fn what_was_logged_and_when_can_be_asked_for() {
    let (mut client, serving) = session();
    let inner = address_of("tiny::inner");
    assert_eq!(client.monitor("log"), "");
    client.ask(&format!("Z1,{inner:x},2"));
    client.ask("c");
    assert!(client.monitor("log").contains("INFO  counted to 42"));
    assert_eq!(client.monitor("log"), "");
    assert!(client.monitor("time").starts_with("0.0000"));
    assert!(client.monitor("help").contains("monitor reset"));
    client.monitor("reset");
    assert_eq!(client.pc(), tiny().entry());
    client.ask("c");
    assert!(client.monitor("log").contains("counted to 42"));
    client.send("k");
    assert_eq!(serving.join().unwrap().reset_count(), 2);
}

#[test]
fn while_it_is_held_its_time_stands_still_and_without_a_debugger_it_runs_as_if_there_were_none() {
    let (listener, address) = listener();
    let mut debugger = Debugger::new(machine(), listener, None).unwrap();
    // No client is connected.
    debugger.run_until(1_000_000).unwrap();
    assert!(!debugger.is_attached());
    let mut client = Client::connect(address);
    let inner = address_of("tiny::inner");
    let (gone, was_gone) = std::sync::mpsc::channel::<()>();
    let running = thread::spawn(move || {
        let mut moment = 1_000_000;
        while was_gone.try_recv().is_err() {
            moment += 10_000;
            debugger.run_until(moment).unwrap();
        }
        assert!(!debugger.is_attached());
        (debugger.into_machine(), moment)
    });
    let first = client.monitor("time");
    assert_eq!(client.monitor("time"), first);
    client.ask(&format!("Z1,{inner:x},2"));
    client.ask("c");
    let stopped = client.monitor("time");
    assert_eq!(client.monitor("time"), stopped);
    client.ask(&format!("z1,{inner:x},2"));
    // It runs, until Ctrl-C.
    client.send("c");
    client.0.write_all(&[3]).unwrap();
    assert!(client.receive().contains("02"));
    client.send("D");
    client.receive();
    gone.send(()).unwrap();
    let (held, moment) = running.join().unwrap();
    let mut alone = machine();
    alone.run_until(moment).unwrap();
    assert_eq!(held.state_hash(), alone.state_hash());
}
