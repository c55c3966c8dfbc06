//! A positioning system beside the clients: its packets keep no client's order alive.

use onboard::Operator;
use units::Duration;

use crate::common::Net;
use crate::common::packets::task;

/// The position (0, 0, 0), as `send_extpos` sends it.
const POSITION: [u8; 13] = [0x6C, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

#[test]
fn an_order_of_a_client_that_is_gone_ends_although_positions_come() {
    let mut net = Net::new(2, 0, 1);
    let base = net.base();
    net.client(base, &task(1));
    for _ in 0..15 {
        net.client(base, &POSITION);
        net.run(Duration::from_millis(200));
    }
    assert_eq!(net.nodes[base].drone.operator(), Operator::Hover);
}
