//! Writes the table of a range survey, which `uchain replay --fit` reads: strength against distance.

use std::io::{self, Write};

use units::NodeId;

use super::durable::DurableFile;
use crate::range_survey::Sample;

/// Writes the samples, whose times count from the station's beginning, and returns when a power cut
/// would leave them.
pub(super) fn write(
    mut file: impl DurableFile,
    node: NodeId,
    samples: &[Sample],
) -> io::Result<()> {
    write_table(&mut file, node, samples)?;
    file.sync()
}

fn write_table(out: impl Write, node: NodeId, samples: &[Sample]) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(["time_s", "link", "rssi_dbm", "distance_m"])?;
    for Sample { at, place_m, rssi } in samples {
        let seconds = at.since(units::Instant::ZERO).as_secs_f32();
        table.write_record([
            format!("{seconds:.3}"),
            format!("{node} from base"),
            rssi.0.to_string(),
            format!("{place_m:.2}"),
        ])?;
    }
    table.flush()
}
