//! The node beside a served mission: frames go out as messages, messages come in as packets.

use std::io;

use crtp::{OperatorTask, ParameterId};
use input::InputError;
use mission::trace::{Frame, Trace};
use report::bag::{Messages, Place};
use ros2_topics::{Commands, Node};
use scenario::Scenario;
use units::{Metres, MetresPerSecond, RadiansPerSecond};
use wire::crtp::{Packet, ParamRequest, Request, Setpoint};

/// A node of ROS 2 beside the clients of a served mission.
pub struct Companion {
    node: Node,
    commands: Commands,
    messages: Messages,
    /// The height of the drones of the mission, which a set-point repeats.
    height: Metres,
}

impl Companion {
    /// Begins to publish a mission of which `trace` is the empty record, and to follow the commands.
    ///
    /// # Errors
    /// If the topics cannot be published.
    pub fn new(
        mut node: Node,
        commands: Commands,
        scenario: &Scenario,
        trace: &Trace,
    ) -> io::Result<Self> {
        let messages = Messages::with_clock(trace, Place::of(scenario), &mut node)?;
        Ok(Self { node, commands, messages, height: scenario.agent.flight.height })
    }
}

impl serve::Companion for Companion {
    fn show(&mut self, trace: &Trace, frame: &Frame) -> Result<(), InputError> {
        self.messages.frame(&mut self.node, trace, frame).map_err(|error| {
            let wrong = format!("the messages of ROS 2 cannot be sent: {error}");
            InputError::new(wrong, "look whether this machine's network is up")
        })
    }

    fn asks(&mut self) -> Vec<Packet> {
        let forward = self.commands.take_forward().map(|twist| twist.what);
        let forward = forward.filter(|forward| forward.is_finite());
        let setpoint = forward.map(|forward| setpoint(forward as f32, self.height));
        let orders = std::iter::from_fn(|| self.commands.take_order());
        setpoint.into_iter().chain(orders.filter_map(|text| order(&text.what))).collect()
    }

    fn lost(&self) -> u64 {
        self.node.lost()
    }
}

/// The set-point that makes the head fly.
fn setpoint(forward: f32, height: Metres) -> Packet {
    Request::Setpoint(Setpoint::Hover {
        forward: MetresPerSecond(forward),
        lateral: MetresPerSecond::ZERO,
        yaw_rate: RadiansPerSecond(0.0),
        height,
    })
    .packet()
}

/// The packet of an order; `None` for a word that is none.
fn order(text: &str) -> Option<Packet> {
    let task = match text.trim() {
        "wait" => OperatorTask::Wait,
        "return" => OperatorTask::Return,
        "land" => OperatorTask::Land,
        "perch" => OperatorTask::Perch,
        "stop" => OperatorTask::Stop,
        _ => return None,
    };
    let value = &[task as u8];
    let write = ParamRequest::Write { id: ParameterId::TASK.row(), value };
    Some(Request::Param(write).packet())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_words_and_nothing_else() {
        for word in ["wait", "return", "land", "perch", "stop", " return\n"] {
            assert!(order(word).is_some(), "{word:?}");
        }
        for word in ["", "Return", "explore", "return home"] {
            assert!(order(word).is_none(), "{word:?}");
        }
    }

    #[test]
    fn a_set_point_has_the_speed_and_the_height() {
        let packet = setpoint(-0.25, Metres(0.4));
        let parsed = Request::parse(&packet).unwrap();
        let Request::Setpoint(Setpoint::Hover { forward, height, .. }) = parsed else {
            panic!("{parsed:?}");
        };
        assert_eq!((forward, height), (MetresPerSecond(-0.25), Metres(0.4)));
    }
}
