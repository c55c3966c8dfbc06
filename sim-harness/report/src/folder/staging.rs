//! The temporary directory that a command fills.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::list::{self, Kind};
use super::lock::Lock;
use super::place;
use super::spot::Spot;

/// The temporary directory of a [`Folder`](super::Folder), which a handler of Ctrl-C can hold, too.
#[derive(Clone)]
pub struct Staging(Arc<Mutex<Option<Held>>>);

/// A temporary directory and the lock that it is filled under.
struct Held {
    path: PathBuf,
    _lock: Lock,
}

impl Staging {
    /// Makes the directory, after what a killed command has left there is removed.
    pub(super) fn make(spot: &Spot, lock: Lock) -> io::Result<Self> {
        let path = spot.staging();
        clear(&path, spot)?;
        fs::create_dir(&path)?;
        list::mark_unfinished(&path)?;
        Ok(Self(Arc::new(Mutex::new(Some(Held { path, _lock: lock })))))
    }

    fn held(&self) -> MutexGuard<'_, Option<Held>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does something with the directory, unless it was discarded. Until it is done, the
    /// directory is not discarded.
    pub(super) fn with<T>(&self, act: impl FnOnce(&Path) -> io::Result<T>) -> io::Result<T> {
        let held = self.held();
        held.as_ref().map_or_else(|| Err(io::ErrorKind::Interrupted.into()), |it| act(&it.path))
    }

    /// Puts the directory in its place; it is no longer a temporary one where that succeeds.
    pub(super) fn place(&self, act: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
        let mut held = self.held();
        let Some(it) = held.as_ref() else { return Err(io::ErrorKind::Interrupted.into()) };
        act(&it.path)?;
        *held = None;
        Ok(())
    }

    /// Removes the directory with all that is in it, unless that was done before.
    pub fn discard(&self) {
        remove(&mut self.held());
    }

    /// Removes the directory, and stops the thread that fills it at its next file: for a handler
    /// that ends the process. Returns whether there was anything to remove.
    #[must_use]
    pub fn discard_at_exit(&self) -> bool {
        let mut held = self.held();
        let removed = remove(&mut held);
        // The lock is never given back.
        std::mem::forget(held);
        removed
    }
}

fn remove(held: &mut Option<Held>) -> bool {
    // There is nothing else to be done about a directory that cannot be removed.
    held.take().is_some_and(|it| fs::remove_dir_all(&it.path).is_ok())
}

/// Removes what a killed command has left.
fn clear(path: &Path, spot: &Spot) -> io::Result<()> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error),
        Ok(found) if !found.is_dir() => return Ok(()),
        Ok(_) => {}
    }
    match Kind::of(path) {
        Kind::Unfinished => fs::remove_dir_all(path),
        // The directory that was replaced when the command was killed, or the new one before it.
        Kind::Written(list) => {
            place::clear_former(path, &spot.target, &list);
            match path.exists() {
                true => fs::remove_dir(path),
                false => Ok(()),
            }
        }
        // Only an empty one can be removed.
        Kind::Foreign => fs::remove_dir(path),
    }
}
