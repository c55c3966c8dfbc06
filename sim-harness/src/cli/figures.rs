//! `uchain figures`: the figures or tables of a paper, with what the paper claims.

mod exploration;
mod placement;
mod swarm;
mod verdicts;
mod watched;

use std::ffi::OsString;
use std::fmt::Write;

use chain::policy::{NAMES, Policy};
use clap::{Args, ValueEnum};
use input::{InputError, suggest};

use super::record::{Made, RecordArgs, Source};
use super::{Common, Trouble, Verdict, interrupt, put};
use measure::campaign::Figure;
use measure::claim::Claim;
use measure::figures::{Cell, Figures, VARIANTS, make, missions};
use measure::intervals::CONFIDENCE;
use report::pictures::{box_plots, survival};
use report::{Folder, figure_page};
use serde_json::Value;
use terminal::{Progress, runs};
use verdicts::Verdicts;

#[derive(Args)]
pub(super) struct FiguresArgs {
    /// The paper whose figures and claims are made
    #[arg(long, value_enum, default_value_t = Paper::UChain)]
    paper: Paper,
    /// Number of missions behind each box plot, or of caves behind each situation; the papers have 30,
    /// and tables of swarms up to 150
    #[arg(long, allow_negative_numbers = true, default_value_t = 30, value_name = "N")]
    runs: usize,
    /// Fly this policy only; may be given more than once. Claims about others are left out
    #[arg(long, value_name = "NAME")]
    policy: Vec<String>,
    /// Repeat all of it with N first seeds, and count the verdicts on each claim; makes no pictures
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    repeat: Option<usize>,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    record: RecordArgs,
}

/// A paper that is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Paper {
    /// Laclau 2020, on chains of relays: figure 3, panels A to F
    UChain,
    /// Falomir 2017, on swarms by virtual forces: tables 2 and 3 for several readings of it
    Forces,
    /// Stegun Vaquero 2020, on placing communication nodes: figures 2 to 4, in many caves
    Placement,
    /// Mahdoui's thesis, chapter 3, on coordinated exploration: figures 3.11 to 3.24
    Exploration,
}

impl Paper {
    /// What the file of its table says: the rest of the command, what it does, and the page.
    fn source(self) -> Source {
        let (name, about, page) = match self {
            Self::UChain => {
                ("u-chain", "Figure 3 of the paper on chains of relays", "benchmarks.md")
            }
            Self::Forces => ("forces", "Tables and figures of the paper on swarms", "swarms.md"),
            Self::Placement => ("placement", "Figures of the paper on placing nodes", "drops.md"),
            Self::Exploration => {
                ("exploration", "Figures of the thesis on exploration", "explore.md")
            }
        };
        Source { command: format!("figures --paper {name}"), file: "figures", about, page }
    }
}

/// What a paper's figures came to, to be printed.
struct Figured {
    table: String,
    summary: Value,
    /// The seeds in words.
    seeds: String,
}

/// Runs the command that this command line gives.
pub(super) fn run(args: &FiguresArgs, line: &[OsString]) -> Result<Verdict, Trouble> {
    let policies = policies(args)?;
    let count = runs(args.runs)?;
    let repeat = args.repeat.map(runs).transpose()?;
    let record = args.record.open(args.paper.source())?;
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let made = match repeat {
        Some(repeat) => repeated(args, &policies, (repeat, count), &mut folder)?,
        None => match args.paper {
            Paper::UChain => chains(args, &policies, count, &mut folder)?,
            Paper::Forces => swarm::make(args, count, &mut folder)?,
            Paper::Placement => placement::make(args, count, &mut folder)?,
            Paper::Exploration => exploration::make(args, count, &mut folder)?,
        },
    };
    let Figured { table, summary, seeds } = &made;
    let recorded = record.as_ref().map_or(Ok(()), |record| {
        record.write(line, &Made { seeds: Some(seeds), table, missed: &[] })
    });
    args.common.finish(folder, table, summary)?;
    recorded?;
    if let Some(record) = record.filter(|_| args.common.prints_table()) {
        put(&format!("\nwrote {}\n", record.path().display()))?;
    }
    Ok(Verdict::Good)
}

/// The claims of a paper with several first seeds.
fn repeated(
    args: &FiguresArgs,
    policies: &[&'static str],
    (repeat, count): (usize, usize),
    folder: &mut Option<Folder>,
) -> Result<Figured, Trouble> {
    let progress = Progress::new(repeat as u64, args.common.quiet);
    progress.say("repetitions");
    let alone = |claims: Vec<Claim>| claims.into_iter().map(|claim| ("", claim)).collect();
    let verdicts = Verdicts::count((repeat, args.common.seed, count), |seed| {
        let claims: Vec<(&'static str, Claim)> = match args.paper {
            Paper::UChain => alone(make(policies, count, seed, || ())?.claims()),
            Paper::Forces => swarm::claims(count, seed)?,
            Paper::Placement => alone(planning::situations::make(count, seed, || ()).claims()),
            Paper::Exploration => alone(exploration::claims(count, seed)?),
        };
        progress.step();
        Ok::<_, InputError>(claims)
    })?;
    drop(progress);
    let summary = verdicts.json();
    if let Some(folder) = folder {
        folder.put_json("verdicts.json", &summary)?;
    }
    let seeds = format!("{count} from each of {}", verdicts.seeds());
    Ok(Figured { table: verdicts.table(), summary, seeds })
}

/// The seeds of so many runs, in words.
fn seeds(first: u64, count: usize) -> String {
    format!("{first} to {}", first.wrapping_add(count as u64).wrapping_sub(1))
}

/// Figure 3 of the paper on chains.
fn chains(
    args: &FiguresArgs,
    policies: &[&'static str],
    count: usize,
    folder: &mut Option<Folder>,
) -> Result<Figured, Trouble> {
    let seed = args.common.seed;
    let progress = Progress::new(missions(policies.len(), count) as u64, args.common.quiet);
    progress.say("missions");
    let figures = make(policies, count, seed, || progress.step())?;
    drop(progress);
    let summary = figures.json(count, seed);
    if let Some(folder) = folder {
        folder.put_json("summary.json", &summary)?;
        let pictures = [
            ("figure-3", figure_page::picture(&figures, count)?),
            ("figure-3abc", survival(&figure_page::resting_chart(&figures))?),
            ("figure-3e", survival(&figure_page::convergence_chart(&figures))?),
            ("figure-3f", box_plots(&figure_page::variance_chart(&figures))?),
        ];
        for (name, picture) in &pictures {
            report::put_picture(folder, name, picture)?;
        }
    }
    Ok(Figured { table: table(&figures, count), summary, seeds: seeds(seed, count) })
}

/// The policies that were asked for, each once, in the order of the registry.
fn policies(args: &FiguresArgs) -> Result<Vec<&'static str>, InputError> {
    if args.policy.is_empty() {
        return Ok(VARIANTS.to_vec());
    }
    if args.paper != Paper::UChain {
        let wrong = "--policy chooses policies of chains, and this paper has none";
        return Err(InputError::new(wrong, "leave it out, or give --paper u-chain"));
    }
    if let Some(unknown) = args.policy.iter().find(|name| Policy::named(name).is_none()) {
        let wrong = format!("there is no policy \"{unknown}\"");
        return Err(InputError::new(wrong, suggest::one_of(unknown, &NAMES)));
    }
    let is_asked = |name: &&str| args.policy.iter().any(|asked| asked == name);
    Ok(NAMES.into_iter().filter(is_asked).collect())
}

fn table(figures: &Figures, count: usize) -> String {
    let mut text = format!(
        "The paper's figure 3, {count} missions for each row. A name ends with its unit; one without \
         a unit is a number of relays, or else a share of the missions or of their time\n"
    );
    let mut part = |heading: &str, of: fn(&Cell) -> Vec<Figure>| {
        let mut names = None;
        for cell in &figures.cells {
            let row = of(cell);
            // Writing to a string cannot fail.
            if names.is_none() {
                let _ = write!(text, "\n{heading}\n\n  {:13} {:8}", "corridor", "policy");
                for figure in &row {
                    let _ = write!(text, " {:>w$}", figure.name, w = width(figure.name));
                }
                text.push('\n');
                names = Some(());
            }
            let _ = write!(text, "  {:13} {:8}", cell.scenario, cell.policy);
            for Figure { name, estimate } in &row {
                let w = width(name);
                let _ = if estimate.value.is_finite() {
                    write!(text, " {:>w$.3}", estimate.value)
                } else {
                    write!(text, " {:>w$}", "never")
                };
            }
            text.push('\n');
        }
    };
    part("A to C: relays anywhere, the head at rest", Cell::convergence_figures);
    part("D to F: exploration, the head at 0.2 m/s for 50 s", Cell::exploration_figures);
    put_claims(&mut text, ("paper's", " for each corridor"), &figures.claims());
    text
}

/// Writes what a text claims, with the verdicts; the words say whose claims they are, and what each
/// interval is of.
fn put_claims(text: &mut String, (whose, of): (&str, &str), claims: &[Claim]) {
    let percent = 100.0 * CONFIDENCE;
    // Writing to a string cannot fail.
    let _ = writeln!(text, "\nThe {whose} claims, with intervals of {percent:.0} %{of}\n");
    for claim in claims {
        let _ = write!(text, "{claim}");
    }
}

fn width(name: &str) -> usize {
    name.len().max(7)
}
