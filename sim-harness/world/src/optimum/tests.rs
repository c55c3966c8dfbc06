use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use radio_model::{Attenuation, PathLoss, UChain, Walls};
use units::Metres;

use super::*;
use crate::layout::Layout;
use crate::{RadioPlace, SkeletonPlace, Tunnel};

/// A winding gallery, and a radio in it with shadows and fades or without.
fn place(turns: &[f32], attenuation: Attenuation, fields: bool) -> (Arc<Tunnel>, Arc<Radio>) {
    let mut at = [0.0, 0.0];
    let mut heading = 0.0_f32;
    let mut line = vec![at];
    for turn in turns {
        heading += turn;
        at = [at[0] + 3.0 * heading.cos(), at[1] + 3.0 * heading.sin()];
        line.push(at);
    }
    let tunnel = Arc::new(Tunnel::dig(&Layout::corridor(&line, 1.0)).unwrap());
    let walls = Walls::Rock;
    let path_loss = PathLoss::UChain(UChain { attenuation, walls, loss_at_1m: Db(40.0) });
    let radio = RadioPlace {
        path_loss,
        shadowing: fields.then_some((Db(5.0), Metres(2.0))),
        fading_k: fields.then_some(6.0),
        seed: 11,
    };
    let radio = Arc::new(Radio::of(&tunnel, &radio));
    (tunnel, radio)
}

/// The way from the base to so many metres along the gallery.
fn way(tunnel: &Tunnel, along: f32) -> Path {
    let base = SkeletonPlace { edge: 0, along: 0.0 };
    tunnel.skeleton().path(base, SkeletonPlace { edge: 0, along })
}

/// The whole way.
fn whole(tunnel: &Tunnel) -> Path {
    way(tunnel, tunnel.skeleton().edge(0).line().length())
}

/// The lists of places of a chain's nodes: the base, the relays anywhere, the head.
fn anywhere(head: f32, between: &[f32], links: usize) -> Vec<Vec<f32>> {
    let mut places = vec![vec![0.0]];
    places.extend(std::iter::repeat_n(between.to_vec(), links.saturating_sub(1)));
    places.push(vec![head]);
    places
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 24,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// To the bit: what is computed once for all links is what each link computes for itself.
    #[test]
    fn chains_on_one_list_are_those_of_a_list_for_each_relay(
        turns in proptest::collection::vec(-0.5_f32..0.5, 1..5),
        jumps in any::<bool>(),
        fields in any::<bool>(),
        links in 0_usize..5,
        limit in 45.0_f32..75.0,
    ) {
        let attenuation = if jumps { Attenuation::WallCount } else { Attenuation::RockDepth };
        let (tunnel, radio) = place(&turns, attenuation, fields);
        let way = whole(&tunnel);
        let loss = |a: f32, b: f32| radio.strength(way.at(a), way.at(b)).loss().0;
        let head = way.length();
        let everywhere = grid(0.0, head, COARSE);
        let slow = solve(&loss, &anywhere(head, &everywhere, links));
        if links > 1 {
            let between = |y: usize, x: usize| loss(everywhere[y], everywhere[x]);
            prop_assert_eq!(&slow, &solve_on_one_list(&between, (&loss, head), &everywhere, links));
        }
        prop_assert!(best_chain(&radio, &way, links).worst <= slow.worst);

        let most = 3;
        let is_weak = |loss: Db| loss.0 > limit;
        let chains = BestChains::along(&radio, way.clone(), most);
        let first = chains.first_weak(is_weak);
        let by_hand = |links: usize| {
            let worst = |place: usize| {
                let places = anywhere(everywhere[place], &everywhere[..=place], links);
                solve(&loss, &places).worst
            };
            (0..everywhere.len()).find(|place| is_weak(worst(*place)))
        };
        let slow: Vec<_> = (1..=most).map(by_hand).collect();
        prop_assert_eq!(&first, &slow);
        // What was solved for the one question serves the other, and the other way round.
        for (links, first) in (1..=most).zip(first) {
            let Some(first) = first else { continue };
            prop_assert!(is_weak(chains.worst(links, first)));
            let before = (0..first).any(|place| is_weak(chains.worst(links, place)));
            prop_assert!(!before, "{links} links, before place {first}");
        }
    }
}

/// A long way is solved no farther than its chains reach, which is what makes a plan of a survey of
/// some kilometres fast.
#[test]
fn a_long_way_is_solved_as_far_as_its_chains_reach() {
    let (tunnel, radio) = place(&[0.0; 100], Attenuation::RockDepth, false);
    let chains = BestChains::along(&radio, whole(&tunnel), 3);
    assert_eq!(chains.last(), 3000);
    let weak = chains.first_weak(|loss| loss.0 > 60.0);
    let farthest = weak.into_iter().flatten().max().unwrap();
    assert!(farthest < 400, "{farthest}");
    assert_eq!(chains.solved.read().unwrap().places.len(), farthest + 1);
}

#[test]
fn a_way_of_no_length_has_its_chain_in_one_place() {
    let (tunnel, radio) = place(&[0.0], Attenuation::RockDepth, false);
    let chain = best_chain(&radio, &way(&tunnel, 0.0), 3);
    assert_eq!(chain.positions, [0.0; 4]);
}
