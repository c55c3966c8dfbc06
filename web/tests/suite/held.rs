//! The head is flown by fingers that hold the buttons, on a phone.

use serde_json::Value;
use uchain_web::Dropped;

use crate::bytes::{same, trace_here};
use crate::opened::{ask, open};
use crate::pointer::{middle, phone, touch};

#[tokio::test]
async fn fingers_fly_the_head_in_and_back_in_chromium() {
    let mut browser = open("held", "scenario=demo&seed=3").await;
    phone(&mut browser).await;
    let order = "uchain.page.flown?.pilot?.at(-1)";
    // Places in metres along the way: a head that is held on does not come back over them, however slow the machine.
    let ways = [("forward", 0.3, "> 4"), ("back", -0.3, "< 3")];
    for (button, speed_mps, comes) in ways {
        let at = middle(&mut browser, &format!("[data-hold={button}]")).await;
        let top = browser.evaluate("scrollY").await;
        touch(&mut browser, "touchStart", &[at]).await;
        browser.wait_for(&format!("{order}?.speed_mps === {speed_mps}")).await;
        // A finger that slips off the button holds it on.
        touch(&mut browser, "touchMove", &[[at[0], at[1] - 60.0]]).await;
        browser.wait_for(&format!("uchain.page.frame.drones[0].way {comes}")).await;
        let held = "[...document.querySelectorAll('.held')].map((it) => it.dataset.hold).join()";
        assert_eq!(browser.evaluate(held).await, button);
        touch(&mut browser, "touchEnd", &[]).await;
        browser.wait_for(&format!("{order}.speed_mps === 0")).await;
        browser.wait_for("Math.abs(uchain.page.frame.drones[0].forward) < 0.05").await;
        assert_eq!(browser.evaluate(held).await, "");
        assert_eq!(browser.evaluate("scrollY").await, top, "the page scrolled under the finger");
    }
    // This machine flies what the fingers flew.
    ask(&mut browser, "finish", Value::Null).await;
    let record = ask(&mut browser, "record", Value::Null).await;
    let steps = record["flown"]["pilot"].as_array().unwrap();
    let speeds: Vec<_> = steps.iter().map(|step| step["speed_mps"].as_f64()).collect();
    assert!(speeds.ends_with(&[0.3, 0.0, -0.3, 0.0].map(Some)), "{speeds:?}");
    let flown = &record["flown"];
    same(flown, record["csv"].as_str().unwrap(), &trace_here(flown, &Dropped::default()));
}
