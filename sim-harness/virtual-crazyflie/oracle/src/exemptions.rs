//! The known cases in which Unicorn differs from the architecture, or from an STM32F4, with the
//! reasons.

use core_vectors::forms::Form;
use core_vectors::{After, Outcome, State};

/// A difference that is no error of ours.
pub(crate) struct Exemption {
    pub(crate) name: &'static str,
    /// The passage of the manual.
    pub(crate) reason: &'static str,
    applies: fn(&Case<'_>) -> bool,
}

struct Case<'a> {
    name: &'a str,
    encoding: u32,
    state: &'a State,
    ours: &'a Outcome,
    other: &'a Outcome,
}

impl Case<'_> {
    fn both(&self) -> Option<(&After, &After)> {
        match (self.ours, self.other) {
            (Outcome::Done(ours), Outcome::Done(other)) => Some((ours, other)),
            _ => None,
        }
    }

    /// They are the same once this has been done to both.
    fn same_but_for(&self, change: impl Fn(&mut After)) -> bool {
        self.both().is_some_and(|(ours, other)| {
            let (mut ours, mut other) = (ours.clone(), other.clone());
            change(&mut ours);
            change(&mut other);
            ours == other
        })
    }
}

/// All of them.
pub(crate) const EXEMPTIONS: &[Exemption] = &[
    Exemption {
        name: "unaligned multiple",
        reason: "DDI 0403, A3.2.1: LDM, STM, LDRD, STRD, VLDR and their kin fault when unaligned, \
                 and for LDR of PC nothing is said (A7.7, LDR); Unicorn goes ahead",
        applies: |case| {
            matches!((case.ours, case.other), (Outcome::Fault(what), Outcome::Done(_))
                if what.starts_with("Unaligned"))
                && ["LDM", "STM", "LDRD", "STRD", "VLD", "VST", "LDREX", "STREX", "LDR pc"]
                    .iter()
                    .any(|stem| case.name.starts_with(stem))
        },
    },
    Exemption {
        name: "priority bits",
        reason: "PM0214, BASEPRI: an STM32F4 has the upper four bits; Unicorn's core has eight",
        applies: |case| case.name == "MSR" && case.same_but_for(|after| after.special[3] &= 0xF0),
    },
    Exemption {
        name: "alignment of SP",
        reason: "DDI 0403, B1.4.1: bits 1 and 0 of SP are zero and stay so; Unicorn writes them",
        applies: |case| {
            case.both().is_some_and(|(ours, _)| ours.r[13] & 3 == 0)
                && case.same_but_for(|after| {
                    after.r[13] &= !3;
                    after.special[0] &= !3;
                    after.special[1] &= !3;
                })
        },
    },
    Exemption {
        name: "fixed point rounds to nearest",
        reason: "DDI 0403, A7.7, VCVT: from fixed point VCVT rounds to nearest whatever the mode; \
                 Unicorn rounds by FPSCR. Ours is held to the exact quotient instead",
        applies: |case| {
            let d = (case.encoding >> 11 & 0x1E | case.encoding >> 22 & 1) as usize;
            case.name == "VCVT from fixed"
                && case.state.fpscr >> 22 & 3 != 0
                && case.same_but_for(|after| after.s[d] = 0)
                && case.both().is_some_and(|(ours, _)| ours.s[d] == from_fixed(case))
        },
    },
    Exemption {
        name: "sum of products in between",
        reason: "DDI 0403, A7.7, SMLAD: Q is about the sum of all three. Unicorn sets it where the \
                 products alone exceed 32 bits, too, though the addend brings them back",
        applies: |case| {
            let register = |at: u32| case.state.r[(case.encoding >> at & 15).min(14) as usize];
            case.name == "SMLAD"
                && (register(16), register(0)) == (0x8000_8000, 0x8000_8000)
                && (register(12) as i32) < 0
                && case.same_but_for(|after| after.apsr &= !(1 << 27))
                && case.both().is_some_and(|(ours, _)| ours.apsr == case.state.apsr)
        },
    },
    Exemption {
        name: "bit-band alias",
        reason: "PM0214, bit-banding: from 0x22000000 on the RAM is there once more, a bit at each \
                 word; Unicorn has nothing there: a fault",
        applies: |case| {
            let base = match case.encoding >> 16 {
                0 => case.encoding >> 3 & 7,
                wide => wide & 15,
            };
            matches!((case.ours, case.other), (Outcome::Done(_), Outcome::Fault(what))
                if what.ends_with("_UNMAPPED"))
                && ["LDR", "STR"].iter().any(|stem| case.name.starts_with(stem))
                && case.state.r.get(base as usize).is_some_and(|base| base >> 25 == 0x11)
        },
    },
    Exemption {
        name: "refused by name",
        reason: "of what is not modelled, unaligned accesses outside memory and parts of the \
                 system's registers, ours says so and stops; Unicorn has nothing there: a fault",
        applies: |case| {
            matches!((case.ours, case.other), (Outcome::Other(what), Outcome::Fault(_))
                if what.starts_with("Refused") && what.contains("Unmodelled"))
        },
    },
];

/// The fixed-point number in the state, as the nearest float: a double holds it exactly.
fn from_fixed(case: &Case<'_>) -> u32 {
    let d = (case.encoding >> 11 & 0x1E | case.encoding >> 22 & 1) as usize;
    let (bits, wide) = (case.state.s[d], case.encoding >> 7 & 1 == 1);
    let value = match (case.encoding >> 16 & 1 == 1, wide) {
        (true, true) => f64::from(bits),
        (true, false) => f64::from(bits as u16),
        (false, true) => f64::from(bits as i32),
        (false, false) => f64::from(bits as i16),
    };
    let size: u32 = if wide { 32 } else { 16 };
    let fraction = size - ((case.encoding & 15) << 1 | case.encoding >> 5 & 1);
    let exact = value / (1u64 << fraction) as f64;
    (exact as f32).to_bits()
}

/// Instructions that leave the stream: an exception's entry, or sleep. IT is one of them, because
/// Unicorn fuses it with the instructions that follow: blocks are tried one instruction at a time,
/// with ITSTATE in the state.
pub(crate) fn cannot_be_compared(form: &Form) -> bool {
    if form.name == "IT" {
        return true;
    }
    ["SVC", "BKPT", "WFE", "WFI", "YIELD"].iter().any(|stem| form.name.starts_with(stem))
}

/// The exemption that a difference falls under.
pub(crate) fn find(
    form: Option<&Form>,
    encoding: u32,
    state: &State,
    ours: &Outcome,
    other: &Outcome,
) -> Option<usize> {
    let form = form?;
    let case = Case { name: &form.name, encoding, state, ours, other };
    EXEMPTIONS.iter().position(|exemption| (exemption.applies)(&case))
}
