//! Fills in the messages of our own from the frames of a trace.

use recordings::messages::{DroneState, Link};

use mission::trace::{DroneFrame, LinkFrame};

/// The message of one link.
pub(super) fn link(link: &LinkFrame) -> Link {
    Link {
        peer: u32::from(link.peer.0),
        raw_dbm: link.raw.0,
        filtered_dbm: link.filtered.0,
        true_dbm: link.truth.0,
    }
}

/// The message of one drone.
pub(super) fn drone_state(drone: &DroneFrame) -> DroneState {
    let [x_m, y_m, z_m] = super::scene::spatial(drone);
    let [forward_m_s, left_m_s] = drone.commanded;
    let [nw, ne, sw, se] = drone.ranges.map(|range| Some(range).filter(|r| r.is_finite()));
    DroneState {
        state: drone.state.name().to_owned(),
        x_m,
        y_m,
        z_m,
        yaw_rad: drone.pose.yaw.0,
        way_m: drone.way,
        forward_m_s,
        left_m_s,
        yaw_rate_rad_s: drone.yaw_rate,
        range_nw_m: nw,
        range_ne_m: ne,
        range_sw_m: sw,
        range_se_m: se,
    }
}
