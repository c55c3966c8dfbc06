//! Compass's files. The positions are those that `cavern` 1.4.4 gives.

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
fn backsights_and_corrections_count() {
    let format = "DDDDUDLRLADBT  CORRECTIONS:  2.00 1.00 0.00";
    let survey =
        one(dat("10.0", format, "a b 10 90 0 1 2 3 4 272 -2\r\nb c 10 -999 5 1 1 1 1 100 -6"))
            .unwrap();
    assert_at(&survey, "b", [2.98, -0.63, 0.08]);
}

#[test]
fn a_shot_of_no_length_equates_and_an_excluded_one_is_left_out() {
    let lines = "a b 10 -999 90 1 2 3 4\r\nb d 0 0 0 1 1 1 1\r\nd e 5 90 0 1 1 1 1\r\ne f 1 0 0 1 1 1 1 #|X#";
    let survey = one(dat("0.0", PLAIN, lines)).unwrap();
    assert_at(&survey, "e", [1.52, 0.0, 3.05]);
    assert!(survey.station_named("f").is_none());
}

#[test]
fn a_project_gathers_its_files_and_fixes_its_links() {
    let files = Memory::default()
        .with("cave.mak", "/ words\r\n@100,200,3,13,-1.05;\r\n&North American 1983;\r\n#ONE.DAT,\r\n a[m,100,200,3],b;\r\n#two.dat;\r\n")
        .with("one.dat", dat("0.0", PLAIN, "a b 10 0 0 1 2 3 4"))
        .with("two.dat", dat("0.0", PLAIN, "b c 10 90 0 1 2 3 4"));
    let survey = read(&files, "cave.mak").unwrap();
    assert_at(&survey, "c", [103.05, 203.05, 3.0]);
}

#[test]
fn what_cannot_be_used_is_refused_where_it_stands() {
    let refusals = [
        (dat("0.0", PLAIN, "a b 10 0 x 1 2 3 4"), "cave.dat:10:10: \"x\" is no number"),
        (dat("0.0", PLAIN, "a"), "cave.dat:10: the name of a station is missing"),
        (dat("0.0", PLAIN, "a b -999 0 0 1 2 3 4"), "cave.dat:10: the tape's reading is left out"),
        ("no survey".into(), "cave.dat: there is no survey in it"),
    ];
    for (text, beginning) in refusals {
        let told = one(text).unwrap_err().to_string();
        assert!(told.starts_with(beginning), "{told}");
    }
    let files =
        Memory::default().with("cave.mak", "#one.dat,\r\na[f,1,2];\r\n").with("one.dat", "");
    let told = read(&files, "cave.mak").unwrap_err().to_string();
    assert!(
        told.starts_with("cave.mak:1: the coordinates of station \"a\" are no three numbers"),
        "{told}"
    );
}
