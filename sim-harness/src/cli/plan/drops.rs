//! `uchain plan drops`: where relays that land for good would be put down.

use std::fmt::Write;
use std::path::PathBuf;

use cave_worlds::World;
use clap::Args;
use grid_map::{Cell, CellState};
use input::{InputError, counted};
use relay_placement::Curve;
use serde_json::{Value, json};
use units::Db;

use crate::cli::{Common, Trouble, Verdict, complain, interrupt};
use planning::drops::{Coverage, Drops, MOST_DROPS, NoDrops, Received, Site, open};
use report::pictures;
use report::put_picture;

#[derive(Args)]
pub(super) struct DropsArgs {
    /// Map: a survey of a cave, a map of a robot (map_server's .yaml) or a SubT world
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    /// Point of the map at which the base stands, in metres; where left out, the free point nearest
    /// to 0,0
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    base: Option<[f64; 2]>,
    /// Number of relays to put down, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 8, allow_negative_numbers = true)]
    nodes: usize,
    /// Point at which a relay stands already; may be given several times
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    relay: Vec<[f64; 2]>,
    /// How the 20 m are measured that a relay covers
    #[arg(long, value_name = "HOW", default_value = "straight")]
    coverage: Coverage,
    /// Readings of the strength of the base and the relays that stand, by which the new relays are
    /// planned for the largest expected coverage: CSV with the columns x_m, y_m, reference (0 for the
    /// base, n for the n-th --relay), and snr_db or rssi_dbm
    #[arg(long, value_name = "FILE")]
    readings: Option<PathBuf>,
    /// Noise of the receiver of the readings, -150 to 0; needed for the column rssi_dbm
    #[arg(long, value_name = "DBM", allow_negative_numbers = true, requires = "readings")]
    noise_dbm: Option<f64>,
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
    if let Some(noise) = args.noise_dbm.filter(|noise| !(-150.0..=0.0).contains(noise)) {
        let wrong = format!("--noise-dbm {noise} is out of range");
        return Err(InputError::new(wrong, "give a level from -150 to 0 dBm").into());
    }
    let (world, warnings) = open(&args.map, args.base)?;
    warnings.iter().for_each(complain);
    let stand = standing(args, &world)?;
    let no_drops = |why: NoDrops| {
        let remedy = "give another --base, or another map";
        InputError::new(why.to_string(), remedy).in_file(&args.map)
    };
    let mut site = Site::new(&world, args.coverage, &stand).map_err(no_drops)?;
    // The base is the first of those that stand, and is always reached.
    if let Some([x, y]) = site.out_of_reach().and_then(|n| args.relay.get(n.checked_sub(1)?)) {
        let wrong = format!("no way leads from the base to --relay {x},{y}");
        let remedy = "leave it out, or leave out --coverage geodesic";
        return Err(InputError::new(wrong, remedy).in_file(&args.map).into());
    }
    let readings = args.readings.as_ref();
    let received = readings.map(|file| Received::read(file, &mut site, args.noise_dbm));
    let received = received.transpose()?;
    let drops = site.plan(args.nodes, received.as_ref()).map_err(no_drops)?;
    interrupt::ends();
    let value = json_of(&world, &drops, received.as_ref());
    let mut folder = args.common.folder()?;
    if let Some(folder) = &mut folder {
        let picture = pictures::drops(&world, &drops).map_err(Trouble::from)?;
        put_picture(folder, "drops", &picture)?;
        folder.put_json("drops.json", &value)?;
    }
    args.common.finish(folder, &table(args, &world, &drops, received.as_ref()), &value)?;
    Ok(Verdict::Good)
}

/// The cells of the base and of the relays that stand.
fn standing(args: &DropsArgs, world: &World) -> Result<Vec<Cell>, InputError> {
    let cell = |at: &[f64; 2]| {
        let inside = world.map.frame().cell_at(world.point(*at));
        let free = inside.filter(|cell| world.map.state(*cell) == CellState::Free);
        free.ok_or_else(|| {
            let wrong = format!("--relay {},{} is no free point of the map", at[0], at[1]);
            InputError::new(wrong, "give a point at which a relay can stand").in_file(&args.map)
        })
    };
    let relays: Result<Vec<_>, _> = args.relay.iter().map(cell).collect();
    Ok([vec![world.base], relays?].concat())
}

fn json_of(world: &World, drops: &Drops, received: Option<&Received>) -> Value {
    let readings = received.map(|received| {
        let row = |(n, (count, over)): (usize, (usize, Db))| {
            json!({ "reference": n, "readings": count, "over_curve_db": hundredths(over.0.into()) })
        };
        received.summary().enumerate().map(row).collect::<Vec<_>>()
    });
    let places = drops.places.iter().enumerate().map(|(n, place)| {
        let [x, y] = world.in_file(place.at);
        let mut value = json!({
            "x_m": hundredths(x),
            "y_m": hundredths(y),
            "gain_m2": drops.square_metres(place.gain_cells),
            "link_margin_db": hundredths(f64::from((place.link - Curve::DEFAULT.covered).0)),
            "free_width_m": hundredths(f64::from(place.free_width.0)),
        });
        if let Some(chance) = drops.chance(n) {
            value["link_probability"] = json!(hundredths(chance.into()));
        }
        value
    });
    let [x, y] = world.in_file(world.map.frame().centre(world.base));
    let mut value = json!({
        "map": world.name,
        "base": { "x_m": hundredths(x), "y_m": hundredths(y) },
        "reachable_m2": drops.square_metres(drops.ground.reached().count()),
        "covered_before_m2": drops.square_metres(drops.before.covered(&drops.ground)),
        "covered_after_m2": drops.square_metres(drops.after.covered(&drops.ground)),
        "gain_at_most_m2": drops.at_most_cells.map(|cells| drops.square_metres(cells)),
        "places": places.collect::<Vec<_>>(),
    });
    if !drops.standing.is_empty() {
        let margin = |link: Db| hundredths(f64::from((link - Curve::DEFAULT.covered).0));
        value["standing_link_margin_db"] =
            drops.standing.iter().map(|link| json!(link.map(margin))).collect();
    }
    if let Some(readings) = readings {
        value["readings"] = json!(readings);
    }
    value
}

/// A number to the hundredth.
fn hundredths(number: f64) -> f64 {
    (100.0 * number).round() / 100.0
}

fn table(args: &DropsArgs, world: &World, drops: &Drops, received: Option<&Received>) -> String {
    let whose = if args.relay.is_empty() { "the base's" } else { "the network's" };
    let area = |cells| drops.square_metres(cells);
    let relays = counted(drops.places.len(), "relay");
    let cover = match (drops.places.len(), drops.chances.is_some()) {
        (1, false) => "covers",
        (_, false) => "cover",
        (1, true) => "is expected to cover",
        (_, true) => "are expected to cover",
    };
    let mut text = format!(
        "{}: {relays} {cover} {:.1} m² more than {whose} {:.1} m², of {:.1} m²",
        world.name,
        area(drops.gain_cells()),
        area(drops.before.covered(&drops.ground)),
        area(drops.ground.reached().count()),
    );
    // Writing to a string cannot fail.
    if let Some(cells) = drops.at_most_cells {
        let _ = write!(text, "; no set covers over {:.1} m² more", area(cells));
    }
    text.push('\n');
    for (n, (count, over)) in received.iter().flat_map(|it| it.summary()).enumerate() {
        let name = if n == 0 { "base".to_owned() } else { format!("standing relay {n}") };
        let readings = counted(count, "reading");
        let _ = writeln!(text, "{name}: {readings}, {:+.1} dB over the curve", over.0);
    }
    for (n, link) in drops.standing.iter().enumerate() {
        let short = link.map_or(0.0, |link| (Curve::DEFAULT.covered - link).0);
        if short > 0.0 {
            let _ = writeln!(text, "standing relay {}: {short:.1} dB short of a link", n + 1);
        }
    }
    if drops.places.is_empty() {
        return text;
    }
    let linked = if drops.chances.is_some() { " linked, %" } else { "" };
    let _ = writeln!(
        text,
        "\n{:10} {:>8} {:>8} {:>9} {:>10} {:>8}{linked}",
        "", "x, m", "y, m", "gain, m²", "margin, dB", "free, m"
    );
    for (n, place) in drops.places.iter().enumerate() {
        let [x, y] = world.in_file(place.at);
        let _ = write!(
            text,
            "relay {:<4} {x:8.2} {y:8.2} {:9.1} {:10.1} {:8.1}",
            n + 1,
            area(place.gain_cells),
            (place.link - Curve::DEFAULT.covered).0,
            place.free_width.0,
        );
        if let Some(chance) = drops.chance(n) {
            let _ = write!(text, " {:9.0}", 100.0 * chance);
        }
        text.push('\n');
    }
    text
}
