//! Profiles of made-up runs, moment by moment.

use super::sites::Target;
use super::*;

const POLL: u32 = 0x0800_1000;
const AFTER_POLL: u32 = 0x0800_0100;
const HANDLER: u32 = 0x0800_2000;
const RETURN: u32 = 0x0800_2010;
const WAKE: u32 = 0x0800_3000;
const STEP: u32 = 0x0800_4000;
const AFTER_STEP: u32 = 0x0800_1040;
const RESET: u32 = 0x0800_0000;
/// The header of task 0, and the byte in it that says that the task is queued.
const HEADER: u32 = 0x2000_1000;
const QUEUED: u32 = HEADER + 9;

fn profile() -> Profile {
    let mut sites = Sites::with_tasks(&["imu gyro", "control"]);
    for (address, site) in [
        (RESET, Site::Reset),
        (POLL, Site::Poll(0)),
        (POLL + 0x100, Site::Poll(1)),
        (AFTER_POLL, Site::PollReturn),
        (HANDLER, Site::Handler),
        (HANDLER + 0x100, Site::Handler),
        (RETURN, Site::HandlerReturn(Target::Register(14))),
        (WAKE, Site::Wake { register: 3, offset: 9 }),
        (STEP, Site::Watched(0)),
        (AFTER_STEP, Site::WatchedReturn),
    ] {
        sites.add(address, site);
    }
    let mut profile = Profile::of_sites(sites);
    profile.watched.push("step".into());
    profile.account.watch();
    profile
}

struct Run(Profile, u64);

impl Run {
    fn new() -> Self {
        let mut run = Self(profile(), 0);
        run.see(0, 0, 0, [0; 4]);
        run
    }

    /// The core is at `pc`, in this exception, at this cycle, with R0, R3, SP and LR.
    fn see(&mut self, cycles: u64, pc: u32, exception: u16, [r0, r3, sp, lr]: [u32; 4]) {
        let mut now = Moment { exception, cycles, slept: self.1, ..Moment::default() };
        for (n, value) in [(0, r0), (3, r3), (13, sp), (14, lr), (15, pc)] {
            now.registers[n] = value;
        }
        self.0.at(&now, &|address, _| (address == QUEUED).then_some(0));
    }

    fn report(&mut self) -> Report {
        // One cycle is one microsecond.
        self.0.report_with(1_000_000, None)
    }
}

const RETURNS: [u32; 4] = [0, 0, 0, 0xFFFF_FFF9];

#[test]
fn an_interrupt_within_a_poll_is_charged_to_the_interrupt() {
    let mut run = Run::new();
    run.see(100, POLL, 0, [HEADER, 0, 0, 0]);
    run.see(150, HANDLER, 16 + 50, RETURNS);
    run.see(170, RETURN, 16 + 50, RETURNS);
    run.see(200, AFTER_POLL, 0, [0; 4]);
    let report = run.report();
    let gyro = &report.tasks[1];
    assert_eq!((gyro.own.count, gyro.own.max, gyro.whole.max), (1, 80.0, 100.0));
    let [timer] = &report.interrupts[..] else { panic!("one interrupt") };
    assert_eq!((timer.name.as_str(), timer.own.max, timer.whole.max), ("TIM5", 20.0, 20.0));
    assert!((report.executor - 0.5).abs() < 1e-9, "{report}");
    let sum = report.executor + timer.share + gyro.share;
    assert!((sum - report.load).abs() < 1e-9, "{report}");
}

#[test]
fn what_is_slept_is_no_load() {
    let mut run = Run::new();
    run.see(100, POLL, 0, [HEADER, 0, 0, 0]);
    run.see(200, AFTER_POLL, 0, [0; 4]);
    run.1 = 700;
    run.see(1000, POLL, 0, [HEADER, 0, 0, 0]);
    let report = run.report();
    assert!((report.load - 0.3).abs() < 1e-9);
    assert!((report.executor - 0.2).abs() < 1e-9);
}

#[test]
fn a_task_polled_by_an_interrupt_is_charged_itself() {
    let mut run = Run::new();
    run.see(10, HANDLER, 16 + 66, RETURNS);
    run.see(15, POLL + 0x100, 16 + 66, [HEADER, 0, 0, 0]);
    // A more urgent one breaks in, and one follows it without a return to the first.
    run.see(20, HANDLER + 0x100, 16 + 50, RETURNS);
    run.see(25, RETURN, 16 + 50, RETURNS);
    run.see(26, HANDLER + 0x100, 16 + 6, RETURNS);
    run.see(30, RETURN, 16 + 6, RETURNS);
    run.see(45, AFTER_POLL, 16 + 66, [0; 4]);
    run.see(50, RETURN, 16 + 66, RETURNS);
    run.see(100, 0, 0, [0; 4]);
    let report = run.report();
    let control = &report.tasks[0];
    assert_eq!((control.own.max, control.whole.max), (21.0, 30.0));
    let shares: Vec<f64> = report.interrupts.iter().map(|i| (i.share * 100.0).round()).collect();
    assert_eq!(shares, [4.0, 5.0, 10.0]);
    let executor = &report.interrupts[2];
    assert_eq!(
        (executor.name.as_str(), executor.whole.max, executor.own.max),
        ("CAN2_SCE", 40.0, 31.0)
    );
}

#[test]
fn a_return_to_code_within_a_handler_does_not_end_it() {
    let mut run = Run::new();
    run.see(10, HANDLER, 16, RETURNS);
    run.see(20, RETURN, 16, [0, 0, 0, 0x0800_5001]);
    run.see(30, RETURN, 16, RETURNS);
    run.see(40, POLL, 0, [HEADER, 0, 0, 0]);
    assert_eq!(run.report().interrupts[0].own.max, 20.0);
}

#[test]
fn a_handler_whose_end_was_not_seen_ends_where_something_else_goes_on() {
    let mut run = Run::new();
    run.see(10, HANDLER, 16, RETURNS);
    run.see(40, POLL, 0, [HEADER, 0, 0, 0]);
    run.see(50, AFTER_POLL, 0, [0; 4]);
    let report = run.report();
    assert_eq!(report.interrupts[0].own.max, 30.0);
    assert_eq!(report.tasks[1].own.max, 10.0);
}

#[test]
fn a_task_is_late_from_when_it_was_first_woken() {
    let mut run = Run::new();
    run.see(10, WAKE, 16, [0, QUEUED, 0, 0]);
    run.see(20, WAKE, 16, [0, QUEUED, 0, 0]);
    run.see(70, POLL, 0, [HEADER, 0, 0, 0]);
    run.see(80, AFTER_POLL, 0, [0; 4]);
    // Polled without having been woken: it was just spawned.
    run.see(90, POLL, 0, [HEADER, 0, 0, 0]);
    let latency = run.report().tasks[1].latency.unwrap();
    assert_eq!((latency.count, latency.max), (1, 60.0));
}

#[test]
fn without_debug_information_it_is_not_known_how_late_a_task_is() {
    let profile = Profile::of_sites(Sites::with_tasks(&["control"]));
    assert_eq!(profile.report_with(1_000_000, None).tasks[0].latency, None);
}

#[test]
fn a_watched_function_is_measured_within_its_task() {
    let mut run = Run::new();
    run.see(10, POLL, 0, [HEADER, 0, 0x100, 0]);
    for begin in [20, 50, 80] {
        run.see(begin, STEP, 0, [0, 0, 0x80, AFTER_STEP + 1]);
        // Passed by with another stack pointer: not its own return.
        run.see(begin + 1, AFTER_STEP, 0, [0, 0, 0x40, 0]);
        run.see(begin + begin / 10, AFTER_STEP, 0, [0, 0, 0x80, 0]);
    }
    run.see(100, AFTER_POLL, 0, [0; 4]);
    let report = run.report();
    let step = &report.watched[0];
    assert_eq!((step.own.count, step.own.p50, step.own.max), (3, 5.0, 8.0));
    assert_eq!(report.unfinished, 0);
    assert_eq!(report.tasks[1].own.max, 90.0);
}

#[test]
fn what_an_exception_delays_is_seen_twice_and_counted_once() {
    let mut run = Run::new();
    run.see(5, WAKE, 16, [0, QUEUED, 0, 0]);
    run.see(9, RETURN, 16, RETURNS);
    for (begin, end) in [(10, 20), (30, 40)] {
        run.see(begin, POLL, 0, [HEADER, 0, 0x100, AFTER_POLL]);
        run.see(begin + 1, HANDLER, 17, RETURNS);
        // The task is woken while it is already being polled: that is for the next time.
        run.see(begin + 2, WAKE, 17, [0, QUEUED, 0, 0]);
        // One more urgent comes in before the handler's first instruction.
        run.see(begin + 3, HANDLER + 0x100, 18, RETURNS);
        run.see(begin + 4, RETURN, 18, RETURNS);
        run.see(begin + 4, HANDLER, 17, RETURNS);
        run.see(begin + 5, RETURN, 17, RETURNS);
        run.see(begin + 6, POLL, 0, [HEADER, 0, 0x100, AFTER_POLL]);
        run.see(end, AFTER_POLL, 0, [0, 0, 0x100, 0]);
    }
    let report = run.report();
    let gyro = &report.tasks[1];
    assert_eq!((gyro.own.count, gyro.own.max, gyro.whole.max), (2, 6.0, 10.0));
    let latency = gyro.latency.unwrap();
    assert_eq!((latency.count, latency.max), (2, 18.0));
    let counts: Vec<u64> = report.interrupts.iter().map(|i| i.own.count).collect();
    assert_eq!(counts, [2, 2]);
    assert_eq!(report.unfinished, 0);
}

#[test]
fn a_reset_ends_everything() {
    let mut run = Run::new();
    run.see(10, POLL, 0, [HEADER, 0, 0, 0]);
    run.see(15, WAKE, 16, [0, QUEUED, 0, 0]);
    run.see(20, RESET, 0, [0; 4]);
    run.see(30, POLL, 0, [HEADER, 0, 0, 0]);
    run.see(40, AFTER_POLL, 0, [0; 4]);
    let report = run.report();
    assert_eq!(report.resets, 1);
    assert_eq!((report.tasks[1].own.count, report.tasks[1].own.max), (1, 10.0));
    assert_eq!(report.tasks[1].latency.unwrap().count, 0);
}

#[test]
fn what_began_before_the_measurement_is_charged_but_not_counted() {
    let mut run = Run::new();
    run.see(10, POLL, 0, [HEADER, 0, 0, 0]);
    run.see(20, STEP, 0, [0, 0, 0x80, AFTER_STEP + 1]);
    let now = Moment { cycles: 50, ..Moment::default() };
    run.0.account.charge(&now);
    run.0.account.restart(&now);
    run.see(55, AFTER_STEP, 0, [0, 0, 0x80, 0]);
    run.see(60, AFTER_POLL, 0, [0; 4]);
    run.see(150, 0, 0, [0; 4]);
    let report = run.report();
    assert_eq!((report.tasks[1].own.count, report.watched[0].own.count), (0, 0));
    assert!((report.watched[0].share - 0.05).abs() < 1e-9);
    assert!((report.tasks[1].share - 0.1).abs() < 1e-9);
    assert!((report.load - 1.0).abs() < 1e-9);
}

#[test]
fn a_percentile_is_a_time_that_occurred() {
    let mut tally = account::Tally::default();
    for cycles in 1..=100 {
        tally.add(cycles);
    }
    let of = |share| tally.percentile(share);
    assert_eq!([of(0.0), of(0.5), of(0.99), of(1.0)], [1, 50, 99, 100]);
    assert_eq!(account::Tally::default().percentile(0.5), 0);
}
