//! A browser that shows the page, and the questions to its simulator.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::served;

/// A scratch folder that a test begins with empty.
pub(crate) fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Opens the page with the part of the address behind `#`, and waits until its mission flies.
pub(crate) async fn open(test: &str, fragment: &str) -> Browser {
    let address = served::page().await;
    let url = format!("http://{address}/#{fragment}");
    let mut browser = Browser::open(&folder(test), &url).await;
    browser.wait_for("globalThis.uchain?.page.frame?.t > 0").await;
    browser
}

/// What the simulator in the page answers.
pub(crate) async fn ask(browser: &mut Browser, act: &str, value: Value) -> Value {
    let call = format!(
        "globalThis.got = undefined; uchain.ask('{act}', {value}).then((value) => got = {{ value }}, \
         (error) => got = {{ wrong: error.message }}); 0"
    );
    browser.evaluate(&call).await;
    browser.wait_for("got !== undefined").await;
    let mut got = browser.evaluate("got").await;
    assert!(got["wrong"].is_null(), "{act}: {got}");
    got["value"].take()
}

/// The record of a mission that the page flies to its end.
pub(crate) async fn flown(browser: &mut Browser, recipe: &Value) -> Value {
    ask(browser, "pace", json!(0)).await;
    ask(browser, "open", json!({ "recipe": recipe })).await;
    ask(browser, "finish", Value::Null).await;
    ask(browser, "record", Value::Null).await
}
