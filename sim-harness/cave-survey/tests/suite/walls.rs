//! Walls's files. The positions are those that `cavern` 1.4.24 gives.

use cave_survey::{Memory, Refusal, Survey, read};

use super::assert_at;

fn srv(text: &str) -> Result<Survey, Refusal> {
    read(&Memory::default().with("cave.srv", text), "cave.srv")
}

/// A place in zone 33, 2.3° of grid convergence to the west of its meridian.
const REF: &str = ".REF 5068100.876 249623.224 33 -2.3 553 0 45 43 1 11 47 0 27 \"WGS 1984\"\r\n";

/// Stations with where they are, m.
type Places = &'static [(&'static str, [f64; 3])];

/// A file, and stations with where they are.
const PLACED: &[(&str, Places)] = &[
    ("A B 10 0 0\r\nB C 5 N45E -- ; words\r\nC D 5 35:30 0\r\n", &[("D", [6.44, 17.61, 0.0])]),
    ("A B 4 -- 90\nB C 10 10/190 5/-5\nC D 5 10/191 --/-5\n", &[("D", [2.64, 14.71, 5.31])]),
    (
        "#Units feet\nA B 10f 0 0\nB C 10m 0 0\nC D 5i6 0 0\nD E 100 10g 10g\nE F 10 0/180 50p\n",
        &[("D", [0.0, 14.72, 0.0]), ("F", [4.71, 47.18, 6.13])],
    ),
    (
        "#units typeab=c typevb=c\nA B 10 10/12 5/7\nB C 10 /14 /3\n#units typeab=n,10 typevb=n\n\
         C D 10 10/195 --/-5\nD E 10 S10W/N14E --\n",
        &[("B", [1.9, 9.76, 1.05]), ("C", [4.31, 19.45, 1.57]), ("E", [4.39, 19.4, 2.44])],
    ),
    (
        "A B 10 0 0 2 1\n#units incd=1 incv=2 inca=3 inch=.5\nB C 10 0 0\n#units decl=10\nC D 10 0 0\n",
        &[("B", [0.0, 10.0, 1.0]), ("C", [0.58, 20.98, 1.88]), ("D", [3.05, 31.69, 2.77])],
    ),
    ("#units feet incd=1 a=g inca=10\nA B 10 0 0\n", &[("B", [0.52, 3.31, 0.0])]),
    (
        "#units rect order=enu\nA B 1 2 3\n#units rect=10 decl=20\nB C 0 10 0\n#units ct order=avd\nC D 0 0 10\n",
        &[("B", [1.0, 2.0, 3.0]), ("C", [2.74, 11.85, 3.0]), ("D", [6.16, 21.25, 3.0])],
    ),
    (
        "#units order=da tape=ss\nA B 10 0 1 3\nB C 10 90\nC D 10 90 5\nD E 10 90 -- 5\n\
         #units tape=it\nE F 10 0 1 3\n",
        &[("B", [0.0, 9.8, -2.0]), ("D", [18.66, 9.8, 3.0]), ("F", [27.32, 19.8, -4.0])],
    ),
    (
        "#units d=feet order=nue\n#fix A 10 5m 20f\n#units order=enu s=m rect\nA B 1 1 1\n",
        &[("A", [6.1, 3.05, 5.0]), ("B", [7.1, 4.05, 6.0])],
    ),
    (
        "#prefix a\n#prefix2 b\n1 2 10 0 0\n:2 3 10 0 0\nx:3 4 1 0 0\n2 :2 5 0 0\n:2 ::2 5 0 0\n3 x:3 5 0 0\n",
        &[("b:a:4", [0.0, 31.0, 0.0]), ("b: :2", [0.0, 15.0, 0.0]), ("2", [0.0, 20.0, 0.0])],
    ),
    (
        "#units $foo=\"feet decl\" save\n#units $(foo)=10\nA B 10 0 0\n#units restore\nB C 10 0 0\n",
        &[("B", [0.53, 3.0, 0.0]), ("C", [0.53, 13.0, 0.0])],
    ),
    ("A B 10 0 0\n#[ words\nx\n#[\n#]\ny\n#]\nB C 0 0 0\nC D 1 90 0\n", &[("D", [1.0, 10.0, 0.0])]),
    ("#fix A 0 0 0\n#fix B 0 11 0 (R0.2)\nA B 10 0 0\n", &[("B", [0.0, 10.48, 0.0])]),
];

#[test]
fn stations_are_where_cavern_puts_them() {
    for (text, stations) in PLACED {
        let survey = srv(text).unwrap_or_else(|refusal| panic!("{text}: {refusal}"));
        for (name, at) in *stations {
            assert_at(&survey, name, *at);
        }
    }
}

#[test]
fn the_case_of_names_is_as_the_options_say() {
    let survey = srv("#units case=upper\na b 10 0 0\n#units case=mixed\nB b 1 0 0\n").unwrap();
    assert_eq!(survey.stations.iter().map(|it| &*it.name).collect::<Vec<_>>(), ["A", "B", "b"]);
}

#[test]
fn splays_segments_and_flags_mark_legs_and_stations() {
    let survey = srv(
        "A B 10 0 0\nB - 3 90 0\n-- B 2 90 0\n#Segment /P\nB C 10 0 0\n#seg /deep/part\n\
         C D 10 0 0 #s /L\nD E 10 0 0\n#Flag A E /Lower Entrance\n#note E words\n#flag Q /entrance\n",
    );
    let survey = survey.unwrap();
    let summary = survey.summary();
    assert_eq!((summary.legs, summary.splays, summary.stations), (2, 2, 7));
    let marked = survey.stations.iter().filter(|it| it.is_entrance).map(|it| &*it.name);
    assert_eq!(marked.collect::<Vec<_>>(), ["A", "E"]);
    assert_eq!(survey.legs.iter().filter(|leg| leg.flags.surface).count(), 1);
    assert_eq!(survey.legs.iter().filter(|leg| leg.flags.duplicate).count(), 1);
}

#[test]
fn dimensions_belong_to_the_station_that_the_options_name() {
    let survey = srv("A B 10 0 0 <1,2,3,4>\nB C 10 0 0 *1f 2 -- 4*\nC <5,6,7,8>\n\
         #units lrud=T:UDRL s=feet\nC D 10 0 0<1,2,3,4>\nD E 9 0 0 <0,0,0,0>\n");
    let survey = survey.unwrap();
    let shown = survey.passages.iter().map(|passage| {
        let name = |station: usize| survey.stations[station].name.clone();
        passage.iter().map(|it| name(it.station)).collect::<String>()
    });
    assert_eq!(shown.collect::<Vec<_>>(), ["ABC", "D"]);
    let second = survey.passages[0][1];
    assert_eq!((second.right, second.up, second.down), (Some(2.0), None, Some(4.0)));
    assert!((second.left.unwrap() - 0.3048).abs() < 1e-9);
    let last = survey.passages[1][0];
    assert!((last.left.unwrap() - 4.0 * 0.3048).abs() < 1e-9 && last.up < last.down);
}

#[test]
fn names_may_hold_signs_that_mean_something_elsewhere() {
    let survey = srv("U5 12#4 10 90 0 <0,0,0,1>\n12#4 &##:S1 10 0 0\n&##:S1 *8 5 0 0\n\
                      &##:S1 < 2 3 4\nU5 x: 1 -- 90\n");
    let survey = survey.unwrap();
    for (name, at) in [
        ("12#4", [10.0, 0.0, 0.0]),
        ("&##:S1", [10.0, 10.0, 0.0]),
        ("*8", [10.0, 15.0, 0.0]),
        ("x:empty name", [0.0, 0.0, 1.0]),
    ] {
        assert_at(&survey, name, at);
    }
}

#[test]
fn a_splay_may_lack_its_slope_and_other_legs_may_not() {
    let survey =
        srv("#units order=adv\nU5 - 90 1.00\n#units order=dav\nU5 -- 2 0 <1,1,1,1>\nU5 A 1 0 0\n");
    let walls = survey.unwrap().stations.into_iter().filter(|it| it.is_wall);
    let at: Vec<_> = walls.map(|it| it.position.map(f64::round)).collect();
    assert_eq!(at, [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    assert!(srv("A B 10 90\n").is_err());
}

#[test]
fn a_dive_of_no_length_joins_its_stations() {
    let survey =
        srv("#units order=da tape=ss\n3 X:1 0 0 0\n1 2 3 220 10.5 9\n2 3 1.5 135 11 8.5 ; x\n");
    let survey = survey.unwrap();
    assert_at(&survey, "X:1", [0.0, 0.0, 0.0]);
    assert_at(&survey, "2", [0.0, 0.0, -1.83]);
    assert_at(&survey, "1", [1.67, 1.99, -3.33]);
}

#[test]
fn the_date_gives_the_declination_where_the_place_is_known_whatever_was_said_before() {
    let project =
        format!(".BOOK\tX\r\n{REF}.SURVEY\ts\r\n.NAME\tONE\r\n.STATUS\t8\r\n.ENDBOOK\r\n");
    let one = |head: &str| {
        let text = format!("#fix A 249623 5068100 500\n{head}\nA B 1000 0 0\n");
        let files = Memory::default().with("p.wpj", project.clone()).with("one.srv", text);
        super::at(&read(&files, "p.wpj").unwrap(), "B")
    };
    let by_date = one("#date 2018-01-26");
    assert_eq!(one("#units decl=0\n#date 2018-01-26"), by_date);
    assert_ne!(one("#date 2018-01-26\n#units decl=0"), by_date);
}

#[test]
fn a_project_gathers_its_books_with_their_folders_and_options() {
    let project = ".BOOK\tCave\r\n.NAME\tX\r\n.STATUS\t3\r\n.SURVEY\ts\r\n.NAME\tONE\r\n.STATUS\t8\r\n\
        .BOOK\tInner\r\n.NAME\tY\r\n.PATH\tsub\r\n.OPTIONS\tPREFIX=q feet\r\n.STATUS\t9\r\n\
        .SURVEY\tt\r\n.NAME\tTWO\r\n.STATUS\t8\r\n.SURVEY\tu\r\n.NAME\tTHREE\r\n.PATH\tdeep\r\n\
        .STATUS\t8\r\n.ENDBOOK\r\n.SURVEY\tv\r\n.NAME\tFOUR\r\n.STATUS\t8\r\n\
        .BOOK\tOff\r\n.NAME\tZ\r\n.STATUS\t10\r\n.SURVEY\tw\r\n.NAME\tLOST\r\n.ENDBOOK\r\n.ENDBOOK\r\n";
    let files = Memory::default()
        .with("cave.wpj", project)
        .with("one.srv", "A B 10 0 0\r\n#units feet decl=90\r\n#date 2001-01-01\r\n")
        .with("Sub/two.SRV", ":B C 10 0 0\r\n")
        .with("Sub/deep/Three.srv", "C D 10 0 0\r\n")
        .with("four.srv", "q:D E 10 0 0\r\n");
    let survey = read(&files, "cave.wpj").unwrap();
    assert_at(&survey, "q:D", [0.0, 16.1, 0.0]);
    assert_at(&survey, "E", [0.0, 26.1, 0.0]);
    assert_eq!(survey.title.as_deref(), Some("Cave"));
    let told: Vec<_> = survey.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(told, ["cave.wpj:24: the book \"Off\" is detached, and passed over"]);
}

#[test]
fn a_reference_gives_the_declination_of_the_day_and_the_convergence() {
    let project =
        format!(".BOOK\tX\r\n.STATUS\t2563\r\n{REF}.SURVEY\ts\r\n.NAME\tONE\r\n.ENDBOOK\r\n");
    let one = "#date 2018-01-26\n#fix A 249623 5068100 500\nA B 1000 0 0\n#units decl=20\nA C 1000 0 0\n\
        #units rect\nA D 0 1000 0\n";
    let files = Memory::default().with("p.wpj", project).with("one.srv", one);
    let survey = read(&files, "p.wpj").unwrap();
    for (name, at) in [
        ("B", [249_718.33, 5_069_095.45, 500.0]),
        ("C", [250_002.53, 5_069_025.18, 500.0]),
        ("D", [249_663.21, 5_069_099.19, 500.0]),
    ] {
        let found = super::at(&survey, name);
        let off = found.iter().zip(at).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // `cavern` 1.4.24 has a newer edition of the field, which differs by 0.003° here.
        assert!(off < 0.06, "{name} is at {found:?}");
    }
}

/// A file, and the beginning of what is said of it.
const REFUSED: &[(&str, &str)] = &[
    ("", "cave.srv: there are no legs"),
    ("A\n", "cave.srv:1: the name of a station is missing"),
    ("A B -- 0 0\n", "cave.srv:1: \"--\" is no distance"),
    ("A B 10 0\n", "cave.srv:1: the slope is missing"),
    ("A B 10 -- 10\n", "cave.srv:1: a leg that is not plumbed has no compass reading"),
    ("A B 10 N95E 10\n", "cave.srv:1: \"N95E\" is no bearing"),
    ("A B 10 0 0 1 2 3\n", "cave.srv:1: \"3\" is more than belongs here"),
    ("A B 10 0 0 <1,2,3,4\n", "cave.srv:1: the < is not closed"),
    ("A B 10 0 0 (x)\n", "cave.srv:1: \"x\" is no variance"),
    ("A A 10 0 0\n", "cave.srv:1: the leg begins and ends at the same station"),
    ("- -- 10 0 0\n", "cave.srv:1: the leg is between two walls"),
    ("#units restore\n", "cave.srv:1: restore has no save"),
    ("#units d=parsecs\n", "cave.srv:1: \"parsecs\" is no value of d"),
    ("#units order=dx\n", "cave.srv:1: \"dx\" is no value of order"),
    ("#units order=dd\n", "cave.srv:1: \"dd\" is no value of order"),
    ("#units $(x)\n", "cave.srv:1: there is no macro \"x\""),
    ("#date foo\n", "cave.srv:1: \"foo\" is no date"),
    ("#fix A 1 2\n", "cave.srv:1: the coordinates of station \"A\" are no three numbers"),
    ("#fix A E14 N45 5\n", "cave.srv:1: the station is fixed in degrees, and no zone is known"),
    ("#frob x\nA B 10 0 0\n", "cave.srv:1: there is no directive #frob"),
    ("#units fete\nA B 10 0 0\n", "cave.srv:1: there is no option fete"),
    ("A B 10 0 0\n#]\n", "cave.srv:2: this #] closes no #["),
    ("A B 10 0 0\n#[\nx\n", "cave.srv:4: a #[ is not closed"),
    ("A B 10.0i6 0 0\n", "cave.srv:1: \"10.0i6\" is no distance"),
    ("A B 10 12.5:0 0\n", "cave.srv:1: \"12.5:0\" is no bearing"),
    ("#date x2001-01-01\n", "cave.srv:1: \"x2001-01-01\" is no date"),
];

/// A file, and the beginning of the remark on it.
const REMARKED: &[(&str, &str)] = &[
    ("#THANK,YOU x\nA B 10 0 0\n", "cave.srv:1: #THANK is passed over"),
    ("#\nA B 10 0 0\n", "cave.srv:1: # is passed over"),
    ("#<L,R,U,D>\nA B 10 0 0\n", "cave.srv:1: #<L is passed over"),
    ("#date 2001-01-01\\ x\nA B 10 0 0\n", "cave.srv:1: \"\\ x\" behind the date is passed over"),
    ("#date 1999-02-30\nA B 10 0 0\n", "cave.srv:1: date 1999-02-30: there is no such day in"),
    ("#date 13/01/1999\nA B 10 0 0\n", "cave.srv:1: date 13/01/1999: there is no such month"),
    ("#units typeab=c,2.0X\nA B 10 0 0\n", "cave.srv:1: \"X\" of the option typeab is passed over"),
    ("#units uvh=4m)\nA B 10 0 0\n", "cave.srv:1: \"m)\" of the option uvh is passed over"),
    ("A B 10 0 0 <1,2,3,4>>\n", "cave.srv:1: \">\" is passed over"),
    ("A B 10 0 0\nA <1,2,3,4> 'words\n", "cave.srv:2: \"'words\" is passed over"),
    ("A <B 10 0 0\n", "cave.srv:1: \"<B\" is taken for a station"),
    ("A x: 10 0 0\n", "cave.srv:1: \"x:\" has a prefix and no name"),
    ("#fix A 0 0 0\n#fix A 1 0 0\nA B 10 0 0\n", "cave.srv:2: \"A\" is fixed before"),
    ("A B 10 0 0\nC D 1 0 0\n", "cave.srv:2: no leg joins station \"C\" and 1 other"),
    ("#units grid=5\nA B 10 0 0\n", "cave.srv:1: the option grid=5 is passed over"),
    ("A B -10 0 0\n", "cave.srv:1: the tape's reading is negative"),
    ("A B 10 400 0\n", "cave.srv:1: the compass reading is not of one full circle"),
    ("A B 10 0 100\n", "cave.srv:1: the clino reading is over a right angle"),
    ("A B 10 0/186 0\n", "cave.srv:1: compass and backcompass disagree by 6.0°"),
    ("#units tape=st\nA B 10 0 0 1\n", "cave.srv:2: heights do not go with this TAPE="),
    ("A B 10 0 0 (50)\n", "cave.srv:1: a variance that is given as a leg's length is passed over"),
    ("A B 10 0 0 <1,2>\n", "cave.srv:1: the dimensions are not four lengths"),
    ("A B 10 0 0\nA C <1,2,3,4>\n", "cave.srv:2: the line has no readings"),
];

#[test]
fn what_cannot_be_used_is_refused_and_what_is_doubtful_remarked_on_where_it_stands() {
    for (text, beginning) in REFUSED {
        let refusal = srv(text).err().unwrap_or_else(|| panic!("{text:?} is read"));
        let told = refusal.to_string();
        assert!(told.starts_with(beginning), "{text:?}:\n{told}, not\n{beginning}");
    }
    for (text, beginning) in REMARKED {
        let survey = srv(text).unwrap_or_else(|refusal| panic!("{text:?}: {refusal}"));
        let told = survey.warnings.first().map(ToString::to_string).unwrap_or_default();
        assert!(told.starts_with(beginning), "{text:?}:\n{told}, not\n{beginning}");
    }
    assert!(srv("A B 10 0/184 0\n").unwrap().warnings.is_empty(), "within the tolerance of 5°");
}

#[test]
fn a_project_with_mistakes_is_refused_where_they_stand() {
    let with = |project: &str| {
        let files = Memory::default().with("p.wpj", project).with("one.srv", "A B 10 0 0\n");
        read(&files, "p.wpj").unwrap_err().to_string()
    };
    for (project, beginning) in [
        (".BOOK x\n.SURVEY y\n.NAME LOST\n", "p.wpj:3: there is no file \"LOST.srv\""),
        (".ENDBOOK\n", "p.wpj:1: this .ENDBOOK has no .BOOK"),
        (
            ".BOOK x\n.PATH ..\\..\n.SURVEY y\n.NAME ONE\n",
            "p.wpj:4: \"../../ONE.srv\" lies outside",
        ),
        (".BOOK x\n.OPTIONS D=x\n", "p.wpj:2: \"x\" is no value of d"),
    ] {
        let told = with(project);
        assert!(told.starts_with(beginning), "{told}, not\n{beginning}");
    }
}
