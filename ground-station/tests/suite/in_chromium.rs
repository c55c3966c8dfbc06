//! The page in a real browser: a mission by keyboard, and how the page looks.

use std::path::PathBuf;

use sim_harness::serve::Event;
use units::{MetresPerSecond, NodeId, Order};

use crate::browser::{Browser, LEAST_CONTRAST};
use crate::severed_line::Line;
use crate::simulated_chain::SimulatedChain;
use crate::stalling_proxy::StallingProxy;
use crate::station_process::StationProcess;

/// A scratch folder that a test begins with empty.
pub(crate) fn folder(test: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

async fn open(test: &str, station: &StationProcess) -> Browser {
    let url = format!("http://{}/", station.page);
    let mut browser = Browser::open(&folder(test), &url).await;
    browser.wait_for("document.querySelectorAll('#drones li').length === 4").await;
    browser
}

const HEAD_FLIES: &str = "document.querySelector('#drones li').innerText.includes('leading')";

#[tokio::test]
#[ignore = "needs chromium"]
async fn a_mission_by_keyboard_in_chromium() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut browser = open("keyboard", &station).await;
    let all_good = "document.querySelectorAll('#checks .good').length === 6";
    browser.wait_for(all_good).await;
    browser.press("ArrowUp").await;
    browser.press("e").await;
    let is_explore =
        |event: &Event| *event == Event::Ordered(Order::explore(MetresPerSecond(0.25)));
    chain.wait_for("order to explore", is_explore).await;
    browser.wait_for(HEAD_FLIES).await;
    browser.press("1").await;
    browser.wait_for("document.body.innerText.includes('taken the order to branch left')").await;
    browser.wait_for(&is_told("The head takes off.")).await;
    browser
        .wait_for("document.getElementById('flight').innerText.startsWith('In flight for 0:')")
        .await;
    let curve = "document.querySelector('#drones li[data-node=\"0\"] .strip .strength') !== null";
    browser.wait_for(curve).await;
    the_curves_of_a_page_that_is_opened_later_begin_as_early(&mut browser, &station).await;
    browser.press("r").await;
    chain.wait_for("order to return", |event| *event == Event::Ordered(Order::Return)).await;
    browser.press("Escape").await;
    chain.wait_for("stop", |event| *event == Event::Ordered(Order::Stop)).await;
    let all_answered = "document.querySelectorAll('#answers .good').length === 5";
    browser.wait_for(all_answered).await;
    browser.wait_for(&is_told("The head has stopped its motors.")).await;
    browser
        .wait_for("document.getElementById('flight').innerText.startsWith('The flight lasted ')")
        .await;
}

/// The station has kept what it heard of the links before there was the second page.
async fn the_curves_of_a_page_that_is_opened_later_begin_as_early(
    first: &mut Browser,
    station: &StationProcess,
) {
    let begin = "strips.seen.get(0)[0][0]";
    first.wait_for(&format!("strips.seen.get(0).at(-1)[0] > {begin} + 3")).await;
    let began = first.evaluate(begin).await.as_f64().unwrap();
    let mut later = open("later", station).await;
    let begins = later.evaluate(begin).await.as_f64().unwrap();
    assert!((begins - began).abs() < 1.5, "{begins} s, not {began} s");
}

/// Whether the page lists that this has happened.
fn is_told(what: &str) -> String {
    format!("document.getElementById('notices').innerText.includes('{what}')")
}

/// A gamepad whose shoulder button is held or not, and whose stick is pushed to the end.
fn gamepad(is_held: bool) -> String {
    format!(
        "navigator.getGamepads = () => [{{ axes: [0, -1], \
         buttons: Array(6).fill({{ pressed: {is_held} }}) }}]; true"
    )
}

#[tokio::test]
#[ignore = "needs chromium"]
async fn a_gamepad_flies_the_head_while_its_button_is_held_in_chromium() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut browser = open("gamepad", &station).await;
    let speed = |speed| move |event: &Event| *event == Event::Ordered(Order::explore(speed));
    browser.evaluate(&gamepad(true)).await;
    chain.wait_for("order of the stick", speed(MetresPerSecond(0.4))).await;
    browser.evaluate(&gamepad(false)).await;
    chain.wait_for("head that hovers", speed(MetresPerSecond(0.0))).await;
}

/// A hold after the recall would keep the chain in the tunnel.
#[tokio::test]
#[ignore = "needs chromium"]
async fn a_gamepad_that_is_let_go_does_not_end_a_recall_in_chromium() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut browser = open("overruled", &station).await;
    browser.evaluate(&gamepad(true)).await;
    browser.wait_for(HEAD_FLIES).await;
    browser.press("r").await;
    chain.wait_for("order to return", |event| *event == Event::Ordered(Order::Return)).await;
    browser.evaluate(&gamepad(false)).await;
    let is_head = |event: &Event| matches!(event, Event::Landed(node) if node.id == NodeId(0));
    chain.wait_for("head at home", is_head).await;
    let hover = Event::Ordered(Order::explore(MetresPerSecond(0.0)));
    assert!(!chain.events().contains(&hover), "{:?}", chain.events());
}

/// The stick is let go while nothing comes from the station: the hold goes out as soon as it can.
#[tokio::test]
#[ignore = "needs chromium"]
async fn a_gamepad_that_is_let_go_in_a_short_stall_holds_the_head_in_chromium() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let proxy = StallingProxy::to(station.page);
    let url = format!("http://{}/", proxy.at);
    let mut browser = Browser::open(&folder("stalled-gamepad"), &url).await;
    browser.wait_for("document.querySelectorAll('#drones li').length === 4").await;
    browser.evaluate(&gamepad(true)).await;
    browser.wait_for(HEAD_FLIES).await;
    proxy.freeze();
    browser.wait_for("line.age() > 550").await;
    browser.evaluate(&gamepad(false)).await;
    browser.wait_for("gamepad.told === undefined").await;
    proxy.flow();
    browser.wait_for("document.body.innerText.includes('taken the order to hold')").await;
    let hover = Event::Ordered(Order::explore(MetresPerSecond(0.0)));
    chain.wait_for("head that hovers", |event| *event == hover).await;
}

/// What the line loses of the keyboard's orders gives no order of the gamepad.
#[tokio::test]
#[ignore = "needs chromium"]
async fn a_line_that_breaks_after_a_recall_does_not_end_it_in_chromium() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let proxy = StallingProxy::to(station.page);
    let url = format!("http://{}/", proxy.at);
    let mut browser = Browser::open(&folder("broken-recall"), &url).await;
    browser.wait_for("document.querySelectorAll('#drones li').length === 4").await;
    browser.press("e").await;
    browser.wait_for(HEAD_FLIES).await;
    browser.press("r").await;
    chain.wait_for("order to return", |event| *event == Event::Ordered(Order::Return)).await;
    proxy.freeze();
    browser.press("r").await;
    proxy.reset();
    proxy.flow();
    browser.wait_for("line.isOpen() && steers && line.age() < 500").await;
    let is_head = |event: &Event| matches!(event, Event::Landed(node) if node.id == NodeId(0));
    chain.wait_for("head at home", is_head).await;
    let hover = Event::Ordered(Order::explore(MetresPerSecond(0.0)));
    assert!(!chain.events().contains(&hover), "{:?}", chain.events());
}

/// The page has connected anew several times when the station goes on.
#[cfg(unix)]
#[tokio::test]
#[ignore = "needs chromium"]
async fn a_key_that_was_pressed_while_the_station_was_suspended_does_nothing_in_chromium() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &[]);
    let mut browser = open("suspended", &station).await;
    station.signal("-STOP");
    browser.press("e").await;
    browser.wait_for("line.age() > 7000").await;
    browser.press("e").await;
    browser.wait_for("at('warning').innerText.includes('NOT SENT, to explore')").await;
    station.signal("-CONT");
    browser.wait_for("line.isOpen() && line.age() < 500 && steers").await;
    let ordered = |event: &Event| matches!(event, Event::Ordered(_) | Event::TakesOff(_));
    assert!(!chain.events().iter().any(ordered), "{:?}", chain.events());
    browser.press("e").await;
    let explore = Event::Ordered(Order::explore(MetresPerSecond(0.2)));
    chain.wait_for("order to explore", |event| *event == explore).await;
}

/// The station has the stop, and is killed before the base has answered: the page gives the stop to
/// the station that comes after it, where the page looks on.
#[tokio::test]
#[ignore = "needs chromium"]
async fn a_stop_outlives_the_station_that_has_heard_it_in_chromium() {
    let chain = SimulatedChain::demo();
    let line = Line::to(&chain.address());
    let station = StationProcess::start(&line.address(), &[]);
    let mut browser = open("restarted", &station).await;
    browser.press("e").await;
    browser.wait_for(HEAD_FLIES).await;
    line.cut();
    browser.press("Escape").await;
    browser.wait_for("at('unheard').innerText.includes('NOT ARRIVED at the base')").await;
    let page = station.page;
    station.kill();
    browser.wait_for("at('unheard').innerText.includes('NOT ARRIVED')").await;
    line.mend();
    let station = StationProcess::start_again(&line.address(), page);
    chain.wait_for("stop", |event| *event == Event::Ordered(Order::Stop)).await;
    browser.wait_for("line.stop === null && !at('unheard').checkVisibility()").await;
    assert_eq!(browser.evaluate("steers || line.state.steering !== null").await, false);
    drop(station);
}

#[tokio::test]
#[ignore = "needs chromium"]
async fn the_map_shows_the_chain_in_chromium() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &["--map", "demo"]);
    let mut browser = open("map", &station).await;
    browser.wait_for("document.querySelectorAll('#map .mark').length === 5").await;
    browser.wait_for("document.querySelectorAll('#map .link').length === 4").await;
    browser.wait_for("document.querySelector('#map .floor').getAttribute('d').length > 50").await;
    let words = "document.getElementById('map').getAttribute('aria-label')";
    browser.wait_for(&format!("{words}.includes('the head 1 m from the base; relay 1')")).await;
    browser.press("e").await;
    browser.wait_for(&format!("{words}.includes('the head 2 m from the base')")).await;
    browser.wait_for("document.querySelectorAll('#map .airborne').length > 0").await;
    // All marks lie within the picture.
    let inside = "[...document.querySelectorAll('#map .mark')].every((mark) => { \
                  const [a, b] = [mark, document.getElementById('map')].map((e) => e.getBoundingClientRect()); \
                  return a.left >= b.left && a.right <= b.right && a.top >= b.top && a.bottom <= b.bottom; })";
    assert_eq!(browser.evaluate(inside).await, true);
}

/// The least contrast of a text with its background that WCAG 2.2 asks for at level AA.
const CONTRAST: f64 = 4.5;

#[tokio::test]
#[ignore = "needs chromium"]
async fn the_page_is_readable_narrow_and_wide_light_and_dark_in_chromium() {
    let chain = SimulatedChain::demo();
    let station = StationProcess::start(&chain.address(), &["--map", "demo"]);
    let mut browser = open("looks", &station).await;
    browser.press("e").await;
    browser.wait_for(HEAD_FLIES).await;
    let nameless = "[...document.querySelectorAll('button, input')].filter((e) => \
                    !(e.innerText.trim() || e.labels?.length)).length";
    assert_eq!(browser.evaluate(nameless).await, 0);
    let pictures = folder("pictures");
    for (width, scheme) in [(1_000, "light"), (1_000, "dark"), (400, "light"), (400, "dark")] {
        browser.look(width, scheme).await;
        let contrast = browser.evaluate(LEAST_CONTRAST).await.as_f64().unwrap();
        assert!(contrast >= CONTRAST, "{scheme}: {contrast}");
        let needed = browser.evaluate("document.documentElement.scrollWidth").await;
        assert!(needed.as_u64().unwrap() <= u64::from(width), "{width}: {needed}");
        browser.picture(&pictures.join(format!("station-{width}-{scheme}.png.base64"))).await;
    }
    browser.press("Escape").await;
    browser.wait_for("document.querySelectorAll('#answers .good').length === 5").await;
    for scheme in ["light", "dark"] {
        browser.look(400, scheme).await;
        let contrast = browser.evaluate(LEAST_CONTRAST).await.as_f64().unwrap();
        assert!(contrast >= CONTRAST, "{scheme}, stopped: {contrast}");
    }
}
