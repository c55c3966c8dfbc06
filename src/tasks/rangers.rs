//! The rangers: one down from the Flow deck, five from the Multi-ranger deck.
//!
//! They share the decks' bus with the EEPROM ([`crate::tasks::store`]), one transaction at a time. Which
//! decks there are is determined at boot: a missing deck does not stop the other deck's rangers.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Timer};
use onboard::mounting::Sides;
use sensors::multi_ranger::{Beam, BeamState, DeckProbe, MultiRanger, RangerConfig, Sweep};
use sensors::vl53l1x::{RangeStatus, Reading};
use units::{Instant, Metres};

use crate::board::bus::Bus;
use crate::board::clock;
use crate::tasks::health::{self, Tally, Task};
use crate::tasks::latest::Latest;

/// The decks' bus, for tasks of the thread.
pub(crate) type DeckBus = Mutex<NoopRawMutex, Bus>;
/// The handle of one task to the bus.
pub(crate) type Share = I2cDevice<'static, NoopRawMutex, Bus>;

/// The height, until the control loop takes it.
pub(crate) static DOWN: Latest<Option<Reading>> = Latest::new(None);

/// The latest reading of each ranger.
static SEEN: Latest<Seen> = Latest::new(Seen([None; 6]));

/// Set when there is a Multi-ranger deck.
static DECK: AtomicBool = AtomicBool::new(false);

/// Transactions that failed.
static ERRORS: Tally = Tally::new();

/// The pause between polls: a fifth of the shortest time between two readings.
const ROUND: Duration = Duration::from_millis(5);

/// The pause between attempts to find the decks, of which there are 20 at most.
const PROBE_ROUND: Duration = Duration::from_millis(50);

/// The age at which a reading is discarded: three periods of the side rangers.
const BELIEVED_FOR: units::Duration = units::Duration::from_millis(100);

/// In the order of [`Beam::ALL`].
#[derive(Clone, Copy)]
struct Seen([Option<(Reading, Instant)>; 6]);

impl Seen {
    /// The valid reading of a beam, if there is one.
    fn of(&self, beam: Beam, now: Instant) -> Option<Reading> {
        let (_, latest) = Beam::ALL.into_iter().zip(self.0).find(|(other, _)| *other == beam)?;
        latest.filter(|(_, at)| now.since(*at) <= BELIEVED_FOR).map(|(reading, _)| reading)
    }
}

/// The valid readings of the four side rangers.
pub(crate) fn sides(now: Instant) -> Sides {
    let seen = SEEN.get();
    Sides {
        front: seen.of(Beam::Front, now),
        right: seen.of(Beam::Right, now),
        back: seen.of(Beam::Back, now),
        left: seen.of(Beam::Left, now),
    }
}

/// The distance that a ranger has measured, for clients.
pub(crate) fn measured(beam: Beam, now: Instant) -> Option<Metres> {
    let reading = SEEN.get().of(beam, now)?;
    (reading.status == RangeStatus::Valid).then_some(reading.distance)
}

/// Whether there is a Multi-ranger deck.
pub(crate) fn are_there() -> bool {
    DECK.load(Ordering::Relaxed)
}

/// Transactions that failed since boot.
pub(crate) fn errors() -> u32 {
    ERRORS.get()
}

/// The task.
#[embassy_executor::task]
pub(crate) async fn run(bus: &'static DeckBus) -> ! {
    let config = decks(bus).await;
    let mut rangers = MultiRanger::new(I2cDevice::new(bus), config, clock::now());
    let mut known = [BeamState::Unused; 6];
    loop {
        Timer::after(ROUND).await;
        health::sign(Task::Rangers);
        publish(&rangers.poll(clock::now()).await);
        ERRORS.set(Beam::ALL.into_iter().map(|beam| rangers.errors(beam)).sum());
        for (beam, known) in Beam::ALL.into_iter().zip(&mut known) {
            let state = rangers.state(beam);
            if state != *known {
                defmt::info!("ranger {}: {}", beam, state);
            }
            *known = state;
        }
    }
}

/// Determines which rangers there are, within a second after boot.
async fn decks(bus: &'static DeckBus) -> RangerConfig {
    let mut probe = DeckProbe::new();
    loop {
        health::sign(Task::Rangers);
        if let Some(config) = probe.ask(I2cDevice::new(bus)).await {
            if config.down.is_none() {
                defmt::warn!("no Flow deck");
            } else if config.sides.is_none() {
                defmt::warn!("no Multi-ranger deck");
            }
            DECK.store(config.sides.is_some(), Ordering::Relaxed);
            break config;
        }
        Timer::after(PROBE_ROUND).await;
    }
}

fn publish(sweep: &Sweep) {
    if let Some(down) = sweep.of(Beam::Down) {
        DOWN.set(Some(down));
    }
    let mut seen = SEEN.get();
    let now = clock::now();
    for (beam, place) in Beam::ALL.into_iter().zip(&mut seen.0) {
        if let Some(reading) = sweep.of(beam) {
            *place = Some((reading, now));
        }
    }
    SEEN.set(seen);
}
