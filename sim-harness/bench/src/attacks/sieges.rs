//! Whole missions beside which an attacker holds packets back, or repeats them elsewhere at once, for
//! as long as an attacker would: for most of the mission, from the first packet on, or for fifty
//! seconds in the middle of it. The mission is `demo`, in which relays follow a head into a cave and
//! come home, at point level; packets are held beside a chain with one relay, so that one radio of the
//! attacker reaches all of it.

use agent::{ChainDuty, Duty, LandReason, State};
use input::InputError;
use rayon::prelude::*;
use serde_json::{Value, json};
use units::Metres;
use world::{SkeletonPlace, World};

use super::measure::{has_neighbours, link_errors, mean};
use medium::timing::RAMP_UP_US;
use medium::{Jams, Repeater};
use mission::{Linked, Mission, ROUND_US};
use scenario::{Changes, Scenario};

/// The scenario's name.
pub const SCENARIO: &str = "demo";
/// The time at which the operator calls the chain home, and the length of the mission, µs.
const CALLED_US: u64 = 230_000_000;
const SPAN_US: u64 = 480_000_000;
/// The pilot releases the stick, and a while later the chain stands, µs. In `demo` the head flies on
/// almost to the call home.
const RELEASED_US: u64 = 110_000_000;
const STANDS_US: u64 = 130_000_000;
/// The length of an attack in the middle of a mission, µs.
const MIDDLE_US: u64 = 50_000_000;
/// A copy is played so much later after the end of a packet, µs, as not to collide with what the same
/// drone sends in the same turn of a later frame. It is still in its turn, in both directions together.
const BESIDE_US: u64 = 450;
/// A drone that has landed within this of the base is at home, m: the row of four drones at the mouth,
/// and as much again.
const HOME_M: f32 = 5.0;

/// When an attack goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct When {
    from_us: u64,
    until_us: u64,
}

impl When {
    const ALWAYS: Self = Self { from_us: 0, until_us: u64::MAX };
    /// While the chain stretches.
    const STRETCHING: Self = Self { from_us: 40_000_000, until_us: 40_000_000 + MIDDLE_US };
    /// While the chain stands.
    const STANDING: Self = Self { from_us: STANDS_US, until_us: STANDS_US + MIDDLE_US };
    /// From the middle on to the end.
    const TO_THE_END: Self = Self { from_us: 40_000_000, until_us: u64::MAX };

    fn name(self) -> &'static str {
        match self {
            Self::ALWAYS => "from the first packet on",
            Self::STRETCHING => "for 50 s while the chain stretches",
            Self::STANDING => "for 50 s while the chain stands",
            _ => "from 40 s on",
        }
    }

    const fn is_on(self, now_us: u64) -> bool {
        self.from_us <= now_us && now_us < self.until_us
    }
}

/// What the attacker does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Means {
    /// Nothing, beside a chain with one relay or with three.
    Nothing { relays: usize },
    /// Every packet is jammed at its receivers, and played so much later, µs.
    Hold { by_us: u64 },
    /// Packets heard at either of two places, m from the base, are sent at once at the other: after so
    /// many µs.
    Wormhole { places_m: [f32; 2], delay_us: u64, jams: bool },
}

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Siege {
    means: Means,
    when: When,
    /// The scenario's `retreat.longest_m`, where it is not the default.
    longest_m: Option<f32>,
}

/// A wormhole between these places.
const fn wormhole(places_m: [f32; 2], jams: bool, when: When) -> Siege {
    Siege { means: Means::Wormhole { places_m, delay_us: RAMP_UP_US, jams }, when, longest_m: None }
}

const fn hold(by_ms: u64, when: When) -> Siege {
    Siege { means: Means::Hold { by_us: by_ms * 1_000 }, when, longest_m: None }
}

const SIEGES: [Siege; 20] = [
    Siege { means: Means::Nothing { relays: 1 }, when: When::ALWAYS, longest_m: None },
    hold(1_000, When::STRETCHING),
    hold(1_000, When::STANDING),
    hold(1_000, When::TO_THE_END),
    hold(1_800, When::STRETCHING),
    hold(500, When::ALWAYS),
    hold(1_000, When::ALWAYS),
    hold(1_800, When::ALWAYS),
    Siege { means: Means::Nothing { relays: 3 }, when: When::ALWAYS, longest_m: None },
    wormhole([2.0, 10.0], false, When::ALWAYS),
    wormhole([2.0, 10.0], true, When::ALWAYS),
    wormhole([2.0, 10.0], true, When::ALWAYS).with_longest(9.0),
    wormhole([2.0, 10.0], true, When::STRETCHING),
    wormhole([2.0, 10.0], true, When::STANDING),
    wormhole([2.0, 20.0], true, When::ALWAYS),
    wormhole([2.0, 20.0], true, When::ALWAYS).with_longest(9.0),
    wormhole([2.0, 20.0], true, When::STRETCHING),
    wormhole([2.0, 20.0], true, When::STANDING),
    wormhole([10.0, 20.0], true, When::STRETCHING),
    wormhole([10.0, 20.0], true, When::STANDING),
];

/// The number of rows.
pub const COUNT: usize = SIEGES.len();

impl Siege {
    /// The same against drones that make no link longer than this.
    const fn with_longest(self, longest_m: f32) -> Self {
        Self { longest_m: Some(longest_m), ..self }
    }

    fn name(&self) -> String {
        let limit = self.longest_m.map(|m| format!(", `longest_m = {m}`")).unwrap_or_default();
        let when = format!("{}{limit}", self.when.name());
        match self.means {
            Means::Nothing { relays: 1 } => "none, one relay".into(),
            Means::Nothing { relays } => format!("none, {relays} relays"),
            Means::Hold { by_us } => {
                format!("jam and hold, {:.1} s, {when}", by_us as f64 * 1e-6)
            }
            Means::Wormhole { places_m: [near, far], delay_us, jams } => {
                let also = if jams { ", originals jammed" } else { "" };
                let delay = delay_us as f64 * 1e-3;
                format!("repeated after {delay:.2} ms, {near} m and {far} m{also}, {when}")
            }
        }
    }

    const fn relays(&self) -> usize {
        match self.means {
            Means::Nothing { relays } => relays,
            Means::Hold { .. } => 1,
            Means::Wormhole { .. } => 3,
        }
    }

    /// Where the attacker's radios are, m from the base: between the drones, or an ear and a mouth at
    /// either place.
    fn radios_m(&self) -> Vec<f32> {
        match self.means {
            Means::Nothing { .. } | Means::Hold { .. } => vec![7.0, 7.0],
            Means::Wormhole { places_m: [near, far], .. } => vec![near, near, far, far],
        }
    }

    /// Sends what is to be sent in the coming round.
    fn attack_for_a_round(&self, mission: &mut Mission<'_>) {
        let now_us = mission.time_us();
        let is_on = self.when.is_on(now_us);
        match self.means {
            Means::Nothing { .. } => {}
            Means::Hold { by_us } => {
                let delay_us = by_us + BESIDE_US;
                let all = [Repeater { ear: 0, mouth: 1, delay_us, jams: Jams::All }];
                mission.repeat(if is_on { &all } else { &[] });
            }
            Means::Wormhole { delay_us, jams, .. } => {
                let jams = if jams { Jams::Weaker } else { Jams::Nothing };
                let both = [(0, 3), (2, 1)];
                let both = both.map(|(ear, mouth)| Repeater { ear, mouth, delay_us, jams });
                mission.repeat(if is_on { &both } else { &[] });
            }
        }
    }
}

/// The result of one siege.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The name of the siege.
    pub siege: String,
    /// How often a drone took one of the attacker's packets, in all missions.
    pub accepted: u64,
    /// The mean error of the drones' filtered links while the attack goes on, dB.
    pub link_error_db: f32,
    /// How far a relay was from its place in the same mission without an attack, up to the call home,
    /// m: the greatest of each mission, mean and greatest of all.
    pub displaced_m: [f32; 2],
    /// For how long a drone was without a neighbour in one piece, up to the call home, s: the longest
    /// of each mission, mean and longest of all.
    pub deaf_s: [f32; 2],
    /// The true strength of the weakest link between neighbours up to the call home, dBm: mean over the
    /// missions, and the weakest of all.
    pub weakest_dbm: [f32; 2],
    /// In how many missions the chain stood at the call home with all drones at work.
    pub holds: usize,
    /// In how many missions all drones came home.
    pub home: usize,
    /// How often a drone touched a wall or another drone, in all missions.
    pub touches: u32,
    /// The number of missions.
    pub missions: usize,
}

impl Row {
    /// The result as one JSON object.
    #[must_use]
    pub fn json(&self) -> Value {
        let round = |value: f32| (f64::from(value) * 1e2).round() / 1e2;
        json!({
            "siege": self.siege,
            "accepted": self.accepted,
            "link_error_db": round(self.link_error_db),
            "displaced_m": self.displaced_m.map(round),
            "deaf_s": self.deaf_s.map(round),
            "weakest_dbm": self.weakest_dbm.map(round),
            "holds": self.holds,
            "home": self.home,
            "touches": self.touches,
            "missions": self.missions,
        })
    }
}

/// Flies every siege on `runs` missions, with seeds from `seed` on.
///
/// # Errors
/// [`InputError`] if the built-in scenario cannot be read.
pub fn run(runs: usize, seed: u64, after_each: impl Fn() + Sync) -> Result<Vec<Row>, InputError> {
    let (pair, chain) = (besieged(1)?, besieged(3)?);
    let worlds = [pair.world(), chain.world()];
    let fly_all = |siege: &Siege| -> Vec<End> {
        let is_pair = siege.relays() == 1;
        let (scenario, world) = if is_pair { (&pair, &worlds[0]) } else { (&chain, &worlds[1]) };
        let mut scenario = scenario.clone();
        if let Some(longest_m) = siege.longest_m {
            scenario.agent.retreat.longest = Metres(longest_m);
        }
        let one = |n| {
            let end = fly(&scenario, world, siege, seed.wrapping_add(n));
            after_each();
            end
        };
        (0..runs as u64).map(one).collect()
    };
    let all: Vec<_> = SIEGES.par_iter().map(|siege| (siege, fly_all(siege))).collect();
    let undisturbed = |siege: &Siege| {
        let calm = |other: &&Siege| matches!(other.means, Means::Nothing { .. });
        let at = SIEGES.iter().position(|o| calm(&o) && o.relays() == siege.relays());
        at.and_then(|at| all.get(at)).map_or(&[][..], |(_, ends)| ends)
    };
    Ok(all.iter().map(|(siege, ends)| row(siege, ends, undisturbed(siege))).collect())
}

/// The scenario with this many relays, for as long as a siege lasts.
fn besieged(relays: usize) -> Result<Scenario, InputError> {
    let changes = Changes { relays: Some(relays), ..Changes::default() };
    let mut scenario = Scenario::open_with(SCENARIO, &changes)?;
    scenario.duration_us = SPAN_US;
    if let Some(hover) = scenario.pilot.get_mut(1) {
        hover.at_us = RELEASED_US;
    }
    Ok(scenario)
}

/// How one mission ended.
struct End {
    accepted: u64,
    link_error_db: f32,
    deaf_s: f32,
    weakest_dbm: f32,
    holds: bool,
    home: bool,
    touches: u32,
    /// The ways of the relays in each round up to the call home.
    ways: Vec<f32>,
}

fn row(siege: &Siege, ends: &[End], undisturbed: &[End]) -> Row {
    let displaced = |(end, calm): (&End, &End)| {
        let ways = end.ways.iter().zip(&calm.ways);
        ways.map(|(is, was)| (is - was).abs()).fold(0.0, f32::max)
    };
    let displaced: Vec<_> = ends.iter().zip(undisturbed).map(displaced).collect();
    let both =
        |values: &[f32]| [mean(values.iter().copied()), values.iter().copied().fold(0.0, f32::max)];
    let weakest: Vec<_> = ends.iter().map(|end| end.weakest_dbm).collect();
    let deaf: Vec<_> = ends.iter().map(|end| end.deaf_s).collect();
    Row {
        siege: siege.name(),
        accepted: ends.iter().map(|end| end.accepted).sum(),
        link_error_db: mean(ends.iter().map(|end| end.link_error_db)),
        displaced_m: both(&displaced),
        deaf_s: both(&deaf),
        weakest_dbm: [mean(weakest.iter().copied()), weakest.iter().copied().fold(0.0, f32::min)],
        holds: ends.iter().filter(|end| end.holds).count(),
        home: ends.iter().filter(|end| end.home).count(),
        touches: ends.iter().map(|end| end.touches).sum(),
        missions: ends.len(),
    }
}

fn fly(scenario: &Scenario, world: &World, siege: &Siege, seed: u64) -> End {
    let places: Vec<_> = siege.radios_m().into_iter().map(SkeletonPlace::main).collect();
    let mut mission = Mission::besieged(scenario, world, seed, &places);
    let (mut deaf, mut longest) = (vec![0_u32; mission.count()], 0);
    let (mut errors, mut ways, mut chain) = (Vec::new(), Vec::new(), Vec::new());
    let (mut weakest_dbm, mut holds) = (0.0, false);
    while !mission.is_over() {
        siege.attack_for_a_round(&mut mission);
        mission.round();
        if mission.time_us() > CALLED_US {
            continue;
        }
        for (n, deaf) in deaf.iter_mut().enumerate() {
            *deaf = if misses(&mission, n) { *deaf + 1 } else { 0 };
            longest = longest.max(*deaf);
        }
        if siege.when.is_on(mission.time_us()) {
            errors.extend(link_errors(&mut mission));
        }
        weakest_dbm = weakest(&mission, &mut chain).min(weakest_dbm);
        ways.extend(mission.ways().skip(1).take(mission.count() - 2));
        holds = (0..mission.count()).all(|n| !misses(&mission, n)) && is_at_work(&mission);
    }
    End {
        accepted: mission.accepted(),
        link_error_db: mean(errors.into_iter()),
        deaf_s: longest as f32 * ROUND_US as f32 * 1e-6,
        weakest_dbm,
        holds,
        home: is_home(&mission),
        touches: mission.wall_contacts() + mission.drone_contacts() + mission.ground_contacts(),
        ways,
    }
}

/// Whether a drone is at work in the air, or the base, and is without a neighbour.
fn misses(mission: &Mission<'_>, n: usize) -> bool {
    let mut states = mission.states();
    let at_work = states.nth(n).is_some_and(|state| matches!(state, State::OnMission(_)));
    at_work && !has_neighbours(mission, n)
}

/// Whether the head leads, and every relay relays or waits on the ground.
fn is_at_work(mission: &Mission<'_>) -> bool {
    let leads = |state| matches!(state, State::OnMission(Duty::Chain(ChainDuty::Leading { .. })));
    let relays = |state| {
        let duty = match state {
            State::OnMission(Duty::Chain(duty)) => duty,
            State::Idle | State::Armed { .. } => return true,
            _ => return false,
        };
        matches!(duty, ChainDuty::Relaying { .. } | ChainDuty::Searching { .. })
    };
    let drones = mission.count() - 1;
    let mut states = mission.states().take(drones).enumerate();
    states.all(|(n, state)| if n == 0 { leads(state) } else { relays(state) })
}

/// The true strength of the weakest link of the chain as it is now.
fn weakest(mission: &Mission<'_>, chain: &mut Vec<Linked>) -> f32 {
    mission.chain(chain);
    let links = chain.windows(2).map(|ends| match ends {
        [one, other] => mission.large_scale_strength(one.id.0.into(), other.id.0.into()).0,
        _ => 0.0,
    });
    links.fold(0.0, f32::min)
}

/// Whether all drones have landed at home, or never left it.
fn is_home(mission: &Mission<'_>) -> bool {
    let drones = mission.count() - 1;
    let is_down = |state: State| match state {
        State::Idle => true,
        State::Landed { why } => {
            matches!(why, LandReason::Home | LandReason::Retired | LandReason::LinkLost)
        }
        _ => false,
    };
    let mut drones = mission.states().zip(mission.ways()).take(drones);
    drones.all(|(state, way)| is_down(state) && way <= HOME_M)
}
