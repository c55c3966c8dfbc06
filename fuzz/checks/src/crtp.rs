//! Packets of any client: answers are packets, and end; and a client with read access changes
//! nothing but that it may stop the drone.

use crtp::{Access, Event, Outcome, Packet, Parameters, Server, Setpoint, Snapshot};
use units::{Duration, Instant, Metres};
use wire::crtp::Request;

/// More packets than can wait: answers, a console's lines and a packet for each log block.
const ENOUGH: u32 = 1000;

/// The bytes of the script that are left.
struct Script<'a>(&'a [u8]);

impl<'a> Script<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(byte)
    }

    fn bytes(&mut self, most: usize) -> &'a [u8] {
        let (bytes, rest) = self.0.split_at(most.min(self.0.len()));
        self.0 = rest;
        bytes
    }
}

/// A server, its clock, and the test's own count of its packets.
struct Bench {
    server: Server,
    parameters: Parameters,
    snapshot: Snapshot,
    now: Instant,
    received: u32,
    sent: u32,
}

/// Runs the bytes as a script. The first byte of each step is the length of a packet in five bits,
/// the access of its sender, and whether the server is polled, drained, or left for some
/// milliseconds; the packet follows.
pub fn check(data: &[u8]) {
    let mut script = Script(data);
    let mut bench = Bench {
        server: Server::new(),
        parameters: Parameters::DEFAULT,
        snapshot: Snapshot::DEFAULT,
        now: Instant::ZERO,
        received: 0,
        sent: 0,
    };
    while let Some(step) = script.byte() {
        let access = if step & 0x20 == 0 { Access::Full } else { Access::Read };
        bench.receive(script.bytes(usize::from(step & 0x1F) + 1), access);
        match step >> 6 {
            0 => {}
            1 => drop(bench.poll()),
            2 => bench.drain(),
            _ => bench.pass(script.byte().unwrap_or_default()),
        }
    }
    bench.drain();
}

impl Bench {
    fn receive(&mut self, bytes: &[u8], access: Access) {
        if let Ok(packet) = Packet::from_bytes(bytes)
            && let Ok(request) = Request::parse(&packet)
        {
            let again = request.packet();
            assert_eq!(Request::parse(&again).map(|request| request.packet()), Ok(again));
        }
        let before = self.parameters;
        let mut event = None;
        self.server.receive(self.now, bytes, access, &mut self.parameters, |asked, _| {
            assert_eq!(event.replace(asked), None, "one packet asks for one thing");
            Outcome::Done
        });
        self.received += 1;
        assert_eq!(self.server.counters().received, self.received);
        match event {
            None | Some(Event::ParameterSet(_)) => {}
            Some(Event::Setpoint(Setpoint::Hover { forward, lateral, yaw_rate, height })) => {
                let numbers = [forward.0, lateral.0, yaw_rate.0, height.0];
                assert!(numbers.iter().all(|number| number.is_finite()), "{event:?}");
            }
            Some(Event::Position(fix)) => {
                assert!(fix.at.iter().all(|one| one.0.abs() <= 100.0), "{event:?}");
                assert!(fix.yaw.is_none_or(|yaw| yaw.0.is_finite()), "{event:?}");
            }
            Some(_) => {}
        }
        if access == Access::Read {
            // Every client may stop a drone, and say where it is.
            let is_open = |event| {
                let stop = [Event::EmergencyStop, Event::EmergencyStopWatchdog];
                stop.contains(&event) || matches!(event, Event::Position(_))
            };
            assert!(event.is_none_or(is_open), "{event:?}");
        }
        if !matches!(event, Some(Event::ParameterSet(_))) {
            assert_eq!(self.parameters, before);
        }
        assert!(self.parameters.speed.0.is_finite() && self.parameters.height.0.is_finite());
    }

    fn poll(&mut self) -> Option<Packet> {
        let packet = self.server.poll(self.now, &self.snapshot, &self.parameters)?;
        self.sent += 1;
        assert_eq!(self.server.counters().sent, self.sent);
        assert_eq!(Packet::from_bytes(packet.bytes()), Ok(packet));
        Some(packet)
    }

    fn drain(&mut self) {
        let sent = (0..ENOUGH).take_while(|_| self.poll().is_some()).count();
        assert!((sent as u32) < ENOUGH, "there is no end to what is sent");
        assert!(self.server.due().is_none_or(|due| due > self.now));
    }

    fn pass(&mut self, milliseconds: u8) {
        self.now = self.now + Duration::from_millis(milliseconds.into());
        self.snapshot.taken = self.now;
        self.snapshot.odometer = Metres(f32::from_bits(u32::from(milliseconds) << 23));
    }
}
