//! Computes the best chains that a scenario allows, once for all its runs, and those on the way to an
//! end of the skeleton when a head first comes near that end.

use world::{BestChains, Leg, Optimum, Path, SkeletonPlace, World, best_chain};

use mission::Linked;
use scenario::{Scenario, Start};

/// The best chains of a scenario, solved once for all its runs.
pub struct Reference {
    /// The optimum for the scenario's own number of links with the head where it starts, for
    /// scenarios that begin in the air.
    pub(super) fixed: Option<(Path, Optimum)>,
    /// The best chains on the way to each end of the skeleton.
    ways: Vec<Way>,
    /// The links of an explorer's chain with all relays in it.
    pub(super) links: usize,
}

/// The best chains along the shortest way from the base to an end of the skeleton.
struct Way {
    /// The last stretch of the way: the heads on it have their best chains in this table.
    last: Leg,
    chains: BestChains,
}

impl Way {
    /// The ways to both ends of every edge, but for those that do not end on it.
    fn all(world: &World, links: usize) -> Vec<Self> {
        let skeleton = world.skeleton();
        let edges = skeleton.edges().iter().enumerate();
        let ends = edges.flat_map(|(edge, found)| {
            let ends = [0.0, found.line().length()];
            ends.map(|along| SkeletonPlace { edge: edge as u16, along })
        });
        let way = |end: SkeletonPlace| {
            let path = world.path_to(end);
            let last = *path.legs().last()?;
            (last.edge == end.edge && last.from != last.to)
                .then(|| Self { last, chains: BestChains::along(&world.radio, path, links) })
        };
        ends.filter_map(way).collect()
    }

    fn leads_to(&self, place: SkeletonPlace) -> bool {
        let Leg { edge, from, to } = self.last;
        edge == place.edge && (from.min(to)..=from.max(to)).contains(&place.along)
    }
}

impl Reference {
    /// Computes the best chains of the scenario.
    #[must_use]
    pub fn of(scenario: &Scenario, world: &World) -> Self {
        let links = scenario.drones.relays + 1;
        let head = match &scenario.drones.start {
            Start::Mouth => None,
            Start::Random { head } => Some(*head),
            Start::Placed(spots) => spots.first().copied(),
        };
        let fixed = head.map(|head| {
            let path = world.path_to(head.on);
            let chain = best_chain(&world.radio, &path, links);
            (path, chain)
        });
        Self { fixed, ways: Way::all(world, links), links }
    }

    /// The best chain to the head where it starts, for scenarios that begin in the air, with its
    /// way.
    #[must_use]
    pub fn fixed(&self) -> Option<(&Path, &Optimum)> {
        self.fixed.as_ref().map(|(path, fixed)| (path, fixed))
    }

    /// The links of an explorer's chain with all relays in it.
    #[must_use]
    pub const fn links(&self) -> usize {
        self.links
    }

    /// Loss in dB of the weakest link of the best chain of `links` links to a head here.
    #[must_use]
    pub fn worst(&self, links: usize, head: &Linked) -> f32 {
        let way = self.ways.iter().find(|way| way.leads_to(head.place));
        let Some(Way { chains, .. }) = way else { return f32::INFINITY };
        let last = chains.last();
        let place = (head.way / chains.way().length() * last as f32).clamp(0.0, last as f32);
        let at = |n: usize| chains.worst(links, n).0;
        let (near, far) = (at(place as usize), at(place as usize + 1));
        near + (place - place.floor()) * (far - near)
    }

    /// The least number of links whose best chain to a head here has no link weaker than
    /// `limit` (a loss in dB); one more than there are drones for, where none will do.
    #[must_use]
    pub fn least_links(&self, limit: f32, head: &Linked) -> usize {
        let enough = |links: &usize| self.worst(*links, head) <= limit;
        (1..=self.links).find(enough).unwrap_or(self.links + 1)
    }
}
