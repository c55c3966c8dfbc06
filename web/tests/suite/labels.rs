//! What the map shows is said in words for those who do not see it.

use crate::opened::open;

/// Only a chain has a head whose way counts.
#[tokio::test]
async fn the_map_is_told_in_the_words_of_its_mission_in_chromium() {
    let label = "document.getElementById('map').ariaLabel";
    for (scenario, words) in [
        ("demo", "/^The cave .*: the head is [1-9]\\d* m from the base\\.$/"),
        (
            "swarm-b",
            "/^The area .*: 3 of 3 in the air, and [1-9]\\d* % of the area was flown over\\.$/",
        ),
        (
            "explore-room",
            "/^The place .*: [1-9] of [1-9] in the air, and [1-9]\\d* % of the place is known\\.$/",
        ),
    ] {
        let mut browser = open(&format!("label-{scenario}"), &format!("scenario={scenario}")).await;
        browser.wait_for(&format!("{words}.test({label})")).await;
        let head = browser.evaluate(&format!("{label}.includes('head')")).await;
        assert_eq!(head, scenario == "demo", "{scenario}");
    }
}
