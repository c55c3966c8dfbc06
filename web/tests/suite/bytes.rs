//! The same mission in the browser and on this machine gives the same bytes.

use std::path::Path;

use serde_json::{Value, json};
use sim_harness::mission::Mission;
use sim_harness::report::csv;
use uchain_web::recipe::Recipe;
use uchain_web::{Dropped, Flight};

use crate::opened::{ask, flown, open};

/// The missions that are the same everywhere, as `.ci/run` flies them on other machines.
fn recipes() -> Vec<Value> {
    const MISSIONS: &str = include_str!("../../../tests/missions.txt");
    MISSIONS.lines().filter(|line| !line.starts_with('#')).map(recipe).collect()
}

/// The recipe of a line of the list: name, seed, scenario or its file, and values of its keys.
fn recipe(line: &str) -> Value {
    let words: Vec<_> = line.split_whitespace().collect();
    let [_, seed, scenario, set @ ..] = &words[..] else { panic!("{line}") };
    let seed: u64 = seed.parse().unwrap();
    if scenario.ends_with(".toml") {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(scenario);
        return json!({ "text": std::fs::read_to_string(file).unwrap(), "seed": seed, "set": set });
    }
    json!({ "scenario": scenario, "seed": seed, "set": set })
}

/// The text of `trace.csv` that this machine makes of a mission.
pub(crate) fn trace_here(recipe: &Value, files: &Dropped) -> String {
    let recipe = Recipe::read(&recipe.to_string()).unwrap();
    let scenario = recipe.scenario(files.memory()).unwrap();
    let trace = Mission::record(&scenario, &scenario.world(), recipe.seed());
    let mut bytes = Vec::new();
    csv::write(&trace, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// The summary that this machine makes of a mission.
fn summary_here(recipe: &Value, files: &Dropped) -> String {
    let mut flight = Flight::new(&recipe.to_string(), files).unwrap();
    while flight.advance(1_000_000) {}
    flight.summary()
}

/// Fails with the first line that differs, since both texts have thousands.
pub(crate) fn same(name: &Value, page: &str, here: &str) {
    assert!(here.len() > 500, "{name}: {here}");
    let differ = page.lines().zip(here.lines()).enumerate().find(|(_, (page, here))| page != here);
    assert!(page == here, "{name}, line, page and here: {differ:?}");
}

#[tokio::test]
async fn the_page_and_this_machine_write_the_same_bytes_in_chromium() {
    let mut browser = open("bytes", "").await;
    let files = Dropped::default();
    for recipe in recipes() {
        let record = flown(&mut browser, &recipe).await;
        same(&recipe, record["csv"].as_str().unwrap(), &trace_here(&recipe, &files));
        same(&recipe, record["summary"].as_str().unwrap(), &summary_here(&recipe, &files));
    }
}

/// Orders by the keyboard and a relay that is killed make a link, from which this machine flies the
/// same mission.
#[tokio::test]
async fn a_flight_by_hand_is_flown_again_from_its_link_in_chromium() {
    let mut browser = open("by-hand", "scenario=demo&seed=3").await;
    ask(&mut browser, "pace", json!(20)).await;
    browser.key_down("ArrowUp").await;
    browser.wait_for("uchain.page.frame.drones[2].z > 0.1").await;
    browser.key_up("ArrowUp").await;
    browser.evaluate("document.querySelectorAll('#drones button')[1].click()").await;
    browser.wait_for("uchain.page.frame.drones[1].lost").await;
    browser.press("r").await;
    browser.wait_for("uchain.page.flown?.pilot?.at(-1).order === 'return'").await;
    ask(&mut browser, "finish", Value::Null).await;
    let record = ask(&mut browser, "record", Value::Null).await;
    // After the end, there is nothing to order and nothing to fly.
    browser.press("l").await;
    ask(&mut browser, "finish", Value::Null).await;
    let after = ask(&mut browser, "record", Value::Null).await;
    assert!(after == record, "the mission went on after its end");
    let recipe = &record["flown"];
    let steps = recipe["pilot"].as_array().unwrap();
    assert!(steps.len() >= 3 && recipe["loss"][0]["drone"] == 1, "{recipe}");
    same(recipe, record["csv"].as_str().unwrap(), &trace_here(recipe, &Dropped::default()));
    // The file for the command is the same mission, too.
    let text = json!({ "text": record["toml"], "seed": 3 });
    same(&text, record["csv"].as_str().unwrap(), &trace_here(&text, &Dropped::default()));
    // Another page flies it from the link.
    browser.wait_for("location.hash.includes('packed')").await;
    let link = browser.evaluate("location.hash.slice(1)").await;
    let mut other = open("from-link", link.as_str().unwrap()).await;
    ask(&mut other, "finish", Value::Null).await;
    let again = ask(&mut other, "record", Value::Null).await;
    same(recipe, again["csv"].as_str().unwrap(), record["csv"].as_str().unwrap());
}

/// A survey that is dropped on the page.
#[tokio::test]
async fn a_dropped_survey_is_flown_and_planned_in_chromium() {
    const CAVE: &str = include_str!("../../../tests/caves/crooked.svx");
    let mut browser = open("survey", "").await;
    browser.evaluate(&dropped_on_page(CAVE, "crooked.svx")).await;
    browser.wait_for("uchain.page.setting?.name === 'crooked'").await;
    browser.evaluate("document.getElementById('ask').click()").await;
    browser
        .wait_for("document.getElementById('answer').innerText.includes('no link weaker than')")
        .await;
    let mut files = Dropped::new();
    files.add("crooked.svx", CAVE.as_bytes().to_vec());
    ask(&mut browser, "finish", Value::Null).await;
    let record = ask(&mut browser, "record", Value::Null).await;
    let recipe = json!({ "map": "crooked.svx" });
    same(&recipe, record["csv"].as_str().unwrap(), &trace_here(&recipe, &files));
    let here = uchain_web::plan_relays(&recipe.to_string(), &files, 3.0).unwrap();
    let page = ask(&mut browser, "plan", json!({ "recipe": recipe, "margin": 3 })).await;
    assert_eq!(page["text"], here.parse::<Value>().unwrap()["text"]);
    // The link holds the survey.
    browser.wait_for("location.hash.includes('packed')").await;
    // A file that is refused leaves the survey where it was, and another file can be chosen.
    let words = "document.getElementById('wrong').innerText";
    browser.evaluate(&dropped_on_page("1 2 x", "bad.svx")).await;
    browser.wait_for(&format!("{words}.includes('bad.svx:1')")).await;
    assert_eq!(browser.evaluate("document.getElementById('entry').value").await, "bad.svx");
    let opened = ask(&mut browser, "open", json!({ "recipe": recipe })).await;
    assert_eq!(opened["setting"]["name"], "crooked");
}

/// A robot's map, whose picture is a file of its own, and a world of the SubT Challenge, whose graph and
/// tiles are two files.
#[tokio::test]
async fn a_dropped_map_or_world_is_flown_in_chromium() {
    let gallery: [(&str, &[u8]); 2] = [
        ("gallery.yaml", include_bytes!("../../../tests/maps/gallery.yaml")),
        ("gallery.pgm", include_bytes!("../../../tests/maps/gallery.pgm")),
    ];
    let world: [(&str, &[u8]); 2] = [
        ("crossing.dot", include_bytes!("../../../tests/maps/crossing.dot")),
        ("crossing.sdf", include_bytes!("../../../tests/maps/crossing.sdf")),
    ];
    let mut browser = open("map", "").await;
    for given in [gallery, world] {
        let entry = given[0].0;
        browser.evaluate(&files_dropped_on_page(&given)).await;
        let name = entry.split('.').next().unwrap();
        let is_open = format!(
            "uchain.page.setting?.name === '{name}' && uchain.page.recipe.map === '{entry}'"
        );
        browser.wait_for(&is_open).await;
        ask(&mut browser, "finish", Value::Null).await;
        let record = ask(&mut browser, "record", Value::Null).await;
        let mut files = Dropped::new();
        for (name, bytes) in given {
            files.add(name, bytes.to_vec());
        }
        let recipe = json!({ "map": entry });
        same(&recipe, record["csv"].as_str().unwrap(), &trace_here(&recipe, &files));
    }
}

/// The JavaScript that drops a file on the page.
fn dropped_on_page(text: &str, name: &str) -> String {
    files_dropped_on_page(&[(name, text.as_bytes())])
}

/// The JavaScript that drops these files on the page at once.
fn files_dropped_on_page(files: &[(&str, &[u8])]) -> String {
    let each = files.iter().map(|(name, bytes)| {
        format!("given.items.add(new File([new Uint8Array({bytes:?})], {name:?})); ")
    });
    format!(
        "{{ const given = new DataTransfer(); {} \
         const input = document.getElementById('files'); input.files = given.files; \
         input.dispatchEvent(new Event('change')); 0 }}",
        each.collect::<String>()
    )
}

/// A mistake is said in the command's own line, and the mission before it flies on.
#[tokio::test]
async fn what_cannot_be_flown_is_refused_with_a_line_in_chromium() {
    let mut browser = open("refused", "scenario=dem").await;
    let words = "document.getElementById('wrong').innerText";
    browser.wait_for(&format!("{words}.includes('there is no scenario')")).await;
    browser.wait_for("uchain.page.setting.name === 'demo'").await;
    browser.evaluate(&dropped_on_page("1 2 x", "bad.svx")).await;
    browser.wait_for(&format!("{words}.includes('bad.svx:1')")).await;
    browser.wait_for("uchain.page.setting.name === 'demo' && uchain.page.frame.t > 0").await;
    for (link, part) in [
        ("relay=4", "the link has \"relay\""),
        ("relays=abc", "relays=abc: give a whole number"),
        ("scenario=demo&packed=AAAA", "the link is damaged"),
    ] {
        browser.evaluate(&format!("location.hash = '{link}'; 0")).await;
        browser.wait_for(&format!("{words}.includes('{part}')")).await;
    }
}

/// Orders and losses from a caller count between rounds, and a scenario holds them.
#[test]
fn a_steered_flight_is_flown_again_from_its_recipe() {
    let mut flight =
        Flight::new(r#"{ "scenario": "t-junction", "seed": 5 }"#, &Dropped::new()).unwrap();
    let orders = [
        (3_140_000, "explore", 0.35, "left"),
        (41_000_000, "explore", -0.1, ""),
        (1_000, "explore", 0.25, "right"),
        (20_020_000, "return", 0.0, ""),
        (30_000_000, "explore", 0.2, ""),
    ];
    for (n, (us, order, speed_mps, branch)) in orders.into_iter().enumerate() {
        flight.advance(us);
        flight.steer(order, speed_mps, branch).unwrap();
        if n == 3 {
            flight.lose(1);
        }
    }
    while flight.advance(1_000_000) {}
    let recipe: Value = flight.flown().parse().unwrap();
    // The scenario's own pilot gives the first.
    assert_eq!(recipe["pilot"].as_array().map(Vec::len), Some(1 + orders.len()), "{recipe}");
    same(&recipe, &flight.trace_csv(), &trace_here(&recipe, &Dropped::new()));
}

/// What is steered in a map is steered in its whole mission, whose pilot would have turned back.
#[test]
fn a_steered_flight_in_a_survey_is_flown_again_from_its_recipe() {
    let mut files = Dropped::new();
    files.add("crooked.svx", include_bytes!("../../../tests/caves/crooked.svx").to_vec());
    let mut flight = Flight::new(r#"{ "map": "crooked.svx", "relays": 2 }"#, &files).unwrap();
    flight.steer("explore", 0.3, "").unwrap();
    flight.advance(100_000_000);
    flight.steer("land", 0.0, "").unwrap();
    while flight.advance(10_000_000) {}
    let recipe: Value = flight.flown().parse().unwrap();
    same(&recipe, &flight.trace_csv(), &trace_here(&recipe, &files));
}

#[test]
fn an_order_or_a_recipe_that_is_none_is_refused() {
    let files = Dropped::new();
    let mut flight = Flight::new("{}", &files).unwrap();
    assert!(flight.steer("explore", 7.0, "").is_err());
    assert!(flight.steer("explore", 0.2, "up").is_err());
    assert!(flight.steer("fly", 0.2, "").is_err());
    for (recipe, part) in [
        ("7", "the link is not one of this page"),
        (r#"{ "scenario": "dem" }"#, "did you mean demo?"),
        (r#"{ "set": ["radio.packet_loss=2"] }"#, "radio.packet_loss=2: "),
        (r#"{ "map": "none.svx" }"#, "none.svx"),
        (r#"{ "scenario": "short-hop", "set": ["fidelity=virtual"] }"#, "virtual"),
    ] {
        let error = Flight::new(recipe, &files).err().unwrap_or_default();
        assert!(error.contains(part), "{recipe}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}
