//! Counts the contacts between drones.

use units::Point2;

/// How often two flying drones have touched.
#[derive(Debug, Default)]
pub(super) struct Contacts {
    count: u32,
    /// Where each member is, and whether it flies.
    places: Vec<(Point2, bool)>,
    /// The pairs that touch now.
    touching: Vec<(usize, usize)>,
}

impl Contacts {
    /// How often it was.
    pub(super) const fn count(&self) -> u32 {
        self.count
    }

    /// Takes in where the members are now and which of them fly; two that are nearer than `least`
    /// metres touch.
    pub(super) fn look(&mut self, places: impl Iterator<Item = (Point2, bool)>, least: f32) {
        let Self { count, places: all, touching } = self;
        all.clear();
        all.extend(places);
        for (a, &(here, flies)) in all.iter().enumerate() {
            for (b, &(there, other_flies)) in all.iter().enumerate().take(a) {
                let (dx, dy) = (here.x - there.x, here.y - there.y);
                let is_near = dx * dx + dy * dy < least * least;
                if !is_near && touching.is_empty() {
                    continue;
                }
                let touch = is_near && flies && other_flies;
                let known = touching.iter().position(|&pair| pair == (a, b));
                match (touch, known) {
                    (true, None) => {
                        touching.push((a, b));
                        *count += 1;
                    }
                    (false, Some(at)) => {
                        touching.swap_remove(at);
                    }
                    _ => {}
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_counts_once_while_it_lasts_and_only_in_the_air() {
        let mut contacts = Contacts::default();
        let mut look = |x: f32, flies| {
            let places = [(Point2::new(0.0, 0.0), true), (Point2::new(x, 0.0), flies)];
            contacts.look(places.into_iter(), 0.2);
            contacts.count()
        };
        assert_eq!([look(1.0, true), look(0.1, true), look(0.1, true)], [0, 1, 1]);
        assert_eq!([look(0.3, true), look(0.1, true)], [1, 2], "a second one");
        assert_eq!([look(0.3, true), look(0.1, false)], [2, 2], "one on the ground");
    }
}
