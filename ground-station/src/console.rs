//! Joins the text of the base's console, which comes in pieces of a packet, to lines.

/// The longest line that is kept: as much as a base buffers (`crtp`, `console.rs`).
const LONGEST: usize = 512;

/// The console of a base.
#[derive(Clone, Debug, Default)]
pub struct Console {
    /// The begin of the line that has not ended yet.
    begun: String,
}

impl Console {
    /// Takes a piece of text; returns the sentences that end in it. A line of one word is no sentence but the
    /// name of a state, which the page shows anyway.
    pub fn take(&mut self, text: &str) -> Vec<String> {
        self.begun.push_str(text);
        let mut sentences = Vec::new();
        while let Some((line, rest)) = self.begun.split_once('\n') {
            let line = line.trim();
            if line.contains(' ') {
                sentences.push(line.to_owned());
            }
            self.begun = rest.to_owned();
        }
        if self.begun.len() > LONGEST {
            self.begun.clear();
        }
        sentences
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_joined_and_states_left_out() {
        let mut console = Console::default();
        assert_eq!(console.take("idle\nPackets come "), Vec::<String>::new());
        assert_eq!(console.take("late.\nThe head st"), ["Packets come late."]);
        assert_eq!(console.take("ands.\nsto"), ["The head stands."]);
        assert_eq!(console.take("pped\n"), Vec::<String>::new());
    }

    #[test]
    fn a_line_without_an_end_is_not_kept() {
        let mut console = Console::default();
        for _ in 0..1_000 {
            assert_eq!(console.take(&"x y".repeat(9)), Vec::<String>::new());
            assert!(console.begun.len() <= LONGEST);
        }
    }
}
