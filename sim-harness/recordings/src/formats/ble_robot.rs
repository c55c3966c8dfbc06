//! The raw packets of six BLE and UWB anchors round a robot in a flat.
//!
//! Tab-separated integers, one row per second and anchor: `unix_ms, anchor, sequence, bytes,
//! pressure, n_ble, n_uwb`, then eight for each BLE packet (`receiver, tag, tick, rssi, pressure,
//! millivolts, steps, alert`) and four for each UWB packet, which are ignored. A link is one of the
//! two receivers of one anchor: their antennas are perpendicular to each other.
//!
//! Beside the log lie the anchors' positions (`anchors.csv`) and where the robot was
//! (`…_df.csv` for `…_ble.txt`). How each of the three was understood is told in the book's
//! chapter "Replay".

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use input::InputError;
use units::{Dbm, Duration, Instant, MetresPerSecond};

use super::table::Table;
use super::{Position, distance, instant, lines, number, read_companion, received};
use crate::recording::{Anomaly, Clock, Ends, RadialSpeed, Recorder, Recording};

const PER_BLE: usize = 8;
const PER_UWB: usize = 4;

/// The tag's height on its pole above the robot (the data set's description).
const TAG_HEIGHT: f64 = 1.3;

/// The robot drives at 0.15 m/s and turns on the spot with the tag 0.14 m off the axis.
const FASTEST: MetresPerSecond = MetresPerSecond(5.0);

/// The files beside the log: anchors and poses.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    /// The anchors, by their numbers in the log.
    anchors: BTreeMap<i64, Position>,
    track: Track,
}

/// The positions of the tag, in order of time.
#[derive(Debug, Default)]
struct Track {
    tag: Vec<(Instant, [f64; 2])>,
}

impl Track {
    /// The age at which a position is no longer used: three poses come in a second.
    const FRESH: Duration = Duration::from_secs(2);

    /// The latest position that was known at `now`.
    fn at(&self, now: Instant) -> Option<Position> {
        let known = self.tag.partition_point(|(time, _)| *time <= now);
        let (time, [x, y]) = self.tag.get(known.checked_sub(1)?)?;
        (now.since(*time) <= Self::FRESH).then_some([*x, *y, TAG_HEIGHT])
    }
}

pub(super) fn is_row(row: &str) -> bool {
    Row::read(row).is_ok()
}

struct Packet {
    receiver: i64,
    tick: u16,
    rssi: i64,
}

struct Row {
    time: Instant,
    anchor: i64,
    packets: Vec<Packet>,
}

impl Row {
    fn read(row: &str) -> Result<Self, Anomaly> {
        let fields: Option<Vec<i64>> =
            row.trim().split('\t').map(|field| field.trim().parse().ok()).collect();
        let fields = fields.ok_or(Anomaly::NotANumber)?;
        let [unix_ms, anchor, _, _, _, ble, uwb, rest @ ..] = fields.as_slice() else {
            return Err(Anomaly::RowLength);
        };
        // One byte each on the air.
        let count = |n: i64| u8::try_from(n).map(usize::from).map_err(|_| Anomaly::RowLength);
        let (ble, uwb) = (count(*ble)? * PER_BLE, count(*uwb)? * PER_UWB);
        let packets = rest.get(..ble).filter(|_| rest.len() == ble + uwb);
        Ok(Self {
            time: instant(*unix_ms as f64 / 1e3).ok_or(Anomaly::NotANumber)?,
            anchor: *anchor,
            packets: packets
                .ok_or(Anomaly::RowLength)?
                .chunks_exact(PER_BLE)
                .map(Packet::read)
                .collect::<Option<_>>()
                .ok_or(Anomaly::NotANumber)?,
        })
    }
}

impl Packet {
    fn read(fields: &[i64]) -> Option<Self> {
        let [receiver, _, tick, rssi, ..] = fields else { return None };
        // Milliseconds in 16 bits, written with their bytes the wrong way round.
        let tick = u16::try_from(*tick).ok()?.swap_bytes();
        Some(Self { receiver: *receiver, tick, rssi: *rssi })
    }
}

/// Turns an anchor's ticks into times: its rows are up to a second younger than their packets.
#[derive(Clone, Copy, Default)]
struct Ticks {
    latest: Option<(u16, Instant)>,
}

impl Ticks {
    /// A clock that is off by more than this has been reset.
    const OFF: Duration = Duration::from_secs(2);

    /// The packets' times, in their order; the row was written at `written`.
    fn times(&mut self, packets: &[Packet], written: Instant) -> Vec<Instant> {
        let Some(first) = packets.first() else { return Vec::new() };
        let (tick, time) = self.latest.unwrap_or((first.tick, written));
        let passed = |packet: &Packet| i64::from(packet.tick.wrapping_sub(tick) as i16);
        let newest = packets.iter().map(passed).max().unwrap_or(0);
        let expected = shifted(time, newest);
        let off = expected.since(written).max(written.since(expected));
        let reset = self.latest.is_none() || off > Self::OFF;
        let now = if reset { written } else { expected };
        self.latest = Some((tick.wrapping_add_signed(newest as i16), now));
        packets.iter().map(|packet| shifted(now, passed(packet) - newest)).collect()
    }
}

fn shifted(time: Instant, ms: i64) -> Instant {
    let span = Duration::from_millis(ms.unsigned_abs());
    if ms < 0 { time - span } else { time + span }
}

#[derive(Default)]
struct Anchor {
    clock: Clock,
    ticks: Ticks,
    speeds: BTreeMap<i64, RadialSpeed>,
}

pub(super) fn parse(bytes: &[u8], surroundings: &Surroundings) -> Recording {
    let mut recorder = Recorder::default();
    let mut anchors: BTreeMap<i64, Anchor> = BTreeMap::new();
    for (line, row) in lines(bytes) {
        recorder.row();
        let row = match Row::read(&row) {
            Ok(row) => row,
            Err(anomaly) => {
                recorder.anomaly(anomaly, line);
                continue;
            }
        };
        // The anchors' rows arrive in no order, so each is held to its own clock.
        let anchor = anchors.entry(row.anchor).or_default();
        if !recorder.clock_is_sound(&mut anchor.clock, row.time, line) {
            continue;
        }
        let times = anchor.ticks.times(&row.packets, row.time);
        let mut heard: Vec<(Instant, &Packet)> = times.into_iter().zip(&row.packets).collect();
        heard.sort_by_key(|(time, _)| *time);
        for (time, packet) in heard {
            match received(packet.rssi as f64) {
                Some(rssi) => {
                    let place = Place { line, time, anchor: row.anchor };
                    record(&mut recorder, &place, packet, rssi, anchor, surroundings);
                }
                None => recorder.anomaly(Anomaly::ImpossibleRssi, line),
            }
        }
    }
    recorder.finish()
}

struct Place {
    line: usize,
    time: Instant,
    anchor: i64,
}

fn record(
    recorder: &mut Recorder,
    &Place { line, time, anchor: number }: &Place,
    packet: &Packet,
    rssi: Dbm,
    anchor: &mut Anchor,
    surroundings: &Surroundings,
) {
    let position = surroundings.anchors.get(&number);
    if position.is_none() {
        recorder.anomaly(Anomaly::UnknownReceiver, line);
    }
    let ends = position
        .zip(surroundings.track.at(time))
        .map(|(position, tag)| Ends { distance: distance(position, &tag), moving: tag });
    let speeds = &mut anchor.speeds;
    let speed = ends.map(|ends| speeds.entry(packet.receiver).or_default().at(time, ends.distance));
    let separating = speed.filter(|speed| speed.abs() <= FASTEST);
    if separating != speed {
        recorder.anomaly(Anomaly::ImpossibleMotion, line);
    }
    let link = recorder.link(&format!("{number}.{}", packet.receiver));
    recorder.sample(line, time, link, rssi, separating, ends);
}

/// Reads the two files that belong to a log.
pub(super) fn surroundings_of(log: &Path, bytes: &[u8]) -> Result<Surroundings, InputError> {
    let beside = "the data set keeps it beside the log";
    let anchors = log.with_file_name("anchors.csv");
    let positions = positions(&read_companion(&anchors, beside)?, &anchors)?;
    let stem = log.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let poses = log.with_file_name(format!("{}_df.csv", stem.trim_end_matches("_ble")));
    let track = track(&read_companion(&poses, beside)?, &poses)?;
    let heard = lines(bytes).filter_map(|(_, row)| Row::read(&row).ok()).map(|row| row.anchor);
    Ok(Surroundings { anchors: identified(&heard.collect(), &positions), track })
}

/// Anchors by the numbers that the log calls them. The log has serial numbers (3, 4, 5, 8, 10, 11)
/// and the list of positions 1 to 6: they are in the same order, as the UWB arrival times show.
fn identified(
    heard: &BTreeSet<i64>,
    positions: &BTreeMap<i64, Position>,
) -> BTreeMap<i64, Position> {
    if heard.len() == positions.len() {
        heard.iter().copied().zip(positions.values().copied()).collect()
    } else {
        positions.clone()
    }
}

fn positions(bytes: &[u8], file: &Path) -> Result<BTreeMap<i64, Position>, InputError> {
    let table = Table::open(bytes, file, ["id", "x", "y", "z"], 4)?;
    let cell = |field: &Option<String>| number(field.as_deref()?);
    Ok(table
        .filter_map(|row| {
            let [id, x, y, z] = &row.fields;
            Some((id.as_deref()?.parse().ok()?, [cell(x)?, cell(y)?, cell(z)?]))
        })
        .collect())
}

/// The positions of the tag in the anchors' frame, from the robot's poses.
fn track(bytes: &[u8], file: &Path) -> Result<Track, InputError> {
    let table = Table::open(bytes, file, ["ts", "x", "y", "heading"], 4)?;
    let cell = |field: &Option<String>| number(field.as_deref()?);
    let mut tag: Vec<(Instant, [f64; 2])> = table
        .filter_map(|row| {
            let [nanoseconds, x, y, heading] = &row.fields;
            let time = instant(cell(nanoseconds)? / 1e9)?;
            let pose = Pose { x: cell(x)?, y: cell(y)?, heading: cell(heading)? };
            Some((time, pose.tag(time)))
        })
        .collect();
    tag.sort_by_key(|(time, _)| *time);
    Ok(Track { tag })
}

/// The robot's lidar on its own map.
struct Pose {
    x: f64,
    y: f64,
    heading: f64,
}

impl Pose {
    /// The run whose poses are on the map that the robot drew; the others are in the flat's frame.
    const CALIB3: std::ops::Range<u64> = 1_628_001_500_000_000..1_628_001_900_000_000;
    /// The vector from the lidar to the tag, in the robot's frame.
    const LEVER: [f64; 2] = [-0.14, 0.01];
    /// The rotation of the robot's map in the flat: 179°.
    const TURN: f64 = 179.0;
    /// then shifted. All three by least squares from 17 rows that the data set also publishes in
    /// the flat's frame; they fit to 10 nm, so this is what its author did.
    const SHIFT: [f64; 2] = [0.460_769_44, 6.342_924_04];

    fn tag(&self, time: Instant) -> [f64; 2] {
        if !Self::CALIB3.contains(&time.as_micros()) {
            return [self.x, self.y];
        }
        let [ahead, aside] = turned(Self::LEVER, self.heading);
        let [x, y] = turned([self.x + ahead, self.y + aside], Self::TURN.to_radians());
        let [east, north] = Self::SHIFT;
        [x + east, y + north]
    }
}

fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(angle);
    [cos * x - sin * y, sin * x + cos * y]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_of_calib3_is_turned_by_179_degrees_about_the_lidar_and_no_other_is() {
        let pose = Pose { x: 1.0, y: 0.0, heading: 0.0 };
        let [x, y] = pose.tag(Instant::from_micros(Pose::CALIB3.start));
        // cos 179° · 0.86 − sin 179° · 0.01 + 0.46077, sin 179° · 0.86 + cos 179° · 0.01 + 6.34292.
        assert!((x + 0.399_274).abs() < 1e-5 && (y - 6.347_934).abs() < 1e-5, "{x} {y}");
        assert_eq!(pose.tag(Instant::from_micros(Pose::CALIB3.end)), [1.0, 0.0]);
    }

    #[test]
    fn ticks_survive_their_wrap_and_a_reset() {
        let packet = |tick| Packet { receiver: 1, tick, rssi: -60 };
        let mut ticks = Ticks::default();
        let at = Instant::from_millis;
        assert_eq!(
            ticks.times(&[packet(65_000), packet(65_300)], at(10_000)),
            [at(9_700), at(10_000)]
        );
        // 636 ms on by the anchor's clock, though the row came late.
        assert_eq!(ticks.times(&[packet(400)], at(11_500)), [at(10_636)]);
        assert_eq!(ticks.times(&[packet(40_000)], at(60_000)), [at(60_000)]);
    }

    #[test]
    fn serial_numbers_are_in_the_order_of_the_positions() {
        let positions = BTreeMap::from([(1, [1.0; 3]), (2, [2.0; 3])]);
        let named = identified(&BTreeSet::from([5, 11]), &positions);
        assert_eq!(named, BTreeMap::from([(5, [1.0; 3]), (11, [2.0; 3])]));
        // Too few receivers were heard to identify them but by their numbers.
        assert_eq!(identified(&BTreeSet::from([2]), &positions), positions);
    }
}
