//! Computes what the chain's policies would have commanded in a recorded flight.
//!
//! The authors' logs hold strengths that were filtered on board, and no velocity, so they cannot
//! test the filter; but each row has the inputs of a relay's movement policy and of the launch
//! policy.

use chain::launch::LaunchConfig;
use chain::policy::{LinkEnd, Policy, PolicyConfig};
use onboard::replay::LaunchRule;
use serde::Serialize;
use units::{Db, Dbm, MetresPerSecond};

use recordings::recording::{LOST_AFTER, Recording, Sample};

/// The commands of one policy to one relay.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Commands {
    /// The name of the policy.
    pub policy: &'static str,
    /// The relay; 1 is next to the head.
    pub relay: usize,
    /// The number of rows in which the relay had both of its links.
    pub rows: usize,
    /// The part of these rows in which the relay is flown towards the head.
    pub forward: f64,
    /// The part of the rows in which the relay hovers.
    pub hover: f64,
    /// The part of the rows in which the relay is flown towards the base.
    pub back: f64,
    /// The mean speed, without its sign.
    pub mean_speed_mps: f64,
    /// The number of times that the direction of flight reversed, without counting hovering.
    pub sign_changes: usize,
    /// The part of the rows in which it flies the same way as the authors' rule, hovering included.
    pub agrees_with_authors: f64,
}

/// Measures of how equal the links of a flight were.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equality {
    /// The mean strength of each link, head first, in dBm; `None` for one that was never heard.
    pub means_dbm: Vec<Option<f64>>,
    /// The number of pairs of adjacent links in all rows.
    pub pairs: usize,
    /// The part of the pairs that differ by 3 dB or less.
    pub within_3_db: f64,
    /// The part of the pairs that differ by 5 dB or less.
    pub within_5_db: f64,
}

/// The analysis of one flight.
pub(super) struct Flight {
    /// One for each policy and relay.
    pub(super) commands: Vec<Commands>,
    /// When the on-board launch policy would have called for a relay, in the log's seconds.
    pub(super) launches: Vec<f64>,
    /// The launches by the rule of the paper's experiments: at once, on the last link alone.
    pub(super) launches_at_once: Vec<f64>,
    pub(super) equality: Equality,
}

/// The links of one row, head first, those that have a value.
struct Row<'a> {
    samples: &'a [Sample],
}

impl Row<'_> {
    fn link(&self, link: usize) -> Option<Dbm> {
        self.samples.iter().find(|sample| sample.link == link).map(|sample| sample.rssi)
    }

    fn pair(&self, front: usize) -> Option<(Dbm, Dbm)> {
        Some((self.link(front)?, self.link(front + 1)?))
    }
}

fn rows(recording: &Recording) -> impl Iterator<Item = Row<'_>> {
    recording.samples.chunk_by(|a, b| a.line == b.line).map(|samples| Row { samples })
}

/// Runs the policies over a flight.
pub(super) fn analyse(recording: &Recording, policies: &[&'static Policy]) -> Flight {
    let relays = 1..recording.links.len();
    Flight {
        commands: policies
            .iter()
            .flat_map(|policy| relays.clone().map(|relay| commands(recording, policy, relay)))
            .collect(),
        launches: launches(recording, &LaunchConfig::WHEN_SETTLED),
        launches_at_once: launches(recording, &LaunchConfig::AT_ONCE),
        equality: equality(recording),
    }
}

/// −1 back, 0 hover, 1 forward.
fn direction(velocity: MetresPerSecond) -> i8 {
    i8::from(velocity > MetresPerSecond::ZERO) - i8::from(velocity < MetresPerSecond::ZERO)
}

fn commands(recording: &Recording, policy: &'static Policy, relay: usize) -> Commands {
    let (mut counts, mut agreed, mut speed, mut turns) = ([0usize; 3], 0, 0.0, 0);
    let mut heading = 0;
    for (front, back) in rows(recording).filter_map(|row| row.pair(relay - 1)) {
        let velocity = policy.config.velocity(LinkEnd::still(front), LinkEnd::still(back));
        let way = direction(velocity);
        if let Some(count) = counts.get_mut((way + 1) as usize) {
            *count += 1;
        }
        agreed += usize::from(
            way == direction(
                PolicyConfig::AUTHORS.velocity(LinkEnd::still(front), LinkEnd::still(back)),
            ),
        );
        speed += f64::from(velocity.abs().0);
        turns += usize::from(way * heading < 0);
        heading = if way == 0 { heading } else { way };
    }
    let rows = counts.iter().sum();
    let [back, hover, forward] = counts.map(|count| part(count, rows));
    Commands {
        policy: policy.name,
        relay,
        rows,
        forward,
        hover,
        back,
        mean_speed_mps: if rows == 0 { 0.0 } else { speed / rows as f64 },
        sign_changes: turns,
        agrees_with_authors: part(agreed, rows),
    }
}

fn part(count: usize, of: usize) -> f64 {
    if of == 0 { 0.0 } else { count as f64 / of as f64 }
}

/// When the launch policy, watching from the base, begins to call for a relay.
fn launches(recording: &Recording, config: &LaunchConfig) -> Vec<f64> {
    let mut rule = LaunchRule::new(recording.links.len());
    let mut launches = Vec::new();
    for row in rows(recording) {
        let Some(now) = row.samples.first().map(|sample| sample.time) else { continue };
        let strengths = row.samples.iter().map(|sample| (sample.link, sample.rssi));
        if rule.step(now, config, LOST_AFTER, strengths) {
            launches.push(now.as_micros() as f64 / 1e6);
        }
    }
    launches
}

fn equality(recording: &Recording) -> Equality {
    let links = recording.links.len();
    let mean = |link: usize| {
        let of_link = || recording.samples.iter().filter(|sample| sample.link == link);
        let sum: f64 = of_link().map(|sample| f64::from(sample.rssi.0)).sum();
        let count = of_link().count();
        (count > 0).then(|| sum / count as f64)
    };
    let differences: Vec<Db> = rows(recording)
        .flat_map(|row| (1..links).filter_map(move |relay| row.pair(relay - 1)))
        .map(|(front, back)| (front - back).abs())
        .collect();
    let within = |most: f32| {
        part(
            differences.iter().filter(|difference| difference.0 <= most).count(),
            differences.len(),
        )
    };
    Equality {
        means_dbm: (0..links).map(mean).collect(),
        pairs: differences.len(),
        within_3_db: within(3.0),
        within_5_db: within(5.0),
    }
}

#[cfg(test)]
mod tests {
    use units::Instant;

    use super::*;

    /// Two links, one row every half second.
    fn flight(rows: &[[f32; 2]]) -> Recording {
        let sample = |row: usize, link: usize, rssi: f32| Sample {
            line: row + 1,
            time: Instant::from_millis(500 * row as u64),
            link,
            rssi: Dbm(rssi),
            ends: None,
            separating: None,
            restarts: row == 0,
        };
        let samples = rows
            .iter()
            .enumerate()
            .flat_map(|(row, [front, back])| [sample(row, 0, *front), sample(row, 1, *back)])
            .collect();
        let links = vec!["r0".into(), "r1".into()];
        Recording { rows: rows.len(), links, samples, ..Recording::default() }
    }

    #[test]
    fn a_relay_flies_towards_its_weaker_link() {
        let recording = flight(&[[-60.0, -50.0], [-55.0, -55.0], [-50.0, -60.0], [-60.0, -50.0]]);
        let commands = commands(&recording, Policy::named("authors").unwrap(), 1);
        assert_eq!((commands.forward, commands.hover, commands.back), (0.5, 0.25, 0.25));
        assert_eq!((commands.sign_changes, commands.agrees_with_authors), (2, 1.0));
        assert!((commands.mean_speed_mps - 0.225).abs() < 1e-6);
    }

    #[test]
    fn a_call_for_a_relay_counts_once_until_the_link_is_well_again() {
        let (well, weak) = ([-61.0, -55.0], [-61.0, -62.0]);
        let rows = [well, weak, weak, weak, weak, weak, weak, well, weak];
        assert_eq!(launches(&flight(&rows), &LaunchConfig::AT_ONCE), [0.5, 4.0]);
        // Weak and equal since 0.5 s, for 2 s.
        assert_eq!(launches(&flight(&rows), &LaunchConfig::WHEN_SETTLED), [2.5]);
    }

    #[test]
    fn equality_is_over_pairs_of_adjacent_links() {
        let equality = equality(&flight(&[[-60.0, -57.0], [-60.0, -55.0], [-60.0, -50.0]]));
        assert_eq!(equality.means_dbm, [Some(-60.0), Some(-54.0)]);
        assert_eq!(equality.pairs, 3);
        assert_eq!((equality.within_3_db, equality.within_5_db), (1.0 / 3.0, 2.0 / 3.0));
    }
}
