//! The readers of cave surveys: no bytes make them panic or take without bound, and every position
//! of a survey that they accept is a number.

use cave_survey::{Memory, Refusal, Survey, read};

/// Reads the bytes as a `.svx` file that may include itself.
pub fn survex(data: &[u8]) {
    accepted(read(&Memory::default().with("cave.svx", data), "cave.svx"));
}

/// Reads the bytes as a `.3d` file.
pub fn three_d(data: &[u8]) {
    accepted(read(&Memory::default().with("cave.3d", data), "cave.3d"));
}

/// Reads the bytes as both kinds of Compass's files; a project lists the survey and itself.
pub fn compass(data: &[u8]) {
    let files = Memory::default().with("cave.mak", data).with("one.dat", data);
    for entry in ["cave.mak", "one.dat"] {
        accepted(read(&files, entry));
    }
}

/// Reads the bytes as both kinds of Walls's files; a project lists the survey, and a survey that is
/// in a zone of UTM.
pub fn walls(data: &[u8]) {
    let zone = ".BOOK x\n.REF 5068100 449623 33 0 553 0 45 45 52 14 21 7 27 \"WGS 1984\"\n\
        .SURVEY y\n.NAME ONE\n.ENDBOOK\n";
    let files = Memory::default().with("cave.wpj", data).with("one.srv", data);
    let files = files.with("zone.wpj", zone);
    for entry in ["cave.wpj", "one.srv", "zone.wpj"] {
        accepted(read(&files, entry));
    }
}

/// Reads the bytes as Therion's data file, which may include a sound one, and as a configuration file,
/// which names the data file.
pub fn therion(data: &[u8]) {
    let part = "survey part\ncentreline\ndata normal from to tape compass clino\n1 2 10 0 0\n\
        endcentreline\nendsurvey\n";
    let files = Memory::default().with("cave.th", data).with("part.th", part);
    let files = files.with("thconfig", [b"source cave\n", data].concat());
    for entry in ["cave.th", "thconfig"] {
        accepted(read(&files, entry));
    }
}

/// Reads the bytes as a file of VisualTopo.
pub fn visual_topo(data: &[u8]) {
    accepted(read(&Memory::default().with("cave.tro", data), "cave.tro"));
}

/// Reads the bytes as an export of PocketTopo, which is told by its contents alone.
pub fn pocket_topo(data: &[u8]) {
    for line in ["", "Cave (m, 360)\n", "TRIP\nDATA\n"] {
        let text = [line.as_bytes(), data].concat();
        accepted(read(&Memory::default().with("cave.txt", text), "cave.txt"));
    }
}

fn accepted(survey: Result<Survey, Refusal>) {
    match survey {
        Ok(survey) => {
            assert!(survey.stations.iter().flat_map(|it| it.position).all(f64::is_finite));
            let summary = survey.summary();
            assert!(summary.length_m.is_finite() && summary.misclosure_m.is_finite());
            for leg in &survey.legs {
                assert!(leg.from < survey.stations.len() && leg.to < survey.stations.len());
            }
        }
        Err(refusal) => {
            assert!(!refusal.wrong.is_empty() && !refusal.remedy.is_empty());
            assert_eq!(refusal.to_string().lines().count(), 1, "{refusal}");
        }
    }
}
