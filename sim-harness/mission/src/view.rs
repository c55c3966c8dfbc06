//! What may be looked at of a mission under way.

use agent::{Exploration, Outputs, State};
use onboard::{Operator, Sensed};
use units::{Dbm, NodeId, Role};
use wire::p2p::Telemetry;
use world::SkeletonPlace;

use super::Mission;
use super::ideal::IdealLink;
use super::log::RadioMetrics;
use super::member::Member;
use super::parts::Part;
use super::seal::Cipher;
use super::track::Linked;
use bodies::Body;
use bodies::emulated::Emulated;

/// The last telemetry that the base has received from a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// The moment at which it came, by the mission's clock, µs.
    pub at_us: u64,
    /// The telemetry.
    pub telemetry: Telemetry,
}

/// The values of one member that may be looked at from outside.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// The member's number.
    pub id: NodeId,
    /// The member's role.
    pub role: Role,
    /// The member's body; at flight level with a [`craft`](Body::craft), unless it is the base.
    pub body: &'a Body,
    /// The outputs of the agent's last round; `None` before the first.
    pub outputs: Option<&'a Outputs>,
    /// The sensor values of the last round.
    pub senses: &'a Sensed,
    /// The operator's orders as the member has them; `None` for a drone in an emulator.
    pub operator: Option<Operator>,
}

impl Mission<'_> {
    /// The time that this machine has spent in each part of the simulation, of a
    /// [timed](Self::timed) mission.
    pub fn spent(&self) -> impl Iterator<Item = (Part, std::time::Duration)> {
        self.stopwatch.spent().into_iter().flat_map(|spent| Part::ALL.into_iter().zip(spent))
    }

    /// A drone that is in an emulator.
    #[must_use]
    pub fn emulated_drone(&self, member: usize) -> Option<&Emulated> {
        self.members.get(member)?.onboard.emulated()
    }

    /// A drone that is in an emulator, to make something go wrong with it, or to watch it.
    pub fn emulated_drone_mut(&mut self, member: usize) -> Option<&mut Emulated> {
        self.members.get_mut(member)?.onboard.emulated_mut()
    }

    /// Whether a drone calls the whole chain home, against the operator's order to explore.
    #[must_use]
    pub fn is_recalled(&self) -> bool {
        let calls = |outputs: &Outputs| outputs.report.recall;
        self.members.iter().any(|member| member.outputs.as_ref().is_some_and(calls))
    }

    /// The bodies, head first, base last.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.members.iter().map(|member| &member.body)
    }

    /// The strength at which one member receives another where they are now: with shadows and fades
    /// of the place, the loss on the ground, and the gains of both antennas, without noise.
    #[must_use]
    pub fn true_strength(&self, receiver: usize, sender: usize) -> Dbm {
        self.strengths.seen_between(&self.world.radio, sender, receiver)
    }

    /// The large-scale strength of the link between two members where they are now, which is that
    /// of the best chains: without the ground, and without the antennas and their errors.
    #[must_use]
    pub fn large_scale_strength(&self, one: usize, other: usize) -> Dbm {
        let radio = &self.world.radio;
        let (here, there) = (self.track.place(one), self.track.place(other));
        let length = || radio.distance(here, there);
        let strength = match (self.strengths.on(one), self.strengths.on(other)) {
            (Some(here), Some(there)) => radio.strength_at(here, there),
            _ => radio.strength(here, there),
        };
        strength + self.strengths.level(one, other, length)
    }

    /// The state of each member's agent, head first, base last.
    pub fn states(&self) -> impl Iterator<Item = State> {
        self.members.iter().map(Member::state)
    }

    /// The maps of the drones that explore.
    pub fn explorations(&self) -> impl Iterator<Item = &Exploration> {
        self.members.iter().filter_map(|member| member.onboard.exploration())
    }

    /// How many members there are, base included.
    #[must_use]
    pub fn count(&self) -> usize {
        self.members.len()
    }

    /// A look at one member, head first, base last.
    #[must_use]
    pub fn view(&self, member: usize) -> Option<View<'_>> {
        let found = self.members.get(member)?;
        Some(View {
            id: NodeId(member as u8),
            role: found.role,
            body: &found.body,
            outputs: found.outputs.as_ref(),
            senses: &found.senses,
            operator: found.onboard.hosted().map(|hosted| hosted.drone().operator()),
        })
    }

    /// The last telemetry that the base has received from a member.
    #[must_use]
    pub fn told(&self, member: usize) -> Option<Told> {
        let base = self.members.last()?.onboard.hosted()?;
        let node = base.drone().node(NodeId(member as u8))?;
        Some(Told { at_us: base.mission_us(node.heard), telemetry: node.telemetry })
    }

    /// The figures of the radio so far.
    #[must_use]
    pub fn radio(&self) -> RadioMetrics {
        let sealed = Cipher::is_sealed(self.scenario.fidelity);
        let tally = self.ideal.as_ref().map_or(self.medium.tally(), IdealLink::tally);
        RadioMetrics::of(sealed, tally, self.now_us, &self.orders)
    }

    /// The links of the chain as it is now, base first, head last: the base, and every drone that
    /// flies as relay or explorer and is not lost.
    pub fn chain(&self, into: &mut Vec<Linked>) {
        into.clear();
        let linked = self.members.iter().enumerate().rev().filter(|(_, member)| {
            let is_link = member.outputs.is_some_and(|outputs| outputs.report.phase.is_link());
            is_link && member.lost.is_none()
        });
        into.extend(linked.map(|(n, _)| self.track.linked(n, self.world)));
    }

    /// The members' places on the skeleton, head first, base last.
    pub fn places(&self) -> impl Iterator<Item = SkeletonPlace> {
        (0..self.members.len()).map(|n| self.track.place(n))
    }

    /// The length of the shortest way from the base to each member, head first, base last, m.
    pub fn ways(&self) -> impl Iterator<Item = f32> {
        self.places().map(|place| self.world.way(place))
    }

    /// How often any drone has touched a wall.
    #[must_use]
    pub fn wall_contacts(&self) -> u32 {
        self.members.iter().map(|member| member.body.contacts()).sum()
    }

    /// How often two flying drones have touched, as seen from above.
    #[must_use]
    pub const fn drone_contacts(&self) -> u32 {
        self.contacts.in_air()
    }

    /// How often a drone, flying or landed, has touched one that stood on the ground.
    #[must_use]
    pub const fn ground_contacts(&self) -> u32 {
        self.contacts.on_ground()
    }

    /// Whether the scenario has taken this member from the chain.
    #[must_use]
    pub fn is_lost(&self, member: usize) -> bool {
        self.members.get(member).is_some_and(|member| member.lost.is_some())
    }
}
