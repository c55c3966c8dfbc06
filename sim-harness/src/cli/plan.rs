//! `uchain plan`: how many relays a place needs, before the drones are packed.

pub mod answer;
mod drops;
mod explore;

use clap::{Args, Subcommand};
use input::InputError;
use units::{Db, MetresPerSecond};

use super::run::MapArgs;
use super::{Common, Trouble, Verdict, complain, interrupt};
use planning::plan::{Demand, Limit, MOST_RELAYS, RelayPlan, relays};
use report::pictures::{self, PlanPicture};
use report::put_picture;

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
    /// Speed of the head on its way out, m/s
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
            depth_m: self.map.depth,
        })
    }
}

fn plan_relays(args: &RelaysArgs) -> Result<Verdict, Trouble> {
    let demand = args.demand()?;
    let scenario = args.map.open(args.scenario.as_deref(), None, Vec::new())?;
    interrupt::ends();
    let mut folder = args.common.folder()?;
    if let Some(route) = &scenario.route {
        route.warnings.iter().for_each(complain);
    }
    let plan = relays(&scenario, demand);
    let value = answer::json(&scenario, &plan);
    if let Some(folder) = &mut folder {
        let places = plan.stands.iter().map(|stand| stand.at).collect();
        let picture =
            PlanPicture { name: &scenario.name, plan: scenario.tunnel.floor_plan(), places };
        put_picture(folder, "plan", &pictures::plan(&picture).map_err(Trouble::from)?)?;
        folder.put_json("summary.json", &value)?;
    }
    args.common.finish(folder, &answer::table(&scenario, &plan), &value)?;
    if plan.limit_fetched() == Limit::Way {
        return Ok(Verdict::Good);
    }
    let RelayPlan { way_m, reached_m, least, .. } = plan;
    complain(format_args!(
        "{}: a chain of {MOST_RELAYS} relays with links of {least:.1} or more reaches \
         {reached_m:.1} m of {way_m:.1} m",
        scenario.name
    ));
    Ok(Verdict::Failed)
}
