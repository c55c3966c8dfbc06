//! `uchain figures`: the paper's figure 3, or the tables of the paper on swarms.

mod swarm;

use std::fmt::Write;

use clap::Args;

use super::{Common, Trouble, Verdict, interrupt};
use crate::args::runs;
use crate::measure::campaign::Figure;
use crate::measure::figures::{Figures, make, missions};
use crate::output;
use crate::output::pictures::box_plots;
use crate::progress::Progress;

#[derive(Args)]
pub(super) struct FiguresArgs {
    /// Number of missions behind each box plot; the paper has 30
    #[arg(long, allow_negative_numbers = true, default_value_t = 30, value_name = "N")]
    runs: usize,
    /// Make tables 2 and 3 of the paper on swarms by virtual forces (Falomir 2017) for several
    /// readings of it, and say which of its claims hold; the paper has 30 to 150 missions
    #[arg(long)]
    swarm: bool,
    #[command(flatten)]
    common: Common,
}

pub(super) fn run(args: &FiguresArgs) -> Result<Verdict, Trouble> {
    if args.swarm {
        return swarm::run(args);
    }
    let count = runs(args.runs)?;
    let seed = args.common.seed;
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let progress = Progress::new(missions(count) as u64, args.common.quiet);
    progress.say("missions");
    let figures = make(count, seed, || progress.step())?;
    drop(progress);
    let summary = figures.json(count, seed);
    if let Some(folder) = &mut folder {
        folder.put_json("summary.json", &summary)?;
        let pictures = [
            ("figure-3", figures.picture(count)?),
            ("figure-3e", box_plots(&figures.convergence_chart())?),
            ("figure-3f", box_plots(&figures.variance_chart())?),
        ];
        for (name, picture) in &pictures {
            output::put_picture(folder, name, picture)?;
        }
    }
    args.common.finish(folder, &table(&figures, count), &summary)?;
    Ok(Verdict::Good)
}

fn table(figures: &Figures, count: usize) -> String {
    let mut text = format!("The paper's figure 3, {count} missions for each row\n");
    let mut part = |heading: &str, of: fn(&crate::measure::figures::Cell) -> Vec<Figure>| {
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
    part(
        "A to C: relays anywhere, the head at rest",
        crate::measure::figures::Cell::convergence_figures,
    );
    part(
        "D to F: exploration, the head at 0.2 m/s for 50 s",
        crate::measure::figures::Cell::exploration_figures,
    );
    text.push_str("\nThe paper's claims\n\n");
    for claim in figures.claims() {
        let verdict = if claim.holds { "holds" } else { "does not hold" };
        let _ =
            writeln!(text, "  {}: {}\n    {verdict}: {}", claim.panel, claim.claim, claim.found);
    }
    text
}

fn width(name: &str) -> usize {
    name.len().max(7)
}
