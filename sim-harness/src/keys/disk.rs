//! Writes files that only their owner may read, each whole or not at all, one command at a time.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use crate::input_error::InputError;

/// The operations on a disk, step by step, so that a test can stop after each.
pub(super) trait Disk {
    /// Whether a file of this name exists.
    fn exists(&self, path: &Path) -> bool;
    /// Makes an empty file that only its owner may read; a file of this name is replaced.
    fn create(&mut self, path: &Path) -> io::Result<()>;
    /// Writes `bytes` into the file.
    fn write(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()>;
    /// Returns when the contents of the file would survive a power cut.
    fn sync(&mut self, path: &Path) -> io::Result<()>;
    /// Renames the file; a file of the new name is replaced.
    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()>;
    /// Returns when the names in the folder would survive a power cut.
    fn sync_folder(&mut self, folder: &Path) -> io::Result<()>;
    /// Removes the file, if that is possible.
    fn remove(&mut self, path: &Path);
}

/// The disk of the computer.
pub(super) struct Real;

impl Disk for Real {
    fn exists(&self, path: &Path) -> bool {
        fs::symlink_metadata(path).is_ok()
    }

    fn create(&mut self, path: &Path) -> io::Result<()> {
        let _ = fs::remove_file(path);
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        options.open(path).map(|_| ())
    }

    fn write(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        OpenOptions::new().write(true).open(path)?.write_all(bytes)
    }

    fn sync(&mut self, path: &Path) -> io::Result<()> {
        OpenOptions::new().write(true).open(path)?.sync_all()
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn sync_folder(&mut self, folder: &Path) -> io::Result<()> {
        // Elsewhere a folder cannot be opened, and need not be.
        if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
    }

    fn remove(&mut self, path: &Path) {
        let _ = fs::remove_file(path);
    }
}

/// A file that is being written, under a name of its own until it is whole.
#[must_use]
pub(super) struct Draft {
    path: PathBuf,
    unfinished: PathBuf,
}

impl Draft {
    pub(super) fn begin(disk: &mut impl Disk, path: &Path) -> Result<Self, InputError> {
        let name = path.file_name().ok_or_else(|| {
            InputError::new("this is no name for a file", "give a file").in_file(path)
        })?;
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.unfinished", std::process::id()));
        let draft = Self { path: path.to_owned(), unfinished: folder(path).join(hidden) };
        match disk.create(&draft.unfinished) {
            Ok(()) => Ok(draft),
            Err(error) => Err(unusable(path, &error)),
        }
    }

    pub(super) fn finish(self, disk: &mut impl Disk, bytes: &[u8]) -> Result<(), InputError> {
        let written = disk
            .write(&self.unfinished, bytes)
            .and_then(|()| disk.sync(&self.unfinished))
            .and_then(|()| disk.rename(&self.unfinished, &self.path))
            .and_then(|()| disk.sync_folder(folder(&self.path)));
        written.map_err(|error| {
            let complaint = unusable(&self.path, &error);
            self.abandon(disk);
            complaint
        })
    }

    pub(super) fn abandon(self, disk: &mut impl Disk) {
        disk.remove(&self.unfinished);
    }
}

/// Writes a file, or leaves the one that is there as it is.
pub(super) fn replace(disk: &mut impl Disk, path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    Draft::begin(disk, path)?.finish(disk, bytes)
}

/// The folder that a file is in.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A key file is some kilobytes; what is much larger is something else.
const LARGEST: u64 = 64 * 1024;

/// The text of a file, if its owner alone may read it.
pub(super) fn read_private(path: &Path) -> Result<String, InputError> {
    let unreadable = |error: &dyn std::fmt::Display| {
        InputError::new(
            format!("cannot be read: {error}"),
            "give a file that uchain keys new has made",
        )
        .in_file(path)
    };
    // Before it is opened: opening a pipe would wait for its other end.
    if !fs::metadata(path).map_err(|error| unreadable(&error))?.is_file() {
        return Err(unreadable(&"it is not a file"));
    }
    let file = File::open(path).map_err(|error| unreadable(&error))?;
    #[cfg(unix)]
    {
        let about = file.metadata().map_err(|error| unreadable(&error))?;
        let mode = std::os::unix::fs::MetadataExt::mode(&about) & 0o777;
        if mode & 0o077 != 0 {
            return Err(InputError::new(
                format!("others than you may read or change this (its mode is {mode:03o})"),
                format!("run: chmod 600 {}", super::quoted(path)),
            )
            .in_file(path));
        }
    }
    let mut text = String::new();
    file.take(LARGEST).read_to_string(&mut text).map_err(|error| unreadable(&error))?;
    Ok(text)
}

/// The file itself where `path` is a link to it: replacing the link would leave two.
pub(super) fn followed(path: &Path) -> Result<PathBuf, InputError> {
    let metadata = fs::symlink_metadata(path);
    if !metadata.is_ok_and(|metadata| metadata.is_symlink()) {
        return Ok(path.to_owned());
    }
    fs::canonicalize(path).map_err(|error| unusable(path, &error))
}

fn unusable(path: &Path, error: &io::Error) -> InputError {
    InputError::new(
        format!("cannot be written: {error}"),
        "give a place where you may write, with room on the disk",
    )
    .in_file(path)
}

/// Holds off every other command on files in the same folder, until it is dropped.
pub(super) struct Lock {
    _folder: Option<File>,
}

impl Lock {
    /// For how long another command may be at work: many times what one takes.
    const TRIES: u32 = 100;
    const PAUSE: Duration = Duration::from_millis(50);

    /// The folder's, since the file is another one each time that it is replaced.
    pub(super) fn of(path: &Path) -> Result<Self, InputError> {
        if !cfg!(unix) {
            return Ok(Self { _folder: None });
        }
        let folder = folder(path);
        let file = File::open(folder).map_err(|error| unusable(path, &error))?;
        for _ in 0..Self::TRIES {
            match file.try_lock() {
                Ok(()) => return Ok(Self { _folder: Some(file) }),
                Err(TryLockError::WouldBlock) => sleep(Self::PAUSE),
                Err(TryLockError::Error(error)) => return Err(unusable(folder, &error)),
            }
        }
        Err(InputError::new(
            "another command is at work in this folder",
            "try again when it is done",
        )
        .in_file(folder))
    }
}
