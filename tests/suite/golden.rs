//! Tables that are committed and compared row by row.
//!
//! `REMINT=1 cargo test --test suite` writes them anew; only where what they show was meant to
//! change, with the reason in the commit.

use std::path::Path;

/// The rows of a `trace.csv`, its header first, whose time is a multiple of `step_s` seconds.
pub(crate) fn rows_every(step_s: u64, csv: &[u8]) -> String {
    let csv = std::str::from_utf8(csv).unwrap();
    let (header, rows) = csv.split_once('\n').unwrap();
    let shown = rows.lines().filter(|row| {
        let (seconds, decimals) = row.split_once(',').unwrap().0.split_once('.').unwrap();
        decimals.bytes().all(|digit| digit == b'0')
            && seconds.parse::<u64>().unwrap().is_multiple_of(step_s)
    });
    std::iter::once(header).chain(shown).map(|row| format!("{row}\n")).collect()
}

/// Compares a table with `tests/golden/{name}`.
///
/// # Panics
/// Where they differ, with the first row that does.
pub(crate) fn compare(name: &str, table: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("REMINT").is_some() {
        std::fs::write(&file, table).unwrap();
    }
    let golden = std::fs::read_to_string(&file).unwrap_or_default();
    if golden == table {
        return;
    }
    let (mut was, mut is) = (golden.lines(), table.lines());
    for number in 1_usize.. {
        let (was, is) = (was.next(), is.next());
        if was != is || was.is_none() {
            panic!(
                "tests/golden/{name}, row {number}:\n- {}\n+ {}\nif it was meant to change, \
                 REMINT=1 writes the file anew; say why in the commit",
                was.unwrap_or("(no such row)"),
                is.unwrap_or("(no such row)")
            );
        }
    }
}
