//! The sentences of the paper that can be tested, each with the interval of the quantity that decides it.
//! Places in the same cave are compared with each other.

use measure::claim::{Claim, Needs};
use measure::intervals::{median, share};

use super::{Dropped, Figures, Situation, Trial};

/// The share of caves that counts as all.
const ALL: f64 = 0.95;
/// Two places that are no farther apart are the same, m: a cell.
const SAME_M: f32 = 0.5;

/// Why the paper's rule covers little, or has no link.
const NEAREST: &str = "Why: of the front, which reaches from the widest to the most covering place, \
                       the rule takes the place nearest the goal; it neither takes the one that \
                       covers most nor asks for a link.";

/// Why our rule covers little.
const LINKED: &str = "Why: it takes no place without a link, and those that cover most have none.";

/// The place of the rule that a claim is about, and why the claim does not hold of it.
#[derive(Clone, Copy)]
struct Whose {
    place: fn(&Trial) -> Option<Dropped>,
    why: &'static str,
}

const PAPER: Whose = Whose { place: |trial| Some(trial.paper), why: NEAREST };
const OURS: Whose = Whose { place: |trial| trial.ours, why: LINKED };

impl Figures {
    /// The paper's claims. Where one is about what a place is worth, it follows for our rule, in the
    /// situations in which that has a place.
    #[must_use]
    pub fn claims(&self) -> Vec<Claim> {
        use Situation::{Covered, Inside, Transition};
        let near = &[Transition, Inside, Covered];
        vec![
            self.is_of_c2(),
            self.is_of_both(),
            self.leaves_less(),
            self.is_uncovered(),
            self.covers_more("the place covers more than one at random", PAPER, &Situation::ALL),
            self.covers_more("the same of our rule", OURS, near),
            self.leaves_width(
                "the next robot has more room than at random",
                PAPER,
                &Situation::ALL,
            ),
            self.leaves_width("the same of our rule", OURS, near),
            self.is_linked("the network hears the new node (here: 37 dB or more)", PAPER, near),
            self.is_linked("the same of our rule", OURS, near),
        ]
    }

    /// Adds the share of the caves that meet a condition.
    fn with_share(
        &self,
        claim: Claim,
        situation: Situation,
        meets: impl Fn(&Trial) -> Option<bool>,
    ) -> Claim {
        let met: Vec<bool> = self.of(situation).filter_map(meets).collect();
        let hits = met.iter().filter(|met| **met).count();
        let told = format!("{hits} of {} caves", met.len());
        claim.with((situation.name(), met.len()), told, share(hits, met.len()))
    }

    /// Adds the median of a value.
    fn with_median(
        &self,
        claim: Claim,
        situation: Situation,
        unit: &str,
        value: impl Fn(&Trial) -> Option<f32>,
    ) -> Claim {
        let mut values: Vec<f64> = self.of(situation).filter_map(value).map(f64::from).collect();
        values.sort_by(f64::total_cmp);
        let middle = values.get(values.len() / 2).copied().unwrap_or(f64::NAN);
        let told = format!("median {middle:+.1} {unit}, {} caves", values.len()).replace('-', "−");
        claim.with((situation.name(), values.len()), told, median(&values))
    }

    fn is_of_c2(&self) -> Claim {
        let quantity = "share of caves with the same place by c2 alone, to 0.5 m";
        let claim = Claim::new(
            ("figure 4", "far from the network the place is the one that maximises c2"),
            (quantity, Needs::AtLeast(ALL)),
            "Why: c1 counts the open ground within 20 m also where the network is too weak \
             everywhere, and so tells the places apart.",
        );
        self.with_share(claim, Situation::Far, |trial| Some(trial.by_one_m[1] <= SAME_M))
    }

    fn is_of_both(&self) -> Claim {
        let quantity = "share of caves in which c1 alone and c2 alone each choose another place";
        let claim = Claim::new(
            ("figure 4", "in the transition both criteria determine the place"),
            (quantity, Needs::MoreThan(0.5)),
            "Why: in most caves one of the criteria alone leads to the same place.",
        );
        let is_of_both = |trial: &Trial| trial.by_one_m.iter().all(|off| *off > SAME_M);
        self.with_share(claim, Situation::Transition, |trial| Some(is_of_both(trial)))
    }

    fn leaves_less(&self) -> Claim {
        let quantity =
            "median of the largest new area in the transition less that here, same cave, m²";
        let claim = Claim::new(
            ("figure 4", "inside a covered area there is little room for optimisation"),
            (quantity, Needs::MoreThan(0.0)),
            "Why: a relay covers 20 m, so that near the edge it covers much wherever it stands.",
        );
        [Situation::Inside, Situation::Covered].into_iter().fold(claim, |claim, situation| {
            self.with_median(claim, situation, "m²", |trial| {
                let there =
                    self.of(Situation::Transition).find(|other| other.seed == trial.seed)?;
                Some(there.most_m2 - trial.most_m2)
            })
        })
    }

    fn is_uncovered(&self) -> Claim {
        let claim = Claim::new(
            ("figure 4", "where little is uncovered, the place is in what is not covered yet"),
            ("share of caves with a place that is not covered", Needs::AtLeast(ALL)),
            "Why: the front holds covered cells, too, and the one nearest the goal is mostly one.",
        );
        self.with_share(claim, Situation::Covered, |trial| Some(!trial.paper.is_linked()))
    }

    fn covers_more(&self, words: &'static str, whose: Whose, situations: &[Situation]) -> Claim {
        let quantity = "median of the new area less that of a drop cell at random, m²";
        let claim =
            Claim::new(("section 3.2.1", words), (quantity, Needs::MoreThan(0.0)), whose.why);
        situations.iter().fold(claim, |claim, situation| {
            self.with_median(claim, *situation, "m²", |trial| {
                Some((whose.place)(trial)?.gain_m2 - trial.random.gain_m2)
            })
        })
    }

    fn leaves_width(&self, words: &'static str, whose: Whose, situations: &[Situation]) -> Claim {
        let quantity = "median of the free width less that beside a drop cell at random, m";
        let why = "Why: the rule moves to the wall, but not to where the passage is wide.";
        let claim = Claim::new(("section 3.2.2", words), (quantity, Needs::MoreThan(0.0)), why);
        situations.iter().fold(claim, |claim, situation| {
            self.with_median(claim, *situation, "m", |trial| {
                Some((whose.place)(trial)?.free_width_m - trial.random.free_width_m)
            })
        })
    }

    fn is_linked(&self, words: &'static str, whose: Whose, situations: &[Situation]) -> Claim {
        let needs = ("share of caves in which the network hears it", Needs::AtLeast(ALL));
        let claim = Claim::new(("section 3.2.1", words), needs, whose.why);
        situations.iter().fold(claim, |claim, situation| {
            self.with_share(claim, *situation, |trial| Some((whose.place)(trial)?.is_linked()))
        })
    }
}
