//! Converts between the agent's types and the radio messages: reports and telemetry.

use agent::{Fitness, LandReason, LinkView, Outputs, State};
use chain::neighbours::Heard;
use chain::report::Report;
use units::{Dbm, NodeId};
use wire::p2p;

use crate::Sensed;

/// Converts this round's report for the radio link, which adds the nodes that it receives.
#[must_use]
pub(crate) fn report_to_air(outputs: &Outputs) -> p2p::Report {
    let report = &outputs.report;
    p2p::Report {
        phase: report.phase,
        recall: report.recall,
        calls: report.calls,
        is_uneven: report.is_uneven,
        velocity: report.velocity,
        odometer: report.odometer,
        links: report.links,
        sums: report.sums,
        waiting: report.waiting,
        head_velocity: report.head_velocity,
        signpost: report.signpost,
        heard: heapless::Vec::new(),
    }
}

/// Converts a report that the radio link has delivered; the sender and the sequence number are in the
/// packet's header.
#[must_use]
pub(crate) fn report_from_air(
    me: NodeId,
    from: NodeId,
    counter: p2p::Counter,
    report: &p2p::Report,
    rssi: Option<Dbm>,
) -> Heard {
    let named = report.heard.iter().find(|heard| heard.node == me && heard.is_new);
    let reverse = named.map(|heard| heard.rssi);
    let report = Report {
        from,
        sequence: counter.low16(),
        phase: report.phase,
        velocity: report.velocity,
        odometer: report.odometer,
        links: report.links,
        sums: report.sums,
        waiting: report.waiting,
        head_velocity: report.head_velocity,
        signpost: report.signpost,
        recall: report.recall,
        calls: report.calls,
        is_uneven: report.is_uneven,
    };
    Heard { report, rssi, reverse }
}

/// Returns the telemetry of a node. The link adds the number of the last order that the node
/// obeyed.
#[must_use]
pub(crate) fn telemetry(outputs: &Outputs, sensed: &Sensed) -> p2p::Telemetry {
    let Outputs { report, status, .. } = outputs;
    let link = |link: &Option<LinkView>| link.as_ref().map(|link| (link.peer, link.rssi));
    p2p::Telemetry {
        state: status.state.code(),
        fault: fault(status.state, sensed.fitness),
        battery: sensed.battery,
        endurance: sensed.endurance,
        front: link(&status.front),
        back: link(&status.back),
        odometer: status.here.odometer,
        velocity: report.velocity,
        height: sensed.height,
        heeded: 0,
    }
}

/// The code of a fault: 0 none; 1 unfit to take off; 2 motors off until the next boot;
/// 3 lost the base's side; 4 never reached its height; 5 restarted by itself;
/// 6 lost its position; from 16 on the flight code's
/// [`Cause`](flight::Cause), in its order.
#[must_use]
pub const fn fault(state: State, fitness: Fitness) -> u8 {
    let why = match state {
        State::Landing { why, .. } | State::Landed { why } => Some(why),
        _ => None,
    };
    match (fitness, why) {
        (Fitness::Stopped, _) => 2,
        (Fitness::Landing(cause) | Fitness::Landed(cause), _)
        | (_, Some(LandReason::Unfit(cause))) => cause_code(cause),
        (_, Some(LandReason::LinkLost)) => 3,
        (_, Some(LandReason::TakeOffFailed)) => 4,
        (_, Some(LandReason::Restarted)) => 5,
        (_, Some(LandReason::PositionLost)) => 6,
        (Fitness::Unfit, _) => 1,
        (Fitness::Fit, _) => 0,
    }
}

const fn cause_code(cause: flight::Cause) -> u8 {
    16 + match cause {
        flight::Cause::NoSetpoint => 0,
        flight::Cause::NoImu => 1,
        flight::Cause::NoFlow => 2,
        flight::Cause::NoHeight => 3,
        flight::Cause::Battery => 4,
        flight::Cause::Overload => 5,
        flight::Cause::Blocked => 6,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use agent::{ChainDuty, Duty, Reckoning, Status};
    use tunnel_nav::Walls;
    use units::{
        Branch, Instant, LinkSpan, LinkSum, Metres, MetresPerDb, MetresPerSecond, Phase, Setpoint,
        Signpost, Volts,
    };

    const POST: Signpost = Signpost {
        revision: 200,
        index: 2,
        count: 3,
        from: Metres(12.25),
        branch: Some(Branch::Straight),
    };

    fn outputs(phase: Phase, links: Option<LinkSpan>) -> Outputs {
        let link = |peer, rssi| LinkView {
            peer: NodeId(peer),
            raw: Dbm(-50.0),
            rssi: Dbm(rssi),
            velocity: MetresPerSecond::ZERO,
            is_base: false,
        };
        let relaying = ChainDuty::Relaying { patient_until: Instant::ZERO };
        let sum = LinkSum { surplus: Metres(-4.25), compliance: MetresPerDb(1.5), links: 3 };
        Outputs {
            setpoint: Setpoint::Off,
            report: Report {
                from: NodeId(2),
                sequence: 9,
                phase,
                velocity: MetresPerSecond(-0.125),
                odometer: Metres(3.5),
                links,
                sums: [LinkSum::NONE, sum],
                waiting: 3,
                head_velocity: MetresPerSecond(0.252),
                signpost: (phase == Phase::Linked).then_some(POST),
                recall: phase == Phase::Linked,
                calls: phase == Phase::Linked,
                is_uneven: phase == Phase::Linked,
            },
            status: Status {
                state: State::OnMission(Duty::Chain(relaying)),
                front: Some(link(1, -63.0)),
                back: Some(link(3, -51.0)),
                here: Reckoning { odometer: Metres(3.5), ..Reckoning::default() },
                walls: Walls::Neither,
            },
        }
    }

    #[test]
    fn every_phase_comes_back_as_it_went() {
        let phases = [
            Phase::Waiting,
            Phase::Transit,
            Phase::Linked,
            Phase::Base,
            Phase::Out,
            Phase::Searching,
            Phase::Perched,
        ];
        for (n, phase) in phases.into_iter().enumerate() {
            let links =
                (n % 2 == 0).then_some(LinkSpan { weakest: Dbm(-63.25), strongest: Dbm(-51.5) });
            let outputs = outputs(phase, links);
            let message = p2p::Message::Report(report_to_air(&outputs));
            let mut body = [0; p2p::MAX_BODY];
            let length = message.encode(&mut body);
            let heard = p2p::Message::decode(message.kind(), &body[..length]).unwrap();
            let p2p::Message::Report(heard) = heard else { panic!("{heard:?}") };
            let counter = p2p::Counter::new(p2p::Epoch::FIRST, 9).unwrap();
            let heard = report_from_air(NodeId(1), NodeId(2), counter, &heard, Some(Dbm(-60.0)));
            assert_eq!(heard.report, outputs.report);
            assert_eq!((heard.rssi, heard.reverse), (Some(Dbm(-60.0)), None));
        }
    }

    /// Of the nodes that a report names, only this drone itself measures the link to the sender,
    /// and only a packet that has come since the report before.
    #[test]
    fn the_way_back_is_measured_once_by_the_drone_that_is_named() {
        let counter = p2p::Counter::new(p2p::Epoch::FIRST, 9).unwrap();
        let named = |node, rssi, is_new| p2p::Heard {
            node: NodeId(node),
            rssi: Dbm(rssi),
            is_new,
            epoch: p2p::Epoch::FIRST,
        };
        let entries = [named(1, -61.0, true), named(3, -72.0, false), named(5, -83.0, true)];
        let mut report = report_to_air(&outputs(Phase::Linked, None));
        report.heard = entries.into_iter().collect();
        let expected = [(1, Some(Dbm(-61.0))), (3, None), (4, None), (5, Some(Dbm(-83.0)))];
        for (me, reverse) in expected {
            let heard = report_from_air(NodeId(me), NodeId(2), counter, &report, Some(Dbm(-60.0)));
            assert_eq!((heard.rssi, heard.reverse), (Some(Dbm(-60.0)), reverse), "by node {me}");
        }
    }

    #[test]
    fn telemetry_says_what_is_wrong() {
        let fit = outputs(Phase::Linked, None);
        let sensed = Sensed { battery: Some(Volts(3.8)), ..Sensed::NONE };
        let told = telemetry(&fit, &sensed);
        assert_eq!((told.state, told.fault, told.heeded), (4, 0, 0));
        assert_eq!(told.front, Some((NodeId(1), Dbm(-63.0))));
        let cause = flight::Cause::NoFlow;
        let landing = State::Landing { since: Instant::ZERO, why: LandReason::Unfit(cause) };
        assert_eq!(fault(landing, Fitness::Landing(cause)), 18);
        assert_eq!(fault(State::Landed { why: LandReason::LinkLost }, Fitness::Fit), 3);
        assert_eq!(fault(State::Landed { why: LandReason::Restarted }, Fitness::Fit), 5);
        assert_eq!(fault(State::Idle, Fitness::Unfit), 1);
        assert_eq!(fault(State::Stopped, Fitness::Stopped), 2);
        assert_eq!(fault(State::Landed { why: LandReason::Home }, Fitness::Fit), 0);
    }
}
