//! What was sealed: whatever is taken is byte for byte what would have been sent, and says numbers.

use wire::p2p::{Task, Telemetry};

/// The bytes are an order; and telemetry.
pub fn check(data: &[u8]) {
    if let Ok(task) = Task::decode(data) {
        assert_eq!(task.encode(), data, "{task:?}");
        if let Task::Explore(speed) = task {
            assert!(speed.0.is_finite());
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
