//! The page that `uchain run --out` writes of a mission (`report.html`), in a browser: nothing in it is cut,
//! covered or pale, narrow and wide, light and dark.

use serde_json::{Value, json};
use sim_harness::report::report;
use uchain_web::{Dropped, Flight};

use crate::browser::Browser;
use crate::looks::{LOOKS, is_readable};
use crate::opened::folder;

/// Counts the pairs of names on the map that cover one another, and the names that are cut.
const NAMES_IN_THE_WAY: &str = r##"(() => {
    const map = document.getElementById("map").getBoundingClientRect();
    const boxes = [...document.querySelectorAll("#map .name")]
        .filter((name) => getComputedStyle(name).display !== "none" && name.textContent)
        .map((name) => name.getBoundingClientRect());
    const covers = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
    const pairs = boxes.flatMap((a, n) => boxes.slice(n + 1).filter((b) => covers(a, b)));
    const cut = boxes.filter((box) => box.left < map.left - 1 || box.right > map.right + 1);
    return pairs.length + cut.length;
})()"##;

/// The report of a mission as the command writes it.
fn report_of(recipe: &Value) -> String {
    let mut flight = Flight::new(&recipe.to_string(), &Dropped::new()).unwrap();
    while flight.advance(1_000_000) {}
    report::html(flight.trace(), &flight.summary().parse().unwrap()).unwrap()
}

/// Opens the report of a mission at a place of its address, when the page is ready.
async fn opened(recipe: &Value, name: &str, place: &str, is_ready: &str) -> Browser {
    let folder = folder(&format!("report-{name}"));
    let file = folder.join("report.html");
    std::fs::write(&file, report_of(recipe)).unwrap();
    let url = format!("file://{}{place}", file.display());
    let mut browser = Browser::open(&folder.join("profile"), &url).await;
    browser.wait_for(is_ready).await;
    browser
}

async fn looks_right(browser: &mut Browser, name: &str) {
    for (width, scheme) in LOOKS {
        is_readable(browser, name, (width, scheme)).await;
        for part in 1..8 {
            let go = format!(
                "{{ const time = document.getElementById('time'); time.value = time.max * {part} / 8; \
                 time.dispatchEvent(new Event('input')); 0 }}"
            );
            browser.evaluate(&go).await;
            let hidden = browser.evaluate(NAMES_IN_THE_WAY).await;
            assert_eq!(hidden, 0, "{name}, {width}, at {part} of 8");
        }
    }
}

#[tokio::test]
async fn reports_are_readable_narrow_and_wide_light_and_dark_in_chromium() {
    let recipes = [
        json!({ "scenario": "demo", "seed": 1 }),
        json!({ "scenario": "cut", "seed": 1 }),
        json!({ "scenario": "swarm-both", "seed": 1 }),
        json!({ "scenario": "explore-room", "seed": 1 }),
    ];
    for recipe in recipes {
        let name = recipe["scenario"].as_str().unwrap();
        let is_ready = "document.querySelectorAll('#events button').length > 2";
        let mut browser = opened(&recipe, name, "", is_ready).await;
        looks_right(&mut browser, name).await;
    }
}

/// The map grows while the mission is played, is what it was when the mission is played back, and has frontiers until
/// all is known.
#[tokio::test]
async fn the_map_that_explorers_draw_grows_in_chromium() {
    let count = |class: &str| {
        format!("document.querySelectorAll('#map rect.{class}:not([display])').length")
    };
    let recipe = json!({ "scenario": "explore-room", "seed": 1 });
    let is_ready = format!("{} > 0", count("seen"));
    let mut browser = opened(&recipe, "map", "#t=10", &is_ready).await;
    let early = browser.evaluate(&count("seen")).await.as_u64().unwrap();
    let frontiers = browser.evaluate(&count("frontier")).await;
    let time = browser.evaluate("document.getElementById('time').value").await;
    let goals =
        "[...document.querySelectorAll('#map .goal')].some((it) => it.style.display !== 'none')";
    assert_eq!(browser.evaluate(goals).await, json!(true));
    let go = |at: &str| {
        format!(
            "(() => {{ const time = document.getElementById('time'); time.value = {at}; \
                 time.dispatchEvent(new Event('input')); return true; }})()"
        )
    };
    browser.evaluate(&go("time.max")).await;
    let late = browser.evaluate(&count("seen")).await.as_u64().unwrap();
    assert!(late > 2 * early && early > 50, "{early} cells at first, {late} at the end");
    let at_end = browser.evaluate(&count("frontier")).await.as_u64().unwrap();
    assert!(
        at_end < frontiers.as_u64().unwrap(),
        "{frontiers} frontiers at first, {at_end} at the end"
    );
    browser.evaluate(&go(time.as_str().unwrap())).await;
    assert_eq!(browser.evaluate(&count("seen")).await, json!(early));
    assert_eq!(browser.evaluate(&count("frontier")).await, frontiers);
}

/// A relay that was killed says no more, so that nothing shows a link of it.
#[tokio::test]
async fn a_drone_that_is_down_has_no_link_in_chromium() {
    let recipe = json!({ "scenario": "cut", "seed": 1 });
    let is_ready = "document.querySelectorAll('#nodes tbody tr').length > 4";
    let mut browser = opened(&recipe, "down", "#t=200", is_ready).await;
    let strengths = "[...document.querySelectorAll('#nodes tbody tr')] \
                     .filter((row) => row.cells[1].textContent === 'down') \
                     .map((row) => row.cells[4].textContent + row.cells[5].textContent)";
    assert_eq!(browser.evaluate(strengths).await, json!(["\u{2013}\u{2013}", "\u{2013}\u{2013}"]));
}
