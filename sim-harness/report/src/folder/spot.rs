//! Finds where the temporary directory and the lock of a directory lie.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use input::InputError;

use super::lock::Lock;
use super::unusable;

/// The end of the name of a temporary directory.
const UNFINISHED: &str = ".unfinished-results";
/// The end of the name of a lock.
const LOCK: &str = ".uchain-lock";

/// Where the temporary directory of a directory lies.
pub(super) struct Spot {
    folder: PathBuf,
    /// What the names there begin with.
    stem: String,
    /// Whether it lies beside the directory, which can then be replaced as a whole.
    pub(super) is_beside: bool,
    /// The directory itself, without links, where it exists.
    pub(super) target: PathBuf,
}

impl Spot {
    /// Finds it, beside the directory if possible, and takes the lock.
    pub(super) fn find(target: &Path) -> Result<(Self, Lock), InputError> {
        let taken = |lock: Option<Lock>| lock.ok_or_else(|| busy(target));
        if !target.is_dir() {
            let spot = Self::of_missing(target);
            let lock = Lock::take(&spot.lock()).map_err(|error| unusable(target, &error))?;
            return Ok((spot, taken(lock)?));
        }
        let within = Self::within(target);
        if let Some(spot) = Self::beside(target)
            && let Ok(lock) = Lock::take(&spot.lock())
        {
            let spot = if is_exchangeable(&spot.target) { spot } else { within };
            return Ok((spot, taken(lock)?));
        }
        let lock = Lock::take(&within.lock()).map_err(|error| unusable(target, &error))?;
        Ok((within, taken(lock)?))
    }

    /// The place for a directory that is to be made: in the nearest directory above that exists.
    fn of_missing(target: &Path) -> Self {
        let folder = existing_parent(target);
        let below = target.strip_prefix(&folder).unwrap_or(target);
        let parts: Vec<_> = below.iter().map(OsStr::to_string_lossy).collect();
        let stem = format!(".{}", parts.join("-"));
        Self { folder, stem, is_beside: true, target: target.to_owned() }
    }

    /// The place beside a directory that exists.
    fn beside(target: &Path) -> Option<Self> {
        let target = target.canonicalize().ok()?;
        let (folder, name) = (target.parent()?.to_owned(), target.file_name()?.to_string_lossy());
        let stem = format!(".{name}");
        Some(Self { folder, stem, is_beside: true, target })
    }

    /// The place in a directory that exists.
    fn within(target: &Path) -> Self {
        let folder = target.to_owned();
        Self { folder, stem: String::new(), is_beside: false, target: target.to_owned() }
    }

    /// The temporary directory.
    pub(super) fn staging(&self) -> PathBuf {
        self.folder.join(format!("{}{UNFINISHED}", self.stem))
    }

    fn lock(&self) -> PathBuf {
        self.folder.join(format!("{}{LOCK}", self.stem))
    }
}

/// Whether a name within a directory is that of a temporary directory or of a lock.
pub(super) fn is_temporary(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    name.starts_with(".unfinished-") || name == LOCK
}

fn busy(target: &Path) -> InputError {
    let wrong = "another uchain is writing into this directory";
    InputError::new(wrong, "wait until it has ended, or give --out another directory")
        .in_file(target)
}

/// Whether another directory can take the place of one: it is not the root of a file system, and no
/// working directory of this command lies in it.
fn is_exchangeable(target: &Path) -> bool {
    let works_there = std::env::current_dir().is_ok_and(|here| here.starts_with(target));
    !works_there && target.parent().is_some_and(|above| is_one_file_system(above, target))
}

#[cfg(unix)]
fn is_one_file_system(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |path| fs::metadata(path).map(|found| found.dev()).ok();
    number(one).is_some() && number(one) == number(other)
}

#[cfg(not(unix))]
fn is_one_file_system(one: &Path, other: &Path) -> bool {
    fs::metadata(one).is_ok() && fs::metadata(other).is_ok()
}

/// The nearest directory above a path that exists.
fn existing_parent(path: &Path) -> PathBuf {
    let above = path.ancestors().skip(1).find(|above| above.is_dir());
    above.filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned()
}
