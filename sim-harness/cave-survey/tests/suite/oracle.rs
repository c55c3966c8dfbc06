//! Agreement with `cavern` and `dump3d` of Survex, 1.4.22 or later.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use cave_survey::{Folder, Summary, Survey, read};

/// What `cavern` and `dump3d` say of a survey.
struct Oracle {
    legs: usize,
    length_m: f64,
    /// `None` where a `*solve` leaves the number unknown.
    loops: Option<usize>,
    nodes: usize,
    positions: BTreeMap<String, [f64; 3]>,
    image: PathBuf,
}

/// The oldest version that agrees: older ones read Compass, loops and parts that nothing joins
/// otherwise.
const OLDEST: [u32; 3] = [1, 4, 22];

/// The oldest version that computes with the heights of Walls.
const OLDEST_WITH_HEIGHTS: [u32; 3] = [1, 4, 24];

/// Whether `cavern` is of that version or later.
fn is_at_least(oldest: [u32; 3]) -> bool {
    let told = Command::new("cavern").arg("--version").output().expect("cavern of survex runs");
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    let version = told.split_whitespace().last().unwrap_or_default();
    let parts: Vec<u32> = version.split('.').filter_map(|part| part.parse().ok()).collect();
    let is_recent = parts.as_slice() >= &oldest[..];
    if !is_recent {
        println!("{} is older than {oldest:?}: nothing compared", told.trim());
    }
    is_recent
}

/// Processes the survey; `None` where `cavern` refuses it.
fn cavern(survey: &Path, folder: &str) -> Option<Oracle> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("oracle").join(folder);
    fs::create_dir_all(&folder).unwrap();
    let image = folder.join("out.3d");
    let _ = fs::remove_file(&image);
    let run = Command::new("cavern")
        .arg("--no-auxiliary-files")
        .arg("-o")
        .arg(&image)
        .arg(survey)
        .output();
    let log = String::from_utf8_lossy(&run.expect("cavern of survex runs").stdout).into_owned();
    if !image.exists() {
        return None;
    }
    let mut lines = log.lines();
    let loops = lines.find(|line| line.starts_with("There ") && line.contains("loop"));
    let loops = loops.and_then(|line| line.split_whitespace().nth(2)?.parse().ok());
    let dump = Command::new("dump3d").arg("-l").arg(&image).output().unwrap();
    let dump = String::from_utf8_lossy(&dump.stdout).into_owned();
    let mut oracle =
        Oracle { legs: 0, length_m: 0.0, loops, nodes: 0, positions: BTreeMap::new(), image };
    for line in dump.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |n: usize| words[n].parse::<f64>().unwrap();
        let is_flagged = ["SPLAY", "SURFACE", "DUPLICATE"].iter().any(|flag| words.contains(flag));
        if words.first() == Some(&"LEG") && !is_flagged {
            oracle.legs += 1;
            // What was not measured has no length.
            if words.contains(&"STYLE=NOSURVEY") {
                continue;
            }
            let side = |n: usize| (number(n) - number(n + 3)).powi(2);
            oracle.length_m += (side(1) + side(2) + side(3)).sqrt();
        }
        if words.first() == Some(&"NODE") {
            oracle.nodes += 1;
            // A name may have blanks in it.
            let name = line.split_once('[').and_then(|it| it.1.rsplit_once(']')).unwrap().0;
            let name = name.to_owned();
            if !name.is_empty() {
                oracle.positions.insert(name, [number(1), number(2), number(3)]);
            }
        }
    }
    Some(oracle)
}

fn agree(survey: &Survey, oracle: &Oracle, name: &str) {
    let Summary { legs, length_m, stations, .. } = survey.summary();
    assert_eq!((legs, stations), (oracle.legs, oracle.nodes), "{name}");
    let slack = 0.05 + 1e-3 * oracle.length_m;
    assert!((length_m - oracle.length_m).abs() < slack, "{name}: {length_m} {}", oracle.length_m);
    for (station, there) in &oracle.positions {
        let here = super::at(survey, station);
        let off = here.iter().zip(there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 0.05, "{name}: {station} is {off:.3} m off");
    }
}

/// The survey by our reader and by `cavern`, its `.3d` file included.
fn both(root: &Path, entry: &str) {
    let name = entry.replace('/', "-");
    let survey = read(&Folder::new(root).unwrap(), entry);
    let Some(oracle) = cavern(&root.join(entry), &name) else {
        assert!(survey.is_err(), "cavern refuses {entry}");
        return;
    };
    let survey = survey.unwrap_or_else(|refusal| panic!("{entry}: {refusal}"));
    agree(&survey, &oracle, entry);
    assert_eq!(survey.loops, oracle.loops.unwrap_or(survey.loops), "{entry}");
    let folder = oracle.image.parent().unwrap();
    agree(&read(&Folder::new(folder).unwrap(), "out.3d").unwrap(), &oracle, entry);
}

#[test]
#[ignore = "needs cavern of the package survex; .ci/run test runs it where it is installed"]
fn cavern_agrees_on_surveys_with_loops_and_every_style() {
    if !is_at_least(OLDEST) {
        return;
    }
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join("oracle-in");
    fs::create_dir_all(&root).unwrap();
    for (number, text) in SURVEYS.iter().enumerate() {
        fs::write(root.join(format!("{number}.svx")), text).unwrap();
        both(&root, &format!("{number}.svx"));
    }
}

/// Surveys of our own, whose loops weigh readings of every kind against each other.
const SURVEYS: &[&str] = &[
    "*fix 1 0 0 0\n1 2 10.37 6.2 11.1\n2 3 13.11 121.5 -27.2\n3 1 12.48 249.6 18.8\n2 4 3.09 272.5 71.3\n4 3 15.50 118.6 -36.0\n4 5 9.47 27.2 76.1\n5 1 18.40 184.7 -49.1\n3 6 11.48 60.6 25.7\n6 2 19.04 273.3 3.2\n6 5 23.22 278.7 34.2\n",
    "1 2 10 - DOWN\n2 3 12 120 -30\n3 1 19.2 300 57\n*sd tape 0.5 metres\n3 4 7 20 LEVEL\n2 4 11.7 83 -\n",
    "*data diving from to tape compass fromdepth todepth\n1 2 14.7 250 -20.7 -22.4\n2 3 9 70 -22.4 -20\n",
    "*data cylpolar from to tape compass depthchange\n1 2 10 90 -5\n2 3 10 210 2\n3 1 10.1 330 3.1\n",
    "*data cartesian from to easting northing altitude\n1 2 10 0 1\n2 3 0 10 1\n*data default\n3 1 14.3 225 -8\n",
    "*begin a\n*export 1 3\n1 2 10 0 0\n2 3 10 90 0\n3 1 14.5 225 1\n*end a\n*begin b\n*export 1\n1 2 8 45 -45\n*end b\n*equate a.3 b.1\n*equate b.1 x\nx y 3 0 0\n*equate y z\nz a.1 16.5 217 0\n",
    "*data normal from to tape compass clino backcompass backclino\n1 2 10 10 5 192 -7\n2 3 10 130 - 311 -2\n3 1 10.2 251 -3 72 2\n",
    "*cs UTM30N\n*cs out UTM30N\n*date 1988.04.02\n*declination auto 700000 6000000 100\n*fix 1 700000 6000000 100\n*fix 3 700030 6000030 100 0.5 1\n1 2 20 8 0\n2 3 31.5 79 0\n3 1 42.6 233 0\n",
];

#[test]
#[ignore = "needs cavern 1.4.24 of the package survex; .ci/run test runs it where it is installed"]
fn cavern_agrees_on_surveys_of_walls() {
    if !is_at_least(OLDEST_WITH_HEIGHTS) {
        return;
    }
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join("oracle-walls");
    fs::create_dir_all(&root).unwrap();
    for (number, text) in WALLS.iter().enumerate() {
        fs::write(root.join(format!("{number}.srv")), text).unwrap();
        both(&root, &format!("{number}.srv"));
    }
}

#[test]
#[ignore = "needs ../shared/data and cavern 1.4.24; .ci/run test runs it where they are there"]
fn cavern_agrees_on_a_recorded_cave_of_walls() {
    let cave = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/caves/suhadolca");
    let survey = read(&Folder::new(&cave).unwrap(), "suhadolca.wpj").unwrap();
    let oracle = cavern(&cave.join("suhadolca.wpj"), "suhadolca").unwrap();
    let summary = survey.summary();
    assert_eq!(
        (summary.legs, summary.stations, survey.loops),
        (oracle.legs, oracle.nodes, oracle.loops.unwrap_or(survey.loops))
    );
    let off = oracle.positions.iter().map(|(name, there)| {
        let here = super::at(&survey, name);
        here.iter().zip(there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    });
    // All its legs are of dives, whose loops `cavern` adjusts by other covariances (see the book,
    // "The figures"), so that its positions agree only nearly.
    let off = off.fold(0.0, f64::max);
    assert!(off < 2.5, "{off}");
}

/// Surveys of Walls of our own, with loops that weigh readings of every kind against each other.
const WALLS: &[&str] = &[
    "A B 10 0 0\nB C 10 120 5\nC A 10.5 240 -3\n",
    "A B 10 0 0\nB C 10 90 5\nA C 14.6 45 0\nC D 30 10 60\nD A 40 195 -30\n",
    "A B 10 0 0\nB C 10 -- 90\nC A 14.5 180 -45\n",
    "#units feet\nA B 100 0 --\nB C 100 90 2\nC A 145 226 0 2 1\n",
    "#units typeab=n,20 typevb=n,2\nA B 10 0/180 0\nB C 10 120/300 5/-5\nC A 10.5 240 -3\n",
    "A B 10 0 0\n#units uv=4\nB C 10 90 0\n#units uvv=.5 uvh=2\nC A 14.5 220 5\n",
    "A B 10 0 0\nB C 10 90 0 (R1)\nC A 14.5 220 5 (R.1,R.3)\n",
    "A B 10 0 0 (?,?)\nB C 10 90 0 (R5)\nC A 14.5 225 0 (*,)\n",
    "#fix A 0 0 0\n#fix B 0 11 0 (R5)\nA B 10 0 0\nB C 10 90 0\nC A 14.5 225 0\n",
    "#units rect\nA B 0 10 1\nB C 10 0 0\n#units ct\nC A 14.5 225 -3\n",
    "#units rect order=ne\nA B 10 0\nB C 0 10\n#units ct\nC A 14.5 225 -3\n",
    "#units order=da tape=ss\nA B 10 0 1 2\nB C 10 90 2 1\n#units tape=it inch=3\nC D 14.5 225 1 1.5\n",
    "A B 10 0 0\nA B 12 0 0\nB A 11 180 1\nB C 0 0 0\nC D 1 0 0\n",
];

#[test]
#[ignore = "needs ../shared/data and cavern; .ci/run test runs it where they are there"]
fn cavern_agrees_on_recorded_caves() {
    let caves = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/caves");
    if !is_at_least(OLDEST) {
        return;
    }
    if !caves.exists() {
        println!("{} is not there: nothing compared", caves.display());
        return;
    }
    for entry in [
        "dowprov/DowProv.svx",
        "mietusia_wyznia/Surveys/Jaskinia_Mietusia_Wyznia/mietusia_wyznia.svx",
        "mietusia_wyznia/GPS/gps_mietusia_wyznia.svx",
        "fulford/Fulford.dat",
        "fulford/Fulfords.mak",
    ] {
        both(&caves, entry);
    }
}

/// What the reader and `cavern` make of one file differently; `None` where they agree.
fn difference(root: &Path, entry: &str) -> Option<String> {
    let name = entry.replace('/', "-");
    let survey = read(&Folder::new(root).unwrap(), entry);
    let oracle = cavern(&root.join(entry), &name);
    let (survey, oracle) = match (survey, oracle) {
        (Err(_), None) => return None,
        (Ok(_), None) => return Some("read, though cavern refuses it".into()),
        (Err(refusal), Some(_)) => return Some(format!("refused: {refusal}")),
        (Ok(survey), Some(oracle)) => (survey, oracle),
    };
    let Summary { legs, length_m, stations, .. } = survey.summary();
    if (legs, stations) != (oracle.legs, oracle.nodes) {
        let there = (oracle.legs, oracle.nodes);
        return Some(format!("legs and stations {:?}, not {there:?}", (legs, stations)));
    }
    for (station, there) in &oracle.positions {
        let Some(found) = survey.station_named(station) else {
            return Some(format!("there is no station \"{station}\""));
        };
        let here = survey.stations[found].position;
        let off = here.iter().zip(there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if off > 0.05 {
            return Some(format!("{station} is {off:.3} m off"));
        }
    }
    if (length_m - oracle.length_m).abs() > 0.05 + 1e-3 * oracle.length_m {
        return Some(format!("{length_m} m long, not {}", oracle.length_m));
    }
    let loops = oracle.loops.filter(|loops| *loops != survey.loops)?;
    Some(format!("{} loops, not {loops}", survey.loops))
}

#[test]
#[ignore = "needs the tests of Survex in the folder that SURVEX_TESTS names, and their cavern"]
fn cavern_agrees_on_the_tests_of_survex() {
    let root = std::env::var_os("SURVEX_TESTS").map(PathBuf::from);
    let root = root.expect("SURVEX_TESTS names the folder of Survex's tests");
    if !is_at_least(OLDEST) {
        return;
    }
    let endings = ["svx", "dat", "mak", "clp", "srv", "wpj"];
    let entries = fs::read_dir(&root).unwrap().map(|entry| entry.unwrap().file_name());
    let mut entries: Vec<_> = entries.map(|name| name.into_string().unwrap()).collect();
    entries.retain(|name| name.rsplit_once('.').is_some_and(|it| endings.contains(&it.1)));
    entries.sort();
    let mut agreed = 0;
    for entry in &entries {
        let exception = EXCEPTIONS.iter().find(|(name, _)| name == entry);
        match (difference(&root, entry), exception) {
            (None, _) => agreed += 1,
            (Some(difference), Some((_, reason))) => println!("{entry}: {difference}: {reason}"),
            (Some(difference), None) => panic!("{entry}: {difference}"),
        }
    }
    println!("{agreed} of {} agree", entries.len());
}

/// The tests of Survex 1.4.22 with which the reader does not agree, and why.
const EXCEPTIONS: &[(&str, &str)] = &[
    ("cmd_solve.svx", "*solve is passed over: all loops are adjusted together"),
    ("cs.svx", "coordinate systems of ESRI are not computed"),
    ("nosurveyhanging.svx", "a survey of which nothing was measured is refused"),
    ("walls.srv", "INCH= and heights of instrument and target count, as in cavern 1.4.24"),
    ("wallsbaddatum.wpj", "a datum that is not known is taken for WGS 1984"),
];
