//! The rangers: one down from the Flow deck, five from the Multi-ranger deck.
//!
//! They share the decks' bus with the EEPROM ([`crate::store`]), one transaction at a time. Which
//! decks there are is found out at boot, and holds until the next one: of a deck that is missing
//! then, the other's rangers do not depend.

use core::sync::atomic::{AtomicBool, Ordering};

use agent::AgentConfig;
use agent::mounting::{self, Beams};
use crtp::Ranges;
use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Timer};
use sensors::multi_ranger::{Beam, BeamState, DeckProbe, MultiRanger, RangerConfig, Sweep};
use sensors::vl53l1x::{RangeStatus, Reading};
use units::{Instant, Metres};

use crate::bus::Bus;
use crate::clock;
use crate::health::{self, Tally, Task};
use crate::latest::Latest;

/// The decks' bus, for tasks of the thread.
pub(crate) type DeckBus = Mutex<NoopRawMutex, Bus>;
/// One task's share of it.
pub(crate) type Share = I2cDevice<'static, NoopRawMutex, Bus>;

/// The height, until the control loop takes it.
pub(crate) static DOWN: Latest<Option<Reading>> = Latest::new(None);

/// The latest reading of each.
static SEEN: Latest<Seen> = Latest::new(Seen([None; 6]));

/// There is a Multi-ranger deck.
static DECK: AtomicBool = AtomicBool::new(false);

/// Transactions that failed.
static ERRORS: Tally = Tally::new();

/// Between polls: a fifth of the shortest time between two readings.
const ROUND: Duration = Duration::from_millis(5);

/// Between questions for the decks, of which there are 20 at most.
const PROBE_ROUND: Duration = Duration::from_millis(50);

/// A reading that is older is none any more: three of the sides' periods.
const BELIEVED_FOR: units::Duration = units::Duration::from_millis(100);

/// Farther than this nobody steers by a side beam.
const REACH: Metres = AgentConfig::DEFAULT.nav.reach;

/// In the order of [`Beam::ALL`].
#[derive(Clone, Copy)]
struct Seen([Option<(Reading, Instant)>; 6]);

impl Seen {
    /// What is believed of a beam now.
    fn of(&self, beam: Beam, now: Instant) -> Option<Reading> {
        let (_, latest) = Beam::ALL.into_iter().zip(self.0).find(|(other, _)| *other == beam)?;
        latest.filter(|(_, at)| now.since(*at) <= BELIEVED_FOR).map(|(reading, _)| reading)
    }
}

const SIDE_BEAMS: [Beam; 4] = [Beam::Front, Beam::Right, Beam::Back, Beam::Left];

/// What the four side beams say now.
pub(crate) fn sides(now: Instant) -> Beams {
    let seen = SEEN.get();
    let [front, right, back, left] =
        SIDE_BEAMS.map(|beam| mounting::side_beam(seen.of(beam, now).as_ref(), REACH));
    Beams { front, right, back, left }
}

/// Whether each of the four is there: it says something, whatever it sees.
pub(crate) fn all_sides(now: Instant) -> bool {
    let seen = SEEN.get();
    SIDE_BEAMS.into_iter().all(|beam| seen.of(beam, now).is_some())
}

/// What all six have measured, for whoever looks.
pub(crate) fn seen(now: Instant) -> Ranges {
    let seen = SEEN.get();
    let distance = |beam| {
        let reading = seen.of(beam, now)?;
        (reading.status == RangeStatus::Valid).then_some(reading.distance)
    };
    Ranges {
        front: distance(Beam::Front),
        back: distance(Beam::Back),
        left: distance(Beam::Left),
        right: distance(Beam::Right),
        up: distance(Beam::Up),
        down: distance(Beam::Down),
    }
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

/// Which rangers there are, a second after boot at the latest.
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
