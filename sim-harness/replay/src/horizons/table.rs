//! Prints the comparison of filters with and without motion as tables.

use std::fmt;

use super::{Gain, Horizon, Horizons, Interval, LinkHorizons, LogHorizons};

/// The number of links in the table of a log.
const LINKS_SHOWN: usize = 12;

impl fmt::Display for Horizons {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for log in &self.logs {
            write!(f, "\n{log}")?;
        }
        if !self.all.is_empty() {
            writeln!(f, "\nall logs with motion")?;
            write_horizons(f, &self.all)?;
        }
        for file in &self.without_motion {
            writeln!(
                f,
                "\n{file}\n  left out: no link changes its length in it, or no length is known"
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for LogHorizons {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.file)?;
        write_horizons(f, &self.horizons)?;
        write_links(f, &self.links)
    }
}

fn write_horizons(f: &mut fmt::Formatter<'_>, horizons: &[Horizon]) -> fmt::Result {
    for horizon in horizons {
        let age = age(horizon);
        let Horizon { samples, motion_db, came, .. } = horizon;
        writeln!(
            f,
            "\n  from {age}: {samples} packets; the motion should change {motion_db:.2} dB, and \
             {came:.2} of it came"
        )?;
        writeln!(
            f,
            "    {:<16}{:>9}{:>9}{:>11}{:>16}   gain by motion: RMSE %, log-likelihood",
            "", "RMSE dB", "mean dB", "median dB", "log-likelihood"
        )?;
        for score in &horizon.predictors {
            write!(
                f,
                "    {:<16}{:>9.3}{:>9.3}{:>11.3}{:>16.4}",
                score.name, score.rmse_db, score.mean_db, score.median_db, score.log_likelihood
            )?;
            match horizon.gains.iter().find(|gain| gain.filter == score.name) {
                Some(Gain { rmse_percent, log_likelihood, .. }) => {
                    writeln!(f, "   {rmse_percent:.2}, {log_likelihood:.4}")?;
                }
                None => writeln!(f)?,
            }
        }
    }
    Ok(())
}

fn write_links(f: &mut fmt::Formatter<'_>, links: &[LinkHorizons]) -> fmt::Result {
    let packets = |link: &LinkHorizons| link.horizons.first().map_or(0, |first| first.samples);
    let mut shown: Vec<&LinkHorizons> = links.iter().filter(|link| packets(link) > 0).collect();
    if shown.len() < 2 {
        return Ok(());
    }
    // The sort is stable: links with as many packets stay in the log's order.
    shown.sort_by_key(|link| std::cmp::Reverse(packets(link)));
    writeln!(f, "\n  RMSE % gained by motion, filter fitted | chain")?;
    for link in shown.iter().take(LINKS_SHOWN) {
        write!(f, "    {:<20}{:>6}", link.link, packets(link))?;
        for horizon in &link.horizons {
            let told: Vec<String> = horizon.gains.iter().skip(1).map(short).collect();
            write!(f, "   from {}: {}", age(horizon), told.join(" | "))?;
        }
        writeln!(f)?;
    }
    match shown.len().saturating_sub(LINKS_SHOWN) {
        0 => Ok(()),
        more => writeln!(f, "    and {more} more, all of them with --json"),
    }
}

/// A gain, with a star where zero lies outside of its interval.
fn short(gain: &Gain) -> String {
    let Interval { value, .. } = gain.rmse_percent;
    format!("{value:+.1}{}", if gain.rmse_percent.excludes_zero() { "*" } else { "" })
}

fn age(horizon: &Horizon) -> String {
    if horizon.horizon_s > 0.0 {
        format!("{} s before", horizon.horizon_s)
    } else {
        "the packet before".to_owned()
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(2);
        let Self { value, low, high } = self;
        write!(f, "{value:.digits$} [{low:.digits$}, {high:.digits$}]")
    }
}
