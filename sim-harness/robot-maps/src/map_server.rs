//! Reads and writes the occupancy maps of ROS: a YAML file, and the PGM, PPM, PNG or BMP image that it names.
//!
//! The meaning of the keys is that of map_server (ROS 1) and nav2_map_server (ROS 2): a pixel of
//! value v has the probability p = (255 − v)/255 of being occupied, or v/255 with `negate`; it is
//! occupied above `occupied_thresh`, free below `free_thresh`, and otherwise unknown. In the mode
//! `scale` a pixel between the thresholds has a probability of its own, and in the mode `raw` v is
//! the probability in per cent, and unknown above 100. What is between the thresholds is neither
//! free nor occupied in either mode: unknown.
//!
//! What a map does not show is never free. The greys by which its writers mark cells that were never
//! seen are unknown whatever the thresholds say: map_saver's 205, which the `free_thresh` of 0.25 of
//! nav2's map_saver makes free, and the middle greys of Cartographer. So is what is not opaque.

mod bmp;
mod header;
mod image;
mod pgm;
mod png;
mod write;

use cave_survey::{Files, Refusal, Warning};

use self::image::Image;
use crate::occupancy::{Cell, Occupancy};
use crate::open::{line_of, open, text, whole};
use header::{Header, Mode};

pub use write::{IMAGE, write};

/// The most that is read of a YAML file, bytes.
const LARGEST_YAML: usize = 64 << 10;
/// The most that is read of an image, bytes: as many cells as a map may have, as plain text.
const LARGEST_IMAGE: usize = 8 * crate::occupancy::MOST_CELLS;

/// Reads the map that the YAML file `entry` describes.
///
/// # Errors
/// [`Refusal`] where it cannot be used.
pub fn read(files: &dyn Files, entry: &str) -> Result<Occupancy, Refusal> {
    let opened = open(files, entry, LARGEST_YAML)?;
    let (header, mut remarks) = Header::read(text(&opened)?, &opened.path)?;
    let (path, remark) = image_of(files, entry, &opened.path, &header)?;
    remarks.extend(remark);
    let file = open(files, &path, LARGEST_IMAGE)?;
    let (image, remark) = Image::read(&file.bytes, &file.path)?;
    if let Some(text) = remark {
        remarks.push(Warning { place: Some(whole(&file.path)), text });
    }
    let mut unseen = Unseen::default();
    let cells = image.upwards().map(|value| header.seen(value, &mut unseen)).collect();
    remarks.extend(unseen.remarks(&header, &opened.path, &file.path));
    let mut map = Occupancy::new(image.columns, cells, header.resolution_m, header.origin);
    map.warnings = remarks;
    Ok(map)
}

/// The path of the image within the set of files: relative to the YAML, or, where it is the path
/// of another machine, the file of that name beside the YAML, with a remark.
fn image_of(
    files: &dyn Files,
    entry: &str,
    shown: &str,
    header: &Header,
) -> Result<(String, Option<Warning>), Refusal> {
    let name = header.image.replace('\\', "/");
    let folder = entry.rsplit_once('/').map_or("", |(folder, _)| folder);
    let beside = |name: &str| resolve(folder, name);
    let is_absolute = name.starts_with('/') || name.get(1..2) == Some(":");
    if !is_absolute
        && let Some(path) = beside(&name)
        && files.open(&path).is_ok()
    {
        return Ok((path, None));
    }
    let last = name.rsplit('/').next().unwrap_or(&name);
    let place = line_of(shown, header.image_line);
    match beside(last).filter(|path| files.open(path).is_ok()) {
        Some(path) => {
            let text = format!("{} is not here: {last} beside this file is read", header.image);
            Ok((path, Some(Warning { place: Some(place), text })))
        }
        None => {
            let wrong = format!("there is no image \"{}\"", header.image);
            let remedy = format!("put {last} beside this file");
            Err(Refusal::new(wrong, remedy).at(place))
        }
    }
}

/// The path of `name` beside `folder`, without `.` and `..`; `None` where it leads out of the set.
fn resolve(folder: &str, name: &str) -> Option<String> {
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(name.split('/')) {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

/// Greys that mark what was never seen, of 255: that of map_saver, and those of Cartographer.
const UNSEEN: [f64; 3] = [205.0, 128.0, 127.0];

/// What is unknown although the thresholds make it free.
#[derive(Default)]
struct Unseen {
    /// The grey of the first such cell, of 255.
    grey: f64,
    greys: usize,
    transparent: usize,
}

impl Unseen {
    fn remarks(&self, header: &Header, yaml: &str, image: &str) -> Vec<Warning> {
        let mut remarks = Vec::new();
        if self.greys > 0 {
            let Self { grey, greys, .. } = self;
            let text = format!(
                "free_thresh = {} makes grey {grey} free, by which maps mark what was never seen: its \
                 {greys} cells are taken as unknown",
                header.free_thresh
            );
            let place = Some(line_of(yaml, header.free_thresh_line));
            remarks.push(Warning { place, text });
        }
        if self.transparent > 0 {
            let text = format!("{} transparent pixels are taken as unknown", self.transparent);
            remarks.push(Warning { place: Some(whole(image)), text });
        }
        remarks
    }
}

impl Header {
    /// The state of a pixel, which is unknown where it marks what was never seen.
    fn seen(&self, value: Option<f64>, unseen: &mut Unseen) -> Cell {
        let Some(value) = value else {
            unseen.transparent += 1;
            return Cell::Unknown;
        };
        let state = self.state(value);
        let grey = (value * 255.0 * 1e3).round() * 1e-3;
        if state == Cell::Free && self.mode != Mode::Raw && UNSEEN.contains(&grey) {
            if unseen.greys == 0 {
                unseen.grey = grey;
            }
            unseen.greys += 1;
            return Cell::Unknown;
        }
        state
    }

    /// The state of a pixel of this brightness, from 0 for black to 1 for white.
    fn state(&self, value: f64) -> Cell {
        let occupied = match self.mode {
            Mode::Raw => match (value * 255.0).round() {
                percent if percent <= 100.0 => percent / 100.0,
                _ => return Cell::Unknown,
            },
            Mode::Trinary | Mode::Scale if self.negate => value,
            Mode::Trinary | Mode::Scale => 1.0 - value,
        };
        if occupied > self.occupied_thresh {
            Cell::Occupied
        } else if occupied < self.free_thresh {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }
}
