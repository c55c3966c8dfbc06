//! Compass's files. The positions are those that `cavern` 1.4.22 gives.

use cave_survey::{Memory, Refusal, Survey, read};

use super::assert_at;

fn dat(declination: &str, format: &str, lines: &str) -> String {
    format!(
        "Cave\r\nSURVEY NAME: A\r\nSURVEY DATE: 6 29 1987  COMMENT:x\r\nSURVEY TEAM: \r\nme\r\n\
         DECLINATION: {declination}  FORMAT: {format}\r\n\r\n\
         FROM TO LENGTH BEARING INC LEFT UP DOWN RIGHT FLAGS COMMENTS\r\n\r\n{lines}\r\n\x0c\r\n"
    )
}

const PLAIN: &str = "DDDDUDLRLADN  CORRECTIONS:  0.00 0.00 0.00";

fn one(text: String) -> Result<Survey, Refusal> {
    read(&Memory::default().with("cave.dat", text), "cave.dat")
}

#[test]
fn a_shot_has_its_declination_and_its_dimensions_in_feet() {
    let survey =
        one(dat("5.0", PLAIN, "a b 10 0 0 1 2 -9999 4\r\nb g 10 0 0 1 2 3 4 #|LP# words")).unwrap();
    assert_at(&survey, "b", [0.27, 3.04, 0.0]);
    assert_at(&survey, "g", [0.53, 6.07, 0.0]);
    let summary = survey.summary();
    assert_eq!((summary.legs, summary.stations, summary.with_dimensions), (1, 3, 2));
    let section = survey.passages[0][0];
    assert!((section.left.unwrap() - 0.3048).abs() < 1e-9 && section.down.is_none());
}

#[test]
fn backsights_count_with_the_corrections_of_foresights_or_their_own() {
    let format = "DDDDUDLRLADBT  CORRECTIONS:  2.00 1.00 0.00";
    let survey =
        one(dat("10.0", format, "a b 10 90 0 1 2 3 4 272 -2\r\nb c 10 -999 5 1 1 1 1 100 -6"))
            .unwrap();
    assert_at(&survey, "b", [2.97, -0.69, 0.05]);
    assert_at(&survey, "c", [0.16, 0.45, 0.35]);
    let format = "DMMDLUDRLADadBF  CORRECTIONS: 1 2 .5 CORRECTIONS2: -1 -2";
    let survey = one(dat("0.0", format, BACK)).unwrap();
    assert_at(&survey, "b", [9.96, 0.17, 1.94]);
    assert_at(&survey, "c", [9.79, 10.32, 2.29]);
}

/// Shots with backsights, one of which has no foresight, and one that is left out.
const BACK: &str = "a b 32.81 88 10 3 3 3 3 270 -8 #|#\r\nb c 32.81 -999.00 999 3 3 3 3 180 0 #|L#\r\n\
                    c d 32.81 45 0 3 3 3 3 225 0 #|X# no";

#[test]
fn the_letter_for_backsights_is_the_fourteenth_where_the_order_of_readings_has_five() {
    for format in ["DMMDLUDRLADadBF", "DMMDLUDRLADadCF", "DMMDLUDRLADadCT", "DMMDLUDRLADadB"] {
        let survey = one(dat("0.0", format, BACK)).unwrap();
        assert_at(&survey, "b", [9.88, 0.17, 1.56]);
        assert_at(&survey, "c", [9.88, 10.17, 1.56]);
        assert!(survey.station_named("d").is_none(), "its shot is excluded");
        let summary = survey.summary();
        assert_eq!((summary.legs, survey.legs.len()), (1, 2));
        assert!((summary.length_m - 10.0).abs() < 0.001, "the duplicate does not count");
    }
    let none = one(dat("0.0", "DMMDLUDRLADadNF", "a b 10 0 0 3 3 3 3 #|S#")).unwrap();
    assert_eq!(none.summary().splays, 1, "no backsights stand before the flags");
}

#[test]
fn corrections_that_are_left_out_are_none() {
    for format in [
        "DDDDUDLRLADN",
        "DDDDUDLRLADN CORRECTIONS:",
        "DDDDUDLRLADN CORRECTIONS:0 0 CORRECTIONS2:0 0",
    ] {
        let survey = one(dat("90", format, "a b 32.81 0 0 1 1 1 1")).unwrap();
        assert_at(&survey, "b", [10.0, 0.0, 0.0]);
    }
}

#[test]
fn dimensions_belong_to_the_station_that_the_last_letter_names() {
    for (format, named) in [("DDDDLUDRLADadNT", "b"), ("DDDDLUDRLADadNF", "a")] {
        let survey = one(dat("0.0", format, "a b 10 0 0 3 3 3 3")).unwrap();
        assert_eq!(survey.stations[survey.passages[0][0].station].name, named, "{format}");
    }
}

#[test]
fn a_dimension_of_999_is_none() {
    let survey = one(dat("0.0", PLAIN, "a b 10 0 0 999 999.00 -999 9999")).unwrap();
    assert!(survey.passages.is_empty());
    let survey = one(dat("0.0", PLAIN, "a b 10 0 0 999.5 2 -1 3")).unwrap();
    let section = survey.passages[0][0];
    assert!(section.left.is_some_and(|left| left > 300.0) && section.down.is_none());
}

#[test]
fn flags_say_what_is_a_splay_or_over_ground_or_not_to_be_adjusted() {
    let lines = "a b 32.81 88 10 3 3 3 3 #|P#\r\nb c 32.81 10 0 3 3 3 3 #|S#\r\n\
                 b d 32.81 90 5 3 3 3 3 #|LS# x\r\nb e 32.81 90 5 3 3 3 3 #|L S# x\r\n\
                 e f 3.28 90 0 1 1 1 1 #|C#\r\ne g 3.28 45 0 1 1 1 1\r\ng f 3.28 135 0 1 1 1 1\r\n\
                 f f 3 0 0 1 1 1 1\r\nf f 0 0 0 0 0 0 0";
    let survey = one(dat("0.0", "DMMDLUDRLADadNF", lines)).unwrap();
    for (name, at) in [("f", [20.80, 0.34, 2.61]), ("g", [20.30, 0.93, 2.61])] {
        assert_at(&survey, name, at);
    }
    let summary = survey.summary();
    assert_eq!((summary.legs, summary.splays, summary.stations, summary.loops), (4, 2, 7, 1));
    let surface: Vec<_> = survey.legs.iter().map(|leg| leg.flags.surface).collect();
    assert_eq!(surface, [true, false, false, false, false, false, false]);
    let told: Vec<_> = survey.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(told, ["cave.dat:17: the shot leads from a station to itself"]);
}

#[test]
fn a_file_with_closed_loops_has_its_corrections_in_its_readings() {
    let text = dat("0.0", "DDDDUDLRLADN  CORRECTIONS: 10 10 10", "a b 10 90 0 1 1 1 1");
    let survey = read(&Memory::default().with("cave.clp", text), "cave.clp").unwrap();
    assert_at(&survey, "b", [3.05, 0.0, 0.0]);
}

#[test]
fn names_in_no_utf_8_stay_apart() {
    let text = dat("0.0", PLAIN, "a1 b? 10 90 0 1 1 1 1\r\nb? b! 10 90 0 1 1 1 1");
    let bytes = text.bytes().map(|byte| match byte {
        b'?' => 0xe9,
        b'!' => 0xe8,
        byte => byte,
    });
    let files = Memory::default().with("cave.dat", bytes.collect::<Vec<u8>>());
    assert_at(&read(&files, "cave.dat").unwrap(), "bè", [6.10, 0.0, 0.0]);
}

#[test]
fn lines_may_end_as_on_the_old_macintosh() {
    let text = dat("0.0", PLAIN, "a b 10 90 0 1 1 1 1").replace("\r\n", "\r");
    assert_at(&one(text + "\u{1a}").unwrap(), "b", [3.05, 0.0, 0.0]);
}

#[test]
fn a_shot_of_no_length_equates_and_an_excluded_one_is_left_out() {
    let lines = "a b 10 -999 90 1 2 3 4\r\nb d 0 0 0 1 1 1 1\r\nd e 5 90 0 1 1 1 1\r\ne f 1 0 0 1 1 1 1 #|X#";
    let survey = one(dat("0.0", PLAIN, lines)).unwrap();
    assert_at(&survey, "e", [1.52, 0.0, 3.05]);
    assert!(survey.station_named("f").is_none());
}

/// The magnetic field that `cavern` 1.4.22 has is a newer edition, which differs by 0.003° here.
fn assert_near(survey: &Survey, name: &str, at: [f64; 3]) {
    let found = super::at(survey, name);
    let off = found.iter().zip(at).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 0.06, "{name} is at {found:?}");
}

#[test]
fn a_base_gives_the_declination_of_the_day_and_the_convergence() {
    let place = "@357715.717,4372837.574,3048.000,13,-1.05;";
    // The datum may come after the base.
    let files = Memory::default()
        .with("cave.mak", format!("/ words\r\n{place}\r\n&North American 1983;\r\n#ONE.DAT,\r\n a[m,357715,4372837,3],b;\r\n#two.dat;\r\n"))
        .with("one.dat", dat("0.0", PLAIN, "a b 1000 0 0 1 2 3 4"))
        .with("two.dat", dat("0.0", PLAIN, "b c 1000 90 0 1 2 3 4"));
    let survey = read(&files, "cave.mak").unwrap();
    assert_near(&survey, "b", [357_784.16, 4_373_133.85, 3.0]);
    assert_near(&survey, "c", [358_081.01, 4_373_064.69, 3.0]);
    assert!(survey.stations[survey.station_named("a").unwrap()].is_entrance);
    // Where the datum is not known, the files say the declination.
    let files = Memory::default()
        .with("cave.mak", format!("{place}&Foo 1;\r\n$13;\r\n#one.dat;"))
        .with("one.dat", dat("5.0", PLAIN, "a b 1000 0 0 1 2 3 4"));
    let survey = read(&files, "cave.mak").unwrap();
    assert_near(&survey, "b", [26.57, 303.64, 0.0]);
    assert!(survey.warnings[0].text.starts_with("zone 13 of the datum \"Foo 1\" is not known"));
}

#[test]
fn folders_comments_and_ends_of_lines_may_stand_anywhere_in_a_project() {
    let project = "@357715.717,4372837.574,3048.000,13,-1.050;\r\n$13;\r\n&North American 1983;\r\n\
                   [sub;\r\n#on/com/e.da\r\nt ,\r\n a [f 1173607.995 , 14346579.967 10000.000], b;\r\n\
                   [deep er;#two three.dat;];\r\n#four.dat;]\r\n?x;\r\n!OT;%0.3;*1;";
    let at = |date: &str, lines: &str| dat("5.0", PLAIN, lines).replace("6 29 1987", date);
    let files = Memory::default()
        .with("cave.mak", project)
        .with("sub/one.dat", at("6 29 1987", "a b 1000 0 0 1 2 3 4"))
        .with("sub/deep er/two three.dat", at("1 1 1", "b c 1000 90 0 1 2 3 4"))
        .with("sub/four.dat", at("11 2 2019", "c d 1000 90 0 1 2 3 4"));
    let survey = read(&files, "cave.mak").unwrap();
    assert_near(&survey, "b", [357_784.88, 4_373_134.42, 3048.0]);
    assert_near(&survey, "c", [358_089.63, 4_373_128.82, 3048.0]);
    assert_near(&survey, "d", [358_389.86, 4_373_076.29, 3048.0]);
    let told: Vec<_> = survey.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        told,
        [
            "sub/deep er/two three.dat:10: the survey has no date, so that its declination is taken for 0",
            "cave.mak:10: the command \"?x\" is not known, and passed over",
        ]
    );
}

#[test]
fn anything_may_separate_the_coordinates_of_a_link_station() {
    for link in
        ["a [m1,2,3], b ;", "a[ M 1 2 3 ];", "b,a[m; 1;2\r\n3];", "a[f,3.28084 6.56168,9.84252]"]
    {
        let files = Memory::default()
            .with("cave.mak", format!("#one.dat,\r\n {link}"))
            .with("one.dat", dat("5.0", PLAIN, "a b 1000 0 0 1 2 3 4"));
        let survey = read(&files, "cave.mak").unwrap_or_else(|refusal| panic!("{link}: {refusal}"));
        assert_at(&survey, "b", [27.57, 305.64, 3.0]);
    }
}

#[test]
fn a_station_in_another_zone_is_converted_to_the_first() {
    // The point is that of zone 13's central meridian plus 6°, which is that of zone 14.
    let project =
        "$13;&WGS 1984;#one.dat,a[m,500000,4000000,0];\r\n$14;#two.dat,c[m,500000,4000000,0];";
    let files = Memory::default()
        .with("cave.mak", project)
        .with("one.dat", dat("0.0", PLAIN, "a b 1000 0 0 1 2 3 4"))
        .with("two.dat", dat("0.0", PLAIN, "c d 1000 0 0 1 2 3 4"));
    let survey = read(&files, "cave.mak").unwrap();
    let [east, north, _] = super::at(&survey, "c");
    assert!(
        (east - 1_040_000.0).abs() < 2000.0 && (north - 4_016_000.0).abs() < 2000.0,
        "{east} {north}"
    );
}

#[test]
fn what_cannot_be_used_is_refused_where_it_stands() {
    let refusals = [
        (dat("0.0", PLAIN, "a b 10 0 x 1 2 3 4"), "cave.dat:10:10: \"x\" is no number"),
        (dat("0.0", PLAIN, "a"), "cave.dat:10: the name of a station is missing"),
        (dat("0.0", PLAIN, "a b -999 0 0 1 2 3 4"), "cave.dat:10: the tape's reading is left out"),
        ("no survey".into(), "cave.dat: there is no survey in it"),
        (dat("x", PLAIN, "a b 1 0 0 1 2 3 4"), "cave.dat:6: \"x\" is no number in the head"),
        (
            dat("0.0", "DDDDUDLRLADN CORRECTIONS: 1 2,5 0", "a b 1 0 0 1 2 3 4"),
            "cave.dat:6: \"2,5\" is no number in the head",
        ),
    ];
    for (text, beginning) in refusals {
        let told = one(text).unwrap_err().to_string();
        assert!(told.starts_with(beginning), "{told}");
    }
    let files = Memory::default()
        .with("cave.mak", "#one.dat,\r\na[f,1,2];\r\n")
        .with("one.dat", dat("0.0", PLAIN, "a b 10 0 0 1 2 3 4"));
    let told = read(&files, "cave.mak").unwrap_err().to_string();
    assert!(
        told.starts_with("cave.mak:2: the coordinates of station \"a\" are no three numbers"),
        "{told}"
    );
}
