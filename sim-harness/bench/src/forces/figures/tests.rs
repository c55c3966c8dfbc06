use ::measure::claim::Answer;

use super::*;

fn few(name: &str, runs: usize) -> Reading {
    let rule = *readings().iter().find(|rule| rule.name == name).expect("a reading");
    let drones = 1..=PAPER_MOST;
    let cases = drones.flat_map(|drones| Place::ALL.map(move |place| Case { rule, drones, place }));
    let flown: Vec<Flown> = cases
        .map(|case| Flown { case, flights: flights(&case, runs, 200_000).expect("six drones") })
        .collect();
    let rows = flown.iter().flat_map(|one| rows(&one.case, &one.flights)).collect();
    Reading { rule, rows, flown }
}

#[test]
fn what_the_paper_says_of_safety_and_links_is_not_refuted_by_our_rule() {
    for claim in few("ours", 3).claims() {
        let promised = claim.source.starts_with("section") || claim.claim.contains("to its end");
        assert!(!promised || claim.answer() != Answer::DoesNotHold, "{claim}");
    }
}

#[test]
fn few_flights_tell_nothing_of_a_median_and_a_stuck_one_is_in_the_count() {
    let mut reading = few("ours", 3);
    let claims = reading.claims();
    assert!(claims.iter().all(|claim| claim.answer() != Answer::Holds), "3 flights");
    for flown in &mut reading.flown {
        for flight in &mut flown.flights {
            flight.legs.pop();
        }
    }
    let ends = reading.claims().into_iter().find(|claim| claim.claim.contains("to its end"));
    let ends = ends.expect("a claim");
    assert_eq!(ends.answer(), Answer::DoesNotHold, "{ends}");
    assert!(ends.found.iter().all(|found| found.told == "0 of 18 flights"), "{ends}");
}
