//! cfclient's window against `uchain serve`: the unmodified program, clicked through under Xvfb by
//! `tests/serve/window.py`.
//!
//! `cargo test --test suite window -- --ignored` needs `Xvfb`, and a Python that has cfclient, whose
//! path is in the environment variable `UCHAIN_CFCLIENT_PYTHON` (`docs/src/cfclient.md`). The
//! pictures of the book are copies of those that the tests leave in `target/tmp/cfclient`.

use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use bridge::{FIRST_PORT, Ports};
use sim_harness::measure::metrics::{Reference, RunMetrics};
use sim_harness::scenario::Scenario;
use sim_harness::serve::{self, Live};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/serve/window.py");

/// cfclient takes a gamepad's packets at a fixed port of this machine, so there is one at a time.
static WINDOW: Mutex<()> = Mutex::new(());

/// An X server without a screen.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// Starts one with a number that is free, which it writes to its standard output.
    fn open() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x900x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb is not installed");
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        Self { server, name: format!(":{}", number.trim()) }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

fn python() -> OsString {
    std::env::var_os("UCHAIN_CFCLIENT_PYTHON").expect(
        "UCHAIN_CFCLIENT_PYTHON does not name a Python that has cfclient; see docs/src/cfclient.md",
    )
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("cfclient")
}

/// Serves the demonstration at a loopback address of its own while a part of `window.py` is done;
/// what came of the mission.
fn window(part: &str, host: Ipv4Addr) -> RunMetrics {
    let _alone = WINDOW.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let scenario = Scenario::open("demo").unwrap_or_else(|error| panic!("{error}"));
    let world = scenario.world();
    let reference = Reference::of(&scenario, &world);
    let count = scenario.drones.relays + 2;
    let ports = Ports::open(host, FIRST_PORT, count).unwrap();
    let (python, folder, display) = (python(), folder(), Display::open());
    fs::create_dir_all(&folder).unwrap();
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let (scenario, world, reference, stop) = (&scenario, &world, &reference, &done);
        let served = scope.spawn(move || {
            let live = Live::new(scenario, world, reference, 1, false);
            let tell = |_, event: serve::Event| eprintln!("{event}");
            serve::serve(live, ports, 1.0, None, stop, tell).0.metrics()
        });
        let output = Command::new(python)
            .args([SCRIPT, part, &count.to_string()])
            .arg(&folder)
            .envs([("DISPLAY", &*display.name), ("SCAN_ADDRESS", &*host.to_string())])
            .env_remove("QT_QPA_PLATFORM")
            .output();
        done.store(true, Ordering::Relaxed);
        let metrics = served.join().unwrap();
        let output = output.unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        metrics
    })
}

#[test]
#[ignore = "needs cfclient and Xvfb"]
fn cfclient_shows_every_tab_and_flies_by_its_buttons() {
    let metrics = window("look", crate::serve::host(2));
    assert_eq!(metrics.wall_contacts, 0);
    assert!(folder().join("flight.png").is_file());
}

#[test]
#[ignore = "needs cfclient and Xvfb"]
fn cfclient_flies_the_head_with_the_assist_mode_hover() {
    let metrics = window("hover", crate::serve::host(3));
    assert!(metrics.farthest_m > 0.5, "only {} m", metrics.farthest_m);
    assert!(folder().join("hover.png").is_file());
}
