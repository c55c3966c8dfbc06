//! Profiles of a small program whose every call is known.

use std::sync::{Arc, Mutex};

use crate::image_tiny::{machine, tiny};
use virtual_crazyflie::profile::Profile;

#[test]
fn calls_and_exceptions_are_counted_and_timed() {
    let mut machine = machine();
    let image = machine.image().clone();
    let mut profile = Profile::new(&image);
    for name in ["tiny::outer", "tiny::inner", "tiny::supervise"] {
        profile.watch(&image, name).unwrap();
    }
    for address in profile.traps() {
        assert!(machine.program_mut().trap(address), "{address:#010x}");
    }
    let profile = Arc::new(Mutex::new(profile));
    machine.observe(Some(Box::new(profile.clone())));
    machine.run_until(2_000_000).unwrap();
    let hz = machine.core_hz() as u32;
    let report = profile.lock().unwrap().report(machine.cpu(), machine.memory(), hz);

    let [outer, inner, supervise] = &report.watched[..] else { panic!("three were asked for") };
    let counts = [outer.own.count, inner.own.count, supervise.own.count];
    assert!(counts[0] > 20, "{report}");
    // Three calls of `inner` to each of `outer`; two of `supervise` to each of those.
    assert!(counts[1].abs_diff(3 * counts[0]) <= 3, "{report}");
    assert!(counts[2].abs_diff(2 * counts[1]) <= 2, "{report}");
    let [call] = &report.interrupts[..] else { panic!("{report}") };
    assert_eq!(call.name, "SVCall");
    assert!(call.own.count.abs_diff(counts[1]) <= 1, "{report}");
    // The supervisor's time is not `inner`'s own, but lies between its begin and its end.
    assert!(inner.own.max + call.own.p50 <= inner.whole.max, "{report}");
    assert!(outer.whole.p50 > 3.0 * inner.whole.p50, "{report}");
    assert_eq!((call.own.max, call.own.p50), (call.whole.max, call.whole.p50));
    let sum = report.executor + call.share;
    assert!((sum - report.load).abs() < 1e-6 && report.load > 0.999, "{report}");
    // Frames of outer, inner, an exception, svcall and supervise: so much and not much more.
    let seen = report.stack.unwrap().seen.unwrap();
    assert!((80..160).contains(&seen), "{report}");
    assert_eq!(report.unfinished, 0);
    assert!(report.to_string().contains("SVCall"), "{report}");
}

#[test]
fn looking_on_changes_nothing() {
    let mut alone = machine();
    alone.run_until(1_000_000).unwrap();
    let mut watched = machine();
    let mut profile = Profile::new(&watched.image().clone());
    profile.watch(&tiny(), "tiny::inner").unwrap();
    for address in profile.traps() {
        watched.program_mut().trap(address);
    }
    watched.observe(Some(Box::new(profile)));
    watched.run_until(1_000_000).unwrap();
    assert_eq!(watched.state_hash(), alone.state_hash());
}

#[test]
fn a_function_that_was_inlined_cannot_be_watched() {
    let image = tiny();
    let why = Profile::new(&image).watch(&image, "tiny::middle").unwrap_err();
    assert_eq!(
        why.to_string(),
        "the image has no function tiny::middle of its own: it may have been inlined"
    );
}
