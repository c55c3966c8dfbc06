//! Writes the table of packets that `uchain replay` reads.
//!
//! The strengths are those of the drones' telemetry, which have passed the on-board filter. A row
//! without a link has no place in the table.

use std::io::{self, Write};

use crate::message::{Event, Record, report_of};

/// The columns, of which `uchain replay` needs the first three and ignores the others.
const COLUMNS: [&str; 9] = [
    "time_s",
    "link",
    "rssi_dbm",
    "node",
    "state",
    "fault",
    "battery_v",
    "endurance_s",
    "odometer_m",
];

/// The table that is being written.
pub(super) struct Packets<W: Write>(csv::Writer<W>);

impl<W: Write> Packets<W> {
    pub(super) fn new(out: W) -> io::Result<Self> {
        let mut table = csv::Writer::from_writer(out);
        table.write_record(COLUMNS)?;
        table.flush()?;
        Ok(Self(table))
    }

    pub(super) fn write(&mut self, record: &Record) -> io::Result<()> {
        let Event::Drone(node, report) = &record.event else { return Ok(()) };
        let row = report_of(*node, report);
        let (Some(back), Some(rssi)) = (row.back, row.rssi_dbm) else { return Ok(()) };
        let number = |value: Option<f32>| value.map(|value| value.to_string()).unwrap_or_default();
        self.0.write_record([
            format!("{:.3}", record.at.as_secs_f64()),
            // A link is named after receiver and sender, as in the trace of a run.
            format!("{node} from {back}"),
            rssi.to_string(),
            row.node.to_string(),
            row.state,
            row.fault,
            number(row.battery_v),
            number(row.endurance_s),
            row.odometer_m.to_string(),
        ])?;
        Ok(())
    }

    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
