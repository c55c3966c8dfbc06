//! Writes into the directory that `--out` names: the files are written into a temporary directory
//! beside it, and take its place as a whole at the end.
//!
//! A command that fails, is interrupted or finds the disk full leaves the directory as it was. A
//! directory is this program's where `files.txt` in it says so; it replaces and removes only the
//! files that this list names, and only as long as they are as it wrote them. A lock keeps two
//! commands from one directory, and what a killed command has left is removed by the next.

mod list;
mod lock;
mod place;
mod spot;
mod staging;

use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use input::InputError;
use list::List;
use spot::Spot;
pub use staging::Staging;

/// The directory that `--out` names, while a command fills it.
///
/// The files are written into a temporary directory, and [`finish`](Self::finish) puts them where
/// they were asked for. A folder that is dropped before leaves nothing behind.
pub struct Folder {
    target: PathBuf,
    spot: Spot,
    staging: Staging,
    /// The files that a former command wrote here.
    former: List,
    /// The names of the files that are ready in the temporary directory, in the order of writing.
    ready: Vec<String>,
}

/// A file of a [`Folder`] that is written piece by piece.
pub struct Streamed {
    name: String,
    out: BufWriter<File>,
}

impl Write for Streamed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl Seek for Streamed {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.out.seek(to)
    }
}

impl Folder {
    /// Makes sure that `target` can be written, before anything is flown for it. It may be missing
    /// or empty, or have been written by this program before.
    ///
    /// # Errors
    /// If it is something else, if another command is writing there, or nothing can be written.
    pub fn open(target: &Path) -> Result<Self, InputError> {
        is_directory_or_free(target)?;
        let (spot, lock) = Spot::find(target)?;
        let former = List::of_former(target)?;
        let staging = Staging::make(&spot, lock).map_err(|error| unusable(target, &error))?;
        Ok(Self { target: target.to_owned(), spot, staging, former, ready: Vec::new() })
    }

    /// Makes sure that the results in a directory are as this program wrote them.
    ///
    /// # Errors
    /// If a file was changed, or they are not this program's.
    pub fn is_as_written(directory: &Path) -> Result<(), InputError> {
        let Some(path) = List::of_results(directory)?.changed(directory) else { return Ok(()) };
        let wrong = "this file was changed since uchain wrote it";
        let remedy = "give the folder as it was written, or fly it again";
        Err(InputError::new(wrong, remedy).in_file(&path))
    }

    /// The temporary directory, for a handler of Ctrl-C to discard.
    #[must_use]
    pub fn staging(&self) -> Staging {
        self.staging.clone()
    }

    /// A file without a name on the disk of the directory, which is gone when it is closed.
    ///
    /// # Errors
    /// If there can be none.
    pub fn scratch(&self) -> io::Result<File> {
        self.staging.with(|path| tempfile::tempfile_in(path))
    }

    /// Writes one file, on the disk when this returns.
    ///
    /// # Errors
    /// If it cannot be created or filled, or is there already and not this program's.
    pub fn put(
        &mut self,
        name: &str,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), InputError> {
        let mut file = self.stream(name)?;
        fill(&mut file.out).map_err(|error| self.unwritten(name, &error))?;
        self.keep(file)
    }

    /// Begins a file that is written piece by piece; [`keep`](Self::keep) ends it.
    ///
    /// # Errors
    /// As for [`put`](Self::put).
    pub fn stream(&self, name: &str) -> Result<Streamed, InputError> {
        let path = self.target.join(name);
        if path.symlink_metadata().is_ok() && !self.former.names(name) {
            return Err(InputError::new(
                "this file was not written by uchain, and is not replaced",
                "move it away, or give --out another directory",
            )
            .in_file(&path));
        }
        let file = self.staging.with(|staging| File::create(staging.join(name)));
        let file = file.map_err(|error| self.unwritten(name, &error))?;
        Ok(Streamed { name: name.to_owned(), out: BufWriter::new(file) })
    }

    /// Ends a file; it is on the disk when this returns.
    ///
    /// # Errors
    /// If the rest of it cannot be written.
    pub fn keep(&mut self, file: Streamed) -> Result<(), InputError> {
        let Streamed { name, out } = file;
        let written = out.into_inner().map_err(io::IntoInnerError::into_error);
        let written = written.and_then(|file| file.sync_all());
        written.map_err(|error| self.unwritten(&name, &error))?;
        self.ready.push(name);
        Ok(())
    }

    /// The error for a file that cannot be written.
    #[must_use]
    pub fn unwritten(&self, name: &str, error: &io::Error) -> InputError {
        unusable(&self.target.join(name), error)
    }

    /// Writes a value as indented JSON.
    ///
    /// # Errors
    /// See [`put`](Self::put).
    pub fn put_json(
        &mut self,
        name: &str,
        value: &impl serde::Serialize,
    ) -> Result<(), InputError> {
        self.put(name, |out| {
            serde_json::to_writer_pretty(&mut *out, value)?;
            out.write_all(b"\n")
        })
    }

    /// Writes a text.
    ///
    /// # Errors
    /// See [`put`](Self::put).
    pub fn put_text(&mut self, name: &str, text: &str) -> Result<(), InputError> {
        self.put(name, |out| out.write_all(text.as_bytes()))
    }

    /// Puts the files in place, and removes those of a former command that this one did not write.
    /// Returns the paths of the new files, in the order of writing.
    ///
    /// # Errors
    /// If they cannot be put there. What was there before is there then.
    pub fn finish(mut self) -> Result<Vec<PathBuf>, InputError> {
        // It may have been changed since the command began.
        self.former.is_as_written(&self.target)?;
        let placed = self.staging.place(|staging| {
            let list = List::of(staging, &self.ready)?;
            list.write(staging)?;
            place::whole(staging, &self.target, &self.spot, &self.former, &list)
        });
        placed.map_err(|error| unusable(&self.target, &error))?;
        self.ready.push(list::NAME.to_owned());
        Ok(self.ready.iter().map(|name| self.target.join(name)).collect())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        self.staging.discard();
    }
}

fn is_directory_or_free(target: &Path) -> Result<(), InputError> {
    match fs::symlink_metadata(target) {
        Err(error) if error.kind() == io::ErrorKind::NotFound && target.file_name().is_some() => {
            Ok(())
        }
        Err(error) => Err(unusable(target, &error)),
        Ok(_) if !target.is_dir() => {
            let remedy = "give --out a directory, or a name that is free";
            Err(InputError::new("this is not a directory", remedy).in_file(target))
        }
        Ok(_) => Ok(()),
    }
}

fn unusable(path: &Path, error: &io::Error) -> InputError {
    InputError::new(
        format!("cannot write here: {error}"),
        "give --out a directory that you may write to, with room on the disk",
    )
    .in_file(path)
}

#[cfg(test)]
pub(crate) mod tests;
