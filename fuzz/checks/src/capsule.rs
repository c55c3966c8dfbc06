//! The text of opened capsules: what is accepted is byte for byte what would have been sent, and
//! its numbers are finite.

use units::Order;
use wire::p2p::Telemetry;

/// Decodes the bytes as an order and as telemetry.
pub fn check(data: &[u8]) {
    if let Ok(task) = wire::p2p::decode_order(data) {
        assert_eq!(wire::p2p::encode_order(task), data, "{task:?}");
        if let Order::Explore(course) = task {
            assert!(course.speed.0.is_finite());
        }
    }
    if let Ok(telemetry) = Telemetry::decode(data) {
        assert_eq!(telemetry.encode(), data, "{telemetry:?}");
        assert!(telemetry.odometer.0.is_finite() && telemetry.velocity.0.is_finite());
        for (_, link) in [telemetry.front, telemetry.back].into_iter().flatten() {
            assert!(link.0.is_finite());
        }
    }
}
