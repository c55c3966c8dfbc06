//! The list of the pilot's choices: how the head makes it, and how it gets from drone to drone.

use chain::route::Route;
use proptest::prelude::*;
use units::{Branch, Metres, SIGNPOSTS, Signpost};

const LEFT: Option<Branch> = Some(Branch::Left);
const RIGHT: Option<Branch> = Some(Branch::Right);

/// A head that has flown along this way: the choice and the last junction at each 0.1 m.
fn led(to: f32, at: impl Fn(f32) -> (Option<Branch>, Option<f32>)) -> Route {
    let mut route = Route::new();
    for step in 0..=(to * 10.0) as i32 {
        let way = 0.1 * step as f32;
        let (branch, junction) = at(way);
        route.lead(Metres(way), branch, junction.map(Metres));
    }
    route
}

/// Junctions at 5, 12 and 20 m, and left, right, left, each chosen a metre behind the junction before.
fn three_forks() -> Route {
    led(24.0, |way| {
        let junction = [20.0, 12.0, 5.0].into_iter().find(|junction| *junction <= way);
        let branch = if (6.0..13.0).contains(&way) { RIGHT } else { LEFT };
        (branch, junction)
    })
}

/// All entries of a list, as its reports say them.
fn posts(route: &mut Route) -> Vec<Signpost> {
    let first = route.say();
    let count = first.map_or(0, |post| post.count);
    let mut posts: Vec<_> = first.into_iter().collect();
    posts.extend((1..count).filter_map(|_| route.say()));
    posts.sort_by_key(|post| post.index);
    posts
}

#[test]
fn a_choice_counts_at_its_junction_by_an_odometer_that_is_metres_off() {
    let route = three_forks();
    for (junction, branch) in [(5.0, LEFT), (12.0, RIGHT), (20.0, LEFT)] {
        for error in [-3.0, -1.0, 0.0, 1.0, 3.0] {
            assert_eq!(route.branch_at(Metres(junction + error)), branch, "{junction} {error}");
        }
    }
    assert_eq!(route.branch_at(Metres(-100.0)), LEFT);
    assert_eq!(route.branch_at(Metres(100.0)), LEFT);
}

#[test]
fn without_a_choice_there_is_no_list() {
    let mut route = led(9.0, |_| (None, Some(3.0)));
    assert_eq!((route.say(), route.branch_at(Metres(4.0))), (None, None));
}

#[test]
fn a_head_that_comes_back_forgets_what_it_chose_there() {
    let mut route = three_forks();
    for step in 0..220 {
        // Back to before the second junction, and then to the left there.
        route.lead(Metres(24.0 - 0.1 * step as f32), LEFT, Some(Metres(20.0)));
    }
    assert_eq!(route.branch_at(Metres(12.0)), LEFT);
    assert_eq!(posts(&mut route).len(), 1);
}

/// A head that looks to the left at a junction at 5 m, comes back to 3 m, and goes to the right; with no
/// choice, or the old one, while it flies back.
fn looked_to_the_left(meanwhile: Option<Branch>) -> Route {
    let mut route = led(9.0, |way| (LEFT, (way >= 5.0).then_some(5.0)));
    for step in 0..=60 {
        let way = 9.0 - 0.1 * step as f32;
        // Tail first the wall on the left ends behind the corner.
        route.lead(Metres(way), meanwhile, Some(Metres(if way < 6.0 { 6.0 } else { 5.0 })));
    }
    route.lead(Metres(3.0), RIGHT, Some(Metres(6.0)));
    route
}

/// Relays whose odometers were metres off followed the old choice into the dead end.
#[test]
fn a_choice_that_led_nowhere_no_longer_counts_for_relays_that_come_later() {
    for meanwhile in [LEFT, None] {
        let mut route = looked_to_the_left(meanwhile);
        for way in [0.0, 2.5, 4.0, 5.0, 9.0] {
            assert_eq!(route.branch_at(Metres(way)), RIGHT, "{meanwhile:?}, {way}");
        }
        assert_eq!(posts(&mut route).len(), 1);
    }
}

/// The choices at junctions that still lie behind the head stay.
#[test]
fn a_head_that_looks_into_a_later_branch_keeps_what_led_there() {
    let mut route = three_forks();
    for step in 0..=70 {
        route.lead(Metres(24.0 - 0.1 * step as f32), LEFT, Some(Metres(20.0)));
    }
    route.lead(Metres(17.0), RIGHT, Some(Metres(20.0)));
    for (junction, branch) in [(5.0, LEFT), (12.0, RIGHT), (20.0, RIGHT)] {
        for error in [-2.5, 0.0, 2.5] {
            assert_eq!(route.branch_at(Metres(junction + error)), branch, "{junction} {error}");
        }
    }
}

/// While the head is still in the junction, the choice is another than the one by which it came there.
#[test]
fn a_head_in_the_junction_came_there_by_another_choice() {
    let mut route = led(9.0, |way| (LEFT, (way >= 5.0).then_some(5.0)));
    assert_eq!(route.passed_otherwise(Metres(6.0), Branch::Right), Some(Metres(5.0)));
    assert_eq!(route.passed_otherwise(Metres(6.0), Branch::Left), None);
    route.lead(Metres(3.5), LEFT, Some(Metres(6.5)));
    assert_eq!(route.passed_otherwise(Metres(3.5), Branch::Right), None, "it is before it");
}

/// Heads flew back into the hall before the junction, and turned there.
#[test]
fn a_head_that_came_back_past_a_junction_does_not_fly_back_to_the_one_before_it() {
    let opened = |way: f32| [5.0, 12.0].into_iter().rfind(|at| *at <= way);
    let mut route = led(14.0, |way| (LEFT, opened(way)));
    for step in 0..=60 {
        route.lead(Metres(14.0 - 0.1 * step as f32), LEFT, Some(Metres(12.0)));
    }
    assert_eq!(route.passed_otherwise(Metres(8.0), Branch::Right), None);
}

/// The tunnel opened at both sides of a junction. A head that had come back past the far one noted its new
/// choice there, and turned into the dead end again.
#[test]
fn a_head_that_has_come_back_past_the_far_side_of_a_junction_flies_on_to_before_it() {
    let opened = |way: f32| [5.0, 7.0].into_iter().rfind(|at| *at <= way);
    let mut route = led(9.0, |way| (LEFT, opened(way)));
    assert_eq!(route.passed_otherwise(Metres(7.4), Branch::Straight), Some(Metres(7.0)));
    route.come_back(Metres(5.8));
    assert_eq!(route.passed_otherwise(Metres(5.8), Branch::Straight), Some(Metres(5.0)));
}

/// A head at the place where it was to take the other branch trembled to behind it, and flew back for ever.
#[test]
fn a_head_that_trembles_where_the_choice_changed_has_not_flown_back() {
    let mut route = led(0.3, |way| (LEFT, (way >= 0.2).then_some(0.2)));
    route.lead(Metres(0.3), RIGHT, Some(Metres(0.2)));
    for way in [0.25, 0.0] {
        assert_eq!(route.passed_otherwise(Metres(way), Branch::Right), None, "{way}");
    }
}

#[test]
fn a_relay_notes_from_where_on_a_new_list_differs() {
    let mut relay = Route::new();
    posts(&mut three_forks()).into_iter().for_each(|post| relay.hear(post));
    assert_eq!(relay.take_change(), Some(Metres(f32::NEG_INFINITY)));
    assert_eq!(relay.take_change(), None);
    let mut head = three_forks();
    for step in 0..=70 {
        head.lead(Metres(24.0 - 0.1 * step as f32), LEFT, Some(Metres(20.0)));
    }
    head.lead(Metres(17.0), RIGHT, Some(Metres(20.0)));
    posts(&mut head).into_iter().for_each(|post| relay.hear(post));
    let from = relay.take_change().unwrap();
    assert!((14.0..18.0).contains(&from.0), "{from:?}");
}

#[test]
fn more_choices_than_there_is_room_for_leave_the_oldest_out() {
    let choice = |way: f32| if (way / 5.0) as i32 % 2 == 0 { LEFT } else { RIGHT };
    let mut route = led(59.0, |way| (choice(way), None));
    assert_eq!(posts(&mut route).len(), SIGNPOSTS);
    for way in [27.0, 33.0, 58.0] {
        assert_eq!(route.branch_at(Metres(way)), choice(way), "{way}");
    }
}

#[test]
fn a_list_that_has_not_come_as_a_whole_does_not_count() {
    let posts = posts(&mut three_forks());
    let mut relay = Route::new();
    relay.hear(posts[0]);
    relay.hear(posts[2]);
    assert_eq!((relay.branch_at(Metres(5.0)), relay.say()), (None, None));
    relay.hear(posts[1]);
    assert_eq!(relay.branch_at(Metres(12.0)), RIGHT);
}

proptest! {
    /// In any order, however often each entry comes, the relay ends with the head's list, and passes
    /// on what it has heard.
    #[test]
    fn lost_and_repeated_entries_change_nothing(
        order in prop::collection::vec(0_usize..8, 0..40),
    ) {
        let sent = posts(&mut three_forks());
        let mut relay = Route::new();
        for n in order.iter().map(|n| n % sent.len()) {
            relay.hear(sent[n]);
        }
        sent.iter().for_each(|post| relay.hear(*post));
        let once = posts(&mut relay);
        prop_assert_eq!(&once, &sent);
        sent.iter().for_each(|post| relay.hear(*post));
        prop_assert_eq!(posts(&mut relay), once);
    }

    /// Whatever comes, a list has no more entries than there is room for, and an older one does not
    /// replace it.
    #[test]
    fn any_entries_leave_a_sound_list(
        entries in prop::collection::vec(
            (any::<u8>(), any::<u8>(), any::<u8>(), any::<f32>()), 0..60,
        ),
    ) {
        let mut relay = Route::new();
        for (revision, index, count, from) in entries {
            relay.hear(Signpost { revision, index, count, from: Metres(from), branch: LEFT });
            let told = posts(&mut relay);
            prop_assert!(told.len() <= SIGNPOSTS);
            prop_assert!(told.iter().all(|post| post.index < post.count && post.from.0.is_finite()));
            let before = told.first().map(|post| post.revision);
            if let Some(revision) = before {
                let old = revision.wrapping_sub(1);
                relay.hear(Signpost { revision: old, index: 0, count: 1, from: Metres(0.0), branch: RIGHT });
                prop_assert_eq!(posts(&mut relay), told);
            }
        }
    }
}
