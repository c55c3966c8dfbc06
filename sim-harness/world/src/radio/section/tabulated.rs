//! Reads the keys of `[radio.model]` with `law = "table"`: losses by distance and number of walls.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use input::InputError;
use input::reader::{At, Reader};
use radio_model::Tabulated;

use super::ModelTable;

/// The most distances of a table.
const MOST_DISTANCES: usize = 2_000;
/// The most rows of a table: no link behind seven walls or more is heard.
const MOST_ROWS: usize = 8;

/// The keys of the table: `distance_m`, and `loss_db` with a row for each number of walls.
pub(super) type Keys<'a> = (Option<&'a At<Vec<f32>>>, Option<&'a At<Vec<Vec<f32>>>>);

/// Reads `distance_m` and `loss_db`.
pub(super) fn read(
    table: &At<ModelTable>,
    keys: Keys<'_>,
    reader: &Reader<'_>,
) -> Result<Tabulated, InputError> {
    let (Some(distances), Some(losses)) = keys else {
        let remedy = "give distance_m, and loss_db with a row for each number of walls";
        return Err(reader.wrong(table, "the law table needs its table".into(), remedy));
    };
    check_distances(distances, reader)?;
    let (columns, rows) = (distances.as_ref().len(), losses.as_ref());
    if rows.is_empty() || rows.len() > MOST_ROWS {
        let wrong = format!("loss_db has {} rows", rows.len());
        let remedy = format!("give 1 to {MOST_ROWS} rows: no wall, one wall, and so on");
        return Err(reader.wrong(losses, wrong, remedy));
    }
    for (walls, row) in rows.iter().enumerate() {
        if row.len() != columns {
            let wrong = format!("loss_db has {} losses in the row of {walls} walls", row.len());
            let remedy = format!("give {columns}, as many as distance_m has distances");
            return Err(reader.wrong(losses, wrong, remedy));
        }
        if let Some(loss) = row.iter().find(|loss| !(0.0..=400.0).contains(*loss)) {
            let wrong = format!("loss_db has a loss of {loss} dB");
            return Err(reader.wrong(losses, wrong, "give losses from 0 to 400"));
        }
    }
    Ok(Tabulated { distances: kept(distances.as_ref()), losses: kept(&rows.concat()) })
}

fn check_distances(distances: &At<Vec<f32>>, reader: &Reader<'_>) -> Result<(), InputError> {
    let values = distances.as_ref();
    if !(2..=MOST_DISTANCES).contains(&values.len()) {
        let wrong = format!("distance_m has {} distances", values.len());
        return Err(reader.wrong(distances, wrong, format!("give 2 to {MOST_DISTANCES}")));
    }
    let is_rising = values.windows(2).all(|pair| pair[0] < pair[1]);
    if is_rising && values.iter().all(|distance| (0.01..=1e4).contains(distance)) {
        return Ok(());
    }
    let wrong = "distance_m does not rise from 0.01 to 10000".to_owned();
    Err(reader.wrong(distances, wrong, "give distances in m, each greater than the one before"))
}

/// The numbers, kept for the program's life. Equal tables are kept once, so that a campaign that reads
/// its scenario for each place of a grid takes no more memory for them than a mission.
fn kept(numbers: &[f32]) -> &'static [f32] {
    static KEPT: Mutex<BTreeMap<Vec<u32>, &'static [f32]>> = Mutex::new(BTreeMap::new());
    let bits = numbers.iter().map(|number| number.to_bits()).collect();
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    kept.entry(bits).or_insert_with(|| Box::leak(numbers.into()))
}
