//! The tables of the book's chapter on cfclient are those of the code.
//!
//! `REMINT=1 cargo test -p onboard --test suite docs` writes them anew.

use std::fmt::Write;
use std::path::Path;

use agent::{ChainDuty, Duty, ExploreDuty, Fitness, LandReason, State, SwarmDuty};
use chain::search::{Place, Search};
use crtp::Documented;
use flight::Cause;
use onboard::air;
use units::{Dbm, Instant, Metres, Point2};

const CHAPTER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/cfclient.md");

fn table(rows: impl Iterator<Item = Documented>, with_access: bool) -> String {
    let mut table = String::from(if with_access {
        "| parameter | type | access | unit | meaning |\n|---|---|---|---|---|\n"
    } else {
        "| variable | type | unit | meaning |\n|---|---|---|---|\n"
    });
    for row in rows {
        let Documented { group, name, kind, access, unit, meaning } = row;
        let access = if with_access { format!(" {access} |") } else { String::new() };
        writeln!(table, "| `{group}.{name}` | {kind} |{access} {unit} | {meaning} |").unwrap();
    }
    table
}

/// What `uchain.state` can be. A state that is missing here is missed by the match.
fn states() -> String {
    let on_duty = |duty| State::OnMission(Duty::Chain(duty));
    let now = Instant::ZERO;
    let why = LandReason::Home;
    let search = Search::begin(now, Place { way: Metres::ZERO, weaker: Dbm(-70.0) });
    let all = [
        (State::Idle, "on the ground, not asked for"),
        (State::Armed { since: now }, "on the ground, next to fly"),
        (State::TakingOff { since: now }, "climbs to its height"),
        (on_duty(ChainDuty::Leading { patient_until: now }), "the head: flies as the pilot says"),
        (on_duty(ChainDuty::Relaying { patient_until: now }), "a relay: makes its two links equal"),
        (
            on_duty(ChainDuty::Reconnecting { since: now, from: Metres::ZERO }),
            "a relay that hears nobody in front: flies on to find them",
        ),
        (
            on_duty(ChainDuty::BackingUp { since: now, from: Metres::ZERO }),
            "a link is too weak: flies back",
        ),
        (State::Landing { since: now, why }, "comes down"),
        (State::Landed { why }, "on the ground, out of the mission until told to wait"),
        (State::Stopped, "motors off until the next boot"),
        (
            on_duty(ChainDuty::Searching { search }),
            "a relay whose links are too weak: looks for a better place",
        ),
        (on_duty(ChainDuty::Retiring), "a relay that is no longer needed: flies home"),
        (
            on_duty(ChainDuty::Rejoining { since: now, to: Metres::ZERO, passed: None }),
            "a relay in another branch than the drone in front: flies back to the junction",
        ),
        (State::Perched, "on the ground at its place in the chain, and relays"),
        (State::Rising { since: now }, "climbs from there back to its height"),
        (
            State::OnMission(Duty::Swarm(SwarmDuty::Hovering { since: now })),
            "of a swarm: does not know its position, and hovers",
        ),
        (State::OnMission(Duty::Swarm(SwarmDuty::Surveying)), "of a swarm: surveys its rows"),
        (
            State::OnMission(Duty::Swarm(SwarmDuty::Gathering)),
            "of a swarm: goes to its place before the passage, and waits there",
        ),
        (
            State::OnMission(Duty::Swarm(SwarmDuty::Crossing)),
            "of a swarm: goes through the passage",
        ),
        (
            State::OnMission(Duty::Explore(ExploreDuty::Lost { since: now })),
            "an explorer: does not know its position, and hovers",
        ),
        (
            State::OnMission(Duty::Explore(ExploreDuty::Waiting)),
            "an explorer: waits for a goal, and looks around",
        ),
        (
            State::OnMission(Duty::Explore(ExploreDuty::Exploring { goal: Point2::default() })),
            "an explorer: flies to what is not known yet",
        ),
        (
            on_duty(ChainDuty::Siting { since: now }),
            "is to relay from the ground: looks for a spot at which to land",
        ),
        (
            State::OnMission(Duty::Explore(ExploreDuty::Returning { has_seen_all: false })),
            "an explorer: has seen all or was called home, and flies to where it took off",
        ),
        (on_duty(ChainDuty::Homing), "flies home: called, or left by the base's side"),
        (
            State::OnMission(Duty::Swarm(SwarmDuty::Returning)),
            "of a swarm: was called home, and comes back to where it took off",
        ),
    ];
    let mut table = String::from("| code | state | the drone |\n|---|---|---|\n");
    for (n, (state, meaning)) in (0..).zip(all) {
        match state {
            State::Idle
            | State::Armed { .. }
            | State::TakingOff { .. }
            | State::OnMission(Duty::Chain(
                ChainDuty::Leading { .. }
                | ChainDuty::Relaying { .. }
                | ChainDuty::Reconnecting { .. }
                | ChainDuty::BackingUp { .. }
                | ChainDuty::Searching { .. }
                | ChainDuty::Retiring
                | ChainDuty::Homing
                | ChainDuty::Rejoining { .. }
                | ChainDuty::Siting { .. },
            ))
            | State::OnMission(Duty::Swarm(
                SwarmDuty::Hovering { .. }
                | SwarmDuty::Surveying
                | SwarmDuty::Gathering
                | SwarmDuty::Crossing
                | SwarmDuty::Returning,
            ))
            | State::OnMission(Duty::Explore(
                ExploreDuty::Lost { .. }
                | ExploreDuty::Waiting
                | ExploreDuty::Exploring { .. }
                | ExploreDuty::Returning { .. },
            ))
            | State::Landing { .. }
            | State::Landed { .. }
            | State::Stopped
            | State::Perched
            | State::Rising { .. } => assert_eq!(state.code(), n, "the rows are in order"),
        }
        writeln!(table, "| {} | {} | {meaning} |", state.code(), state.name()).unwrap();
    }
    table
}

/// What `nodeN.fault` can be.
fn faults() -> String {
    let landed = |why| State::Landed { why };
    let by_flight = |why, meaning| (State::Idle, Fitness::Landed(why), meaning);
    let all = [
        (State::Idle, Fitness::Fit, "nothing is wrong"),
        (State::Idle, Fitness::Unfit, "it would not take off"),
        (State::Stopped, Fitness::Stopped, "its motors are off until the next boot"),
        (landed(LandReason::LinkLost), Fitness::Fit, "it lost the base's side"),
        (landed(LandReason::TakeOffFailed), Fitness::Fit, "it never reached its height"),
        (
            landed(LandReason::Restarted),
            Fitness::Fit,
            "it restarted after a fault or in the air, and stays down until told to wait",
        ),
        (
            landed(LandReason::PositionLost),
            Fitness::Fit,
            "it did not know its position for too long",
        ),
        by_flight(Cause::NoSetpoint, "nobody said for too long what to do"),
        by_flight(Cause::NoImu, "the inertial sensor failed"),
        by_flight(Cause::NoFlow, "nothing measures its velocity"),
        by_flight(Cause::NoHeight, "nothing measures its height"),
        by_flight(Cause::Battery, "the battery is at its end"),
        by_flight(Cause::Overload, "a motor cannot keep up"),
        by_flight(Cause::Blocked, "it keeps hitting something"),
    ];
    let mut table = String::from("| code | meaning |\n|---|---|\n");
    for (state, fitness, meaning) in all {
        writeln!(table, "| {} | {meaning} |", air::fault(state, fitness)).unwrap();
    }
    table
}

/// The chapter with `table` between the markers of that name.
fn with_table(chapter: &str, name: &str, table: &str) -> String {
    let (begin, end) = (format!("<!-- {name} -->\n"), format!("<!-- end of {name} -->"));
    let (before, rest) = chapter.split_once(&begin).expect("the chapter has the marker");
    let (_, after) = rest.split_once(&end).expect("and the one that ends the table");
    format!("{before}{begin}\n{table}\n{end}{after}")
}

#[test]
fn the_book_lists_every_variable_and_parameter() {
    let path = Path::new(CHAPTER);
    let chapter = std::fs::read_to_string(path).expect("docs/src/cfclient.md");
    let right = with_table(&chapter, "variables", &table(crtp::variables(), false));
    let right = with_table(&right, "parameters", &table(crtp::parameters(), true));
    let right = with_table(&right, "states", &states());
    let right = with_table(&right, "faults", &faults());
    if std::env::var_os("REMINT").is_some() {
        std::fs::write(path, right).expect("docs/src/cfclient.md");
        return;
    }
    assert!(
        chapter == right,
        "docs/src/cfclient.md has other tables than the code: \
         write them anew by `REMINT=1 cargo test -p onboard --test suite docs`"
    );
}

#[test]
fn every_row_says_what_it_means() {
    for row in crtp::variables().chain(crtp::parameters()) {
        assert!(!row.meaning.is_empty(), "{row:?}");
        assert!(!row.meaning.contains('|') && !row.unit.contains('|'), "{row:?}");
    }
}
