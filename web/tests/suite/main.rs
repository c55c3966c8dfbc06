//! The page in a real browser. `cargo run --package pack` builds it into `web/dist` before.

#[allow(dead_code, reason = "the station's tests use more of it")]
#[path = "../../../ground-station/tests/suite/browser.rs"]
mod browser;
mod bytes;
mod drawing;
mod drawn;
mod ended;
mod held;
mod labels;
mod looks;
mod opened;
mod pointer;
mod reports;
mod served;
mod sliders;
