//! The operator's desk: what is said at any drone's port becomes the operator's one word, given
//! to the chain at its base.

use units::{Duration, Instant, MetresPerSecond, Order};

/// The operator's word, as the newest of all that was said has it.
#[derive(Debug, Default)]
pub(super) struct Desk {
    word: Option<Word>,
    /// When the motors stop unless the client asks again that they do not.
    watchdog: Option<Instant>,
}

#[derive(Clone, Copy, Debug)]
enum Word {
    /// A pilot's stick, moved then; it must be moved again and again.
    Stick { forward: MetresPerSecond, at: Instant },
    /// Holds until another is given.
    Standing(Order),
}

impl Desk {
    /// A set-point older than this is nobody's word any more: the firmware of a Crazyflie levels
    /// out after as long (crazyflie-firmware, supervisor.c, COMMANDER_WDT_TIMEOUT_STABILIZE).
    const STICK: Duration = Duration::from_millis(500);
    /// How often the emergency-stop watchdog wants to be fed once it was (crazyflie-firmware,
    /// supervisor.c, DEFAULT_EMERGENCY_STOP_WATCHDOG_TIMEOUT).
    const WATCHDOG: Duration = Duration::from_secs(1);

    /// The stick is moved.
    pub(super) fn steer(&mut self, now: Instant, forward: MetresPerSecond) {
        self.say(Word::Stick { forward, at: now });
    }

    /// An order is given.
    pub(super) fn order(&mut self, task: Order) {
        self.say(Word::Standing(task));
    }

    /// The head, where it explores by itself, does so at another speed.
    pub(super) fn change_speed(&mut self, speed: MetresPerSecond) {
        if let Some(Word::Standing(Order::Explore(_))) = self.word {
            self.order(Order::Explore(speed));
        }
    }

    /// A client that may stop the motors by its silence is still there.
    pub(super) fn feed_watchdog(&mut self, now: Instant) {
        self.watchdog = Some(now + Self::WATCHDOG);
    }

    /// Motors that were stopped stay so until the next boot.
    fn say(&mut self, word: Word) {
        if !matches!(self.word, Some(Word::Standing(Order::Stop))) {
            self.word = Some(word);
        }
    }

    /// What is ordered now; `None` while nobody has said anything yet.
    pub(super) fn task(&mut self, now: Instant) -> Option<Order> {
        if self.watchdog.is_some_and(|until| now > until) {
            self.order(Order::Stop);
        }
        self.word.map(|word| match word {
            Word::Stick { forward, at } if now.since(at) <= Self::STICK => Order::Explore(forward),
            Word::Stick { .. } => Order::Explore(MetresPerSecond::ZERO),
            Word::Standing(task) => task,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEED: MetresPerSecond = MetresPerSecond(0.3);
    const HALT: Option<Order> = Some(Order::Explore(MetresPerSecond::ZERO));

    fn at(ms: u64) -> Instant {
        Instant::from_millis(ms)
    }

    #[test]
    fn nothing_is_ordered_until_somebody_speaks() {
        assert_eq!(Desk::default().task(at(10_000)), None);
    }

    #[test]
    fn a_stick_that_is_let_go_halts_the_head_and_takes_nobody_down() {
        let mut desk = Desk::default();
        desk.steer(at(1_000), SPEED);
        assert_eq!(desk.task(at(1_500)), Some(Order::Explore(SPEED)));
        assert_eq!(desk.task(at(1_510)), HALT);
        assert_eq!(desk.task(at(3_600_000)), HALT);
    }

    #[test]
    fn the_newest_word_counts() {
        let mut desk = Desk::default();
        desk.steer(at(0), SPEED);
        desk.order(Order::Return);
        assert_eq!(desk.task(at(60_000)), Some(Order::Return));
        desk.steer(at(60_000), -SPEED);
        assert_eq!(desk.task(at(60_100)), Some(Order::Explore(-SPEED)));
    }

    #[test]
    fn a_speed_moves_nobody_who_does_not_explore_by_itself() {
        let mut desk = Desk::default();
        desk.change_speed(SPEED);
        assert_eq!(desk.task(at(0)), None);
        desk.steer(at(0), MetresPerSecond::ZERO);
        desk.change_speed(SPEED);
        assert_eq!(desk.task(at(0)), HALT);
        desk.order(Order::Explore(-SPEED));
        desk.change_speed(SPEED);
        assert_eq!(desk.task(at(0)), Some(Order::Explore(SPEED)));
    }

    #[test]
    fn an_emergency_stop_is_the_last_word() {
        let mut desk = Desk::default();
        desk.order(Order::Stop);
        desk.steer(at(0), SPEED);
        desk.order(Order::Wait);
        assert_eq!(desk.task(at(0)), Some(Order::Stop));
    }

    #[test]
    fn a_watchdog_once_fed_stops_the_motors_when_it_starves() {
        let mut desk = Desk::default();
        desk.order(Order::Return);
        desk.feed_watchdog(at(100));
        desk.feed_watchdog(at(1_000));
        assert_eq!(desk.task(at(2_000)), Some(Order::Return));
        assert_eq!(desk.task(at(2_010)), Some(Order::Stop));
    }
}
