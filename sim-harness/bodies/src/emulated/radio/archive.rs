//! Finds the radio chip's image in an archive of the vendor's releases: a ZIP file whose
//! `manifest.json` says which file is for which chip (docs of crazyflie-lib-python, "Bootloader file
//! format").

use std::fmt;
use std::io::Read as _;

use flate2::read::DeflateDecoder;
use serde_json::Value;

/// The most that a file of the archive may have when it is unpacked: either chip has less flash.
const LARGEST: u64 = 2 << 20;
/// The signatures of a file, of an entry in the directory, and of the directory's end (APPNOTE.TXT of
/// PKWARE, 4.3).
const FILE: &[u8; 4] = b"PK\x03\x04";
const ENTRY: &[u8; 4] = b"PK\x01\x02";
const END: &[u8; 4] = b"PK\x05\x06";
/// The sizes of their fixed parts.
const FILE_SIZE: usize = 30;
const ENTRY_SIZE: usize = 46;
const END_SIZE: usize = 22;

/// The reason why an archive has no image of the radio chip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum BadArchive {
    /// The archive is damaged, or packed in a way that releases are not.
    Damaged,
    /// The archive has no such file.
    Without(String),
    /// The manifest is no JSON.
    BadManifest,
    /// The manifest names no firmware of the radio chip.
    NoRadio,
}

impl fmt::Display for BadArchive {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damaged => write!(f, "this ZIP archive is damaged"),
            Self::Without(name) => write!(f, "this ZIP archive has no {name}"),
            Self::BadManifest => write!(f, "the archive's manifest.json is damaged"),
            Self::NoRadio => write!(f, "the archive's manifest names no firmware for the nrf51"),
        }
    }
}

/// Whether a file is a ZIP archive.
pub(super) fn is_one(file: &[u8]) -> bool {
    file.starts_with(FILE) || file.starts_with(END)
}

/// The image of the radio chip.
pub(super) fn radio_image(archive: &[u8]) -> Result<Vec<u8>, BadArchive> {
    let manifest = unpacked(archive, "manifest.json")?;
    let manifest: Value = serde_json::from_slice(&manifest).map_err(|_| BadArchive::BadManifest)?;
    let files = manifest["files"].as_object().ok_or(BadArchive::BadManifest)?;
    let is_radios = |about: &Value| about["target"] == "nrf51" && about["type"] == "fw";
    let found = files.iter().find(|(_, about)| is_radios(about));
    let (name, _) = found.ok_or(BadArchive::NoRadio)?;
    unpacked(archive, name)
}

/// Bytes of the archive.
fn part(archive: &[u8], at: usize, length: usize) -> Result<&[u8], BadArchive> {
    at.checked_add(length).and_then(|end| archive.get(at..end)).ok_or(BadArchive::Damaged)
}

/// A number in an entry, lowest byte first.
fn number(entry: &[u8], at: usize, bytes: usize) -> usize {
    let bytes = entry.iter().skip(at).take(bytes);
    bytes.enumerate().fold(0, |sum, (n, byte)| sum | usize::from(*byte) << (8 * n))
}

/// The content of a file of the archive.
fn unpacked(archive: &[u8], name: &str) -> Result<Vec<u8>, BadArchive> {
    let end = archive.windows(END_SIZE).rposition(|window| window.starts_with(END));
    let end = part(archive, end.ok_or(BadArchive::Damaged)?, END_SIZE)?;
    let mut at = number(end, 16, 4);
    for _ in 0..number(end, 10, 2) {
        let entry = part(archive, at, ENTRY_SIZE)?;
        if !entry.starts_with(ENTRY) {
            return Err(BadArchive::Damaged);
        }
        let length = number(entry, 28, 2);
        if part(archive, at + ENTRY_SIZE, length)? == name.as_bytes() {
            return content(archive, entry);
        }
        at += ENTRY_SIZE + length + number(entry, 30, 2) + number(entry, 32, 2);
    }
    Err(BadArchive::Without(name.to_owned()))
}

/// The content of the file of an entry: stored, or deflated.
fn content(archive: &[u8], entry: &[u8]) -> Result<Vec<u8>, BadArchive> {
    let at = number(entry, 42, 4);
    let header = part(archive, at, FILE_SIZE)?;
    let before = FILE_SIZE + number(header, 26, 2) + number(header, 28, 2);
    let packed = part(archive, at + before, number(entry, 20, 4))?;
    let mut bytes = Vec::new();
    let read = match number(entry, 10, 2) {
        0 => packed.take(LARGEST).read_to_end(&mut bytes),
        8 => DeflateDecoder::new(packed).take(LARGEST).read_to_end(&mut bytes),
        _ => return Err(BadArchive::Damaged),
    };
    if read.is_ok() && bytes.len() == number(entry, 24, 4) {
        Ok(bytes)
    } else {
        Err(BadArchive::Damaged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::read::DeflateEncoder;

    /// An archive with these files, each deflated.
    fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
        let little = |number: usize, bytes: usize| number.to_le_bytes()[..bytes].to_vec();
        let (mut archive, mut directory) = (Vec::new(), Vec::new());
        for (name, content) in files {
            let mut packed = Vec::new();
            DeflateEncoder::new(*content, Compression::fast()).read_to_end(&mut packed).unwrap();
            let sizes = [little(0, 4), little(packed.len(), 4), little(content.len(), 4)].concat();
            let shared = [&[20, 0, 0, 0, 8, 0, 0, 0, 0, 0], &sizes[..]].concat();
            let names = [little(name.len(), 2), little(0, 2)].concat();
            let at = little(archive.len(), 4);
            archive.extend([FILE, &shared[..], &names, name.as_bytes(), &packed].concat());
            let rest = [&[0; 10], &at[..], name.as_bytes()].concat();
            directory.extend([ENTRY, &[20, 0][..], &shared, &names, &rest].concat());
        }
        let count = little(files.len(), 2);
        let places = [little(directory.len(), 4), little(archive.len(), 4)].concat();
        archive.extend(&directory);
        archive.extend([END, &[0; 4][..], &count, &count, &places, &[0; 2]].concat());
        archive
    }

    const MANIFEST: &[u8] = br#"{"version": 2, "files": {
        "cf2.bin": {"platform": "cf2", "target": "stm32", "type": "fw"},
        "sd.bin": {"platform": "cf2", "target": "nrf51", "type": "bootloader+softdevice"},
        "cf2_nrf.bin": {"platform": "cf2", "target": "nrf51", "type": "fw"}}}"#;

    #[test]
    fn the_image_that_the_manifest_names_is_found() {
        let image = vec![7; 5_000];
        let archive = archive(&[("cf2_nrf.bin", &image), ("manifest.json", MANIFEST)]);
        assert!(is_one(&archive));
        assert_eq!(radio_image(&archive), Ok(image));
    }

    #[test]
    fn what_is_missing_is_named() {
        let empty = archive(&[]);
        assert_eq!(radio_image(&empty), Err(BadArchive::Without("manifest.json".into())));
        let without = archive(&[("manifest.json", MANIFEST)]);
        assert_eq!(radio_image(&without), Err(BadArchive::Without("cf2_nrf.bin".into())));
        let bolt = archive(&[("manifest.json", br#"{"files": {}}"#)]);
        assert_eq!(radio_image(&bolt), Err(BadArchive::NoRadio));
    }

    #[test]
    fn an_archive_that_is_cut_off_anywhere_is_refused() {
        let whole = archive(&[("manifest.json", MANIFEST), ("cf2_nrf.bin", &[7; 500])]);
        for length in 0..whole.len() {
            assert!(radio_image(&whole[..length]).is_err(), "{length}");
        }
    }
}
