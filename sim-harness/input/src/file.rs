//! Reads files that the user names, up to a size: a device that never ends, such as `/dev/zero`, and a
//! wrong file of gigabytes fill no memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The most that is read of a text that people write: a scenario, a table of readings.
pub const LARGEST_TEXT: u64 = 16 << 20;
/// The most that is read of an ELF: the firmware's has 10 MB with its debug information.
pub const LARGEST_ELF: u64 = 256 << 20;

/// Reads a file of at most so many bytes.
pub fn read(path: &Path, largest: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(largest + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > largest {
        let wrong = format!("it has more than {} MiB", largest >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, wrong));
    }
    Ok(bytes)
}

/// Reads a text of at most so many bytes; the error's kind is `InvalidData` where it is not UTF-8.
pub fn read_text(path: &Path, largest: u64) -> io::Result<String> {
    String::from_utf8(read(path, largest)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not text in UTF-8"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn a_file_that_never_ends_is_refused() {
        let error = read(Path::new("/dev/zero"), 1 << 20).unwrap_err();
        assert_eq!(error.to_string(), "it has more than 1 MiB");
        assert!(read(Path::new("/dev/null"), 1 << 20).unwrap().is_empty());
    }
}
