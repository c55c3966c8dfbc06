//! Which reader a file is given to, and what is said of files that none reads.

use cave_survey::{Memory, Survey, read};

use super::assert_at;

fn told(name: &str, bytes: impl Into<Vec<u8>>) -> String {
    match read(&Memory::default().with(name, bytes), name) {
        Ok(_) => panic!("{name} is read"),
        Err(refusal) => refusal.to_string(),
    }
}

fn read_as(name: &str, text: &str) -> Survey {
    let files = Memory::default().with(name, text);
    read(&files, name).unwrap_or_else(|refusal| panic!("{name}: {refusal}"))
}

const SURVEX: &str = "; words\n*begin a\n1 2 10 0 0\n*end a\n";
const THERION: &str = "encoding utf-8\nsurvey a\ncentreline\ndata normal from to tape compass clino\n1 2 10 0 0\n\
     endcentreline\nendsurvey\n";
const COMPASS: &str = "Cave\r\nSURVEY NAME: A\r\nSURVEY DATE: 6 29 1987\r\nSURVEY TEAM:\r\nme\r\n\
                       DECLINATION: 0 FORMAT: DDDDUDLRLADN\r\n\r\nFROM TO LEN\r\n\r\na b 32.81 0 0 1 1 1 1\r\n";
const WALLS: &str = "; words\r\n#units feet\r\nA B 32.81 0 0\r\n";
const VISUAL_TOPO: &str = "Version 5.11\nVerification 1\n\nTrou Example,0,0,0,\nEntree E1\n\
                           Param Deca Degd Clino Gra 0.0000 Dir,Dir,Dir Arr Inc 0,0,0\n\n\
                           E0 E0 0.00 0.00 0.00 1 2 3 4 N I * N\n\
                           E0 E1 10.00 90.00 50.00 * * 2 1 N I * N ; words\n\
                           * E2 10.00 0.00 0.00 1 1 1 1 N E * N\n\
                           E1 * 3.00 0.00 0.00 * * * * N E M *\n[Configuration 4.5]\nx\n";

#[test]
fn a_file_whose_ending_says_nothing_is_known_by_its_contents() {
    for (text, station) in
        [(SURVEX, "a.2"), (THERION, "a.2"), (COMPASS, "b"), (WALLS, "B"), ("1 2 10 0 0\n", "2")]
    {
        for name in ["cave", "cave.txt", "cave.survey", "cave.old.x"] {
            assert_at(&read_as(name, text), station, [0.0, 10.0, 0.0]);
        }
    }
    let project =
        ".BOOK\tX\r\n.NAME\tX\r\n.SURVEY\tone\r\n.NAME\tONE\r\n.STATUS\t8\r\n.ENDBOOK\r\n";
    let files = Memory::default().with("cave.w", project).with("one.srv", WALLS);
    assert_at(&read(&files, "cave.w").unwrap(), "B", [0.0, 10.0, 0.0]);
    let files = Memory::default().with("cave.m", "#one.dat,a[m,1,2,3];\n").with("one.dat", COMPASS);
    assert_at(&read(&files, "cave.m").unwrap(), "b", [1.0, 12.0, 3.0]);
}

#[test]
fn a_file_of_another_format_than_its_ending_says_is_refused_by_the_name_of_that_format() {
    for (name, text, expected) in [
        (
            "cave.svx",
            THERION,
            "looks like a file of Therion, and not of Survex; rename it to end in .th",
        ),
        (
            "cave.dat",
            SURVEX,
            "looks like a file of Survex, and not of Compass; rename it to end in .svx",
        ),
        ("cave.th", SURVEX, "looks like a file of Survex, and not of Therion"),
        ("cave.srv", COMPASS, "looks like a file of Compass, and not of Walls"),
        ("cave.svx", WALLS, "looks like a file of Walls, and not of Survex"),
        ("cave.tro", THERION, "looks like a file of Therion, and not of VisualTopo"),
        ("cave.th", VISUAL_TOPO, "looks like a file of VisualTopo, and not of Therion"),
    ] {
        let told = told(name, text);
        assert!(told.starts_with(&format!("{name}: this {expected}")), "{told}");
    }
    assert!(told("cave.svx", "1 2 x 0 0\n").starts_with("cave.svx:1:5: \"x\" is no number"));
}

/// Also where another file includes it.
#[test]
fn text_in_utf_16_is_refused_by_that_name() {
    let utf_16 = |text: &str| -> Vec<u8> {
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
    };
    for (name, text) in [("a.svx", SURVEX), ("a.th", THERION), ("a.dat", COMPASS), ("a.srv", WALLS)]
    {
        let told = told(name, utf_16(text));
        assert!(told.contains("is text in UTF-16; save it as UTF-8"), "{told}");
    }
    let files = Memory::default().with("whole.svx", "*include a\n").with("a.svx", utf_16(SURVEX));
    let told = read(&files, "whole.svx").unwrap_err().to_string();
    assert_eq!(told, "whole.svx:1:10: \"a\" is text in UTF-16; save it as UTF-8");
}

#[test]
fn a_file_that_no_reader_reads_is_refused_by_name_with_the_way_out() {
    for (name, bytes, expected) in [
        (
            "cave.plt",
            &b"Z+x\nNExample\n"[..],
            "plots of Compass are not read; give the .dat or .mak",
        ),
        (
            "cave.top",
            b"Top\x03\0\0",
            "files of PocketTopo are not read; export it as Therion or text",
        ),
        ("cave.bin", b"Top\x03\0\0", "files of PocketTopo are not read"),
        (
            "cave.csx",
            b"<?xml?><csurvey/>",
            "files of cSurvey are not read; export a .3d, a .svx or a .th",
        ),
        ("cave.trox", b"<VisualTopo/>", "files of VisualTopo in XML are not read; save it as .tro"),
        ("cave.xml", b"<?xml?><csurvey/>", "files in XML are not read"),
        ("cave.th2", b"scrap a\n", "drawings of Therion are not read; give the .th"),
        ("cave.lox", b"\x01\0\0\0", "models of Therion are not read; export a .3d"),
        ("cave.kml", b"<kml/>", "drawings and positions without legs are not read"),
        ("cave.csv", b"from,to,tape,compass,clino\n1,2,10,0,0\n", "tables of shots are not read"),
        ("cave.md", b"# A cave\n\nWords about it.\n", "this is no survey of a format that is read"),
        ("cave.jpg", b"\xff\xd8\xff\xe0\0\x10JFIF", "this is no survey of a format that is read"),
        ("cave", b"", "this is no survey of a format that is read"),
    ] {
        let told = told(name, bytes);
        assert!(told.starts_with(&format!("{name}: {expected}")), "{told}");
    }
}

#[test]
fn a_file_of_visual_topo_has_its_legs_splays_and_dimensions() {
    let survey = read_as("cave.tro", VISUAL_TOPO);
    assert_at(&survey, "E1", [7.07, 0.0, 7.07]);
    assert_at(&survey, "E2", [7.07, 10.0, 7.07]);
    let summary = survey.summary();
    assert_eq!((summary.legs, summary.splays, summary.with_dimensions), (1, 1, 3));
    assert_eq!(survey.title.as_deref(), Some("Example"));
    assert!(survey.stations[survey.station_named("E1").unwrap()].is_entrance);
    assert!(survey.legs[1].flags.duplicate, "E excludes it from the length");
    let first = survey.passages[0][0];
    assert_eq!(
        (first.left, first.right, first.up, first.down),
        (Some(1.0), Some(2.0), Some(3.0), Some(4.0))
    );
    let units = "Param Deca Deg Clino Deg 1.5 Dir,Dir,Dir Dep\nA B 10 88.30 0.00 1 1 1 1\n";
    let survey = read_as("cave.tro", units);
    assert_at(&survey, "B", [10.0, 0.0, 0.0]);
    assert_eq!(survey.stations[survey.passages[0][0].station].name, "A");
}

#[test]
fn shots_of_visual_topo_by_other_means_are_refused() {
    for (text, expected) in [
        (
            "Param Topof Degd Clino Degd 0 Dir,Dir,Dir\n",
            "cave.tro:1: shots of VisualTopo by \"Topof\" are not read",
        ),
        (
            "Param Deca Degd Vulc Degd 0 Dir,Dir,Dir\n",
            "cave.tro:1: shots of VisualTopo by \"Vulc\"",
        ),
        (
            "Param Deca Degd Clino Degd 0 Inv,Dir,Dir\n",
            "cave.tro:1: shots of VisualTopo by \"Inv,Dir,Dir\"",
        ),
        ("Param Deca\n", "cave.tro:1: Param is too short"),
        ("A B 10 0\n", "cave.tro:1: \"A B 10 0\" is no shot"),
        ("A B x 0 0\n", "cave.tro:1: \"x\" is no number"),
        ("* B 10 0 0\n", "cave.tro:1: no shot is before this *"),
        ("A B 10 * 10\n", "cave.tro:1: a leg that is not plumbed has no compass reading"),
    ] {
        let told = told("cave.tro", text);
        assert!(told.starts_with(expected), "{told}, not {expected}");
    }
}

#[test]
fn both_exports_of_pocket_topo_as_text_are_read() {
    let text = "Example cave (m, 400)\n\n[1]: 2010/01/01 10.00 \"c\"\n[2]: 2010/01/02 0.00\n\n\
                1.0\t1.1\t10.00\t90.00\t0.00\t[1]\t\"words [3]\"\n1.0\t1.1\t10.10\t90.00\t0.00\t[1]\n\
                1.1\t\t3.00\t0.00\t0.00\t[1]\n1.1\t2.0\t0.000\t0.00\t0.00\t[2]\n2.0\t2.1\t5.00\t0.00\t100.00\t[2]\n\
                1.0\t100.0\t200.0\t300.0\n";
    let survey = read_as("cave.txt", text);
    assert_at(&survey, "2.0", [110.05, 200.0, 300.0]);
    assert_at(&survey, "2.1", [110.05, 200.0, 305.0]);
    assert_eq!((survey.summary().legs, survey.summary().splays), (2, 1));
    let text = "FIX\n1.0\t100.0\t200.0\t300.0\nTRIP\nDATE 2008-01-01 \nDECLINATION     9.00\nDATA\n\
                1.0\t\t301.86\t2.25\t1.800\t>\n1.0\t1.1\t81.00\t0.00\t10.000\t<\n\nPLAN\nPOLYLINE x\n1 2\n";
    let survey = read_as("cave.txt", text);
    assert_at(&survey, "1.1", [110.0, 200.0, 300.0]);
    assert_eq!((survey.summary().legs, survey.summary().splays), (1, 1));
    assert!(
        told("cave.txt", "x (m, 360)\n1 2 a 0 0 [1]\n")
            .starts_with("cave.txt:2: \"a\" is no number")
    );
    assert!(
        told("cave.txt", "TRIP\nDATA\n1\t2\n")
            .starts_with("cave.txt:3: the row has too few columns")
    );
}

/// For each leg by the names of its ends, whether it was dived and whether it is called a squeeze.
fn marks(name: &str, text: &str) -> Vec<(String, bool, bool)> {
    let survey = read_as(name, text);
    let end = |station: usize| survey.stations[station].name.clone();
    let mark = |leg: &cave_survey::Leg| {
        (format!("{} {}", end(leg.from), end(leg.to)), leg.flags.dived, leg.flags.squeeze)
    };
    survey.legs.iter().map(mark).collect()
}

#[test]
fn legs_that_were_dived_and_squeezes_that_are_named_are_known_in_every_format() {
    let expected = |names: [&str; 3]| {
        names.map(str::to_owned).into_iter().zip([false, true, false]).zip([false, false, true])
    };
    let expected = |names: [&str; 3]| -> Vec<(String, bool, bool)> {
        expected(names).map(|((name, dived), squeeze)| (name, dived, squeeze)).collect()
    };
    let survex = "1 2 10 90 0\n*data diving from to tape compass fromdepth todepth\n2 3 10 90 0 -4\n\
                  *data normal from to tape compass clino\n3 4 5 90 0 ; up the Squeeze, and on\n";
    assert_eq!(marks("cave.svx", survex), expected(["1 2", "2 3", "3 4"]));
    let level = survex.replace("diving", "cylpolar").replace("Squeeze", "squeezed bend");
    let told = marks("cave.svx", &level);
    assert!(told[1].1 && !told[2].2, "{told:?}");
    let walls = "#units meters\nA B 10 90 0\n#units ORDER=DA\nB C 10 90 0 4 <0,0,0,0> ; deep\n\
                 #units ORDER=DAV\nC D 5 90 0 ; squeeze\n";
    assert_eq!(marks("cave.srv", walls), expected(["A B", "B C", "C D"]));
    let therion = "survey a\ncentreline\ndata normal from to length compass clino\n1 2 10 90 0\n\
                   data diving from to length compass fromdepth todepth\n2 3 10 90 0 -4\n\
                   endcentreline\nendsurvey\n";
    assert_eq!(marks("cave.th", therion), expected(["a.1 a.2", "a.2 a.3", ""])[..2]);
    let head = |format: &str| COMPASS.replace("DDDDUDLRLADN", format);
    let compass = format!("{}b c 9 0 0 1 1 1 1 #|L# after the squeeze\r\n", head("DDDWUDLRLADN"));
    let told = marks("cave.dat", &compass);
    assert_eq!(told, [("a b".into(), true, false), ("b c".into(), true, true)]);
    assert!(!marks("cave.dat", COMPASS)[0].1);
}
