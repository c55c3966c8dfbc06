//! What is refused, with the place, and what is remarked on and read all the same.

use cave_survey::{Memory, read};
use proptest::prelude::*;

use super::svx;

/// A file, and the beginning of what is said of it.
const REFUSED: &[(&str, &str)] = &[
    ("", "cave.svx: there are no legs"),
    ("*frobnicate x\n1 2 10 0 0\n", "cave.svx:1:2: there is no command \"*frobnicate\""),
    ("1 2 10 0 0 hello\n", "cave.svx:1:12: \"hello\" is more than belongs here"),
    ("1 2 x 0 0\n", "cave.svx:1:5: \"x\" is no number"),
    ("1 2 10 0\n", "cave.svx:1:9: a number is missing"),
    ("1 2 - 0 0\n", "cave.svx:1: the tape's reading is left out"),
    ("1 2 10 - 0\n", "cave.svx:1: a leg that is not plumbed has no compass reading"),
    ("1 1 10 0 0\n", "cave.svx:1: the leg begins and ends at the same station"),
    ("a/b 2 10 0 0\n", "cave.svx:1:2: '/' is not allowed in a name"),
    (". .. 10 0 0\n", "cave.svx:1:12: the leg is between two anonymous stations"),
    ("*begin a\n1 2 10 0 0\n", "cave.svx:1: this *begin has no *end"),
    ("*begin a\n1 2 10 0 0\n*end b\n", "cave.svx:3:6: this *end is not of survey \"a\""),
    ("1 2 10 0 0\n*end a\n", "cave.svx:2:6: this *end has no *begin"),
    ("*begin\n1 2 10 0 0\n*end a\n", "cave.svx:3:6: the *begin that this *end closes has no name"),
    ("*include nofile\n", "cave.svx:1:10: there is no file \"nofile\""),
    ("*include cave\n", "cave.svx:1:10: \"cave\" includes itself"),
    ("*include ../cave\n", "cave.svx:1:10: \"../cave\" lies outside the folder"),
    ("*include /etc/passwd\n", "cave.svx:1:10: \"/etc/passwd\" lies outside the folder"),
    ("*fix 1 0 0 0\n*fix 1 0 0 1\n1 2 10 0 0\n", "cave.svx:2: \"1\" is fixed at two places"),
    ("*fix 1 0 0 0\n*fix 2 0 0 1\n*equate 1 2\n", "cave.svx:2: \"2\" is fixed at two places"),
    ("*fix 1 2 3\n1 2 10 0 0\n", "cave.svx:1:11: *fix has too few numbers"),
    (
        "1 2 10 0 0\n*data passage station left right up down\n9 1 1 1 1\n",
        "cave.svx:3: the passage is at station \"9\"",
    ),
    (
        "*begin a\n1 2 10 0 0\n*end a\na 3 10 0 0\n",
        "cave.svx:4: \"a\" is both a station and a survey",
    ),
    (
        "*begin a\n*export 1\n1 2 10 0 0\n*end a\n*equate a.2 3\n",
        "cave.svx:5: station \"a.2\" is used here",
    ),
    ("*begin a\n1 2 10 0 0\n*export 1\n*end a\n", "cave.svx:3:9: *export is not at the beginning"),
    ("*equate 1\n", "cave.svx:1:10: *equate names only one station"),
    ("*flags bogus\n", "cave.svx:1:8: there is no flag \"bogus\""),
    ("*units tape parsecs\n", "cave.svx:1:13: \"parsecs\" is no unit"),
    ("*units tapes feet\n", "cave.svx:1:8: \"tapes\" is no quantity"),
    ("*units tape degrees\n", "cave.svx:1:13: the quantity is not measured in degrees"),
    ("*calibrate tape compass 1\n", "cave.svx:1:25: angles and lengths are calibrated together"),
    ("*calibrate tape 0 0\n", "cave.svx:1:19: the scale factor is 0"),
    ("*sd tape 0 metres\n", "cave.svx:1:10: a standard deviation is not positive"),
    ("*data foo from to\n", "cave.svx:1:7: there is no style of data \"foo\""),
    (
        "*data normal from to tape compass clyno\n1 2 10 0 5\n",
        "cave.svx:1:35: there is no reading \"clyno\"; correct it, or give ignore for it",
    ),
    ("*data normal from to tape\n", "cave.svx:1:7: the order of readings lacks the compass"),
    (
        "*data normal from to tape tape compass\n",
        "cave.svx:1:27: the reading \"tape\" is there twice",
    ),
    (
        "*cs UTM30\n*fix 1 0 0 0\n",
        "cave.svx:2:8: *cs gives the system of the coordinates, but no *cs out",
    ),
    ("*cs nowhere\n", "cave.svx:1:5: there is no such coordinate system"),
    ("*require 9.9\n", "cave.svx:1:10: the survey requires Survex 9.9"),
    ("*title \"x\n", "cave.svx:1:8: a quotation mark is missing"),
    ("*ref \"x\n", "cave.svx:1:6: a quotation mark is missing"),
    ("*cartesian north\n", "cave.svx:1:12: no north; give grid, magnetic or true"),
    ("*cs out JTSK\n", "cave.svx:1:5: the axes of this system lead west and south"),
    (
        "*cs UTM33N\n*declination auto 400000 5400000 500\n1 2 10 0 0\n",
        "cave.svx:3: no *cs out says in which system positions are",
    ),
    (
        "*data normal station newline tape compass clino\n1\n 1 0 0\n\n2\n",
        "cave.svx:4:1: a leg has no second station",
    ),
    (
        "*data normal from to tape compass clino note\n1 2 10 0 0 x\n",
        "cave.svx:1:7: the order of readings lacks newline",
    ),
    ("*data passage station noteall left\n", "cave.svx:1:23: noteall is not the last reading"),
    (
        "*set names .\n1 2 1 0 0\na.b a.b 1 0 0\n",
        "cave.svx:3: the leg begins and ends at the same station \"a.b\"",
    ),
    ("*fix 1 0 0 0 0.1 0\n", "cave.svx:1:8: a standard deviation is not positive"),
    ("*date foo\n", "cave.svx:1:7: \"foo\" is no date"),
    ("1 2 1e9 0 0\n", "cave.svx:1:6: \"e9\" is no number"),
    ("1 2 9999999999999999999 0 0\n", "cave.svx:1: the leg's readings are too large"),
];

#[test]
fn what_cannot_be_used_is_refused_where_it_stands() {
    for (text, beginning) in REFUSED {
        let refusal = svx(text).err().unwrap_or_else(|| panic!("{text:?} is read"));
        let told = refusal.to_string();
        assert!(told.starts_with(beginning), "{text:?}:\n{told}, not\n{beginning}");
        assert!(!refusal.remedy.is_empty() && told.lines().count() == 1, "{told}");
    }
}

/// A file, and the beginning of the remark on it.
const REMARKED: &[(&str, &str)] = &[
    ("1 2 -10 0 0\n", "cave.svx:1:5: the tape's reading is negative"),
    ("1 2 10 400 0\n", "cave.svx:1:8: the compass reading is not of one full circle"),
    ("1 2 10 0 95\n", "cave.svx:1:10: the clino reading is over a right angle"),
    ("1 2 10 30 DOWN\n", "cave.svx:1: a plumbed leg has a compass reading"),
    ("1 2 10 0 0\n*entrance 5\n", "cave.svx:2: *entrance names \"5\""),
    ("1 2 10 0 0\n*equate 1 1\n", "cave.svx:2:11: a station is equated to itself"),
    ("*begin a\n1 2 10 0 0\n*end\n", "cave.svx:3:5: *end does not say the name of its survey"),
    (
        "*begin a\n1 2 1 0 0\n*end a\n*begin a\n2 3 1 0 0\n*end a\n",
        "cave.svx:4:8: survey \"a\" goes on here",
    ),
    ("*prefix a\n1 2 10 0 0\n", "cave.svx:1:2: *prefix is out of use"),
    ("*date 1801\n1 2 10 0 0\n", "cave.svx:1:7: date 1801"),
    (
        "*fix 9 1 2 3\n*fix 1 0 0 0\n1 2 10 0 0\n",
        "cave.svx:1: the fixed station \"9\" is used by no leg",
    ),
    ("1 2 10 0 0\n*solve\n", "cave.svx:2:2: *solve is passed over"),
];

#[test]
fn what_is_doubtful_is_read_with_a_remark_that_names_the_line() {
    for (text, beginning) in REMARKED {
        let survey = svx(text).unwrap_or_else(|refusal| panic!("{text:?}: {refusal}"));
        let told = survey.warnings.first().map(ToString::to_string).unwrap_or_default();
        assert!(told.starts_with(beginning), "{text:?}:\n{told}, not\n{beginning}");
    }
}

#[test]
fn what_is_said_of_a_file_holds_none_of_its_control_characters() {
    let names = Memory::default().with("cave.srv", "A B \u{1b}[2J 0 0\n#\u{7},\n");
    let told = read(&names, "cave.srv").unwrap_err().to_string();
    assert_eq!(told.chars().find(|it| it.is_control()), None, "{told:?}");
    let survey = svx("*title \"x\"\n1 2 1 0 0\n*date \u{1b}x 1\n").unwrap_err().to_string();
    assert_eq!(survey.chars().find(|it| it.is_control()), None, "{survey:?}");
}

#[test]
fn files_that_include_each_other_without_end_are_refused() {
    let ring = Memory::default().with("a.svx", "*include b\n").with("b.svx", "*include a\n");
    assert!(read(&ring, "a.svx").unwrap_err().wrong.contains("includes itself"));
    // Each file includes the next one ten times: 10^20 in all.
    let mut bomb = Memory::default();
    for n in 0..20 {
        bomb = bomb.with(&format!("{n}.svx"), format!("*include {}\n", n + 1).repeat(10));
    }
    let bomb = bomb.with("20.svx", "");
    assert!(read(&bomb, "0.svx").unwrap_err().wrong.contains("more than"));
}

#[test]
fn more_legs_than_any_cave_has_are_refused() {
    let mut text = String::new();
    for n in 0..=cave_survey::MOST_LEGS {
        text += &format!("{n} {} 1 0 0\n", n + 1);
    }
    let refusal = svx(&text).unwrap_err().to_string();
    assert!(
        refusal.starts_with("cave.svx:250001: the survey has more than 250000 legs"),
        "{refusal}"
    );
}

#[test]
fn a_thousand_mistakes_in_a_row_fill_no_memory_with_remarks() {
    let text = "1 2 10 400 0\n".repeat(5000);
    assert_eq!(svx(&text).unwrap().warnings.len(), 1001);
}

/// Lines that are nearly right, to get deep into the reader.
fn nearly_a_survey() -> impl Strategy<Value = String> {
    let word = prop::sample::select(vec![
        "*begin",
        "*end",
        "*data",
        "normal",
        "passage",
        "diving",
        "from",
        "to",
        "tape",
        "compass",
        "clino",
        "newline",
        "station",
        "left",
        "right",
        "up",
        "down",
        "*fix",
        "*equate",
        "*export",
        "*units",
        "*calibrate",
        "*sd",
        "feet",
        "degrees",
        "*flags",
        "splay",
        "not",
        "*set",
        "*cs",
        "UTM33N",
        "out",
        "*declination",
        "auto",
        "*date",
        "2001",
        "*infer",
        "equates",
        "on",
        "1",
        "2",
        "3",
        "a",
        "a.1",
        "-",
        ".",
        "..",
        "-V",
        "10",
        "-5.5",
        "0",
        "90",
        "N45E",
        "\"",
        ";",
        "\n",
        "\n",
        "\n",
        "*truncate",
        "*case",
        "x20",
        "*alias",
        "default",
        "*solve",
        "*include",
        "cave",
        "depth",
        "1 2 10 0 0\n",
        "2 3 10 120 0\n",
        "3 1 10 240 0\n",
    ]);
    prop::collection::vec(word, 0..60).prop_map(|words| words.join(" "))
}

/// A name for each reader, and one that says nothing.
const NAMES: [&str; 10] = [
    "cave.svx", "cave.3d", "cave.dat", "cave.clp", "cave.mak", "cave.srv", "cave.wpj", "cave.th",
    "cave.tro", "cave.txt",
];

/// A file that each reader reads, and its name.
const SOUND: &[(&str, &str)] = &[
    (
        "cave.svx",
        "*begin a\n*cs UTM33N\n*cs out UTM32N\n*declination auto 400000 5400000 500\n*date 2010.1.1\n\
         *fix 1 400000 5400000 500\n*units clino 50 percent\n*set names ._\n1 2.x 10 0 0\n2.x . 3 9 1\n\
         *data cartesian from to dx dy dz\n*cartesian magnetic 5 degrees\n1 3 1 2 3\n\
         *data passage station left noteall\n1 2 x\n*include one.dat\n*include two.srv\n*end a\n",
    ),
    (
        "one.dat",
        "Cave\r\nSURVEY NAME: A\r\nSURVEY DATE: 6 29 1987\r\nSURVEY TEAM:\r\nme\r\n\
         DECLINATION: 5.0 FORMAT: DMMDLUDRLADadBT CORRECTIONS: 1 2 .5 CORRECTIONS2: -1 -2\r\n\r\n\
         FROM TO LEN\r\n\r\na b 32.81 88 10 3 3 3 3 270 -8 #|#\r\n\
         b c 32.81 -999 999 3 3 3 3 180 0 #|LSPC# x\r\n\u{c}\r\n",
    ),
    (
        "cave.mak",
        "/ x\r\n@357715.7,4372837.5,3048.0,13,-1.05;\r\n$13;&North American 1983;\r\n[sub;];\r\n\
         #one.dat,\r\n a [f 1 , 2 3], b;\r\n%0.3;!OT;\r\n",
    ),
    (
        "two.srv",
        "#units $x=\"feet decl\"\r\n#units $(x)=5 typeab=c,2X order=dav uv=2\r\n#date 2001-01-01\\\r\n\
         #fix A 0 0 0 (R5,?)\r\nA B#1 10 0/180 0/-- 1 2 (R1) <1,2,3,4>> #s /L\r\nB#1 - 5 90 --\r\n\
         #[\r\nx\r\n#]\r\n#units rect save\r\nB#1 x:C 1 2 3\r\n#units restore\r\n",
    ),
    (
        "cave.wpj",
        ".BOOK\tX\r\n.STATUS\t3\r\n\
         .REF 5068100.876 249623.224 33 -2.3 553 0 45 43 1 11 47 0 27 \"WGS 1984\"\r\n\
         .OPTIONS\tfeet\r\n.SURVEY\ts\r\n.NAME\tTWO\r\n.STATUS\t8\r\n.ENDBOOK\r\n",
    ),
    (
        "cave.th",
        "encoding utf-8\nsurvey a -title \"A\" -declination [2000.01.01 4 2010.01.01 14 degrees]\n\
         input one\ncentreline\ncs UTM33\nfix 1 4e5 5.4e6 500 1\ndate 2005.01.01\nunits tape 2 feet\n\
         calibrate compass 1 1\ndata normal from to tape compass clino up left\n1 2 10 12:30 5 [1 2] -\n\
         2 - 3 90 up . .\ngroup\nflags not splay duplicate\ndata normal station newline length bearing gradient\n\
         2\n5 90 -5\n3\nendgroup\nstation 3 \"\" entrance\nendcentreline\nequate 3 1@b\nendsurvey\n",
    ),
    (
        "one.th",
        "survey b\ncentreline\ndata diving from to length compass depthchange\n1 2 5 0 1\nendcentreline\nendsurvey\n",
    ),
    (
        "cave.tro",
        "Version 5.11\nTrou X,0,0,0,\nEntree E1\nParam Deca Deg Clino Gra 1.30 Dir,Dir,Dir Dep\n\
         E0 E0 0 0 0 1 2 3 4 N I * N\nE0 E1 10 90.30 50 * 1 2 1 N E * N\n* * 3 0 0 * * * * N E M *\n",
    ),
    (
        "cave.txt",
        "Cave (m, 400)\n\n[1]: 2010/01/01 10.00 \"c\"\n1.0\t1.1\t10\t90\t0\t[1]\t\"x\"\n1.1\t\t3\t0\t0\t[1]\n\
         1.1\t2.0\t0\t0\t0\t[1]\n1.0\t1\t2\t3\n",
    ),
    (
        "table.txt",
        "FIX\n1.0\t1\t2\t3\nTRIP\nDECLINATION 9\nDATA\n1.0\t1.1\t81\t0\t10\t<\n1.1\t\t81\t0\t1\t>\n",
    ),
];

/// The same files, of which one is changed at some places.
fn changed(entry: usize, changes: &[(u8, prop::sample::Index, u8)]) -> Memory {
    let mut files = Memory::default();
    for (number, (name, text)) in SOUND.iter().enumerate() {
        let mut bytes = text.as_bytes().to_vec();
        for (kind, place, byte) in changes.iter().filter(|_| number == entry) {
            let at = place.index(bytes.len().max(1)).min(bytes.len().saturating_sub(1));
            match kind % 5 {
                0 if !bytes.is_empty() => bytes[at] = *byte,
                1 => bytes.insert(at, *byte),
                2 if !bytes.is_empty() => {
                    drop(bytes.drain(at..(at + usize::from(*byte) % 20).min(bytes.len())))
                }
                3 => {
                    let end = (at + usize::from(*byte)).min(bytes.len());
                    let copy = bytes[at..end].to_vec();
                    bytes.extend(copy);
                }
                _ => bytes.truncate(bytes.len() - usize::from(*byte) % 8 * bytes.len() / 64),
            }
        }
        files = files.with(name, bytes);
    }
    files
}

#[test]
fn sound_files_are_read() {
    for (name, _) in SOUND {
        read(&changed(usize::MAX, &[]), name).unwrap_or_else(|refusal| panic!("{name}: {refusal}"));
    }
}

proptest! {
    #[test]
    fn no_changed_file_does_harm(
        entry in 0..SOUND.len(),
        changes in prop::collection::vec((any::<u8>(), any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let files = changed(entry, &changes);
        for (name, _) in SOUND {
            match read(&files, name) {
                Ok(survey) => {
                    prop_assert!(survey.stations.iter().flat_map(|it| it.position).all(f64::is_finite));
                }
                Err(refusal) => {
                    prop_assert!(refusal.to_string().lines().count() == 1 && !refusal.remedy.is_empty());
                }
            }
        }
    }

    #[test]
    fn no_text_does_harm(text in nearly_a_survey()) {
        if let Ok(survey) = svx(&text) {
            prop_assert!(survey.stations.iter().flat_map(|it| it.position).all(f64::is_finite));
        }
    }

    #[test]
    fn no_bytes_do_harm(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        for name in NAMES {
            let _ = read(&Memory::default().with(name, bytes.clone()), name);
        }
    }
}
