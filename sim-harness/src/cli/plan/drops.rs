//! `uchain plan drops`: where relays that land for good would be put down.

use std::fmt::Write;
use std::path::PathBuf;

use cave_worlds::World;
use clap::Args;
use relay_placement::Curve;
use serde_json::{Value, json};

use crate::cli::{Common, Trouble, Verdict, interrupt};
use crate::input_error::InputError;
use crate::measure::drops::{Drops, MOST_DROPS, open};
use crate::output::pictures;
use crate::output::put_picture;

#[derive(Args)]
pub(super) struct DropsArgs {
    /// Map: a survey of a cave, a map of a robot (map_server's .yaml) or a SubT world
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    /// Point of the map at which the base stands, in metres; where left out, the free point nearest
    /// to 0,0
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    base: Option<[f64; 2]>,
    /// Number of relays to put down
    #[arg(long, value_name = "N", default_value_t = 8, allow_negative_numbers = true)]
    nodes: usize,
    #[command(flatten)]
    common: Common,
}

/// A point, m.
fn point(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(',').and_then(|(x, y)| {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|it| it.is_finite());
        Some([number(x)?, number(y)?])
    });
    numbers.ok_or_else(|| "give X,Y as two numbers, such as 1.5,-2".to_owned())
}

pub(super) fn run(args: &DropsArgs) -> Result<Verdict, Trouble> {
    if !(1..=MOST_DROPS).contains(&args.nodes) {
        let wrong = format!("--nodes {} is out of range", args.nodes);
        let remedy = format!("give a number from 1 to {MOST_DROPS}");
        return Err(InputError::new(wrong, remedy).into());
    }
    let world = open(&args.map, args.base)?;
    let drops = Drops::plan(&world, args.nodes).map_err(|why| {
        let remedy = "give another --base, or another map";
        InputError::new(why.to_string(), remedy).in_file(&args.map)
    })?;
    interrupt::ends();
    let value = json_of(&world, &drops);
    let mut folder = args.common.folder()?;
    if let Some(folder) = &mut folder {
        let picture = pictures::drops(&world, &drops).map_err(Trouble::from)?;
        put_picture(folder, "drops", &picture)?;
        folder.put_json("drops.json", &value)?;
    }
    args.common.finish(folder, &table(&world, &drops), &value)?;
    Ok(Verdict::Good)
}

fn json_of(world: &World, drops: &Drops) -> Value {
    let places = drops.plan.places().iter().map(|place| {
        let [x, y] = world.in_file(place.at);
        json!({
            "x_m": hundredths(x),
            "y_m": hundredths(y),
            "gain_m2": drops.square_metres(place.gain_cells),
            "link_margin_db": hundredths(f64::from((place.link - Curve::DEFAULT.covered).0)),
            "free_width_m": hundredths(f64::from(place.free_width.0)),
        })
    });
    let [x, y] = world.in_file(world.map.frame().centre(world.base));
    json!({
        "map": world.name,
        "base": { "x_m": hundredths(x), "y_m": hundredths(y) },
        "reachable_m2": drops.square_metres(drops.ground.reached().count()),
        "covered_before_m2": drops.square_metres(drops.before.covered(&drops.ground)),
        "covered_after_m2": drops.square_metres(drops.after.covered(&drops.ground)),
        "gain_at_most_m2": drops.square_metres(drops.at_most_cells),
        "places": places.collect::<Vec<_>>(),
    })
}

/// A number to the hundredth.
fn hundredths(number: f64) -> f64 {
    (100.0 * number).round() / 100.0
}

fn table(world: &World, drops: &Drops) -> String {
    let area = |cells| drops.square_metres(cells);
    let mut text = format!(
        "{}: {} relays cover {:.1} m² more than the base's {:.1} m², of {:.1} m²; no set covers over \
         {:.1} m² more\n",
        world.name,
        drops.plan.places().len(),
        area(drops.plan.gain_cells()),
        area(drops.before.covered(&drops.ground)),
        area(drops.ground.reached().count()),
        area(drops.at_most_cells),
    );
    if drops.plan.places().is_empty() {
        return text;
    }
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "\n{:10} {:>8} {:>8} {:>9} {:>10} {:>8}",
        "", "x, m", "y, m", "gain, m²", "margin, dB", "free, m"
    );
    for (n, place) in drops.plan.places().iter().enumerate() {
        let [x, y] = world.in_file(place.at);
        let _ = writeln!(
            text,
            "relay {:<4} {x:8.2} {y:8.2} {:9.1} {:10.1} {:8.1}",
            n + 1,
            area(place.gain_cells),
            (place.link - Curve::DEFAULT.covered).0,
            place.free_width.0,
        );
    }
    text
}
