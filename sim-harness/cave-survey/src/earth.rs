//! Places coordinates and the compass on the earth: coordinate systems, the grid's north, and the
//! magnetic declination of a place and a day.

use igrf::declination;
use proj4rs::Proj;
use proj4rs::transform::transform;

use crate::matrix::Vector;

/// A coordinate system.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct System {
    /// What PROJ calls it, without an offset.
    definition: String,
    /// Metres east and north that are added to coordinates first, for a square of a grid.
    offset: [f64; 2],
}

/// The reason why coordinates cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EarthError {
    /// No such system is known.
    Unknown,
    /// The system is known, but its projection is not supported.
    Unsupported,
}

/// British National Grid, EPSG:27700.
const BRITISH: u16 = 27700;

impl System {
    /// The system of that name, as `*cs` takes it.
    pub(crate) fn named(name: &str) -> Result<Self, EarthError> {
        let upper = name.to_ascii_uppercase();
        let plain = |definition: String| Ok(Self { definition, offset: [0.0; 2] });
        if let Some(code) = upper.strip_prefix("EPSG:") {
            let code = code.parse().map_err(|_| EarthError::Unknown)?;
            let known = crs_definitions::from_code(code).ok_or(EarthError::Unknown)?;
            return plain(known.proj4.into());
        }
        if let Some(square) = upper.strip_prefix("OSGB:") {
            let known = crs_definitions::from_code(BRITISH).ok_or(EarthError::Unknown)?;
            let offset = british_square(square).ok_or(EarthError::Unknown)?;
            return Ok(Self { definition: known.proj4.into(), offset });
        }
        if let Some(zone) = upper.strip_prefix("UTM") {
            let south = zone.ends_with('S');
            let zone: u8 =
                zone.trim_end_matches(['N', 'S']).parse().map_err(|_| EarthError::Unknown)?;
            if !(1..=60).contains(&zone) {
                return Err(EarthError::Unknown);
            }
            let south = if south { " +south" } else { "" };
            return plain(format!("+proj=utm +zone={zone}{south} +datum=WGS84 +units=m +no_defs"));
        }
        match upper.as_str() {
            "LONG-LAT" => plain("+proj=longlat +datum=WGS84 +no_defs".into()),
            "S-MERC" => {
                plain(crs_definitions::from_code(3857).ok_or(EarthError::Unknown)?.proj4.into())
            }
            "EUR79Z30" => plain(
                "+proj=utm +zone=30 +ellps=intl +towgs84=-86,-98,-119,0,0,0,0 +units=m +no_defs"
                    .into(),
            ),
            "IJTSK" => plain(krovak("", JTSK)),
            "IJTSK03" => plain(krovak("", JTSK03)),
            "JTSK" => plain(krovak("+czech ", JTSK)),
            "JTSK03" => plain(krovak("+czech ", JTSK03)),
            _ if upper.starts_with("ESRI:") => Err(EarthError::Unsupported),
            _ => Err(EarthError::Unknown),
        }
    }

    /// The system that a text for PROJ defines.
    pub(crate) fn custom(definition: &str) -> Result<Self, EarthError> {
        let words = definition.split_whitespace().map(with_decimal_angle);
        let definition = words.collect::<Vec<_>>().join(" ");
        Proj::from_proj_string(&definition).map_err(|_| EarthError::Unsupported)?;
        Ok(Self { definition, offset: [0.0; 2] })
    }

    /// Whether the axes lead west and south, so that positions in it would be mirrored.
    pub(crate) fn is_mirrored(&self) -> bool {
        self.definition.contains("+czech")
    }

    /// Metres of the unit of heights.
    fn height_unit(&self) -> f64 {
        let mut words = self.definition.split_whitespace();
        match words.find_map(|word| word.strip_prefix("+vunits=")) {
            Some("ft") => 0.3048,
            Some("us-ft") => 1200.0 / 3937.0,
            _ => 1.0,
        }
    }

    /// Whether the coordinates are angles.
    pub(crate) fn is_angular(&self) -> bool {
        self.definition.contains("+proj=longlat")
    }

    /// Whether points of this system can be placed on the earth.
    pub(crate) fn is_computable(&self) -> bool {
        // In the middle of a zone of UTM.
        self.degrees([500_000.0, 5_000_000.0, 0.0]).is_ok_and(|at| at.iter().all(|x| x.is_finite()))
    }

    fn projection(&self) -> Result<Proj, EarthError> {
        Proj::from_proj_string(&self.definition).map_err(|_| EarthError::Unsupported)
    }

    /// The coordinates of a point of this system in another.
    pub(crate) fn to(&self, other: &Self, at: Vector) -> Result<Vector, EarthError> {
        let [x, y] = [at[0] + self.offset[0], at[1] + self.offset[1]];
        let z = at[2] * self.height_unit() / other.height_unit();
        if heightless(&self.definition) == heightless(&other.definition) {
            return Ok([x - other.offset[0], y - other.offset[1], z]);
        }
        let scale = if self.is_angular() { 1f64.to_radians() } else { 1.0 };
        let mut point = (x * scale, y * scale, 0.0);
        transform(&self.projection()?, &other.projection()?, &mut point)
            .map_err(|_| EarthError::Unsupported)?;
        let scale = if other.is_angular() { 1f64.to_degrees() } else { 1.0 };
        Ok([point.0 * scale - other.offset[0], point.1 * scale - other.offset[1], z])
    }

    /// The longitude and the latitude of a point, in degrees.
    pub(crate) fn degrees(&self, at: Vector) -> Result<[f64; 2], EarthError> {
        let [longitude, latitude, _] = self.to(&Self::named("LONG-LAT")?, at)?;
        Ok([longitude, latitude])
    }

    /// The angle from true north to this system's north at a place in degrees, clockwise, in
    /// radians.
    ///
    /// In a system that is compound, of a plane and a height, it is taken for 0, as `cavern` 1.4.22
    /// takes it: surveys are drawn up and compared by its positions.
    pub(crate) fn convergence(&self, [longitude, latitude]: [f64; 2]) -> Result<f64, EarthError> {
        if self.definition.contains("+vunits") {
            return Ok(0.0);
        }
        let system = Self::named("LONG-LAT")?;
        let place = |latitude| system.to(self, [longitude, latitude, 0.0]);
        /// A step of 100 m north, in degrees.
        const STEP: f64 = 0.0009;
        let (south, north) = (place(latitude - STEP)?, place(latitude + STEP)?);
        Ok(-(north[0] - south[0]).atan2(north[1] - south[1]))
    }
}

/// The shifts from the datums of the Czech and Slovak grids to WGS 1984, as Survex 1.4.22 has them.
const JTSK: &str = "570.8285,85.6769,462.842,4.9984,1.5867,5.2611,3.5623";
const JTSK03: &str = "485.021,169.465,483.839,7.786342,4.397554,4.102655,0";

/// The definition of a grid in the projection of Krovak.
fn krovak(axes: &str, shift: &str) -> String {
    format!("+proj=krovak {axes}+ellps=bessel +towgs84={shift} +units=m +no_defs")
}

/// A word of a definition, in which an angle such as `13d20` or `13d20'30"` becomes decimal.
fn with_decimal_angle(word: &str) -> String {
    let decimal = word.split_once('=').and_then(|(key, value)| {
        let (degrees, rest) = value.split_once(['d', 'D'])?;
        let (minutes, seconds) = rest.split_once('\'').unwrap_or((rest, ""));
        let seconds = seconds.trim_end_matches('"');
        let part = |text: &str| if text.is_empty() { Some(0.0) } else { text.parse::<f64>().ok() };
        let whole = degrees.parse::<f64>().ok()?;
        let fraction = part(minutes)? / 60.0 + part(seconds)? / 3600.0;
        let sign = if degrees.starts_with('-') { -1.0 } else { 1.0 };
        Some(format!("{key}={}", whole + sign * fraction))
    });
    decimal.unwrap_or_else(|| word.to_owned())
}

/// The definition without what concerns heights, which have units of their own.
fn heightless(definition: &str) -> String {
    let words = definition.split_whitespace().filter(|word| !word.starts_with("+vunits"));
    words.collect::<Vec<_>>().join(" ")
}

/// The south-west corner of a square of 100 km of the British grid, of two letters: the first is of
/// 500 km, and both count in rows of five from the north-west, without I. The grid's origin is the
/// south-west corner of SV.
fn british_square(letters: &str) -> Option<[f64; 2]> {
    let [first, second] = <[u8; 2]>::try_from(letters.as_bytes()).ok()?;
    let place = |letter: u8| {
        if !letter.is_ascii_uppercase() || letter == b'I' {
            return None;
        }
        let number = i32::from(letter - b'A') - i32::from(letter > b'I');
        Some([number % 5, 4 - number / 5])
    };
    if !b"HNOST".contains(&first) {
        return None;
    }
    let ([big_x, big_y], [x, y], [zero_x, zero_y]) = (place(first)?, place(second)?, place(b'S')?);
    let corner = |big: i32, zero: i32, small: i32| f64::from((big - zero) * 5 + small) * 1e5;
    Some([corner(big_x, zero_x, x), corner(big_y, zero_y, y)])
}

/// The magnetic declination at a place in degrees, metres above the sea, on a day; in radians.
///
/// It is that of the International Geomagnetic Reference Field, 13th generation, which Survex
/// 1.4.4 uses as well. Beyond its years, from 1900 to 2025, it is extrapolated.
pub(crate) fn magnetic_declination(
    [longitude, latitude]: [f64; 2],
    up: f64,
    day: Day,
) -> Option<f64> {
    let month = time::Month::try_from(day.month).ok()?;
    let date = time::Date::from_calendar_date(i32::from(day.year), month, day.day).ok()?;
    let field = match declination(latitude, longitude, up.clamp(0.0, 1e4) as u32, date) {
        Ok(field) | Err(igrf::Error::DateOutOfRange(field)) => field,
        Err(_) => return None,
    };
    // At the magnetic poles there is none.
    Some(field.d.to_radians()).filter(|angle| angle.is_finite())
}

/// A place for which the angle between the compass's north and a grid's is asked day by day.
#[derive(Clone, Debug)]
pub(crate) struct Base {
    /// Longitude and latitude, degrees.
    place: [f64; 2],
    /// The height above the sea, m.
    up: f64,
    /// The angle from true north to the grid's, rad.
    convergence: f64,
    last: Option<(Day, f64)>,
}

impl Base {
    /// Makes the base at a point of `system`, for directions in the grid `output`; `None` where it
    /// cannot be computed.
    pub(crate) fn new(system: &System, output: &System, at: Vector) -> Option<Self> {
        let place = system.degrees(at).ok()?;
        let convergence = output.convergence(place).ok()?;
        let is_sound = place.into_iter().chain([convergence]).all(f64::is_finite);
        is_sound.then_some(Self { place, up: at[2], convergence, last: None })
    }

    /// The angle from true north to the grid's, rad.
    pub(crate) const fn convergence(&self) -> f64 {
        self.convergence
    }

    /// The angle from the compass's north to the grid's, rad; without a day, that from true north.
    pub(crate) fn declination(&mut self, day: Option<Day>) -> f64 {
        let Some(day) = day else { return -self.convergence };
        if let Some((known, angle)) = self.last
            && known == day
        {
            return angle;
        }
        let magnetic = magnetic_declination(self.place, self.up, day).unwrap_or(0.0);
        self.last = Some((day, magnetic - self.convergence));
        magnetic - self.convergence
    }
}

/// A day of the calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Day {
    pub(crate) year: u16,
    pub(crate) month: u8,
    pub(crate) day: u8,
}

impl Day {
    /// The number of the day, counted from long ago.
    pub(crate) fn julian(self) -> Option<i32> {
        let month = time::Month::try_from(self.month).ok()?;
        let date = time::Date::from_calendar_date(i32::from(self.year), month, self.day);
        Some(date.ok()?.to_julian_day())
    }

    /// The day in the middle between two.
    pub(crate) fn middle(self, other: Self) -> Option<Self> {
        let middle = i32::midpoint(self.julian()?, other.julian()?);
        let date = time::Date::from_julian_day(middle).ok()?;
        let year = u16::try_from(date.year()).ok()?;
        Some(Self { year, month: date.month().into(), day: date.day() })
    }
}
