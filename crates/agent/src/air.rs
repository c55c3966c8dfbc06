//! Reports as the mind knows them, and as they are on the air.

use chain::report::{LinkSpan, Order, Phase, Report, Task};
use wire::report as air;

/// As it is broadcast.
#[must_use]
pub fn to_air(report: &Report) -> air::Report {
    air::Report {
        from: report.from,
        sequence: report.sequence,
        phase: match report.phase {
            Phase::Waiting => air::Phase::Waiting,
            Phase::Transit => air::Phase::Transit,
            Phase::Linked => air::Phase::Linked,
            Phase::Base => air::Phase::Base,
            Phase::Out => air::Phase::Out,
        },
        velocity: report.velocity,
        odometer: report.odometer,
        links: report
            .links
            .map(|span| air::Links { weakest: span.weakest, strongest: span.strongest }),
        order: report.order.map(|order| air::Order {
            sequence: order.sequence,
            task: match order.task {
                Task::Wait => air::Task::Wait,
                Task::Explore(speed) => air::Task::Explore(speed),
                Task::Return => air::Task::Return,
                Task::Land => air::Task::Land,
                Task::Stop => air::Task::Stop,
            },
        }),
        recall: report.recall,
    }
}

/// As it was heard.
#[must_use]
pub fn from_air(report: &air::Report) -> Report {
    Report {
        from: report.from,
        sequence: report.sequence,
        phase: match report.phase {
            air::Phase::Waiting => Phase::Waiting,
            air::Phase::Transit => Phase::Transit,
            air::Phase::Linked => Phase::Linked,
            air::Phase::Base => Phase::Base,
            air::Phase::Out => Phase::Out,
        },
        velocity: report.velocity,
        odometer: report.odometer,
        links: report
            .links
            .map(|span| LinkSpan { weakest: span.weakest, strongest: span.strongest }),
        order: report.order.map(|order| Order {
            sequence: order.sequence,
            task: match order.task {
                air::Task::Wait => Task::Wait,
                air::Task::Explore(speed) => Task::Explore(speed),
                air::Task::Return => Task::Return,
                air::Task::Land => Task::Land,
                air::Task::Stop => Task::Stop,
            },
        }),
        recall: report.recall,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::{Dbm, Metres, MetresPerSecond, NodeId};

    #[test]
    fn every_phase_and_task_comes_back_as_it_went() {
        let phases = [Phase::Waiting, Phase::Transit, Phase::Linked, Phase::Base, Phase::Out];
        let tasks = [
            Task::Wait,
            Task::Explore(MetresPerSecond(0.25)),
            Task::Return,
            Task::Land,
            Task::Stop,
        ];
        for (n, (phase, task)) in phases.into_iter().zip(tasks).enumerate() {
            let report = Report {
                from: NodeId(n as u8),
                sequence: 513,
                phase,
                velocity: MetresPerSecond(-0.125),
                odometer: Metres(3.5),
                links: (n % 2 == 0)
                    .then_some(LinkSpan { weakest: Dbm(-63.25), strongest: Dbm(-51.5) }),
                order: (n > 0).then_some(Order { sequence: 9, task }),
                recall: n == 3,
            };
            let heard = air::Report::decode(&to_air(&report).encode()).unwrap();
            assert_eq!(from_air(&heard), report);
        }
    }
}
