//! The choice that is kept up to date is the one that the manual's rules make anew.

use proptest::prelude::*;

use super::*;

/// One thing that happens.
#[derive(Clone, Copy, Debug)]
enum Change {
    Pend(u16),
    Unpend(u16),
    Lines(u128),
    Enable(u16, bool),
    Priority(u16, u8),
    Grouping(u8),
    Primask(bool),
    Faultmask(bool),
    Basepri(u8),
    /// Enters all exceptions that may be entered.
    Enter,
    /// The exception that came in last returns.
    Return,
}

/// The rules of B1.5.4 and B3.4.1, one exception at a time and nothing remembered.
struct Manual {
    pending: [bool; EXCEPTIONS],
    enabled: [bool; EXCEPTIONS],
    active: [bool; EXCEPTIONS],
    lines: [bool; EXCEPTIONS],
    priority: [i32; EXCEPTIONS],
    grouping: u32,
    primask: bool,
    faultmask: bool,
    basepri: i32,
    stack: Vec<usize>,
}

impl Manual {
    fn new() -> Self {
        let none = [false; EXCEPTIONS];
        let mut priority = [0; EXCEPTIONS];
        (priority[1], priority[2], priority[3]) = (-3, -2, -1);
        let enabled = std::array::from_fn(|n| matches!(n, 2 | 3 | 11 | 14 | 15));
        Self {
            pending: none,
            enabled,
            active: none,
            lines: none,
            priority,
            grouping: 0,
            primask: false,
            faultmask: false,
            basepri: 0,
            stack: Vec::new(),
        }
    }

    fn grouped(&self, priority: i32) -> i32 {
        let value = 2 << self.grouping;
        if priority < 0 { priority } else { priority - priority % value }
    }

    fn without_primask(&self) -> i32 {
        let mut highest = 256;
        for n in 2..EXCEPTIONS {
            if self.active[n] && self.grouped(self.priority[n]) < highest {
                highest = self.grouped(self.priority[n]);
            }
        }
        highest.min(self.boosted())
    }

    fn boosted(&self) -> i32 {
        let mut boosted = 256;
        if self.basepri != 0 {
            boosted = self.grouped(self.basepri);
        }
        if self.faultmask { -1 } else { boosted }
    }

    fn execution(&self) -> i32 {
        if self.primask { self.without_primask().min(0) } else { self.without_primask() }
    }

    fn best(&self) -> Option<usize> {
        (2..EXCEPTIONS)
            .filter(|n| self.pending[*n] && self.enabled[*n])
            .min_by_key(|n| (self.priority[*n], *n))
    }

    fn apply(&mut self, change: Change) {
        match change {
            Change::Pend(n) => self.pending[usize::from(n)] = true,
            Change::Unpend(n) => {
                let n = usize::from(n);
                self.pending[n] &= self.lines[n];
            }
            Change::Lines(lines) => {
                for n in 16..EXCEPTIONS {
                    let level = lines >> (n - 16) & 1 != 0;
                    self.pending[n] |= level && !self.lines[n];
                    self.lines[n] = level;
                }
            }
            Change::Enable(n, on) => self.enabled[usize::from(n)] = on,
            Change::Priority(n, value) => {
                if n > 3 {
                    self.priority[usize::from(n)] = i32::from(value & 0xF0);
                }
            }
            Change::Grouping(value) => self.grouping = u32::from(value),
            Change::Primask(on) => self.primask = on,
            Change::Faultmask(on) => self.faultmask = on,
            Change::Basepri(value) => self.basepri = i32::from(value & 0xF0),
            Change::Enter => {
                if let Some(n) = self.best().filter(|_| self.wants_in()) {
                    self.pending[n] = false;
                    self.active[n] = true;
                    self.stack.push(n);
                }
            }
            Change::Return => {
                if let Some(n) = self.stack.pop() {
                    self.active[n] = false;
                    self.faultmask &= n == 2;
                    self.pending[n] |= self.lines[n];
                }
            }
        }
    }

    fn wants_in(&self) -> bool {
        self.best().is_some_and(|n| self.grouped(self.priority[n]) < self.execution())
    }

    fn wakes(&self) -> bool {
        self.best().is_some_and(|n| self.grouped(self.priority[n]) < self.without_primask())
    }

    fn vect_pending(&self) -> usize {
        self.best().filter(|n| self.grouped(self.priority[*n]) < self.boosted()).unwrap_or(0)
    }
}

fn apply(priorities: &mut Priorities, stack: &mut Vec<u16>, change: Change) {
    match change {
        Change::Pend(n) => {
            priorities.pend(bit(n));
        }
        Change::Unpend(n) => priorities.unpend(bit(n)),
        Change::Lines(lines) => {
            if !priorities.has_lines(lines) {
                priorities.set_lines(lines);
            }
        }
        Change::Enable(n, on) => priorities.set_enabled(bit(n), on),
        Change::Priority(n, value) => priorities.set_priority(n, value),
        Change::Grouping(value) => priorities.set_grouping(value),
        Change::Primask(on) => priorities.set_primask(on),
        Change::Faultmask(on) => priorities.set_faultmask(on),
        Change::Basepri(value) => priorities.set_basepri(value),
        Change::Enter => {
            if priorities.wants_in()
                && let Some(n) = priorities.best()
            {
                priorities.activate(n);
                stack.push(n);
            }
        }
        Change::Return => {
            if let Some(n) = stack.pop() {
                priorities.deactivate(n);
            }
        }
    }
}

/// A few exceptions, so that they meet often, and all kinds of them.
fn exception() -> impl Strategy<Value = u16> {
    prop_oneof![Just(2), Just(3), Just(5), Just(11), Just(15), 16_u16..22, Just(97)]
}

fn configurable() -> impl Strategy<Value = u16> {
    exception().prop_filter("the core keeps these enabled", |n| !matches!(n, 2 | 3 | 11 | 15))
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        3 => exception().prop_map(Change::Pend),
        1 => exception().prop_map(Change::Unpend),
        2 => (0_u128..64, any::<bool>())
            .prop_map(|(low, high)| Change::Lines(low | u128::from(high) << 81)),
        2 => (configurable(), any::<bool>()).prop_map(|(n, on)| Change::Enable(n, on)),
        2 => (exception(), any::<u8>()).prop_map(|(n, value)| Change::Priority(n, value)),
        1 => (0_u8..8).prop_map(Change::Grouping),
        1 => any::<bool>().prop_map(Change::Primask),
        1 => any::<bool>().prop_map(Change::Faultmask),
        1 => any::<u8>().prop_map(Change::Basepri),
        4 => Just(Change::Enter),
        2 => Just(Change::Return),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn what_is_kept_equals_what_the_manual_says(
        changes in prop::collection::vec(change(), 1..60),
    ) {
        let mut manual = Manual::new();
        let mut priorities = Priorities::default();
        let mut stack = Vec::new();
        for change in changes {
            manual.apply(change);
            apply(&mut priorities, &mut stack, change);
            prop_assert_eq!(priorities.best().map(usize::from), manual.best());
            prop_assert_eq!(i32::from(priorities.execution()), manual.execution());
            prop_assert_eq!(priorities.wants_in(), manual.wants_in());
            prop_assert_eq!(priorities.wakes(), manual.wakes());
            prop_assert_eq!(usize::from(priorities.vect_pending()), manual.vect_pending());
        }
    }
}

#[test]
fn of_equal_priorities_the_lowest_number_comes_first() {
    let mut priorities = Priorities::default();
    priorities.set_enabled(bit(40) | bit(41), true);
    priorities.pend(bit(41));
    priorities.pend(bit(40));
    assert_eq!(priorities.best(), Some(40));
    priorities.set_priority(40, 0x10);
    assert_eq!(priorities.best(), Some(41));
}

#[test]
fn a_subpriority_orders_but_does_not_interrupt() {
    let mut priorities = Priorities::default();
    priorities.set_enabled(bit(40) | bit(41) | bit(42), true);
    // Bits 7 and 6 are the group.
    priorities.set_grouping(5);
    priorities.set_priority(40, 0x60);
    priorities.set_priority(41, 0x50);
    priorities.set_priority(42, 0x30);
    priorities.pend(bit(40));
    priorities.activate(40);
    priorities.pend(bit(41));
    assert!(!priorities.wants_in(), "it is of the same group");
    priorities.pend(bit(42));
    assert!(priorities.wants_in());
    assert_eq!(priorities.best(), Some(42));
}

#[test]
fn a_line_that_stays_high_asks_again_on_return_and_not_before() {
    let mut priorities = Priorities::default();
    priorities.set_enabled(bit(16), true);
    priorities.set_lines(1);
    priorities.activate(16);
    priorities.set_lines(1);
    assert_eq!(priorities.pending(), 0);
    priorities.deactivate(16);
    assert_eq!(priorities.pending(), bit(16));
    priorities.unpend(bit(16));
    assert_eq!(priorities.pending(), bit(16), "the line is still high");
    priorities.set_lines(0);
    assert_eq!(priorities.pending(), bit(16), "what was asked for once is remembered");
    priorities.unpend(bit(16));
    assert_eq!(priorities.pending(), 0);
}

#[test]
fn a_pulse_while_it_is_active_is_not_lost() {
    let mut priorities = Priorities::default();
    priorities.set_enabled(bit(16), true);
    priorities.set_lines(1);
    priorities.activate(16);
    priorities.set_lines(0);
    priorities.set_lines(1);
    priorities.set_lines(0);
    assert_eq!(priorities.pending(), bit(16));
    assert!(!priorities.wants_in());
    priorities.deactivate(16);
    assert!(priorities.wants_in());
}
