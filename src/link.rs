//! The drone's end of the chain's link, which the tasks of the thread share.
//!
//! They need no lock for it: one executor runs them, one at a time, and nobody waits while it has
//! the link in its hands. So what takes long in it, encrypting and checking, is done with all
//! interrupts on, and delays no control step.

use core::cell::{Cell, RefCell};

use airlink::keys::Keys;
use airlink::{Airlink, Counters, Identity, LinkConfig, Schedule, Sealed, Status};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use static_cell::StaticCell;
use units::Instant;
use wire::p2p::Epoch;

use crate::store::{self, KeysState};

/// What it takes to speak.
pub(crate) struct Credentials {
    pub(crate) identity: Identity,
    pub(crate) keys: Keys,
    pub(crate) epoch: Epoch,
    pub(crate) schedule: Schedule,
}

/// Whether the drone is part of a chain, or could be.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub(crate) enum Standing {
    /// It is, or listens for one.
    Fine,
    /// It was never provisioned.
    NoKeys,
    /// It was, but may not speak: [`store::keys_state`] says why.
    Shut,
    /// The chain has refused it, or it has left, or it has no number for another packet:
    /// [`Link::status`].
    Out,
}

type End = RefCell<Airlink<Sealed>>;

/// Too large for a stack; here the linker accounts for it.
static END: StaticCell<End> = StaticCell::new();

/// The link: shut until [`crate::store`] has the keys and an epoch to use them in.
pub(crate) struct Link {
    end: Cell<Option<&'static End>>,
    news: Signal<NoopRawMutex, ()>,
}

impl Link {
    pub(crate) const fn new() -> Self {
        Self { end: Cell::new(None), news: Signal::new() }
    }

    /// Opens it, once.
    pub(crate) fn open(&self, with: Credentials, now: Instant) {
        let Credentials { identity, keys, epoch, schedule } = with;
        let end = END.try_init_with(|| {
            let seal = Sealed::new(keys);
            RefCell::new(Airlink::new(LinkConfig::DEFAULT, identity, seal, epoch, schedule, now))
        });
        if let Some(end) = end {
            self.end.set(Some(end));
            self.news.signal(());
        }
    }

    /// Does something with the link, unless it is shut.
    pub(crate) fn with<R>(&self, act: impl FnOnce(&mut Airlink<Sealed>) -> R) -> Option<R> {
        // It is in nobody's hands now: see above.
        self.end.get()?.try_borrow_mut().ok().map(|mut end| act(&mut end))
    }

    /// The same, for what may give the sending task something to send.
    pub(crate) fn tell<R>(&self, act: impl FnOnce(&mut Airlink<Sealed>) -> R) -> Option<R> {
        let result = self.with(act);
        self.news.signal(());
        result
    }

    /// Waits for [`tell`](Self::tell). One task does.
    pub(crate) async fn news(&self) {
        self.news.wait().await;
    }

    /// When there is something to send, if there is.
    pub(crate) fn due(&self) -> Option<Instant> {
        self.with(|end| end.due()).flatten()
    }

    /// How it stands with the chain; `None` while it is shut.
    pub(crate) fn status(&self) -> Option<Status> {
        self.with(|end| end.status())
    }

    /// Whether the drone may take part.
    pub(crate) fn standing(&self) -> Standing {
        use airlink::Standing::{Exhausted, Left, Listening, Member, Refused};
        match (self.status().map(|status| status.standing), store::keys_state()) {
            (Some(Listening | Member), _) => Standing::Fine,
            (Some(Refused | Left | Exhausted), _) => Standing::Out,
            (None, KeysState::Unread | KeysState::Missing) => Standing::NoKeys,
            (None, KeysState::Held { .. } | KeysState::Shut(_)) => Standing::Shut,
        }
    }

    /// What it has counted; `None` while it is shut.
    pub(crate) fn counters(&self) -> Option<Counters> {
        self.with(|end| end.counters())
    }
}
