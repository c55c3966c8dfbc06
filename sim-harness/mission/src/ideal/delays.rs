//! How long reports and orders take over the exact link: a table of what was measured.
//!
//! `cargo sim bench link --runs 20 --json` measures it again: `report_delay_s` and `order_delay_s`
//! of each row are the deciles of delays, from one drone's agent to the other's, without the time
//! for which they lie in the mailbox. It was measured with the seeds 1 to 20, in chains of 2 to 15
//! drones that stand still, each of which hears the next and no other.
//!
//! A report is sent in the next turn of its sender and not repeated, so its delay depends on where
//! the sender's rounds lie in its frame, which does not change over a mission. Neither the loss
//! nor the length of the chain moved a decile of all reports by more than 8 ms, but for the upper
//! two, which they moved by up to 14 and 29 ms, so there is one row of them. An order is repeated
//! until it is heard, hop by hop: its delay grows with both.

/// The least delay, those that each further tenth of all did not exceed, and the greatest, ms.
pub type Deciles = [f32; 11];

/// Reports, in all chains at all losses.
pub const REPORTS: Deciles = [1.0, 3.0, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0, 25.0, 34.0, 62.0];

/// The parts of all packets that were lost on each link.
const LOSSES: [f32; 4] = [0.0, 0.2, 0.5, 0.7];
/// The numbers of hops from base to head.
const HOPS: [f32; 4] = [2.0, 4.0, 8.0, 15.0];
/// Orders to the head, by [`HOPS`] and by [`LOSSES`].
const ORDERS: [[[u16; 11]; LOSSES.len()]; HOPS.len()] = [
    // 2 hops
    [
        [4, 11, 14, 15, 18, 22, 25, 26, 30, 40, 57],
        [4, 12, 15, 16, 21, 24, 26, 29, 35, 42, 91],
        [4, 14, 16, 23, 28, 33, 44, 50, 56, 67, 181],
        [4, 16, 28, 41, 50, 55, 66, 84, 90, 117, 227],
    ],
    // 4 hops
    [
        [17, 28, 31, 36, 40, 41, 41, 55, 59, 68, 108],
        [17, 29, 33, 37, 40, 41, 55, 59, 68, 75, 166],
        [17, 36, 41, 58, 66, 72, 80, 96, 105, 128, 254],
        [18, 62, 77, 94, 103, 121, 134, 154, 171, 203, 359],
    ],
    // 8 hops
    [
        [43, 46, 48, 56, 65, 68, 69, 71, 74, 81, 96],
        [43, 47, 50, 66, 68, 71, 74, 83, 94, 110, 205],
        [43, 72, 88, 107, 116, 131, 145, 161, 175, 203, 345],
        [44, 134, 169, 187, 207, 230, 246, 269, 291, 330, 506],
    ],
    // 15 hops
    [
        [100, 112, 117, 121, 124, 127, 132, 135, 137, 146, 169],
        [100, 116, 122, 127, 132, 136, 146, 162, 173, 195, 300],
        [103, 170, 194, 216, 231, 244, 263, 275, 296, 330, 495],
        [124, 294, 339, 370, 395, 425, 447, 475, 511, 558, 826],
    ],
];

/// The delays at the loss of one mission.
#[derive(Clone, Debug)]
pub(super) struct Delays {
    /// By number of hops.
    orders: Vec<Deciles>,
}

impl Delays {
    /// The delays of orders over up to `hops` hops, at this loss.
    pub(super) fn of(loss: f32, hops: usize) -> Self {
        Self { orders: (0..=hops).map(|hops| order_deciles(loss, hops as f32)).collect() }
    }

    /// The delay of all reports of a drone, in microseconds, by a number uniform in [0, 1).
    pub(super) fn report_us(luck: f32) -> u64 {
        draw(&REPORTS, luck)
    }

    /// The delay of an order over so many hops, in microseconds, by a number uniform in [0, 1).
    pub(super) fn order_us(&self, hops: usize, luck: f32) -> u64 {
        self.orders.get(hops).map_or(0, |deciles| draw(deciles, luck))
    }
}

/// The deciles of orders between the losses and the hops that were measured.
#[must_use]
pub fn order_deciles(loss: f32, hops: f32) -> Deciles {
    let (row, along) = bracket(&HOPS, hops);
    let (column, across) = bracket(&LOSSES, loss);
    std::array::from_fn(|n| {
        let of = |row: usize| {
            let [low, high] = [column, column + 1].map(|at| f32::from(ORDERS[row][at][n]));
            low + across * (high - low)
        };
        of(row) + along * (of(row + 1) - of(row))
    })
}

/// Between which two of these values another lies, and how far on the way from one to the other; a
/// value beyond all counts as the last.
fn bracket(values: &[f32; 4], value: f32) -> (usize, f32) {
    let at = values.iter().take(3).rposition(|low| *low <= value).unwrap_or(0);
    let [low, high] = [values[at], values[at + 1]];
    (at, ((value - low) / (high - low)).clamp(0.0, 1.0))
}

/// The delay in microseconds below which this part of all lies.
fn draw(deciles: &Deciles, part: f32) -> u64 {
    let tenths = part * 10.0;
    let at = (tenths as usize).min(9);
    let [from, to] = [deciles[at], deciles[at + 1]];
    ((from + (tenths - at as f32) * (to - from)) * 1e3) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_the_rows_delays_are_between_theirs() {
        assert_eq!(order_deciles(0.2, 4.0)[0], f32::from(ORDERS[1][1][0]));
        let middle = f32::midpoint(f32::from(ORDERS[1][1][5]), f32::from(ORDERS[2][1][5]));
        assert!((order_deciles(0.2, 6.0)[5] - middle).abs() < 1e-3);
        assert_eq!(order_deciles(0.9, 16.0)[10], f32::from(ORDERS[3][3][10]));
        assert_eq!(draw(&REPORTS, 0.0), (REPORTS[0] * 1e3) as u64);
    }
}
