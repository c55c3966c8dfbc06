//! Flies the vendor's firmware in the emulator, and says how far it got.

use std::net::Ipv4Addr;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use bridge::Ports;
use input::InputError;

use serve;
use stock::client::{Client, Failure};
use stock::served::Served;
use stock::transcript::{Device, Summary};
use stock::{StockDrone, StockFirmware};

/// The height at which it hovers, m.
pub const HEIGHT_M: f32 = 0.4;
/// The aim for the time within [`AIM_M`] of the point of hover, s.
pub const AIM_S: f64 = 10.0;
/// The aim for the distance from the point of hover, m.
pub const AIM_M: f64 = 0.1;

/// The time that is judged, from the end of the take-off on, ms.
const HOVER_MS: u64 = 12_000;
/// Times in which something must have happened, ms.
const BOOT_MS: u64 = 6_000;
const SELF_TEST_MS: u64 = 8_000;
const SETTLE_MS: u64 = 4_000;
const TAKE_OFF_S: f32 = 2.0;
const LANDING_MS: u64 = 4_000;

/// The variables that are logged during the hover.
const LOGGED: [&str; 3] = ["stateEstimate.z", "range.zrange", "range.front"];

/// The script by which cflib flies it.
const SCRIPT: &str = include_str!("../../../../tests/serve/stock.py");

/// How far the firmware got.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// It has started, and said so on its console.
    pub boot: bool,
    /// It has passed its own test of sensors, memory and decks.
    pub self_test: bool,
    /// What it read from each sensor in flight, times a second.
    pub streams: Vec<(&'static str, f64)>,
    /// Whether cflib connected, armed, flew and logged it; `None` where no Python was given.
    pub cflib: Option<bool>,
    /// Variables of its log, and parameters, that were read.
    pub contents: (usize, usize),
    /// The time for which it stayed within [`AIM_M`] of the point of hover, s.
    pub hover_s: f64,
    /// The root mean square of the true distance from the point of hover, m.
    pub hover_rms_m: f64,
    /// The same of its estimate of the height against the true one, m.
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
        aim(self.cflib != Some(false), "cflib did not fly it");
        aim(self.hover_s >= AIM_S, "it did not hover for 10 s within 0.1 m");
        missed
    }
}

/// Flies it, and with a Python that has cflib a second time by that.
///
/// # Errors
/// When there is no such ELF, or no port for cflib.
pub fn run(
    (elf, radio): (&Path, Option<&Path>),
    seed: u64,
    python: Option<&Path>,
) -> Result<Measured, InputError> {
    let firmware = StockFirmware::open(elf)?.with_radio(radio)?;
    let mut client = Client::new(StockDrone::new(&firmware, seed));
    let mut measured = Measured::default();
    if let Err(failure) = fly(&mut client, &mut measured) {
        measured.refused.push(failure.to_string());
    }
    measured.console = client.console();
    measured.cflib = python.map(|python| by_cflib(&firmware, seed, python)).transpose()?;
    Ok(measured)
}

fn fly(client: &mut Client, measured: &mut Measured) -> Result<(), Failure> {
    measured.boot = client.wait_for("is up and running!", BOOT_MS)?;
    measured.self_test = client.wait_for("Self test passed!", SELF_TEST_MS)?;
    client.protocol()?;
    let log = client.log_contents()?;
    measured.contents = (log.len(), client.parameters()?.len());
    client.log(&log, &LOGGED)?;
    wait(client, SETTLE_MS)?;
    client.arm()?;
    client.climb(HEIGHT_M, TAKE_OFF_S, false)?;
    wait(client, (TAKE_OFF_S * 1e3) as u64 + SETTLE_MS)?;
    hover(client, measured)?;
    client.climb(0.0, TAKE_OFF_S, true)?;
    wait(client, LANDING_MS)
}

fn wait(client: &mut Client, millis: u64) -> Result<(), Failure> {
    (0..millis).try_for_each(|_| client.advance())
}

/// Measures the hover.
fn hover(client: &mut Client, measured: &mut Measured) -> Result<(), Failure> {
    let place = client.drone().craft().body().position();
    let (mut square, mut height_square, mut kept_ms, mut kept) = (0.0, 0.0, 0_u32, true);
    let mut summary = Summary::default();
    client.drone_mut().board_mut().record_transfers();
    for _ in 0..HOVER_MS {
        client.advance()?;
        summary.add(&client.drone_mut().board_mut().take_transfers());
        let body = client.drone().craft().body();
        let apart = place.iter().zip(body.position()).map(|(a, b)| f64::from(a - b).powi(2));
        let away2: f64 = apart.sum();
        square += away2;
        kept &= away2.sqrt() <= AIM_M && !body.is_on_floor();
        kept_ms += u32::from(kept);
        let estimate = client.float(0).unwrap_or(f32::NAN);
        height_square += f64::from(estimate - body.height()).powi(2);
    }
    let samples = HOVER_MS as f64;
    measured.hover_s = f64::from(kept_ms) * 1e-3;
    measured.hover_rms_m = (square / samples).sqrt();
    measured.height_rms_m = (height_square / samples).sqrt();
    measured.streams = streams(&summary, samples * 1e-3);
    Ok(())
}

/// What was read of each sensor: a device, its data registers, and a name.
fn streams(summary: &Summary, seconds: f64) -> Vec<(&'static str, f64)> {
    const DATA: [(Device, u16, usize); 6] = [
        (Device::Gyroscope, 0x02, 6),
        (Device::Accelerometer, 0x12, 6),
        (Device::Barometer, 0x04, 6),
        (Device::Flow, 0x16, 12),
        (Device::Down, 0x88, 17),
        (Device::Sides, 0x88, 17),
    ];
    let rate = |(device, register, length): (Device, u16, usize)| {
        let reads = summary.of(device).map_or(0, |traffic| traffic.reads_of(register, length));
        (device.name(), f64::from(reads) / seconds)
    };
    DATA.into_iter().map(rate).collect()
}

/// Lets cflib connect to it over UDP, arm it, hover it and log it; whether it did.
fn by_cflib(firmware: &StockFirmware, seed: u64, python: &Path) -> Result<bool, InputError> {
    let ports = Ports::open(Ipv4Addr::LOCALHOST, 0, 1)?;
    let address = ports.addresses().first().map_or_else(String::new, ToString::to_string);
    let done = AtomicBool::new(false);
    Ok(thread::scope(|scope| {
        let stop = &done;
        scope.spawn(move || {
            let world = Served::new(StockDrone::new(firmware, seed));
            serve::serve(world, ports, 1.0, None, stop, |_, _| {});
        });
        let script =
            Command::new(python).args(["-c", SCRIPT, &format!("udp://{address}")]).output();
        done.store(true, Ordering::Relaxed);
        script.is_ok_and(|output| output.status.success())
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `UCHAIN_STOCK_ELF=…/cf2.elf cargo test --release -p sim-harness --features virtual stock
    /// -- --ignored`.
    #[test]
    #[ignore = "needs the vendor's cf2.elf: name it in UCHAIN_STOCK_ELF"]
    fn the_vendors_firmware_boots_passes_its_test_and_hovers() {
        let elf = std::env::var_os("UCHAIN_STOCK_ELF").expect("UCHAIN_STOCK_ELF names the ELF");
        let measured = run((Path::new(&elf), None), 1, None).unwrap();
        assert_eq!(measured.missed(), [""; 0], "{}", measured.console);
        assert!(measured.height_rms_m < 0.03, "{} m", measured.height_rms_m);
        for (sensor, rate) in measured.streams {
            assert!(rate >= 10.0, "{sensor}: {rate} a second");
        }
    }
}
