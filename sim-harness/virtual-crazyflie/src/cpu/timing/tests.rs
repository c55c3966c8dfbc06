//! The accelerator's cache, against a list in the order of use.

use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

const WAIT: u8 = 5;

fn accelerated() -> Timing {
    let mut timing = Timing::default();
    timing.set_flash(FlashTiming::Accelerated, WAIT);
    timing
}

/// Whether a list of so many lines holds one; it is from now on.
fn used<T: PartialEq>(list: &mut VecDeque<T>, line: T, most: usize) -> bool {
    let held = list.iter().position(|held| *held == line);
    if let Some(at) = held {
        list.remove(at);
    }
    list.push_front(line);
    list.truncate(most);
    held.is_some()
}

proptest! {
    /// Only every third line is asked for, so that none is fetched ahead of the one before.
    #[test]
    fn the_line_of_instructions_that_was_used_longest_ago_goes_first(
        lines in prop::collection::vec(0..90_u16, 1..2000),
        early in 0..3000,
    ) {
        let mut timing = accelerated();
        timing.instructions.clock = (i32::MAX / TICK - early) * TICK;
        let (mut list, mut before) = (VecDeque::new(), NO_LINE);
        for line in lines.into_iter().map(|line| 3 * line) {
            if line != before {
                let held = used(&mut list, line, LINES);
                prop_assert_eq!(timing.fetch(line, 0), if held { 0 } else { u64::from(WAIT) });
            }
            before = line;
        }
    }

    #[test]
    fn so_does_the_line_of_data(lines in prop::collection::vec(0..12_u32, 1..500)) {
        let mut timing = accelerated();
        let mut list = VecDeque::new();
        for line in lines {
            let held = used(&mut list, line, DATA_LINES);
            prop_assert_eq!(timing.load(16 * line + 4), if held { 0 } else { u64::from(WAIT) });
        }
    }

    #[test]
    fn the_next_line_costs_what_is_left_of_fetching_it_ahead(spent in 0..12_u64) {
        let mut timing = accelerated();
        let wait = u64::from(WAIT);
        prop_assert_eq!(timing.fetch(100, 0), wait);
        let expected = (2 * wait + 1).saturating_sub(wait + spent);
        prop_assert_eq!(timing.fetch(101, wait + spent), expected);
    }
}
