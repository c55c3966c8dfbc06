//! Prints the results of a replay in three forms: as a table, as JSON, and as a CSV of every
//! sample.

use std::fmt;
use std::io;
use std::path::Path;

use serde::Serialize;

use super::agents::AgentReport;
use super::flight::{Commands, Equality, Flight};
use super::horizons::Horizons;
use super::prediction::{Foresights, Prediction, Tally};
use recordings::Format;
use recordings::fit::RadioFit;
use recordings::recording::{Anomalies, Recording, Sample};

/// The results of a replay for all of its files.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ReplaySummary {
    /// The results of each file, in the order given.
    pub files: Vec<FileReport>,
    /// The scores over the packets of all files; `None` where no file has any that could be
    /// predicted.
    pub all: Option<Prediction>,
    /// The comparison of filters with and without the motion, where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizons: Option<Horizons>,
    /// The radio model that was fitted to all packets, where one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit: Option<RadioFit>,
    #[serde(skip)]
    tally: Tally,
}

/// The results of a replay for one file.
#[derive(Clone, Debug, Serialize)]
pub struct FileReport {
    /// The file, as it was named.
    pub file: String,
    /// The format of the log.
    pub format: Format,
    /// The number of rows, without empty ones and a header.
    pub rows: usize,
    /// The number of rows in which at least one packet counted.
    pub used: usize,
    /// The number of packets that counted.
    pub packets: usize,
    /// The anomalies of the other rows.
    pub anomalies: Anomalies,
    /// A note on how the file was interpreted, where that is not obvious.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// The scores of the predictors; `None` for a flight, whose packets are not raw.
    pub prediction: Option<Prediction>,
    /// The scores for each link.
    pub links: Vec<LinkReport>,
    /// The commands of the movement policies to each relay; `None` for all but flights.
    pub policy: Option<Vec<Commands>>,
    /// The times at which the firmware's launch policy without sums over the links would have
    /// called for a relay, in seconds of the log.
    pub launches_s: Vec<f64>,
    /// The times at which the launch policy of the paper's experiments would have called for a
    /// relay, in seconds of the log.
    pub launches_at_once_s: Vec<f64>,
    /// The states of each relay's agent; empty where the log is not a flight.
    pub agents: Vec<AgentReport>,
    /// Measures of how equal the links were; `None` for all but flights.
    pub equality: Option<Equality>,
    #[serde(skip)]
    series: Series,
    #[serde(skip)]
    tally: Option<Tally>,
}

/// The results of a replay for one link.
#[derive(Clone, Debug, Serialize)]
pub struct LinkReport {
    /// The link's name in the log.
    pub link: String,
    /// The number of its packets that counted.
    pub packets: usize,
    /// The mean strength of these packets, in dBm; `None` without any.
    pub mean_dbm: Option<f64>,
    /// The scores of the predictors.
    pub prediction: Option<Prediction>,
}

/// Every packet of a file and, except in flights, what was expected of it.
#[derive(Clone, Debug, Default)]
struct Series {
    samples: Vec<Sample>,
    foresights: Vec<Foresights>,
}

impl FileReport {
    pub(super) fn of_flight(
        file: &Path,
        recording: Recording,
        flight: Flight,
        agents: Vec<AgentReport>,
    ) -> Self {
        Self {
            policy: Some(flight.commands),
            launches_s: flight.launches,
            launches_at_once_s: flight.launches_at_once,
            agents,
            equality: Some(flight.equality),
            ..Self::new(file, Format::UchainFlight, recording, Vec::new())
        }
    }

    pub(super) fn of_packets(
        file: &Path,
        format: Format,
        recording: Recording,
        foresights: Vec<Foresights>,
    ) -> Self {
        let knows_motion = recording.samples.iter().any(|sample| sample.separating.is_some());
        let tally = Tally::of(&foresights, knows_motion);
        Self {
            prediction: tally.prediction(),
            tally: Some(tally),
            ..Self::new(file, format, recording, foresights)
        }
    }

    fn new(file: &Path, format: Format, recording: Recording, foresights: Vec<Foresights>) -> Self {
        let Recording { rows, links, samples, anomalies, note, .. } = recording;
        Self {
            file: file.display().to_string(),
            format,
            rows,
            used: samples.chunk_by(|a, b| a.line == b.line).count(),
            packets: samples.len(),
            anomalies,
            note,
            prediction: None,
            links: link_reports(&links, &samples, &foresights),
            policy: None,
            launches_s: Vec::new(),
            launches_at_once_s: Vec::new(),
            agents: Vec::new(),
            equality: None,
            series: Series { samples, foresights },
            tally: None,
        }
    }
}

fn link_reports(
    links: &[String],
    samples: &[Sample],
    foresights: &[Foresights],
) -> Vec<LinkReport> {
    // One pass, however many links there are.
    let mut of_link: Vec<(usize, f64, Vec<&Foresights>, bool)> =
        vec![(0, 0.0, Vec::new(), false); links.len()];
    for (index, sample) in samples.iter().enumerate() {
        let Some((packets, sum, foreseen, knows_motion)) = of_link.get_mut(sample.link) else {
            continue;
        };
        *packets += 1;
        *sum += f64::from(sample.rssi.0);
        *knows_motion |= sample.separating.is_some();
        foreseen.extend(foresights.get(index));
    }
    links
        .iter()
        .zip(of_link)
        .map(|(link, (packets, sum, foreseen, knows_motion))| LinkReport {
            link: link.clone(),
            packets,
            mean_dbm: (packets > 0).then(|| sum / packets as f64),
            prediction: Tally::of(foreseen, knows_motion).prediction(),
        })
        .collect()
}

impl ReplaySummary {
    pub(super) fn add(&mut self, report: FileReport) {
        if let Some(tally) = &report.tally {
            self.tally.merge(tally);
            self.all = self.tally.prediction();
        }
        self.files.push(report);
    }

    /// Writes one row of CSV per packet: where and when it was received, how strongly, what each
    /// predictor expected and by how much it was wrong (received less expected). What is not known
    /// is left empty.
    ///
    /// # Errors
    /// The error of `out`.
    pub fn write_series(&self, out: &mut dyn io::Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record([
            "file",
            "line",
            "time_s",
            "link",
            "rssi_dbm",
            "velocity_mps",
            "last_dbm",
            "average_dbm",
            "kalman_still_dbm",
            "kalman_dbm",
            "k_tuned_dbm",
            "chain_dbm",
            "last_error_db",
            "average_error_db",
            "kalman_still_error_db",
            "kalman_error_db",
            "k_tuned_error_db",
            "chain_error_db",
        ])?;
        for report in &self.files {
            let Series { samples, foresights } = &report.series;
            for (index, sample) in samples.iter().enumerate() {
                let foresights = foresights.get(index).copied().unwrap_or_default();
                writer.write_record(report.series_row(sample, &foresights))?;
            }
        }
        writer.flush()
    }
}

impl FileReport {
    fn series_row(&self, sample: &Sample, foresights: &Foresights) -> Vec<String> {
        let micros = sample.time.as_micros();
        let link = self.links.get(sample.link).map_or("", |report| &report.link);
        let mut row = vec![
            self.file.clone(),
            sample.line.to_string(),
            format!("{}.{:06}", micros / 1_000_000, micros % 1_000_000),
            link.to_owned(),
            sample.rssi.0.to_string(),
            sample.separating.map_or_else(String::new, |speed| format!("{:.3}", speed.0)),
        ];
        let told = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.3}"));
        row.extend(foresights.iter().map(|f| told(f.map(|f| f64::from(f.expected.0)))));
        row.extend(foresights.iter().map(|f| told(f.map(|f| f.residual))));
        row
    }
}

/// The number of line numbers of one kind of anomaly in the table.
const LINES_SHOWN: usize = 5;

/// The number of links in the table.
const LINKS_SHOWN: usize = 12;

impl fmt::Display for ReplaySummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, report) in self.files.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{report}")?;
        }
        if let Some(all) = self.all.as_ref().filter(|_| self.files.len() > 1) {
            writeln!(f, "\nall files")?;
            write_prediction(f, all)?;
        }
        if let Some(horizons) = &self.horizons {
            write!(f, "{horizons}")?;
        }
        if let Some(fit) = &self.fit {
            write!(f, "\n{fit}")?;
        }
        Ok(())
    }
}

impl fmt::Display for FileReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.file)?;
        writeln!(
            f,
            "  {}: {} of {} rows used, {} packets on {} links",
            self.format,
            self.used,
            self.rows,
            self.packets,
            self.links.len()
        )?;
        for (kind, lines) in self.anomalies.iter() {
            write_anomaly(f, kind.name(), lines)?;
        }
        if let Some(prediction) = &self.prediction {
            write_prediction(f, prediction)?;
            write_links(f, &self.links)?;
        }
        if let Some(equality) = &self.equality {
            write_equality(f, equality, &self.links)?;
            write_launches(f, "settled", &self.launches_s)?;
            write_launches(f, "at once", &self.launches_at_once_s)?;
            for agent in &self.agents {
                write!(
                    f,
                    "    agent, relay {}: relaying {:.0} %, reconnecting {:.0} %, backing up {:.0} %",
                    agent.relay,
                    100.0 * agent.relaying,
                    100.0 * agent.reconnecting,
                    100.0 * agent.backing_up
                )?;
                match agent.landed_s {
                    Some(landed) => writeln!(f, ", landed at {landed:.1} s")?,
                    None => writeln!(f)?,
                }
            }
        }
        self.policy.as_ref().map_or(Ok(()), |commands| write_commands(f, commands))
    }
}

fn write_anomaly(f: &mut fmt::Formatter<'_>, kind: &str, lines: &[usize]) -> fmt::Result {
    let shown: Vec<String> = lines.iter().take(LINES_SHOWN).map(usize::to_string).collect();
    let more = if lines.len() > LINES_SHOWN { ", …" } else { "" };
    let line = if lines.len() == 1 { "line" } else { "lines" };
    writeln!(f, "  {kind:<18}{:>6}  ({line} {}{more})", lines.len(), shown.join(", "))
}

fn write_prediction(f: &mut fmt::Formatter<'_>, prediction: &Prediction) -> fmt::Result {
    let Prediction { samples, last, average, kalman_still, kalman, k_tuned, chain } = prediction;
    writeln!(
        f,
        "\n  next packet ({samples} predicted)   RMSE dB   log-likelihood   same variance"
    )?;
    let pad = 27 + samples.to_string().len();
    let rows = [
        ("last sample", Some(last)),
        ("average 0.27", Some(average)),
        ("filter, still", Some(kalman_still)),
        ("filter, velocity", kalman.as_ref()),
        ("k-tuned", Some(k_tuned)),
        ("chain", Some(chain)),
    ];
    for (name, score) in rows {
        match score {
            Some(score) => writeln!(
                f,
                "  {name:<pad$}{:>7.3}{:>17.4}{:>16.4}",
                score.rmse_db, score.log_likelihood, score.log_likelihood_seen,
            )?,
            None => writeln!(f, "  {name}: the log has no motion")?,
        }
    }
    Ok(())
}

fn write_links(f: &mut fmt::Formatter<'_>, links: &[LinkReport]) -> fmt::Result {
    let mut predicted: Vec<(&LinkReport, &Prediction)> =
        links.iter().filter_map(|link| Some((link, link.prediction.as_ref()?))).collect();
    if predicted.len() < 2 {
        return Ok(());
    }
    // The sort is stable: links with as many packets stay in the log's order.
    predicted.sort_by_key(|(link, _)| std::cmp::Reverse(link.packets));
    writeln!(
        f,
        "\n  {:<20}{:>9}{:>10}{:>9}{:>9}{:>9}{:>10}{:>9}",
        "RMSE dB of link", "packets", "mean dBm", "last", "average", "still", "velocity", "chain"
    )?;
    for (link, prediction) in predicted.iter().take(LINKS_SHOWN) {
        let Prediction { last, average, kalman_still, kalman, chain, .. } = prediction;
        write!(f, "  {:<20}{:>9}", link.link, link.packets)?;
        write!(f, "{:>10.1}", link.mean_dbm.unwrap_or(f64::NAN))?;
        write!(f, "{:>9.2}{:>9.2}", last.rmse_db, average.rmse_db)?;
        write!(f, "{:>9.2}", kalman_still.rmse_db)?;
        match kalman {
            Some(kalman) => write!(f, "{:>10.2}", kalman.rmse_db)?,
            None => write!(f, "{:>10}", "–")?,
        }
        writeln!(f, "{:>9.2}", chain.rmse_db)?;
    }
    match links.len().saturating_sub(predicted.len().min(LINKS_SHOWN)) {
        0 => Ok(()),
        more => writeln!(f, "  and {more} more, all of them with --json"),
    }
}

fn write_equality(
    f: &mut fmt::Formatter<'_>,
    equality: &Equality,
    links: &[LinkReport],
) -> fmt::Result {
    write!(f, "\n  mean dBm          ")?;
    for (link, mean) in links.iter().zip(&equality.means_dbm) {
        match mean {
            Some(mean) => write!(f, "  {} {mean:.1}", link.link)?,
            None => write!(f, "  {} never heard", link.link)?,
        }
    }
    writeln!(
        f,
        "\n  adjacent links      within 3 dB {:.0} %, within 5 dB {:.0} % (of {} pairs)",
        100.0 * equality.within_3_db,
        100.0 * equality.within_5_db,
        equality.pairs
    )
}

fn write_launches(f: &mut fmt::Formatter<'_>, when: &str, launches: &[f64]) -> fmt::Result {
    let times: Vec<String> = launches.iter().map(|time| format!("{time:.2}")).collect();
    let times = if times.is_empty() { "never".to_owned() } else { times.join(", ") + " s" };
    writeln!(f, "  {:<20}{times}", format!("launch {when}"))
}

fn write_commands(f: &mut fmt::Formatter<'_>, commands: &[Commands]) -> fmt::Result {
    if commands.is_empty() {
        return writeln!(f, "\n  one link and no relay: no policy to run");
    }
    writeln!(
        f,
        "\n  {:<10}{:>5}{:>7}{:>10}{:>8}{:>8}{:>10}{:>8}{:>13}",
        "policy", "relay", "rows", "forward", "hover", "back", "mean m/s", "turns", "as authors"
    )?;
    for told in commands {
        if told.rows == 0 {
            let (policy, relay) = (told.policy, told.relay);
            writeln!(f, "  {policy:<10}{relay:>5}{:>7}  never had both of its links", 0)?;
            continue;
        }
        writeln!(
            f,
            "  {:<10}{:>5}{:>7}{:>8.0} %{:>6.0} %{:>6.0} %{:>10.3}{:>8}{:>11.0} %",
            told.policy,
            told.relay,
            told.rows,
            100.0 * told.forward,
            100.0 * told.hover,
            100.0 * told.back,
            told.mean_speed_mps,
            told.sign_changes,
            100.0 * told.agrees_with_authors
        )?;
    }
    Ok(())
}
