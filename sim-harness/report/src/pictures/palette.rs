//! The colours of what is drawn of a mission: one table for the pictures, the report, and the recordings.
//!
//! Every colour that can stand beside another one in a picture differs from it, on light and on dark ground:
//! the tests hold all pairs to a least difference. Links have one ramp, from [`WEAK`] to [`STRONG`], which
//! people with any colour vision can tell apart; no drone has a colour that is near to it.

use std::fmt::Write;

use plotters::style::RGBColor;
use units::Role;

use mission::trace::Node;

/// One meaning's colour on light and on dark ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shade {
    /// The colour on white.
    pub(crate) light: RGBColor,
    /// The colour on the report's dark ground.
    pub(crate) dark: RGBColor,
}

const fn shade(light: [u8; 3], dark: [u8; 3]) -> Shade {
    Shade {
        light: RGBColor(light[0], light[1], light[2]),
        dark: RGBColor(dark[0], dark[1], dark[2]),
    }
}

/// A link at the launch limit or below it: vermilion of Okabe and Ito, "Color Universal Design", 2008.
pub(crate) const WEAK: RGBColor = RGBColor(213, 94, 0);
/// A link that is [`SPARE_DB`] or more above the launch limit: blue of the same palette.
pub(crate) const STRONG: RGBColor = RGBColor(0, 114, 178);
/// A link counts as strong so far above the launch limit, dB.
pub(crate) const SPARE_DB: f64 = 15.0;
/// The strength at which links count as weak in a mission without a launch limit, dBm: about where packets begin
/// to be lost.
pub(crate) const WEAK_DBM: f64 = -85.0;

/// The first explorer, and the head of a chain.
const HEAD: Shade = shade([204, 0, 122], [255, 80, 160]);
/// The base.
const BASE: Shade = shade([31, 41, 51], [228, 233, 238]);
/// Relays by their numbers.
const RELAYS: [Shade; 15] = [
    shade([100, 0, 160], [140, 80, 200]),
    shade([0, 170, 0], [0, 170, 0]),
    shade([130, 0, 40], [210, 30, 80]),
    shade([180, 110, 250], [180, 120, 250]),
    shade([90, 160, 150], [90, 160, 150]),
    shade([0, 80, 0], [0, 130, 60]),
    shade([190, 130, 160], [190, 130, 160]),
    shade([250, 80, 180], [200, 60, 170]),
    shade([0, 30, 180], [80, 140, 250]),
    shade([50, 120, 0], [100, 210, 10]),
    shade([140, 80, 170], [210, 170, 240]),
    shade([60, 150, 250], [100, 190, 250]),
    shade([100, 90, 250], [70, 90, 240]),
    shade([90, 60, 100], [250, 120, 250]),
    shade([190, 0, 20], [250, 180, 160]),
];
/// The beams of the rangers.
const BEAM: Shade = shade([230, 159, 0], [230, 159, 0]);
/// Cells that explorers know as free beside what they do not know.
const FRONTIER: Shade = shade([212, 200, 0], [212, 200, 0]);
/// Ground that explorers know as free.
const KNOWN: Shade = shade([190, 218, 214], [43, 78, 80]);

/// A node's colours: the head stands out, the base stays back, and relays that follow each other differ.
pub(crate) fn node_shade(node: &Node) -> Shade {
    match node.role {
        Role::Head if node.id.0 == 0 => HEAD,
        Role::Base => BASE,
        Role::Head | Role::Relay => {
            let turn = usize::from(node.id.0.saturating_sub(1)) % RELAYS.len();
            RELAYS.get(turn).copied().unwrap_or(HEAD)
        }
    }
}

/// A node's colour on light ground as red, green and blue.
pub(crate) fn node_rgb(node: &Node) -> [u8; 3] {
    let RGBColor(r, g, b) = node_shade(node).light;
    [r, g, b]
}

/// The colour of a link of this strength, dBm, where links below `limit` are too weak.
pub(crate) fn link_colour(dbm: f64, limit: Option<f64>) -> RGBColor {
    let share = ((dbm - limit.unwrap_or(WEAK_DBM)) / SPARE_DB).clamp(0.0, 1.0);
    let (RGBColor(r, g, b), RGBColor(r2, g2, b2)) = (WEAK, STRONG);
    let mixed = |weak: u8, strong: u8| {
        (f64::from(weak) + (f64::from(strong) - f64::from(weak)) * share).round() as u8
    };
    RGBColor(mixed(r, r2), mixed(g, g2), mixed(b, b2))
}

/// The colour as a style sheet writes it: `#d55e00`.
pub(crate) fn hex(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The variable of the report's style sheet that holds a node's colour.
pub(crate) fn variable(node: &Node) -> String {
    format!("var({})", name_of(node_shade(node)))
}

fn name_of(shade: Shade) -> String {
    format!("--drone-{}", hex(shade.light).trim_start_matches('#'))
}

/// The part of the report's style sheet that says all colours of a mission, for light and dark ground. Pictures
/// are painted for light ground: on dark ground their drones' colours are exchanged.
pub(crate) fn style() -> String {
    let named = [("--beam", BEAM), ("--frontier", FRONTIER), ("--known", KNOWN)];
    let named = named.map(|(name, shade)| (name.to_owned(), shade));
    let drones: Vec<Shade> = [HEAD, BASE].into_iter().chain(RELAYS).collect();
    let named: Vec<(String, Shade)> =
        named.into_iter().chain(drones.iter().map(|shade| (name_of(*shade), *shade))).collect();
    let [mut light, mut dark, mut exchanged] = [const { String::new() }; 3];
    for (name, shade) in &named {
        // Writing to a string cannot fail.
        let _ = write!(light, "{name}:{};", hex(shade.light));
        let _ = write!(dark, "{name}:{};", hex(shade.dark));
    }
    for shade in drones.iter().filter(|shade| shade.light != shade.dark) {
        let (painted, name) = (hex(shade.light).to_uppercase(), name_of(*shade));
        for attribute in ["fill", "stroke"] {
            let _ = writeln!(
                exchanged,
                ".picture [{attribute}=\"{painted}\"]{{{attribute}:var({name})}}"
            );
        }
    }
    format!(
        ":root{{--link-weak:{};--link-strong:{};{light}}}\n\
         @media (prefers-color-scheme:dark){{:root{{{dark}}}\n{exchanged}}}\n",
        hex(WEAK),
        hex(STRONG)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::{MissionKind, NodeId};

    /// The least difference of two colours that stand in one picture, as distance in OKLab (Ottosson, 2020), in
    /// which 0.02 is just noticeable side by side.
    const LEAST: f64 = 0.1;
    /// The same for the links ramp's ends and middle, to eyes without green cones.
    const LEAST_OF_RAMP: f64 = 0.12;

    fn linear(RGBColor(r, g, b): RGBColor) -> [f64; 3] {
        [r, g, b].map(|part| {
            let part = f64::from(part) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { libm::pow((part + 0.055) / 1.055, 2.4) }
        })
    }

    fn times(matrix: [[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
    }

    fn oklab(linear: [f64; 3]) -> [f64; 3] {
        const CONES: [[f64; 3]; 3] = [
            [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
            [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
            [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
        ];
        const LAB: [[f64; 3]; 3] = [
            [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
            [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
            [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
        ];
        times(LAB, times(CONES, linear).map(libm::cbrt))
    }

    fn difference(one: [f64; 3], other: [f64; 3]) -> f64 {
        let [one, other] = [one, other].map(oklab);
        libm::sqrt(one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum())
    }

    /// What eyes without green cones see (Machado, Oliveira and Fernandes, 2009).
    fn without_green(colour: RGBColor) -> [f64; 3] {
        const DEUTERANOPIA: [[f64; 3]; 3] = [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ];
        times(DEUTERANOPIA, linear(colour)).map(|part| part.clamp(0.0, 1.0))
    }

    fn ramp(steps: u32) -> Vec<RGBColor> {
        let at = |step| f64::from(step) / f64::from(steps) * SPARE_DB + WEAK_DBM;
        (0..=steps).map(|step| link_colour(at(step), None)).collect()
    }

    #[test]
    fn all_that_stands_in_one_picture_differs_on_light_and_dark_ground() {
        let meanings: Vec<Shade> =
            [HEAD, BASE, BEAM, FRONTIER, KNOWN].into_iter().chain(RELAYS).collect();
        for ground in [|shade: &Shade| shade.light, |shade: &Shade| shade.dark] {
            let colours: Vec<RGBColor> = meanings.iter().map(ground).collect();
            for (n, one) in colours.iter().enumerate() {
                let links = ramp(12);
                for other in colours[n + 1..].iter().chain(&links) {
                    let apart = difference(linear(*one), linear(*other));
                    assert!(apart >= LEAST, "{one:?} and {other:?}: {apart:.3}");
                }
            }
        }
    }

    #[test]
    fn links_by_strength_differ_to_eyes_without_green_cones() {
        let stops = ramp(2);
        for (n, one) in stops.iter().enumerate() {
            for other in &stops[n + 1..] {
                let apart = difference(without_green(*one), without_green(*other));
                assert!(apart >= LEAST_OF_RAMP, "{one:?} and {other:?}: {apart:.3}");
            }
        }
    }

    #[test]
    fn links_are_weak_at_the_limit_and_strong_15_db_above_it() {
        assert_eq!(link_colour(-90.0, Some(-70.0)), WEAK);
        assert_eq!(link_colour(-70.0, Some(-70.0)), WEAK);
        assert_eq!(link_colour(-55.0, Some(-70.0)), STRONG);
        assert_eq!(link_colour(-85.0, None), WEAK);
    }

    #[test]
    fn the_report_knows_the_colours_of_all_drones_on_both_grounds() {
        let style = style();
        for number in 0..=15 {
            let role = if number == 0 { Role::Head } else { Role::Relay };
            let node = Node { id: NodeId(number), role, mission: MissionKind::Chain };
            let name = variable(&node).replace("var(", "").replace(')', ":");
            assert_eq!(style.matches(&name).count(), 2, "{name} in {style}");
        }
    }
}
