//! Finds the leader of a cluster, a connected component of the radio graph.

/// The most robots that explore together.
pub const ROBOTS: usize = 8;

/// Which robots hear each other: bit `b` of entry `a` says that `a` hears `b`.
pub type Links = [u8; ROBOTS];

/// The leader of a robot's cluster: the lowest number in the connected component of the radio graph
/// in which the robot is. A link counts where both ends hear each other. A robot that hears nobody,
/// or whose number is not below [`ROBOTS`], leads itself.
#[must_use]
pub fn leader(links: &Links, robot: u8) -> u8 {
    let mut member = 1_u8.checked_shl(u32::from(robot)).unwrap_or(0);
    // After as many rounds as there are robots, the component no longer grows.
    for _ in 0..ROBOTS {
        for (a, heard) in links.iter().enumerate() {
            for b in 0..ROBOTS {
                let is_heard = links.get(b).is_some_and(|back| back >> a & 1 == 1);
                if heard >> b & 1 == 1 && is_heard && member >> a & 1 == 1 {
                    member |= 1 << b;
                }
            }
        }
    }
    if member == 0 { robot } else { member.trailing_zeros() as u8 }
}
