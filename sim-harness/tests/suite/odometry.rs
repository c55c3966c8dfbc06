//! A drone's own reckoning of where it is, held against where it is.

use sim_harness::mission::Mission;
use sim_harness::scenario::builtin;
use units::{Point2, Pose2};

/// `pose` as seen from `origin`.
fn seen_from(origin: Pose2, pose: Pose2) -> Pose2 {
    let (east, north) = (pose.at.x - origin.at.x, pose.at.y - origin.at.y);
    let (sin, cos) = origin.yaw.sin_cos();
    Pose2 {
        at: Point2::new(east * cos + north * sin, north * cos - east * sin),
        yaw: (pose.yaw - origin.yaw).wrapped(),
    }
}

/// Round right angles and back again, at point level. Three standard deviations are allowed: of the
/// scale of the optic flow, and of its noise, which walks by σ·√(time · round) metres, 0.14 m in the
/// four minutes.
#[test]
fn a_drone_knows_where_it_is_as_seen_from_its_take_off() {
    let scenario = builtin::find("turns").unwrap().unwrap();
    let world = scenario.world();
    let vehicle = &scenario.vehicle;
    for seed in 1..=5 {
        let mut mission = Mission::new(&scenario, &world, seed);
        let mut origins = [None; 2];
        let mut farthest = 0.0f32;
        while !mission.is_over() {
            mission.round();
            let seconds = mission.time_us() as f32 * 1e-6;
            let walk = vehicle.flow_noise * (seconds * 0.2).sqrt();
            for (n, origin) in origins.iter_mut().enumerate() {
                let view = mission.view(n).unwrap();
                let status = view.outputs.unwrap().status;
                if !status.state.is_airborne() {
                    continue;
                }
                let truth = seen_from(*origin.get_or_insert(view.body.pose()), view.body.pose());
                let away = truth.at.distance(Point2::default()).0;
                farthest = farthest.max(away);
                let pose = status.here.pose;
                let off = pose.at.distance(truth.at).0;
                let most = 3.0 * (walk + vehicle.flow_scale_error * away);
                assert!(off <= most + 0.05, "seed {seed}, drone {n}: {pose:?} is {truth:?}");
                // The nose has turned since the round in which the drone sensed.
                let turned = (pose.yaw - truth.yaw).wrapped().0;
                assert!(turned.abs() < 0.25, "seed {seed}, drone {n}: {turned}");
            }
        }
        assert!(farthest > 5.0, "seed {seed}: {farthest} m");
    }
}
