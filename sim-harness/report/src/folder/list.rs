//! The list of the files that this program wrote into a directory, by which the directory is known
//! to be its own.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use crc32fast::Hasher;
use input::InputError;

/// The name of the list.
pub(super) const NAME: &str = "files.txt";

/// The first line of the list of a directory with results.
const WRITTEN: &str =
    "# uchain wrote these files and replaces them as long as they are unchanged: CRC-32 size name";

/// The whole list of a directory that a command is filling.
const UNFINISHED: &str = "# uchain is writing here, and removes this directory\n";

/// A file, as it was written.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Content {
    crc: u32,
    size: u64,
}

/// The files of a directory. Between two commands that cannot exchange directories, a name has the
/// content of either.
#[derive(Clone, Default)]
pub(super) struct List {
    /// The names, in the order of writing.
    order: Vec<String>,
    /// Whether it is in its directory.
    is_written: bool,
    contents: BTreeMap<String, Vec<Content>>,
}

/// What a directory is by its list.
pub(super) enum Kind {
    /// It has results.
    Written(List),
    /// A command is or was filling it.
    Unfinished,
    /// It is not this program's.
    Foreign,
}

impl List {
    /// The list of these files.
    pub(super) fn of(directory: &Path, names: &[String]) -> io::Result<Self> {
        let mut list = Self::default();
        for name in names {
            list.add(name, content(&directory.join(name))?);
        }
        Ok(list)
    }

    /// The list of the files that a former command wrote into a directory; empty where that is
    /// missing or empty.
    ///
    /// # Errors
    /// If the directory has other files, or one of the list was changed.
    pub(super) fn of_former(target: &Path) -> Result<Self, InputError> {
        if fs::symlink_metadata(target).is_err() {
            return Ok(Self::default());
        }
        match Kind::of(target) {
            Kind::Written(list) => list.is_as_written(target).map(|()| list),
            _ if is_empty(target) => Ok(Self::default()),
            _ => {
                let wrong = "this directory holds files that uchain did not write";
                let remedy = "give --out a new or an empty directory";
                Err(InputError::new(wrong, remedy).in_file(target))
            }
        }
    }

    /// The list of a directory that has to hold results.
    pub(super) fn of_results(directory: &Path) -> Result<Self, InputError> {
        match Kind::of(directory) {
            Kind::Written(list) => Ok(list),
            _ => {
                let remedy = "give a folder that uchain has written";
                Err(InputError::new("this folder holds no results", remedy).in_file(directory))
            }
        }
    }

    fn add(&mut self, name: &str, content: Content) {
        let known = self.contents.entry(name.to_owned()).or_default();
        if known.is_empty() {
            self.order.push(name.to_owned());
        }
        if !known.contains(&content) {
            known.push(content);
        }
    }

    /// Whether a file of this name belongs to it; the list itself does.
    pub(super) fn names(&self, name: &str) -> bool {
        self.contents.contains_key(name) || (name == NAME && self.is_written)
    }

    /// The names, in the order of writing.
    pub(super) fn iter(&self) -> impl Iterator<Item = &str> {
        self.order.iter().map(String::as_str)
    }

    /// Both lists as one.
    pub(super) fn with(&self, other: &Self) -> Self {
        let mut both = self.clone();
        for (name, contents) in &other.contents {
            contents.iter().for_each(|content| both.add(name, *content));
        }
        both
    }

    /// Makes sure that its files are as they were written, or gone.
    pub(super) fn is_as_written(&self, directory: &Path) -> Result<(), InputError> {
        let Some(path) = self.changed(directory) else { return Ok(()) };
        let wrong = "this file is not as uchain wrote it, and is not replaced";
        let remedy = "move it away, or give --out another directory";
        Err(InputError::new(wrong, remedy).in_file(&path))
    }

    /// A file that is there and not as it was written.
    pub(super) fn changed(&self, directory: &Path) -> Option<PathBuf> {
        self.contents.iter().find_map(|(name, contents)| {
            let path = directory.join(name);
            let found = fs::symlink_metadata(&path).ok()?;
            let is_same = found.is_file()
                && contents.iter().any(|content| content.size == found.len())
                && content(&path).is_ok_and(|content| contents.contains(&content));
            (!is_same).then_some(path)
        })
    }

    /// Writes it into a directory, in one step.
    pub(super) fn write(&self, directory: &Path) -> io::Result<()> {
        let mut text = format!("{WRITTEN}\n");
        for (name, contents) in &self.contents {
            for Content { crc, size } in contents {
                text += &format!("{crc:08x} {size} {name}\n");
            }
        }
        let new = directory.join(".files.txt");
        let mut file = File::create(&new)?;
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(new, directory.join(NAME))
    }

    fn parse(text: &str) -> Option<Self> {
        let mut list = Self { is_written: true, ..Self::default() };
        let mut lines = text.lines();
        if lines.next() != Some(WRITTEN) {
            return None;
        }
        for line in lines {
            let mut fields = line.splitn(3, ' ');
            let crc = u32::from_str_radix(fields.next()?, 16).ok()?;
            let size = fields.next()?.parse().ok()?;
            let name = fields.next()?;
            // A name with a separator in it is not one that this program wrote.
            if Path::new(name).file_name()? != name {
                return None;
            }
            list.add(name, Content { crc, size });
        }
        Some(list)
    }
}

impl Kind {
    /// The kind of a directory.
    pub(super) fn of(directory: &Path) -> Self {
        let list = directory.join(NAME);
        if !fs::symlink_metadata(&list).is_ok_and(|found| found.is_file()) {
            return Self::Foreign;
        }
        let Ok(text) = input::file::read_text(&list, input::file::LARGEST_TEXT) else {
            return Self::Foreign;
        };
        if let Some(list) = List::parse(&text) {
            return Self::Written(list);
        }
        // A command that is killed at once leaves less than the whole text.
        let alone = || fs::read_dir(directory).is_ok_and(|entries| entries.count() == 1);
        if text == UNFINISHED || (UNFINISHED.starts_with(&text) && alone()) {
            return Self::Unfinished;
        }
        Self::Foreign
    }
}

/// Marks a directory as one that a command is filling.
pub(super) fn mark_unfinished(directory: &Path) -> io::Result<()> {
    fs::write(directory.join(NAME), UNFINISHED)
}

/// Whether a directory holds nothing, or only what killed commands left behind.
fn is_empty(directory: &Path) -> bool {
    fs::read_dir(directory).is_ok_and(|entries| {
        entries.flatten().all(|entry| super::spot::is_temporary(&entry.file_name()))
    })
}

fn content(path: &Path) -> io::Result<Content> {
    let (mut file, mut hasher, mut size) = (File::open(path)?, Hasher::new(), 0);
    let mut buffer = vec![0; 1 << 16];
    loop {
        let count = file.read(&mut buffer)?;
        if count == 0 {
            return Ok(Content { crc: hasher.finalize(), size });
        }
        hasher.update(buffer.get(..count).unwrap_or_default());
        size += count as u64;
    }
}
