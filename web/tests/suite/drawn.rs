//! A cave is drawn on the page with fingers, with the mouse and with the keyboard, and is flown.

use serde_json::{Value, json};
use uchain_web::Dropped;

use crate::browser::Browser;
use crate::bytes::{same, trace_here};
use crate::looks::{LOOKS, is_readable};
use crate::opened::{ask, folder, open};
use crate::pointer::{drag, hover, middle, pair, phone, tap, touch};

const WORDS: &str = "document.getElementById('sketch-words').innerText";

/// Where a place of the drawing, metres, is in the window, pixels.
async fn pixel(browser: &mut Browser, [x, y]: [f64; 2]) -> [f64; 2] {
    let find = format!(
        "(() => {{ const {{ board }} = uchain.drawing; const box = board.canvas.getBoundingClientRect(); \
         const [x, y] = board.pixel([{x}, {y}]); return [box.left + x, box.top + y]; }})()"
    );
    pair(&browser.evaluate(&find).await)
}

async fn click(browser: &mut Browser, id: &str) {
    browser.evaluate(&format!("document.getElementById('{id}').click()")).await;
}

/// Opens the page and the panel for drawing, 1,440 pixels wide.
async fn opened(test: &str) -> Browser {
    let mut browser = open(test, "").await;
    browser.look(1_440, "light").await;
    click(&mut browser, "draw").await;
    browser.wait_for("uchain.drawing.board.scale > 0").await;
    middle(&mut browser, "#sketch").await;
    browser
}

async fn clicks(browser: &mut Browser, corners: &[[f64; 2]]) {
    for corner in corners {
        let at = pixel(browser, *corner).await;
        drag(browser, &[at]).await;
    }
}

/// Asserts that the corners are drawn where they were put, to a tenth of a metre and a pixel.
async fn has_galleries(browser: &mut Browser, galleries: &[&[[f64; 2]]]) {
    let drawn = browser.evaluate("uchain.drawing.sketch.galleries").await;
    let drawn = drawn.as_array().unwrap();
    assert_eq!(drawn.len(), galleries.len(), "{drawn:?}");
    for (corners, gallery) in drawn.iter().zip(galleries) {
        let corners: Vec<_> = corners.as_array().unwrap().iter().map(pair).collect();
        let near = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) < 0.2;
        assert!(
            corners.len() == gallery.len() && corners.iter().zip(*gallery).all(near),
            "{corners:?}"
        );
    }
}

/// An L with a branch, drawn by taps on a phone, is the same mission here, from its file, and from its link.
#[tokio::test]
async fn a_cave_that_fingers_draw_is_flown_again_from_its_link_in_chromium() {
    let mut browser = open("drawn", "").await;
    phone(&mut browser).await;
    let at = middle(&mut browser, "#draw").await;
    tap(&mut browser, at).await;
    browser.wait_for("uchain.drawing.board.scale > 0").await;
    middle(&mut browser, "#sketch").await;
    for corner in [[-9.0, -3.0], [4.0, -3.0], [4.0, 7.0], [-3.0, -3.0], [-3.0, 4.0]] {
        let at = pixel(&mut browser, corner).await;
        tap(&mut browser, at).await;
    }
    browser.wait_for(&format!("{WORDS}.includes('m of galleries in 4 legs')")).await;
    let main = [[-9.0, -3.0], [-3.0, -3.0], [4.0, -3.0], [4.0, 7.0]];
    has_galleries(&mut browser, &[&main, &[[-3.0, -3.0], [-3.0, 4.0]]]).await;
    let at = middle(&mut browser, "#fly-it").await;
    tap(&mut browser, at).await;
    browser.wait_for("uchain.page.recipe.text?.includes('[[tunnel.branch]]')").await;
    browser.wait_for("!document.getElementById('flight').hidden && uchain.page.frame.t > 0").await;
    ask(&mut browser, "finish", Value::Null).await;
    let record = ask(&mut browser, "record", Value::Null).await;
    let csv = record["csv"].as_str().unwrap();
    let flown = &record["flown"];
    same(flown, csv, &trace_here(flown, &Dropped::default()));
    let file = json!({ "text": record["toml"] });
    same(&file, csv, &trace_here(&file, &Dropped::default()));
    browser.wait_for("location.hash.includes('packed')").await;
    let link = browser.evaluate("location.hash.slice(1)").await;
    let mut other = open("drawn-link", link.as_str().unwrap()).await;
    ask(&mut other, "finish", Value::Null).await;
    let again = ask(&mut other, "record", Value::Null).await;
    same(flown, again["csv"].as_str().unwrap(), csv);
}

/// A bad drawing is told, is not flown, and is mended.
#[tokio::test]
async fn a_bad_drawing_is_told_and_stays_editable_in_chromium() {
    let mut browser = opened("bad-drawing").await;
    clicks(&mut browser, &[[-8.0, 0.0], [0.0, 0.0], [0.0, 1.0]]).await;
    browser.wait_for(&format!("{WORDS}.includes('shorter than its gallery is wide')")).await;
    assert_eq!(browser.evaluate("uchain.drawing.board.wrong").await, json!([[0, 1]]));
    click(&mut browser, "fly-it").await;
    // The corner is pulled away.
    let way = [pixel(&mut browser, [0.0, 1.0]).await, pixel(&mut browser, [0.0, 5.0]).await];
    drag(&mut browser, &way).await;
    browser.wait_for(&format!("{WORDS}.includes('13.0 m of galleries in 2 legs')")).await;
    clicks(&mut browser, &[[-5.0, 5.0], [-5.0, -5.0]]).await;
    browser.wait_for(&format!("{WORDS}.includes('Two legs cross')")).await;
    click(&mut browser, "fly-it").await;
    click(&mut browser, "undo").await;
    browser.wait_for(&format!("{WORDS}.includes('18.0 m of galleries in 3 legs')")).await;
    let widen = "{ const it = document.getElementById('gallery-width'); it.value = 2.9; \
                 it.dispatchEvent(new Event('input')); 0 }";
    browser.evaluate(widen).await;
    browser.wait_for(&format!("{WORDS}.includes('18.0 m of galleries')")).await;
    assert!(browser.evaluate("uchain.page.recipe.text").await.is_null(), "a bad drawing was flown");
    click(&mut browser, "fly-it").await;
    browser.wait_for("uchain.page.recipe.text?.includes('width_m = 2.9')").await;
    // The drawing is still there, and can be cleared; clearing is undone as well.
    click(&mut browser, "draw").await;
    let corners = "uchain.drawing.sketch.corners.length";
    click(&mut browser, "clear").await;
    browser.wait_for(&format!("{corners} === 0 && {WORDS}.includes('mouth of the cave')")).await;
    click(&mut browser, "undo").await;
    browser.wait_for(&format!("{corners} === 4")).await;
}

/// All that the panel does can be done without a pointer.
#[tokio::test]
async fn a_cave_is_drawn_by_the_keyboard_in_chromium() {
    let mut browser = opened("keyboard").await;
    let button = |id: &str| format!("document.getElementById('{id}').focus()");
    let towards = |degrees: u32| format!("document.getElementById('leg-way').value = {degrees}; 0");
    for (degrees, back) in [(0, 0), (90, 1), (0, 0)] {
        browser.evaluate(&towards(degrees)).await;
        browser.evaluate(&button("add-leg")).await;
        browser.press(" ").await;
        for _ in 0..back {
            browser.evaluate(&button("back")).await;
            browser.press(" ").await;
        }
    }
    has_galleries(
        &mut browser,
        &[&[[0.0, 0.0], [6.0, 0.0], [6.0, 6.0]], &[[6.0, 0.0], [12.0, 0.0]]],
    )
    .await;
    browser.evaluate(&button("back")).await;
    // The ring comes to each of the four corners.
    let mut rings = Vec::new();
    for _ in 0..4 {
        browser.press(" ").await;
        rings.push(browser.evaluate("uchain.drawing.sketch.pen").await);
    }
    assert_eq!(rings, [json!([6, 6]), json!([6, 0]), json!([0, 0]), json!([12, 0])]);
    // The arrows and Esc of the flight do nothing here.
    browser.press("Escape").await;
    browser.evaluate(&button("fly-it")).await;
    browser.press(" ").await;
    browser.wait_for("uchain.page.recipe.text?.includes('[[tunnel.branch]]')").await;
    assert!(browser.evaluate("uchain.page.flown").await.is_null(), "Esc stopped the motors");
}

/// Two fingers move and zoom the view, and draw nothing.
#[tokio::test]
async fn two_fingers_move_and_zoom_the_view_in_chromium() {
    let mut browser = open("fingers", "").await;
    phone(&mut browser).await;
    click(&mut browser, "draw").await;
    browser.wait_for("uchain.drawing.board.scale > 0").await;
    let [x, y] = middle(&mut browser, "#sketch").await;
    let before = browser.evaluate("uchain.drawing.board.scale").await.as_f64().unwrap();
    touch(&mut browser, "touchStart", &[[x - 50.0, y]]).await;
    touch(&mut browser, "touchStart", &[[x - 50.0, y], [x + 50.0, y]]).await;
    touch(&mut browser, "touchMove", &[[x - 50.0, y], [x + 150.0, y]]).await;
    touch(&mut browser, "touchEnd", &[]).await;
    let scale = browser.evaluate("uchain.drawing.board.scale").await.as_f64().unwrap();
    assert!((scale / before - 2.0).abs() < 0.01, "{before} and {scale} pixels a metre");
    assert_eq!(browser.evaluate("uchain.drawing.sketch.corners.length").await, 0);
    // What was under the first finger is still under it.
    let held = pixel(&mut browser, [-50.0 / before, 0.0]).await;
    assert!((held[0] - (x - 50.0)).hypot(held[1] - y) < 1.0, "{held:?}");
}

#[tokio::test]
async fn the_drawing_is_readable_narrow_and_wide_light_and_dark_in_chromium() {
    let mut browser = opened("drawing-looks").await;
    clicks(
        &mut browser,
        &[[-8.0, 0.0], [4.0, 0.0], [4.0, 6.0], [-2.0, 0.0], [-2.0, 5.0], [-9.0, 5.0]],
    )
    .await;
    let pictures = folder("drawing-pictures");
    for (width, scheme) in LOOKS {
        for state in ["good", "bad"] {
            is_readable(&mut browser, "the drawing", (width, scheme)).await;
            click(&mut browser, "all-of-it").await;
            middle(&mut browser, "#sketch").await;
            if state == "bad" {
                clicks(&mut browser, &[[-6.0, -3.0]]).await;
                browser.wait_for(&format!("{WORDS}.includes('Two legs cross')")).await;
            }
            let end = pixel(&mut browser, [-4.0, 9.0]).await;
            hover(&mut browser, end).await;
            is_readable(&mut browser, "the drawing", (width, scheme)).await;
            let file = format!("{state}-{width}-{scheme}.png.base64");
            browser.picture(&pictures.join(file)).await;
        }
        click(&mut browser, "undo").await;
    }
}
