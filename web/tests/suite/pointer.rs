//! Fingers and a mouse on the page.

use serde_json::{Value, json};

use crate::browser::Browser;

/// Makes the page that of a phone, 400 pixels wide and touched by fingers.
pub(crate) async fn phone(browser: &mut Browser) {
    let size = json!({ "width": 400, "height": 800, "deviceScaleFactor": 2, "mobile": true });
    browser.call("Emulation.setDeviceMetricsOverride", size).await;
    browser.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": true })).await;
}

/// The middle of an element, which is scrolled into view, in pixels of the window.
pub(crate) async fn middle(browser: &mut Browser, selector: &str) -> [f64; 2] {
    let find = format!(
        "(() => {{ const it = document.querySelector({selector:?}); it.scrollIntoView({{ block: 'center' }}); \
         const box = it.getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]; }})()"
    );
    pair(&browser.evaluate(&find).await)
}

/// The two numbers of a JSON list.
pub(crate) fn pair(value: &Value) -> [f64; 2] {
    [0, 1].map(|n| value[n].as_f64().unwrap_or_else(|| panic!("{value} is no pair of numbers")))
}

/// Puts fingers on the page, moves them there, or lifts those that are not in the list.
pub(crate) async fn touch(browser: &mut Browser, kind: &str, fingers: &[[f64; 2]]) {
    let finger = |(id, [x, y]): (usize, &[f64; 2])| json!({ "x": x, "y": y, "id": id });
    let points: Value = fingers.iter().enumerate().map(finger).collect();
    browser.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points })).await;
}

/// Taps with a finger.
pub(crate) async fn tap(browser: &mut Browser, at: [f64; 2]) {
    touch(browser, "touchStart", &[at]).await;
    touch(browser, "touchEnd", &[]).await;
}

/// Moves the mouse.
pub(crate) async fn hover(browser: &mut Browser, at: [f64; 2]) {
    mouse(browser, "mouseMoved", at).await;
}

/// Presses the mouse's button at the first place, and lets it go at the last.
pub(crate) async fn drag(browser: &mut Browser, way: &[[f64; 2]]) {
    hover(browser, way[0]).await;
    mouse(browser, "mousePressed", way[0]).await;
    for at in way {
        hover(browser, *at).await;
    }
    mouse(browser, "mouseReleased", way[way.len() - 1]).await;
}

async fn mouse(browser: &mut Browser, kind: &str, [x, y]: [f64; 2]) {
    let button = if kind == "mouseMoved" { "none" } else { "left" };
    let event = json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": 1 });
    browser.call("Input.dispatchMouseEvent", event).await;
}
