//! `uchain plan explore`: one exploration of a map by several robots.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use explorers::{Air, Outcome, PLANS, ROBOTS, Senses, Setup, World};
use frontier::{RULES, RuleEntry};
use grid_map::Cell;
use input::{InputError, suggest};
use serde_json::{Value, json};
use units::Point2;

use crate::cli::map::put_map;
use crate::cli::{Common, Trouble, Verdict, complain, interrupt};
use benchmarks::explore::measure::setup;
use planning::explored::explored;
use terminal::{NetworkArg, SensorArg};

#[derive(Args)]
pub(in crate::cli) struct ExploreArgs {
    /// The map: map_server (.yaml), a cave's survey, or a SubT world
    #[arg(long, value_name = "FILE", conflicts_with = "plan")]
    map: Option<PathBuf>,
    /// A built-in floor plan of 8 by 8 m in place of a map: room, rooms, maze, loop or pillars
    #[arg(long, value_name = "NAME", default_value = "rooms")]
    plan: String,
    /// Number of robots, 1 to 8
    #[arg(long, value_name = "N", default_value_t = 3, allow_negative_numbers = true)]
    robots: usize,
    /// Rule of exploration: thesis, thesis-event, thesis-reach, nearest, greedy-pair, explore-lite or ours
    #[arg(long, value_name = "NAME", default_value = "ours")]
    rule: String,
    /// Where the first robot starts on the map, x and y in metres; where left out, where there is most
    /// room
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires = "map")]
    start: Option<String>,
    /// The exploration ends after so many seconds, 1 to 36000
    #[arg(long, value_name = "S", default_value_t = 900.0, allow_negative_numbers = true)]
    longest_s: f32,
    /// By which sensor the robots map
    #[arg(long, value_enum, default_value = "camera")]
    sensor: SensorArg,
    /// Let the robots' positions drift as those by optic flow do
    #[arg(long)]
    drift: bool,
    /// Which robots send others' packets on
    #[arg(long, value_enum, default_value = "mesh")]
    network: NetworkArg,
    #[command(flatten)]
    common: Common,
}

pub(super) fn plan(args: &ExploreArgs) -> Result<Verdict, Trouble> {
    let (world, rule) = (args.world()?, args.rule()?);
    if !(1..=ROBOTS).contains(&args.robots) {
        let wrong = format!("--robots {} is out of range", args.robots);
        return Err(InputError::new(wrong, format!("give a number from 1 to {ROBOTS}")).into());
    }
    if !(1.0..=36_000.0).contains(&args.longest_s) {
        let wrong = format!("--longest-s {} is out of range", args.longest_s);
        return Err(InputError::new(wrong, "give a number from 1 to 36000").into());
    }
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let setup = setup(&world, rule.rule, args.robots, args.common.seed);
    let senses = Senses { sensor: args.sensor.sensor(), drifts: args.drift };
    let air = Air { network: args.network.network(), ..setup.air };
    let setup = Setup { longest_s: args.longest_s, senses, air, ..setup };
    let (outcome, map) = explorers::run(&setup);
    let value = json_of(args, &world, &outcome);
    if let Some(folder) = &mut folder {
        put_map(folder, &map)?;
        folder.put_text("seen.csv", &seen(&outcome, args.robots))?;
        folder.put_json("summary.json", &value)?;
    }
    args.common.finish(folder, &table(args, &world, &outcome), &value)?;
    let failures = failures(&outcome);
    failures.iter().for_each(|failure| complain(format_args!("{}: {failure}", world.name)));
    Ok(if failures.is_empty() { Verdict::Good } else { Verdict::Failed })
}

/// Why the exploration is no success: too little was seen, or a body touched something.
fn failures(outcome: &Outcome) -> Vec<String> {
    let known = 100.0 * outcome.explored;
    let little = outcome.t99_s.is_none();
    let mut failures =
        Vec::from_iter(little.then(|| format!("{known:.1} % of what can be seen was seen")));
    if outcome.touches > 0 {
        failures.push(format!("{} touches of a wall", outcome.touches));
    }
    if outcome.robot_touches > 0 {
        failures.push(format!("{} touches between robots", outcome.robot_touches));
    }
    failures
}

impl ExploreArgs {
    fn world(&self) -> Result<World, InputError> {
        if let Some(file) = &self.map {
            let (world, warnings) = explored(file, self.start()?)?;
            warnings.iter().for_each(complain);
            complain_of_unreached(&world);
            return Ok(world);
        }
        World::plan(&self.plan).ok_or_else(|| {
            let wrong = format!("there is no floor plan \"{}\"", self.plan);
            InputError::new(wrong, suggest::one_of(&self.plan, &PLANS.map(|(name, _)| name)))
        })
    }

    fn rule(&self) -> Result<&'static RuleEntry, InputError> {
        RuleEntry::named(&self.rule).ok_or_else(|| {
            let wrong = format!("there is no rule \"{}\"", self.rule);
            InputError::new(wrong, suggest::one_of(&self.rule, &RULES.map(|rule| rule.name)))
        })
    }

    fn start(&self) -> Result<Option<Point2>, InputError> {
        let Some(text) = &self.start else { return Ok(None) };
        let number = |text: &str| text.trim().parse().ok().filter(|n: &f32| n.is_finite());
        let point = text.split_once(',').and_then(|(x, y)| Some((number(x)?, number(y)?)));
        let wrong =
            || InputError::new(format!("--start {text} is no point"), "give two numbers: X,Y");
        point.map(|(x, y)| Some(Point2::new(x, y))).ok_or_else(wrong)
    }
}

fn json_of(args: &ExploreArgs, world: &World, outcome: &Outcome) -> Value {
    json!({
        "world": world.name,
        "rule": args.rule,
        "robots": args.robots,
        "free_m2": area(world, |it, cell| !it.is_wall(cell)),
        "visible_m2": area(world, World::is_visible),
        "explored": f64::from(outcome.explored),
        "t99_s": outcome.t99_s.map(f64::from),
        "stopped_s": outcome.stopped_s.map(f64::from),
        "path_m": f64::from(outcome.path_m),
        "overlap": f64::from(outcome.overlap),
        "premature_stop": outcome.premature_stop,
        "kB_on_air": f64::from(outcome.kb_on_air),
        "wall_touches": outcome.touches,
        "into_walls": outcome.into_walls,
        "robot_touches": outcome.robot_touches,
        "closest_m": outcome.closest_m.map(f64::from),
        "error_m": f64::from(outcome.error_m),
    })
}

/// So much of the free space, if no more, may be out of sight without a remark: niches and corners.
const UNREACHED: f64 = 0.1;

/// Says how much of the free space cannot be explored, where that is much.
fn complain_of_unreached(world: &World) {
    let (seen, free) = (area(world, World::is_visible), area(world, |it, cell| !it.is_wall(cell)));
    let unreached = 1.0 - seen / free.max(f64::EPSILON);
    if unreached > UNREACHED {
        complain(format_args!(
            "{}: {:.0} % of the free space ({:.1} of {free:.1} m²) cannot be seen from where robots \
             get to, and does not count",
            world.name,
            100.0 * unreached,
            free - seen,
        ));
    }
}

/// The area of the cells of a place for which this is true, in square metres.
fn area(world: &World, is_counted: impl Fn(&World, Cell) -> bool) -> f64 {
    let side = f64::from(world.frame().resolution().0);
    let count = world.frame().cells().filter(|cell| is_counted(world, *cell)).count();
    count as f64 * side * side
}

fn table(args: &ExploreArgs, world: &World, outcome: &Outcome) -> String {
    let seconds =
        |time: Option<f32>| time.map_or_else(|| "never".to_owned(), |time| format!("{time:.0} s"));
    format!(
        "{}: {:.0} m², {} robots by the rule {}\n\n  explored    {:.1} %\n  99 % known  {}\n  stopped     \
         {}\n  way         {:.1} m a robot, until 99 % were known\n  overlap     {:.0} % was seen by two \
         robots or more\n  on the air  {:.1} kB\n  touches     {} of walls, {} between robots\n",
        world.name,
        area(world, World::is_visible),
        args.robots,
        args.rule,
        100.0 * outcome.explored,
        seconds(outcome.t99_s),
        seconds(outcome.stopped_s),
        outcome.path_m,
        100.0 * outcome.overlap,
        outcome.kb_on_air,
        outcome.touches,
        outcome.robot_touches,
    )
}

/// What part of the place each robot had seen, second by second.
fn seen(outcome: &Outcome, robots: usize) -> String {
    let mut text = String::from("time_s");
    for n in 0..robots {
        // Writing to a string cannot fail.
        let _ = write!(text, ",robot_{n}");
    }
    text.push_str(",any\n");
    for (n, parts) in outcome.curve.iter().enumerate() {
        let _ = write!(text, "{}", n + 1);
        for part in parts {
            let _ = write!(text, ",{part:.4}");
        }
        text.push('\n');
    }
    text
}
