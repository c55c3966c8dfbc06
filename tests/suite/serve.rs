//! `uchain serve` to the clients that it is for: the unmodified cflib of `tests/serve/
//! requirements.txt` connects to simulated drones, logs, sets parameters and flies the head.
//!
//! The tests with cflib need python3, and the first time the Python package index:
//! `cargo test --test suite serve -- --ignored`.

use std::fs::{self, File};
use std::io;
use std::net::{Ipv4Addr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use bridge::{FIRST_PORT, Ports};
use sim_harness::measure::metrics::{Reference, RunMetrics};
use sim_harness::scenario::{Fidelity, Scenario};
use sim_harness::serve::{self, Live};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/serve");

/// The ports of cflib's scan, on a loopback address of this test's own where there are many, so
/// that nothing else that runs here is met.
pub(super) fn host(test: u8) -> Ipv4Addr {
    if !cfg!(target_os = "linux") {
        return Ipv4Addr::LOCALHOST;
    }
    let [high, low] = (std::process::id() as u16).to_be_bytes();
    Ipv4Addr::new(127, 64 + test, high, low.max(1))
}

/// The interpreter of a virtual environment with cflib, made once.
pub(super) fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| environment().unwrap_or_else(|why| panic!("{why}")))
}

fn environment() -> Result<PathBuf, String> {
    let wanted = Path::new(FOLDER).join("requirements.txt");
    let wanted = fs::read_to_string(wanted).unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cflib");
    fs::create_dir_all(&folder).unwrap();
    // Another run of the tests may be making it.
    let lock = File::create(folder.join("lock")).unwrap();
    lock.lock().unwrap();
    let environment = folder.join("venv");
    let python = if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };
    let python = environment.join(python);
    let made = environment.join("made-of.txt");
    if fs::read_to_string(&made).is_ok_and(|is| is == wanted) {
        return Ok(python);
    }
    let system = if cfg!(windows) { "python" } else { "python3" };
    run(Command::new(system).args(["-m", "venv", "--clear"]).arg(&environment))?;
    run(Command::new(&python)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input"])
        .args(["--no-deps", "--require-hashes", "--only-binary", ":all:", "--requirement"])
        .arg(Path::new(FOLDER).join("requirements.txt")))?;
    fs::write(made, wanted).unwrap();
    Ok(python)
}

fn run(command: &mut Command) -> Result<(), String> {
    let output = match command.output() {
        Ok(output) => output,
        Err(error) => return Err(format!("{command:?} cannot be run: {error}")),
    };
    if output.status.success() {
        return Ok(());
    }
    Err(format!("{command:?} failed: {}", said(&output)))
}

pub(super) fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text)).join("\n")
}

/// Runs a part of `drive.py` against so many drones.
pub(super) fn script(
    python: &Path,
    part: &str,
    host: Ipv4Addr,
    count: usize,
    rest: &[&str],
) -> io::Result<Output> {
    Command::new(python)
        .arg(Path::new(FOLDER).join("drive.py"))
        .args([part, &*host.to_string(), &FIRST_PORT.to_string(), &count.to_string()])
        .args(rest)
        .output()
}

/// What came of a mission that a part of `drive.py` was run against.
struct Driven {
    metrics: RunMetrics,
    states: Vec<&'static str>,
    events: Vec<serve::Event>,
}

/// Serves a scenario while a part of `drive.py` is run against it.
fn drive(scenario: &Scenario, speed: f64, host: Ipv4Addr, arguments: &[&str]) -> Driven {
    let world = scenario.world();
    let reference = Reference::of(scenario, &world);
    let ports = Ports::open(host, FIRST_PORT, scenario.drones.relays + 2).unwrap();
    let (python, done) = (python(), AtomicBool::new(false));
    let ((live, events), output) = thread::scope(|scope| {
        let (world, reference, stop) = (&world, &reference, &done);
        let served = scope.spawn(move || {
            let live = Live::new(scenario, world, reference, 1, false);
            let mut events = Vec::new();
            let tell = |_, event: serve::Event| {
                eprintln!("{event}");
                events.push(event);
            };
            let (live, _) = serve::serve(live, ports, speed, None, stop, tell);
            (live, events)
        });
        let (part, rest) = arguments.split_first().unwrap();
        let output = script(python, part, host, scenario.drones.members(), rest);
        done.store(true, Ordering::Relaxed);
        (served.join().unwrap(), output.unwrap())
    });
    println!("{}", said(&output));
    assert!(output.status.success(), "{arguments:?} failed");
    let states = live.states().map(|(_, state)| state.name()).collect();
    Driven { metrics: live.metrics(), states, events }
}

fn demonstration() -> Scenario {
    Scenario::open("demo").unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[ignore = "needs python3 and the Python package index"]
fn cflib_finds_a_drone_reads_its_tables_logs_at_100_hz_and_sets_its_parameters() {
    drive(&demonstration().at(Fidelity::Flight), 1.0, host(0), &["look"]);
}

/// How far the client flies the head, in metres. The demonstration's own pilot gets to 23 m at
/// flight level with seed 1; where a client's set-points come at other moments, the head may have
/// to stop sooner at the launch limit.
const FAR_M: f32 = 16.0;

#[test]
#[ignore = "needs python3 and the Python package index"]
fn cflib_flies_the_head_down_the_tunnel_and_back_while_relays_follow() {
    let far = FAR_M.to_string();
    let scenario = demonstration().at(Fidelity::Flight);
    let Driven { metrics, states, .. } = drive(&scenario, 6.0, host(1), &["fly", &far]);
    // The head's odometer is off by its flow sensor's scale.
    assert!(metrics.farthest_m >= 0.95 * FAR_M, "only {} m", metrics.farthest_m);
    assert!(metrics.launched >= 2.0, "only {} relays flew", metrics.launched);
    let (base, drones) = states.split_last().unwrap();
    assert!(drones.iter().all(|state| ["idle", "landed"].contains(state)), "{states:?}");
    assert_eq!((drones[0], *base), ("landed", "idle"));
}

/// The set-points and waits of cflib's commanders are by the clock, so this is at its speed.
#[test]
#[ignore = "needs python3 and the Python package index"]
fn cflibs_motion_commander_flies_the_head_and_a_place_is_refused_in_one_line() {
    let scenario = demonstration().at(Fidelity::Flight);
    let Driven { metrics, states, .. } = drive(&scenario, 1.0, host(6), &["motion"]);
    assert!(metrics.farthest_m > 0.3, "only {} m", metrics.farthest_m);
    assert_eq!(states[0], "landed");
}

#[test]
#[ignore = "needs python3 and the Python package index"]
fn cflibs_reset_estimator_ends_at_every_drone_and_a_relay_says_why_it_takes_no_set_point() {
    for fidelity in [Fidelity::Flight, Fidelity::Point] {
        drive(&demonstration().at(fidelity), 1.0, host(7), &["estimators"]);
    }
}

#[test]
#[ignore = "needs python3 and the Python package index"]
fn two_cflib_clients_at_one_port_each_get_their_own_and_are_told_in_one_line() {
    let Driven { events, .. } = drive(&demonstration(), 1.0, host(8), &["two"]);
    let count = |is: fn(&serve::Event) -> bool| events.iter().filter(|event| is(event)).count();
    assert_eq!(count(|event| matches!(event, serve::Event::Shared(..))), 1);
    assert_eq!(count(|event| matches!(event, serve::Event::Connected(..))), 2);
}

/// The script that the book shows is the one that is run here.
#[test]
fn the_books_script_is_the_tested_one() {
    let root = env!("CARGO_MANIFEST_DIR");
    let script = fs::read_to_string(format!("{FOLDER}/fly.py")).unwrap();
    let page = fs::read_to_string(format!("{root}/docs/src/serve.md")).unwrap();
    let shown = page.split("```python\n").nth(1).and_then(|rest| rest.split("```").next());
    assert_eq!(shown, Some(&*script), "put tests/serve/fly.py into docs/src/serve.md");
}

#[test]
fn a_port_that_is_in_use_and_a_host_that_is_elsewhere_are_refused_with_a_remedy() {
    let taken = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = taken.local_addr().unwrap().port();
    let refused = |host, first, count| Ports::open(host, first, count).err().unwrap().to_string();
    assert_eq!(
        refused(Ipv4Addr::LOCALHOST, port, 1),
        format!(
            "UDP port 127.0.0.1:{port} is in use; end the program that has it, or give another \
             --port"
        )
    );
    // An address of TEST-NET-1, which no machine has (RFC 5737).
    assert_eq!(
        refused(Ipv4Addr::new(192, 0, 2, 1), FIRST_PORT, 1),
        "192.0.2.1 is no address of this machine; give --host one that is, or 0.0.0.0 for all of \
         them"
    );
    assert_eq!(
        refused(Ipv4Addr::LOCALHOST, u16::MAX, 2),
        "there are no 2 ports from 65535 on; give a smaller --port"
    );
}
