//! Scenario files drawn at random from the book's tables of keys: each is flown or refused in one
//! line, whatever it holds.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use random::{Purpose, Stream};
use sim_harness::mission::Mission;
use sim_harness::scenario::{Fidelity, Scenario, builtin};

use super::damaged_logs::damage;

/// A key of the file, as the book has it.
struct Key {
    /// The table, such as `[radio]` or `[[pilot]]`; empty at the top of the file.
    table: String,
    name: String,
    kind: String,
    /// The column of its range.
    range: String,
}

/// Every key of the book's chapter, and those of `[swarm]` and `[explore]`, which other chapters have.
fn keys() -> Vec<Key> {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/scenarios.md");
    let book = fs::read_to_string(book).unwrap();
    let mut tables: Vec<String> = vec![String::new()];
    let mut keys = Vec::new();
    for line in book.lines() {
        if line.starts_with('#') {
            let named = line.split('`').skip(1).step_by(2).filter(|name| name.starts_with('['));
            tables = named.map(str::to_owned).collect();
            if line.starts_with("## The top") {
                tables = vec![String::new()];
            }
        }
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, name, kind, _, range, ..] = cells[..] else { continue };
        let names = name.split('`').skip(1).step_by(2);
        for name in names.filter(|name| {
            name.bytes().all(|b| b.is_ascii_lowercase() || b"_.0123456789".contains(&b))
        }) {
            // `[radio.shadowing]`, `[radio.fading]` and `[radio.antenna]` share a table of the book.
            let (table, name) = match name.split_once('.') {
                Some((table, name)) => (format!("[radio.{table}]"), name),
                None if line.contains("amplitude")
                    || line.contains("swing") && !line.contains("criteri") =>
                {
                    continue;
                }
                None => match tables.first() {
                    Some(table) => (table.clone(), name),
                    None => continue,
                },
            };
            let (kind, range) = (kind.to_owned(), range.to_owned());
            keys.push(Key { table, name: name.to_owned(), kind, range });
        }
    }
    let own = [
        ("[swarm]", "corner_m area_m entrance_m width_m direction_deg length_m speed_mps"),
        ("[explore]", "corner_m area_m start_m direction_deg speed_mps turn_dps"),
    ];
    for (table, names) in own {
        keys.extend(names.split(' ').map(|name| Key {
            table: table.into(),
            name: name.into(),
            kind: if ["corner_m", "area_m", "entrance_m", "start_m"].contains(&name) {
                "`[x, y]`".into()
            } else {
                "number".into()
            },
            range: "0 to 20".into(),
        }));
    }
    keys
}

/// Draws the texts of scenarios.
struct Draw {
    random: Stream,
}

impl Draw {
    fn one<'a, T: ?Sized>(&mut self, of: &[&'a T]) -> &'a T {
        of[self.random.below(of.len() as u32) as usize]
    }

    /// Whether something that happens so often, in a hundred, happens.
    fn percent(&mut self, percent: u32) -> bool {
        self.random.below(100) < percent
    }

    fn number(&mut self, range: &str) -> String {
        if self.percent(10) {
            return self
                .one(&["0", "-1", "1e30", "-1e30", "inf", "-inf", "nan", "1e-30", "3"])
                .into();
        }
        let plain = range.replace('\u{2212}', "-");
        let bounds = plain.split_once(" to ").and_then(|(low, high)| {
            let high: String =
                high.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
            Some((low.trim().parse::<f32>().ok()?, high.parse::<f32>().ok()?))
        });
        let (low, high) = bounds.unwrap_or((0.0, 12.0));
        // Small numbers are the usual ones.
        let part = self.random.uniform();
        let part = if self.percent(50) { part } else { part.powi(4) };
        format!("{:?}", low + part * (high - low))
    }

    fn pair(&mut self) -> String {
        format!("[{}, {}]", self.number("0 to 14"), self.number("-4 to 4"))
    }

    fn list(&mut self, most: u32, mut item: impl FnMut(&mut Self) -> String) -> String {
        let count = self.random.below(most + 1);
        let items: Vec<String> = (0..count).map(|_| item(self)).collect();
        format!("[{}]", items.join(", "))
    }

    fn text(&mut self, range: &str) -> String {
        let named: Vec<&str> =
            range.split('`').skip(1).step_by(2).filter(|it| it.starts_with('"')).collect();
        if !named.is_empty() && !self.percent(8) {
            return self.one(&named).into();
        }
        let orders = ["\"wait\"", "\"explore\"", "\"return\"", "\"land\"", "\"perch\"", "\"stop\""];
        let losses = ["\"lands\"", "\"silent\"", "\"gone\""];
        let others =
            ["\"\"", "\"main\"", "\"\\u0000\"", "\"caf\u{e9}\"", "\"none.svx\"", "\"/dev/null\""];
        let all: Vec<&str> = orders.into_iter().chain(losses).chain(others).collect();
        self.one(&all).into()
    }

    fn place(&mut self) -> String {
        match self.random.below(3) {
            0 => self.number("0 to 14"),
            1 => self.pair(),
            _ => format!("{{ edge = {}, along_m = {} }}", self.text(""), self.number("0 to 9")),
        }
    }

    /// A value that suits the key, or one of another kind.
    fn value(&mut self, key: &Key) -> String {
        if self.percent(6) {
            let strange = [
                "true",
                "\"12\"",
                "[]",
                "{}",
                "[[]]",
                "1979-05-27T07:32:00Z",
                "-0",
                "0x7fffffff",
                "9223372036854775807",
                "[1, 2, 3]",
                "{ a = 1 }",
                "''''''",
            ];
            return self.one(&strange).into();
        }
        match key.kind.as_str() {
            "string" => self.text(&key.range),
            "boolean" => self.one(&["true", "false"]).into(),
            "whole number" => self.random.below(17).to_string(),
            "list of `[x, y]`" => self.list(5, Self::pair),
            "list of numbers" => self.list(5, |draw| draw.number("0.5 to 3")),
            "`[x, y]`" => self.pair(),
            "place" => self.place(),
            "list of places" => self.list(5, Self::place),
            "table" => format!(
                "{{ length_m = {}, amplitude_m = {}, wavelength_m = {} }}",
                self.number("1 to 40"),
                self.number("0 to 3"),
                self.number("0.5 to 20"),
            ),
            _ => self.number(&key.range),
        }
    }

    /// A whole file: a sound one, with keys put in, changed and left out.
    fn scenario(&mut self, keys: &[Key]) -> String {
        let mut tables: Vec<(String, Vec<(String, String)>)> = vec![
            (
                String::new(),
                vec![("title".into(), "\"drawn\"".into()), ("duration_s".into(), "1.0".into())],
            ),
            (
                "[tunnel]".into(),
                vec![
                    ("width_m".into(), "1.4".into()),
                    ("centre_line_m".into(), "[[0, 0], [7, 0], [12, 3]]".into()),
                ],
            ),
            ("[drones]".into(), vec![("relays".into(), "2".into())]),
        ];
        for _ in 0..self.random.below(12) {
            let key = &keys[self.random.below(keys.len() as u32) as usize];
            let value = self.value(key);
            let is_list = key.table.starts_with("[[");
            let place = tables.iter().rposition(|(table, _)| *table == key.table);
            let place = place.filter(|_| !is_list || self.percent(70)).unwrap_or_else(|| {
                tables.push((key.table.clone(), self.required(&key.table)));
                tables.len() - 1
            });
            let entries = &mut tables[place].1;
            entries.retain(|(name, _)| *name != key.name);
            entries.push((key.name.clone(), value));
        }
        if self.percent(10) {
            let place = self.random.below(tables.len() as u32) as usize;
            tables[place].1.pop();
        }
        let mut text = String::new();
        for (table, entries) in tables {
            text += &format!("{table}\n");
            for (name, value) in entries {
                text += &format!("{name} = {value}\n");
            }
        }
        if self.percent(3) {
            let cut = self.random.below(text.len() as u32 + 1) as usize;
            text = text.chars().take(cut).collect();
        }
        text
    }

    /// The keys that a table must have, mostly.
    fn required(&mut self, table: &str) -> Vec<(String, String)> {
        let given: &[(&str, &str)] = match table {
            "[[tunnel.branch]]" => &[("width_m", "1.2"), ("centre_line_m", "[[4, 0], [4, 4]]")],
            "[[tunnel.room]]" => &[("centre_m", "[6, 0]"), ("size_m", "[3, 2]")],
            "[radio.model]" => &[("law", "\"log-distance\"")],
            "[radio.shadowing]" => &[("deviation_db", "3"), ("decorrelation_m", "2")],
            "[radio.fading]" => &[("rician_k", "4")],
            "[radio.antenna]" => &[("depth_db", "6"), ("null_deg", "90")],
            "[[pilot]]" => &[("at_s", "0"), ("order", "\"explore\""), ("speed_mps", "0.2")],
            "[[loss]]" => &[("at_s", "0.4"), ("drone", "1"), ("how", "\"lands\"")],
            _ => &[],
        };
        let owned = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        given.iter().filter(|_| !self.percent(5)).map(owned).collect()
    }
}

/// What became of the files.
#[derive(Default)]
struct Fates {
    flown: usize,
    refused: usize,
    /// The longest that one took, with its number. It is printed, and no test depends on it.
    longest: (Duration, u64),
}

impl Fates {
    /// Flies the file, or asks for one line that refuses it.
    fn try_file(&mut self, file: &Path, number: u64, text: &[u8]) {
        let began = Instant::now();
        match Scenario::read(file) {
            Err(error) => {
                let line = error.to_string();
                let is_clear = line.lines().count() == 1 && line.contains("; ");
                assert!(is_clear, "{number}: {line}\n{}", String::from_utf8_lossy(text));
                self.refused += 1;
            }
            Ok(scenario) => {
                look(&scenario, number);
                self.flown += 1;
            }
        }
        self.longest = self.longest.max((began.elapsed(), number));
    }

    fn print(&self) {
        let Self { flown, refused, longest } = self;
        println!("{flown} flown, {refused} refused; number {} took {:?}", longest.1, longest.0);
    }
}

/// How many files a test tries: what this variable says, or else so many.
fn many(variable: &str, usual: u64) -> u64 {
    std::env::var(variable).ok().and_then(|it| it.parse().ok()).unwrap_or(usual)
}

/// Draws and flies files of these numbers.
fn fly(numbers: std::ops::Range<u64>, folder: &Path) -> Fates {
    let keys = keys();
    fs::create_dir_all(folder).unwrap();
    let mut fates = Fates::default();
    for number in numbers {
        let mut draw = Draw { random: Stream::new(number, Purpose::Drawn) };
        let text = draw.scenario(&keys);
        let file = folder.join("drawn.toml");
        fs::write(&file, &text).unwrap();
        fates.try_file(&file, number, text.as_bytes());
    }
    fates
}

/// Flies the first second of a scenario.
fn look(scenario: &Scenario, number: u64) {
    // An ELF is not there.
    if scenario.fidelity == Fidelity::Virtual {
        return;
    }
    let mut short = scenario.clone();
    short.duration_us = short.duration_us.min(1_000_000);
    let world = short.world();
    let trace = Mission::record(&short, &world, number);
    let places = trace.frames.iter().flat_map(|frame| &frame.drones).map(|drone| drone.pose.at);
    assert!(places.into_iter().all(|at| at.is_finite()), "{number}: a drone is nowhere");
}

/// Values and marks that readers of numbers, of text and of TOML trip over.
const STRANGE: [&str; 16] = [
    "-1", "0", "1e38", "-1e38", "1e-40", "inf", "nan", "16", "[]", "\"\"", "true", "#", "[[", "]",
    "=", "\u{feff}",
];

/// Changes a line of the text: of lines, a changed one is most often still TOML.
fn damage_line(bytes: &mut Vec<u8>, other: &[u8], random: &mut Stream) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let strange = STRANGE[random.below(STRANGE.len() as u32) as usize];
    let at = random.below(lines.len() as u32 + 1) as usize;
    let number = random.uniform();
    match (random.below(6), lines.get_mut(at)) {
        (0, Some(_)) => drop(lines.remove(at)),
        (1, Some(line)) => {
            let copy = line.clone();
            lines.insert(random.below(lines.len() as u32) as usize, copy);
        }
        (2, Some(line)) => {
            if let Some((key, _)) = line.split_once('=') {
                *line = format!("{key}= {strange}");
            }
        }
        (3 | 4, Some(line)) => {
            if let Some(from) = line.find(|c: char| c.is_ascii_digit()) {
                let digits = line[from..].chars().take_while(|c| c.is_ascii_digit() || *c == '.');
                let end = from + digits.count();
                let new = if random.below(2) == 0 {
                    strange.to_owned()
                } else {
                    format!("{:.2}", 40.0 * number.powi(3))
                };
                line.replace_range(from..end, &new);
            }
        }
        _ => {
            let others: Vec<&str> = std::str::from_utf8(other).unwrap().lines().collect();
            let line = others[random.below(others.len() as u32) as usize];
            lines.insert(at, line.to_owned());
        }
    }
    *bytes = (lines.join("\n") + "\n").into_bytes();
}

/// Reads and flies so many files that are built into the program, each damaged at up to five places.
fn fly_damaged(count: u64, folder: &Path) -> Fates {
    fs::create_dir_all(folder).unwrap();
    let file = folder.join("damaged.toml");
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let sound = builtin::names().map(|name| fs::read(scenarios.join(name).with_extension("toml")));
    let sound: Vec<Vec<u8>> = sound.map(Result::unwrap).collect();
    let mut fates = Fates::default();
    for number in 0..count {
        let mut random = Stream::new(number, Purpose::Drawn);
        let mut bytes = sound[number as usize % sound.len()].clone();
        let other = &sound[random.below(sound.len() as u32) as usize];
        for _ in 0..=random.below(4) {
            if random.below(8) == 0 {
                damage(&mut bytes, &mut random);
            } else {
                damage_line(&mut bytes, other, &mut random);
            }
        }
        fs::write(&file, &bytes).unwrap();
        fates.try_file(&file, number, &bytes);
    }
    fates
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("random-scenarios").join(name)
}

#[test]
fn the_keys_are_those_of_the_book() {
    let keys = keys();
    let has = |table: &str, name: &str| keys.iter().any(|it| it.table == table && it.name == name);
    for (table, name) in [
        ("", "link"),
        ("[tunnel]", "widths_m"),
        ("[[tunnel.branch]]", "name"),
        ("[[tunnel.room]]", "size_m"),
        ("[radio]", "latency_s"),
        ("[radio.model]", "permittivity"),
        ("[radio.fading]", "rician_k"),
        ("[vehicle]", "charge"),
        ("[drones]", "at_m"),
        ("[retreat]", "max_time_s"),
        ("[[pilot]]", "branch"),
        ("[[loss]]", "how"),
        ("[criteria]", "launched"),
    ] {
        assert!(has(table, name), "{table} {name}");
    }
}

#[test]
fn a_drawn_scenario_is_flown_or_refused_in_one_line() {
    let fates = fly(0..400, &folder("some"));
    // Both kinds are tried.
    assert!(fates.flown > 60 && fates.refused > 60, "{} {}", fates.flown, fates.refused);
}

/// `RANDOM_SCENARIOS` says how many files; 100,000 take some minutes in a release build.
#[test]
#[ignore = "takes minutes; UCHAIN_LONG=1 .ci/run test runs it"]
fn every_drawn_scenario_is_flown_or_refused_in_one_line() {
    fly(0..many("RANDOM_SCENARIOS", 100_000), &folder("many")).print();
}

#[test]
fn a_damaged_scenario_is_flown_or_refused_in_one_line() {
    let fates = fly_damaged(100, &folder("damaged"));
    assert!(fates.flown > 10 && fates.refused > 10, "{} {}", fates.flown, fates.refused);
}

/// `DAMAGED_SCENARIOS` says how many files.
#[test]
#[ignore = "takes minutes; UCHAIN_LONG=1 .ci/run test runs it"]
fn every_damaged_scenario_is_flown_or_refused_in_one_line() {
    fly_damaged(many("DAMAGED_SCENARIOS", 20_000), &folder("damaged-many")).print();
}
