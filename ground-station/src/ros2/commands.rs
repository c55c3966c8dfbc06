//! Reads what programs ask for: the words of `/order`, the speed of `/cmd_vel`, and their age.

use std::time::{Duration, SystemTime};

use ros2_topics::{Commands, Received};

use crate::freshness::{Echo, LIMIT};
use crate::order::{Order, Way};
use crate::station::Request;

/// What programs have asked for since the last look.
#[derive(Clone, Debug, Default)]
pub(super) struct Heard {
    /// The words of orders, in the order in which they came.
    pub(super) orders: Vec<(Age, String)>,
    /// The forward speed of the last Twist, m/s.
    pub(super) forward: Option<(Age, f64)>,
}

/// How long ago a message was sent; `None` where nothing says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Age(pub(super) Option<Duration>);

impl Heard {
    /// Takes what has come.
    pub(super) fn take(commands: &mut Commands, now: SystemTime) -> Self {
        let orders = std::iter::from_fn(|| commands.take_order());
        let orders = orders.map(|Received { what, sent }| (Age::of(sent, now), what)).collect();
        let forward = commands.take_forward();
        Self { orders, forward: forward.map(|twist| (Age::of(twist.sent, now), twist.what)) }
    }
}

impl Age {
    /// By the clock of the sender's machine. One that is ahead of this machine's by more than an order may
    /// be old says nothing about the age.
    fn of(sent: Option<SystemTime>, now: SystemTime) -> Self {
        Self(sent.and_then(|sent| {
            match now.duration_since(sent) {
                Ok(age) => Some(age),
                Err(ahead) => (ahead.duration().as_micros() < u128::from(LIMIT.as_micros()))
                    .then_some(Duration::ZERO),
            }
        }))
    }

    /// What a page would say with an act of this age, when `stamp` is that of the last state. The stamp of
    /// an older state stands for it, because a page also counts as there from the stamp that it echoes.
    pub(super) fn echo(self, stamp: u64, seq: u64) -> Echo {
        let Some(age) = self.0 else { return Echo { seq: Some(seq), ..Echo::default() } };
        // Whole milliseconds, rounded up, make nothing younger.
        let age = u64::try_from(age.as_micros().div_ceil(1_000)).unwrap_or(u64::MAX);
        let back = age.min(stamp);
        Echo { stamp: Some(stamp - back), held: age - back, seq: Some(seq) }
    }
}

/// The request that a word of `/order` stands for; `None` for a word that stands for none.
pub(super) fn request(text: &str) -> Option<Request> {
    let mut words = text.split_whitespace();
    let (word, choice) = (words.next()?, words.next());
    if words.next().is_some() {
        return None;
    }
    Some(match (word, choice) {
        ("stop", None) => Request::Stop,
        ("steer", None) => Request::Steer,
        ("wait", None) => Request::Order(Order::Wait),
        ("hold", None) => Request::Order(Order::Hold),
        ("return", None) => Request::Order(Order::Recall),
        ("land", None) => Request::Order(Order::Land),
        ("perch", None) => Request::Order(Order::Perch),
        ("branch", Some(choice)) => {
            let ways = [Way::None, Way::Left, Way::Right, Way::Straight];
            let way = ways.into_iter().find(|way| way.name() == choice)?;
            Request::Order(Order::Branch { way })
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use std::time::UNIX_EPOCH;

    use super::*;

    #[test]
    fn orders_are_words_and_nothing_else() {
        for word in ["stop", "steer", "wait", "hold", " return\n", "land", "perch", "branch left"] {
            assert!(request(word).is_some(), "{word:?}");
        }
        for word in ["", "Return", "explore", "return home", "branch", "branch up", "branch left 2"]
        {
            assert!(request(word).is_none(), "{word:?}");
        }
    }

    #[test]
    fn a_message_is_as_old_as_its_sender_says_and_never_younger() {
        let now = UNIX_EPOCH + Duration::from_secs(1_000);
        let age = |sent_us| Age::of(Some(UNIX_EPOCH + Duration::from_micros(sent_us)), now);
        let echo = age(999_899_500).echo(5_000, 7);
        assert_eq!(echo, Echo { stamp: Some(4_899), held: 0, seq: Some(7) });
        let echo = age(990_000_000).echo(5_000, 7);
        assert_eq!(echo, Echo { stamp: Some(0), held: 5_000, seq: Some(7) });
    }

    #[test]
    fn a_message_from_the_future_or_without_a_time_has_no_age() {
        let now = UNIX_EPOCH + Duration::from_secs(1_000);
        assert_eq!(Age::of(Some(now + Duration::from_millis(499)), now), Age(Some(Duration::ZERO)));
        for sent in [None, Some(now + Duration::from_millis(500))] {
            let age = Age::of(sent, now);
            assert_eq!(age, Age(None));
            assert_eq!(age.echo(5_000, 7), Echo { stamp: None, held: 0, seq: Some(7) });
        }
    }
}
