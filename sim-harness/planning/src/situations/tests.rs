use super::*;

/// Some caves, with the goals that they have.
fn caves() -> impl Iterator<Item = (Cave, [Option<Cell>; 4])> {
    (0..4).filter_map(|n| Cave::dig(FIRST_CAVE + n)).map(|cave| {
        let goals = cave.goals();
        (cave, goals)
    })
}

/// The rule of `relay_placement` is fast by sums along rows; here it is by the paper's words.
#[test]
fn the_rule_takes_what_the_papers_words_say() {
    let mut tried = 0;
    for (mut cave, goals) in caves() {
        for (situation, goal) in Situation::ALL.into_iter().zip(goals) {
            let Some(goal) = goal else { continue };
            let criteria = Criteria::of(&cave, goal);
            let trial = Trial::of(&mut cave, situation, goal, &criteria).unwrap();
            let by_hand = criteria.taken(|scored| scored.is_on_front);
            assert_eq!(Some(trial.paper.cell), by_hand, "cave {}, {situation:?}", cave.seed);
            assert!(trial.paper.off_goal_m <= 10.0 && trial.paper.is_beside_wall, "{trial:?}");
            tried += 1;
        }
    }
    assert!(tried >= 8, "{tried} goals");
}

#[test]
fn the_situations_are_what_they_are_called() {
    for (cave, goals) in caves() {
        let covered = |cell: &Cell| cave.network.covers(*cell);
        if let Some(goal) = goals[0] {
            let reached = cave.drop_cells(goal).flat_map(|cell| cave.around(cell, 20.0));
            assert_eq!(reached.filter(covered).count(), 0, "cave {}, far", cave.seed);
        }
        for (situation, goal) in Situation::ALL.into_iter().zip(goals).skip(1) {
            let Some(goal) = goal else { continue };
            let all = cave.drop_cells(goal).count();
            let share = cave.drop_cells(goal).filter(covered).count() as f32 / all as f32;
            let [least, most] = match situation {
                Situation::Transition => [0.25, 0.75],
                Situation::Inside => [0.75, 0.95],
                _ => [0.95, 0.9999],
            };
            assert!((least..=most).contains(&share), "cave {}, {situation:?}: {share}", cave.seed);
        }
    }
}

#[test]
fn each_situation_is_found_in_as_many_caves_as_asked_for() {
    let figures = make(2, 1, || ());
    for situation in Situation::ALL {
        assert_eq!(figures.of(situation).count(), 2, "{situation:?}");
    }
    let scenes: Vec<_> = figures.scenes.iter().map(|scene| scene.trial.situation).collect();
    assert_eq!(scenes, Situation::ALL);
    let claims = figures.claims();
    assert!(claims.iter().all(|claim| !claim.found.is_empty()));
    // Two caves tell nothing of a median.
    let undecided = |claim: &&measure::claim::Claim| {
        claim.quantity.starts_with("median")
            && claim.answer() == measure::claim::Answer::CannotBeTold
    };
    assert_eq!(claims.iter().filter(undecided).count(), 5);
}
