//! Keeps where the drones of a swarm are, which of them are linked, and what each one hears.

use units::{Metres, Point2};
use virtual_forces::Heard;

/// The most drones of a swarm: links are the bits of one word for each drone.
pub const MOST_DRONES: u16 = 64;

/// The drones of a swarm in the world.
#[derive(Clone, Debug)]
pub(crate) struct Swarm {
    pub(crate) positions: Vec<Point2>,
    /// For each drone its links, a bit for each other drone.
    pub(crate) links: Vec<u64>,
    /// The drones that fly, a bit each.
    pub(crate) flying: u64,
    reach: f32,
}

impl Swarm {
    pub(crate) fn new(positions: Vec<Point2>, range: Metres) -> Self {
        let count = positions.len();
        let flying = (0..count).fold(0, |bits, drone| bits | 1 << drone);
        let reach = range.0 * range.0;
        let mut swarm = Self { links: vec![0; count], positions, flying, reach };
        for drone in 0..count {
            swarm.relink(drone);
        }
        swarm
    }

    /// Moves a drone, and returns the squared distance to the nearest other one, in square metres.
    pub(crate) fn place(&mut self, drone: usize, position: Point2) -> f32 {
        self.positions[drone] = position;
        self.relink(drone)
    }

    /// Takes a drone out of the air.
    pub(crate) fn drop_out(&mut self, drone: usize) {
        self.flying &= !(1 << drone);
        self.links[drone] = 0;
        for links in &mut self.links {
            *links &= !(1 << drone);
        }
    }

    /// Computes the links of one drone anew, and returns the squared distance to the nearest other
    /// one.
    fn relink(&mut self, drone: usize) -> f32 {
        let here = self.positions[drone];
        let (mut links, mut nearest) = (0_u64, f32::INFINITY);
        for (other, position) in self.positions.iter().enumerate() {
            let (x, y) = (position.x - here.x, position.y - here.y);
            let squared = x * x + y * y;
            let counts = other != drone && self.flying & (1 << other) != 0;
            nearest = if counts && squared < nearest { squared } else { nearest };
            links |= u64::from(counts && squared <= self.reach) << other;
        }
        let mut changed = links ^ self.links[drone];
        self.links[drone] = links;
        while changed != 0 {
            self.links[changed.trailing_zeros() as usize] ^= 1 << drone;
            changed &= changed - 1;
        }
        nearest
    }

    /// Says whether every drone that flies reaches every other one over links.
    pub(crate) fn connected(&self) -> bool {
        let mut seen = self.flying & self.flying.wrapping_neg();
        let mut next = seen;
        while next != 0 {
            let mut found = 0;
            while next != 0 {
                found |= self.links[next.trailing_zeros() as usize];
                next &= next - 1;
            }
            next = found & !seen;
            seen |= found;
        }
        seen == self.flying
    }

    /// Puts what one drone hears of the others into `heard`: what drones in reach pass on, over at
    /// most `hops` hops, with positions that may be wrong by `error`. The bits of `arrives` are the drones of which each one's packets arrive.
    pub(crate) fn hear(
        &self,
        drone: usize,
        hops: u16,
        arrives: &[u64],
        error: Metres,
        says: impl Fn(usize) -> (Point2, u16),
        heard: &mut Vec<Heard>,
    ) {
        heard.clear();
        let mut seen = 1_u64 << drone;
        let mut layer = self.links[drone] & arrives[drone];
        for hop in 1..=hops {
            seen |= layer;
            let mut next = 0;
            while layer != 0 {
                let other = layer.trailing_zeros() as usize;
                layer &= layer - 1;
                next |= self.links[other] & arrives[other];
                let (position, progress) = says(other);
                heard.push(Heard { number: other as u16, position, error, hops: hop, progress });
            }
            layer = next & !seen;
            if layer == 0 {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: Metres = Metres(0.0);

    fn line(count: u16) -> Swarm {
        let positions = (0..count).map(|n| Point2::new(f32::from(n), 0.0)).collect();
        Swarm::new(positions, Metres(1.1))
    }

    #[test]
    fn news_come_over_as_many_hops_as_there_are_drones_between() {
        let swarm = line(5);
        let mut heard = Vec::new();
        let says = |drone: usize| (swarm.positions[drone], 7);
        swarm.hear(0, u16::MAX, &[u64::MAX; 5], EXACT, says, &mut heard);
        let hops: Vec<_> = heard.iter().map(|other| (other.number, other.hops)).collect();
        assert_eq!(hops, [(1, 1), (2, 2), (3, 3), (4, 4)]);
        swarm.hear(0, 2, &[u64::MAX; 5], EXACT, says, &mut heard);
        assert_eq!(heard.len(), 2);
        swarm.hear(0, u16::MAX, &[!0, !4, !0, !0, !0], EXACT, says, &mut heard);
        assert_eq!(heard.len(), 1, "the second drone hears no packet of the third");
    }

    #[test]
    fn a_line_of_sixty_four_without_its_middle_is_cut() {
        let mut swarm = line(MOST_DRONES);
        assert!(swarm.connected());
        swarm.drop_out(63);
        assert!(swarm.connected());
        swarm.drop_out(30);
        assert!(!swarm.connected());
    }

    #[test]
    fn a_drone_that_comes_back_is_linked_again() {
        let mut swarm = line(3);
        assert!((swarm.place(2, Point2::new(9.0, 0.0)) - 64.0).abs() < 1e-3);
        assert!(!swarm.connected());
        swarm.place(2, Point2::new(2.0, 0.0));
        assert_eq!(swarm.links, line(3).links);
    }
}
