//! Writes into the directory that `--out` names: the files are written into a temporary directory,
//! and moved to their place at the end.
//!
//! A command that fails, is interrupted or finds the disk full leaves the directory as it was. It
//! replaces and removes only files that this program wrote: `files.txt` lists them.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::input_error::InputError;

/// The file that lists the other files which a command wrote into its directory.
const LIST: &str = "files.txt";

/// The directory that `--out` names, while a command fills it.
///
/// The files are written into a temporary directory, and [`finish`](Self::finish) moves them to
/// where they were asked for. A folder that is dropped before leaves nothing behind.
pub struct Folder {
    target: PathBuf,
    staging: Staging,
    /// The names of the files that a former command wrote here.
    former: Vec<String>,
    /// The names of the files that are ready in the temporary directory, in the order of writing.
    ready: Vec<String>,
}

/// The temporary directory of a [`Folder`], which a handler of Ctrl-C can hold, too.
#[derive(Clone)]
pub struct Staging(Arc<Mutex<Option<PathBuf>>>);

impl Staging {
    /// Makes the directory.
    fn make(path: PathBuf) -> io::Result<Self> {
        fs::create_dir(&path)?;
        Ok(Self(Arc::new(Mutex::new(Some(path)))))
    }

    /// Does something with the directory, unless it was discarded. Until it is done, the
    /// directory is not discarded.
    fn with<T>(&self, act: impl FnOnce(&Path) -> io::Result<T>) -> io::Result<T> {
        let path = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        path.as_deref().map_or_else(|| Err(io::ErrorKind::Interrupted.into()), act)
    }

    /// Removes the directory with all that is in it, unless that was done before.
    pub fn discard(&self) {
        remove(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Removes the directory, and stops the thread that fills it at its next file: for a handler
    /// that ends the process. Returns whether there was anything to remove.
    #[must_use]
    pub fn discard_at_exit(&self) -> bool {
        let mut path = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let removed = remove(&mut path);
        // The lock is never given back.
        std::mem::forget(path);
        removed
    }
}

fn remove(path: &mut Option<PathBuf>) -> bool {
    // There is nothing else to be done about a directory that cannot be removed.
    path.take().is_some_and(|path| fs::remove_dir_all(path).is_ok())
}

impl Folder {
    /// Makes sure that `target` can be written, before anything is flown for it. It may be missing
    /// or empty, or have been written by this program before.
    ///
    /// # Errors
    /// If it is something else, or nothing can be written there.
    pub fn open(target: &Path) -> Result<Self, InputError> {
        let former = former_files(target)?;
        let hidden = format!(".unfinished-{}", std::process::id());
        let staging = if target.is_dir() {
            // Within it, since its parent may be another file system or not writable.
            target.join(hidden)
        } else {
            let name = target.file_name().map(|name| name.to_string_lossy().into_owned());
            existing_parent(target).join(format!(".{}{hidden}", name.unwrap_or_default()))
        };
        let staging = Staging::make(staging).map_err(|error| unusable(target, &error))?;
        Ok(Self { target: target.to_owned(), staging, former, ready: Vec::new() })
    }

    /// The temporary directory, for a handler of Ctrl-C to discard.
    #[must_use]
    pub fn staging(&self) -> Staging {
        self.staging.clone()
    }

    /// Writes one file, on the disk when this returns.
    ///
    /// # Errors
    /// If it cannot be created or filled, or is there already and not this program's.
    pub fn put(
        &mut self,
        name: &str,
        fill: impl FnOnce(&mut io::BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), InputError> {
        let path = self.target.join(name);
        if path.exists() && !self.former.iter().any(|former| former == name) {
            return Err(InputError::new(
                "this file was not written by uchain, and is not replaced",
                "move it away, or give --out another directory",
            )
            .in_file(&path));
        }
        self.stage(name, fill)
    }

    /// Writes one file into the temporary directory.
    fn stage(
        &mut self,
        name: &str,
        fill: impl FnOnce(&mut io::BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), InputError> {
        let written = self.staging.with(|staging| write_file(&staging.join(name), fill));
        written.map_err(|error| unusable(&self.target.join(name), &error))?;
        self.ready.push(name.to_owned());
        Ok(())
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
    /// If they cannot be moved. What was there before is there then.
    pub fn finish(mut self) -> Result<Vec<PathBuf>, InputError> {
        let list: String = self.ready.iter().flat_map(|name| [name.as_str(), "\n"]).collect();
        self.stage(LIST, |out| out.write_all(list.as_bytes()))?;
        let placed = self.staging.with(|staging| match self.target.is_dir() {
            true => self.move_files(staging),
            false => move_directory(staging, &self.target),
        });
        placed.map_err(|error| unusable(&self.target, &error))?;
        Ok(self.ready.iter().map(|name| self.target.join(name)).collect())
    }

    /// Moves each file into the directory that is there. If the power fails meanwhile, the list
    /// names all files of either command.
    fn move_files(&self, staging: &Path) -> io::Result<()> {
        let stale = || self.former.iter().filter(|name| !self.ready.contains(name));
        let all = self.ready.iter().chain(stale()).flat_map(|name| [name.as_str(), "\n"]);
        let both = staging.join(".both");
        write_file(&both, |out| out.write_all(all.collect::<String>().as_bytes()))?;
        fs::rename(both, self.target.join(LIST))?;
        for name in &self.ready {
            fs::rename(staging.join(name), self.target.join(name))?;
        }
        for name in stale() {
            match fs::remove_file(self.target.join(name)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        self.staging.discard();
    }
}

fn move_directory(staging: &Path, target: &Path) -> io::Result<()> {
    if let Some(parent) = target.parent() {
        fs::create_dir_all(parent)?;
    }
    fs::rename(staging, target)
}

fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut io::BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = io::BufWriter::new(File::create(path)?);
    fill(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
}

/// The names of the files that this program wrote into a directory; none where it is missing or
/// empty.
fn former_files(target: &Path) -> Result<Vec<String>, InputError> {
    match fs::symlink_metadata(target) {
        Err(error) if error.kind() == io::ErrorKind::NotFound && target.file_name().is_some() => {
            return Ok(Vec::new());
        }
        Err(error) => return Err(unusable(target, &error)),
        Ok(_) if !target.is_dir() => {
            let remedy = "give --out a directory, or a name that is free";
            return Err(InputError::new("this is not a directory", remedy).in_file(target));
        }
        Ok(_) => {}
    }
    match fs::read_to_string(target.join(LIST)) {
        // A name with a separator in it is not one that this program wrote.
        Ok(list) => Ok(list
            .lines()
            .filter(|name| Path::new(name).file_name().is_some_and(|plain| plain == *name))
            .map(str::to_owned)
            .collect()),
        Err(_) if is_empty(target) => Ok(Vec::new()),
        Err(_) => {
            let wrong = "this directory holds files that uchain did not write";
            let remedy = "give --out a new or an empty directory";
            Err(InputError::new(wrong, remedy).in_file(target))
        }
    }
}

/// Whether a directory holds nothing, or only what killed commands left behind.
fn is_empty(directory: &Path) -> bool {
    fs::read_dir(directory).is_ok_and(|entries| {
        entries
            .flatten()
            .all(|entry| entry.file_name().to_string_lossy().starts_with(".unfinished-"))
    })
}

/// The nearest directory above a path that exists.
fn existing_parent(path: &Path) -> PathBuf {
    let above = path.ancestors().skip(1).find(|above| above.is_dir());
    above.filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned()
}

fn unusable(path: &Path, error: &io::Error) -> InputError {
    InputError::new(
        format!("cannot write here: {error}"),
        "give --out a directory that you may write to, with room on the disk",
    )
    .in_file(path)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A directory of a test's own, gone when dropped.
    pub(crate) struct Scratch(PathBuf);

    impl Scratch {
        pub(crate) fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("uchain-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        pub(crate) fn path(&self) -> &Path {
            &self.0
        }

        /// Names and texts of the files in `out`, sorted; `None` if there is no such directory.
        fn out(&self) -> Option<Vec<(String, String)>> {
            let entries = fs::read_dir(self.0.join("out")).ok()?;
            let mut files: Vec<_> = entries
                .map(|entry| entry.unwrap())
                .map(|entry| {
                    let text = fs::read_to_string(entry.path()).unwrap_or_default();
                    (entry.file_name().into_string().unwrap(), text)
                })
                .collect();
            files.sort();
            Some(files)
        }

        fn command(&self, files: &[(&str, &str)]) -> Result<Vec<PathBuf>, InputError> {
            let mut folder = Folder::open(&self.0.join("out"))?;
            for (name, text) in files {
                folder.put_text(name, text)?;
            }
            folder.finish()
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn named(files: &[(&str, &str)]) -> Vec<(String, String)> {
        files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
    }

    #[test]
    fn nothing_is_there_until_the_folder_is_finished() {
        let scratch = Scratch::new("unseen");
        let mut folder = Folder::open(&scratch.path().join("made/for/it")).unwrap();
        folder.put_text("a", "1").unwrap();
        assert!(!scratch.path().join("made").exists());
        folder.finish().unwrap();
        assert_eq!(fs::read_to_string(scratch.path().join("made/for/it/a")).unwrap(), "1");
    }

    #[test]
    fn a_folder_that_is_dropped_leaves_the_former_one_and_no_other() {
        let scratch = Scratch::new("dropped");
        scratch.command(&[("a", "1")]).unwrap();
        let before = scratch.out();
        let mut folder = Folder::open(&scratch.path().join("out")).unwrap();
        folder.put_text("a", "2").unwrap();
        drop(folder);
        assert_eq!(scratch.out(), before);
        drop(Folder::open(&scratch.path().join("new")).unwrap());
        assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 1, "only out is left");
    }

    #[test]
    fn a_folder_that_is_discarded_cannot_be_finished() {
        let scratch = Scratch::new("discarded");
        let mut folder = Folder::open(&scratch.path().join("out")).unwrap();
        folder.put_text("a", "1").unwrap();
        folder.staging().discard();
        assert!(folder.put_text("b", "1").is_err());
        assert!(folder.finish().is_err());
        assert_eq!(scratch.out(), None);
    }

    #[test]
    fn a_later_command_replaces_what_the_former_wrote_and_nothing_else() {
        let scratch = Scratch::new("replaced");
        scratch.command(&[("a", "1"), ("b", "1")]).unwrap();
        fs::write(scratch.path().join("out/notes"), "mine").unwrap();
        scratch.command(&[("a", "2"), ("c", "2")]).unwrap();
        let expected = [("a", "2"), ("c", "2"), ("files.txt", "a\nc\n"), ("notes", "mine")];
        assert_eq!(scratch.out().unwrap(), named(&expected));
    }

    #[test]
    fn a_file_that_the_program_did_not_write_is_never_replaced() {
        let scratch = Scratch::new("foreign");
        scratch.command(&[("a", "1")]).unwrap();
        fs::write(scratch.path().join("out/b"), "mine").unwrap();
        let before = scratch.out();
        let error = scratch.command(&[("a", "2"), ("b", "2")]).unwrap_err();
        assert!(error.to_string().contains("was not written by uchain"), "{error}");
        assert_eq!(scratch.out(), before);
    }

    #[test]
    fn a_directory_of_other_files_is_refused_and_an_empty_one_is_not() {
        let scratch = Scratch::new("other");
        fs::create_dir(scratch.path().join("out")).unwrap();
        scratch.command(&[("a", "1")]).unwrap();
        fs::remove_file(scratch.path().join("out/files.txt")).unwrap();
        let error = scratch.command(&[("b", "2")]).unwrap_err();
        assert!(error.to_string().contains("give --out a new or an empty directory"), "{error}");
        assert_eq!(scratch.out().unwrap(), named(&[("a", "1")]));
    }

    #[test]
    fn a_list_cannot_name_a_file_elsewhere() {
        let scratch = Scratch::new("elsewhere");
        scratch.command(&[]).unwrap();
        fs::write(scratch.path().join("precious"), "mine").unwrap();
        fs::write(scratch.path().join("out/files.txt"), "../precious\n..\n/etc\n\n").unwrap();
        scratch.command(&[("a", "1")]).unwrap();
        assert_eq!(fs::read_to_string(scratch.path().join("precious")).unwrap(), "mine");
    }

    #[test]
    fn a_directory_that_cannot_be_is_bad_input() {
        let scratch = Scratch::new("blocked");
        let file = scratch.path().join("file");
        fs::write(&file, "").unwrap();
        for wrong in [file.join("out"), file, scratch.path().join("no/..")] {
            let error = Folder::open(&wrong).err().unwrap();
            assert!(error.to_string().contains("give --out a directory"), "{error}");
            assert_eq!(error.to_string().lines().count(), 1);
        }
    }
}
