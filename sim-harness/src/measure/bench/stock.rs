//! Flies the vendor's firmware in the emulator, and says how far it got.

use std::path::Path;

use crate::input_error::InputError;
use crate::stock::client::{Client, Failure};
use crate::stock::{StockDrone, StockFirmware};

/// The height at which it hovers, m.
pub const HEIGHT_M: f32 = 0.4;
/// The time that is judged, from the end of the take-off on, ms.
const HOVER_MS: u64 = 12_000;
/// The longest time in which the hover may last.
pub const AIM_S: f64 = 10.0;
/// The aim for the root mean square of the distance from the point of hover, m.
pub const AIM_RMS_M: f64 = 0.1;

/// Times in which something must have happened, ms.
const BOOT_MS: u64 = 3_000;
const SELF_TEST_MS: u64 = 8_000;
const SETTLE_MS: u64 = 4_000;
const TAKE_OFF_S: f32 = 2.0;

/// The variables that are logged during the hover.
const LOGGED: [&str; 5] = [
    "stateEstimate.x",
    "stateEstimate.y",
    "stateEstimate.z",
    "range.zrange",
    "range.front",
];

/// How far the firmware got.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// It has started, and said so on its console.
    pub boot: bool,
    /// It has passed its own test of sensors, memory and decks.
    pub self_test: bool,
    /// The parts of its sensors that deliver.
    pub streams: Vec<(&'static str, f64)>,
    /// Variables of its log and parameters that were read.
    pub contents: (usize, usize),
    /// The time for which it stayed within the aim of the point of hover, s.
    pub hover_s: f64,
    /// The root mean square of the true distance from the point of hover, m.
    pub hover_rms_m: f64,
    /// The same of the difference between its estimate of the height and the true one, m.
    pub height_rms_m: f64,
    /// The access that the emulator refused, or the answer that did not come.
    pub refused: Vec<String>,
    /// The text of its console.
    pub console: String,
}

impl Measured {
    /// Aims that were not reached.
    #[must_use]
    pub fn missed(&self) -> Vec<String> {
        let mut missed = self.refused.clone();
        let mut aim = |met: bool, what: &str| {
            if !met {
                missed.push(format!("stock: {what}"));
            }
        };
        aim(self.boot, "it did not boot");
        aim(self.self_test, "it did not pass its self-test");
        aim(self.hover_s >= AIM_S, "it did not hover for 10 s within 0.1 m");
        missed
    }
}

/// Flies it.
///
/// # Errors
/// When there is no such ELF.
pub fn run(elf: &Path, seed: u64) -> Result<Measured, InputError> {
    let firmware = StockFirmware::open(elf)?;
    let mut client = Client::new(StockDrone::new(&firmware, seed));
    let mut measured = Measured::default();
    if let Err(failure) = fly(&mut client, &mut measured) {
        measured.refused.push(failure.to_string());
    }
    measured.console = client.console();
    Ok(measured)
}

fn fly(client: &mut Client, measured: &mut Measured) -> Result<(), Failure> {
    for _ in 0..BOOT_MS {
        client.advance()?;
    }
    measured.boot = client.wait_for("is up and running!", BOOT_MS)?;
    measured.self_test = client.wait_for("Self test passed!", SELF_TEST_MS)?;
    client.protocol()?;
    let log = client.log_contents()?;
    measured.contents = (log.len(), client.parameters()?.len());
    client.log(&log, &LOGGED)?;
    for _ in 0..SETTLE_MS {
        client.advance()?;
    }
    client.arm()?;
    client.climb(HEIGHT_M, TAKE_OFF_S, false)?;
    for _ in 0..(TAKE_OFF_S * 1e3) as u64 + SETTLE_MS {
        client.advance()?;
    }
    hover(client, measured)
}

/// Measures the hover.
fn hover(client: &mut Client, measured: &mut Measured) -> Result<(), Failure> {
    let place = client.drone().craft().body().position();
    let rows = client.rows();
    let (mut square, mut height_square, mut kept_ms) = (0.0, 0.0, 0);
    for _ in 0..HOVER_MS {
        client.advance()?;
        let body = client.drone().craft().body();
        let away: f64 = place.iter().zip(body.position()).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        square += away;
        if kept_ms >= 0 && away.sqrt() <= AIM_RMS_M && !body.is_on_floor() {
            kept_ms += 1;
        }
        let estimate = client.float(2).unwrap_or(f32::NAN);
        height_square += f64::from(estimate - body.height()).powi(2);
        if std::env::var("DBG").is_ok() && client.drone().now_ms() % 500 == 0 {
            eprintln!("{} true {:?} est {:?} {:?} {:?} z {:?} front {:?}", client.drone().now_ms(), body.position(), client.float(0), client.float(1), client.float(2), client.float(3), client.float(4));
        }
    }
    let _ = rows;
    measured.hover_s = kept_ms as f64 * 1e-3;
    measured.hover_rms_m = (square / HOVER_MS as f64).sqrt();
    measured.height_rms_m = (height_square / HOVER_MS as f64).sqrt();
    Ok(())
}
