//! The orders of a mission's operator: the scenario's pilot, or the caller.

use scenario::{Loss, LossKind, PilotStep, as_in_a_file};
use units::{Course, MetresPerSecond, Order};

use super::Mission;
use super::member::{Member, Onboard};

/// Where a mission's orders come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// The pilot: the scenario's, or the caller of [`Mission::steer`].
    Script,
    /// The caller of [`Mission::order`], whose last order this is.
    Live(Order),
    /// Clients at the drones' own CRTP servers.
    Clients,
}

impl Mission<'_> {
    /// Gives the operator's order at the base of a live mission; it holds until the next.
    pub fn order(&mut self, task: Order) {
        let word = Source::Live(task);
        if self.source == Source::Script || self.source == word {
            return;
        }
        self.source = word;
        self.give_order(self.now_us);
    }

    /// Gives an order in the place of the scenario's pilot, who gives none from now on. A scenario
    /// with the orders of [`pilot`](Self::pilot) flies the same mission, bit for bit, where the
    /// caller steers between rounds.
    pub fn steer(&mut self, order: Order) {
        let at_us = as_in_a_file(self.now_us);
        let pilot = self.pilot.to_mut();
        pilot.retain(|step| step.at_us < at_us);
        if pilot.last().map_or(Order::Wait, |step| step.task) != order {
            pilot.push(PilotStep { at_us, task: order });
        }
    }

    /// The orders of the pilot, in order of time.
    #[must_use]
    pub fn pilot(&self) -> &[PilotStep] {
        &self.pilot
    }

    /// Takes a drone from the chain. A scenario with the [`losses`](Self::losses) flies the same
    /// mission, bit for bit, where the caller loses drones between rounds.
    pub fn lose(&mut self, drone: usize, how: LossKind) {
        let at_us = as_in_a_file(self.now_us);
        if drone >= self.scenario.drones.flying() || self.is_lost(drone) {
            return;
        }
        let losses = self.losses.to_mut();
        losses.retain(|loss| loss.drone != drone);
        losses.push(Loss { at_us, drone, how });
        losses.sort_by_key(|loss| loss.at_us);
    }

    /// The drones that are lost in this mission, in order of time.
    #[must_use]
    pub fn losses(&self) -> &[Loss] {
        &self.losses
    }

    /// Whether the operator is a client, and not the scenario's script.
    #[must_use]
    pub const fn is_live(&self) -> bool {
        !matches!(self.source, Source::Script)
    }

    /// The operator's order at this time.
    #[must_use]
    pub fn task(&self) -> Order {
        let order = self.operators_order(self.now_us);
        order.or_else(|| self.clients_order()).unwrap_or(Order::Wait)
    }

    /// The order that the base has of its clients; `None` before the first.
    #[must_use]
    pub fn clients_order(&self) -> Option<Order> {
        match &self.members.last()?.onboard {
            Onboard::Hosted(base) => base.drone().operator().order(),
            Onboard::Emulated(base) => base.order(),
        }
    }

    /// Gives the base the operator's present order.
    pub(super) fn give_order(&mut self, now_us: u64) {
        self.orders.given(now_us);
        let Some(order) = self.operators_order(now_us) else { return };
        if let Some(Member { onboard: Onboard::Hosted(base), .. }) = self.members.last_mut() {
            base.order(now_us, order);
        }
    }

    /// The operator's order at this time; `None` where clients give orders.
    fn operators_order(&self, now_us: u64) -> Option<Order> {
        match self.source {
            Source::Clients => None,
            Source::Live(task) => Some(task),
            Source::Script => {
                let steps = self.pilot.iter();
                let step = steps.take_while(|step| step.at_us <= now_us).last();
                Some(self.along_route(step.map_or(Order::Wait, |step| step.task)))
            }
        }
    }

    /// The order of a pilot who stops the head where its odometer says that it is as deep as the
    /// scenario lets it fly, and who chooses the way of a map's route at junctions.
    fn along_route(&self, task: Order) -> Order {
        let head = self.members.first().and_then(|head| head.outputs.as_ref());
        let way_m = head.map_or(0.0, |outputs| outputs.status.here.odometer.0);
        let Order::Explore(course) = task else { return task };
        let from_base_m = way_m + self.scenario.drones.row_m();
        let is_deep = self.scenario.depth_m.is_some_and(|deep| from_base_m >= deep);
        let stops = is_deep && course.speed > MetresPerSecond::ZERO;
        Order::Explore(Course {
            speed: if stops { MetresPerSecond::ZERO } else { course.speed },
            branch: course.branch.or_else(|| self.route.branch(way_m)),
        })
    }
}
