//! Finds the files of a folder that are caves, maps or worlds.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use cave_survey::{FileError, Files, Folder, Opened};
use input::InputError;

/// The endings of surveys that are read, of which a project comes before its parts.
const SURVEYS: [&str; 12] =
    ["mak", "wpj", "thconfig", "svx", "th", "3d", "clp", "dat", "srv", "tro", "tropx", "txt"];
/// The deepest folder that is looked into, so that a link which leads back ends.
const DEEPEST: usize = 16;

/// A file that is a place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found {
    /// The name in tables: the file's path below the folder.
    pub(super) name: String,
    /// The file.
    pub(super) file: PathBuf,
}

/// The places below a folder, in the order of their names: surveys that no other file includes, maps
/// and worlds.
///
/// # Errors
/// [`InputError`] where there is none.
pub(super) fn places(data: &Path) -> Result<Vec<Found>, InputError> {
    let mut files = Vec::new();
    let unreadable = |error: std::io::Error| {
        InputError::new(format!("the folder cannot be read: {error}"), "give --data a folder")
            .in_file(data)
    };
    walk(data, DEEPEST, &mut files).map_err(unreadable)?;
    files.sort();
    let parts = parts(&files);
    let is_place = |file: &&PathBuf| match ending(file).as_str() {
        "yaml" | "yml" => is_map(file),
        "dot" => file.with_extension("sdf").is_file(),
        "sdf" => false,
        "txt" => is_survey_text(file),
        ending => SURVEYS.contains(&ending) && !parts.contains(&real(file)),
    };
    let name = |file: &Path| file.strip_prefix(data).unwrap_or(file).display().to_string();
    let found: Vec<Found> = files
        .iter()
        .filter(is_place)
        .map(|file| Found { name: name(file).replace('\\', "/"), file: file.clone() })
        .collect();
    if found.is_empty() {
        let wrong = "there is no cave, map or world in the folder";
        let remedy = "give --data a folder with surveys, maps (.yaml) or SubT worlds (.dot, .sdf)";
        return Err(InputError::new(wrong, remedy).in_file(data));
    }
    Ok(found)
}

fn walk(folder: &Path, depth: usize, into: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)?.flatten() {
        let path = entry.path();
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        if path.is_dir() && depth > 0 && !is_hidden {
            // A folder below that cannot be read has no places.
            let _ = walk(&path, depth - 1, into);
        } else if path.is_file() {
            into.push(path);
        }
    }
    Ok(())
}

/// The ending of a file's name in small letters; the whole name where it has none.
fn ending(file: &Path) -> String {
    let ending = file.extension().or(file.file_name()).unwrap_or_default();
    ending.to_string_lossy().to_ascii_lowercase()
}

fn real(file: &Path) -> PathBuf {
    file.canonicalize().unwrap_or_else(|_| file.to_owned())
}

/// Whether a YAML file is a map: others name no image.
fn is_map(file: &Path) -> bool {
    let text = input::file::read_text(file, input::file::LARGEST_TEXT).unwrap_or_default();
    text.lines().any(|line| line.trim_start().starts_with("image:"))
}

/// Whether a text is an export of PocketTopo: what others write is no survey.
fn is_survey_text(file: &Path) -> bool {
    maps::open(file, None).is_ok()
}

/// The surveys that others include.
fn parts(files: &[PathBuf]) -> BTreeSet<PathBuf> {
    let mut parts = BTreeSet::new();
    for file in files.iter().filter(|file| SURVEYS.contains(&ending(file).as_str())) {
        let folder = file.parent().unwrap_or(Path::new("."));
        let (Ok(files), Some(name)) = (Folder::new(folder), file.file_name()) else { continue };
        let recorder = Recorder { files, opened: Mutex::default() };
        // What cannot be read has parts all the same: those up to the mistake.
        let _ = cave_survey::read(&recorder, &name.to_string_lossy());
        let opened = recorder.opened.into_inner().unwrap_or_default();
        let whole = real(file);
        parts.extend(opened.into_iter().map(|path| real(&path)).filter(|path| *path != whole));
    }
    parts
}

/// A folder that notes what is read of it.
struct Recorder {
    files: Folder,
    opened: Mutex<Vec<PathBuf>>,
}

impl Files for Recorder {
    fn open(&self, path: &str) -> Result<Opened, FileError> {
        let opened = self.files.open(path)?;
        if let Ok(mut list) = self.opened.lock() {
            list.push(PathBuf::from(&opened.path));
        }
        Ok(opened)
    }
}
