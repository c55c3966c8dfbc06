//! `uchain replay`: recorded RSSI.

use std::path::PathBuf;

use clap::Args;

use super::{Common, Trouble, Verdict};
use crate::output;
use crate::replay::{Format, Policy, ReplayOptions, replay};

#[derive(Args)]
pub(super) struct ReplayArgs {
    /// The recordings
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// What they are; told from their content where left out
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Over recorded flights, run this movement policy alone
    #[arg(long, value_enum)]
    policy: Option<Policy>,
    #[command(flatten)]
    common: Common,
}

pub(super) fn run(args: &ReplayArgs) -> Result<Verdict, Trouble> {
    let options =
        ReplayOptions { format: args.format, policy: args.policy, ..ReplayOptions::default() };
    let summary = replay(&args.logs, &options)?;
    let value = serde_json::to_value(&summary)
        .map_err(|error| Trouble::Internal(format!("the summary cannot be written ({error})")))?;
    args.common.print(&summary.to_string(), &value);
    if let Some(dir) = &args.common.out {
        let written = [
            output::put_json(dir, "summary.json", &value)?,
            output::put(dir, "trace.csv", |out| summary.write_series(out))?,
        ];
        args.common.wrote(&written);
    }
    Ok(Verdict::Good)
}
