//! A cell for the latest value, by which the tasks exchange values.
//!
//! Writing replaces the value, read or not. Neither writing nor reading waits.

use core::cell::Cell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;

/// A cell for the latest value. Each access copies the value with all interrupts off.
pub(crate) struct Latest<T>(Mutex<CriticalSectionRawMutex, Cell<T>>);

impl<T: Copy> Latest<T> {
    /// A cell that holds `value` until it is set.
    pub(crate) const fn new(value: T) -> Self {
        Self(Mutex::new(Cell::new(value)))
    }

    /// The latest value.
    pub(crate) fn get(&self) -> T {
        self.0.lock(Cell::get)
    }

    /// Replaces the value.
    pub(crate) fn set(&self, value: T) {
        self.0.lock(|cell| cell.set(value));
    }
}

impl<T: Copy> Latest<Option<T>> {
    /// Takes the latest value, if it was not taken yet.
    pub(crate) fn take(&self) -> Option<T> {
        self.0.lock(Cell::take)
    }
}
