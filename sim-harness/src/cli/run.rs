//! `uchain run`: one mission.

mod drawn;
mod table;

use std::path::{Path, PathBuf};

use clap::Args;

use super::emulated::{Aftermath, Base, Fleet};
use super::map::put_map;
use super::{
    Common, LinkArg, SetArgs, Trouble, Verdict, VirtualArgs, adapted, builtin_scenarios, complain,
    interrupt, with_link,
};
use measure::metrics::{Reference, RunMetrics, Watch};
use measure::verdict::Judgement;
use mission::trace::{Thinning, Trace};
use mission::{Mission, ROUND_US};
use report::{Folder, Origin, TraceFiles, summary};
use robot_maps::Occupancy;
use scenario::{Changes, DEPTHS, Fidelity, Scenario, Setting, builtin};
use terminal::FidelityArg;
use terminal::Progress;

use input::InputError;
use maps::{Ends, MapChoice};
use table::table;
use world::layout::FARTHEST;

#[derive(Args)]
#[command(after_help = builtin_scenarios())]
pub(super) struct RunArgs {
    /// Name of a built-in scenario (listed below), or a scenario file; where left out, the
    /// demonstration, or with --map a chain along the map's route
    scenario: Option<String>,
    #[command(flatten)]
    map: MapArgs,
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
    /// Fly the mission again whose results this folder holds, with its scenario and its seed
    #[arg(long, value_name = "FOLDER")]
    #[arg(conflicts_with_all = [
        "scenario", "map", "depth", "relays", "policy", "fidelity", "link", "set", "seed",
    ])]
    again: Option<PathBuf>,
    /// The former option for virtual drones, refused with a line that names the present one
    #[arg(long, hide = true, value_name = "NAME")]
    vehicle: Option<String>,
    #[command(flatten)]
    emulated: VirtualArgs,
    /// Port at which GDB connects to a virtual drone: the first one, or number NODE. The mission
    /// waits for GDB
    #[arg(long, value_name = "[NODE:]PORT")]
    gdb: Option<String>,
    /// Print the log messages of virtual drones on standard error
    #[arg(long)]
    log: bool,
    /// Write a bag of ROS 2 (rosbag2, MCAP) into --out as well: bag.mcap and metadata.yaml
    #[arg(long, requires = "out")]
    bag: bool,
    /// Print the file of the built-in scenario, as a start for your own, and fly nothing
    #[arg(long)]
    show: bool,
    #[command(flatten)]
    common: Common,
}

/// The options that put a mission into a surveyed cave or into another map.
#[derive(Args)]
pub(super) struct MapArgs {
    /// Survey of a cave (Survex, Compass, Walls, Therion, VisualTopo, PocketTopo), world of the
    /// SubT Challenge (.dot, .sdf) or map of a robot (map_server's .yaml): fly along a route of it
    /// instead of in the scenario's tunnel
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Station of the survey, tile of the world or point x,y of the map at which the base stands;
    /// where left out, the route is the longest that can be flown
    #[arg(long, value_name = "PLACE", requires = "map", allow_hyphen_values = true)]
    from: Option<String>,
    /// Station, tile or point at which the route ends
    #[arg(long, value_name = "PLACE", requires = "map", allow_hyphen_values = true)]
    to: Option<String>,
    /// Dig the other galleries within this distance of the route, in metres; 0 digs the route
    /// alone. Where left out, 0 in a survey, and 60 in a SubT world
    #[arg(long, allow_negative_numbers = true, value_name = "METRES", requires = "map")]
    #[arg(value_parser = around)]
    around_m: Option<f32>,
    /// Read the files that belong to the map from this folder and those below it; where left out,
    /// from the map's own folder
    #[arg(long, value_name = "DIR", requires = "map")]
    within: Option<PathBuf>,
    /// How far from the base the head is to come, in metres of way: the pilot stops it there, with as
    /// much time for the way as it needs
    #[arg(long, allow_negative_numbers = true, value_name = "METRES", value_parser = depth)]
    pub(super) depth: Option<f32>,
}

/// A depth, m.
fn depth(text: &str) -> Result<f32, String> {
    let metres: f32 = text.parse().map_err(|_| "this is no number".to_owned())?;
    let (least, most) = (DEPTHS.start(), DEPTHS.end());
    let is_sound = DEPTHS.contains(&metres);
    is_sound.then_some(metres).ok_or_else(|| format!("give a number from {least} to {most}"))
}

/// A distance from a route, m.
pub(super) fn around(text: &str) -> Result<f32, String> {
    let metres: f32 = text.parse().map_err(|_| "this is no number".to_owned())?;
    let is_sound = (0.0..=FARTHEST).contains(&metres);
    is_sound.then_some(metres).ok_or_else(|| format!("give a number from 0 to {FARTHEST}"))
}

impl MapArgs {
    /// The scenario of this name along the map's route, if a map was given, with so many relays and
    /// these settings.
    pub(super) fn open(
        &self,
        scenario: Option<&str>,
        relays: Option<usize>,
        settings: Vec<Setting>,
    ) -> Result<Scenario, InputError> {
        let Self { map, from, to, within, around_m, depth: _ } = self;
        let map = map.as_ref().map(|file| MapChoice {
            file: file.clone(),
            within: within.clone(),
            ends: Ends { from: from.clone(), to: to.clone(), around_m: *around_m },
            memory: None,
        });
        match (scenario, map) {
            (None, Some(map)) => Scenario::of_map(map, relays, settings),
            (name, map) => {
                let name = name.unwrap_or(builtin::DEMONSTRATION);
                Scenario::open_with(name, &Changes { map, relays, suits_width: false, settings })
            }
        }
    }
}

impl MapArgs {
    /// The same, whose pilot flies the head as deep as was asked for.
    pub(super) fn mission(
        &self,
        scenario: Option<&str>,
        relays: Option<usize>,
        settings: Vec<Setting>,
    ) -> Result<Scenario, InputError> {
        let mut scenario = self.open(scenario, relays, settings)?;
        if let Some(depth_m) = self.depth {
            scenario.explore_to(depth_m)?;
        }
        Ok(scenario)
    }
}

impl RunArgs {
    /// The scenario and the seed: of the options, or of earlier results.
    fn open(&self) -> Result<(Scenario, u64), InputError> {
        if let Some(folder) = &self.again {
            return again(folder);
        }
        let name = self.scenario.as_deref();
        let scenario = self.map.mission(name, self.relays, self.set.settings()?)?;
        let scenario = adapted(scenario, self.policy.as_deref(), self.fidelity)?;
        Ok((with_link(scenario, self.link)?, self.common.seed))
    }

    /// The virtual drones of the mission, if it has any.
    fn fleet(&self, scenario: &Scenario) -> Result<Option<Fleet>, InputError> {
        if scenario.fidelity == Fidelity::Virtual {
            let gdb = self.gdb.as_deref();
            return Fleet::of(&self.emulated, gdb, self.log, scenario, Base::OnHost).map(Some);
        }
        if self.emulated.are_given() || self.gdb.is_some() || self.log {
            let wrong =
                "--elf, --radio-elf, --gdb, --log and --virtual-drones are for virtual drones";
            return Err(InputError::new(wrong, "add --fidelity virtual"));
        }
        Ok(None)
    }
}

pub(super) fn run(args: &RunArgs) -> Result<Verdict, Trouble> {
    if args.show {
        return show(args.scenario.as_deref().unwrap_or(builtin::DEMONSTRATION));
    }
    if args.vehicle.is_some() {
        let wrong = "--vehicle is now a part of --fidelity";
        return Err(InputError::new(wrong, "give --fidelity virtual, or flight").into());
    }
    let (scenario, seed) = args.open()?;
    if let Some(route) = &scenario.route {
        route.warnings.iter().for_each(complain);
    }
    let fleet = args.fleet(&scenario)?;
    interrupt::ends();
    if args.common.out.is_some() {
        report::memory::is_enough_for(&scenario)?;
    }
    let mut folder = args.common.folder()?;
    let Flown { trace, files, metrics, judgement, aftermath, map } =
        fly(&scenario, seed, args, fleet.as_ref(), folder.as_ref())?;
    let mut failures: Vec<_> = judgement.failures.iter().map(ToString::to_string).collect();
    failures.extend(aftermath.failures());
    let mut summary = summary(&scenario, seed, &trace, &metrics, &judgement, &failures);
    if let (Some(summary), false) = (summary.as_object_mut(), aftermath.is_empty()) {
        summary.insert("virtual".into(), aftermath.json());
    }
    if let Some((folder, files)) = folder.as_mut().zip(files) {
        files.finish(folder, &trace, &summary)?;
        Origin::of("run", &scenario, seed).write(folder, &scenario)?;
        aftermath.write(folder)?;
        if let Some(map) = &map {
            put_map(folder, map)?;
        }
    }
    let table =
        table(&scenario, seed, &trace, &metrics, &judgement, &failures) + &aftermath.table();
    args.common.finish(folder, &table, &summary)?;
    // The table has them already.
    for failure in failures.iter().filter(|_| !args.common.prints_table()) {
        complain(format_args!("{}, seed {seed}: {failure}", scenario.name));
    }
    Ok(if failures.is_empty() { Verdict::Good } else { Verdict::Failed })
}

/// The scenario and the seed of the results in a folder.
fn again(folder: &Path) -> Result<(Scenario, u64), InputError> {
    let (origin, scenario) = Origin::read(folder)?;
    if origin.verb != "run" {
        let wrong = format!("these are the results of uchain {}", origin.verb);
        return Err(InputError::new(wrong, "give the folder of a uchain run").in_file(folder));
    }
    let now = Origin::of("run", &scenario, origin.seed);
    if (&now.version, &now.revision) != (&origin.version, &origin.revision) {
        complain(format_args!(
            "{}: another uchain has flown this mission; its bytes may differ",
            folder.display()
        ));
    }
    Ok((scenario, origin.seed))
}

fn show(name: &str) -> Result<Verdict, Trouble> {
    if let Some(text) = builtin::text(name) {
        super::put(text)?;
        return Ok(Verdict::Good);
    }
    // Says which names there are.
    Scenario::open(name)?;
    Err(InputError::new(
        format!("\"{name}\" is not a built-in scenario"),
        "--show prints built-in ones",
    )
    .into())
}

/// A mission that was flown.
struct Flown {
    /// The record, thinned where the mission is long.
    trace: Trace,
    /// The files with every frame of it, where they were asked for.
    files: Option<TraceFiles>,
    metrics: RunMetrics,
    judgement: Judgement,
    aftermath: Aftermath,
    /// The map that the drones have drawn, if they explore.
    map: Option<Occupancy>,
}

/// Flies a mission with its record, its figures and its verdict.
fn fly(
    scenario: &Scenario,
    seed: u64,
    args: &RunArgs,
    fleet: Option<&Fleet>,
    folder: Option<&Folder>,
) -> Result<Flown, Trouble> {
    let world = scenario.world();
    let reference = Reference::of(scenario, &world);
    let progress = Progress::new(scenario.duration_us / ROUND_US, args.common.quiet);
    progress.say("rounds");
    let mut mission = match fleet {
        None => Mission::new(scenario, &world, seed),
        Some(fleet) => Mission::emulated(scenario, &world, seed, fleet.drones(scenario, seed)?),
    };
    let mut watch = Watch::new(scenario, &world, &reference);
    let mut trace = mission.begin_trace(seed);
    let mut thinning = Thinning::default();
    let begin = |folder| {
        let files = TraceFiles::begin(folder, &trace)?;
        if args.bag { files.with_bag(folder, &trace, scenario) } else { Ok(files) }
    };
    let mut files = folder.map(begin).transpose()?;
    while !mission.is_over() {
        mission.round();
        watch.look(&mission);
        trace.team_map.look(&mission);
        let frame = mission.frame();
        if let Some((folder, files)) = folder.zip(files.as_mut()) {
            files.frame(folder, &trace, &frame)?;
        }
        thinning.add(&mut trace.frames, frame);
        if let Some(fleet) = fleet {
            fleet.say(&mut mission, |line| progress.aside(line));
        }
        progress.step();
    }
    let metrics = watch.verdict(&mission);
    let judgement = watch.judgement(&mission, &metrics);
    let (aftermath, map) = (Aftermath::of(&mission), drawn::map(&mission));
    Ok(Flown { trace, files, metrics, judgement, aftermath, map })
}
