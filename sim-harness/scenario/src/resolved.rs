//! Writes a scenario with all its keys, those of the defaults included, as a file that reads back to the
//! same mission.

use radio_model::{Attenuation, PathLoss, Walls};
use toml::{Table, Value};
use units::{Duration, MissionKind};
use wire::radio::Datarate;

use super::{RadioSpec, Scenario, Start, VehicleSpec};

/// The text of the scenario's file.
pub(super) fn text(scenario: &Scenario) -> String {
    let mut file = Table::clone(&scenario.source);
    file.insert("duration_s".into(), seconds(scenario.duration_us));
    if let Some(depth_m) = scenario.depth_m {
        file.insert("depth_m".into(), number(depth_m));
    }
    for (key, name) in [
        ("fidelity", scenario.fidelity.name()),
        ("link", scenario.link.name()),
        ("mission", scenario.mission.name()),
    ] {
        file.insert(key.into(), name.into());
    }
    put(&mut file, "radio", radio(&scenario.radio));
    put(&mut file, "vehicle", vehicle(&scenario.vehicle));
    put(&mut file, "drones", drones(scenario));
    put(&mut file, "policy", policy(scenario));
    put(&mut file, "launch", launch(scenario));
    put(&mut file, "retreat", retreat(scenario));
    let ground = [("light", scenario.ground.light), ("texture", scenario.ground.texture)];
    put(&mut file, "ground", ground.map(|(key, value)| (key, number(value))).to_vec());
    match scenario.mission {
        MissionKind::Chain => {}
        MissionKind::Swarm => put(&mut file, "swarm", swarm(scenario)),
        MissionKind::Explore => put(&mut file, "explore", explore(scenario)),
    }
    pilot(&mut file, scenario);
    file.to_string()
}

type Keys = Vec<(&'static str, Value)>;

/// Puts the keys into a table of the file.
fn put(file: &mut Table, name: &str, keys: Keys) {
    let table = file.entry(name).or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(table) = table {
        table.extend(keys.into_iter().map(|(key, value)| (key.to_owned(), value)));
    }
}

/// A number by its shortest decimals, so that 0.1 stays 0.1.
fn number(value: f32) -> Value {
    Value::Float(value.to_string().parse().unwrap_or(f64::from(value)))
}

fn seconds(us: u64) -> Value {
    Value::Float(us as f64 / 1e6)
}

fn span(span: Duration) -> Value {
    seconds(span.as_micros())
}

fn radio(radio: &RadioSpec) -> Keys {
    let RadioSpec { place, reception, fades, .. } = radio;
    let mut keys = vec![
        ("loss_at_1m_db", number(place.path_loss.loss_at_1m().0)),
        ("noise_variance_db2", number(reception.noise_variance)),
        ("resolution_db", number(reception.resolution.0)),
        ("packet_loss", number(reception.loss_rate)),
        ("sensitivity_dbm", number(reception.sensitivity.0)),
        ("fade_share", number(fades.share)),
        ("fade_s", span(fades.mean)),
        ("gain_error_db", number(radio.gain_error.0)),
        ("ground_loss_db", number(radio.ground_loss.0)),
        ("polling_hz", number(radio.polling_hz)),
        ("latency_s", seconds(radio.latency_us)),
        ("place_seed", Value::Integer(i64::try_from(place.seed).unwrap_or(i64::MAX))),
    ];
    let datarate = match radio.datarate {
        Datarate::Kbit250 => "250K",
        Datarate::Mbit1 => "1M",
        Datarate::Mbit2 => "2M",
    };
    keys.push(("datarate", datarate.into()));
    if let PathLoss::UChain(law) = &place.path_loss {
        let attenuation = match law.attenuation {
            Attenuation::WallCount => "wall-count",
            Attenuation::RockDepth => "rock-depth",
        };
        let walls = match law.walls {
            Walls::Rock => "rock",
            Walls::Paper => "paper",
            Walls::Leaky => "leaky",
        };
        keys.extend([("attenuation", attenuation.into()), ("walls", walls.into())]);
    }
    keys
}

fn vehicle(vehicle: &VehicleSpec) -> Keys {
    let mut keys = vec![
        ("charge", number(vehicle.charge)),
        ("lag_s", number(vehicle.lag)),
        ("flow_noise_mps", number(vehicle.flow_noise)),
        ("flow_scale_error", number(vehicle.flow_scale_error)),
        ("radius_m", number(vehicle.radius)),
        ("reach_m", number(vehicle.reach)),
        ("range_noise_m", number(vehicle.range_noise)),
        ("sees_cones", vehicle.sees_cones.into()),
        ("sees_drones", vehicle.sees_drones.into()),
        ("vibration_g", number(vehicle.vibration)),
        ("thrust", number(vehicle.thrust)),
        ("motor_error", number(vehicle.motor_error)),
        ("battery_ohm", number(vehicle.battery_ohm)),
        ("yaw_torque_nm", Value::Array(vehicle.yaw_torque.map(number).to_vec())),
    ];
    let usual = VehicleSpec::DEFAULT;
    let tilts = vehicle.tilt_torque.into_iter().zip(usual.tilt_torque);
    for (name, (torque, usual)) in ["roll_torque_nm", "pitch_torque_nm"].into_iter().zip(tilts) {
        if torque != usual {
            keys.push((name, Value::Array(torque.map(number).to_vec())));
        }
    }
    if vehicle.lateral_noise != usual.lateral_noise {
        keys.push(("lateral_noise_mps2", number(vehicle.lateral_noise)));
    }
    // Without the key there is no positioning system.
    keys.extend(vehicle.position_noise.map(|noise| ("position_noise_m", number(noise))));
    keys
}

fn drones(scenario: &Scenario) -> Keys {
    let drones = &scenario.drones;
    let count = |count: usize| Value::Integer(i64::try_from(count).unwrap_or(i64::MAX));
    let start = match drones.start {
        Start::Mouth => "mouth",
        Start::Random { .. } => "random",
        Start::Placed(_) => "placed",
    };
    vec![
        ("explorers", count(drones.explorers)),
        ("relays", count(drones.relays)),
        ("start", start.into()),
        ("fetched", drones.fetched.into()),
    ]
}

fn policy(scenario: &Scenario) -> Keys {
    vec![
        ("name", scenario.policy.as_str().into()),
        ("loss_at_1m_db", number(scenario.assumed_loss_at_1m.0)),
    ]
}

fn launch(scenario: &Scenario) -> Keys {
    let launch = &scenario.agent.launch;
    let mut keys = vec![
        ("limit_dbm", number(launch.limit.0)),
        ("hold_s", span(launch.hold)),
        ("patience_s", span(launch.patience)),
        ("arm_delay_s", span(launch.arm_delay)),
    ];
    keys.extend(launch.settled.map(|settled| ("settled_db", number(settled.0))));
    keys
}

fn retreat(scenario: &Scenario) -> Keys {
    let retreat = &scenario.agent.retreat;
    vec![
        ("limit_dbm", number(retreat.limit.0)),
        ("speed_mps", number(retreat.speed.0)),
        ("max_time_s", span(retreat.max_time)),
        ("max_distance_m", number(retreat.max_distance.0)),
        ("longest_m", number(retreat.longest.0)),
    ]
}

fn pair(x: f32, y: f32) -> Value {
    Value::Array(vec![number(x), number(y)])
}

fn swarm(scenario: &Scenario) -> Keys {
    let swarm = &scenario.agent.swarm;
    vec![
        ("corner_m", pair(swarm.corner.x, swarm.corner.y)),
        ("area_m", pair(swarm.area.0.0, swarm.area.1.0)),
        ("entrance_m", pair(swarm.passage.entrance.x, swarm.passage.entrance.y)),
        ("width_m", number(swarm.passage.width.0)),
        ("length_m", number(swarm.passage.length.0)),
        ("speed_mps", number(swarm.speed.0)),
    ]
}

fn explore(scenario: &Scenario) -> Keys {
    let explore = &scenario.agent.explore;
    vec![
        ("corner_m", pair(explore.corner.x, explore.corner.y)),
        ("area_m", pair(explore.area.0.0, explore.area.1.0)),
        ("start_m", pair(explore.start.at.x, explore.start.at.y)),
        ("speed_mps", number(explore.speed.0)),
    ]
}

/// The times of the operator's orders, which a map's own mission moves.
fn pilot(file: &mut Table, scenario: &Scenario) {
    let Some(Value::Array(steps)) = file.get_mut("pilot") else { return };
    for (step, order) in steps.iter_mut().zip(&scenario.pilot) {
        if let Value::Table(step) = step {
            step.insert("at_s".into(), seconds(order.at_us));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Changes, Scenario, builtin};
    use maps::MapChoice;

    /// Everything but where it was read from.
    fn same(one: &Scenario, other: &Scenario) {
        let told = |scenario: &Scenario| {
            let bare =
                Scenario { source: Default::default(), name: String::new(), ..scenario.clone() };
            format!("{bare:?}")
        };
        assert!(told(one) == told(other), "{}:\n{}\n{}", one.name, told(one), told(other));
    }

    #[test]
    fn every_built_in_scenario_reads_back_to_the_same_mission() {
        for name in builtin::names() {
            let scenario = Scenario::open(name).unwrap();
            let text = scenario.resolved();
            let again = Scenario::of_text(std::path::Path::new("again.toml"), &text).unwrap();
            same(&scenario, &again);
            assert_eq!(again.resolved(), text, "{name}");
        }
    }

    #[test]
    fn a_maps_own_mission_reads_back_from_another_folder() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/caves/crooked.svx").into();
        let map = MapChoice { file, ..MapChoice::default() };
        let scenario = Scenario::of_map(map, Some(2), Vec::new()).unwrap();
        let text = scenario.resolved();
        let again =
            Scenario::of_text(std::path::Path::new("/elsewhere/again.toml"), &text).unwrap();
        same(&scenario, &again);
    }

    #[test]
    fn what_was_changed_is_in_it() {
        let changes = Changes { relays: Some(1), ..Changes::default() };
        let scenario = Scenario::open_with("demo", &changes).unwrap().with_policy("t5").unwrap();
        let text = scenario.resolved();
        for line in ["relays = 1", "name = \"t5\"", "packet_loss = 0.2", "lag_s = 0.3"] {
            assert!(text.lines().any(|found| found == line), "no {line:?} in\n{text}");
        }
    }
}
