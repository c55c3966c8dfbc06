//! `uchain campaign`: one scenario, many seeds, and a grid of settings.
//!
//! Rows are written as the missions end, into a file beside the folder of results, from which a
//! campaign that was stopped goes on; and all files are made from rows alone, so that the parts of
//! a campaign, merged, give the bytes of the whole.

mod journal;
mod merge;
mod report;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use clap::Args;
use crc32fast::Hasher;

use super::run::MapArgs;
use super::{
    Common, LinkArg, SetArgs, Trouble, Verdict, adapted, builtin_scenarios, complain, interrupt,
    on_the_host, with_link,
};
use ::report::{CampaignOrigin, Folder, Origin};
use measure::campaign::grid::{self, Axis, Shard};
use measure::campaign::{CHUNK, Place, Row};
use scenario::{Scenario, Setting};
use terminal::Progress;
use terminal::{FidelityArg, runs};

use input::InputError;
use journal::Journal;
use report::Report;

#[derive(Args)]
#[command(after_help = builtin_scenarios())]
pub(super) struct CampaignArgs {
    /// Name of a built-in scenario (listed below), or a scenario file; with --map it may be left out
    #[arg(required_unless_present_any = ["map", "merge"])]
    scenario: Option<String>,
    #[command(flatten)]
    map: MapArgs,
    /// Number of missions, for each place of the grid
    #[arg(long, allow_negative_numbers = true, default_value_t = 100, value_name = "N")]
    runs: usize,
    /// Number of relays, instead of the scenario's
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    relays: Option<usize>,
    /// Movement policy, instead of the scenario's: t0, t5, k, authors, k-tuned or chain
    #[arg(long, value_name = "NAME")]
    policy: Option<String>,
    /// How closely the drones are simulated
    #[arg(long, value_enum)]
    fidelity: Option<FidelityArg>,
    /// How reports and orders get from drone to drone
    #[arg(long, value_enum)]
    link: Option<LinkArg>,
    #[command(flatten)]
    set: SetArgs,
    /// Vary a key of the scenario: KEY=A:B:N for N values from A to B, or KEY=a,b,c; may be
    /// repeated, and every combination is flown
    #[arg(long, value_name = "KEY=VALUES")]
    vary: Vec<String>,
    /// Fly only the I-th of N parts, which --merge puts together
    #[arg(long, value_name = "I/N", requires = "out")]
    shard: Option<String>,
    /// Go on with a campaign that was stopped, from the rows beside --out
    #[arg(long, requires = "out")]
    resume: bool,
    /// Fly nothing, and put the parts in these folders together
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    #[arg(conflicts_with_all = [
        "scenario", "map", "depth", "runs", "relays", "policy", "fidelity", "link", "set", "vary",
        "shard", "resume", "seed",
    ])]
    merge: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// A campaign: a scenario for each place of its grid, and the seeds.
struct Campaign {
    /// The scenario without the settings of the grid.
    scenario: Scenario,
    axes: Vec<Axis>,
    /// The settings of each place.
    points: Vec<Vec<Setting>>,
    runs: usize,
    seed: u64,
    shard: Shard,
    /// The CRC-32 of all that the missions depend on, in hexadecimal.
    crc32: String,
}

pub(super) fn run(args: &CampaignArgs) -> Result<Verdict, Trouble> {
    if !args.merge.is_empty() {
        return merge::run(&args.merge, &args.common);
    }
    let (campaign, scenarios) = args.open()?;
    let stop = interrupt::asks(
        "Ctrl-C: the missions that have begun are flown to their ends; a second Ctrl-C drops all",
    );
    let folder = args.common.folder()?;
    let journal = args.common.out.as_deref();
    let journal = journal.map(|out| Journal::open(out, &campaign, args.resume)).transpose()?;
    let mut former = journal.as_ref().map(|journal| journal.rows(&campaign)).transpose()?;
    let progress = Progress::new(campaign.missions().count() as u64, args.common.quiet);
    progress.say("missions");
    let mut report = Report::begin(&campaign, folder.as_ref())?;
    for (point, scenario) in scenarios.iter().enumerate() {
        let place = Place::new(scenario, point);
        report.begin_place(folder.as_ref(), point)?;
        let mut missions = campaign.missions_at(point).peekable();
        while missions.peek().is_some() {
            let chunk: Vec<u64> = missions.by_ref().take(CHUNK).collect();
            let mut rows = former.as_mut().map_or(Ok(Vec::new()), |it| it.of(point, &chunk))?;
            rows.iter().for_each(|_| progress.step());
            rows.extend(fly(&place, &chunk, &rows, stop, journal.as_ref(), &progress));
            rows.sort_by_key(|row| row.seed.wrapping_sub(campaign.seed));
            if let Some(journal) = &journal {
                journal.is_written()?;
            }
            report.add(&campaign, folder.as_ref(), &rows)?;
        }
        report.end_place()?;
    }
    drop(progress);
    finish(&campaign, report, folder, journal, &args.common)
}

/// Flies those missions of a chunk of which there is no row yet.
fn fly(
    place: &Place<'_>,
    chunk: &[u64],
    known: &[Row],
    stop: &AtomicBool,
    journal: Option<&Journal>,
    progress: &Progress,
) -> Vec<Row> {
    let is_known = |seed: &u64| known.binary_search_by_key(seed, |row| row.seed).is_ok();
    let seeds: Vec<u64> = chunk.iter().copied().filter(|seed| !is_known(seed)).collect();
    if seeds.is_empty() {
        return Vec::new();
    }
    place.fly(stop, &seeds, |row| {
        if journal.is_some_and(|journal| !journal.add(row)) {
            stop_at_once(stop);
        }
        progress.step();
    })
}

/// Lets no further mission begin, because its row could not be kept.
fn stop_at_once(stop: &AtomicBool) {
    stop.store(true, std::sync::atomic::Ordering::Relaxed);
}

/// Writes the summary, and says how it went.
fn finish(
    campaign: &Campaign,
    report: Report,
    folder: Option<Folder>,
    journal: Option<Journal>,
    common: &Common,
) -> Result<Verdict, Trouble> {
    let (flown, failed) = (report.flown, report.failed);
    let asked = campaign.missions().count();
    if flown == 0 && asked > 0 {
        complain("interrupted before a mission was flown; nothing was written");
        journal.map_or(Ok(()), Journal::remove)?;
        return Ok(Verdict::Interrupted);
    }
    report.finish(campaign, folder, common)?;
    let name = &campaign.scenario.name;
    if failed > 0 {
        complain(format_args!("{name}: {failed} of {flown} missions failed"));
    }
    if flown < asked {
        let count = report::counted(flown, asked);
        complain(format_args!("interrupted; the figures are of {count} missions"));
        return Ok(Verdict::Interrupted);
    }
    journal.map_or(Ok(()), Journal::remove)?;
    Ok(if failed == 0 { Verdict::Good } else { Verdict::Failed })
}

impl CampaignArgs {
    /// The campaign, and the scenario of each place of its grid.
    fn open(&self) -> Result<(Campaign, Vec<Scenario>), InputError> {
        let settings = self.set.settings()?;
        let open = |more: &[Setting]| {
            let settings = settings.iter().chain(more).cloned().collect();
            let scenario = self.map.mission(self.scenario.as_deref(), self.relays, settings)?;
            let scenario = adapted(scenario, self.policy.as_deref(), self.fidelity)?;
            with_link(on_the_host(scenario)?, self.link)
        };
        let runs = runs(self.runs)?;
        let axes = self.vary.iter().map(|text| Axis::parse(text)).collect::<Result<Vec<_>, _>>()?;
        let points = grid::points(&axes)?;
        let scenario = open(&[])?;
        if let Some(route) = &scenario.route {
            route.warnings.iter().for_each(complain);
        }
        let scenarios = match axes.is_empty() {
            true => vec![scenario.clone()],
            false => points.iter().map(|point| open(point)).collect::<Result<_, _>>()?,
        };
        let shard = self.shard.as_deref().map_or(Ok(Shard::WHOLE), Shard::parse)?;
        let seed = self.common.seed;
        let crc32 = crc32(&scenarios, runs, seed);
        Ok((Campaign { scenario, axes, points, runs, seed, shard, crc32 }, scenarios))
    }
}

/// The CRC-32 of all that the missions of a campaign depend on.
fn crc32(scenarios: &[Scenario], runs: usize, seed: u64) -> String {
    let mut hasher = Hasher::new();
    hasher.update(format!("{} {runs} {seed}\n", env!("CARGO_PKG_VERSION")).as_bytes());
    for scenario in scenarios {
        hasher.update(scenario.resolved().as_bytes());
    }
    format!("{:08x}", hasher.finalize())
}

impl Campaign {
    /// The place in the grid and the seed of each mission of this part, in order.
    fn missions(&self) -> impl Iterator<Item = (usize, u64)> {
        (0..self.points.len()).flat_map(|point| self.missions_at(point).map(move |it| (point, it)))
    }

    /// The seeds of the missions of this part at one place of the grid, in order.
    fn missions_at(&self, point: usize) -> impl Iterator<Item = u64> {
        let all = (0..self.runs).filter(move |n| self.shard.has(point * self.runs + n));
        all.map(|n| self.seed.wrapping_add(n as u64))
    }

    /// The number of a mission over all places of the grid.
    const fn number(&self, point: usize, seed: u64) -> usize {
        point * self.runs + seed.wrapping_sub(self.seed) as usize
    }

    /// The origin that the folder of results records.
    fn origin(&self) -> Origin {
        let campaign = CampaignOrigin {
            runs: self.runs,
            vary: self.axes.iter().map(Axis::to_string).collect(),
            crc32: self.crc32.clone(),
            shard: self.shard.to_string(),
        };
        let origin = Origin::of("campaign", &self.scenario, self.seed);
        Origin { campaign: Some(campaign), ..origin }
    }
}
