//! Finds the name that the user probably meant when a name is unknown.

/// The name that is most like `wrong`, if any is like it at all.
fn nearest<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // One slip of the finger in three letters: a letter wrong, missing, too many, or two exchanged.
    let is_like = |slips: usize| slips <= wrong.len() / 3;
    names
        .into_iter()
        .map(|name| (strsim::osa_distance(&wrong.to_lowercase(), &name.to_lowercase()), name))
        .filter(|(slips, name)| is_like(*slips) && *slips < name.len())
        .min_by_key(|(slips, _)| *slips)
        .map(|(_, name)| name)
}

/// Returns a question whether that name was meant, to be put before the remedy; it is empty where
/// no name is like `wrong`.
pub fn question<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    nearest(wrong, names)
        .map_or_else(String::new, |meant| format!("did you mean {meant}? if not, "))
}

/// Returns the remedy for a wrong name where `names` are the right ones.
#[must_use]
pub fn one_of(wrong: &str, names: &[&str]) -> String {
    format!("{}give one of {}", question(wrong, names.iter().copied()), names.join(", "))
}

/// Returns the [`question`] for an error message of `serde`, which has the wrong name in backticks
/// and after it every right one; it is empty for messages about something else.
#[must_use]
pub fn question_about(message: &str) -> String {
    if !message.starts_with("unknown field") && !message.starts_with("unknown variant") {
        return String::new();
    }
    let mut names = message.split('`').skip(1).step_by(2);
    names.next().map_or_else(String::new, |wrong| question(wrong, names))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_is_understood_and_another_word_is_not() {
        let names = ["demo", "straight", "short-hop", "relay-pair"];
        assert_eq!(nearest("stright", names), Some("straight"));
        assert_eq!(nearest("rnu", ["bench", "run", "serve"]), Some("run"));
        assert_eq!(nearest("Demo", names), Some("demo"));
        assert_eq!(nearest("xyzzy", names), None);
        assert_eq!(nearest("", names), None);
    }

    #[test]
    fn the_names_are_found_in_the_message_of_the_parser() {
        let message = "unknown field `widht_m`, expected one of `width_m`, `winding`, `room`";
        assert_eq!(question_about(message), "did you mean width_m? if not, ");
        let message = "unknown variant `exat`, expected `exact` or `ideal`";
        assert_eq!(question_about(message), "did you mean exact? if not, ");
        assert_eq!(question_about("unclosed array, expected `]`"), "");
        assert_eq!(question_about("unknown field `a`, there are no fields"), "");
    }

    #[test]
    fn a_remedy_names_all_that_there_are() {
        assert_eq!(one_of("t4", &["t0", "t5"]), "give one of t0, t5");
        assert_eq!(
            one_of("defualt", &["t0", "default"]),
            "did you mean default? if not, give one of t0, default"
        );
    }
}
