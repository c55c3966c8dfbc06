//! Flies one survey of the paper's area.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use units::{Metres, Point2};
use virtual_forces::{Config, Heard, Survey, direction, guarded};

/// The paper's first area (section 6.2): 9 m along x, 7.5 m along y.
const AREA: (Metres, Metres) = (Metres(9.0), Metres(7.5));
/// The shortest and the longest way of a drone in one round (section 6.2 of the paper).
const STEP: (f32, f32) = (0.05, 0.10);
/// Rounds after which a survey counts as stuck: eight times the paper's 1210 for one drone.
const PATIENCE: u32 = 10_000;

/// What one survey came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// The rounds until the last drone reached its last goal, or nothing when the swarm got stuck.
    pub rounds: Option<u32>,
    /// The least distance between two drones at the end of any round; infinite for one drone.
    pub closest: Metres,
    /// The links that were lost, each time that one was.
    pub links_lost: u32,
}

struct Drone {
    position: Point2,
    reached: u16,
    underway: bool,
}

/// Flies a survey with `drones` drones, each of which starts at its first goal. The same `seed`
/// gives the same flight.
#[must_use]
pub fn survey(config: &Config, drones: u16, seed: u64) -> Outcome {
    let plan = Survey::new(config, AREA.0, AREA.1);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut swarm: Vec<Drone> = (0..drones)
        .filter_map(|place| plan.goal(place, drones, 0))
        .map(|position| Drone { position, reached: 1, underway: false })
        .collect();
    let mut outcome = Outcome { rounds: None, closest: Metres(f32::INFINITY), links_lost: 0 };
    let mut links = links_of(config, &swarm);
    for round in 0..PATIENCE {
        if (0..drones).zip(&swarm).all(|(place, d)| plan.goal(place, drones, d.reached).is_none()) {
            outcome.rounds = Some(round);
            break;
        }
        for place in 0..swarm.len() {
            fly(config, &plan, &mut swarm, place, &mut random);
        }
        let now = links_of(config, &swarm);
        outcome.links_lost +=
            links.iter().zip(&now).map(|(was, is)| (was & !is).count_ones()).sum::<u32>();
        outcome.closest = Metres(outcome.closest.0.min(closest(&swarm)));
        links = now;
    }
    outcome
}

/// Moves the drone at `place` by one round.
fn fly(config: &Config, plan: &Survey, swarm: &mut [Drone], place: usize, random: &mut ChaCha8Rng) {
    let uniform = random.next_u32() as f32 / u32::MAX as f32;
    let Some(goal) = plan.goal(place as u16, swarm.len() as u16, swarm[place].reached) else {
        return;
    };
    let heard = hearing(config, swarm, place);
    let drones = swarm.len() as u16;
    let me = &mut swarm[place];
    me.underway =
        me.underway || Survey::may_start(config.wait, drones, me.reached, heard.iter().copied());
    let Some(way) =
        direction(config, me.position, goal, heard.iter().copied()).filter(|_| me.underway)
    else {
        return;
    };
    let step = (STEP.0 + uniform * (STEP.1 - STEP.0)).min(me.position.distance(goal).0);
    let step = guarded(config, me.position, way, Metres(step), heard).0;
    me.position.x += step * way.x;
    me.position.y += step * way.y;
    if me.position.distance(goal) <= config.tolerance {
        me.reached += 1;
        me.underway = false;
    }
}

/// Returns what the drone at `place` hears of the others: what drones in reach pass on, over any
/// number of hops.
fn hearing(config: &Config, swarm: &[Drone], place: usize) -> Vec<Heard> {
    let mut hops: Vec<Option<u16>> = vec![None; swarm.len()];
    hops[place] = Some(0);
    let mut queue = vec![place];
    let mut next = 0;
    let mut heard = Vec::with_capacity(swarm.len());
    while let Some(&by) = queue.get(next) {
        next += 1;
        for (other, Drone { position, reached, .. }) in swarm.iter().enumerate() {
            let linked = position.distance(swarm[by].position) <= config.radio_range;
            if let (true, None, Some(way)) = (linked, hops[other], hops[by]) {
                hops[other] = Some(way + 1);
                queue.push(other);
                heard.push(Heard { position: *position, hops: way + 1, reached: *reached });
            }
        }
    }
    heard
}

/// Returns for each drone the later ones in radio range, as a bit each; there are at most 64.
fn links_of(config: &Config, swarm: &[Drone]) -> Vec<u64> {
    let in_range = |a: &Drone, b: &Drone| a.position.distance(b.position) <= config.radio_range;
    (0..swarm.len())
        .map(|a| {
            (a + 1..swarm.len().min(64))
                .filter(|&b| in_range(&swarm[a], &swarm[b]))
                .fold(0, |bits, b| bits | 1 << b)
        })
        .collect()
}

fn closest(swarm: &[Drone]) -> f32 {
    let mut least = f32::INFINITY;
    for (index, one) in swarm.iter().enumerate() {
        for other in &swarm[index + 1..] {
            least = least.min(one.position.distance(other.position).0);
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same rule in JBotSim, an independent simulator: mean rounds with 1 to 6 drones.
    const JBOTSIM: [f32; 6] = [1187.0, 652.0, 463.0, 362.0, 352.0, 249.0];

    #[test]
    fn the_literal_rule_takes_as_long_as_on_jbotsim() {
        for (drones, expected) in (1..).zip(JBOTSIM) {
            let rounds: u32 = (200_000..200_060)
                .map(|seed| survey(&Config::PAPER, drones, seed).rounds.expect("no livelock"))
                .sum();
            let mean = rounds as f32 / 60.0;
            println!("{drones}: {mean}");
            assert!((mean / expected - 1.0).abs() < 0.02, "{drones} drones: {mean} rounds");
        }
    }

    #[test]
    fn a_team_that_waits_keeps_its_clearance() {
        for drones in 2..=6 {
            for seed in 200_000..200_060 {
                let outcome = survey(&Config::BARRIER, drones, seed);
                assert!(outcome.rounds.is_some(), "{drones} drones are stuck at seed {seed}");
                // 1.3 safety distances, which the paper claims (section 6.3.1).
                assert!(outcome.closest.0 >= 1.3 * 0.30, "{drones} drones, {seed}: {outcome:?}");
            }
        }
    }

    #[test]
    fn the_same_seed_flies_the_same_survey() {
        assert_eq!(survey(&Config::PAPER, 6, 7), survey(&Config::PAPER, 6, 7));
    }
}
