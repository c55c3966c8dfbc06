//! How missions begin: with the scenario's pilot or with clients, on the host or in an emulator.

use std::borrow::Cow;

use random::{Purpose, Stream};
use units::Order;

use super::contacts::Contacts;
use super::guide::Guide;
use super::hosted::Clocks;
use super::ideal::IdealLink;
use super::log::OrderLog;
use super::member::{member, spots};
use super::operator::Source;
use super::parts::Stopwatch;
use super::strengths::Strengths;
use super::track::Track;
use super::{Mission, World};
use bodies::emulated::Emulated;
use bodies::point::Response;
use medium::{Arrives, Medium, MediumConfig, Polling};
use scenario::{LinkModel, RadioSpec, Scenario};

/// The medium between the radios of a scenario.
pub(super) fn medium_of(scenario: &Scenario) -> MediumConfig {
    let base = scenario.drones.flying();
    let hz = scenario.radio.polling_hz;
    let polling = (hz > 0.0).then(|| Polling::at(base, hz));
    let config = MediumConfig::of(scenario.radio.reception);
    let RadioSpec { datarate, fades, .. } = scenario.radio;
    MediumConfig { datarate, fades, polling, ..config }
}

impl<'a> Mission<'a> {
    /// A mission by the scenario's pilot: all members are at their places, before the first packet.
    #[must_use]
    pub fn new(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        Self::with_clocks(scenario, world, seed, Clocks::Apart)
    }

    fn with_clocks(scenario: &'a Scenario, world: &'a World, seed: u64, clocks: Clocks) -> Self {
        let mut start = Stream::new(seed, Purpose::Start);
        let spots = spots(scenario, world, &mut start);
        let count = spots.len();
        let members: Vec<_> = spots
            .iter()
            .enumerate()
            .map(|(n, spot)| member(scenario, world, seed, &mut start, n, spot, clocks))
            .collect();
        Self {
            scenario,
            world,
            medium: Medium::new(medium_of(scenario), count, seed)
                .through(scenario.radio.trace.as_ref(), seed),
            track: Track::new(spots.iter().map(|spot| spot.on).collect()),
            strengths: Strengths::new(
                &world.radio,
                &scenario.radio,
                seed,
                spots.iter().map(|spot| spot.on),
            ),
            due_us: Vec::with_capacity(count),
            members,
            response: Response::new(&scenario.vehicle),
            source: Source::Script,
            pilot: Cow::Borrowed(&scenario.pilot),
            route: Guide::of(scenario, world),
            losses: Cow::Borrowed(&scenario.losses),
            now_us: 0,
            contacts: Contacts::default(),
            obstacles: Vec::with_capacity(count),
            orders: OrderLog::default(),
            intruders: None,
            ideal: match scenario.link {
                LinkModel::Exact => None,
                LinkModel::Ideal => Some(IdealLink::new(scenario, count, seed)),
            },
            stopwatch: Stopwatch::default(),
            law: None,
            halted: None,
        }
    }

    /// A mission by the scenario's pilot in which these drones, in an emulator, stand in place of those
    /// of their numbers.
    #[must_use]
    pub fn emulated(
        scenario: &'a Scenario,
        world: &'a World,
        seed: u64,
        drones: Vec<Emulated>,
    ) -> Self {
        let mut mission = Self::new(scenario, world, seed);
        let config = MediumConfig { arrives: Arrives::AtAntenna, ..medium_of(scenario) };
        mission.medium = Medium::new(config, mission.members.len(), seed)
            .through(scenario.radio.trace.as_ref(), seed);
        for drone in drones {
            if let Some(member) = mission.members.get_mut(usize::from(drone.node().0)) {
                member.emulate(drone);
            }
        }
        mission
    }

    /// This mission with a stopwatch, which tells what [`spent`](Self::spent) is asked for.
    #[must_use]
    pub fn timed(self) -> Self {
        Self { stopwatch: Stopwatch::started(), ..self }
    }

    /// A mission without the scenario's pilot: all drones wait for [`order`](Self::order).
    #[must_use]
    pub fn live(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        Self { source: Source::Live(Order::Wait), ..Self::new(scenario, world, seed) }
    }

    /// A mission with clients at the drones in the pilot's place, by [`client`](Self::client).
    #[must_use]
    pub fn served(scenario: &'a Scenario, world: &'a World, seed: u64) -> Self {
        let mission = Self::with_clocks(scenario, world, seed, Clocks::InStep);
        Self { source: Source::Clients, ..mission }
    }

    /// This mission with clients in the pilot's place, as [`served`](Self::served): for one with
    /// emulated drones.
    #[must_use]
    pub fn for_clients(self) -> Self {
        Self { source: Source::Clients, ..self }
    }
}
