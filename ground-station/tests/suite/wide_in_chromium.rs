//! The page in a real browser on a wide screen: what an operator must see at once is inside the window,
//! and on the map no drone covers another.

use sim_harness::scenario::{Changes, Fidelity, Scenario};

use crate::browser::Browser;
use crate::in_chromium::folder;
use crate::simulated_chain::SimulatedChain;
use crate::station_process::StationProcess;

/// The numbers of relays of a short and of the longest chain.
const CHAINS: [usize; 2] = [3, 14];

/// A chain with so many relays at the mouth, whose drones have batteries, and its station's page in a
/// window of 1,440 by 900 pixels.
async fn open(
    test: &str,
    relays: usize,
    options: &[&str],
) -> (SimulatedChain, StationProcess, Browser) {
    let changes = Changes { relays: Some(relays), ..Changes::default() };
    let scenario = Scenario::open_with("demo", &changes).unwrap().at(Fidelity::Flight);
    let chain = SimulatedChain::of(scenario);
    let station = StationProcess::start(&chain.address(), options);
    let url = format!("http://{}/", station.page);
    let mut browser = Browser::open(&folder(&format!("{test}-{relays}")), &url).await;
    browser.look(1_440, "light").await;
    let drones = relays + 1;
    browser.wait_for(&format!("document.querySelectorAll('#drones li').length === {drones}")).await;
    let batteries = "document.getElementById('drones').innerText.match(/Battery for/g)?.length";
    browser.wait_for(&format!("{batteries} === {drones}")).await;
    browser.wait_for("document.querySelectorAll('#drones .strip').length > 0").await;
    (chain, station, browser)
}

/// The parts of the page that do not lie inside the window as a whole.
const OUTSIDE: &str = "[...document.querySelectorAll('#stop, #map, #orders button, #drones li')].filter((part) => { \
    const at = part.getBoundingClientRect(); \
    return at.width === 0 || at.left < 0 || at.top < 0 || at.right > innerWidth || at.bottom > innerHeight; \
    }).map((part) => part.innerText || part.id)";

#[tokio::test]
#[ignore = "needs chromium"]
async fn stop_orders_map_chain_and_batteries_are_in_a_wide_window_in_chromium() {
    for relays in CHAINS {
        for options in [&[][..], &["--map", "demo"]] {
            let (_chain, _station, mut browser) = open("wide", relays, options).await;
            assert_eq!(
                browser.evaluate("[innerWidth, innerHeight]").await,
                serde_json::json!([1440, 900])
            );
            let none = serde_json::json!([]);
            assert_eq!(browser.evaluate(OUTSIDE).await, none, "{relays} relays at the mouth");
            browser.press("e").await;
            browser.wait_for("document.querySelectorAll('#map .airborne').length > 0").await;
            assert_eq!(
                browser.evaluate(OUTSIDE).await,
                none,
                "{relays} relays, the head in flight"
            );
        }
    }
}

/// Pairs of marks that overlap, and marks that are not on the map as a whole.
const COVERED: &str = "(() => { \
    const names = (marks) => marks.map((mark) => mark.textContent).join(' and '); \
    const box = (part) => part.getBoundingClientRect(); \
    const marks = [...document.querySelectorAll('#map .mark')]; \
    const map = box(document.getElementById('map')); \
    const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom; \
    const isOn = (a) => a.left >= map.left && a.right <= map.right && a.top >= map.top && a.bottom <= map.bottom; \
    const pairs = marks.flatMap((one, n) => marks.slice(n + 1).map((other) => [one, other])); \
    return [...pairs.filter(([one, other]) => overlap(box(one), box(other))).map(names), \
            ...marks.filter((mark) => !isOn(box(mark))).map((mark) => names([mark]))]; \
    })()";

#[tokio::test]
#[ignore = "needs chromium"]
async fn no_mark_on_the_map_covers_another_at_the_mouth_in_chromium() {
    for options in [&[][..], &["--map", "demo"]] {
        let (_chain, _station, mut browser) = open("marks", 14, options).await;
        let marks = "document.querySelectorAll('#map .mark').length";
        for width in [1_440, 400] {
            browser.look(width, "light").await;
            browser
                .wait_for(&format!("chainMap.size[0] === at('map').clientWidth && {marks} === 16"))
                .await;
            assert_eq!(browser.evaluate(COVERED).await, serde_json::json!([]), "{width} pixels");
        }
    }
}
