//! Puts files onto the disk: what a program has written is in the memory of the system until then,
//! and a power cut takes it.

use std::fs::File;
use std::io::{self, Seek, Write};
use std::path::Path;

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

/// Returns when the names in a folder would survive a power cut.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    // Elsewhere a folder cannot be opened, and need not be.
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
pub(super) mod tests {
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

    impl PowerCutFile {
        pub(in crate::recorder) fn after_power_cut(&self) -> Vec<u8> {
            self.0.lock().unwrap().kept.clone()
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
}
