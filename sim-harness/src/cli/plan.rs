//! `uchain plan`: how many relays a place needs, before the drones are packed.

mod drops;
mod explore;

use std::fmt::Write;

use clap::{Args, Subcommand};
use serde_json::{Value, json};
use units::{Db, MetresPerSecond};

use super::run::MapArgs;
use super::{Common, Trouble, Verdict, complain, interrupt};
use crate::count::counted;
use crate::input_error::InputError;
use crate::measure::plan::{Demand, MOST_RELAYS, OutOfReach, RelayPlan, relays};
use crate::output::pictures::{self, PlanPicture};
use crate::output::put_picture;
use crate::scenario::Scenario;

/// Plan a mission on paper.
#[derive(Args)]
pub(super) struct PlanArgs {
    #[command(subcommand)]
    verb: PlanVerb,
}

#[derive(Subcommand)]
enum PlanVerb {
    /// How many relays the radio needs along a way, where they would stand, how strong their links
    /// would be, and how far the batteries reach
    Relays(RelaysArgs),
    /// How long several robots take to explore a map together, and what each sees when
    Explore(explore::ExploreArgs),
    /// Where relays that land for good would be put down on a map, and what they would cover
    Drops(drops::DropsArgs),
}

#[derive(Args)]
struct RelaysArgs {
    /// Name of a built-in scenario, or a scenario file, whose main gallery is the way; where left
    /// out, the demonstration, or with --map the map's route
    scenario: Option<String>,
    #[command(flatten)]
    map: MapArgs,
    /// How much stronger than the launch limit every link is to be, dB
    #[arg(long, value_name = "DB", default_value_t = 3.0, allow_negative_numbers = true)]
    margin: f32,
    /// Speed of the head out and home, m/s
    #[arg(long, value_name = "MPS", default_value_t = 0.2)]
    speed: f32,
    #[command(flatten)]
    common: Common,
}

pub(super) fn run(args: &PlanArgs) -> Result<Verdict, Trouble> {
    match &args.verb {
        PlanVerb::Relays(args) => plan_relays(args),
        PlanVerb::Explore(args) => explore::plan(args),
        PlanVerb::Drops(args) => drops::run(args),
    }
}

impl RelaysArgs {
    fn demand(&self) -> Result<Demand, InputError> {
        let within = |what: &str, value: f32, least: f32, most: f32| {
            if (least..=most).contains(&value) {
                return Ok(value);
            }
            let remedy = format!("give a number from {least} to {most}");
            Err(InputError::new(format!("--{what} {value} is out of range"), remedy))
        };
        Ok(Demand {
            margin: Db(within("margin", self.margin, -50.0, 50.0)?),
            speed: MetresPerSecond(within("speed", self.speed, 0.01, 1.0)?),
        })
    }
}

fn plan_relays(args: &RelaysArgs) -> Result<Verdict, Trouble> {
    let demand = args.demand()?;
    let scenario = args.map.open(args.scenario.as_deref(), None, Vec::new())?;
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let planned = relays(&scenario, demand);
    if let (Some(folder), Ok(plan)) = (&mut folder, &planned) {
        let places = plan.stands.iter().map(|stand| stand.at).collect();
        let picture =
            PlanPicture { name: &scenario.name, plan: scenario.tunnel.floor_plan(), places };
        put_picture(folder, "plan", &pictures::plan(&picture).map_err(Trouble::from)?)?;
    }
    let value = planned.as_ref().map_or_else(out_of_reach_json, |plan| json_of(&scenario, plan));
    if let Some(folder) = &mut folder {
        folder.put_json("summary.json", &value)?;
    }
    let text = planned.as_ref().map_or_else(|_| String::new(), |plan| table(&scenario, plan));
    args.common.finish(folder, &text, &value)?;
    match planned {
        Ok(_) => Ok(Verdict::Good),
        Err(OutOfReach { way_m, reached_m, least }) => {
            complain(format_args!(
                "{}: a chain of {MOST_RELAYS} relays with links of {least:.1} or more reaches \
                 {reached_m:.1} m of {way_m:.1} m",
                scenario.name
            ));
            Ok(Verdict::Failed)
        }
    }
}

fn out_of_reach_json(why: &OutOfReach) -> Value {
    json!({
        "relays": null,
        "way_m": why.way_m,
        "reached_m": why.reached_m,
        "least_dbm": why.least.0,
    })
}

fn json_of(scenario: &Scenario, plan: &RelayPlan) -> Value {
    let stands = plan
        .stands
        .iter()
        .map(|stand| json!({ "along_m": stand.along_m, "x_m": stand.at.x, "y_m": stand.at.y }));
    let links = plan.links.iter().map(|link| {
        json!({
            "length_m": link.length_m,
            "strength_dbm": link.strength.0,
            "over_launch_db": link.over_launch.0,
            "over_retreat_db": link.over_retreat.0,
        })
    });
    json!({
        "scenario": scenario.name,
        "relays": plan.links.len() - 1,
        "way_m": plan.way_m,
        "least_dbm": plan.least.0,
        "stands": stands.collect::<Vec<_>>(),
        "links": links.collect::<Vec<_>>(),
        "battery": {
            "endurance_s": plan.reach.endurance_s,
            "stay_s": plan.reach.stay_s,
            "farthest_m": plan.reach.farthest_m,
        },
    })
}

fn table(scenario: &Scenario, plan: &RelayPlan) -> String {
    let relays = plan.links.len() - 1;
    let mut text = format!(
        "{}: {} for {:.1} m, no link weaker than {:.1}\n\n\
         {:10} {:>8} {:>8} {:>8}   {:>8} {:>10} {:>12} {:>13}\n",
        scenario.name,
        counted(relays, "relay"),
        plan.way_m,
        plan.least,
        "",
        "way, m",
        "x, m",
        "y, m",
        "link, m",
        "dBm",
        "over launch",
        "over retreat"
    );
    for (n, stand) in plan.stands.iter().enumerate() {
        let name = match n {
            0 => "base".to_owned(),
            n if n == relays + 1 => "head".to_owned(),
            // The relay next to the head flies first.
            n => format!("relay {}", relays + 1 - n),
        };
        let _ =
            write!(text, "{name:10} {:8.1} {:8.1} {:8.1}", stand.along_m, stand.at.x, stand.at.y);
        if let Some(link) = n.checked_sub(1).and_then(|before| plan.links.get(before)) {
            let _ = write!(
                text,
                "   {:8.1} {:10.1} {:9.1} dB {:10.1} dB",
                link.length_m, link.strength.0, link.over_launch.0, link.over_retreat.0
            );
        }
        text.push('\n');
    }
    let reach = plan.reach;
    let _ = writeln!(
        text,
        "\na new, full battery hovers for {:.0} s; the head {}; it comes home from {:.0} m",
        reach.endurance_s,
        if reach.stay_s > 0.0 {
            format!("can stay {:.0} s at the end", reach.stay_s)
        } else {
            "cannot come home from the end".to_owned()
        },
        reach.farthest_m
    );
    text
}
