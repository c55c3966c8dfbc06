//! Opens the files of a map, and says why one cannot be opened.

use std::sync::Arc;

use cave_survey::{FileError, Files, Opened, Place, Refusal};

/// Opens a file of at most `largest` bytes.
pub(crate) fn open(files: &dyn Files, path: &str, largest: usize) -> Result<Opened, Refusal> {
    let opened = files.open(path).map_err(|error| unopened(path, &error))?;
    if opened.bytes.len() > largest {
        let wrong = format!("it has {} bytes", opened.bytes.len());
        let remedy = format!("give a file of at most {largest}");
        return Err(Refusal::new(wrong, remedy).at(whole(&opened.path)));
    }
    Ok(opened)
}

fn unopened(path: &str, error: &FileError) -> Refusal {
    match error {
        FileError::Missing if [".dot", ".sdf"].iter().any(|end| path.ends_with(end)) => {
            Refusal::new(
                format!("there is no file \"{path}\""),
                "give both files of the world, its .dot and its .sdf, beside each other",
            )
        }
        FileError::Missing => {
            Refusal::new(format!("there is no file \"{path}\""), "give its right name")
        }
        FileError::Outside => {
            let wrong = format!("\"{path}\" lies outside the map's folder");
            Refusal::new(wrong, "put it beside the map")
        }
        FileError::Utf16 => {
            Refusal::new(format!("\"{path}\" is text in UTF-16"), "save it as UTF-8")
        }
        FileError::Unreadable(why) => {
            Refusal::new(format!("\"{path}\" cannot be read: {why}"), "give a file that can")
        }
    }
}

/// The text of a file.
pub(crate) fn text(opened: &Opened) -> Result<&str, Refusal> {
    std::str::from_utf8(&opened.bytes).map_err(|error| {
        let before = &opened.bytes[..error.valid_up_to()];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        let wrong = "this is not text in UTF-8";
        Refusal::new(wrong, "save the file as UTF-8").at(line_of(&opened.path, line))
    })
}

/// The place of a whole file.
pub(crate) fn whole(file: &str) -> Place {
    line_of(file, 0)
}

/// The place of a line, the first being 1.
pub(crate) fn line_of(file: &str, line: usize) -> Place {
    Place { file: Arc::from(file), line: u32::try_from(line).unwrap_or(u32::MAX), column: 0 }
}
