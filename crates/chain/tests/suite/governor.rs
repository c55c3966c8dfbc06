//! The head without an order: where its links are too weak it comes back to where they bore it.

use chain::filter::LinkState;
use chain::governor::{Governor, HeadLinks};
use chain::launch::LaunchConfig;
use units::{Db, DbPerMetre, Metres, MetresPerDb, MetresPerSecond};

const CONFIG: LaunchConfig = LaunchConfig::AT_ONCE;

/// The speed of a head whose own link is so much stronger than the limit.
fn eased(spare: f32, sound: Option<f32>) -> MetresPerSecond {
    let loss = (CONFIG.limit + Db(spare)).loss();
    let slopes = [DbPerMetre(2.0); 2];
    let own = LinkState { loss, slopes, variance: 0.1, step: None, hump: Db(0.0) };
    let level = CONFIG.limit + Db(20.0);
    let links = HeadLinks { level, compliance: MetresPerDb(0.5), own: Some(own) };
    Governor::eased(&CONFIG, &links, sound.map(Metres))
}

#[test]
fn a_head_that_its_links_bear_stays() {
    assert_eq!(eased(0.0, Some(0.2)), MetresPerSecond::ZERO);
    assert_eq!(eased(5.0, None), MetresPerSecond::ZERO);
}

#[test]
fn a_head_that_is_a_little_too_far_out_comes_back_wherever_it_was_strong() {
    assert!(eased(-2.0, None) < MetresPerSecond::ZERO);
    assert!(eased(-2.0, Some(7.0)) < MetresPerSecond::ZERO);
}

/// A head that stood 8 dB below the limit, decimetres behind a corner, stayed there for as long as the pilot
/// gave no order, and its relays flew to and fro after it.
#[test]
fn a_head_behind_a_corner_comes_back_and_one_far_beyond_its_links_stays() {
    assert!(eased(-8.0, Some(0.3)) < MetresPerSecond::ZERO);
    assert_eq!(eased(-8.0, Some(3.0)), MetresPerSecond::ZERO, "the pilot has led it there");
    assert_eq!(eased(-8.0, None), MetresPerSecond::ZERO);
    assert_eq!(eased(-8.0, Some(0.0)), MetresPerSecond::ZERO, "the relay behind has left it");
}
