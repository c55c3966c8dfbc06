//! Wraps the drone's end of the radio link, which is shut until the drone has keys and an epoch.

use airlink::{Airlink, Refused, Seal, Standing};
use crtp::LinkState;
use units::{Instant, Order};
use wire::p2p::Counter;

/// The drone's end of the radio link.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one, for ever, and no heap")]
pub(crate) enum Link<S> {
    /// The drone was never provisioned, or its memory has not been read yet.
    NoKeys,
    /// The drone was provisioned, but must not transmit.
    Shut,
    /// The drone may transmit.
    Open(Airlink<S>),
}

/// Whether a drone is part of a chain, or could be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LinkHealth {
    /// The drone takes part, or listens for others.
    Fine,
    /// The drone has no keys.
    NoKeys,
    /// The drone has keys that it cannot use.
    Shut,
    /// Another drone keeps this one's number, or the drone has left the chain, or it has used up
    /// its packet numbers.
    Out,
}

impl<S> Link<S> {
    pub(crate) const fn open(&self) -> Option<&Airlink<S>> {
        match self {
            Self::NoKeys | Self::Shut => None,
            Self::Open(link) => Some(link),
        }
    }

    pub(crate) const fn open_mut(&mut self) -> Option<&mut Airlink<S>> {
        match self {
            Self::NoKeys | Self::Shut => None,
            Self::Open(link) => Some(link),
        }
    }
}

impl<S: Seal> Link<S> {
    /// Gives an order to the whole mission; returns whether it stands.
    pub(crate) fn order(&mut self, now: Instant, order: Order) -> bool {
        self.open_mut().is_some_and(|link| link.order(now, order))
    }

    pub(crate) fn health(&self) -> LinkHealth {
        match self {
            Self::NoKeys => LinkHealth::NoKeys,
            Self::Shut => LinkHealth::Shut,
            Self::Open(link) => match link.status().standing {
                Standing::Listening | Standing::Member => LinkHealth::Fine,
                Standing::Refused | Standing::Left | Standing::Exhausted => LinkHealth::Out,
            },
        }
    }

    /// The link's log variables. `orders` is the number of orders that came in.
    pub(crate) fn told(&self, orders: u32) -> crtp::Link {
        let Some(link) = self.open() else { return crtp::Link { orders, ..crtp::Link::SILENT } };
        let counters = link.counters();
        crtp::Link {
            state: match link.status().standing {
                Standing::Listening => LinkState::Listening,
                Standing::Member => LinkState::Member,
                Standing::Refused => LinkState::Refused,
                Standing::Left => LinkState::Off,
                Standing::Exhausted => LinkState::Exhausted,
            },
            accepted: counters.taken.total(),
            refused: total(&counters.refused),
            sent: counters.sent.total(),
            orders,
        }
    }
}

/// The counts of a link wrap.
fn total(refused: &Refused) -> u32 {
    let Refused {
        malformed,
        no_slot,
        tag,
        own,
        twin,
        replayed,
        held,
        stale,
        body,
        forged,
        outdated,
    } = *refused;
    [malformed, no_slot, tag, own, twin, replayed, held, stale, body, forged, outdated]
        .into_iter()
        .fold(0, u32::wrapping_add)
}

/// The orders that a drone has received over its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heeded {
    /// The number of the last one.
    pub(crate) last: Option<Counter>,
    /// The number of orders.
    pub(crate) count: u32,
}

impl Heeded {
    /// No order has come.
    pub(crate) const NONE: Self = Self { last: None, count: 0 };
}
