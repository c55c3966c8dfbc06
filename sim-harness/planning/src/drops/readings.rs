//! Reads what was received of relays on the ground, from a table.
//!
//! The table is CSV with a header. Its columns, in any order, are `x_m` and `y_m`, where the receiver
//! was in the coordinates of the map; `reference`, the number of what it received, 0 for the base and n
//! for the n-th relay that stands; and `snr_db`, or `rssi_dbm` for a receiver whose noise is known.

use std::path::Path;

use cave_worlds::World;
use input::InputError;
use relay_placement::{Correction, Curve, Readings, RefineConfig};
use units::{Db, Point2};

use super::Site;

/// The places at which the readings of a reference are kept apart.
const SPOTS: usize = 64;

/// The ratios that are taken for readings, dB: a radio of LoRa's kind hears 20 dB below the noise, and
/// one next to the transmitter is 100 dB above it.
const RATIOS: [f64; 2] = [-30.0, 120.0];

/// The readings of each reference.
pub struct Received {
    readings: Vec<Readings<SPOTS>>,
    counts: Vec<usize>,
}

impl Received {
    /// Reads a table of the base and the relays that stand at a site; `noise_dbm` is the noise of the
    /// receiver.
    ///
    /// # Errors
    /// [`InputError`] with the line of the first reading that cannot be used.
    pub fn read(
        file: &Path,
        site: &mut Site<'_>,
        noise_dbm: Option<f64>,
    ) -> Result<Self, InputError> {
        let references = site.ways();
        let text = input::file::read_text(file, input::file::LARGEST_TEXT).map_err(|why| {
            let remedy = "give a CSV file, saved as UTF-8";
            InputError::new(format!("cannot be read: {why}"), remedy).in_file(file)
        })?;
        let mut table = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let columns = Columns::of(table.headers().map_err(|why| no_table(file, &why))?, noise_dbm)
            .map_err(|error| error.in_file(file))?;
        let mut received = Self {
            readings: vec![Readings::new(RefineConfig::DEFAULT); references.len()],
            counts: vec![0; references.len()],
        };
        for record in table.records() {
            let record = record.map_err(|why| no_table(file, &why))?;
            let line = record.position().map_or(0, csv::Position::line) as usize;
            let reading = columns
                .reading(&record, site.world(), references.len())
                .map_err(|error| error.at_line(file, line))?;
            let own =
                received.readings.get_mut(reading.reference).zip(references.get(reading.reference));
            if let Some((readings, ways)) = own {
                let model = Curve::DEFAULT.at(ways.to(reading.at));
                // A reading of finite numbers is never refused.
                let _ = readings.add(reading.at, reading.ratio - model);
                received.counts[reading.reference] += 1;
            }
        }
        if received.counts.iter().all(|count| *count == 0) {
            let remedy = "give a table with at least one reading";
            return Err(InputError::new("there is no reading", remedy).in_file(file));
        }
        Ok(received)
    }

    /// What the strength of a reference is over the curve's, at any point.
    pub fn corrections(&self, reference: usize) -> impl Fn(Point2) -> Correction + '_ {
        let fit = self.readings.get(reference).map(Readings::fit);
        move |at| fit.as_ref().map_or(Correction::NONE, |fit| fit.at(at))
    }

    /// Of each reference the number of readings, and by how much it is over the curve far from them.
    pub fn summary(&self) -> impl Iterator<Item = (usize, Db)> + '_ {
        let far = Point2::new(1e6, 1e6);
        self.counts
            .iter()
            .enumerate()
            .map(move |(n, count)| (*count, self.corrections(n)(far).over))
    }
}

fn no_table(file: &Path, why: &csv::Error) -> InputError {
    let error =
        InputError::new(format!("this is no table: {why}"), "give a CSV file with a header");
    match why.position() {
        Some(position) => error.at_line(file, position.line() as usize),
        None => error.in_file(file),
    }
}

/// A reading that can be used.
struct Reading {
    at: Point2,
    reference: usize,
    ratio: Db,
}

/// Where the columns are.
struct Columns {
    x: usize,
    y: usize,
    reference: usize,
    strength: usize,
    /// The name of the column of the strength.
    name: &'static str,
    /// What is taken off the strength to have a ratio, dB.
    noise: f64,
}

impl Columns {
    fn of(header: &csv::StringRecord, noise_dbm: Option<f64>) -> Result<Self, InputError> {
        let find = |name: &str| header.iter().position(|column| column == name);
        let column = |name: &str| {
            find(name).ok_or_else(|| {
                let remedy = "give x_m, y_m, reference and snr_db or rssi_dbm";
                InputError::new(format!("there is no column {name}"), remedy)
            })
        };
        let (strength, name, noise) = match (find("snr_db"), find("rssi_dbm"), noise_dbm) {
            (Some(at), _, _) => (at, "snr_db", 0.0),
            (None, Some(at), Some(noise)) => (at, "rssi_dbm", noise),
            (None, Some(_), None) => {
                let remedy = "give it as --noise-dbm, or a column snr_db";
                return Err(InputError::new("rssi_dbm needs the noise of the receiver", remedy));
            }
            (None, None, _) => (column("snr_db")?, "snr_db", 0.0),
        };
        let (x, y, reference) = (column("x_m")?, column("y_m")?, column("reference")?);
        Ok(Self { x, y, reference, strength, name, noise })
    }

    fn reading(
        &self,
        record: &csv::StringRecord,
        world: &World,
        references: usize,
    ) -> Result<Reading, InputError> {
        let text = |at: usize| record.get(at).unwrap_or("");
        let number = |at: usize, name: &str| {
            let number = text(at).parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| {
                let wrong = format!("{name} is {:?}, which is no finite number", text(at));
                InputError::new(wrong, "correct it, or leave the line out")
            })
        };
        let place = [number(self.x, "x_m")?, number(self.y, "y_m")?];
        let at = world.point(place);
        if world.map.frame().cell_at(at).is_none() {
            let wrong = format!("{},{} lies outside the map", place[0], place[1]);
            return Err(InputError::new(wrong, "give points in the coordinates of the map"));
        }
        let strength = number(self.strength, self.name)?;
        let [least, most] = RATIOS.map(|ratio| ratio + self.noise);
        if !(least..=most).contains(&strength) {
            let wrong =
                format!("{} is {:?}, which is out of range", self.name, text(self.strength));
            return Err(InputError::new(wrong, format!("give a number from {least} to {most}")));
        }
        let ratio = Db((strength - self.noise) as f32);
        let reference = text(self.reference).parse().ok();
        let reference = reference.filter(|n| *n < references).ok_or_else(|| {
            let wrong = format!("there is no reference {:?}", text(self.reference));
            let remedy = match references {
                1 => "0 is the base; give other relays that stand as --relay X,Y".to_owned(),
                count => format!("0 is the base, 1 to {} are the relays that stand", count - 1),
            };
            InputError::new(wrong, remedy)
        })?;
        Ok(Reading { at, reference, ratio })
    }
}
