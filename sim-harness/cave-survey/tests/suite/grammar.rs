//! What lines and commands mean. The positions are those that `cavern` 1.4.22 gives.

use super::{assert_at, svx};

/// A file, and where it puts stations.
type Case = (&'static str, &'static [(&'static str, [f64; 3])]);

const CASES: &[Case] = &[
    ("1 2 10 90 0", &[("2", [10.0, 0.0, 0.0])]),
    ("2 1 10 90 0", &[("1", [10.0, 0.0, 0.0])]),
    (
        "1 2 10 - DOWN\n2 3 10 - +V\n3 4 5 90 LEVEL\n4 5 3 0 -",
        &[("2", [0.0, 0.0, -10.0]), ("5", [5.0, 3.0, 0.0])],
    ),
    ("*units tape feet\n1 2 10 10 5", &[("2", [0.53, 2.99, 0.27])]),
    (
        "*units compass quadrants\n1 2 10 S34E 0\n2 3 10 N 0",
        &[("2", [5.59, -8.29, 0.0]), ("3", [5.59, 1.71, 0.0])],
    ),
    ("*units clino percent\n1 2 10 0 100", &[("2", [0.0, 7.07, 7.07])]),
    ("*units compass clino grads\n1 2 10 100 50", &[("2", [7.07, 0.0, 7.07])]),
    ("*calibrate tape 1 feet\n1 2 10 10 5", &[("2", [1.68, 9.51, 0.84])]),
    ("*calibrate tape 0.5 1.1\n1 2 10 100 5", &[("2", [10.25, -1.81, 0.91])]),
    (
        "*declination 5 degrees\n1 2 10 0 0\n*calibrate declination 5\n2 3 10 0 0",
        &[("2", [0.87, 9.96, 0.0]), ("3", [0.0, 19.92, 0.0])],
    ),
    (
        "*data normal from to tape compass clino backcompass backclino\n1 2 10 10 5 192 -7\n2 3 10 - - 190 -5",
        &[("2", [1.90, 9.76, 1.05]), ("3", [3.63, 19.57, 1.92])],
    ),
    (
        "*data normal from to backtape backcompass backclino\n1 2 10 100 5",
        &[("2", [-9.81, 1.73, -0.87])],
    ),
    (
        "*data normal station newline tape compass clino\n1\n10 0 0\n2\n5 90 0\n3\n\n2\n4 180 0\n4",
        &[("1", [0.0, -10.0, 0.0]), ("3", [5.0, 0.0, 0.0]), ("4", [0.0, -4.0, 0.0])],
    ),
    (
        "*data normal station newline direction tape compass clino\n1\nF 10 0 0\n2\nB 5 90 0\n3",
        &[("1", [0.0, -10.0, 0.0]), ("3", [-5.0, 0.0, 0.0])],
    ),
    (
        "*data normal from to fromcount tocount compass clino\n1 2 0 100 0 0",
        &[("2", [0.0, 100.0, 0.0])],
    ),
    (
        "*data diving from to tape compass fromdepth todepth\n1 2 14.7 250 -20.7 -22.4",
        &[("2", [-13.72, -4.99, -1.70])],
    ),
    ("*data cartesian from to northing easting altitude\n1 2 1 2 3", &[("2", [2.0, 1.0, 3.0])]),
    ("*data cylpolar from to tape compass depthchange\n1 2 10 90 -5", &[("2", [10.0, 0.0, -5.0])]),
    (
        "*BEGIN A\n1 B 3 0 0\n*END a\n*equate a.b c\nc d 1 0 0",
        &[("a.b", [0.0, 3.0, 0.0]), ("d", [0.0, 4.0, 0.0])],
    ),
    ("*begin a\n*case preserve\n1 B 3 0 0\n*end a", &[("a.B", [0.0, 3.0, 0.0])]),
    (
        "*set separator /\n*begin a\n1 2 3 0 0\n*end a\n*equate a/2 z\nz y 1 0 0",
        &[("y", [0.0, 4.0, 0.0])],
    ),
    ("*set blank x09x20\n*set decimal ,\n1 2 3,5 0 0", &[("2", [0.0, 3.5, 0.0])]),
    ("*set names _-/\na/b 2 10 0 0", &[("2", [0.0, 10.0, 0.0])]),
    ("*truncate 3\nabcdef 2 3 0 0\nabcxyz 3 4 0 0", &[("3", [0.0, 4.0, 0.0])]),
    ("*infer plumbs on\n1 2 10 - -90", &[("2", [0.0, 0.0, -10.0])]),
    ("*infer equates on\n1 2 0 - -\n2 3 1 0 0", &[("2", [0.0, 0.0, 0.0]), ("3", [0.0, 1.0, 0.0])]),
    ("*fix 1 100 200 300\n1 2 10 0 0", &[("2", [100.0, 210.0, 300.0])]),
    ("*fix 1 0 0 0\n*fix 3 0 21 0 1 1 1\n1 2 10 0 0\n2 3 10 0 0", &[("3", [0.0, 20.01, 0.0])]),
    (
        "*cs OSGB:SD\n*cs out EPSG:27700\n*fix 1 97480 72608 225\n1 2 1 0 0",
        &[("1", [397480.0, 472608.0, 225.0])],
    ),
    (
        "*cs LONG-LAT\n*cs out UTM34N\n*fix 1 19.894862 49.245410 1000\n1 2 1 0 0",
        &[("1", [419566.03, 5455325.08, 1000.0])],
    ),
    (
        "*cs UTM30N\n*cs out UTM30N\n*date 1988.04.02\n*fix 1 700000 6000000 100\n*declination auto 700000 6000000 100\n1 2 100 0 0",
        &[("2", [699986.53, 6000099.09, 100.0])],
    ),
    (
        "*units clino 100 percent\n1 2 10 0 -2.4\n*units clino 50 percent\n2 3 10 90 1",
        &[("2", [0.0, 3.85, -9.23]), ("3", [8.94, 3.85, -4.76])],
    ),
    (
        "*units backclino 10 percent\n*data normal from to tape compass backclino\n1 2 10 0 5",
        &[("2", [0.0, 8.94, -4.47])],
    ),
    (
        "*data cartesian from to dx dy dz\n*declination 90 degrees\n*cartesian true\n0 t 10 0 0\n*cartesian magnetic\n0 m 0 10 0\n*cartesian grid 100 grads\n0 g 0 -10 0\n*cartesian magnetic 30 degrees\n0 n 10 0 1",
        &[
            ("t", [10.0, 0.0, 0.0]),
            ("m", [10.0, 0.0, 0.0]),
            ("g", [-10.0, 0.0, 0.0]),
            ("n", [-5.0, -8.66, 1.0]),
        ],
    ),
    (
        "*cs UTM33N\n*cs out UTM32N\n*date 2010.1.1\n*declination auto 400000 5400000 500\n*fix a 400000 5400000 500\n*data cartesian from to dx dy dz\na t 0 100 0\n*cartesian grid\na g 0 100 0",
        &[("t", [841_035.44, 5_409_598.97, 500.0]), ("g", [841_033.66, 5_409_598.84, 500.0])],
    ),
    (
        "*data normal note station newline tape compass clino\n\"a bolt\" 5\n 1 180 0\nLHW 6\n 2 90 0\n- 7",
        &[("5", [0.0, 1.0, 0.0]), ("7", [2.0, 0.0, 0.0])],
    ),
    (
        "*data normal station noteall newline tape compass clino ignoreall\n5 a bolt\n 1 180 0 x\n6 ; y\n 2 90 0\n7",
        &[("5", [0.0, 1.0, 0.0]), ("7", [2.0, 0.0, 0.0])],
    ),
    (
        "*data nosurvey station noteall\n1 x y\n3 z\n*data normal - from to tape compass clino\n3 2 10 0 0\n2 1 1 0 0",
        &[("1", [0.0, 11.0, 0.0])],
    ),
    (
        "*set separator /\n*set names _-.\n*begin pull4\n1 2 1 0 0\n2 2.1 1 90 0\n*end pull4\n*equate pull4/2.1 x.y\nx.y z 1 0 0",
        &[("pull4/2", [0.0, 1.0, 0.0]), ("pull4/2.1", [1.0, 1.0, 0.0]), ("z", [1.0, 2.0, 0.0])],
    ),
    ("*set names .\n1.a 2 1 0 0", &[("1.a", [0.0, 0.0, 0.0]), ("2", [0.0, 1.0, 0.0])]),
    (
        "*begin\n*set eol ^^;words until the caret\n*fix no 9 9 9\n^*set eol x0a\n*end\n1 2 1 0 0",
        &[("2", [0.0, 1.0, 0.0])],
    ),
    ("*prefix \\\n*begin \\\n1 2 3 0 0\n*end \\\n2 3 1 0 0", &[("3", [0.0, 4.0, 0.0])]),
    (
        "*cs UTM33N\n*declination auto 400000 5400000 500\n*cs out UTM32N\n*date 2010.1.1\n*fix a 400000 5400000 500\na b 100 0 0",
        &[("b", [841_040.01, 5_409_599.14, 500.0])],
    ),
    (
        "*cs JTSK\n*cs out UTM33N\n*fix b 600000 1050000 400\n*cs iJTSK\n*fix a -600000 -1050000 400\na b 1 0 0",
        &[("a", [601_074.77, 5_559_964.61, 400.0]), ("b", [601_074.77, 5_559_964.61, 400.0])],
    ),
    (
        "*cs out custom \"+proj=tmerc +lon_0=13d20 +y_0=-5200000 +ellps=bessel +towgs84=577.326,90.129,463.919,5.137,1.474,5.297,2.4232\"\n*cs custom \"+proj=tmerc +lon_0=13d20 +y_0=-5200000 +ellps=bessel +towgs84=577.326,90.129,463.919,5.137,1.474,5.297,2.4232 +vunits=us-ft\"\n*fix a 36000 83000 5236.21\na b 1 0 0",
        &[("b", [36_000.0, 83_001.0, 1596.0])],
    ),
    // The same leg, measured again at once, counts by the mean; so it does if a *begin is between.
    ("1 2 10 0 0\n*begin\n1 2 11 0 0\n*end", &[("2", [0.0, 10.5, 0.0])]),
    ("1 2 10 0 0 ; a comment\r\n2 3 10 0 0\r\n", &[("3", [0.0, 20.0, 0.0])]),
    ("\u{feff}1 2 10 0 0", &[("2", [0.0, 10.0, 0.0])]),
];

#[test]
fn lines_and_commands_put_stations_where_cavern_does() {
    for (text, stations) in CASES {
        let survey = svx(text).unwrap_or_else(|refusal| panic!("{text:?}: {refusal}"));
        println!("{text:?}");
        for &(name, expected) in *stations {
            assert_at(&survey, name, expected);
        }
    }
}

#[test]
fn a_splay_is_no_leg_and_an_anonymous_station_has_no_name() {
    let survey =
        svx("*alias station - ..\n1 2 10 0 0\n2 - 3 90 0\n2 . 4 270 0\n2 ... 5 0 0\n").unwrap();
    let summary = survey.summary();
    assert_eq!((summary.legs, summary.splays, summary.stations), (2, 2, 5));
    assert!((summary.length_m - 15.0).abs() < 1e-9);
    let walls: Vec<_> = survey.stations.iter().filter(|station| station.is_wall).collect();
    assert!(walls.len() == 1 && walls[0].name.is_empty());
}

#[test]
fn flags_keep_legs_out_of_the_length_until_their_block_ends() {
    let text = "1 2 10 0 0\n*begin\n*flags duplicate surface\n2 3 5 0 0\n*flags not duplicate\n3 4 5 0 0\n*end\n4 5 1 0 0\n";
    let summary = svx(text).unwrap().summary();
    assert_eq!((summary.legs, summary.stations), (2, 5));
    assert!((summary.length_m - 11.0).abs() < 1e-9);
}

#[test]
fn each_block_of_passage_data_is_one_tube() {
    let text = "1 2 10 0 0\n2 3 10 0 0\n*data passage station left right up down\n1 1 2 3 -\n2 1 0 -1 4\n*data\n3 - - - -\n2 5 5 5 5\n";
    let survey = svx(text).unwrap();
    assert_eq!(survey.passages.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2]);
    let second = survey.passages[0][1];
    assert_eq!(
        (second.left, second.right, second.up, second.down),
        (Some(1.0), Some(0.0), None, Some(4.0))
    );
    assert_eq!(survey.summary().with_dimensions, 3);
}

#[test]
fn surveys_of_compass_and_walls_are_included_into_the_present_survey() {
    let compass = "Cave\r\nSURVEY NAME: A\r\nSURVEY DATE: 6 29 1987\r\nSURVEY TEAM:\r\nme\r\n\
                   DECLINATION: 0 FORMAT: DDDDUDLRLADN\r\n\r\nFROM TO LEN\r\n\r\n\
                   a b.1 32.81 0 0 1 1 1 1\r\nb.1 c 3.281 0 90 1 1 1 1 #|S#\r\n";
    let files = cave_survey::Memory::default()
        .with("main.svx", "*begin x\n*include one.dat\nc 2 5 90 0\n*end x\n")
        .with("walls.svx", "*begin x\n*case preserve\n*include two\n*include two.srv\n*equate q.B 1\n1 2 5 90 0\n*end x\n")
        .with("project.svx", "*include three.mak\n*equate a one.5\none.5 2 1 0 0\n")
        .with("one.dat", compass)
        .with("two.svx", "5 1 1 0 0\n")
        .with("two.srv", "#prefix q\r\nA B 10 0 0\r\n")
        .with("three.mak", "#one.dat,a[m,1,2,3];\r\n")
        .with("bad.svx", "*include x.th\n")
        .with("x.th", "");
    let survey = cave_survey::read(&files, "main.svx").unwrap();
    assert_at(&survey, "x.b.1", [0.0, 10.0, 0.0]);
    assert_at(&survey, "x.2", [5.0, 10.0, 1.0]);
    assert_eq!((survey.summary().splays, survey.summary().with_dimensions), (1, 2));
    let survey = cave_survey::read(&files, "walls.svx").unwrap();
    assert_at(&survey, "x:2", [5.0, 1.0, 0.0]);
    assert_at(&survey, "x:q:A", [0.0, -9.0, 0.0]);
    let survey = cave_survey::read(&files, "project.svx").unwrap();
    assert_at(&survey, "2", [1.0, 3.0, 3.0]);
    let told = cave_survey::read(&files, "bad.svx").unwrap_err().to_string();
    assert!(told.starts_with("bad.svx:1:10: *include takes surveys of Survex, Compass"), "{told}");
}

#[test]
fn dimensions_may_be_left_out_of_a_style() {
    let text = "1 2 10 0 0\n*data passage station left noteall\n1 2 words\n2 - words\n\
                *data passage station note\n1 \"a note\"\n";
    let survey = svx(text).unwrap();
    let [first, second] = survey.passages[0][..] else { panic!("{:?}", survey.passages) };
    assert!(first.left == Some(2.0) && first.right.is_none() && !second.is_measured());
    assert_eq!(survey.summary().with_dimensions, 1);
}

#[test]
fn what_is_not_measured_has_no_length() {
    let survey = svx("*fix 1 0 0 0\n*fix 2 5 0 0\n*data nosurvey from to\n1 2\n").unwrap();
    let summary = survey.summary();
    assert!(summary.length_m.is_sign_positive() && summary.length_m == 0.0, "0, and not -0");
}

#[test]
fn a_file_is_found_in_whatever_case_and_with_either_slash() {
    let files = cave_survey::Memory::default()
        .with("main.svx", "*include Sub\\ONE\n*include \"sub/two words\"\n*equate one.2 1\n")
        .with("sub/one.svx", "*begin one\n1 2 5 0 0\n*end one\n")
        .with("sub/Two Words.SVX", "1 2 7 0 0\n");
    let survey = cave_survey::read(&files, "main.svx").unwrap();
    assert_eq!(survey.summary().legs, 2);
    assert_at(&survey, "2", [0.0, 12.0, 0.0]);
}
