//! What is on the air, and which receivers it keeps from what else.
//!
//! A receiver that has found the address of a packet stays with this packet until its end, whatever
//! comes meanwhile: the radio looks for an address only after it was started, and the chip's program
//! starts it anew at the end of a packet (crazyflie2-nrf-firmware, `esb.c`: `esbInterruptHandler`).
//! So a packet that begins later is lost there, however strong it is; and where it is strong, the
//! first one is lost with it.

use units::{Db, Dbm};
use wire::radio::timing::{LISTENS_AFTER_US, RAMP_UP_US};
use wire::syslink::MAX_P2P;

use super::{Ether, Loss};

/// The most stations of a medium: bits of [`Transmission::locked`].
pub(super) const MOST_STATIONS: usize = 64;

/// A packet or a carrier on the air.
#[derive(Clone, Copy)]
pub(super) struct Transmission {
    pub(super) from: usize,
    pub(super) start_us: u64,
    pub(super) end_us: u64,
    /// When a receiver has found the packet's address. A carrier has none.
    address_us: Option<u64>,
    /// Whether it is a packet that has not come to its end.
    pub(super) waits: bool,
    pub(super) cut: bool,
    /// Bit `n` is set when the receiver of station `n` has found the packet's address; `None` before
    /// that was decided.
    locked: Option<u64>,
    pub(super) length: usize,
    pub(super) data: [u8; MAX_P2P],
}

impl Transmission {
    /// A carrier without a packet.
    pub(super) const fn carrier(from: usize, start_us: u64, end_us: u64) -> Self {
        Self {
            from,
            start_us,
            end_us,
            address_us: None,
            waits: false,
            cut: false,
            locked: None,
            length: 0,
            data: [0; MAX_P2P],
        }
    }

    /// A packet whose address is over after `address_us`.
    pub(super) fn packet(
        from: usize,
        (start_us, address_us, end_us): (u64, u64, u64),
        data: &[u8],
    ) -> Self {
        let mut bytes = [0; MAX_P2P];
        let length = data.len().min(MAX_P2P);
        bytes[..length].copy_from_slice(&data[..length]);
        Self {
            address_us: Some(address_us),
            waits: true,
            length,
            data: bytes,
            ..Self::carrier(from, start_us, end_us)
        }
    }

    pub(super) const fn overlaps(&self, from_us: u64, until_us: u64) -> bool {
        self.start_us < until_us && from_us < self.end_us
    }

    /// Whether the radio of the sender is deaf at any time between these two: while it turns round,
    /// sends, and turns round again.
    const fn deafens(&self, from_us: u64, until_us: u64) -> bool {
        self.overlaps(from_us.saturating_sub(LISTENS_AFTER_US), until_us + RAMP_UP_US)
    }
}

/// All that is on the air.
#[derive(Default)]
pub(super) struct OnAir(Vec<Transmission>);

impl OnAir {
    /// Puts a packet or a carrier on the air. A packet of the same sender is cut off.
    pub(super) fn put(&mut self, on: Transmission) {
        for own in self.0.iter_mut().filter(|other| other.from == on.from && other.waits) {
            if on.waits && own.overlaps(on.start_us, on.end_us) {
                own.cut = true;
                own.end_us = on.start_us;
            }
        }
        self.0.push(on);
    }

    /// When the next packet comes to its end.
    pub(super) fn next_end_us(&self) -> Option<u64> {
        self.0.iter().filter(|on| on.waits).map(|on| on.end_us).min()
    }

    /// Takes the packet that comes to its end now, and says whether others contest it: another
    /// packet at the same time, or one for which a radio turns round.
    pub(super) fn end(&mut self, now_us: u64) -> Option<(usize, Transmission, bool)> {
        let at = self.0.iter().position(|on| on.waits && on.end_us == now_us)?;
        let packet = self.0[at];
        let mut others = self.others(at);
        let is_contested = others.any(|other| other.deafens(packet.start_us, packet.end_us));
        drop(others);
        self.0[at].waits = false;
        Some((at, packet, is_contested))
    }

    fn others(&self, at: usize) -> impl Iterator<Item = &Transmission> {
        self.0.iter().enumerate().filter(move |(n, _)| *n != at).map(|(_, other)| other)
    }

    /// Decides which receivers have found the address of the packet at place `at`, and of those that
    /// began before it.
    pub(super) fn settle(
        &mut self,
        at: usize,
        (stations, capture): (usize, Db),
        ether: &mut impl Ether,
        reaches: impl Fn(Dbm) -> bool,
    ) {
        let until_us = self.0[at].start_us;
        loop {
            let open = self.0.iter().enumerate().filter(|(_, on)| {
                on.address_us.is_some() && on.locked.is_none() && on.start_us <= until_us
            });
            let Some((first, _)) = open.min_by_key(|(n, on)| (on.start_us, *n)) else { return };
            let locked = (0..stations.min(MOST_STATIONS))
                .filter(|&to| self.locks(first, to, capture, ether, &reaches))
                .fold(0, |bits, to| bits | 1 << to);
            self.0[first].locked = Some(locked);
        }
    }

    /// Whether the receiver of `to` finds the address of the packet at place `at`, where that of all
    /// earlier ones is decided.
    fn locks(
        &self,
        at: usize,
        to: usize,
        capture: Db,
        ether: &mut impl Ether,
        reaches: impl Fn(Dbm) -> bool,
    ) -> bool {
        let packet = &self.0[at];
        let Some(address_us) = packet.address_us.filter(|_| packet.from != to) else {
            return false;
        };
        let strength = ether.strength(packet.from, to).filter(|&strength| reaches(strength));
        let Some(strength) = strength else { return false };
        self.others(at).all(|other| {
            let has_it = other.locked.is_some_and(|bits| bits & 1 << to != 0);
            if has_it && other.start_us <= packet.start_us && other.end_us > packet.start_us {
                return false;
            }
            if other.from == to {
                return !other.deafens(packet.start_us, address_us);
            }
            let drowns = |against: Dbm| strength - against < capture;
            !other.overlaps(packet.start_us, address_us)
                || !ether.strength(other.from, to).is_some_and(drowns)
        })
    }

    /// Whether a packet is lost at one receiver to what else is on the air.
    pub(super) fn contest(
        &self,
        at: usize,
        to: usize,
        (strength, capture): (Dbm, Db),
        ether: &mut impl Ether,
    ) -> Result<(), Loss> {
        let Transmission { start_us, end_us, locked, .. } = self.0[at];
        for other in self.others(at) {
            if other.from == to {
                if other.deafens(start_us, end_us) {
                    return Err(Loss::Deaf);
                }
            } else if other.overlaps(start_us, end_us)
                && let Some(against) = ether.strength(other.from, to)
                && strength - against < capture
            {
                return Err(Loss::Collision);
            }
        }
        let found = locked.is_none_or(|bits| bits & 1 << to != 0);
        if found { Ok(()) } else { Err(Loss::Collision) }
    }

    /// Forgets what was over before any packet that has not come to its end began.
    pub(super) fn forget(&mut self, now_us: u64) {
        let waiting = self.0.iter().filter(|on| on.waits);
        let first_us = waiting.map(|on| on.start_us).fold(now_us, u64::min);
        let first_us = first_us.saturating_sub(LISTENS_AFTER_US);
        self.0.retain(|on| on.waits || on.end_us > first_us);
    }
}
