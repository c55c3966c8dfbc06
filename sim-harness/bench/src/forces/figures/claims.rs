//! What the paper says of its tables and of figures 12 and 14, each with the interval of the quantity that
//! decides it. Flights of the same seed are compared with each other; one that gets stuck takes for ever.

use measure::claim::{Claim, Needs, number};
use measure::intervals::{Interval, mean, median, share};
use swarms::bench::{CLEAR, PAPER_MOST};
use swarms::{Leg, Phase, Place};

use super::{Flown, Reading, TABLE_2, TABLE_3};

/// The share of the flights that counts as all.
const ALL: f64 = 0.99;

/// The names of the numbers of drones, from one on.
const SIZES: [&str; 6] = ["1 drone", "2 drones", "3 drones", "4 drones", "5 drones", "6 drones"];
/// The names of the steps from a number of drones to the next.
const STEPS: [&str; 5] = ["1 to 2", "2 to 3", "3 to 4", "4 to 5", "5 to 6"];

const UNSAID: &str = "Why: not known; the paper leaves open what the readings differ in, and no program is published.";
const NO_GUARD: &str = "Why: the next step is a weighted mean of all forces, in which the repulsion of one \
                        near thing may be outweighed; only `ours` has a guard.";
const RANKS: &str =
    "Why: not measured; more drones than fit beside each other pass one after the other.";
const STUCK: &str = "Why: not measured; where drones stand still, the forces balance each other.";
const CUT: &str = "Why: not measured; no force of the paper knows whether a link is the last one between \
                   two parts of the swarm.";

impl Reading {
    /// The paper's claims of this reading's flights.
    #[must_use]
    pub fn claims(&self) -> Vec<Claim> {
        let mut claims = vec![self.durations(), self.quicker(), self.links(), self.clear()];
        claims.extend([self.ends(), self.short_set_up(), self.single_fastest(), self.alike_in_a()]);
        claims.extend([self.wide_faster(), self.slower_together(), self.jumps_in_d()]);
        claims.extend([self.grows_in_e(), self.connected()]);
        claims
    }

    /// The surveys of so many drones, which are the same before every passage.
    fn surveys(&self) -> impl Iterator<Item = (usize, &Flown)> {
        (1..=PAPER_MOST).zip(0..).filter_map(|(drones, n)| Some((n, self.flown(Place::A, drones)?)))
    }

    fn durations(&self) -> Claim {
        let words = "all six durations of the survey, within 10 %";
        let quantity = "distance of the mean of the surveys from the paper's, in parts of it";
        let empty = Claim::new(("table 2", words), (quantity, Needs::AtMost(0.1)), UNSAID);
        self.surveys().zip(TABLE_2).fold(empty, |claim, ((n, flown), paper)| {
            let all = flown.rounds(Phase::Survey);
            let ended: Vec<f64> = all.iter().copied().filter(|rounds| rounds.is_finite()).collect();
            let stuck = all.len() - ended.len();
            let told = format!("mean {}, paper {paper}, {stuck} stuck", number(middle(&ended)));
            let ratio = mean(&ended).map(|mean| mean / f64::from(paper));
            // With surveys that never end, the mean of all of them has no upper limit.
            let high = if stuck > 0 { f64::INFINITY } else { ratio.high };
            let off = Interval { high, ..ratio }.distance_from(1.0);
            claim.with((SIZES[n], all.len()), told, off)
        })
    }

    fn quicker(&self) -> Claim {
        let words = "the more drones, the quicker the survey";
        let quantity = "median of the rounds that one drone more saves with the same seed";
        let empty = Claim::new(("table 2", words), (quantity, Needs::MoreThan(0.0)), UNSAID);
        let pairs = self.surveys().zip(self.surveys().skip(1));
        pairs.fold(empty, |claim, ((n, few), (_, many))| {
            let [few, many] = [few, many].map(|flown| flown.rounds(Phase::Survey));
            claim.with((STEPS[n], few.len()), medians(&few, &many), differences(&few, &many))
        })
    }

    fn links(&self) -> Claim {
        let words = "all five numbers of links lost in the survey, within a factor of 2";
        let quantity = "distance of the mean from the paper's, as a power of 2";
        let empty = Claim::new(("table 3", words), (quantity, Needs::AtMost(1.0)), UNSAID);
        self.surveys().skip(1).zip(TABLE_3).fold(empty, |claim, ((n, flown), paper)| {
            let legs = flown.legs(Phase::Survey).flatten();
            let lost: Vec<f64> = legs.map(|leg| f64::from(leg.links_lost)).collect();
            let told = format!("mean {}, paper {paper}", number(middle(&lost)));
            let power = |mean: f64| libm::log2(mean.max(0.0) / f64::from(paper));
            claim.with((SIZES[n], lost.len()), told, mean(&lost).map(power).distance_from(0.0))
        })
    }

    fn clear(&self) -> Claim {
        let words = "everything stays 1.3 safety distances apart (here: in 99 % of the flights)";
        let safe = self.rule.config.safety_distance().0;
        let nearest = |leg: &Leg| leg.closest_drones.0.min(leg.closest_wall.0) / safe;
        let empty = share_of_all(("section 6.3.1", words), NO_GUARD);
        Place::ALL.into_iter().fold(empty, |claim, place| {
            let flights = (1..=PAPER_MOST).filter_map(|drones| self.flown(place, drones));
            let all = flights.flat_map(|flown| &flown.flights);
            let near: Vec<f32> = all
                .map(|flight| flight.legs.iter().map(nearest).fold(f32::INFINITY, f32::min))
                .collect();
            let least = near.iter().copied().fold(f32::INFINITY, f32::min);
            let clear = near.iter().filter(|near| **near >= CLEAR).count();
            let told = format!("{clear} of {} flights, nearest {least:.2}", near.len());
            claim.with((place.name(), near.len()), told, share(clear, near.len()))
        })
    }

    fn ends(&self) -> Claim {
        let words = "every flight comes to its end, since all have a duration (here: 99 %)";
        let empty = share_of_all(("figure 14", words), STUCK);
        self.count(empty, 1, |flown| {
            flown
                .legs(Phase::Crossing)
                .map(|leg| leg.is_some_and(|leg| leg.rounds.is_some()))
                .collect()
        })
    }

    fn connected(&self) -> Claim {
        let words = "the swarm stays connected in every passage (here: in 99 % of the flights)";
        let empty = share_of_all(("section 6.3.4", words), CUT);
        self.count(empty, 2, |flown| {
            flown.legs(Phase::Crossing).flatten().map(|leg| leg.connected).collect()
        })
    }

    /// The claim with the share of the flights of which something is true, in each passage over all
    /// numbers of drones from the least on.
    fn count(&self, empty: Claim, least: u16, is: impl Fn(&Flown) -> Vec<bool>) -> Claim {
        Place::ALL.into_iter().fold(empty, |claim, place| {
            let flown = (least..=PAPER_MOST).filter_map(|drones| self.flown(place, drones));
            let all: Vec<bool> = flown.flat_map(&is).collect();
            let hits = all.iter().filter(|is| **is).count();
            let told = format!("{hits} of {} flights", all.len());
            claim.with((place.name(), all.len()), told, share(hits, all.len()))
        })
    }

    fn short_set_up(&self) -> Claim {
        let words = "every set-up takes less than 1.4 times the ideal";
        let quantity = "greatest of the six swarms' medians, in ideal durations";
        let empty = Claim::new(("figure 12", words), (quantity, Needs::AtMost(1.4)), UNSAID);
        self.in_places((Phase::Setup, &Place::ALL), empty, |place| {
            let all: Vec<Vec<f64>> = self.all_ratios(Phase::Setup, place);
            Interval::of_greatest(all.iter().map(|ratios| median(ratios)))
        })
    }

    fn single_fastest(&self) -> Claim {
        let words = "a single drone sets up the fastest in every passage";
        let quantity = "least of the medians of a swarm's set-up less one drone's with the same seed, in \
                        ideal durations";
        let empty = Claim::new(("figure 12", words), (quantity, Needs::AtLeast(0.0)), UNSAID);
        self.in_places((Phase::Setup, &Place::ALL), empty, |place| {
            self.least_slowdown(Phase::Setup, place)
        })
    }

    fn alike_in_a(&self) -> Claim {
        let words = "a is crossed in the same time with any number of drones, within 10 %";
        let quantity = "greatest distance from 1 of the median of a swarm's time over one drone's with \
                        the same seed";
        let empty = Claim::new(("figure 14", words), (quantity, Needs::AtMost(0.1)), RANKS);
        self.in_places((Phase::Crossing, &[Place::A]), empty, |place| {
            let all = self.all_ratios(Phase::Crossing, place);
            let Some((one, several)) = all.split_first() else { return Interval::UNBOUNDED };
            let quotients = several.iter().map(|ratios| quotients(ratios, one));
            Interval::of_greatest(quotients.map(|one| median(&one).distance_from(1.0)))
        })
    }

    fn wide_faster(&self) -> Claim {
        let words = "c is crossed faster than b";
        let quantity =
            "median of the time in b less that in c with the same seed, in ideal durations";
        let empty = Claim::new(("figure 14", words), (quantity, Needs::MoreThan(0.0)), UNSAID);
        (2..=PAPER_MOST).zip(&SIZES[1..]).fold(empty, |claim, (drones, name)| {
            let [b, c] =
                [Place::B, Place::C].map(|place| self.ratios(Phase::Crossing, place, drones));
            claim.with((*name, b.len()), medians(&b, &c), differences(&b, &c))
        })
    }

    fn slower_together(&self) -> Claim {
        let words = "b to e take longer with several drones than with one";
        let quantity = "least of the medians of a swarm's time less one drone's with the same seed, in \
                        ideal durations";
        let empty = Claim::new(("figure 14", words), (quantity, Needs::MoreThan(0.0)), UNSAID);
        let places = [Place::B, Place::C, Place::D, Place::E];
        self.in_places((Phase::Crossing, &places), empty, |place| {
            self.least_slowdown(Phase::Crossing, place)
        })
    }

    fn jumps_in_d(&self) -> Claim {
        let words = "d grows from 4 to 5 drones by 20 % more than b";
        let quantity = "median of the growth in d over that in b with the same seed";
        let claim = Claim::new(("figure 14", words), (quantity, Needs::MoreThan(1.2)), UNSAID);
        let [d, b] = [Place::D, Place::B].map(|place| self.growth(place, 4));
        claim.with(("d, b", d.len()), medians(&d, &b), median(&quotients(&d, &b)))
    }

    fn grows_in_e(&self) -> Claim {
        let words = "e grows by 20 % from 3 to 4 drones";
        let quantity = "median of the growth with the same seed";
        let claim = Claim::new(("figure 14", words), (quantity, Needs::AtLeast(1.2)), UNSAID);
        let growth = self.growth(Place::E, 3);
        let told = format!("median {}", number(middle_of(&growth)));
        claim.with(("e", growth.len()), told, median(&growth))
    }

    fn ratios(&self, phase: Phase, place: Place, drones: u16) -> Vec<f64> {
        self.flown(place, drones).map(|flown| flown.ratios(phase)).unwrap_or_default()
    }

    /// The ratios of each number of drones, from one on.
    fn all_ratios(&self, phase: Phase, place: Place) -> Vec<Vec<f64>> {
        (1..=PAPER_MOST).map(|drones| self.ratios(phase, place, drones)).collect()
    }

    /// The time of a crossing with one drone more, over that with so many.
    fn growth(&self, place: Place, drones: u16) -> Vec<f64> {
        let [few, many] =
            [drones, drones + 1].map(|drones| self.ratios(Phase::Crossing, place, drones));
        quotients(&many, &few)
    }

    /// The least that several drones take longer than one.
    fn least_slowdown(&self, phase: Phase, place: Place) -> Interval {
        let all = self.all_ratios(phase, place);
        let Some((one, several)) = all.split_first() else { return Interval::UNBOUNDED };
        Interval::of_least(several.iter().map(|ratios| differences(ratios, one)))
    }

    /// The claim with an interval of each passage, and the medians of all numbers of drones there.
    fn in_places(
        &self,
        (phase, places): (Phase, &[Place]),
        empty: Claim,
        interval: impl Fn(Place) -> Interval,
    ) -> Claim {
        places.iter().fold(empty, |claim, place| {
            let all = self.all_ratios(phase, *place);
            let medians: Vec<String> = all.iter().map(|one| number(middle_of(one))).collect();
            let runs = all.first().map_or(0, Vec::len);
            let told = format!("medians {}", medians.join(", "));
            claim.with((place.name(), runs), told, interval(*place))
        })
    }
}

/// A claim that something is true of all flights.
fn share_of_all(source: (&'static str, &'static str), why: &'static str) -> Claim {
    Claim::new(source, ("share of the flights", Needs::AtLeast(ALL)), why)
}

/// The interval for the median of the differences of flights of the same seed; two that both get stuck
/// do not differ.
fn differences(one: &[f64], other: &[f64]) -> Interval {
    let difference = |(one, other): (&f64, &f64)| if one == other { 0.0 } else { one - other };
    median(&one.iter().zip(other).map(difference).collect::<Vec<f64>>())
}

/// The quotients of flights of the same seed; two that both get stuck are alike.
fn quotients(one: &[f64], other: &[f64]) -> Vec<f64> {
    let quotient = |(one, other): (&f64, &f64)| if one == other { 1.0 } else { one / other };
    one.iter().zip(other).map(quotient).collect()
}

fn medians(one: &[f64], other: &[f64]) -> String {
    format!("medians {}, {}", number(middle_of(one)), number(middle_of(other)))
}

/// The median of the values themselves.
fn middle_of(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

fn middle(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
