//! Conversions between quantities and whole steps, which several messages share.

use units::{Branch, Dbm, NODES, NodeId, Volts};

/// Steps of each quantity in one of its unit.
const POWER: f32 = 4.0;
const VOLTAGE: f32 = 50.0;

/// The nearest whole number, ties away from zero. A conversion by `as` saturates, and makes zero of
/// NaN.
pub(super) fn nearest(number: f32) -> i32 {
    (number + if number < 0.0 { -0.5 } else { 0.5 }) as i32
}

/// The nearest whole number between `least` and `most`.
pub(super) fn within(number: f32, least: i32, most: i32) -> i32 {
    nearest(number).clamp(least, most)
}

/// The nearest whole number of two bytes with a sign.
pub(super) fn short(number: f32) -> i16 {
    within(number, i16::MIN.into(), i16::MAX.into()) as i16
}

/// The number, unless it is NaN.
pub(super) fn number(number: f32) -> Option<f32> {
    (!number.is_nan()).then_some(number)
}

/// A signal strength, to ¼ dBm; none for NaN.
pub(super) fn quarters(power: Dbm) -> Option<i16> {
    number(power.0).map(|power| short(power * POWER))
}

pub(super) fn of_quarters(steps: i16) -> Dbm {
    Dbm(f32::from(steps) / POWER)
}

/// An unfiltered signal strength, to 1 dBm. NaN counts as the weakest.
pub(super) fn weakness(power: Dbm) -> u8 {
    number(power.0).map_or(u8::MAX, |power| within(-power, 0, u8::MAX.into()) as u8)
}

pub(super) fn of_weakness(weakness: u8) -> Dbm {
    // Not `-0.0`, whose bits differ from those of zero.
    Dbm(0.0 - f32::from(weakness))
}

/// A voltage, to 20 mV; zero for none.
pub(super) fn voltage(battery: Option<Volts>) -> u8 {
    let volts = battery.and_then(|battery| number(battery.0));
    volts.map_or(0, |volts| within(volts * VOLTAGE, 1, u8::MAX.into()) as u8)
}

pub(super) fn of_voltage(steps: u8) -> Option<Volts> {
    (steps != 0).then(|| Volts(f32::from(steps) / VOLTAGE))
}

/// The number by which a node is named on the air, if it can be.
pub(super) fn name(node: NodeId) -> Option<u8> {
    (usize::from(node.0) < NODES).then_some(node.0)
}

/// The nearest number by which a node can be named on the air.
pub(super) fn nearest_name(node: NodeId) -> u8 {
    name(node).unwrap_or(NODES as u8 - 1)
}

/// The node with this number on the air, if there is one.
pub(super) fn of_name(name: u8) -> Result<NodeId, super::Error> {
    if usize::from(name) < NODES { Ok(NodeId(name)) } else { Err(super::Error::Reserved) }
}

/// The choice at junctions with this code.
pub(super) fn of_branch(code: u8) -> Result<Option<Branch>, super::Error> {
    Branch::from_code(code).ok_or(super::Error::Code(code))
}
