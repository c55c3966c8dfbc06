//! A place for the latest value of something: how the tasks talk to each other.
//!
//! Whoever writes never waits for who reads, nor the other way round. What nobody has read is
//! replaced.

use core::cell::Cell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;

/// The place. A cell, which cannot be borrowed twice, behind a pause of all interrupts, for no
/// longer than a copy takes.
pub(crate) struct Latest<T>(Mutex<CriticalSectionRawMutex, Cell<T>>);

impl<T: Copy> Latest<T> {
    /// Holding `value` until something later comes.
    pub(crate) const fn new(value: T) -> Self {
        Self(Mutex::new(Cell::new(value)))
    }

    /// The latest value.
    pub(crate) fn get(&self) -> T {
        self.0.lock(Cell::get)
    }

    /// A later one.
    pub(crate) fn set(&self, value: T) {
        self.0.lock(|cell| cell.set(value));
    }
}

impl<T: Copy> Latest<Option<T>> {
    /// The latest value, if nobody has taken it yet.
    pub(crate) fn take(&self) -> Option<T> {
        self.0.lock(Cell::take)
    }
}
