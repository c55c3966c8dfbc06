//! The orders of a mission's operator: the scenario's pilot, or the caller.

use units::Order;

use super::Mission;
use super::member::{Member, Onboard};
use crate::scenario::Scenario;

/// Where a mission's orders come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// The scenario's pilot.
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

    /// Whether the operator is a client, and not the scenario's script.
    #[must_use]
    pub const fn is_live(&self) -> bool {
        !matches!(self.source, Source::Script)
    }

    /// The operator's order at this time.
    #[must_use]
    pub fn task(&self) -> Order {
        let order = operators_order(self.scenario, self.source, self.now_us);
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
        let Some(order) = operators_order(self.scenario, self.source, now_us) else { return };
        if let Some(Member { onboard: Onboard::Hosted(base), .. }) = self.members.last_mut() {
            base.order(now_us, order);
        }
    }
}

/// The operator's order at this time; `None` where clients give orders.
fn operators_order(scenario: &Scenario, source: Source, now_us: u64) -> Option<Order> {
    match source {
        Source::Clients => None,
        Source::Live(task) => Some(task),
        Source::Script => {
            let step = scenario.pilot.iter().take_while(|step| step.at_us <= now_us).last();
            Some(step.map_or(Order::Wait, |step| step.task))
        }
    }
}
