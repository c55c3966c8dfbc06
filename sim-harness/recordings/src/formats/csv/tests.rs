use units::Instant;

use super::*;

fn parsed(text: &str) -> Recording {
    parse(text.as_bytes(), Path::new("log.csv")).unwrap()
}

/// The times of a table with these, in milliseconds since the first, and its note.
fn times(texts: &[&str]) -> (Vec<u64>, Option<String>) {
    let rows: String = texts.iter().map(|time| format!("{time},a,-50\n")).collect();
    let recording = parsed(&format!("time_s,link,rssi_dbm\n{rows}"));
    let first = recording.samples.first().map_or(Instant::ZERO, |sample| sample.time);
    let since = |sample: &crate::recording::Sample| sample.time.since(first).as_micros() / 1000;
    (recording.samples.iter().map(since).collect(), recording.note)
}

#[test]
fn times_of_other_programs_are_read_with_a_remark() {
    for (texts, word) in [
        (["1700000000000", "1700000000100"], "milliseconds"),
        (["1700000000000000", "1700000000100000"], "microseconds"),
        (["1700000000000000000", "1700000000100000000"], "nanoseconds"),
        (["2024-05-01T10:00:00.000Z", "2024-05-01T10:00:00.100Z"], "dates"),
        (["2024-05-01T10:00:00+02:00", "2024-05-01T08:00:00.1Z"], "dates"),
        (["2024-05-01 10:00:00.000", "2024-05-01 10:00:00.100"], "dates"),
        (["20240501T100000", "20240501T100000.1"], "dates"),
    ] {
        let (read, note) = times(&texts);
        assert_eq!(read, [0, 100], "{texts:?}");
        assert!(note.as_ref().is_some_and(|note| note.contains(word)), "{texts:?}: {note:?}");
    }
    assert_eq!(times(&["0.5", "0.6"]), (vec![0, 100], None));
    assert_eq!(times(&["1700000000", "1700000000.1"]), (vec![0, 100], None));
}

#[test]
fn times_of_two_kinds_are_not_guessed_at() {
    let rows = "time_s,link,rssi_dbm\n1.5,a,-50\n1700000000000,a,-50\n";
    let recording = parsed(rows);
    assert_eq!((recording.samples.len(), recording.note), (1, None));
    assert_eq!(recording.anomalies.of(Anomaly::NotANumber), [3]);
}

#[test]
fn other_separators_and_decimal_commas_are_read_with_a_remark() {
    let commas = "time_s,link,rssi_dbm,velocity_mps\n0.10,a,-50,0.5\n0.20,a,-51.5,\n";
    let expected = parsed(commas);
    for (separator, word) in [(';', "semicolons"), ('\t', "tabs"), ('|', "bars")] {
        let other = commas.replace(',', &separator.to_string());
        for text in [other.clone(), other.replace('.', ",")] {
            let recording = parsed(&text);
            assert_eq!(recording.samples, expected.samples, "{text}");
            assert!(recording.note.is_some_and(|note| note.contains(word)), "{text}");
        }
    }
}

#[test]
fn comments_are_passed_over_and_lines_keep_their_numbers() {
    let text = "\u{feff}sep=;\n# recorded by me\ntime_s;link;rssi_dbm\n0;a;-50\n# end\n1;a;-51\n";
    let recording = parsed(text);
    let lines: Vec<_> = recording.samples.iter().map(|sample| sample.line).collect();
    assert_eq!(lines, [4, 6]);
    assert_eq!(recording.rows, 2);
}

#[test]
fn the_first_wrong_row_is_kept_with_its_field() {
    let wrong = |rows: &str| {
        let text = format!("link,time_s,note,rssi_dbm\n{rows}");
        let (line, wrong) = parsed(&text).wrong.unwrap();
        (line, wrong.field, wrong.what)
    };
    for (row, field, what) in [
        ("a,soon,x,-50\n", Some(1), "time_s = \"soon\" is no number of seconds"),
        ("a,1,x,weak\n", Some(3), "rssi_dbm = \"weak\" is no number"),
        ("a,1,x,\n", Some(3), "rssi_dbm is empty"),
        ("a,1\n", None, "it has 2 fields where the first row has 4"),
    ] {
        assert_eq!(wrong(row), (2, field, what.to_owned()), "{row}");
    }
}
