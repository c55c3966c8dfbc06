//! The rangers: one down from the Flow deck, five from the Multi-ranger deck.
//!
//! They share the decks' bus with the EEPROM ([`crate::store`]), one transaction at a time. Which
//! decks there are is found out at boot, and holds until the next one: of a deck that is missing
//! then, the other's rangers do not depend.

use agent::AgentConfig;
use agent::mounting::{self, Beams};
use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Timer};
use sensors::multi_ranger::{Beam, BeamState, DeckProbe, MultiRanger, RangerConfig, Sweep};
use sensors::vl53l1x::Reading;
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

/// The latest reading of each side.
static SIDES: Latest<Sides> = Latest::new(Sides([None; 4]));

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

/// Front, right, back and left.
#[derive(Clone, Copy)]
struct Sides([Option<(Reading, Instant)>; 4]);

const SIDE_BEAMS: [Beam; 4] = [Beam::Front, Beam::Right, Beam::Back, Beam::Left];

/// What the four side beams say now.
pub(crate) fn sides(now: Instant) -> Beams {
    let [front, right, back, left] = SIDES.get().0.map(|latest| {
        let believed = latest.filter(|(_, at)| now.since(*at) <= BELIEVED_FOR);
        mounting::side_beam(believed.as_ref().map(|(reading, _)| reading), REACH)
    });
    Beams { front, right, back, left }
}

/// Whether each of the four is there: it says something, whatever it sees.
pub(crate) fn all_sides(now: Instant) -> bool {
    let is_fresh = |(_, at): (Reading, Instant)| now.since(at) <= BELIEVED_FOR;
    SIDES.get().0.into_iter().all(|latest| latest.is_some_and(is_fresh))
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
            break config;
        }
        Timer::after(PROBE_ROUND).await;
    }
}

fn publish(sweep: &Sweep) {
    if let Some(down) = sweep.of(Beam::Down) {
        DOWN.set(Some(down));
    }
    let mut sides = SIDES.get();
    let now = clock::now();
    for (beam, place) in SIDE_BEAMS.into_iter().zip(&mut sides.0) {
        if let Some(reading) = sweep.of(beam) {
            *place = Some((reading, now));
        }
    }
    SIDES.set(sides);
}
