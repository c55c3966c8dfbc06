//! `uchain replay`: recorded RSSI.

use std::path::PathBuf;

use chain::policy::{NAMES, Policy};
use clap::Args;
use clap::builder::PossibleValuesParser;

use super::progress::Progress;
use super::{Common, Trouble, Verdict, complain, interrupt};
use crate::replay::{Format, ReplayOptions, replay};

#[derive(Args)]
pub(super) struct ReplayArgs {
    /// The recordings
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Format of the recordings; where left out, each is recognized by its content
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Movement policy to run over recorded flights; where left out, all of them
    #[arg(long, value_parser = PossibleValuesParser::new(NAMES))]
    policy: Option<String>,
    /// Fit a radio model to the packets, and write it as sections of a scenario file, radio.toml
    #[arg(long)]
    fit: bool,
    #[command(flatten)]
    common: Common,
}

pub(super) fn run(args: &ReplayArgs) -> Result<Verdict, Trouble> {
    let policy = args.policy.as_deref().and_then(Policy::named);
    let options =
        ReplayOptions { format: args.format, policy, fit: args.fit, ..ReplayOptions::default() };
    interrupt::ends();
    let mut folder = args.common.folder()?;
    let progress = Progress::busy("replay", args.common.quiet);
    let summary = replay(&args.logs, &options)?;
    drop(progress);
    for report in &summary.files {
        if let Some(note) = report.note {
            complain(format_args!("{}: {note}", report.file));
        }
    }
    let value = serde_json::to_value(&summary)
        .map_err(|error| Trouble::Internal(format!("the summary cannot be written ({error})")))?;
    if let Some(folder) = &mut folder {
        folder.put_json("summary.json", &value)?;
        folder.put("trace.csv", |out| summary.write_series(out))?;
        if let Some(fit) = &summary.fit {
            folder.put_text("radio.toml", &fit.scenario())?;
        }
    }
    args.common.finish(folder, &summary.to_string(), &value)?;
    Ok(Verdict::Good)
}
