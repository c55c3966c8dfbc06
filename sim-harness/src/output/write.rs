//! Puts a run's files into a directory, each whole or not at all.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::pictures::{self, Picture, PictureError};
use super::{csv, mcap, report};
use crate::input_error::InputError;
use crate::trace::Trace;

/// A run's files could not be written.
#[derive(Debug)]
pub enum OutputError {
    /// The directory cannot be used: the user's to mend.
    Input(InputError),
    /// Something that should not be able to fail did.
    Picture(PictureError),
}

impl fmt::Display for OutputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => error.fmt(f),
            Self::Picture(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for OutputError {}

impl From<InputError> for OutputError {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<PictureError> for OutputError {
    fn from(error: PictureError) -> Self {
        Self::Picture(error)
    }
}

/// Writes everything that is made of one mission into `dir`, which is created if need be:
/// `summary.json`, `trace.csv`, `trace.mcap`, `report.html`, and `map`, `links` and `positions`
/// as SVG and PNG. Returns the paths, in that order. Files of these names are replaced.
///
/// # Errors
/// [`OutputError::Input`] if the directory cannot be created or written to.
pub fn write_all(
    dir: &Path,
    trace: &Trace,
    summary: &serde_json::Value,
) -> Result<Vec<PathBuf>, OutputError> {
    let page = report::html(trace, summary)?;
    let mut written = vec![
        put_json(dir, "summary.json", summary)?,
        put(dir, "trace.csv", |out| csv::write(trace, out))?,
        put(dir, "trace.mcap", |out| Ok(mcap::write(trace, out)?))?,
        put(dir, "report.html", |out| out.write_all(page.as_bytes()))?,
    ];
    for (name, picture) in [
        ("map", pictures::map(trace)?),
        ("links", pictures::links(trace)?),
        ("positions", pictures::positions(trace)?),
    ] {
        written.extend(put_picture(dir, name, &picture)?);
    }
    Ok(written)
}

/// Writes a picture as `name.svg` and `name.png`, each whole or not at all.
///
/// # Errors
/// As [`write_all`].
pub fn put_picture(dir: &Path, name: &str, picture: &Picture) -> Result<[PathBuf; 2], OutputError> {
    let png = picture.png()?;
    Ok([
        put(dir, &format!("{name}.svg"), |out| out.write_all(picture.svg().as_bytes()))?,
        put(dir, &format!("{name}.png"), |out| out.write_all(&png))?,
    ])
}

/// Writes a value as indented JSON, whole or not at all; the directory is created if need be.
///
/// # Errors
/// As [`put`].
pub fn put_json(
    dir: &Path,
    name: &str,
    value: &impl serde::Serialize,
) -> Result<PathBuf, InputError> {
    put(dir, name, |out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        out.write_all(b"\n")
    })
}

/// Writes a text into a directory.
///
/// # Errors
/// If the file cannot be created or filled.
pub fn put_text(dir: &Path, name: &str, text: &str) -> Result<PathBuf, InputError> {
    put(dir, name, |out| out.write_all(text.as_bytes()))
}

/// Writes one file into a directory, which is created if need be: under a name of its own first, so that who reads
/// it never sees half of it. Returns its path.
///
/// # Errors
/// If the file cannot be created or filled.
pub fn put(
    dir: &Path,
    name: &str,
    fill: impl FnOnce(&mut io::BufWriter<File>) -> io::Result<()>,
) -> Result<PathBuf, InputError> {
    let path = dir.join(name);
    let unfinished = dir.join(format!(".{name}.unfinished"));
    fs::create_dir_all(dir).map_err(|error| unusable(dir, &error))?;
    let written = File::create(&unfinished).and_then(|file| {
        let mut out = io::BufWriter::new(file);
        fill(&mut out)?;
        out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
        fs::rename(&unfinished, &path)
    });
    match written {
        Ok(()) => Ok(path),
        Err(error) => {
            // Best effort: what is wrong already has been said.
            let _ = fs::remove_file(&unfinished);
            Err(unusable(&path, &error))
        }
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
mod tests {
    use serde_json::json;

    use super::*;
    use crate::output::synthetic;

    /// A directory of this test's own, gone when dropped.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("uchain-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            Self(path)
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn short_mission() -> Trace {
        let mut trace = synthetic::mission();
        trace.frames.truncate(400);
        trace
    }

    #[test]
    fn everything_is_written_and_nothing_else_is_left() {
        let scratch = Scratch::new("all");
        let dir = scratch.0.join("made/for/it");
        let summary = json!({ "success": true });
        let mut written = write_all(&dir, &short_mission(), &summary).unwrap();
        let mut found: Vec<_> =
            fs::read_dir(&dir).unwrap().map(|entry| entry.unwrap().path()).collect();
        written.sort();
        found.sort();
        assert_eq!(written, found);
        assert_eq!(written.len(), 10);
        assert!(fs::read(dir.join("map.png")).unwrap().starts_with(b"\x89PNG"));
        let read: serde_json::Value =
            serde_json::from_slice(&fs::read(dir.join("summary.json")).unwrap()).unwrap();
        assert_eq!(read, summary);
    }

    #[test]
    fn one_mission_makes_the_same_bytes_every_time() {
        let scratches = [Scratch::new("once"), Scratch::new("twice")];
        let mut trace = synthetic::mission();
        trace.frames.truncate(50);
        let all = scratches.each_ref().map(|s| write_all(&s.0, &trace, &json!({})).unwrap());
        for (one, other) in all[0].iter().zip(&all[1]) {
            assert!(fs::read(one).unwrap() == fs::read(other).unwrap(), "{}", one.display());
        }
    }

    #[test]
    fn a_directory_that_cannot_be_is_bad_input() {
        let scratch = Scratch::new("blocked");
        fs::create_dir_all(&scratch.0).unwrap();
        let file = scratch.0.join("file");
        fs::write(&file, "").unwrap();
        let error = write_all(&file.join("out"), &short_mission(), &json!({})).unwrap_err();
        assert!(matches!(error, OutputError::Input(_)));
        assert!(error.to_string().contains("give --out a directory"));
        assert_eq!(error.to_string().lines().count(), 1);
    }
}
