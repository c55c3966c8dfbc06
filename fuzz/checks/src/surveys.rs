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
        Err(refusal) => assert!(!refusal.wrong.is_empty() && !refusal.remedy.is_empty()),
    }
}
