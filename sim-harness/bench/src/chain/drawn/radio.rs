//! Draws a radio: a law of the path loss with its constants, what packets suffer, and the limits that an
//! operator would choose with it.

use std::fmt::Write;

use radio_model::{Geometry, Obstruction};
use random::Stream;
use units::{Db, Dbm, Metres};
use world::{Known, World};

use super::place::between;
use measure::oracle::Commanded;
use mission::Gains;
use scenario::Scenario;

/// A radio that was drawn.
#[derive(Clone, Debug)]
pub(super) struct DrawnRadio {
    /// The keys of the table `[radio]`.
    keys: String,
    /// The tables below it.
    tables: String,
    /// Whether waves go through walls, so that thin rock is of interest.
    pub(super) is_leaky: bool,
    /// The standard deviation of the drones' odometers' scales.
    pub(super) odometer: f32,
    /// The noise of the optic flow, m/s.
    pub(super) flow_noise: f32,
}

/// A law for the path loss, as keys of `[radio]` and as the table `[radio.model]`.
fn law(random: &mut Stream) -> (&'static str, String) {
    let corner = between(random, 6.0, 20.0);
    match random.uniform() {
        u if u < 0.35 => ("attenuation = \"rock-depth\"\n", String::new()),
        u if u < 0.60 => ("attenuation = \"wall-count\"\n", String::new()),
        u if u < 0.77 => {
            let exponent = between(random, 1.8, 3.2);
            let law = format!(
                "law = \"log-distance\"\nexponent = {exponent:.2}\ncorner_db = {corner:.1}\n"
            );
            ("", law)
        }
        u if u < 0.87 => {
            let (width, height) = (between(random, 1.5, 3.0), between(random, 1.5, 3.0));
            let second = between(random, 0.0, 0.6);
            let size = format!("width_m = {width:.1}\nheight_m = {height:.1}\n");
            let law = format!(
                "law = \"waveguide\"\n{size}second_mode = {second:.2}\ncorner_db = {corner:.1}\n"
            );
            ("", law)
        }
        u if u < 0.96 => {
            let exponent = between(random, 1.5, 3.0);
            ("", format!("law = \"subt\"\nexponent = {exponent:.2}\n"))
        }
        _ => ("walls = \"leaky\"\n", String::new()),
    }
}

impl DrawnRadio {
    pub(super) fn draw(random: &mut Stream, place_seed: u64) -> Self {
        let (law_keys, model) = law(random);
        let is_leaky = law_keys.contains("leaky");
        let mut keys = law_keys.to_owned();
        let mut tables = String::new();
        let first_metre = between(random, 35.0, 45.0);
        let noise = between(random, 1.0, 20.0);
        let loss = between(random, 0.0, 0.4);
        // Writing to a string cannot fail.
        let _ = write!(
            keys,
            "loss_at_1m_db = {first_metre:.1}\nnoise_variance_db2 = {noise:.1}\n\
             packet_loss = {loss:.2}\n"
        );
        if random.uniform() < 0.5 {
            let _ = writeln!(keys, "gain_error_db = {:.1}", between(random, 0.2, 2.0));
        }
        if !model.is_empty() {
            let _ = write!(tables, "\n[radio.model]\n{model}");
        }
        // A third has fades or shadows.
        match random.uniform() {
            u if u < 0.11 => {
                let (share, mean) = (between(random, 0.02, 0.15), between(random, 0.3, 3.0));
                let _ = writeln!(keys, "fade_share = {share:.2}\nfade_s = {mean:.1}");
            }
            u if u < 0.22 => {
                let (deviation, far) = (between(random, 1.0, 3.0), between(random, 3.0, 10.0));
                let table = "\n[radio.shadowing]\n";
                let _ = write!(
                    tables,
                    "{table}deviation_db = {deviation:.1}\ndecorrelation_m = {far:.1}\n"
                );
            }
            u if u < 0.33 => {
                let k = between(random, 4.0, 12.0);
                let _ = write!(tables, "\n[radio.fading]\nrician_k = {k:.1}\n");
            }
            _ => {}
        }
        if !tables.is_empty() {
            let _ = writeln!(keys, "place_seed = {}", place_seed % 1_000_000_000);
        }
        let odometer = between(random, 0.0, 0.05);
        let flow_noise = between(random, 0.01, 0.04);
        Self { keys, tables, is_leaky, odometer, flow_noise }
    }

    /// The table `[radio]` and those below it.
    pub(super) fn text(&self, limits: &Limits) -> String {
        let Self { keys, tables, .. } = self;
        format!("[radio]\n{keys}sensitivity_dbm = {:.1}\n{tables}", limits.sensitivity)
    }
}

/// The limits of links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    pub(super) launch: f32,
    pub(super) retreat: f32,
    pub(super) sensitivity: f32,
}

impl Limits {
    /// Limits by which the first text of a place can be read.
    pub(super) const PROVISIONAL: Self =
        Self { launch: -60.0, retreat: -65.0, sensitivity: -100.0 };

    fn of(launch: f32, below: f32) -> Self {
        let launch = (2.0 * launch).floor() / 2.0;
        let retreat = launch - (2.0 * below).round() / 2.0;
        Self { launch, retreat, sensitivity: (retreat - 10.0).min(-85.0) }
    }

    /// The same with a launch limit that is lower by so much.
    pub(super) fn lowered(&self, by: f32) -> Self {
        Self::of(self.launch - by, self.launch - self.retreat)
    }

    /// Draws what an operator would choose in a place: a link reaches 5 to 15 m along a straight leg,
    /// or round a bend and some metres to either side of it; and the head, where it stands before
    /// it takes off, has a link to the base that is 3 dB better.
    pub(super) fn draw(
        random: &mut Stream,
        scenario: &Scenario,
        world: &World,
        commanded: &Commanded,
        corners: &[f32],
        seed: u64,
    ) -> Self {
        let law = scenario.radio.place.path_loss;
        let straight = |reach: f32| {
            let loss = law.loss(Geometry::in_sight(Metres(reach)), law.term(Obstruction::NONE));
            Dbm::after_loss(loss)
        };
        let below = between(random, 4.0, 10.0);
        let reach = between(random, 5.0, 15.0);
        let (back, ahead) = (between(random, 1.0, 5.0), between(random, 1.0, 4.0));
        let at = |way: f32| commanded.way.at(way.clamp(0.0, commanded.way.length()));
        let link = |a: f32, b: f32| world.radio.known_strength(at(a), at(b), Known::Shadows);
        let corner = random.below(corners.len().max(1) as u32) as usize;
        let limit = match corners.get(corner) {
            Some(&corner) if random.uniform() < 0.5 => {
                // A link that reaches farther than 30 m in sight has no need of relays.
                let round = link(corner - back, corner + ahead).0;
                round.min(straight(5.0).0).max(straight(30.0).0)
            }
            _ => straight(reach).0,
        };
        let flying = scenario.drones.flying();
        let gains = Gains::of(&scenario.radio, flying + 1, seed);
        let row = scenario.drones.row_m();
        let before_launch = link(0.0, row) + gains.of_link(flying, 0) - Db(3.0);
        Self::of(limit.min(before_launch.0), below)
    }
}
