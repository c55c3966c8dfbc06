//! Orders as the text of a command: one [`Order`] in 4 bytes.

use units::{Branch, Course, MetresPerSecond, Order};

use super::{Error, exactly, steps};

/// Bytes of an order in clear.
pub const ORDER: usize = 4;

/// Steps of the speed in one metre per second.
const SPEED: f32 = 1000.0;

/// The bytes of `order`, in clear:
///
/// | byte | type | field | what | unit |
/// |---|---|---|---|---|
/// | 0 | `u8` | `order` | 1 wait, 2 explore, 3 return, 4 land, 5 stop, 6 perch | |
/// | 1 | `i16` | `speed` | along the tunnel, 0 but for 2 | 1 mm/s |
/// | 3 | `u8` | `branch` | 0 none, 1 left, 2 right, 3 straight, at junctions, 0 but for 2 | |
#[must_use]
pub fn encode_order(order: Order) -> [u8; ORDER] {
    let (code, speed, branch) = match order {
        Order::Wait => (1, 0, 0),
        Order::Explore(Course { speed, branch }) => {
            (2, steps::short(speed.0 * SPEED), Branch::code(branch))
        }
        Order::Return => (3, 0, 0),
        Order::Land => (4, 0, 0),
        Order::Stop => (5, 0, 0),
        Order::Perch => (6, 0, 0),
    };
    let [s0, s1] = speed.to_le_bytes();
    [code, s0, s1, branch]
}

/// The order in these bytes.
///
/// # Errors
/// [`Error::Length`], [`Error::Code`] or [`Error::Reserved`].
pub fn decode_order(bytes: &[u8]) -> Result<Order, Error> {
    let [code, s0, s1, branch] = exactly::<ORDER>(bytes)?;
    let speed = i16::from_le_bytes([s0, s1]);
    let order = match code {
        1 => Order::Wait,
        2 => Order::Explore(Course {
            speed: MetresPerSecond(f32::from(speed) / SPEED),
            branch: steps::of_branch(branch)?,
        }),
        3 => Order::Return,
        4 => Order::Land,
        5 => Order::Stop,
        6 => Order::Perch,
        _ => return Err(Error::Code(code)),
    };
    match (order, speed, branch) {
        (Order::Explore(..), ..) | (_, 0, 0) => Ok(order),
        _ => Err(Error::Reserved),
    }
}
