//! Holds what `#Units` sets for the lines that follow.

use super::numbers::{self, AngleUnit};
use crate::survex::settings::{FOOT, Instrument, Quantity, Settings, Unit};

/// The way in which a tape was held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Taping {
    /// From the instrument to the target, the default.
    InstrumentToTarget,
    /// From station to station.
    StationToStation,
    /// In another way, from or to one station only.
    Mixed,
}

/// A reading of a line by tape and compass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Item {
    Distance,
    Azimuth,
    Vertical,
}

/// How the case of letters in names counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Case {
    Mixed,
    Upper,
    Lower,
}

/// The difference of foresight and backsight up to which Walls says nothing, degrees.
const TOLERANCE_DEG: f64 = 5.0;

/// The ratio of the standard deviations of Walls's surveys to those of Survex's own. `cavern` 1.4.24
/// takes a deviation by which foresight and backsight differ too much just where they differ by more
/// than the tolerance, 3 √2 deviations; the others are larger in proportion, so that surveys that
/// give no tolerance close like Survex's.
const COARSER: f64 = TOLERANCE_DEG / (3.0 * std::f64::consts::SQRT_2 * 0.5);

/// What `#Units` sets.
#[derive(Clone, Debug)]
pub(super) struct Units {
    /// Zero errors and accuracies.
    pub(super) settings: Settings,
    /// Metres of one unit of distances.
    pub(super) distance: f64,
    /// Metres of one unit of heights, dimensions and coordinate legs.
    pub(super) size: f64,
    /// The units of bearings, foresight and backsight.
    pub(super) azimuth: [AngleUnit; 2],
    /// The units of slopes.
    pub(super) vertical: [AngleUnit; 2],
    /// The readings of a line by tape and compass, in their order.
    pub(super) order: Vec<Item>,
    /// The axes of a line of coordinates, in their order: 0 is east.
    pub(super) axes: Vec<usize>,
    pub(super) is_rect: bool,
    /// Whether backsights of bearings and of slopes are turned round already.
    pub(super) is_corrected: [bool; 2],
    pub(super) taping: Taping,
    /// The height that is added to legs with a slope, m.
    pub(super) height: f64,
    /// The declination, rad; `None` where it follows from the date.
    pub(super) declination: Option<f64>,
    /// The angle by which coordinate legs are turned clockwise, rad.
    pub(super) turn: f64,
    /// Factors of the variances, horizontally and vertically.
    pub(super) variance: [f64; 2],
    /// Whether dimensions are those at the second station.
    pub(super) is_at_second: bool,
    /// The places in a line of left, right, up and down.
    pub(super) dimensions: [usize; 4],
    /// The prefixes of names, the innermost first.
    pub(super) prefix: [String; 3],
    case: Case,
}

impl Default for Units {
    fn default() -> Self {
        let mut settings = Settings::default();
        for instrument in &mut settings.instruments {
            instrument.variance *= COARSER * COARSER;
            *instrument = Instrument { unit: Unit::Plain(1.0), ..*instrument };
        }
        Self {
            settings,
            distance: 1.0,
            size: 1.0,
            azimuth: [AngleUnit::Degrees; 2],
            vertical: [AngleUnit::Degrees; 2],
            order: vec![Item::Distance, Item::Azimuth, Item::Vertical],
            axes: vec![0, 1, 2],
            is_rect: false,
            is_corrected: [false; 2],
            taping: Taping::InstrumentToTarget,
            height: 0.0,
            declination: None,
            turn: 0.0,
            variance: [1.0; 2],
            is_at_second: false,
            dimensions: [0, 1, 2, 3],
            prefix: Default::default(),
            case: Case::Mixed,
        }
    }
}

/// What is wrong with an option.
pub(super) enum OptionFault {
    /// There is no such option.
    Unknown,
    /// The option does nothing here.
    PassedOver,
    /// The option is set, and what follows its number is not read.
    Junk(String),
    /// Its value cannot be used; the text says what it should be.
    Unusable(&'static str),
}

use OptionFault::{Junk, PassedOver, Unknown, Unusable};

impl Units {
    /// Sets an option, whose key is in lower case.
    pub(super) fn set(&mut self, key: &str, value: Option<&str>) -> Result<(), OptionFault> {
        let text = value.unwrap_or_default();
        match key {
            "m" | "meters" | "metres" => (self.distance, self.size) = (1.0, 1.0),
            "f" | "feet" => (self.distance, self.size) = (FOOT, FOOT),
            "d" | "distance" => self.distance = length_unit(text)?,
            "s" => self.size = length_unit(text)?,
            "a" | "azimuth" => self.azimuth[0] = angle_unit(text)?,
            "ab" => self.azimuth[1] = angle_unit(text)?,
            "a/ab" => self.azimuth = [angle_unit(text)?; 2],
            "v" | "vertical" => self.vertical[0] = angle_unit(text)?,
            "vb" => self.vertical[1] = angle_unit(text)?,
            "v/vb" => self.vertical = [angle_unit(text)?; 2],
            "order" | "o" => self.set_order(text)?,
            "ct" => self.is_rect = false,
            "rect" if value.is_none() => self.is_rect = true,
            "rect" => self.turn = self.angle(text)?,
            "decl" => self.declination = Some(self.angle(text)?),
            // Corrections are added, where a zero error is taken away.
            "incd" => self.zero(Quantity::Length, self.length(text)?),
            "inch" => self.height = numbers::length(text, self.size).ok_or(Unusable("a length"))?,
            "inca" => self.zero(Quantity::Bearing, angle_in(text, self.azimuth[0])?),
            "incab" => self.zero(Quantity::BackBearing, angle_in(text, self.azimuth[1])?),
            "incv" => self.zero(Quantity::Gradient, angle_in(text, self.vertical[0])?),
            "incvb" => self.zero(Quantity::BackGradient, angle_in(text, self.vertical[1])?),
            "typeab" => {
                self.set_type(0, [Quantity::Bearing, Quantity::BackBearing], text)?;
            }
            "typevb" => {
                self.set_type(1, [Quantity::Gradient, Quantity::BackGradient], text)?;
            }
            "tape" => self.taping = taping(text)?,
            "uv" | "uvh" | "uvv" => {
                let (factor, junk) = factor(text)?;
                let axes = if key == "uvv" { 1..2 } else { 0..1 + usize::from(key == "uv") };
                self.variance[axes].fill(factor);
                return junk;
            }
            "lrud" => self.set_dimensions(text)?,
            "p" | "prefix" | "prefix1" => text.clone_into(&mut self.prefix[0]),
            "prefix2" => text.clone_into(&mut self.prefix[1]),
            "prefix3" => text.clone_into(&mut self.prefix[2]),
            "case" => {
                self.case = match text.chars().next().map(|it| it.to_ascii_lowercase()) {
                    Some('u') => Case::Upper,
                    Some('l') => Case::Lower,
                    _ => Case::Mixed,
                }
            }
            "reset" => *self = Self::default(),
            // Flags and notes that belong to every station mark none.
            "flag" | "note" => {}
            "grid" => return Err(PassedOver),
            _ => return Err(Unknown),
        }
        Ok(())
    }

    fn length(&self, text: &str) -> Result<f64, OptionFault> {
        numbers::length(text, self.distance).ok_or(Unusable("a length"))
    }

    fn angle(&self, text: &str) -> Result<f64, OptionFault> {
        angle_in(text, AngleUnit::Degrees)
    }

    const fn zero(&mut self, quantity: Quantity, correction: f64) {
        self.settings.change(quantity).zero = -correction;
    }

    /// Reads an order such as `DAV`, of tape and compass, or `ENU`, of coordinates.
    fn set_order(&mut self, text: &str) -> Result<(), OptionFault> {
        let letters: Vec<char> = text.to_ascii_lowercase().chars().collect();
        let unusable = Unusable("DAV, DA, ENU or EN, in any order");
        let items: Option<Vec<Item>> = letters.iter().map(|letter| item(*letter)).collect();
        let axes: Option<Vec<usize>> = letters.iter().map(|letter| "enu".find(*letter)).collect();
        let is_once = (0..letters.len()).all(|n| !letters[..n].contains(&letters[n]));
        match (items, axes) {
            _ if !is_once => return Err(unusable),
            (Some(items), _)
                if items.contains(&Item::Distance) && items.contains(&Item::Azimuth) =>
            {
                self.order = items;
            }
            (_, Some(axes)) if axes.contains(&0) && axes.contains(&1) => self.axes = axes,
            _ => return Err(unusable),
        }
        Ok(())
    }

    /// Reads `N` or `C`, for backsights as they were read or turned round, and the tolerance.
    fn set_type(
        &mut self,
        which: usize,
        quantities: [Quantity; 2],
        text: &str,
    ) -> Result<(), OptionFault> {
        let mut parts = text.split(',').map(str::trim);
        self.is_corrected[which] = match parts.next().unwrap_or_default().chars().next() {
            Some('n' | 'N') => false,
            Some('c' | 'C') => true,
            _ => return Err(Unusable("N or C")),
        };
        let mut junk = Ok(());
        if let Some(tolerance) = parts.next() {
            let read = numbers::leading(tolerance).filter(|it| it.0 > 0.0 && it.0 <= 180.0);
            let (degrees, rest) = read.ok_or(Unusable("N or C and a tolerance in degrees"))?;
            junk = without_junk(rest);
            let deviation = degrees.to_radians() / (3.0 * std::f64::consts::SQRT_2);
            for quantity in quantities {
                self.settings.change(quantity).variance = deviation * deviation;
            }
        }
        // With X, backsights are compared but not used; `cavern` uses them too.
        if parts.next().is_some() { Err(PassedOver) } else { junk }
    }

    /// Reads where dimensions are measured, and their order: `F`, `T`, `FB:UDLR`.
    fn set_dimensions(&mut self, text: &str) -> Result<(), OptionFault> {
        let (place, order) = text.split_once(':').unwrap_or((text, "lrud"));
        let unusable = || Unusable("F, T, FB or TB, with an order such as :LRUD");
        self.is_at_second = match place.chars().next().map(|it| it.to_ascii_lowercase()) {
            Some('f') => false,
            Some('t') => true,
            _ => return Err(unusable()),
        };
        let order = if order.is_empty() { "lrud" } else { order }.to_ascii_lowercase();
        let mut places = [0; 4];
        for (place, letter) in places.iter_mut().zip("lrud".chars()) {
            *place = order.chars().position(|it| it == letter).ok_or_else(unusable)?;
        }
        if order.chars().count() != 4 {
            return Err(unusable());
        }
        self.dimensions = places;
        Ok(())
    }

    /// The full name of a station: `:` leaves out as many prefixes as it stands in the name, and
    /// what stands before it takes their place. Outer prefixes that are empty are left out, as Walls
    /// does, and others are a blank, as `cavern` has them.
    pub(super) fn full_name(&self, name: &str) -> String {
        let name = match self.case {
            Case::Mixed => name.to_owned(),
            Case::Upper => name.to_uppercase(),
            Case::Lower => name.to_lowercase(),
        };
        let mut levels: Vec<&str> = name.split(':').collect();
        let given = levels.len() - 1;
        for prefix in self.prefix.iter().skip(given) {
            levels.insert(0, prefix);
        }
        // A name may be a prefix alone; `cavern` calls the station so.
        if let Some(last) = levels.last_mut().filter(|last| last.is_empty() && given > 0) {
            *last = "empty name";
        }
        let empty = levels.iter().take_while(|level| level.is_empty()).count();
        let levels = levels.iter().skip(empty.min(levels.len() - 1));
        let shown = levels.map(|level| if level.is_empty() { " " } else { level });
        shown.collect::<Vec<_>>().join(":")
    }
}

fn item(letter: char) -> Option<Item> {
    Some(match letter {
        'd' => Item::Distance,
        'a' => Item::Azimuth,
        'v' => Item::Vertical,
        _ => return None,
    })
}

/// Walls looks only at the first letter of a unit.
fn length_unit(text: &str) -> Result<f64, OptionFault> {
    match text.chars().next().map(|it| it.to_ascii_lowercase()) {
        Some('m') => Ok(1.0),
        Some('f') => Ok(FOOT),
        _ => Err(Unusable("meters or feet")),
    }
}

fn angle_unit(text: &str) -> Result<AngleUnit, OptionFault> {
    text.chars().next().and_then(AngleUnit::of).ok_or(Unusable("degrees, grads, mils or percent"))
}

fn angle_in(text: &str, unit: AngleUnit) -> Result<f64, OptionFault> {
    numbers::angle(text, unit).ok_or(Unusable("an angle"))
}

/// A factor of variances, which `cavern` keeps from being nothing or endless, and what follows it.
fn factor(text: &str) -> Result<(f64, Result<(), OptionFault>), OptionFault> {
    let read = numbers::leading(text).filter(|(number, _)| *number >= 0.0);
    let (number, rest) = read.ok_or(Unusable("a factor that is not negative"))?;
    Ok((number.clamp(1e-6, 9999.0), without_junk(rest)))
}

/// Walls does not read what follows a number in these options.
fn without_junk(rest: &str) -> Result<(), OptionFault> {
    if rest.is_empty() { Ok(()) } else { Err(Junk(rest.to_owned())) }
}

fn taping(text: &str) -> Result<Taping, OptionFault> {
    match &*text.to_ascii_lowercase() {
        "it" => Ok(Taping::InstrumentToTarget),
        "ss" => Ok(Taping::StationToStation),
        "is" | "st" => Ok(Taping::Mixed),
        _ => Err(Unusable("IT, SS, IS or ST")),
    }
}
