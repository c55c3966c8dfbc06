//! Tells the format of a file by its name's ending, and by its contents where the ending says nothing.

use crate::error::Refusal;
use crate::files;

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Survex,
    /// The processed surveys of Survex.
    Processed,
    CompassSurvey,
    CompassProject,
    WallsSurvey,
    WallsProject,
    Therion,
    VisualTopo,
    PocketTopo,
}

impl Format {
    /// The format that the ending of a name tells.
    pub(crate) fn named(name: &str) -> Option<Self> {
        match by_ending(name) {
            Ending::Read(format) => Some(format),
            Ending::Refused(..) | Ending::Unknown => None,
        }
    }

    /// The program whose format it is, and the ending that its files have.
    const fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Survex => ("Survex", ".svx"),
            Self::Processed => ("processed surveys of Survex", ".3d"),
            Self::CompassSurvey => ("Compass", ".dat"),
            Self::CompassProject => ("projects of Compass", ".mak"),
            Self::WallsSurvey => ("Walls", ".srv"),
            Self::WallsProject => ("projects of Walls", ".wpj"),
            Self::Therion => ("Therion", ".th"),
            Self::VisualTopo => ("VisualTopo", ".tro"),
            Self::PocketTopo => ("PocketTopo's text", ".txt"),
        }
    }
}

/// What the ending of a name says.
enum Ending {
    Read(Format),
    /// Files of the program are not read; the second text is the remedy.
    Refused(&'static str, &'static str),
    Unknown,
}

const PROCESS: &str = "export a .3d, a .svx or a .th";

fn by_ending(name: &str) -> Ending {
    let file = name.rsplit('/').next().unwrap_or(name).to_ascii_lowercase();
    let (stem, ending) = file.rsplit_once('.').unwrap_or((&file, ""));
    if stem == "thconfig" || ending == "thconfig" {
        return Ending::Read(Format::Therion);
    }
    match ending {
        "svx" => Ending::Read(Format::Survex),
        "3d" => Ending::Read(Format::Processed),
        "dat" | "clp" => Ending::Read(Format::CompassSurvey),
        "mak" => Ending::Read(Format::CompassProject),
        "srv" => Ending::Read(Format::WallsSurvey),
        "wpj" => Ending::Read(Format::WallsProject),
        "th" | "thc" => Ending::Read(Format::Therion),
        "tro" => Ending::Read(Format::VisualTopo),
        "th2" => Ending::Refused("drawings of Therion", "give the .th with the centreline"),
        "lox" => Ending::Refused("models of Therion", "export a .3d: export model -fmt survex"),
        "xvi" => Ending::Refused("sketches for Therion", "give the .th with the centreline"),
        "plt" => Ending::Refused("plots of Compass", "give the .dat or .mak, or export a .3d"),
        "top" => Ending::Refused("files of PocketTopo", "export it as Therion or text"),
        "trox" => {
            Ending::Refused("files of VisualTopo in XML", "save it as .tro, or export a .svx")
        }
        "csx" | "csz" => Ending::Refused("files of cSurvey", PROCESS),
        "tdr" | "zip" => Ending::Refused("archives of TopoDroid", PROCESS),
        "tab" => Ending::Refused("files of Toporobot", PROCESS),
        "gpx" | "kml" | "kmz" | "dxf" | "shp" | "svg" | "pdf" | "pos" => {
            Ending::Refused("drawings and positions without legs", PROCESS)
        }
        _ => Ending::Unknown,
    }
}

/// The format of a file.
///
/// # Errors
/// [`Refusal`] where such files are not read.
pub(crate) fn format(name: &str, bytes: &[u8]) -> Result<Format, Refusal> {
    let refused = |what: &str, remedy: &str| Refusal::new(format!("{what} are not read"), remedy);
    match by_ending(name) {
        Ending::Read(format) => Ok(format),
        Ending::Refused(what, remedy) => Err(refused(what, remedy)),
        Ending::Unknown => by_contents(bytes).map_err(|what| match what {
            Some((what, remedy)) => refused(what, remedy),
            None => Refusal::new(
                "this is no survey of a format that is read",
                "give one of Survex, Compass, Walls, Therion or VisualTopo, such as a .3d",
            ),
        }),
    }
}

/// The refusal of a file whose contents are of another format than its name says.
pub(crate) fn mistaken(read: Format, bytes: &[u8]) -> Option<Refusal> {
    let found = by_certain_lines(bytes).ok().filter(|found| *found != read)?;
    let ((program, ending), (expected, _)) = (found.described(), read.described());
    let wrong = format!("this looks like a file of {program}, and not of {expected}");
    Some(Refusal::new(wrong, format!("rename it to end in {ending}, or correct it")))
}

/// What is not read, and the remedy; `None` where it is not known what the file is.
type Unread = Option<(&'static str, &'static str)>;

/// The most bytes and lines at which is looked.
const LONGEST_HEAD: usize = 64 << 10;
const MOST_LINES: usize = 400;

/// The format of a file, of which a line of a leg may be all that it has.
fn by_contents(bytes: &[u8]) -> Result<Format, Unread> {
    let certain = by_certain_lines(bytes);
    let head = bytes.get(..LONGEST_HEAD).unwrap_or(bytes);
    let is_plain = || !head.contains(&0) && files::lines(&files::text(head)).any(is_leg);
    match certain {
        Err(None) if is_plain() => Ok(Format::Survex),
        known => known,
    }
}

/// The format by the first line that belongs to one format alone.
fn by_certain_lines(bytes: &[u8]) -> Result<Format, Unread> {
    if bytes.starts_with(b"Survex 3D Image File") {
        return Ok(Format::Processed);
    }
    if bytes.starts_with(b"Top\x03") {
        return Err(Some(("files of PocketTopo", "export it as Therion or text")));
    }
    let head = bytes.get(..LONGEST_HEAD).unwrap_or(bytes);
    if head.contains(&0) {
        return Err(None);
    }
    let text = files::text(head);
    if text.trim_start().starts_with('<') {
        return Err(Some(("files in XML", PROCESS)));
    }
    for line in files::lines(&text).take(MOST_LINES) {
        if let Some(format) = by_line(line.trim())? {
            return Ok(format);
        }
    }
    Err(None)
}

/// The format to which alone a line belongs.
fn by_line(line: &str) -> Result<Option<Format>, Unread> {
    let lower = line.to_ascii_lowercase();
    let mut words = lower.split_whitespace();
    let (first, second) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    Ok(match first {
        "survey" if matches!(second, "name:" | "date:" | "team:") => Some(Format::CompassSurvey),
        "declination:" => Some(Format::CompassSurvey),
        "survey" | "encoding" if line.starts_with(first) && words.clone().count() < 12 => {
            let is_leg = second.bytes().all(|byte| byte.is_ascii_digit());
            (!is_leg).then_some(Format::Therion)
        }
        "centreline" | "centerline" | "endsurvey" | "endcentreline" => Some(Format::Therion),
        "*begin" | "*data" | "*include" | "*title" | "*fix" | "*export" | "*equate" | "*cs"
        | "*calibrate" | "*units" | "*date" | "*team" | "*instrument" | "*entrance" | "*end" => {
            Some(Format::Survex)
        }
        "#units" | "#fix" | "#prefix" | "#date" | "#segment" | "#seg" | "#flag" | "#note" => {
            Some(Format::WallsSurvey)
        }
        ".book" | ".survey" => Some(Format::WallsProject),
        "param" if matches!(second, "deca" | "topof" | "topofil") => Some(Format::VisualTopo),
        "trou" | "entree" if line.starts_with(['T', 'E']) => Some(Format::VisualTopo),
        _ if lower.starts_with('#') && (lower.contains(".dat,") || lower.contains(".dat;")) => {
            Some(Format::CompassProject)
        }
        _ if matches!(line, "TRIP" | "FIX") => Some(Format::PocketTopo),
        _ if ["(m, 360)", "(m, 400)", "(ft, 360)"].iter().any(|units| line.ends_with(units)) => {
            Some(Format::PocketTopo)
        }
        _ if lower.starts_with("from,to,") => {
            return Err(Some(("tables of shots", PROCESS)));
        }
        _ => None,
    })
}

/// Whether a line is one leg: two names and three numbers.
fn is_leg(line: &str) -> bool {
    let line = line.split(';').next().unwrap_or(line);
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_number = |word: &&str| word.parse::<f64>().is_ok() || *word == "-";
    words.len() == 5 && words[2..].iter().all(is_number)
}
