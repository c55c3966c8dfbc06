//! Puts files and their names onto the disk: what a program has written is in the memory of the system
//! until then, and a power cut takes it.

use std::fs::{self, File};
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

/// A file that can be put onto the disk.
pub(super) trait DurableFile: Write + Seek + Sized {
    /// The same file once more.
    fn again(&self) -> io::Result<Self>;

    /// Returns when what was written would survive a power cut.
    fn sync(&self) -> io::Result<()>;
}

impl DurableFile for File {
    fn again(&self) -> io::Result<Self> {
        self.try_clone()
    }

    fn sync(&self) -> io::Result<()> {
        self.sync_data()
    }
}

/// A folder in which files are made whose names can be put onto the disk.
pub(super) trait DurableFolder {
    /// A file in it.
    type File: DurableFile;

    /// Makes a file that was not there.
    fn create(&self, name: &str) -> io::Result<Self::File>;

    /// Returns when the names of its files would survive a power cut.
    fn sync(&self) -> io::Result<()>;
}

/// A folder on the disk.
pub(super) struct DiskFolder(PathBuf);

impl DiskFolder {
    /// Makes the folder and those above it, where they are missing.
    pub(super) fn make(path: &Path) -> io::Result<Self> {
        make_durable(path, sync_folder)?;
        Ok(Self(path.to_owned()))
    }
}

impl DurableFolder for DiskFolder {
    type File = File;

    fn create(&self, name: &str) -> io::Result<File> {
        File::create_new(self.0.join(name))
    }

    fn sync(&self) -> io::Result<()> {
        sync_folder(&self.0)
    }
}

/// Makes a folder and those above it, and has each in which one was made put onto the disk.
fn make_durable(path: &Path, sync: impl Fn(&Path) -> io::Result<()>) -> io::Result<()> {
    let missing = path.ancestors().take_while(|above| !above.exists());
    let above = missing.filter_map(Path::parent).map(|above| {
        // The folder above a plain name is the one in which the program works.
        if above.as_os_str().is_empty() { Path::new(".") } else { above }
    });
    let above: Vec<_> = above.collect();
    fs::create_dir_all(path)?;
    above.into_iter().try_for_each(sync)
}

/// Returns when the names in a folder would survive a power cut.
fn sync_folder(folder: &Path) -> io::Result<()> {
    // Elsewhere a folder cannot be opened, and need not be.
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
pub(super) mod tests {
    use std::cell::RefCell;
    use std::collections::BTreeMap;
    use std::io::SeekFrom;
    use std::sync::{Arc, Mutex};

    use super::*;

    /// A file of which a power cut leaves what was put onto the disk.
    #[derive(Clone, Default)]
    pub(in crate::recorder) struct PowerCutFile(Arc<Mutex<Sheet>>);

    #[derive(Default)]
    struct Sheet {
        written: io::Cursor<Vec<u8>>,
        kept: Vec<u8>,
    }

    /// A folder of which a power cut leaves the names that were put onto the disk.
    #[derive(Clone, Default)]
    pub(in crate::recorder) struct PowerCutFolder(Arc<Mutex<[BTreeMap<String, PowerCutFile>; 2]>>);

    impl PowerCutFolder {
        /// The content of a file; `None` where its name is lost.
        pub(in crate::recorder) fn after_power_cut(&self, name: &str) -> Option<Vec<u8>> {
            let [_, kept] = &*self.0.lock().unwrap();
            kept.get(name).map(|file| file.0.lock().unwrap().kept.clone())
        }
    }

    impl DurableFolder for PowerCutFolder {
        type File = PowerCutFile;

        fn create(&self, name: &str) -> io::Result<PowerCutFile> {
            let file = PowerCutFile::default();
            self.0.lock().unwrap()[0].insert(name.to_owned(), file.clone());
            Ok(file)
        }

        fn sync(&self) -> io::Result<()> {
            let [made, kept] = &mut *self.0.lock().unwrap();
            kept.clone_from(made);
            Ok(())
        }
    }

    impl Write for PowerCutFile {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().written.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for PowerCutFile {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.0.lock().unwrap().written.seek(to)
        }
    }

    impl DurableFile for PowerCutFile {
        fn again(&self) -> io::Result<Self> {
            Ok(self.clone())
        }

        fn sync(&self) -> io::Result<()> {
            let sheet = &mut *self.0.lock().unwrap();
            sheet.kept.clone_from(sheet.written.get_ref());
            Ok(())
        }
    }

    /// A pipe and a device are on no disk, and the system says so where it is asked.
    #[test]
    #[cfg(target_os = "linux")]
    fn the_system_is_asked_to_put_files_and_names_onto_the_disk() {
        let (_reader, writer) = io::pipe().unwrap();
        let pipe = File::from(std::os::fd::OwnedFd::from(writer));
        assert!(pipe.sync().is_err());
        assert!(sync_folder(Path::new("/dev/null")).is_err());
        assert!(sync_folder(&std::env::temp_dir()).is_ok());
    }

    #[test]
    fn the_name_of_each_folder_that_is_made_is_put_onto_the_disk() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = scratch.path().join("made/for/it");
        let synced = RefCell::new(Vec::new());
        let note = |above: &Path| {
            synced.borrow_mut().push(above.to_owned());
            Ok(())
        };
        make_durable(&folder, note).unwrap();
        assert!(folder.is_dir());
        let above = ["made/for", "made", ""].map(|name| scratch.path().join(name));
        assert_eq!(*synced.borrow(), above);
        // A folder that was there has its name already.
        make_durable(&folder, note).unwrap();
        assert_eq!(synced.borrow().len(), 3);
    }
}
