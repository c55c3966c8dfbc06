//! Keeps the list of the choices that the pilot made at junctions, and passes it on from the head to
//! the relays.
//!
//! "It is straightforward to store and transmit the direction choice made by the pilot who is
//! controlling the head UAV, provided that a crude approximate of the position x in the tunnel is
//! available" (the conclusion of the U-Chain paper). The head notes its way by odometer wherever the
//! pilot's choice changes, and a relay takes the choice that counts at its own way. The choice before
//! such a place counts at the junctions before it, and the new one at those behind it; so a relay's
//! odometer may be wrong by as much as the nearest junction is away. The head therefore moves each
//! place to the middle between the last junction before it and the first one behind it.
//!
//! Every drone sends one entry in each of its reports, one after the other. A list that has come as a
//! whole replaces an older one: a report that is lost or comes twice changes nothing.
//!
//! A pilot may look into a branch, back out and choose another one. A junction that the head has come
//! back to no longer lies behind it; and a choice by which the head has passed no junction that still
//! lies behind it led nowhere: the next one takes its place, so that relays that come later never
//! follow it.

use heapless::Vec;
use units::{Branch, Metres, SIGNPOSTS, Signpost};

/// How far the head must fly back from a place before what the pilot chose there is forgotten: an
/// odometer trembles by centimetres while the head hovers.
const BACK: Metres = Metres(0.5);

/// A drone that is so far before the place where it saw the tunnel open is before the junction: both beams
/// of that side have seen the wall again, and for long enough that it counts. Our own number, for
/// galleries of 1.2 to 1.6 m, tuned in the simulator.
pub const BEFORE: Metres = Metres(1.2);
/// A junction is so long, from where the leading beam sees it to a metre and a half into a branch: half of
/// a gallery of 1.6 m, a turn of a right angle at 0.5 m, and what the wall of the branch is seen later. Our
/// own number.
pub const JUNCTION: Metres = Metres(3.5);
/// The way by which an odometer trembles from round to round.
const TREMBLES: Metres = Metres(0.05);
/// The most openings behind the head that are remembered; of more the oldest is forgotten.
const OPENINGS: usize = 16;

/// One choice, and the way from which on it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Choice {
    from: Metres,
    branch: Option<Branch>,
}

/// The list of the pilot's choices, as one drone knows it.
#[derive(Clone, Debug, Default)]
pub struct Route {
    revision: u8,
    choices: Vec<Choice, SIGNPOSTS>,
    /// The way at which the tunnel opened last, as the head told it.
    told: Option<Metres>,
    /// The same place, until the head has flown on from there or back.
    ahead: Option<Metres>,
    /// The ways at which the tunnel opened behind the head, in order.
    openings: Vec<Metres, OPENINGS>,
    /// The nearest opening past which the head has come back, until it passes another.
    came_back: Option<Metres>,
    /// The junction before the place at which the choice changed last, until the next one is passed.
    before: Option<Metres>,
    /// A list of which some entries have come.
    incoming: Option<Incoming>,
    /// The number of the entry that the next report has.
    next: u8,
    /// The way from which on this list differs from the one before, until that is taken note of.
    changed_from: Option<Metres>,
}

/// A list of which some entries have come.
#[derive(Clone, Copy, Debug)]
struct Incoming {
    revision: u8,
    count: u8,
    entries: [Option<Choice>; SIGNPOSTS],
}

impl Route {
    /// A list without any choice.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            revision: 0,
            choices: Vec::new(),
            told: None,
            ahead: None,
            openings: Vec::new(),
            came_back: None,
            before: None,
            incoming: None,
            next: 0,
            changed_from: None,
        }
    }

    /// Notes at the head that the pilot's choice is `branch` while the head is at `way`, and where the
    /// tunnel has opened last.
    pub fn lead(&mut self, way: Metres, branch: Option<Branch>, junction: Option<Metres>) {
        if !way.0.is_finite() {
            return;
        }
        self.pass(way, junction);
        // The head has flown back past a place: what it chose there no longer leads to it.
        while let [_, .., last] = self.choices.as_slice()
            && way < last.from - BACK
        {
            self.choices.pop();
            self.before = None;
            self.revision = self.revision.wrapping_add(1);
        }
        let chosen = self.choices.last().map(|last| last.branch);
        if chosen != Some(branch) && !(chosen.is_none() && branch.is_none()) {
            self.before = Some(self.openings.last().copied().unwrap_or(way));
            let surplus = usize::from(self.choices.is_full());
            self.choices = gathered(self.choices.iter().skip(surplus).copied());
            // There is room: of a full list the oldest entry was left out.
            let _ = self.choices.push(Choice { from: way, branch });
            self.revision = self.revision.wrapping_add(1);
            self.changed_from = Some(way);
        }
        self.leave_out_idle();
    }

    /// Leaves out choices before the last one that have led past no junction which still lies behind a
    /// head that has come back.
    fn leave_out_idle(&mut self) {
        while self.came_back.is_some()
            && let [.., before, last] = self.choices.as_slice()
            && (before.branch == last.branch
                || self.openings.last().is_none_or(|opening| *opening <= before.from))
        {
            let joined = Choice { from: before.from, branch: last.branch };
            self.choices.truncate(self.choices.len() - 2);
            let _ = self.choices.push(joined);
            self.before = None;
            self.revision = self.revision.wrapping_add(1);
        }
    }

    /// Forgets the openings that lie ahead of the head again, which is at `way`.
    pub fn come_back(&mut self, way: Metres) {
        while let Some(passed) = self.openings.last().copied().filter(|last| way <= *last - BEFORE)
        {
            self.openings.pop();
            self.came_back = Some(passed);
        }
    }

    /// Notes where the head at `way` saw the tunnel open last. The first opening behind the place at which
    /// the choice changed tells how far that place may be moved.
    fn pass(&mut self, way: Metres, opened: Option<Metres>) {
        self.come_back(way);
        if opened != self.told {
            (self.told, self.ahead) = (opened, opened);
        }
        // Tail first, too, the tunnel opens; but then the head has not passed that place.
        self.ahead = self.ahead.filter(|at| *at - way < TREMBLES);
        let Some(behind) = self.ahead.filter(|at| way - *at > TREMBLES) else { return };
        self.ahead = None;
        if self.openings.last().is_some_and(|last| behind <= *last) {
            return;
        }
        let surplus = usize::from(self.openings.is_full());
        self.openings = gathered(self.openings.iter().skip(surplus).copied());
        let _ = self.openings.push(behind);
        self.came_back = None;
        if let Some(before) = self.before
            && let Some(last) = self.choices.last_mut()
            && behind > last.from
        {
            last.from = Metres(0.5 * (before.0 + behind.0));
            self.before = None;
            self.revision = self.revision.wrapping_add(1);
        }
    }

    /// The way at which the tunnel last opened behind a head at `way`, if the choice that counts there is
    /// another than `branch`. A head that has come back past a junction is to look into another branch of
    /// that one, which lies ahead again, and not of one that is farther back.
    #[must_use]
    pub fn passed_otherwise(&self, way: Metres, branch: Branch) -> Option<Metres> {
        let last = self.openings.last().copied()?;
        let is_same = |passed: Metres| passed - last <= JUNCTION;
        let is_behind = last - BEFORE < way && self.came_back.is_none_or(is_same);
        // A choice counts until the head has flown back from it by more than an odometer trembles.
        let chosen = self.branch_at(way + BACK);
        (is_behind && chosen != Some(branch)).then_some(last)
    }

    /// Takes the way from which on the list differs from the one before, once.
    pub const fn take_change(&mut self) -> Option<Metres> {
        self.changed_from.take()
    }

    /// The choice that counts at `way`.
    #[must_use]
    pub fn branch_at(&self, way: Metres) -> Option<Branch> {
        branch_at(&self.choices, way)
    }

    /// Takes one entry of a list from a drone that is nearer to the head. The list is replaced when
    /// the last entry of a newer one has come.
    pub fn hear(&mut self, post: Signpost) {
        let Signpost { revision, index, count, from, branch } = post;
        let is_sound = index < count && usize::from(count) <= SIGNPOSTS && from.0.is_finite();
        let is_newer = self.choices.is_empty() || newer(revision, self.revision);
        if !is_sound || !is_newer {
            return;
        }
        let mut list =
            self.incoming.filter(|list| (list.revision, list.count) == (revision, count));
        let list = list.get_or_insert(Incoming { revision, count, entries: [None; SIGNPOSTS] });
        if let Some(entry) = list.entries.get_mut(usize::from(index)) {
            *entry = Some(Choice { from, branch });
        }
        let known = || list.entries.iter().take(usize::from(count)).copied();
        if known().all(|entry| entry.is_some()) {
            let before = core::mem::replace(&mut self.choices, gathered(known().flatten()));
            self.changed_from = earlier(self.changed_from, self.differs_from(&before));
            self.revision = revision;
            self.incoming = None;
        } else {
            self.incoming = Some(*list);
        }
    }

    /// The least way from which on the list differs from another one, if they differ.
    fn differs_from(&self, other: &[Choice]) -> Option<Metres> {
        let start = Metres(f32::NEG_INFINITY);
        let places = self.choices.iter().chain(other).map(|choice| choice.from);
        let differs = |way: &Metres| self.branch_at(*way) != branch_at(other, *way);
        core::iter::once(start)
            .chain(places)
            .filter(differs)
            .fold(None, |least, way| earlier(least, Some(way)))
    }

    /// The entry for the next report; `None` without any choice.
    pub fn say(&mut self) -> Option<Signpost> {
        let count = self.choices.len() as u8;
        let index = if self.next < count { self.next } else { 0 };
        self.next = index + 1;
        let Choice { from, branch } = *self.choices.get(usize::from(index))?;
        Some(Signpost { revision: self.revision, index, count, from, branch })
    }
}

/// The choice of this list that counts at `way`.
fn branch_at(choices: &[Choice], way: Metres) -> Option<Branch> {
    let passed = choices.iter().take_while(|choice| choice.from <= way);
    // Before the first place, too, the first choice counts.
    passed.last().or(choices.first())?.branch
}

/// The lesser of two ways.
fn earlier(a: Option<Metres>, b: Option<Metres>) -> Option<Metres> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b < a { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// A list of as many of these entries as there is room for.
fn gathered<T, const N: usize>(entries: impl Iterator<Item = T>) -> Vec<T, N> {
    let mut list = Vec::new();
    // Collecting them would link a panic.
    entries.for_each(|entry| _ = list.push(entry));
    list
}

/// Whether `a` comes after `b` on the circle of revisions.
const fn newer(a: u8, b: u8) -> bool {
    let ahead = a.wrapping_sub(b);
    ahead != 0 && ahead < 0x80
}
