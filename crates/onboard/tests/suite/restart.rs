//! A drone that begins another run in its place is as a new one.

use onboard::{Config, Drone, Setup, Start};
use units::{Duration, Instant, Metres, NodeId, Role};

use crate::common::{Clear, Net, packets};

/// A chain that has flown, with a client at its base.
fn flown() -> Net {
    let mut net = Net::new(3, 0, 1);
    net.client(net.base(), &packets::hover(0.2));
    net.run(Duration::from_secs(5));
    net
}

#[test]
fn a_drone_that_begins_another_run_is_as_a_new_one() {
    let mut net = flown();
    let mut config = Config::DEFAULT;
    config.agent.flight.height.0 += 0.1;
    let starts = [
        Start::OnGround,
        Start::AfterFault,
        Start::InAir { at: Instant::from_micros(7), flown: Metres(9.0) },
    ];
    for (start, stopped) in starts.into_iter().zip([false, true, false]) {
        let setup = Setup { start, stopped, ..Setup::new(NodeId(2), Role::Relay) };
        let new = Drone::<Clear>::new(config, &setup);
        for node in &mut net.nodes {
            node.drone.begin(config, &setup);
            assert_eq!(format!("{:?}", node.drone), format!("{new:?}"));
        }
        net = flown();
    }
}
