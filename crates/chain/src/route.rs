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

use heapless::Vec;
use units::{Branch, Metres, SIGNPOSTS, Signpost};

/// How far the head must fly back from a place before what the pilot chose there is forgotten: an
/// odometer trembles by centimetres while the head hovers.
const BACK: Metres = Metres(0.5);

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
    /// The way at which the head passed its last junction.
    junction: Option<Metres>,
    /// The junction before the place at which the choice changed last, until the next one is passed.
    before: Option<Metres>,
    /// A list of which some entries have come.
    incoming: Option<Incoming>,
    /// The number of the entry that the next report has.
    next: u8,
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
            junction: None,
            before: None,
            incoming: None,
            next: 0,
        }
    }

    /// Notes at the head that the pilot's choice is `branch` while the head is at `way`, and where it
    /// has passed its last junction.
    pub fn lead(&mut self, way: Metres, branch: Option<Branch>, junction: Option<Metres>) {
        if !way.0.is_finite() {
            return;
        }
        self.pass(junction);
        // The head has flown back past a place: what it chose there no longer leads to it.
        while let [_, .., last] = self.choices.as_slice()
            && way < last.from - BACK
        {
            self.choices.pop();
            self.before = None;
            self.revision = self.revision.wrapping_add(1);
        }
        let chosen = self.choices.last().map(|last| last.branch);
        if chosen == Some(branch) || (chosen.is_none() && branch.is_none()) {
            return;
        }
        self.before = Some(self.junction.filter(|junction| *junction < way).unwrap_or(way));
        let surplus = usize::from(self.choices.is_full());
        self.choices = gathered(self.choices.iter().skip(surplus).copied());
        // There is room: of a full list the oldest entry was left out.
        let _ = self.choices.push(Choice { from: way, branch });
        self.revision = self.revision.wrapping_add(1);
    }

    /// Notes the last junction that the head has passed. The first one behind the place at which the
    /// choice changed tells how far that place may be moved.
    fn pass(&mut self, junction: Option<Metres>) {
        if junction == self.junction {
            return;
        }
        self.junction = junction;
        if let (Some(behind), Some(before)) = (junction, self.before)
            && let Some(last) = self.choices.last_mut()
            && behind > last.from
        {
            last.from = Metres(0.5 * (before.0 + behind.0));
            self.before = None;
            self.revision = self.revision.wrapping_add(1);
        }
    }

    /// The choice that counts at `way`.
    #[must_use]
    pub fn branch_at(&self, way: Metres) -> Option<Branch> {
        let passed = self.choices.iter().take_while(|choice| choice.from <= way);
        // Before the first place, too, the first choice counts.
        passed.last().or(self.choices.first())?.branch
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
            (self.choices, self.revision) = (gathered(known().flatten()), revision);
            self.incoming = None;
        } else {
            self.incoming = Some(*list);
        }
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

/// A list of as many of these choices as there is room for.
fn gathered(choices: impl Iterator<Item = Choice>) -> Vec<Choice, SIGNPOSTS> {
    let mut list = Vec::new();
    // Collecting them would link a panic.
    choices.for_each(|choice| _ = list.push(choice));
    list
}

/// Whether `a` comes after `b` on the circle of revisions.
const fn newer(a: u8, b: u8) -> bool {
    let ahead = a.wrapping_sub(b);
    ahead != 0 && ahead < 0x80
}
