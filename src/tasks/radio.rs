//! Exchanges frames with the radio chip over a serial line: packets of the chain and of clients,
//! battery, power button.
//!
//! The chip sends nothing until it has received a good frame, and receives no packets until it is
//! told that its radio is set up. So [`transmit`] sends it all settings at boot, and again when its
//! answers say otherwise, when it hears nothing, and when the line has been silent for a while, since
//! then the chip was reset. In Bluetooth mode, in which it starts, it is told as few settings as
//! possible (`onboard::hardware`). No packet goes on the air before the chip has answered.
//!
//! The chip's program drops what it has no room for, 127 bytes, and does not tell. It takes one frame
//! in each round of its loop, of a millisecond at most: so the settings are sent one in two
//! milliseconds, and what else is sent is a packet of the chain's, once in its turn, and one answer
//! for each packet that a client sent.
//!
//! The chain's packets are P2P packets on port [`PORT`]. `crates/airlink` decides their content and
//! the moment at which they are sent. A packet that the chip does not take at that moment is not
//! sent, since it would collide in another drone's turn.
//!
//! A drone without keys sends no such packet, not even an empty one. The chip begins in Bluetooth
//! mode, which ends with the first packet of its own protocol that it receives or sends
//! (crazyflie2-nrf-firmware, `main.c`): so the first drone that transmits ends it for itself and for
//! the drones in range, and a drone without keys needs to receive only a Crazyradio.
//!
//! Clients send the vendor's protocol, CRTP, which `onboard::Drone` answers with at most one packet
//! for each that comes in.

use core::future::{Future, poll_fn};
use core::pin::pin;
use core::sync::atomic::{AtomicBool, Ordering};

use crtp::{Packet, Power, Ranges, Snapshot};
use embassy_futures::select::{Either4, select4};
use embassy_futures::yield_now;
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{self, RingBufferedUartRx, UartTx};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Timer, with_timeout};
use onboard::hardware::{HardwareFault, RadioChip};
use sensors::multi_ranger::Beam;
use storage::board_name::Board;
use storage::settings::Radio;
use units::{Dbm, Volts};
use wire::p2p::Kind;
use wire::syslink::{
    Battery, Decoder, Frame, Incoming, MAX_FRAME, MAX_P2P, Outgoing, Port, Release,
};

use crate::board::flow_control::{FlowControl, guarded};
use crate::board::{clock, identity};
use crate::probe::UCHAIN_PROBE;
use crate::tasks::drone::{Drone, Shared};
use crate::tasks::health::{self, Tally, Task};
use crate::tasks::latest::Latest;
use crate::tasks::{control, flow, rangers, store};

/// Where the chain's packets are. 15 is the port of the vendor's token ring, 0 that of its
/// example.
const PORT: u8 = 11;

/// The battery's voltage, until the control loop takes it.
pub(crate) static VOLTAGE: Latest<Option<Volts>> = Latest::new(None);
/// Battery and charger.
pub(crate) static BATTERY: Latest<Option<Battery>> = Latest::new(None);
/// The strength of the last packet that the chip received from any sender.
pub(crate) static RSSI: Latest<Option<Dbm>> = Latest::new(None);

/// Reports of others that came in.
pub(crate) static HEARD: Tally = Tally::new();
/// Counts bytes that are no frame, damaged frames, and errors of the line.
pub(crate) static ERRORS: Tally = Tally::new();
/// Frames that the chip did not take in time.
pub(crate) static DROPPED: Tally = Tally::new();

/// Answers to the operator: one for each packet that came from there, so there are never many.
static ANSWERS: Channel<CriticalSectionRawMutex, Packet, 4> = Channel::new();

/// The power button was pressed.
static BUTTON: Signal<CriticalSectionRawMutex, ()> = Signal::new();
static SHUTS_DOWN: AtomicBool = AtomicBool::new(false);
/// The chip, as far as its answers show it. Both tasks change it: they share an executor, and do not
/// wait in between.
static CHIP: Latest<RadioChip> = Latest::new(RadioChip::new());

/// Whether the power button was pressed, so that power is about to go.
pub(crate) fn is_shutting_down() -> bool {
    SHUTS_DOWN.load(Ordering::Relaxed)
}

/// The receiving task's longest wait: the chip sends a frame every 5 ms once it has been asked to.
const SILENCE: Duration = Duration::from_secs(1);
/// A frame of 70 bytes takes 0.7 ms, and longer where the chip says "wait".
const WRITE_LIMIT: Duration = Duration::from_millis(5);
/// The chip says "wait" for a few ms at most while it works.
const HOLD_LIMIT: Duration = Duration::from_millis(20);
/// Between two settings: see above.
const SETTINGS_APART: Duration = Duration::from_millis(2);
/// A packet of the chain's that the chip does not take within this time would be late for its turn.
const LATE: Duration = Duration::from_micros(300);
/// An answer of 31 bytes takes 0.4 ms of the line; it is not begun when it would delay a packet of
/// the chain's.
const ANSWER: Duration = Duration::from_millis(1);
/// The delay before the power may go: for the store to finish a write, two pages at 5 ms, and for
/// the drone's next turn on the air, which comes within a frame of 100 ms.
const FLUSH_LIMIT: Duration = Duration::from_millis(110);
/// The sending task's longest round.
const ROUND: Duration = Duration::from_millis(250);
/// The shortest one after a turn in which nothing was sent.
const PAUSE: Duration = Duration::from_millis(1);

/// In the air, a drone with less flying time than this left has a low battery.
const SCARCE: units::Duration = units::Duration::from_secs(60);

/// The receiving task.
#[embassy_executor::task]
pub(crate) async fn receive(mut line: RingBufferedUartRx<'static>, shared: &'static Shared) -> ! {
    let mut decoder = Decoder::new();
    let mut bytes = [0; 128];
    loop {
        health::sign(Task::Receive);
        let received = {
            let mut read = pin!(line.read(&mut bytes));
            let read = poll_fn(|context| guarded(|| read.as_mut().poll(context)));
            with_timeout(SILENCE, read).await
        };
        match received {
            Ok(Ok(length)) => {
                let mut rest = bytes.get(..length).unwrap_or_default();
                let bad = decoder.counters().bad_checksums;
                while let Some(frame) = decoder.next(&mut rest) {
                    take(&frame, shared);
                }
                if decoder.counters().bad_checksums != bad {
                    ERRORS.count();
                }
            }
            // The next read starts the line again.
            Ok(Err(_)) => {
                ERRORS.count();
                yield_now().await;
            }
            Err(_) => {}
        }
        shared.attend(clock::now());
    }
}

/// Hands a received frame to the drone or to the cells of this module.
fn take(frame: &Frame<'_>, shared: &Shared) {
    let packet = Incoming::parse(frame);
    if let Ok(packet) = &packet {
        change_chip(|chip| chip.take(clock::now(), packet));
    }
    match packet {
        Ok(Incoming::P2pBroadcast { port, rssi, data } | Incoming::P2p { port, rssi, data })
            if port.number() == PORT =>
        {
            let kind = shared.tell(|drone| drone.receive(clock::now(), rssi, data)).flatten();
            match kind {
                Some(Kind::Report) => HEARD.count(),
                Some(Kind::Command) => show_order(shared),
                _ => {}
            }
        }
        Ok(Incoming::Raw(packet)) => {
            if let Some(answer) = shared.tell(|drone| answer(drone, packet)).flatten() {
                // Where there is no room, the chip has not asked for the ones before.
                let _ = ANSWERS.try_send(answer);
            }
        }
        Ok(Incoming::RawBroadcast(packet)) => {
            shared.tell(|drone| hear(drone, packet));
        }
        Ok(Incoming::Battery(battery)) => {
            VOLTAGE.set(Some(battery.voltage));
            BATTERY.set(Some(battery));
        }
        Ok(Incoming::Rssi(rssi)) => RSSI.set(rssi),
        Ok(Incoming::ShutdownRequest) => {
            SHUTS_DOWN.store(true, Ordering::Relaxed);
            BUTTON.signal(());
        }
        Ok(_) => {}
        Err(_) => ERRORS.count(),
    }
}

fn show_order(shared: &Shared) {
    if let Some(counter) = shared.with(|drone| drone.last_order()).flatten() {
        UCHAIN_PROBE.show_order(counter);
    }
}

/// Takes a packet of a client: the answer to it, or to one before it.
fn answer(drone: &mut Drone, packet: &[u8]) -> Option<Packet> {
    hear(drone, packet);
    let now = clock::now();
    let snapshot = drone.snapshot(now, &measured(now));
    drone.poll_client(now, &snapshot)
}

/// Takes a packet of a client, or of a positioning system.
fn hear(drone: &mut Drone, packet: &[u8]) {
    drone.note_decks(flow::is_there(), rangers::are_there());
    drone.client(clock::now(), packet);
    store::keep_settings(drone.take_unsaved());
}

/// The measurements of the board, for clients.
fn measured(now: units::Instant) -> Snapshot {
    let loop_measured = control::MEASURED.get();
    let status = control::STATUS.get();
    let mut snapshot = status.map_or(Snapshot::DEFAULT, |status| onboard::observed(&status));
    snapshot.duties = loop_measured.duties;
    snapshot.gyro = loop_measured.gyro;
    snapshot.accel = loop_measured.accel;
    let range = |beam| rangers::measured(beam, now);
    snapshot.ranges = Ranges {
        front: range(Beam::Front),
        back: range(Beam::Back),
        left: range(Beam::Left),
        right: range(Beam::Right),
        up: range(Beam::Up),
        down: range(Beam::Down),
    };
    snapshot.flow = flow::latest();
    snapshot.power = power(&snapshot);
    snapshot.radio.rssi = RSSI.get();
    snapshot.radio.broadcasts = HEARD.get();
    snapshot
}

fn power(snapshot: &Snapshot) -> Power {
    match BATTERY.get() {
        _ if is_shutting_down() => Power::ShuttingDown,
        Some(battery) if battery.charging => Power::Charging,
        Some(battery) if battery.usb => Power::Charged,
        _ if snapshot.endurance.is_some_and(|left| left < SCARCE) => Power::Low,
        _ => Power::Battery,
    }
}

/// The sending task.
#[embassy_executor::task]
pub(crate) async fn transmit(
    mut line: UartTx<'static, Async>,
    mut hold: FlowControl,
    shared: &'static Shared,
) -> ! {
    let mut out = Out { line: &mut line, hold: &mut hold };
    loop {
        health::sign(Task::Transmit);
        if CHIP.get().is_to_be_told(clock::now())
            && let Some(settings) = store::settings()
        {
            change_chip(|chip| chip.note_told(clock::now(), settings.radio));
            out.introduce(&settings.radio).await;
        }
        let due = if CHIP.get().answers() { shared.due().map(at) } else { None };
        let wake = (Instant::now() + ROUND).min(due.unwrap_or(Instant::MAX));
        match select4(Timer::at(wake), shared.news(), ANSWERS.receive(), BUTTON.wait()).await {
            Either4::First(()) if due.is_some_and(|due| due <= Instant::now()) => {
                out.speak(shared).await;
            }
            Either4::First(()) | Either4::Second(()) => {}
            Either4::Third(answer) => {
                if let Some(due) = due
                    && due < Instant::now() + ANSWER
                {
                    Timer::at(due).await;
                    out.speak(shared).await;
                }
                out.send(&Outgoing::Raw(answer.bytes())).await;
            }
            Either4::Fourth(()) => out.let_go(shared).await,
        }
    }
}

/// Converts a moment to the executor's type.
fn at(moment: units::Instant) -> Instant {
    Instant::from_micros(moment.as_micros())
}

fn change_chip(change: impl FnOnce(&mut RadioChip)) {
    let mut chip = CHIP.get();
    change(&mut chip);
    CHIP.set(chip);
}

/// The fault of the board or the radio chip that keeps the drone on the ground, if there is one.
pub(crate) fn hardware_fault() -> Option<HardwareFault> {
    match identity::board() {
        Board::Crazyflie21 => CHIP.get().fault(clock::now()),
        Board::Crazyflie20 | Board::Other => Some(HardwareFault::Board),
    }
}

/// The release of the radio chip's firmware, if it is known.
pub(crate) fn release() -> Option<Release> {
    CHIP.get().release()
}

/// The line to the chip.
struct Out<'a> {
    line: &'a mut UartTx<'static, Async>,
    hold: &'a mut FlowControl,
}

impl Out<'_> {
    /// Sets the radio up, and requests the reports that the chip sends only on request.
    async fn introduce(&mut self, radio: &Radio) {
        let frames = [
            Outgoing::NrfVersion,
            Outgoing::Channel(radio.channel),
            Outgoing::Datarate(radio.datarate),
            Outgoing::Address(radio.address),
            Outgoing::Power(radio.power),
            Outgoing::RadioReady,
            Outgoing::BatteryAutoupdate,
        ];
        for frame in frames.iter().filter(|frame| CHIP.get().is_told(frame)) {
            self.send(frame).await;
            Timer::after(SETTINGS_APART).await;
        }
    }

    /// Sends the packet that the link has for this turn. Where the chip does not take it, the packet
    /// stays in the link, which sends it in its next turn.
    async fn speak(&mut self, shared: &Shared) {
        let (Some(port), Ok(())) =
            (Port::new(PORT), with_timeout(LATE, self.hold.wait_for_room()).await)
        else {
            DROPPED.count();
            Timer::after(PAUSE).await;
            return;
        };
        let mut packet = [0; MAX_P2P];
        let length = shared.with(|drone| drone.transmit(clock::now(), &mut packet)).flatten();
        match length.and_then(|length| packet.get(..length)) {
            Some(data) => {
                self.send(&Outgoing::P2pBroadcast { port, data }).await;
                change_chip(|chip| chip.note_sent(clock::now()));
            }
            None => Timer::after(PAUSE).await,
        }
    }

    /// Answers the power button: the power may go as soon as the motors stand and no write is under
    /// way. If one of its turns comes before that, the drone leaves the chain. A drone in the air
    /// does not answer; the chip then switches the power off by itself after a second.
    async fn let_go(&mut self, shared: &Shared) {
        let until = Instant::now() + FLUSH_LIMIT;
        let leaves = !control::is_airborne() && shared.with(Drone::leave) == Some(true);
        while Instant::now() < until {
            match shared.due().map(at).filter(|_| leaves) {
                Some(due) if due <= Instant::now() => self.speak(shared).await,
                None if store::is_idle() => break,
                Some(_) | None => Timer::after(PAUSE).await,
            }
        }
        if !control::is_airborne() {
            self.send(&Outgoing::ShutdownAck).await;
        }
    }

    /// Sends a frame, or drops it where the chip does not take it.
    async fn send(&mut self, packet: &Outgoing<'_>) {
        let mut frame = [0; MAX_FRAME];
        let length = packet.encode(&mut frame).unwrap_or_default();
        let bytes = frame.get(..length).unwrap_or_default();
        if bytes.is_empty() {
            return;
        }
        let sent = match with_timeout(HOLD_LIMIT, self.hold.wait_for_room()).await {
            Ok(()) => with_timeout(WRITE_LIMIT, self.write(bytes)).await,
            Err(timeout) => Err(timeout),
        };
        if !matches!(sent, Ok(Ok(()))) {
            DROPPED.count();
        }
    }

    /// Writes bytes, with pauses where the chip asks for them.
    async fn write(&mut self, bytes: &[u8]) -> Result<(), usart::Error> {
        let mut written = pin!(self.line.write(bytes));
        poll_fn(|context| self.hold.guard(|| written.as_mut().poll(context))).await
    }
}
