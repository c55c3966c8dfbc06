//! The members of a mission: where each starts, its body, and its on-board code.

use agent::{Exploration, Fitness, Outputs, State};
use flight::Cause;
use onboard::Sensed;
use random::{Purpose, Stream};
use units::{Dbm, Metres, MissionKind, NodeId, Point2, Role, Setpoint};
use wire::syslink::MAX_P2P;
use world::{SkeletonPlace, Spot};

use super::hosted::{Clocks, Hosted};
use super::{STEPS_PER_ROUND, World, surroundings};
use bodies::craft::Craft;
use bodies::emulated::Emulated;
use bodies::others::{Obstacle, Others};
use bodies::point::PointBody;
use bodies::{Body, Flown};
use scenario::{Fidelity, LossKind, Scenario, Start};

/// One member of the chain.
pub(super) struct Member {
    pub(super) onboard: Onboard,
    pub(super) role: Role,
    pub(super) body: Body,
    pub(super) random: Stream,
    /// In which physics step of a round its turn comes.
    pub(super) phase: u64,
    pub(super) outputs: Option<Outputs>,
    pub(super) senses: Sensed,
    /// How the scenario has taken it from the chain, if it has.
    pub(super) lost: Option<LossKind>,
}

/// The on-board code of a member.
pub(super) enum Onboard {
    /// The crates of the firmware, called from here.
    Hosted(Box<Hosted>),
    /// The firmware's ELF, in an emulator.
    Emulated(Box<Emulated>),
}

/// A packet on the serial line of a drone whose radio has received it.
pub(super) struct OnLine {
    pub(super) at_us: u64,
    pub(super) rssi: Dbm,
    pub(super) length: usize,
    pub(super) data: [u8; MAX_P2P],
}

impl Onboard {
    /// When the member next has something to send; never, for an emulated one, whose packets come out
    /// of its radio chip.
    pub(super) fn due_us(&self) -> u64 {
        match self {
            Self::Hosted(hosted) => hosted.due_us(),
            Self::Emulated(_) => u64::MAX,
        }
    }

    pub(super) fn hosted(&self) -> Option<&Hosted> {
        match self {
            Self::Hosted(hosted) => Some(hosted),
            Self::Emulated(_) => None,
        }
    }

    pub(super) fn emulated(&self) -> Option<&Emulated> {
        match self {
            Self::Hosted(_) => None,
            Self::Emulated(emulated) => Some(emulated),
        }
    }

    /// The map of a drone that explores.
    pub(super) fn exploration(&self) -> Option<&Exploration> {
        match self {
            Self::Hosted(hosted) => hosted.exploration(),
            Self::Emulated(emulated) => emulated.exploration(),
        }
    }

    pub(super) fn emulated_mut(&mut self) -> Option<&mut Emulated> {
        match self {
            Self::Hosted(_) => None,
            Self::Emulated(emulated) => Some(emulated),
        }
    }
}

impl Member {
    /// The member as the rangers of others see it. The base stands on the ground.
    pub(super) fn as_obstacle(&self) -> Obstacle {
        Obstacle { at: self.body.position(), height: self.body.height() }
    }

    /// The state of the member's agent.
    pub(super) fn state(&self) -> State {
        match &self.onboard {
            Onboard::Hosted(hosted) => hosted.drone().state(),
            Onboard::Emulated(_) => {
                self.outputs.map_or(State::Idle, |outputs| outputs.status.state)
            }
        }
    }

    /// Lets the firmware in an emulator fly the body from now on.
    pub(super) fn emulate(&mut self, emulated: Emulated) {
        self.onboard = Onboard::Emulated(Box::new(emulated));
        self.body.hand_over();
    }

    /// Whether the member can neither hear nor be heard.
    pub(super) fn is_silenced(&self) -> bool {
        let is_lost = self.lost.is_some_and(LossKind::is_silent);
        is_lost || self.body.craft().is_some_and(Craft::is_silenced)
    }

    /// Takes the member from the chain; a drone that is lost already stays as it is.
    pub(super) fn lose(&mut self, how: LossKind) {
        if self.lost.is_none() && how == LossKind::Gone {
            self.body.command(Setpoint::Stop);
        }
        self.lost.get_or_insert(how);
    }

    /// The fitness of a drone whose flight code brings it down.
    pub(super) fn forced_down(&self) -> Fitness {
        let why = Cause::Overload;
        if self.body.height() > 0.0 { Fitness::Landing(why) } else { Fitness::Landed(why) }
    }
}

/// A craft on the ground or in the air at this spot.
fn flown(
    scenario: &Scenario,
    world: &World,
    (at, nose): (Point2, [f32; 2]),
    flying: bool,
    height: Metres,
    random: Stream,
) -> Flown {
    let config = flight::FlightConfig::CRAZYFLIE_2_1;
    let craft = Craft::standing(config, at, nose, &scenario.vehicle, random);
    if flying {
        let craft = craft.hovering(height, surroundings(scenario, world, Others::NONE));
        Flown::new(craft, Setpoint::hover(height))
    } else {
        Flown::new(craft, Setpoint::Off)
    }
}

/// How far before the base a drone stands in the row of those that will fly, m: the head in front.
fn ahead_in_row_m(scenario: &Scenario, n: usize) -> f32 {
    Start::SPACING * scenario.drones.flying().saturating_sub(n) as f32
}

/// Where the members start: explorers, relays, base.
pub(super) fn spots(scenario: &Scenario, world: &World, start: &mut Stream) -> Vec<Spot> {
    let skeleton = world.skeleton();
    let base = scenario.drones.base;
    let flying = scenario.drones.explorers + scenario.drones.relays;
    let mut spots = Vec::with_capacity(flying + 1);
    match &scenario.drones.start {
        Start::Mouth => {
            // In a row in front of the base, in the order in which they will fly.
            let places = (0..flying).map(|n| ahead_in_row_m(scenario, n));
            spots.extend(places.map(|ahead| {
                let place = SkeletonPlace { along: base.on.along + ahead, ..base.on };
                Spot::on(skeleton, place)
            }));
        }
        Start::Random { head } => {
            let way = skeleton.path(base.on, head.on);
            let mut drawn = draw_apart(scenario.drones.relays, way.length(), start);
            drawn.sort_by(f32::total_cmp);
            spots.push(*head);
            spots.extend(drawn.into_iter().rev().map(|x| Spot::on(skeleton, way.at(x))));
        }
        Start::Placed(at) => spots.extend(at),
    }
    spots.push(base);
    spots
}

/// `count` lengths of the way to a head at `head`, uniform but for keeping apart from each other.
fn draw_apart(count: usize, head: f32, start: &mut Stream) -> Vec<f32> {
    let mut drawn: Vec<f32> = Vec::with_capacity(count);
    // A scenario has room for three times as many, so a dozen tries place each of them; the
    // bound is for the reader.
    for _ in 0..10_000 {
        if drawn.len() == count {
            break;
        }
        let place = head * start.uniform();
        let apart = |other: f32| (place - other).abs() >= Start::APART;
        if apart(0.0) && apart(head) && drawn.iter().all(|&other| apart(other)) {
            drawn.push(place);
        }
    }
    drawn
}

pub(super) fn member(
    scenario: &Scenario,
    world: &World,
    seed: u64,
    start: &mut Stream,
    n: usize,
    spot: &Spot,
    clocks: Clocks,
) -> Member {
    let role = scenario.drones.role(n);
    let id = NodeId(n as u8);
    let mut random = Stream::new(seed, Purpose::Drone(id.0));
    let flying = role != Role::Base && !matches!(scenario.drones.start, Start::Mouth);
    // From its place in the row before the base, as the odometers of drones that took off there.
    let from_row = world.path_to(spot.on).length() - ahead_in_row_m(scenario, n);
    let way_flown = flying.then_some(Metres(from_row.max(0.0)));
    let height = if flying { scenario.agent.flight.height } else { Metres::ZERO };
    let nose = world.skeleton().at(spot.on).1;
    let body = match (scenario.fidelity, role) {
        (Fidelity::Flight | Fidelity::Virtual, Role::Head | Role::Relay) => {
            let random = Stream::new(seed, Purpose::Craft(id.0));
            let at = (spot.at, nose);
            Body::Craft(Box::new(flown(scenario, world, at, flying, height, random)))
        }
        (Fidelity::Point, _) | (_, Role::Base) => {
            let mut body = PointBody::at(spot.at, nose, height.0, &scenario.vehicle, &mut random);
            if flying {
                body.command(Setpoint::hover(height));
            }
            // A chain of points is a study of policies, which a battery would cut short.
            if scenario.mission != MissionKind::Chain && role != Role::Base {
                body = body.with_battery(&scenario.vehicle);
            }
            Body::Point(body)
        }
    };
    let hosted = Hosted::new(scenario, seed, (id, role), way_flown, clocks);
    Member {
        onboard: Onboard::Hosted(Box::new(hosted)),
        role,
        body,
        random,
        phase: ((start.uniform() * STEPS_PER_ROUND as f32) as u64).min(STEPS_PER_ROUND - 1),
        outputs: None,
        senses: Sensed::NONE,
        lost: None,
    }
}
