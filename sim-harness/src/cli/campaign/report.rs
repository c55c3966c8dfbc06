//! The files and the table of a campaign, made from its rows.

use std::fmt::Write;
use std::fs::File;
use std::io;

use input::InputError;
use serde_json::{Map, Value, json};

use super::Campaign;
use crate::cli::{Common, Trouble};
use measure::campaign::{COLUMNS, Figure, Figures, Row, Tally, Verdicts, json as figures_json};
use report::{Folder, RunsParquet, Streamed};
use scenario::Setting;

/// The table with a row for each mission.
const RUNS: &str = "runs.csv";
/// The same table for programs.
const RUNS_PARQUET: &str = "runs.parquet";

/// The report of a campaign, place by place of its grid.
pub(super) struct Report {
    tables: Option<Tables>,
    places: Vec<Place>,
    /// The place whose rows come.
    current: Option<Counted>,
    /// How many missions were flown.
    pub(super) flown: usize,
    /// How many of them failed.
    pub(super) failed: usize,
    /// The values of the varied keys at each place, as they are written.
    keys: Vec<Vec<String>>,
}

/// The rows of one place of the grid, as far as they have come. Their memory does not grow with their
/// number.
struct Counted {
    point: usize,
    runs: usize,
    tally: Tally,
    figures: Figures<File>,
}

/// The figures of one place of the grid.
struct Place {
    point: usize,
    runs: usize,
    verdicts: Verdicts,
    figures: Vec<Figure>,
}

impl Place {
    fn json(&self) -> [(String, Value); 2] {
        [("verdict", self.verdicts.json()), ("metrics", figures_json(&self.figures))]
            .map(|(name, value)| (name.to_owned(), value))
    }
}

/// The tables with a row for each mission.
struct Tables {
    csv: csv::Writer<Streamed>,
    parquet: RunsParquet<Streamed>,
}

impl Tables {
    fn begin(campaign: &Campaign, folder: &Folder) -> Result<Self, InputError> {
        let mut csv = csv::Writer::from_writer(folder.stream(RUNS)?);
        let names = campaign.axes.iter().map(|axis| axis.key()).chain(["seed"]);
        let written = csv.write_record(names.chain(COLUMNS.iter().map(|column| column.name)));
        written.map_err(|error| folder.unwritten(RUNS, &error.into()))?;
        let parquet = RunsParquet::begin(folder.stream(RUNS_PARQUET)?, &campaign.axes);
        let parquet = parquet.map_err(|error| folder.unwritten(RUNS_PARQUET, &error))?;
        Ok(Self { csv, parquet })
    }

    fn add(
        &mut self,
        folder: &Folder,
        keys: &[String],
        settings: &[Setting],
        row: &Row,
    ) -> Result<(), InputError> {
        let keys = keys.iter().cloned().chain([row.seed.to_string()]);
        let written = self.csv.write_record(keys.chain(row.texts()));
        written.map_err(|error| folder.unwritten(RUNS, &error.into()))?;
        let written = self.parquet.add(settings, row);
        written.map_err(|error| folder.unwritten(RUNS_PARQUET, &error))
    }

    fn finish(self, folder: &mut Folder) -> Result<(), InputError> {
        let csv = self.csv.into_inner().map_err(csv::IntoInnerError::into_error);
        folder.keep(csv.map_err(|error| folder.unwritten(RUNS, &error))?)?;
        let parquet = self.parquet.finish();
        folder.keep(parquet.map_err(|error| folder.unwritten(RUNS_PARQUET, &error))?)
    }
}

impl Report {
    /// Begins the files.
    pub(super) fn begin(campaign: &Campaign, folder: Option<&Folder>) -> Result<Self, InputError> {
        let value = |setting: &Setting| match setting.value() {
            toml::Value::String(text) => text.clone(),
            value => value.to_string(),
        };
        let keys = campaign.points.iter().map(|point| point.iter().map(value).collect()).collect();
        let tables = folder.map(|folder| Tables::begin(campaign, folder)).transpose()?;
        Ok(Self { tables, places: Vec::new(), current: None, flown: 0, failed: 0, keys })
    }

    /// Begins with the rows of a place.
    pub(super) fn begin_place(
        &mut self,
        folder: Option<&Folder>,
        point: usize,
    ) -> Result<(), InputError> {
        let scratch = folder.map_or_else(tempfile::tempfile, Folder::scratch);
        let figures = Figures::new(scratch.map_err(|error| unkept(&error))?);
        self.current = Some(Counted { point, runs: 0, tally: Tally::default(), figures });
        Ok(())
    }

    /// Adds rows of the place, in the order of the seeds.
    pub(super) fn add(
        &mut self,
        campaign: &Campaign,
        folder: Option<&Folder>,
        rows: &[Row],
    ) -> Result<(), InputError> {
        let Some(place) = &mut self.current else { return Ok(()) };
        let point = place.point;
        for row in rows {
            if let Some((folder, tables)) = folder.zip(self.tables.as_mut()) {
                tables.add(folder, &self.keys[point], &campaign.points[point], row)?;
            }
            place.runs += 1;
            place.tally.add(row.seed, &row.outcome);
            place.figures.add(&row.metrics).map_err(|error| unkept(&error))?;
        }
        Ok(())
    }

    /// Makes the figures of the place.
    pub(super) fn end_place(&mut self) -> Result<(), InputError> {
        let Some(Counted { point, runs, tally, figures }) = self.current.take() else {
            return Ok(());
        };
        if runs == 0 {
            return Ok(());
        }
        let verdicts = tally.verdicts();
        let figures = figures.finish().map_err(|error| unkept(&error))?;
        self.flown += runs;
        self.failed += verdicts.failed();
        self.places.push(Place { point, runs, verdicts, figures });
        Ok(())
    }

    /// Writes the summary and the origin, and prints the result the way it was asked for.
    pub(super) fn finish(
        mut self,
        campaign: &Campaign,
        mut folder: Option<Folder>,
        common: &Common,
    ) -> Result<(), Trouble> {
        let summary = self.summary(campaign);
        if let Some(folder) = &mut folder {
            folder.put_json("summary.json", &summary)?;
            if let Some(tables) = self.tables.take() {
                tables.finish(folder)?;
            }
            campaign.origin().write(folder, &campaign.scenario)?;
        }
        common.finish(folder, &self.text(campaign), &summary)
    }

    fn summary(&self, campaign: &Campaign) -> Value {
        let scenario = &campaign.scenario;
        let mut summary = json!({
            "scenario": scenario.name,
            "policy": scenario.policy,
            "fidelity": scenario.fidelity.name(),
            "link": scenario.link.name(),
            "seed": campaign.seed,
            "runs": self.flown,
            "runs_asked": campaign.missions().count(),
            "version": env!("CARGO_PKG_VERSION"),
        });
        let Some(entries) = summary.as_object_mut() else { return summary };
        match (campaign.axes.as_slice(), self.places.as_slice()) {
            ([], [place]) => entries.extend(place.json()),
            _ => {
                let entry = |place: &Place| {
                    let names = campaign.axes.iter().map(|axis| axis.key().to_owned());
                    let keys = names.zip(self.keys[place.point].iter().map(|value| json!(value)));
                    let mut entry = Map::new();
                    entry.insert("set".into(), Value::Object(keys.collect()));
                    entry.insert("runs".into(), json!(place.runs));
                    entry.extend(place.json());
                    Value::Object(entry)
                };
                entries.insert("grid".into(), self.places.iter().map(entry).collect());
            }
        }
        summary
    }

    fn text(&self, campaign: &Campaign) -> String {
        let scenario = &campaign.scenario;
        let count = counted(self.flown, campaign.missions().count());
        let heading = format!("{}: {count} missions, policy {}", scenario.name, scenario.policy);
        match (campaign.axes.as_slice(), self.places.as_slice()) {
            ([], [place]) => table(&heading, place),
            _ => {
                let mut text = format!("{heading}\n");
                for place in &self.places {
                    let settings = campaign.points[place.point].iter().map(Setting::to_string);
                    let settings = settings.collect::<Vec<_>>().join(" ");
                    let heading = format!("\n{settings}: {} missions", place.runs);
                    text += &table(&heading, place);
                }
                text
            }
        }
    }
}

/// The values of which quantiles are made could not be kept.
fn unkept(error: &io::Error) -> InputError {
    let wrong = format!("the times of the missions cannot be kept in a temporary file: {error}");
    let remedy =
        "make room on the disk of --out or, without --out, of the folder for temporary files";
    InputError::new(wrong, remedy)
}

/// The number of missions that were flown, and of how many where that is fewer.
pub(super) fn counted(flown: usize, asked: usize) -> String {
    if flown == asked { flown.to_string() } else { format!("{flown} of {asked}") }
}

fn table(heading: &str, place: &Place) -> String {
    let verdicts = place.verdicts.table();
    let mut text = format!("{heading}\n\n{verdicts}\n  {:18} {:>10}   95 % interval\n", "", "");
    for Figure { name, estimate } in &place.figures {
        // Writing to a string cannot fail.
        let _ = write!(text, "  {name:18} {:>10.3}", estimate.value);
        if let Some((low, high)) = estimate.interval {
            let _ = write!(text, "   {low:.3} to {high:.3}");
        }
        text.push('\n');
    }
    text
}
