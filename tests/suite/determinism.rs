//! The same scenario and seed give the same bytes: twice in one process, on one thread and on two,
//! in a debug build and in a release build, on any machine.
//!
//! It covers the whole stack: tunnel, beams, radio, random streams, agents, and both trace
//! formats. Anything that reads a clock, iterates a hash map, or takes a sine from the platform
//! shows up here.

use std::io::Cursor;
use std::path::Path;

use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use sim_harness::measure::campaign::fly;
use sim_harness::measure::metrics::Reference;
use sim_harness::mission::Mission;
use sim_harness::mission::trace::Trace;
use sim_harness::report::{csv, mcap};
use sim_harness::scenario::Scenario;

use crate::golden;

fn short() -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenarios/short.toml");
    Scenario::read(&file).unwrap_or_else(|error| panic!("{error}"))
}

/// What `--out` writes of it.
fn bytes(trace: &Trace) -> (Vec<u8>, Vec<u8>) {
    let (mut table, mut recording) = (Vec::new(), Cursor::new(Vec::new()));
    csv::write(trace, &mut table).unwrap();
    mcap::write(trace, &mut recording).unwrap();
    (table, recording.into_inner())
}

#[test]
fn a_mission_flown_twice_leaves_the_same_bytes() {
    let scenario = short();
    let once = bytes(&Mission::record(&scenario, &scenario.world(), 7));
    let again = bytes(&Mission::record(&scenario, &scenario.world(), 7));
    assert!(once.0 == again.0, "trace.csv differs");
    assert!(once.1 == again.1, "trace.mcap differs");
    let other = bytes(&Mission::record(&scenario, &scenario.world(), 8));
    assert!(once.0 != other.0, "the seed does nothing");
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let scenario = short();
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let with_threads = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let traces: Vec<_> = (0..6_u64)
                .into_par_iter()
                .map(|seed| bytes(&Mission::record(&scenario, &world, seed)))
                .collect();
            let figures = fly(&scenario, &world, &reference, 1, 6, || ());
            (traces, format!("{figures:?}"))
        })
    };
    let (alone, alone_figures) = with_threads(1);
    let (two, two_figures) = with_threads(2);
    for (seed, (one, other)) in alone.iter().zip(&two).enumerate() {
        assert!(one.0 == other.0, "trace.csv of seed {seed} differs");
        assert!(one.1 == other.1, "trace.mcap of seed {seed} differs");
    }
    assert_eq!(alone_figures, two_figures);
}

/// A debug build, a release build and another machine all compare themselves to one table.
#[test]
fn the_trace_is_the_committed_one() {
    let scenario = short();
    let (table, _) = bytes(&Mission::record(&scenario, &scenario.world(), 1));
    golden::compare("short.csv", &golden::rows_every(1, &table));
}
