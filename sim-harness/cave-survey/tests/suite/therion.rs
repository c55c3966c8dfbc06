//! Therion's files. The positions are those that Therion 6.1.6 gives.

use cave_survey::{Memory, Refusal, Survey, read};

use super::{assert_at, at};

fn th(text: &str) -> Result<Survey, Refusal> {
    read(&Memory::default().with("cave.th", text), "cave.th")
}

/// A centreline around these lines, in survey `a`.
fn lines(text: &str) -> Result<Survey, Refusal> {
    th(&format!("survey a\ncentreline\n{text}\nendcentreline\nendsurvey\n"))
}

/// Stations with where they are, m.
type Places = &'static [(&'static str, [f64; 3])];

/// The lines of a centreline, and stations with where they are.
const PLACED: &[(&str, Places)] = &[
    (
        "data normal from to tape compass clino direction\n1 2 10 30 10 f # words\n2 3 10 40 20 b\n\
         data cylpolar from to tape compass depthchange\n3 4 10 90 -5\nunits clino percent\n\
         data normal from to tape compass clino\n4 5 10 0 100\n5 6 10 12:30 5\n6 7 0 0 0",
        &[
            ("a.2", [4.92, 8.53, 1.74]),
            ("a.3", [-1.12, 1.33, -1.68]),
            ("a.4", [8.88, 1.33, -6.68]),
            ("a.5", [8.88, 8.40, 0.39]),
            ("a.7", [11.05, 18.15, 0.89]),
        ],
    ),
    (
        "units compass clino grads\ncalibrate length 0.5 2\ncalibrate compass 10\n\
         declination 5 degrees\ndata normal from to compass clino tape up down left right\n\
         1 2 100 50 5 1 2 3 [4 5]\n2 3 390 -10 10 - - 1 1",
        &[("a.2", [6.35, 0.44, 6.36]), ("a.3", [2.13, 18.73, 3.39])],
    ),
    (
        "data normal station newline length bearing gradient\n1\n 5 0 0\n\n2\n 3 90 10\n3\nbreak\n2\n\
         4 180 up\n4\nflags surface\ndata diving from to length compass fromdepth todepth\n\
         4 6 5 90 -1 -4",
        &[("a.3", [2.95, 5.0, 0.52]), ("a.4", [0.0, 5.0, 4.0]), ("a.6", [4.0, 5.0, 1.0])],
    ),
    (
        "fix 1 10 20 30\nstation-names p s\nfix 1 10 20 30\ndata normal from to tape compass clino\n\
         equate p1s 1\n1 2 10 0 0\ngroup\nunits tape feet\n2 3 10 0 0\nendgroup\n3 4 10 0 0",
        &[
            ("a.p2s", [10.0, 30.0, 30.0]),
            ("a.p3s", [10.0, 33.05, 30.0]),
            ("a.p4s", [10.0, 43.05, 30.0]),
        ],
    ),
    (
        "units position feet\nfix 1 100 200 300\nunits tape 2 metres\n\
         data topofil from to fromcount tocount compass clino\n1 2 100 110 90 0\n\
         data cartesian from to easting northing altitude\n2 3 1 2 3",
        &[("a.2", [40.48, 60.96, 91.44]), ("a.3", [41.48, 62.96, 94.44])],
    ),
    (
        "data normal from to length backlength compass backcompass clino backclino\n\
         1 2 10 10.2 10 192 5 -7\n2 3 10 - - 190 - -5",
        &[("a.2", [1.92, 9.86, 1.06]), ("a.3", [3.65, 19.67, 1.93])],
    ),
    (
        "infer equates on\ndata normal from to compass clino tape\n1 2 0 0 0\n2 3 90 0 10 \\\n\n",
        &[("a.3", [10.0, 0.0, 0.0])],
    ),
    (
        "1 2 10 20 30\n2 3 5 40 10 # words",
        &[("a.2", [2.96, 8.14, 5.0]), ("a.3", [6.13, 11.91, 5.87])],
    ),
    ("data normal from to length compass clino\n1 2 1e1 -90 300\n", &[("a.2", [-5.0, 0.0, -8.66])]),
];

#[test]
fn stations_are_where_therion_puts_them() {
    for (text, stations) in PLACED {
        let survey = lines(text).unwrap_or_else(|refusal| panic!("{text}: {refusal}"));
        println!("{text}");
        for &(name, expected) in *stations {
            assert_at(&survey, name, expected);
        }
    }
}

#[test]
fn surveys_are_levels_of_names_and_references_lead_into_them() {
    let files = Memory::default()
        .with(
            "cave.th",
            "encoding utf-8\nsurvey a -title \"A \"\"cave\"\"\" -entrance 1@d\n\
             input sub/b\ninput sub/drawing.th2\nsurvey d\ncenterline\n\
             data normal from to tape compass clino\n1 2 10 0 0\n1.5 2 1 90 0\nendcenterline\n\
             endsurvey d\nequate 2@inner.b 1@d # joined\nendsurvey a\n",
        )
        .with("sub/b.th", "survey b\ninput \"c c.TH\"\nendsurvey b\n")
        .with(
            "sub/c c.th",
            "survey inner\ncentreline\ndata normal from to tape compass clino\n1 2 5 0 0\n\
             endcentreline\nendsurvey",
        );
    let survey = read(&files, "cave.th").unwrap();
    assert_at(&survey, "a.d.2", [0.0, 15.0, 0.0]);
    assert_at(&survey, "a.d.1.5", [-1.0, 15.0, 0.0]);
    assert_at(&survey, "a.b.inner.2", [0.0, 5.0, 0.0]);
    assert_eq!(survey.title.as_deref(), Some("A \"cave\""));
    let entrances = survey.stations.iter().filter(|it| it.is_entrance).map(|it| &*it.name);
    assert_eq!(entrances.collect::<Vec<_>>(), ["a.d.1"]);
}

#[test]
fn a_station_is_found_by_the_name_that_therion_gives_it() {
    let survey = th("survey a\nsurvey b\ncentreline\ndata normal from to tape compass clino\n\
                     1 2 5 0 0\nendcentreline\nendsurvey\nendsurvey\n");
    let survey = survey.unwrap();
    let found = survey.station_named("2@b.a").unwrap();
    assert_eq!(survey.stations[found].name, "a.b.2");
    assert!(survey.station_named("2@a.b").is_none());
}

#[test]
fn splays_and_flags_mark_legs_and_stations() {
    let survey = lines(
        "data normal from to tape compass clino\n1 2 10 0 0\n2 - 1 90 0\n. 2 2 90 0\n\
         flags splay\n2 w 3 90 0\nflags not splay duplicate\n2 3 10 0 0\nflags not duplicate surface\n\
         3 4 10 0 0\nflags not surface\n3 5 10 180 0\nstation 4 \"words\" continuation not entrance\n\
         station 5 \"\" air-draught entrance\nmark 1 fixed\nextend left 3\nwalls off",
    );
    let survey = survey.unwrap();
    let summary = survey.summary();
    assert_eq!((summary.legs, summary.splays, summary.stations), (2, 3, 8));
    assert!((summary.length_m - 20.0).abs() < 1e-9);
    assert_eq!(survey.stations.iter().filter(|it| it.is_wall).count(), 1, "that of -");
    assert_eq!(survey.legs.iter().filter(|leg| leg.flags.surface).count(), 1);
    let entrances = survey.stations.iter().filter(|it| it.is_entrance).map(|it| &*it.name);
    assert_eq!(entrances.collect::<Vec<_>>(), ["a.5"]);
}

#[test]
fn a_dimension_alone_is_that_of_the_second_station_and_two_are_of_both() {
    let survey = lines(
        "data normal from to compass clino tape up down left right\n1 2 0 0 5 1 2 3 [4 5]\n\
         2 3 0 0 5 - - 1 .\ndata dimensions station left right up down\n1 1 2 3 4\n3 - - - 9",
    );
    let survey = survey.unwrap();
    let shown: Vec<Vec<_>> = survey
        .passages
        .iter()
        .map(|passage| {
            let name = |it: &cave_survey::CrossSection| survey.stations[it.station].name.clone();
            passage.iter().map(|it| (name(it), it.left, it.right, it.up, it.down)).collect()
        })
        .collect();
    let some = |x: f64| Some(x);
    assert_eq!(
        shown,
        [
            vec![
                ("a.1".into(), None, some(4.0), None, None),
                ("a.2".into(), some(3.0), some(5.0), some(1.0), some(2.0)),
                ("a.3".into(), some(1.0), None, None, None),
            ],
            vec![
                ("a.1".into(), some(1.0), some(2.0), some(3.0), some(4.0)),
                ("a.3".into(), None, None, None, some(9.0)),
            ],
        ]
    );
}

/// The magnetic field of Therion 6.1.6 is of another edition.
fn assert_near(survey: &Survey, name: &str, expected: [f64; 3]) {
    let found = at(survey, name);
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 0.06, "{name} is at {found:?}");
}

#[test]
fn stations_on_the_earth_give_the_declination_of_the_day() {
    let given = "centreline\ndeclination 3 degrees\ndata normal from to tape compass clino\n\
                 2 4 1000 0 5\nendcentreline\n";
    for fix in [
        "cs long-lat\nfix 1 15 49 400",
        "cs lat-long\nfix 1 49:0:0 15.0 400",
        "cs UTM33\nfix 1 500000 5427455.78 400",
    ] {
        let survey = th(&format!(
            "survey a -namespace off\ncentreline\n{fix}\ndate 2010.01.01@10:00\n\
             data normal from to tape compass clino\n1 2 1000 0 0\nendcentreline\n{given}endsurvey"
        ));
        let survey = survey.unwrap();
        assert_near(&survey, "1", [500_000.0, 5_427_455.78, 400.0]);
        assert_near(&survey, "2", [500_051.70, 5_428_454.44, 400.0]);
        assert_near(&survey, "4", [500_103.84, 5_429_449.27, 487.16]);
    }
}

#[test]
fn a_survey_gives_its_declination_by_the_day() {
    let survey = |date: &str| {
        let text = format!(
            "survey a -declination [2000.01.01 4 2010.01.01 14 degrees]\nsurvey b\ncentreline\n{date}\n\
             data normal from to tape compass clino\n1 2 10 0 0\nendcentreline\nendsurvey\nendsurvey"
        );
        at(&th(&text).unwrap(), "a.b.2")
    };
    for (date, degrees) in [
        ("date 2005.01.01", 9.0f64),
        ("date 1990", 4.0),
        ("date 2020.01.01 - 2020.02.01", 14.0),
        ("", 9.0),
        ("declination 20 degrees", 20.0),
    ] {
        let [east, north, _] = survey(date);
        assert!((east.atan2(north).to_degrees() - degrees).abs() < 0.01, "{date}: {east} {north}");
    }
}

#[test]
fn a_configuration_reads_its_sources_and_passes_over_the_rest() {
    let files = Memory::default()
        .with(
            "thconfig",
            "encoding utf-8\nsource one.th\nsource\ncentreline\ndata normal from to tape compass clino\n\
             2 3 5 0 0\nendcentreline\nendsource\ncs UTM33\ntext en \"a\" \"b\"\nlayout x\n  scale 1 100\nendlayout\n\
             select m\nexport map -o x.pdf\n",
        )
        .with("one.th", "centreline\ndata normal from to tape compass clino\n1 2 5 0 0\nendcentreline\nscrap s\nline wall\n1 2\nendline\nendscrap\n");
    assert_at(&read(&files, "thconfig").unwrap(), "3", [0.0, 10.0, 0.0]);
}

/// A file, and the beginning of what is said of it.
const REFUSED: &[(&str, &str)] = &[
    ("", "cave.th: there are no legs"),
    ("survey\n", "cave.th:1: a survey has no name"),
    ("survey a\n", "cave.th:1: this survey has no end; add endsurvey"),
    ("survey a\nendsurvey b\n", "cave.th:2: this endsurvey names \"b\", and survey \"a\" is open"),
    ("endsurvey\n", "cave.th:1: this endsurvey has no survey around it; remove it"),
    ("survey a\nsurvey b\nendsurvey\nsurvey b\n", "cave.th:4: there are two surveys \"b\""),
    ("centreline\nendsurvey\n", "cave.th:2: \"endsurvey\" is no command of a centreline"),
    ("centreline\n1 2 3 4\n", "cave.th:2: \"1\" is no command of a centreline, and no data"),
    ("centreline\nteem \"A B\" c d e\n", "cave.th:2: \"teem\" is no command of a centreline"),
    ("frobnicate\n", "cave.th:1: there is no command \"frobnicate\" outside a centreline"),
    ("layout x\n", "cave.th:1: this block has no endlayout"),
    ("input lost\n", "cave.th:1: there is no file \"lost\""),
    ("input cave\n", "cave.th:1: \"cave\" includes itself"),
    ("input ../x\n", "cave.th:1: \"../x\" lies outside the folder"),
    ("equate 1\n", "cave.th:1: equate names only one station"),
    ("equate 1@b 2\n", "cave.th:1: there is no survey \"b\""),
    ("equate a!b 2\n", "cave.th:1: '!' is not allowed in the name \"a!b\""),
    ("survey a -declination 5\n", "cave.th:1: \"5\" is no declination"),
];

/// The lines of a centreline, and the beginning of what is said of them.
const REFUSED_LINES: &[(&str, &str)] = &[
    ("data odd from to", "cave.th:3: there is no style of data \"odd\""),
    ("data normal from to tape compass frob", "cave.th:3: there is no reading \"frob\""),
    ("data normal from to tape tape", "cave.th:3: the reading \"tape\" is there twice"),
    ("data normal from to tape compass", "cave.th:3: the order of readings lacks the gradient"),
    ("data normal station tape compass clino", "cave.th:3: the order of readings lacks newline"),
    ("units tape degrees", "cave.th:3: the quantity is not measured in \"degrees\""),
    ("units frob 2 metres", "cave.th:3: \"frob\" is no quantity"),
    ("units tape five metres", "cave.th:3: the factor of a unit is no number"),
    ("calibrate tape x", "cave.th:3: calibrate has no zero error"),
    ("sd tape 0 metres", "cave.th:3: a standard deviation is not positive"),
    ("declination 5", "cave.th:3: the declination has no unit"),
    ("flags odd", "cave.th:3: there is no flag \"odd\""),
    ("date June", "cave.th:3: \"June\" is no date"),
    ("cs nowhere", "cave.th:3: there is no coordinate system \"nowhere\""),
    ("fix 1 2 3", "cave.th:3: fix has no three coordinates"),
    ("fix 1 2 3 x", "cave.th:3: \"x\" is no number"),
    ("fix - 1 2 3", "cave.th:3: \"-\" is no name of a station"),
    ("fix 1 1 2 3\ncs UTM33\nfix 2 4e5 5e6 3", "cave.th:5: some stations are fixed with a cs"),
    ("endgroup", "cave.th:3: this endgroup has no group around it; end the centreline before it"),
];

/// A line of data from station to station, and the beginning of what is said of it.
const REFUSED_DATA: &[(&str, &str)] = &[
    ("1 2 10 0", "cave.th:4: the line has fewer readings than the 5 of data"),
    ("1 2 10 0 0 words", "cave.th:4: \"words\" is more than the 5 readings of data"),
    ("1 2 x 0 0", "cave.th:4: \"x\" is no number"),
    ("1 2 10,5 0 0", "cave.th:4: \"10,5\" is no number"),
    ("1 1 10 0 0", "cave.th:4: the leg begins and ends at the same station \"a.1\""),
    ("- . 10 0 0", "cave.th:4: the leg is between two points without names"),
    ("1 2 - 0 0", "cave.th:4: the tape's reading is left out"),
    ("1 2 10 - 10", "cave.th:4: a leg that is not plumbed has no compass reading"),
];

#[test]
fn what_cannot_be_used_is_refused_where_it_stands() {
    let data = |text: &str| format!("data normal from to tape compass clino\n{text}");
    let files = REFUSED.iter().map(|(text, told)| (th(text), *text, *told));
    let in_lines = REFUSED_LINES.iter().map(|(text, told)| (lines(text), *text, *told));
    let in_data = REFUSED_DATA.iter().map(|(text, told)| (lines(&data(text)), *text, *told));
    for (survey, text, beginning) in files.chain(in_lines).chain(in_data) {
        let told = survey.err().unwrap_or_else(|| panic!("{text:?} is read")).to_string();
        assert!(told.starts_with(beginning), "{text:?}:\n{told}, not\n{beginning}");
        assert_eq!(told.lines().count(), 1, "{told}");
    }
}

#[test]
fn what_is_doubtful_is_read_with_a_remark_that_names_the_line() {
    let shot = "data normal from to tape compass clino\n1 2 10 0 0";
    for (text, beginning) in [
        (format!("{shot}\n2 3 -1 0 0"), "cave.th:5: the tape's reading is negative"),
        (
            format!("{shot}\n2 3 1 800 0"),
            "cave.th:5: the compass reading is not of one full circle",
        ),
        (format!("{shot}\n2 3 1 0 95"), "cave.th:5: the clino reading is over a right angle"),
        (format!("units lenght metres\n{shot}"), "cave.th:3: \"lenght\" is no quantity"),
        (format!("date 1992 08 16\n{shot}"), "cave.th:3: \"08\" behind the date is passed over"),
        (format!("{shot}\nequate 1 1"), "cave.th:5: a station is equated to itself"),
        (format!("{shot}\n3 4 1 0 0"), "cave.th:5: no leg joins station \"a.3\" and 1 other"),
        (format!("cs UTM33\nfix 1 4e5 5e6 3\n{shot}"), "cave.th:6: the survey has no date"),
    ] {
        let survey = lines(&text).unwrap_or_else(|refusal| panic!("{text:?}: {refusal}"));
        let told = survey.warnings.first().map(ToString::to_string).unwrap_or_default();
        assert!(told.starts_with(beginning), "{text:?}:\n{told}, not\n{beginning}");
    }
    let survey = th(
        "import x.3d -surveys use\nrevise a -title x\ncentreline\ndata normal from to tape compass clino\n1 2 1 0 0\nendcentreline\n",
    );
    let told: Vec<_> = survey.unwrap().warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        told,
        [
            "cave.th:1: import of \"x.3d\" is passed over: give that file itself",
            "cave.th:2: revise is passed over",
        ]
    );
}
