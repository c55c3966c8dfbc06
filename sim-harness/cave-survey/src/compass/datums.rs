//! Knows the datums by the names that Compass gives them.

use crate::earth::System;

/// The zones of UTM of a datum that are in the register of EPSG, with the number that is added to
/// the zone's: south of the equator, zones are negative here and positive in the register.
struct Range {
    zones: std::ops::RangeInclusive<i32>,
    code: i32,
}

const fn range(first: i32, last: i32, code: i32) -> Range {
    Range { zones: first..=last, code }
}

/// The datums, and where EPSG's register has their zones.
const DATUMS: &[(&str, &[Range])] = &[
    ("WGS 1984", &[range(1, 60, 32600), range(-60, -1, 32700)]),
    ("North American 1983", &[range(1, 23, 26900), range(59, 60, 3313)]),
    ("North American 1927", &[range(1, 23, 26700), range(59, 60, 3311)]),
    ("Adindan", &[range(35, 38, 20100)]),
    ("Arc 1950", &[range(-36, -34, 20900)]),
    ("Arc 1960", &[range(-37, -35, 21000)]),
    ("Cape", &[range(-36, -34, 22200)]),
    ("European 1950", &[range(28, 38, 23000)]),
    ("Geodetic 1949", &[range(58, 60, 27200)]),
    ("Hu Tzu Shan", &[range(51, 51, 3829 - 51)]),
    ("Indian", &[range(48, 49, 3100)]),
    ("Tokyo", &[range(51, 55, 3041)]),
    ("WGS 1972", &[range(1, 60, 32200), range(-60, -1, 32300)]),
];

/// The system of coordinates of a zone in a datum, and whether it is that of WGS 1984 in the place
/// of one that cannot be computed; `None` where the datum is not known, or has no such zone.
pub(super) fn system(datum: &str, zone: i32) -> Option<(System, bool)> {
    let (name, ranges) = DATUMS.iter().find(|(name, _)| *name == datum)?;
    let code = ranges.iter().find(|range| range.zones.contains(&zone)).map(|range| range.code);
    if let Some(code) = code {
        let system = System::named(&format!("EPSG:{}", code + zone.abs())).ok();
        if let Some(system) = system.filter(System::is_computable) {
            return Some((system, false));
        }
    } else if !name.starts_with("North American") {
        return None;
    }
    let side = if zone > 0 { 'N' } else { 'S' };
    let system = System::named(&format!("UTM{}{side}", zone.abs())).ok()?;
    Some((system, true))
}
