//! Draws a whole scenario from a seed: its text, and what an oracle makes of it.

use std::fmt::Write;
use std::path::Path;
use world::World;

use input::InputError;
use random::{Purpose, Stream};
use units::Dbm;

use super::pilot::{self, Pilot, Stick};
use super::place::{Choice, Place, Wanted};
use super::plane::{dot, minus};
use super::radio::{DrawnRadio, Limits};
use measure::oracle::{Commanded, Detour, Oracle};
use scenario::{Fidelity, PilotStep, Scenario, Start};
use units::{Course, MetresPerSecond, Order};

/// A mission in a drawn place.
pub struct Drawn {
    /// The seed of the place, and of the mission that is flown there.
    pub seed: u64,
    /// The scenario as a file.
    pub text: String,
    /// The same, read.
    pub scenario: Scenario,
    /// The place and its radio.
    pub world: World,
    /// Where the pilot's orders lead.
    pub commanded: Commanded,
    /// What can be reached.
    pub oracle: Oracle,
}

/// What missions of a fidelity have room for.
struct Bounds {
    relays: u32,
    speeds: [f32; 2],
    /// The exploration takes no longer than that, s.
    explores_s: f32,
    holds_s: f32,
    /// The whole mission takes no longer than that, s.
    whole_s: f32,
    /// The pilot pushes on for no longer than that, s.
    pushes_s: f32,
}

impl Bounds {
    const fn of(fidelity: Fidelity) -> Self {
        match fidelity {
            Fidelity::Point => Self {
                relays: 14,
                speeds: [0.1, 0.4],
                explores_s: 700.0,
                holds_s: 60.0,
                whole_s: 1200.0,
                pushes_s: 90.0,
            },
            // A battery lasts for six minutes, of which the drones keep some to come home.
            Fidelity::Flight | Fidelity::Virtual => Self {
                relays: 6,
                speeds: [0.2, 0.4],
                explores_s: 200.0,
                holds_s: 40.0,
                whole_s: 360.0,
                pushes_s: 15.0,
            },
        }
    }
}

impl Bounds {
    /// The length of a gallery at whose end the head can be, and come home from, in the time that
    /// there is, m.
    fn longest_m(&self, pilot: &Pilot, relays: usize) -> f32 {
        let rest = self.whole_s - self.holds_s - home_s(0.0, relays) - pilot.ends(0.0, 0.0);
        let each = pilot.ends(0.0, 1.0 / pilot.pace()) - pilot.ends(0.0, 0.0);
        (rest / (each + home_s(1.0, 0) - home_s(0.0, 0))).max(9.0)
    }
}

/// The time that a chain is given to come home from this depth, s.
fn home_s(depth_m: f32, relays: usize) -> f32 {
    1.6 * depth_m / RETURNS_MPS + 40.0 + 6.0 * relays as f32
}

/// The speed of the way home, m/s (`FlightConfig::DEFAULT`).
const RETURNS_MPS: f32 = 0.2;
/// The oracle's head must get farther than its row by so much, or there is no mission, m.
const LEAST_DEPTH_M: f32 = 4.0;
/// And farther than a fork whose dead end the pilot looks into, as far as the pilot looks, m.
const BEHIND_FORK_M: f32 = 3.0;
/// How often a place is drawn again that does not fit.
const TRIES: usize = 400;

/// A place, its radio and its pilot, as numbers.
struct Drawing {
    seed: u64,
    fidelity: Fidelity,
    relays: usize,
    place: Place,
    radio: DrawnRadio,
    limits: Limits,
    pilot: Pilot,
    sticks: Vec<Stick>,
    holds_s: f32,
    returns_s: f32,
    duration_s: f32,
}

impl Drawn {
    /// The mission of a seed.
    ///
    /// # Errors
    /// [`InputError`] where the drawing makes a scenario that cannot be read, which is a defect.
    pub fn of(seed: u64, fidelity: Fidelity) -> Result<Self, InputError> {
        let mut random = Stream::new(seed, Purpose::Drawn);
        for _ in 0..TRIES {
            if let Some(drawn) = Self::once(&mut random, seed, fidelity)? {
                return Ok(drawn);
            }
        }
        Err(InputError::new(format!("no place fits seed {seed}"), "give another seed"))
    }

    fn once(
        random: &mut Stream,
        seed: u64,
        fidelity: Fidelity,
    ) -> Result<Option<Self>, InputError> {
        let bounds = Bounds::of(fidelity);
        let Some(mut drawing) = Drawing::draw(random, seed, fidelity, &bounds) else {
            return Ok(None);
        };
        let Ok(mut scenario) = drawing.read() else { return Ok(None) };
        let world = scenario.world();
        let mut commanded = Commanded::along_main(&world);
        drawing.commands(&mut commanded);
        let corners = drawing.corners();
        let limits = Limits::draw(random, &scenario, &world, &commanded, &corners, seed);
        // A dead end that the pilot looks into is within the chain's reach.
        let looks = commanded.detour.map_or(0.0, |detour| detour.at_m + BEHIND_FORK_M);
        let least = (drawing.row_m() + LEAST_DEPTH_M).max(looks);
        // An operator lowers a limit with which the head could hardly fly.
        let found = (0..6).find_map(|n| {
            drawing.limits = limits.lowered(3.0 * n as f32);
            drawing.apply(&mut scenario, &bounds);
            let oracle = Oracle::of(&scenario, &world, &commanded, seed);
            (oracle.depth_m >= least).then_some(oracle)
        });
        let Some(widest) = found else { return Ok(None) };
        if !drawing.settle(&bounds, &widest, &commanded) {
            return Ok(None);
        }
        let text = drawing.text();
        let scenario = drawing.read()?;
        let oracle = Oracle::of(&scenario, &world, &commanded, seed);
        Ok(Some(Self { seed, text, scenario, world, commanded, oracle }))
    }
}

impl Drawing {
    fn draw(random: &mut Stream, seed: u64, fidelity: Fidelity, bounds: &Bounds) -> Option<Self> {
        let radio = DrawnRadio::draw(random, seed);
        let share = random.uniform();
        let relays = 1 + (share * share * bounds.relays as f32) as usize;
        let pilot = Pilot::draw(random, bounds.speeds, bounds.pushes_s);
        let row_m = Start::SPACING * (relays + 1) as f32;
        let longest_m = bounds.longest_m(&pilot, relays);
        let rock_m = if radio.is_leaky { 0.4 } else { 1.0 };
        let place = Place::draw(random, &Wanted { row_m, longest_m, rock_m })?;
        let branch = place.choice.leading();
        let (mut sticks, begins) = pilot.detour(&place, row_m);
        let holds_s = begins.max(pilot::BEGINS_S) + bounds.explores_s;
        sticks.extend(pilot.sticks(branch, begins, holds_s));
        let returns_s = holds_s + bounds.holds_s;
        Some(Self {
            seed,
            fidelity,
            relays,
            place,
            radio,
            limits: Limits::PROVISIONAL,
            pilot,
            sticks,
            holds_s,
            returns_s,
            duration_s: returns_s + 1.0,
        })
    }

    fn row_m(&self) -> f32 {
        Start::SPACING * (self.relays + 1) as f32
    }

    /// Where the main gallery's bends are, m along it.
    fn corners(&self) -> Vec<f32> {
        /// A point at which only the width changes is none: the cosine of 10 degrees.
        const STRAIGHT: f32 = 0.985;
        let mut along = 0.0;
        let bends = self.place.main.windows(3).filter_map(|points| {
            let [before, behind] = [0, 1].map(|n| minus(points[n + 1].0, points[n].0));
            let lengths = [before, behind].map(|piece| dot(piece, piece).sqrt());
            along += lengths[0];
            (dot(before, behind) < STRAIGHT * lengths[0] * lengths[1]).then_some(along)
        });
        bends.collect()
    }

    /// Notes the dead end that the pilot looks into first.
    fn commands(&self, commanded: &mut Commanded) {
        if let (Choice::Changed { .. }, Some(end)) =
            (self.place.choice, self.place.dead_ends.first())
        {
            let (_, until) = self.pilot.detour(&self.place, self.row_m());
            commanded.detour = Some(Detour {
                at_m: self.place.first_bend_m,
                length_m: end.length(),
                until_us: (f64::from(until) * 1e6) as u64,
            });
        }
    }

    /// Takes the limits and the pilot as they now are into a scenario that was read before.
    fn apply(&self, scenario: &mut Scenario, bounds: &Bounds) {
        scenario.agent = scenario
            .agent
            .with_limits(Some(Dbm(self.limits.launch)), Some(Dbm(self.limits.retreat)));
        let us = |s: f32| (f64::from(s) * 1e6) as u64;
        let explore = |stick: &Stick| PilotStep {
            at_us: us(stick.at_s),
            task: Order::Explore(Course {
                speed: MetresPerSecond(stick.speed),
                branch: stick.branch,
            }),
        };
        scenario.pilot = self.sticks.iter().map(explore).collect();
        scenario.duration_us = us(self.holds_s.max(bounds.explores_s));
    }

    /// Gives the mission the time that is allowed a chain for what the oracle's does; says whether
    /// there is so much.
    fn settle(&mut self, bounds: &Bounds, oracle: &Oracle, commanded: &Commanded) -> bool {
        let begins = pilot::BEGINS_S;
        let until = commanded.detour.map_or(begins, |detour| detour.until_us as f32 * 1e-6);
        let home_s = home_s(oracle.depth_m, self.relays);
        self.holds_s = self.pilot.ends(begins, oracle.at_s).max(until + 20.0);
        let (mut sticks, from) = self.pilot.detour(&self.place, self.row_m());
        sticks.extend(self.pilot.sticks(self.place.choice.leading(), from, self.holds_s));
        self.sticks = sticks;
        self.returns_s = self.holds_s + bounds.holds_s;
        self.duration_s = self.returns_s + home_s;
        self.duration_s <= bounds.whole_s
    }

    fn read(&self) -> Result<Scenario, InputError> {
        let name = format!("drawn-{}.toml", self.seed);
        Scenario::of_text(Path::new(&name), &self.text())
    }

    /// The scenario's file.
    fn text(&self) -> String {
        let Self { seed, relays, limits, .. } = self;
        let level = self.fidelity.name();
        let mut text = format!(
            "# A drawn place: `uchain run drawn-{seed}.toml --seed {seed}` flies what\n\
             # `uchain bench chain --drawn 1 --seed {seed} --fidelity {level}` flies.\n\
             title = \"drawn place {seed}\"\nduration_s = {:.0}\nfidelity = \"{level}\"\n\n",
            self.duration_s.ceil()
        );
        self.put_tunnel(&mut text);
        text.push_str(&self.radio.text(limits));
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n[vehicle]\nflow_noise_mps = {:.3}\nflow_scale_error = {:.3}\n\
             \n[drones]\nrelays = {relays}\n\
             \n[launch]\nlimit_dbm = {:.1}\n\n[retreat]\nlimit_dbm = {:.1}\n",
            self.radio.flow_noise, self.radio.odometer, limits.launch, limits.retreat
        );
        text.push_str(&pilot::text(&self.sticks, self.holds_s, self.returns_s));
        text
    }

    fn put_tunnel(&self, text: &mut String) {
        let list = |numbers: Vec<String>| format!("[{}]", numbers.join(", "));
        let point = |[x, y]: [f32; 2]| format!("[{x:.2}, {y:.2}]");
        let main = &self.place.main;
        let widths = list(main.iter().map(|(_, width)| format!("{width:.2}")).collect());
        let line = list(main.iter().map(|(at, _)| point(*at)).collect());
        // Writing to a string cannot fail.
        let _ = write!(text, "[tunnel]\nwidths_m = {widths}\ncentre_line_m = {line}\n\n");
        for end in &self.place.dead_ends {
            let [a, b] = end.line.map(point);
            let width = end.width;
            let _ = write!(
                text,
                "[[tunnel.branch]]\nwidth_m = {width:.2}\ncentre_line_m = [{a}, {b}]\n\n"
            );
        }
        for hall in &self.place.halls {
            let (centre, size) = (point(hall.centre), point(hall.size));
            let _ = write!(text, "[[tunnel.room]]\ncentre_m = {centre}\nsize_m = {size}\n\n");
        }
    }
}

#[cfg(test)]
mod tests;
