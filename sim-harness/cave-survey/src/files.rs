//! Gives readers their files. A reader asks for a file by the name that another file calls it, and
//! gets the bytes only where the file lies within the folder that the user gave.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// The reason why a file is not given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileError {
    /// There is no such file.
    Missing,
    /// The file lies outside the folder.
    Outside,
    /// The file is text in UTF-16, which none of the programs writes.
    Utf16,
    /// The file cannot be read; the text says why.
    Unreadable(String),
}

/// A file that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Opened {
    /// The path by which messages name the file and other names are relative to it.
    pub path: String,
    /// The contents.
    pub bytes: Vec<u8>,
}

/// A set of files that a survey may consist of.
pub trait Files {
    /// Opens the file `path`, which is relative to the set, without `.` and `..`.
    ///
    /// # Errors
    /// [`FileError`], of which `Missing` makes the reader try another spelling.
    fn open(&self, path: &str) -> Result<Opened, FileError>;
}

/// The most that is read of one file, in bytes: an image of a map may be so large.
pub(crate) const LARGEST: u64 = 128 << 20;

/// The most that is read of a project, which only lists files, in bytes.
pub(crate) const LARGEST_PROJECT: usize = 16 << 20;

/// The longest line of the formats whose lines are cut into words, in bytes.
pub(crate) const LONGEST_LINE: usize = 100_000;

/// The files of a folder on disk.
#[derive(Clone, Debug)]
pub struct Folder {
    root: PathBuf,
    /// The name of the root in messages.
    shown: PathBuf,
}

impl Folder {
    /// Makes the set of the files below `root`.
    ///
    /// # Errors
    /// The error of the operating system where there is no such folder.
    pub fn new(root: &Path) -> std::io::Result<Self> {
        let root = if root.as_os_str().is_empty() { Path::new(".") } else { root };
        Ok(Self { root: root.canonicalize()?, shown: root.to_owned() })
    }

    /// The path on disk, where letters may differ in case as on the disks of DOS.
    fn find(&self, path: &str) -> Option<PathBuf> {
        let mut found = self.root.clone();
        for part in path.split('/') {
            let exact = found.join(part);
            found = if exact.exists() { exact } else { same_but_case(&found, part)? };
        }
        Some(found)
    }
}

fn same_but_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder).ok()?;
    let alike = |entry: &std::fs::DirEntry| {
        entry.file_name().to_str().is_some_and(|other| other.eq_ignore_ascii_case(name))
    };
    let mut found: Vec<_> = entries.flatten().filter(alike).map(|entry| entry.path()).collect();
    found.sort();
    found.into_iter().next()
}

/// Reads a file that is a file, and of a size that a survey may have.
///
/// # Errors
/// [`FileError::Missing`] for a folder, a pipe or a device; [`FileError::Unreadable`] otherwise.
pub fn read_whole(path: &Path) -> Result<Vec<u8>, FileError> {
    let told = |error: std::io::Error| FileError::Unreadable(error.to_string());
    let facts = std::fs::metadata(path).map_err(told)?;
    if !facts.is_file() {
        return Err(FileError::Missing);
    }
    if facts.len() > LARGEST {
        return Err(FileError::Unreadable(format!("it has more than {LARGEST} bytes")));
    }
    std::fs::read(path).map_err(told)
}

/// The bytes of a file that is no text in UTF-16: as that of single bytes it would be refused for what it
/// does not say. Some editors save so, and put a byte order mark first.
fn of_single_bytes(bytes: Vec<u8>) -> Result<Vec<u8>, FileError> {
    match bytes.as_slice() {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Err(FileError::Utf16),
        _ => Ok(bytes),
    }
}

impl Files for Folder {
    fn open(&self, path: &str) -> Result<Opened, FileError> {
        let found = self.find(path).ok_or(FileError::Missing)?;
        let real = found.canonicalize().map_err(|_| FileError::Missing)?;
        // A link may lead out of the folder.
        if !real.starts_with(&self.root) {
            return Err(FileError::Outside);
        }
        let bytes = of_single_bytes(read_whole(&real)?)?;
        let shown = self.shown.join(found.strip_prefix(&self.root).unwrap_or(&found));
        let shown = shown.strip_prefix(".").unwrap_or(&shown);
        Ok(Opened { path: shown.to_string_lossy().into_owned(), bytes })
    }
}

/// Files in memory, such as those that were dropped on a page in the browser.
#[derive(Clone, Debug, Default)]
pub struct Memory(BTreeMap<String, Vec<u8>>);

impl Memory {
    /// Adds a file.
    #[must_use]
    pub fn with(mut self, path: &str, bytes: impl Into<Vec<u8>>) -> Self {
        self.0.insert(path.to_owned(), bytes.into());
        self
    }
}

impl Files for Memory {
    fn open(&self, path: &str) -> Result<Opened, FileError> {
        let alike = |known: &&String| known.eq_ignore_ascii_case(path);
        let known = self.0.get_key_value(path).map(|(known, _)| known);
        let known = known.or_else(|| self.0.keys().find(alike)).ok_or(FileError::Missing)?;
        let bytes = of_single_bytes(self.0.get(known).cloned().unwrap_or_default())?;
        Ok(Opened { path: known.clone(), bytes })
    }
}

/// The text of a file: UTF-8, or else Latin-1, in which every byte is a character, so that no two
/// names become one.
pub(crate) fn text(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
    }
}

/// The lines of a text that ends them as Unix, DOS or the old Macintosh does, or by Ctrl-Z, the end
/// of a file of DOS.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> + Clone {
    text.split('\n').flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split(['\r', '\x1a']))
}

/// Opens a file by the name that the file `from` calls it: relative to that file's folder, with
/// `\` for `/`, and with one of the `endings` added where there is none of that name.
pub(crate) fn open_named(
    files: &dyn Files,
    from: &str,
    name: &str,
    endings: &[&str],
) -> Result<(String, Opened), FileError> {
    let mut last = FileError::Missing;
    let slashed = name.replace('\\', "/");
    for spelling in [name, &slashed] {
        let path = resolve(from, spelling)?;
        let plain = std::iter::once(path.clone());
        for path in plain.chain(endings.iter().map(|ending| format!("{path}{ending}"))) {
            match files.open(&path) {
                Ok(opened) => return Ok((path, opened)),
                Err(FileError::Missing) => {}
                Err(error) => last = error,
            }
        }
    }
    Err(last)
}

/// The path of `name` beside the file `from`, both relative to the set.
fn resolve(from: &str, name: &str) -> Result<String, FileError> {
    let folder = Path::new(from).parent().unwrap_or(Path::new(""));
    let mut parts: Vec<String> = Vec::new();
    for component in folder.join(name).components() {
        match component {
            Component::Normal(part) => parts.push(part.to_string_lossy().into_owned()),
            Component::CurDir => {}
            Component::ParentDir if parts.pop().is_some() => {}
            _ => return Err(FileError::Outside),
        }
    }
    Ok(parts.join("/"))
}
