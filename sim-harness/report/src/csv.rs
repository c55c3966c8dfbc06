//! Writes `trace.csv`, with one row for each drone and frame, for spreadsheets, pandas and R.
//!
//! The columns are documented in the book, "What a run leaves behind". A field is empty where
//! there is no value: no link, no measurement. Numbers are rounded to a fixed count of decimals,
//! finer than any sensor, so that files compare byte for byte.

use std::io::{self, Write};

use mission::trace::{DroneFrame, Frame, LinkFrame, Node, Trace};

const HEADER: [&str; 28] = [
    "time_s",
    "node",
    "role",
    "state",
    "x_m",
    "y_m",
    "z_m",
    "yaw_rad",
    "edge",
    "along_m",
    "way_m",
    "forward_m_s",
    "left_m_s",
    "yaw_rate_rad_s",
    "range_nw_m",
    "range_ne_m",
    "range_sw_m",
    "range_se_m",
    "front_peer",
    "front_raw_dbm",
    "front_filtered_dbm",
    "front_true_dbm",
    "back_peer",
    "back_raw_dbm",
    "back_filtered_dbm",
    "back_true_dbm",
    "goal_x_m",
    "goal_y_m",
];

/// Writes the whole mission, frame by frame, head first, base last.
///
/// # Errors
/// The errors of `out`.
pub fn write(trace: &Trace, out: impl Write) -> io::Result<()> {
    let mut table = Table::new(out)?;
    for frame in &trace.frames {
        table.frame(trace, frame)?;
    }
    table.finish().map(drop)
}

/// The table of a mission that is still flown.
pub(super) struct Table<W: Write> {
    csv: ::csv::Writer<W>,
}

impl<W: Write> Table<W> {
    pub(super) fn new(out: W) -> io::Result<Self> {
        let mut csv = ::csv::Writer::from_writer(out);
        csv.write_record(HEADER)?;
        Ok(Self { csv })
    }

    /// Writes the rows of a frame.
    pub(super) fn frame(&mut self, trace: &Trace, frame: &Frame) -> io::Result<()> {
        let time = seconds(frame.time_us);
        for (node, drone) in trace.nodes.iter().zip(&frame.drones) {
            self.csv.write_record(row(&time, node, drone, trace))?;
        }
        Ok(())
    }

    pub(super) fn finish(self) -> io::Result<W> {
        self.csv.into_inner().map_err(::csv::IntoInnerError::into_error)
    }
}

fn row(time: &str, node: &Node, drone: &DroneFrame, trace: &Trace) -> Vec<String> {
    let mut row = vec![
        time.to_owned(),
        node.id.to_string(),
        node.role.name().to_owned(),
        drone.state.name().to_owned(),
    ];
    let at = drone.pose.at;
    row.extend([at.x, at.y, drone.height].map(|metres| number(metres, 4)));
    row.push(number(drone.pose.yaw.0, 4));
    row.push(trace.floor_plan.edge_name(drone.place).to_owned());
    row.extend([drone.place.along, drone.way].map(|metres| number(metres, 4)));
    row.extend(drone.commanded.map(|speed| number(speed, 4)));
    row.push(number(drone.yaw_rate, 4));
    row.extend(drone.ranges.map(|metres| number(metres, 3)));
    row.extend(link(drone.front.as_ref()));
    row.extend(link(drone.back.as_ref()));
    row.extend(
        drone
            .goal
            .map_or_else(Default::default, |goal| [goal.x, goal.y].map(|metres| number(metres, 4))),
    );
    row
}

fn link(link: Option<&LinkFrame>) -> [String; 4] {
    link.map_or_else(Default::default, |link| {
        [
            link.peer.to_string(),
            number(link.raw.0, 2),
            number(link.filtered.0, 2),
            number(link.truth.0, 2),
        ]
    })
}

/// Seconds with all six decimals: exact, where a float would not be.
fn seconds(micros: u64) -> String {
    format!("{}.{:06}", micros / 1_000_000, micros % 1_000_000)
}

/// Writes a number with fixed decimals: nothing for NaN, `inf` for infinity, and never `-0.000`,
/// which differs from `0.000` as text only.
fn number(value: f32, decimals: usize) -> String {
    if value.is_nan() {
        return String::new();
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(positive) if positive.bytes().all(|c| c == b'0' || c == b'.') => positive.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use units::{Point2, Pose2, Radians};

    use super::*;
    use crate::synthetic;
    use world::SkeletonPlace;

    fn written(trace: &Trace) -> String {
        let mut bytes = Vec::new();
        write(trace, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn there_is_one_full_row_for_each_drone_and_frame() {
        let trace = synthetic::mission();
        let text = written(&trace);
        let mut reader = ::csv::Reader::from_reader(text.as_bytes());
        assert_eq!(reader.headers().unwrap().len(), HEADER.len());
        let rows = reader.records().map(Result::unwrap).count();
        assert_eq!(rows, trace.frames.len() * trace.nodes.len());
    }

    #[test]
    fn what_is_not_known_is_an_empty_field() {
        let mut trace = synthetic::mission();
        trace.frames.truncate(1);
        trace.frames[0].time_us = 1_200_001;
        trace.nodes.truncate(1);
        trace.frames[0].drones.truncate(1);
        trace.frames[0].drones[0] = DroneFrame {
            pose: Pose2 { at: Point2::new(1.0, -0.000_01), yaw: Radians(0.25) },
            height: 0.5,
            place: SkeletonPlace::main(3.0),
            way: 2.5,
            commanded: [0.2, -0.1],
            yaw_rate: 0.0,
            ranges: [f32::INFINITY, f32::NAN, 1.2341, 0.5],
            state: agent::State::Idle,
            battery_v: f32::NAN,
            goal: Some(Point2::new(2.0, -1.25)),
            target: None,
            front: None,
            back: None,
        };
        let text = written(&trace);
        let row = text.lines().nth(1).unwrap();
        let expected = "1.200001,0,head,idle,1.0000,0.0000,0.5000,0.2500,main,3.0000,2.5000,0.2000,\
                        -0.1000,0.0000,inf,,1.234,0.500,,,,,,,,,2.0000,-1.2500";
        assert_eq!(row, expected);
    }
}
