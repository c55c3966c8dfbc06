//! Says in words what a drone is doing, what is wrong with it, and what the base orders. The codes
//! are those of the book's page on cfclient, to which a test holds this module.

/// What a drone in the state with this code is doing.
#[must_use]
pub const fn state(code: u8) -> &'static str {
    match code {
        0 => "on the ground, not asked for",
        1 => "on the ground, next to fly",
        2 => "taking off",
        3 => "leading",
        4 => "relaying",
        5 => "flying on to find the drone in front",
        6 => "backing up: a link is too weak",
        7 => "landing",
        8 => "landed",
        9 => "stopped",
        10 => "searching for a place with stronger links",
        11 => "flying home, no longer needed",
        12 => "flying back to the junction",
        13 => "relaying from the ground",
        14 => "rising from the ground",
        15 => "hovering: it does not know its position",
        16 => "surveying",
        17 => "going to its place before the passage",
        18 => "crossing the passage",
        19 => "hovering: it does not know its position",
        20 => "waiting for a goal, and looking around",
        21 => "flying to what is not known yet",
        22 => "looking for a spot at which to land",
        23 => "flying back to where it took off",
        24 => "flying home",
        25 => "flying back to where it took off",
        _ => "in a state that this station does not know",
    }
}

/// Whether a drone in the state with this code is in the air.
#[must_use]
pub const fn is_airborne(state: u8) -> bool {
    matches!(state, 2..=7 | 10..=12 | 14..=25)
}

/// Whether a drone in the state with this code does what is not its usual work: flying back, searching, waiting
/// for its position, crossing, relaying from the ground.
#[must_use]
pub const fn is_news(state: u8) -> bool {
    matches!(state, 5 | 6 | 10..=13 | 15 | 17..=19 | 22..=25)
}

/// What is wrong with a drone whose fault has this code; `None` for nothing.
#[must_use]
pub const fn fault(code: u8) -> Option<&'static str> {
    Some(match code {
        0 => return None,
        1 => "it would not take off",
        2 => "its motors are off until it is switched off and on",
        3 => "it lost the side towards the base",
        4 => "it never reached its height",
        5 => "it restarted, and stays down until told to wait",
        6 => "it did not know its position for too long",
        16 => "nobody said for too long what to do",
        17 => "the inertial sensor failed",
        18 => "nothing measures its velocity",
        19 => "nothing measures its height",
        20 => "the battery is at its end",
        21 => "a motor cannot keep up",
        22 => "it keeps hitting something",
        _ => "it has a fault that this station does not know",
    })
}

/// The order that the base gives, by the code of `uchain.task`.
#[must_use]
pub const fn task(code: u8) -> &'static str {
    match code {
        0 => "wait",
        1 => "explore",
        2 => "return",
        3 => "land",
        4 => "stop",
        5 => "perch",
        _ => "unknown",
    }
}

/// The state of the base's radio link, by the code of `uchain.linkStatus`.
#[must_use]
pub const fn link(code: u8) -> &'static str {
    match code {
        0 => "its radio is off",
        1 => "it listens to the radio",
        2 => "it is a member of the chain",
        3 => "another node has its number",
        4 => "its packet counter is used up; switch it off and on",
        _ => "its radio is in an unknown state",
    }
}

/// A name at the beginning of a sentence.
#[must_use]
pub fn capital(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHAPTER: &str =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/src/cfclient.md"));

    /// The codes in the first column of the chapter's table between two markers.
    fn codes(name: &str) -> Vec<u8> {
        let (_, rest) = CHAPTER.split_once(&format!("<!-- {name} -->")).unwrap();
        let (table, _) = rest.split_once(&format!("<!-- end of {name} -->")).unwrap();
        table.lines().filter_map(|line| line.split('|').nth(1)?.trim().parse().ok()).collect()
    }

    #[test]
    fn every_state_and_every_fault_has_words() {
        let (states, faults) = (codes("states"), codes("faults"));
        assert!(states.len() > 10 && faults.len() > 10);
        assert!(states.iter().all(|code| state(*code) != state(255)), "{states:?}");
        assert!(faults.iter().all(|code| fault(*code) != fault(255)), "{faults:?}");
    }
}
