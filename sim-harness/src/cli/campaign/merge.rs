//! `uchain campaign --merge`: the parts of a campaign put together.

use std::fs::File;
use std::path::{Path, PathBuf};

use input::InputError;

use super::report::Report;
use super::{Campaign, finish};
use crate::cli::{Common, Trouble, Verdict, interrupt};
use measure::campaign::Row;
use measure::campaign::grid::{self, Axis, Shard};
use report::{CampaignOrigin, Folder, Origin};
use scenario::Scenario;

/// The rows of one part, read one by one.
struct Part {
    path: PathBuf,
    records: csv::StringRecordsIntoIter<File>,
    line: usize,
}

pub(super) fn run(folders: &[PathBuf], common: &Common) -> Result<Verdict, Trouble> {
    let mut parts = Vec::new();
    is_no_part(common.out.as_deref(), folders)?;
    for folder in folders {
        Folder::is_as_written(folder)?;
        let (origin, scenario) = Origin::read(folder)?;
        parts.push((folder, of_campaign(folder, origin)?, scenario));
    }
    let Some((_, (first, seed), scenario)) = parts.first() else { return Ok(Verdict::Good) };
    let campaign = whole(first, *seed, scenario, &folders[0])?;
    let mut readers = in_order(&parts, first)?;
    interrupt::ends();
    let folder = common.folder()?;
    let mut report = Report::begin(&campaign, folder.as_ref())?;
    let count = readers.len();
    for point in 0..campaign.points.len() {
        report.begin_place(folder.as_ref(), point)?;
        for seed in campaign.missions_at(point) {
            let part = campaign.number(point, seed) % count;
            let row = readers[part].row(&campaign, point, seed)?;
            report.add(&campaign, folder.as_ref(), &[row])?;
        }
        report.end_place()?;
    }
    finish(&campaign, report, folder, None, common)
}

/// Refuses to write the whole campaign over one of its parts, which could not be merged again.
fn is_no_part(out: Option<&Path>, parts: &[PathBuf]) -> Result<(), InputError> {
    let Some((out, place)) = out.and_then(|out| Some((out, out.canonicalize().ok()?))) else {
        return Ok(());
    };
    if !parts.iter().any(|part| part.canonicalize().is_ok_and(|part| part == place)) {
        return Ok(());
    }
    let wrong = "this is one of the parts, which would be replaced by the whole";
    Err(InputError::new(wrong, "give --out another folder").in_file(out))
}

fn of_campaign(folder: &Path, origin: Origin) -> Result<(CampaignOrigin, u64), InputError> {
    let seed = origin.seed;
    let campaign = origin.campaign.map(|campaign| (campaign, seed));
    campaign.ok_or_else(|| {
        let remedy = "give folders of uchain campaign --shard";
        InputError::new("this is no part of a campaign", remedy).in_file(folder)
    })
}

/// The campaign of which this is a part.
fn whole(
    part: &CampaignOrigin,
    seed: u64,
    scenario: &Scenario,
    folder: &Path,
) -> Result<Campaign, InputError> {
    let axes = part.vary.iter().map(|text| Axis::parse(text)).collect::<Result<Vec<_>, _>>();
    let axes = axes.map_err(|error| error.in_file(folder))?;
    Ok(Campaign {
        scenario: scenario.clone(),
        points: grid::points(&axes)?,
        axes,
        runs: part.runs,
        seed,
        shard: Shard::WHOLE,
        crc32: part.crc32.clone(),
    })
}

/// The readers of all parts, in the order of their numbers.
fn in_order(
    parts: &[(&PathBuf, (CampaignOrigin, u64), Scenario)],
    first: &CampaignOrigin,
) -> Result<Vec<Part>, InputError> {
    let of = Shard::parse(&first.shard)?.of;
    let mut places: Vec<Option<&Path>> = vec![None; of];
    for (folder, (part, _), _) in parts {
        let shard = Shard::parse(&part.shard)?;
        if part.crc32 != first.crc32 || shard.of != of {
            let wrong = "this is a part of another campaign than the first folder";
            return Err(InputError::new(wrong, "give the parts of one campaign").in_file(folder));
        }
        if places[shard.number - 1].replace(folder).is_some() {
            let wrong = format!("part {shard} is there twice");
            return Err(InputError::new(wrong, "give each part once").in_file(folder));
        }
    }
    let mut readers = Vec::with_capacity(of);
    for (n, place) in places.into_iter().enumerate() {
        let folder = place.ok_or_else(|| {
            let wrong = format!("part {}/{of} is missing", n + 1);
            InputError::new(wrong, "give the folders of all parts")
        })?;
        readers.push(Part::open(&folder.join("runs.csv"))?);
    }
    Ok(readers)
}

impl Part {
    fn open(path: &Path) -> Result<Self, InputError> {
        let reader = csv::Reader::from_path(path).map_err(|error| {
            let remedy = "give folders of uchain campaign --shard";
            InputError::new(format!("cannot be read: {error}"), remedy).in_file(path)
        })?;
        Ok(Self { path: path.to_owned(), records: reader.into_records(), line: 1 })
    }

    /// The next row, which has to be of this mission.
    fn row(&mut self, campaign: &Campaign, point: usize, seed: u64) -> Result<Row, InputError> {
        self.line += 1;
        let record = self.records.next().and_then(Result::ok);
        let row = record.and_then(|record| {
            let keys = campaign.axes.len();
            let own: u64 = record.get(keys)?.parse().ok()?;
            let values: Vec<&str> = record.iter().skip(keys + 1).collect();
            Row::read(point, own, values.into_iter()).filter(|row| row.seed == seed)
        });
        row.ok_or_else(|| {
            let wrong = format!("the row of seed {seed} is missing or damaged");
            let remedy = "fly this part again, with --resume where it was stopped";
            InputError::new(wrong, remedy).at_line(&self.path, self.line)
        })
    }
}
