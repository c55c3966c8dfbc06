//! Looks at a chain while its head is to stand still: what its relays fly, and how its links swing.

use units::Db;

use bodies::Body;
use scenario::Stretch;

/// A link swings by as much as it changes within this time, rounds of 0.2 s: as in
/// [`metrics`](measure::metrics).
const SWING_ROUNDS: usize = 50;
/// The share of all swings that are no larger than the one that counts.
const SHARE: f32 = 0.95;

/// What is seen of a chain in its hold.
pub(super) struct Rest {
    hold: Option<Stretch>,
    /// Where each member was in the last round of the hold.
    last: Vec<Option<units::Point2>>,
    flown_m: Vec<f32>,
    /// The links' losses by their ends, in order of time.
    losses: Vec<([u8; 2], Vec<f32>)>,
    relays: Option<usize>,
}

impl Rest {
    pub(super) fn of(hold: Option<Stretch>, members: usize) -> Self {
        Self {
            hold,
            last: vec![None; members],
            flown_m: vec![0.0; members],
            losses: Vec::new(),
            relays: None,
        }
    }

    /// Takes in the chain's links and the members' places at the end of a round.
    pub(super) fn look<'a>(
        &mut self,
        now_us: u64,
        links: &[([u8; 2], Db)],
        bodies: impl Iterator<Item = &'a Body>,
    ) {
        let Some(hold) = self.hold else { return };
        if !(hold.from_us < now_us && now_us <= hold.until_us) {
            return;
        }
        for ((last, flown), body) in self.last.iter_mut().zip(&mut self.flown_m).zip(bodies) {
            let at = body.position();
            if let Some(last) = last.filter(|_| body.height() > 0.0) {
                *flown += last.distance(at).0;
            }
            *last = Some(at);
        }
        self.relays = Some(links.len().saturating_sub(1));
        // The swing is that of the chain at rest: the second half of the hold.
        if now_us < hold.from_us.midpoint(hold.until_us) {
            return;
        }
        for (ends, loss) in links {
            match self.losses.iter_mut().find(|(known, _)| known == ends) {
                Some((_, losses)) => losses.push(loss.0),
                None => self.losses.push((*ends, vec![loss.0])),
            }
        }
    }

    /// The relays in the chain at the end of the hold.
    pub(super) const fn relays(&self) -> Option<usize> {
        self.relays
    }

    /// What a relay flew in the hold, mean over those that flew at all, m.
    pub(super) fn path_m(&self) -> f32 {
        let flown = self.flown_m.iter().skip(1).filter(|flown| **flown > 0.0);
        let (count, sum) = flown.fold((0, 0.0), |(count, sum), flown| (count + 1, sum + flown));
        if count == 0 { f32::NAN } else { sum / count as f32 }
    }

    /// The swing of a link within 10 s that 95 % of all links and moments do not exceed, dB.
    pub(super) fn swing_db(&self) -> f32 {
        let windows = self.losses.iter().flat_map(|(_, losses)| losses.windows(SWING_ROUNDS));
        let swing = |window: &[f32]| {
            let most = window.iter().copied().fold(f32::MIN, f32::max);
            most - window.iter().copied().fold(f32::MAX, f32::min)
        };
        let mut swings: Vec<f32> = windows.map(swing).collect();
        swings.sort_by(f32::total_cmp);
        let at = (SHARE * swings.len() as f32).ceil() as usize;
        swings.get(at.saturating_sub(1)).copied().unwrap_or(f32::NAN)
    }
}
