//! Writes files that only their owner may read, each whole or not at all, one command at a time.
//!
//! A file is written as a draft and then given its name. On Linux the draft has no name where the
//! file system can do that, so that a command which is killed leaves nothing behind. Elsewhere, and
//! for the moment in which a draft takes the place of another file, its name is hidden; the next
//! command in that folder removes such a draft ([`clean`]) unless the command that writes it is
//! still at work, which holds a lock on it.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use input::InputError;
use storage::Record;
use storage::keys::KeysRecord;

use super::fleet::HEADING;

/// The end of the name of a draft, after a dot, the file's name, a dot and the number of a process.
const DRAFT: &str = ".keys-unfinished";
/// The same as versions before wrote it.
const OLD_DRAFT: &str = ".unfinished";

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
#[derive(Default)]
pub(super) struct Real {
    /// The drafts, by the names that they have or would have.
    drafts: BTreeMap<PathBuf, OpenDraft>,
}

/// A draft, which is locked while it is open.
struct OpenDraft {
    file: File,
    is_named: bool,
}

impl OpenDraft {
    /// A draft without a name, where the file system can do that.
    #[cfg(target_os = "linux")]
    fn unnamed(folder: &Path) -> Option<Self> {
        use rustix::fs::{Mode, OFlags, open};
        // Through this folder it gets its name later.
        if !Path::new("/proc/self/fd").is_dir() {
            return None;
        }
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        let file = File::from(open(folder, flags, Mode::RUSR | Mode::WUSR).ok()?);
        Some(Self { file, is_named: false })
    }

    #[cfg(not(target_os = "linux"))]
    fn unnamed(_: &Path) -> Option<Self> {
        None
    }

    fn named(path: &Path) -> io::Result<Self> {
        let _ = fs::remove_file(path);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        Ok(Self { file: options.open(path)?, is_named: true })
    }

    /// Gives a draft without a name one that no file has.
    #[cfg(target_os = "linux")]
    fn name(&self, path: &Path) -> io::Result<()> {
        use std::os::fd::AsRawFd;

        use rustix::fs::{AtFlags, CWD, linkat};
        let itself = format!("/proc/self/fd/{}", self.file.as_raw_fd());
        Ok(linkat(CWD, itself, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
    }

    #[cfg(not(target_os = "linux"))]
    fn name(&self, _: &Path) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }

    /// Gives a draft without a name this hidden one; on a file system that cannot, it is a copy.
    fn hide(&mut self, path: &Path) -> io::Result<()> {
        if self.name(path).is_err() {
            let mut copy = Self::named(path)?;
            copy.file.lock()?;
            self.file.rewind()?;
            io::copy(&mut self.file, &mut copy.file)?;
            copy.file.sync_all()?;
            *self = copy;
        }
        Ok(())
    }
}

impl Real {
    fn draft(&mut self, path: &Path) -> io::Result<&mut OpenDraft> {
        self.drafts.get_mut(path).ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}

impl Disk for Real {
    fn exists(&self, path: &Path) -> bool {
        fs::symlink_metadata(path).is_ok()
    }

    fn create(&mut self, path: &Path) -> io::Result<()> {
        let draft = match OpenDraft::unnamed(folder(path)) {
            Some(draft) => draft,
            None => OpenDraft::named(path)?,
        };
        // Some file systems have no locks: there a draft may be removed under its command, which
        // then fails.
        let _ = draft.file.try_lock();
        self.drafts.insert(path.to_owned(), draft);
        Ok(())
    }

    fn write(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.draft(path)?.file.write_all(bytes)
    }

    fn sync(&mut self, path: &Path) -> io::Result<()> {
        self.draft(path)?.file.sync_all()
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        let draft = self.draft(from)?;
        if !draft.is_named {
            if draft.name(to).is_ok() {
                self.drafts.remove(from);
                return Ok(());
            }
            draft.hide(from)?;
            draft.is_named = true;
        }
        fs::rename(from, to)?;
        self.drafts.remove(from);
        Ok(())
    }

    fn sync_folder(&mut self, folder: &Path) -> io::Result<()> {
        // Elsewhere a folder cannot be opened, and need not be.
        if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
    }

    fn remove(&mut self, path: &Path) {
        if self.drafts.remove(path).is_some_and(|draft| draft.is_named) {
            let _ = fs::remove_file(path);
        }
    }
}

/// Removes the drafts that commands which were killed have left in the folder of this file.
pub(super) fn clean(path: &Path) {
    let Ok(entries) = fs::read_dir(folder(path)) else { return };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && is_left_behind(&entry.path(), &entry.file_name().to_string_lossy()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether a file is a draft that no command is writing.
fn is_left_behind(path: &Path, name: &str) -> bool {
    let ours = has_draft_name(name, DRAFT);
    if !ours && !has_draft_name(name, OLD_DRAFT) {
        return false;
    }
    let Ok(file) = File::open(path) else { return false };
    // Versions before held no lock: what is not surely a draft of keys may be another program's.
    file.try_lock().is_ok() && (ours || has_keys(&file))
}

fn has_draft_name(name: &str, end: &str) -> bool {
    let middle = name.strip_prefix('.').and_then(|name| name.strip_suffix(end));
    let process = middle.and_then(|middle| Some(middle.rsplit_once('.')?.1));
    process.is_some_and(|digits| {
        !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
    })
}

/// Whether a file begins as a key file does, or as a page does.
fn has_keys(file: &File) -> bool {
    let mut bytes = Vec::new();
    let read = file.take(LARGEST).read_to_end(&mut bytes);
    let first_line = HEADING.lines().next().unwrap_or(HEADING).as_bytes();
    read.is_ok() && (bytes.starts_with(first_line) || KeysRecord::decode(&bytes).is_ok())
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
        hidden.push(format!(".{}{DRAFT}", std::process::id()));
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
///
/// # Errors
/// If the file has another name by a hard link. Whichever name is given, the other would keep the
/// file as it was before, and give out the same numbers again.
pub(super) fn only(path: &Path) -> Result<PathBuf, InputError> {
    let metadata = fs::symlink_metadata(path);
    let is_link = metadata.is_ok_and(|metadata| metadata.is_symlink());
    let file = if is_link { fs::canonicalize(path) } else { Ok(path.to_owned()) };
    let file = file.map_err(|error| unusable(path, &error))?;
    #[cfg(unix)]
    if let Ok(names) =
        fs::metadata(&file).map(|about| std::os::unix::fs::MetadataExt::nlink(&about))
        && names > 1
    {
        return Err(InputError::new(
            format!("this key file has {names} names (hard links), and only one would be changed"),
            format!(
                "find them with: find FOLDER -samefile {}, and delete all but one",
                super::quoted(&file)
            ),
        )
        .in_file(path));
    }
    Ok(file)
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
