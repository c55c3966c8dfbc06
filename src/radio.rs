//! The radio chip, at the other end of a serial line: reports in and out, battery, power button.
//!
//! The chip is silent until it has received a good frame, and deaf to the air until it is told
//! that its radio is set, so [`transmit`] tells it everything at boot, and again when the line has
//! been dead for a while: then the chip was reset, and has forgotten. The first report that goes
//! out ends the chip's Bluetooth mode (crazyflie2-nrf-firmware, `main.c`).
//!
//! Reports are P2P broadcasts on port [`PORT`]. Two drones whose rounds began at the same time
//! would talk over each other for ever, so each report waits a moment that differs from report to
//! report and from drone to drone.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use chain::neighbours::Heard;
use chain::report::Report;
use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{RingBufferedUartRx, UartTx};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Timer, with_timeout};
use units::Volts;
use wire::report as air;
use wire::settings::Settings;
use wire::syslink::{Battery, Decoder, Frame, Incoming, MAX_FRAME, Outgoing, Port};

use crate::board::Edge;
use crate::health::{self, Tally, Task};
use crate::latest::Latest;
use crate::{control, mind, store};

/// Where the chain's reports are. 15 is the port of the vendor's token ring, 0 that of its
/// example.
const PORT: u8 = 11;

/// The battery's voltage, until the control loop takes it.
pub(crate) static VOLTAGE: Latest<Option<Volts>> = Latest::new(None);
/// Battery and charger.
pub(crate) static BATTERY: Latest<Option<Battery>> = Latest::new(None);
/// The report to be sent next. A newer one replaces it.
pub(crate) static REPORT: Signal<CriticalSectionRawMutex, Report> = Signal::new();

/// Reports of others that came in.
pub(crate) static HEARD: Tally = Tally::new();
/// Frames and bytes that were none, and errors of the line.
pub(crate) static ERRORS: Tally = Tally::new();
/// Frames that the chip did not take in time.
pub(crate) static DROPPED: Tally = Tally::new();

/// The power button was pressed.
static BUTTON: Signal<CriticalSectionRawMutex, ()> = Signal::new();
static SHUTS_DOWN: AtomicBool = AtomicBool::new(false);
/// Good frames so far.
static FRAMES: AtomicU32 = AtomicU32::new(0);

/// Whether the power button was pressed, so that power is about to go.
pub(crate) fn is_shutting_down() -> bool {
    SHUTS_DOWN.load(Ordering::Relaxed)
}

/// The chip sends a frame every 5 ms once it has been asked to.
const SILENCE: Duration = Duration::from_secs(1);
/// A frame of 70 bytes takes 0.7 ms.
const WRITE_LIMIT: Duration = Duration::from_millis(5);
/// The chip empties its buffer of 128 bytes in a few ms.
const HOLD_LIMIT: Duration = Duration::from_millis(20);
/// For the store to finish a write: two pages at 5 ms.
const FLUSH_LIMIT: Duration = Duration::from_millis(60);
/// Rounds of the sending task without a frame from the chip, after which it is told everything
/// again: with five reports a second, a second.
const SILENT_ROUNDS: u8 = 5;
/// The sending task's longest round.
const ROUND: Duration = Duration::from_millis(250);

/// The receiving task.
#[embassy_executor::task]
pub(crate) async fn receive(mut line: RingBufferedUartRx<'static>) -> ! {
    let mut decoder = Decoder::new();
    let mut bytes = [0; 128];
    loop {
        health::sign(Task::Receive);
        match with_timeout(SILENCE, line.read(&mut bytes)).await {
            Ok(Ok(length)) => {
                let mut rest = bytes.get(..length).unwrap_or_default();
                let bad = decoder.counters().bad_checksums;
                while let Some(frame) = decoder.next(&mut rest) {
                    FRAMES.fetch_add(1, Ordering::Relaxed);
                    take(&frame);
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
    }
}

/// Passes on what came in.
fn take(frame: &Frame<'_>) {
    match Incoming::parse(frame) {
        Ok(Incoming::P2pBroadcast { port, rssi, data }) if port.number() == PORT => {
            match air::Report::decode(data) {
                Ok(report) => {
                    HEARD.count();
                    mind::hear(Heard { report: agent::air::from_air(&report), rssi });
                }
                Err(_) => ERRORS.count(),
            }
        }
        Ok(Incoming::Battery(battery)) => {
            VOLTAGE.set(Some(battery.voltage));
            BATTERY.set(Some(battery));
        }
        Ok(Incoming::ShutdownRequest) => {
            SHUTS_DOWN.store(true, Ordering::Relaxed);
            BUTTON.signal(());
        }
        Ok(_) => {}
        Err(_) => ERRORS.count(),
    }
}

/// The sending task.
#[embassy_executor::task]
pub(crate) async fn transmit(mut line: UartTx<'static, Async>, mut hold: Edge) -> ! {
    let mut out = Out { line: &mut line, hold: &mut hold };
    let mut frames = FRAMES.load(Ordering::Relaxed);
    // Rounds without a frame from the chip since it was last told; none before it was.
    let mut silent = None;
    loop {
        health::sign(Task::Transmit);
        if silent.is_none_or(|rounds: u8| rounds >= SILENT_ROUNDS)
            && let Some(settings) = store::settings()
        {
            out.introduce(&settings).await;
            silent = Some(0);
        }
        match with_timeout(ROUND, select(REPORT.wait(), BUTTON.wait())).await {
            Ok(Either::First(report)) => {
                Timer::after(jitter(&report)).await;
                out.report(&report).await;
            }
            Ok(Either::Second(())) => out.let_go().await,
            Err(_) => {}
        }
        let now = FRAMES.load(Ordering::Relaxed);
        silent = silent.map(|rounds| if now == frames { rounds.saturating_add(1) } else { 0 });
        frames = now;
    }
}

/// Up to 16 ms, by a multiplicative hash of number and sequence (Knuth, TAOCP 3, 6.4: 2³²/φ).
fn jitter(report: &Report) -> Duration {
    let key = (u32::from(report.from.0) << 16) | u32::from(report.sequence);
    Duration::from_micros((key.wrapping_mul(0x9E37_79B9) >> 18).into())
}

/// The line to the chip.
struct Out<'a> {
    line: &'a mut UartTx<'static, Async>,
    hold: &'a mut Edge,
}

impl Out<'_> {
    /// Sets the radio and asks for what the chip tells only those who ask.
    async fn introduce(&mut self, settings: &Settings) {
        let radio = &settings.radio;
        let frames = [
            Outgoing::NrfVersion,
            Outgoing::Channel(radio.channel),
            Outgoing::Datarate(radio.datarate),
            Outgoing::Address(radio.address),
            Outgoing::Power(radio.power),
            Outgoing::RadioReady,
            Outgoing::BatteryAutoupdate,
        ];
        for frame in &frames {
            self.send(frame).await;
        }
    }

    async fn report(&mut self, report: &Report) {
        let Some(port) = Port::new(PORT) else { return };
        let data = agent::air::to_air(report).encode();
        self.send(&Outgoing::P2pBroadcast { port, data: &data }).await;
    }

    /// Power may go as soon as the motors stand and nothing is being written. A drone in the air
    /// does not answer; the chip will then take the power away by itself after a second.
    async fn let_go(&mut self) {
        let began = embassy_time::Instant::now();
        while !store::is_idle() && began.elapsed() < FLUSH_LIMIT {
            Timer::after_millis(1).await;
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
        let held = with_timeout(HOLD_LIMIT, self.hold.wait_for_low()).await;
        let sent = match held {
            Ok(()) => with_timeout(WRITE_LIMIT, self.line.write(bytes)).await,
            Err(timeout) => Err(timeout),
        };
        if !matches!(sent, Ok(Ok(()))) {
            DROPPED.count();
        }
    }
}
