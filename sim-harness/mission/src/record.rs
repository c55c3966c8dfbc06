//! The record of a mission.

use agent::Exploration;
use tunnel_nav::Range;
use units::{MissionKind, NodeId, Setpoint};

use super::team_map::TeamMap;
use super::{Mission, World};
use crate::trace::{DroneFrame, Frame, LinkFrame, Node, Trace};
use scenario::Scenario;

impl<'a> Mission<'a> {
    /// Flies a whole mission and returns its record.
    #[must_use]
    pub fn record(scenario: &'a Scenario, world: &'a World, seed: u64) -> Trace {
        let mut mission = Self::new(scenario, world, seed);
        let mut trace = mission.begin_trace(seed);
        while !mission.is_over() {
            mission.round();
            trace.team_map.look(&mission);
            trace.frames.push(mission.frame());
        }
        trace
    }

    /// An empty record of this mission.
    #[must_use]
    pub fn begin_trace(&self, seed: u64) -> Trace {
        Trace {
            scenario: self.scenario.name.clone(),
            seed: Some(seed),
            mission: self.scenario.mission,
            floor_plan: self.world.tunnel.floor_plan(),
            nodes: self
                .members
                .iter()
                .enumerate()
                .map(|(n, member)| Node {
                    id: NodeId(n as u8),
                    role: member.role,
                    mission: self.scenario.mission,
                })
                .collect(),
            launch_limit: self.scenario.agent.launch.limit,
            passage: (self.scenario.mission == MissionKind::Swarm)
                .then(|| self.scenario.agent.swarm.passage.corners()),
            team_map: TeamMap::default(),
            frames: Vec::new(),
        }
    }

    /// The present state of the mission, for the record.
    #[must_use]
    pub fn frame(&self) -> Frame {
        let drones = (0..self.members.len()).map(|n| self.drone_frame(n)).collect();
        Frame { time_us: self.time_us(), order: self.task(), drones, team_links: self.team_links() }
    }

    fn drone_frame(&self, n: usize) -> DroneFrame {
        let member = &self.members[n];
        let body = &member.body;
        let place = self.track.place(n);
        let (commanded, yaw_rate) = match body.setpoint() {
            Setpoint::Off | Setpoint::Stop => ([0.0; 2], 0.0),
            Setpoint::Fly { forward, lateral, yaw_rate, .. } => {
                ([forward.0, lateral.0], yaw_rate.0)
            }
        };
        let link = |view: Option<agent::LinkView>| {
            view.and_then(|view| {
                let peer = usize::from(view.peer.0);
                let truth = (peer < self.members.len()).then(|| self.true_strength(n, peer))?;
                Some(LinkFrame { peer: view.peer, raw: view.raw, filtered: view.rssi, truth })
            })
        };
        let status = member.outputs.map(|outputs| outputs.status);
        let beams = &member.senses.ranges;
        DroneFrame {
            pose: body.pose(),
            height: body.height(),
            place,
            way: self.world.way(place),
            commanded,
            yaw_rate,
            ranges: [beams.nw, beams.ne, beams.sw, beams.se].map(metres),
            state: member.state(),
            target: member.onboard.hosted().and_then(|hosted| hosted.drone().target()),
            goal: member.onboard.exploration().and_then(Exploration::goal),
            battery_v: body.craft().map_or(f32::NAN, |craft| craft.battery().volts()),
            front: link(status.and_then(|status| status.front)),
            back: link(status.and_then(|status| status.back)),
        }
    }
}

fn metres(range: Range) -> f32 {
    match range {
        Range::At(distance) => distance.0,
        Range::Clear => f32::INFINITY,
        Range::Invalid => f32::NAN,
    }
}
