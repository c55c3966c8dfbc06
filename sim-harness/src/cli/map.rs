//! `uchain map`: surveys of caves, SubT worlds, and maps of robots.

mod figures;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use input::InputError;
use maps::{Ends, Map, MapChoice, open};
use robot_maps::{Occupancy, map_server};
use world::{MOST_CELLS, Tunnel};

use super::{Trouble, Verdict, complain, interrupt, put, run};
use figures::{figures, table};
use report::Folder;
use scenario::Scenario;

/// Look at cave surveys, SubT worlds and maps of robots, and convert them.
#[derive(Args)]
pub(super) struct MapArgs {
    #[command(subcommand)]
    verb: MapVerb,
}

#[derive(Subcommand)]
enum MapVerb {
    /// Print the figures of a map: of a survey legs, length, stations, loops and how well they close
    Info(InfoArgs),
    /// Write a map as tables, and the floor plan of a route as an occupancy map (PGM and YAML)
    Convert(ConvertArgs),
}

#[derive(Args)]
struct ConvertArgs {
    /// The map: Survex (.svx, .3d), Compass (.dat, .mak), Walls (.srv, .wpj), Therion (.th),
    /// VisualTopo (.tro), SubT (.dot, .sdf), map_server (.yaml), or a scenario (.toml)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Read the files that belong to the map from this folder and those below it; where left out,
    /// from the map's own folder
    #[arg(long, value_name = "DIR")]
    within: Option<PathBuf>,
    /// Station, tile or point at which the route begins whose floor plan is drawn
    #[arg(long, value_name = "PLACE", allow_hyphen_values = true)]
    from: Option<String>,
    /// Station, tile or point at which it ends
    #[arg(long, value_name = "PLACE", allow_hyphen_values = true)]
    to: Option<String>,
    /// Draw the other galleries within this distance of the route, in metres
    #[arg(long, allow_negative_numbers = true, value_name = "METRES", value_parser = run::around)]
    around_m: Option<f32>,
    /// Edge of a cell of the occupancy map, in metres
    #[arg(long, value_name = "METRES", default_value_t = 0.05, value_parser = resolution)]
    resolution_m: f64,
    /// Write the files into this directory; it must be new, empty, or written by uchain before
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Do not say what was written; errors still go to standard error
    #[arg(long)]
    quiet: bool,
}

#[derive(Args)]
struct InfoArgs {
    /// The map: Survex (.svx, .3d), Compass (.dat, .mak), Walls (.srv, .wpj), Therion (.th),
    /// VisualTopo (.tro), SubT (.dot, .sdf) or map_server (.yaml)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Read the files that belong to the map from this folder and those below it; where left out,
    /// from the map's own folder
    #[arg(long, value_name = "DIR")]
    within: Option<PathBuf>,
    /// Print no table; errors still go to standard error
    #[arg(long)]
    quiet: bool,
    /// Print the figures as one JSON value on standard output, instead of the table
    #[arg(long)]
    json: bool,
}

/// The edge of a cell, m.
fn resolution(text: &str) -> Result<f64, String> {
    let metres: f64 = text.parse().map_err(|_| "this is no number".to_owned())?;
    let is_sound = (0.005..=5.0).contains(&metres);
    is_sound.then_some(metres).ok_or_else(|| "give a number from 0.005 to 5".to_owned())
}

pub(super) fn run(args: &MapArgs) -> Result<Verdict, Trouble> {
    match &args.verb {
        MapVerb::Info(args) => info(args),
        MapVerb::Convert(args) => convert(args),
    }
}

fn info(args: &InfoArgs) -> Result<Verdict, Trouble> {
    let map = open(&args.file, args.within.as_deref())?;
    if args.json {
        put(&format!("{:#}\n", figures(&map)))?;
    } else if !args.quiet {
        put(&table(&map))?;
    }
    if !args.json {
        map.warnings().iter().for_each(complain);
    }
    Ok(Verdict::Good)
}

fn convert(args: &ConvertArgs) -> Result<Verdict, Trouble> {
    let is_scenario = args.file.extension().is_some_and(|ending| ending == "toml");
    let map = if is_scenario { None } else { Some(open(&args.file, args.within.as_deref())?) };
    let drawn = match &map {
        None => Some(draw(&Scenario::read(&args.file)?.tunnel, args)?),
        // A map stays as it is.
        Some(Map::Grid(map)) => Some(map.clone()),
        Some(_) => route(args)?,
    };
    let mut folder = Folder::open(&args.out)?;
    interrupt::discards(folder.staging());
    match &map {
        Some(Map::Survey(survey)) => report::survey::write(&mut folder, survey)?,
        Some(Map::Subt(world)) => report::subt::write(&mut folder, world)?,
        Some(Map::Grid(_)) | None => {}
    }
    if let Some(drawn) = &drawn {
        put_map(&mut folder, drawn)?;
    }
    map.iter().flat_map(Map::warnings).for_each(complain);
    let files = folder.finish()?;
    if !args.quiet {
        let lines = files.iter().map(|file| format!("wrote {}\n", file.display()));
        put(&lines.collect::<String>())?;
    }
    Ok(Verdict::Good)
}

/// The floor plan of the route that was asked for. Where none was, and there is none to fly, only the
/// tables are written.
fn route(args: &ConvertArgs) -> Result<Option<Occupancy>, InputError> {
    let ConvertArgs { file, within, from, to, around_m, .. } = args;
    let ends = Ends { from: from.clone(), to: to.clone(), around_m: *around_m };
    let choice = MapChoice { file: file.clone(), within: within.clone(), ends, memory: None };
    match choice.dig() {
        Ok((tunnel, _)) => draw(&tunnel, args).map(Some),
        Err(error) if from.is_some() || to.is_some() => Err(error),
        Err(error) => {
            complain(format_args!("no floor plan is drawn: {error}"));
            Ok(None)
        }
    }
}

fn draw(tunnel: &Tunnel, args: &ConvertArgs) -> Result<Occupancy, InputError> {
    tunnel.occupancy(args.resolution_m).ok_or_else(|| {
        let wrong = format!("the occupancy map would have more than {MOST_CELLS} cells");
        let remedy = format!("give --resolution-m more than {}", args.resolution_m);
        InputError::new(wrong, remedy).in_file(Path::new(&args.file))
    })
}

pub(super) fn put_map(folder: &mut Folder, map: &Occupancy) -> Result<(), InputError> {
    let (mut yaml, mut image) = (Vec::new(), Vec::new());
    // Writing to memory cannot fail.
    let _ = map_server::write(map, &mut yaml, &mut image);
    folder.put("map.yaml", |out| out.write_all(&yaml))?;
    folder.put(map_server::IMAGE, |out| out.write_all(&image))
}
