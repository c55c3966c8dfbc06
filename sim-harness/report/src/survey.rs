//! Writes a survey as tables: `stations.csv`, `legs.csv` and `passages.csv`.
//!
//! A station without a name is called `#` and its number in `stations.csv`, from 1. Metres have
//! three decimals; a field is empty where nothing was measured.

use std::io;

use cave_survey::{StationId, Survey};
use input::InputError;

use super::Folder;

/// Writes the tables into the folder.
///
/// # Errors
/// [`InputError`] where a file cannot be written.
pub fn write(folder: &mut Folder, survey: &Survey) -> Result<(), InputError> {
    folder.put("stations.csv", |out| stations(survey, out))?;
    folder.put("legs.csv", |out| legs(survey, out))?;
    folder.put("passages.csv", |out| passages(survey, out))
}

fn name(survey: &Survey, station: StationId) -> String {
    match &*survey.stations[station].name {
        "" => format!("#{}", station + 1),
        name => name.to_owned(),
    }
}

fn metres(length: f64) -> String {
    format!("{length:.3}")
}

fn stations(survey: &Survey, out: impl io::Write) -> io::Result<()> {
    let mut csv = ::csv::Writer::from_writer(out);
    csv.write_record(["station", "east_m", "north_m", "up_m", "entrance", "wall"])?;
    for (number, station) in survey.stations.iter().enumerate() {
        let [east, north, up] = station.position.map(metres);
        let flag = |is: bool| if is { "1" } else { "0" }.to_owned();
        let flags = [flag(station.is_entrance), flag(station.is_wall)];
        csv.write_record([name(survey, number), east, north, up].into_iter().chain(flags))?;
    }
    csv.flush()
}

fn legs(survey: &Survey, out: impl io::Write) -> io::Result<()> {
    let mut csv = ::csv::Writer::from_writer(out);
    csv.write_record(["from", "to", "measured_m", "adjusted_m", "flags"])?;
    for leg in &survey.legs {
        let flags = [
            (leg.flags.surface, "surface"),
            (leg.flags.duplicate, "duplicate"),
            (leg.flags.splay, "splay"),
            (leg.flags.dived, "dived"),
            (leg.flags.squeeze, "squeeze"),
        ];
        let flags: Vec<_> = flags.iter().filter(|(is, _)| *is).map(|(_, flag)| *flag).collect();
        csv.write_record([
            name(survey, leg.from),
            name(survey, leg.to),
            leg.length.map_or_else(String::new, metres),
            metres(cave_survey::norm(survey.vector(leg))),
            flags.join(" "),
        ])?;
    }
    csv.flush()
}

fn passages(survey: &Survey, out: impl io::Write) -> io::Result<()> {
    let mut csv = ::csv::Writer::from_writer(out);
    csv.write_record(["passage", "station", "left_m", "right_m", "up_m", "down_m"])?;
    for (number, passage) in (1..).zip(&survey.passages) {
        for section in passage {
            let sides = [section.left, section.right, section.up, section.down];
            let sides = sides.map(|side| side.map_or_else(String::new, metres));
            let head = [number.to_string(), name(survey, section.station)];
            csv.write_record(head.into_iter().chain(sides))?;
        }
    }
    csv.flush()
}
