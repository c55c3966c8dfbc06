//! Every state in every situation: what the drone does next, as a golden table.
//!
//! Each cell is one step of a fresh agent that was brought into the column's state and then met
//! the row's situation, 2.2 s after its last step unless the row says otherwise: longer than a
//! neighbour that is not heard then counts as there.
//!
//! `golden/transitions.txt` is written anew by `REMINT=1 cargo test -p agent --test agent`; only
//! where the machine was meant to change, with the reason in the commit.

use std::fmt::Write;
use units::{Order, Phase, Role};

use agent::{Fitness, LandReason, State};
use flight::Cause;

use super::rig::{BASE, EXPLORE, Rig, Scene};

/// The states and how one gets there.
const STATES: [&str; 14] = [
    "idle",
    "armed",
    "taking-off",
    "leading",
    "relaying",
    "reconnecting",
    "backing-up",
    "homing",
    "landing",
    "landed",
    "siting",
    "perched",
    "rising",
    "stopped",
];

/// A drone in the state of that name, with the scene that it is in; `None` where its role never
/// gets there.
fn in_state(role: Role, name: &str) -> Option<(Rig, Scene)> {
    let ground = Scene::quiet().order(EXPLORE);
    let air = ground.clone().at_height(Some(0.3));
    let reached = match (role, name) {
        (_, "idle") => {
            let mut rig = Rig::new(role);
            rig.step(&Scene::quiet());
            (rig, Scene::quiet())
        }
        (Role::Base, "stopped") => {
            let mut rig = Rig::new(role);
            rig.step(&ground.clone().order(Order::Stop));
            (rig, ground)
        }
        (Role::Base, _) => return None,
        (_, "armed") => {
            let mut rig = Rig::new(role);
            rig.until("armed", &ground);
            if role == Role::Relay {
                rig.during(3.0, &ground);
            }
            (rig, ground)
        }
        (_, "taking-off") => {
            let mut rig = Rig::new(role);
            rig.until("taking-off", &ground.clone().link(0, -62.0).link(BASE, -50.0));
            (rig, air)
        }
        (Role::Head, "leading") | (Role::Relay, "relaying") => (Rig::on_duty(role), air),
        (Role::Relay, "reconnecting") => {
            let alone = air.without(0);
            let mut rig = Rig::on_duty(role);
            rig.until(name, &alone);
            (rig, alone)
        }
        (_, "backing-up") => {
            let weak = air.link(BASE, -70.0).link(0, -60.0);
            let mut rig = Rig::on_duty(role);
            rig.until(name, &weak);
            (rig, weak)
        }
        (_, "homing") => {
            let called = air.order(Order::Return);
            let mut rig = Rig::on_duty(role);
            rig.until(name, &called);
            (rig, called)
        }
        (_, "landing") => {
            let mut rig = Rig::on_duty(role);
            rig.until(name, &air.clone().order(Order::Land));
            (rig, air.order(Order::Land))
        }
        (_, "landed") => {
            let down = ground.order(Order::Land);
            let mut rig = Rig::on_duty(role);
            rig.until(name, &down);
            (rig, down)
        }
        (_, "siting") => {
            let down = air.order(Order::Perch);
            let mut rig = Rig::on_duty(role);
            rig.until(name, &down);
            (rig, down)
        }
        (_, "perched") => {
            let down = ground.order(Order::Perch);
            let mut rig = Rig::on_duty(role);
            rig.until(name, &down);
            (rig, down)
        }
        (_, "rising") => {
            let mut rig = Rig::on_duty(role);
            rig.until("perched", &ground.clone().order(Order::Perch));
            rig.until(name, &ground.order(EXPLORE));
            (rig, air)
        }
        (_, "stopped") => {
            let mut rig = Rig::on_duty(role);
            rig.until(name, &air.order(Order::Stop));
            (rig, ground)
        }
        _ => return None,
    };
    Some(reached)
}

/// The situations: a name, how long after the last step, and what becomes of the scene.
type Situation = (&'static str, u64, fn(Scene) -> Scene);

const SITUATIONS: [Situation; 30] = [
    ("nothing new", 2_200, |s| s),
    ("order: wait", 2_200, |s| s.order(Order::Wait)),
    ("order: explore", 2_200, |s| s.order(EXPLORE)),
    ("order: return, away", 2_200, |s| s.order(Order::Return).link(BASE, -52.0)),
    ("order: return, base as at home", 2_200, |s| s.order(Order::Return).link(BASE, -38.0)),
    ("order: land", 2_200, |s| s.order(Order::Land)),
    ("order: stop", 2_200, |s| s.order(Order::Stop)),
    ("order: perch", 2_200, |s| s.order(Order::Perch)),
    ("order: perch, links too weak", 2_200, |s| s.order(Order::Perch).link(BASE, -66.0)),
    ("both links good", 2_200, |s| good(s)),
    ("front weak", 2_200, |s| good(s).link(0, -62.0)),
    ("front lost", 2_200, |s| good(s).without(0)),
    ("back weak", 2_200, |s| good(s).link(BASE, -70.0)),
    ("back weak, front weaker", 2_200, |s| good(s).link(BASE, -70.0).link(0, -75.0)),
    ("back lost", 2_200, |s| good(s).without(BASE)),
    ("nobody heard", 2_200, |s| s.without(0).without(BASE)),
    ("number 1 waits", 2_200, |s| s.also(1, Phase::Waiting, -50.0)),
    ("number 1 climbs, front weak", 2_200, |s| {
        good(s).link(0, -62.0).also(1, Phase::Transit, -50.0)
    }),
    ("ground under the legs", 2_200, |s| s.at_height(Some(0.03))),
    ("height not measured", 2_200, |s| s.at_height(None)),
    ("12 s later", 12_000, |s| s),
    ("12 s later, height not measured", 12_000, |s| s.at_height(None)),
    ("not fit to take off", 2_200, |s| s.fitness(Fitness::Unfit)),
    ("brought down", 2_200, |s| s.fitness(Fitness::Landing(Cause::NoFlow))),
    ("brought down, on the ground", 2_200, |s| s.fitness(Fitness::Landed(Cause::NoFlow))),
    ("motors off until reboot", 2_200, |s| s.fitness(Fitness::Stopped)),
    ("battery for the way home", 2_200, |s| s.endurance(15)),
    ("the same, base as at home", 2_200, |s| s.endurance(15).link(BASE, -50.0)),
    ("31 s later, back weak", 31_000, |s| good(s).link(BASE, -70.0)),
    ("31 s later, back lost", 31_000, |s| good(s).without(BASE)),
];

/// Head and base as well heard as can be.
fn good(scene: Scene) -> Scene {
    scene.without(0).without(BASE).also(0, Phase::Linked, -52.0).also(BASE, Phase::Base, -52.0)
}

fn named(state: State) -> String {
    let why = match state {
        State::Landing { why, .. } | State::Landed { why } => match why {
            LandReason::Ordered => " (ordered)",
            LandReason::Perched => " (to perch)",
            LandReason::Home => " (home)",
            LandReason::Done => " (done)",
            LandReason::Retired => " (retired)",
            LandReason::TakeOffFailed => " (take-off)",
            LandReason::LinkLost => " (link)",
            LandReason::Unfit(_) => " (unfit)",
            LandReason::Restarted => " (restarted)",
            LandReason::PositionLost => " (position)",
        },
        _ => "",
    };
    format!("{}{why}", state.name())
}

fn table(role: Role) -> String {
    let columns: Vec<_> = STATES.iter().filter(|name| in_state(role, name).is_some()).collect();
    let mut text = format!("{role:?}\n{:32}", "");
    for name in &columns {
        let _ = write!(text, "| {name:19}");
    }
    for (situation, gap, becomes) in SITUATIONS {
        let _ = write!(text, "\n{situation:32}");
        for name in &columns {
            let (mut rig, scene) = in_state(role, name).unwrap();
            assert_eq!(&rig.state().name(), *name);
            let outputs = rig.step_after(gap, &becomes(scene));
            assert_eq!(outputs.status.state, rig.state());
            let next = named(rig.state());
            // What stays is not worth reading.
            let shown = if rig.state().name() == **name { "." } else { &next };
            let _ = write!(text, "| {shown:19}");
        }
    }
    let lines: Vec<_> = text.lines().map(str::trim_end).collect();
    lines.join("\n")
}

#[test]
fn every_state_in_every_situation() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/transitions.txt");
    let mut is = String::from(
        "What each state becomes in each situation; a dot stays. See tests/agent/state_table.rs.\n",
    );
    for role in [Role::Head, Role::Relay, Role::Base] {
        let _ = write!(is, "\n{}\n", table(role));
    }
    if std::env::var_os("REMINT").is_some() {
        std::fs::write(file, &is).unwrap();
    }
    let golden = std::fs::read_to_string(file).unwrap_or_default();
    if golden == is {
        return;
    }
    for (was, now) in golden.lines().zip(is.lines()).filter(|(was, now)| was != now) {
        println!("- {was}\n+ {now}");
    }
    panic!("the transitions are no longer those of {file}");
}
