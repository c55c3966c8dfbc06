//! `uchain figures`: the figures or tables of a paper, with what the paper claims.

mod exploration;
mod placement;
mod swarm;

use std::fmt::Write;

use chain::policy::{NAMES, Policy};
use clap::{Args, ValueEnum};
use input::{InputError, suggest};

use super::{Common, Trouble, Verdict, interrupt};
use measure::campaign::Figure;
use measure::claim::Claim;
use measure::figures::{Cell, Figures, VARIANTS, make, missions};
use measure::intervals::CONFIDENCE;
use report::figure_page;
use report::pictures::{box_plots, survival};
use terminal::Progress;
use terminal::runs;

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
    #[command(flatten)]
    common: Common,
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
    /// Mahdoui's thesis, chapter 3, on coordinated exploration: figures 3.11 to 3.22
    Exploration,
}

pub(super) fn run(args: &FiguresArgs) -> Result<Verdict, Trouble> {
    let policies = policies(args)?;
    match args.paper {
        Paper::UChain => {}
        Paper::Forces => return swarm::run(args),
        Paper::Placement => return placement::run(args),
        Paper::Exploration => return exploration::run(args),
    }
    let count = runs(args.runs)?;
    let seed = args.common.seed;
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let progress = Progress::new(missions(policies.len(), count) as u64, args.common.quiet);
    progress.say("missions");
    let figures = make(&policies, count, seed, || progress.step())?;
    drop(progress);
    let summary = figures.json(count, seed);
    if let Some(folder) = &mut folder {
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
    args.common.finish(folder, &table(&figures, count), &summary)?;
    Ok(Verdict::Good)
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
