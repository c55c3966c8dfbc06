//! Opens maps on disk: surveys of caves, SubT worlds, and maps of robots.

use std::path::{Path, PathBuf};

use cave_survey::{FileError, Files, Folder, Opened, Refusal, Survey, Warning, read_whole};
use input::InputError;
use robot_maps::{Occupancy, map_server, subt};

/// A map.
#[derive(Clone, Debug)]
pub enum Map {
    /// A survey of a cave.
    Survey(Survey),
    /// A world of the SubT Challenge.
    Subt(subt::World),
    /// An occupancy map.
    Grid(Occupancy),
}

/// The kind of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MapKind {
    /// A survey of a cave.
    Survey,
    /// A world of the SubT Challenge.
    Subt,
    /// An occupancy map.
    Grid,
}

impl MapKind {
    /// The kind of map in a file, by the ending of its name.
    fn of(file: &Path) -> Self {
        let ending = file.extension().and_then(|it| it.to_str()).unwrap_or_default();
        match &*ending.to_ascii_lowercase() {
            "dot" | "sdf" => Self::Subt,
            "yaml" | "yml" => Self::Grid,
            _ => Self::Survey,
        }
    }
}

impl Map {
    /// The remarks of its reader.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        match self {
            Self::Survey(survey) => &survey.warnings,
            Self::Subt(world) => &world.warnings,
            Self::Grid(map) => &map.warnings,
        }
    }
}

/// Reads the map `file`, and what belongs to it from the folder `within` and those below it; where
/// there is none, from the file's own folder.
///
/// # Errors
/// [`InputError`] where the map cannot be used.
pub fn open(file: &Path, within: Option<&Path>) -> Result<Map, InputError> {
    refuse_image(file)?;
    let read = |files: &dyn Files, entry: &str| read(files, entry, file);
    let lost = |error: std::io::Error| {
        InputError::new(format!("cannot be read: {error}"), "give a survey file").in_file(file)
    };
    let real = file.canonicalize().map_err(lost)?;
    let beside = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let root = within.or(beside).unwrap_or(Path::new("."));
    let unusable = |error: std::io::Error| {
        let wrong = format!("the folder cannot be read: {error}");
        InputError::new(wrong, "give the folder that holds all of the survey").in_file(root)
    };
    let folder = Folder::new(root).map_err(unusable)?;
    let whole = root.canonicalize().map_err(unusable)?;
    if let Some(entry) = real.strip_prefix(&whole).ok().and_then(Path::to_str) {
        return read(&folder, &entry.replace('\\', "/"));
    }
    if within.is_some() {
        let wrong = format!("it does not lie within {}", root.display());
        let remedy = "give the folder that holds all of the survey";
        return Err(InputError::new(wrong, remedy).in_file(file));
    }
    // A file that the user names is read wherever a link leads.
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let named = Named { folder, name, path: file.to_owned(), real };
    read(&named, &named.name)
}

/// Reads the map `file` of these files, and what belongs to it.
///
/// # Errors
/// [`InputError`] where the map cannot be used.
pub fn open_in(files: &dyn Files, file: &Path) -> Result<Map, InputError> {
    refuse_image(file)?;
    read(files, &file.to_string_lossy(), file)
}

/// Refuses an image, which is but a part of a map.
fn refuse_image(file: &Path) -> Result<(), InputError> {
    let is_image = |ending: &std::ffi::OsStr| {
        ["bmp", "pgm", "png"].iter().any(|image| ending.eq_ignore_ascii_case(image))
    };
    if file.extension().is_some_and(is_image) {
        let remedy = "give the YAML file beside it, which says how large it is";
        return Err(InputError::new("an image alone is no map", remedy).in_file(file));
    }
    Ok(())
}

/// Reads the map `entry` of these files, of the kind that the name of `file` tells.
fn read(files: &dyn Files, entry: &str, file: &Path) -> Result<Map, InputError> {
    let map = match MapKind::of(file) {
        MapKind::Survey => cave_survey::read(files, entry).map(Map::Survey),
        MapKind::Subt => subt::read(files, entry).map(Map::Subt),
        MapKind::Grid => map_server::read(files, entry).map(Map::Grid),
    };
    map.map_err(refused)
}

/// A file that the user names, and the folder of what it includes.
struct Named {
    folder: Folder,
    name: String,
    path: PathBuf,
    real: PathBuf,
}

impl Files for Named {
    fn open(&self, path: &str) -> Result<Opened, FileError> {
        if path != self.name {
            return self.folder.open(path);
        }
        let bytes = read_whole(&self.real)?;
        Ok(Opened { path: self.path.to_string_lossy().into_owned(), bytes })
    }
}

/// The error of a survey that cannot be used.
fn refused(refusal: Refusal) -> InputError {
    let error = InputError::new(refusal.wrong, refusal.remedy);
    match refusal.place {
        Some(place) => {
            let column =
                if place.column > 0 { format!(":{}", place.column) } else { String::new() };
            let line = if place.line > 0 { format!(":{}", place.line) } else { String::new() };
            error.in_file(Path::new(&format!("{}{line}{column}", place.file)))
        }
        None => error,
    }
}
