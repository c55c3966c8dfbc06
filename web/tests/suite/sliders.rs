//! A slider changes the value that it is for, and no other.

use serde_json::json;

use crate::opened::open;

/// The scenario's launch limit is lower than the slider goes, and one of the link's values holds a `=`.
#[tokio::test]
async fn a_slider_leaves_the_other_values_as_they_are_in_chromium() {
    const PILOT: &str = "pilot=[{ at_s = 0, order = \"explore\", speed_mps = 0.1 }]";
    let fragment = format!("scenario=random-n15&set={}", encoded(PILOT));
    let mut browser = open("sliders", &fragment).await;
    let limit = "document.getElementById('launch-now').value";
    assert_eq!(browser.evaluate(limit).await, "−200 dBm");
    let moved = "{ const slider = document.getElementById('loss'); slider.value = 40; \
                 slider.dispatchEvent(new Event('change')); 0 }";
    browser.evaluate(moved).await;
    browser.wait_for("uchain.page.setting.packet_loss === 0.4").await;
    let set = browser.evaluate("uchain.page.recipe.set").await;
    assert_eq!(set, json!([PILOT, "radio.packet_loss=0.4"]));
    assert_eq!(browser.evaluate("uchain.page.setting.launch_dbm").await, -200);
    assert_eq!(browser.evaluate(limit).await, "−200 dBm");
}

/// A text as a value of a link.
fn encoded(text: &str) -> String {
    text.bytes().map(|byte| format!("%{byte:02X}")).collect()
}
