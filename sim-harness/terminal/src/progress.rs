//! A progress bar: on a terminal, and only once a task has taken a second.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A task that takes no longer shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Counts what is done; cheap and safe to call from many threads.
pub struct Progress {
    bar: ProgressBar,
    since: Instant,
    shown: AtomicBool,
    wanted: bool,
}

impl Progress {
    /// Makes a bar of so many steps, hidden where it is not wanted.
    pub fn new(total: u64, quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg} {eta} left");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        let wanted = !quiet && std::io::stderr().is_terminal();
        Self { bar, since: Instant::now(), shown: AtomicBool::new(false), wanted }
    }

    /// Makes a bar without an end, for a task whose length is not known.
    pub fn busy(what: &str, quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        bar.set_message(what.to_owned());
        let wanted = !quiet && std::io::stderr().is_terminal();
        if wanted {
            let bar = bar.clone();
            std::thread::spawn(move || {
                std::thread::sleep(PATIENCE);
                if !bar.is_finished() {
                    bar.set_draw_target(ProgressDrawTarget::stderr());
                    bar.enable_steady_tick(PATIENCE / 5);
                }
            });
        }
        Self { bar, since: Instant::now(), shown: AtomicBool::new(wanted), wanted }
    }

    /// Counts one more that is done.
    pub fn step(&self) {
        self.bar.inc(1);
        let late = self.since.elapsed() > PATIENCE;
        if self.wanted && late && !self.shown.swap(true, Ordering::Relaxed) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    /// Prints a line on standard error, above the bar.
    pub fn aside(&self, line: &str) {
        // Where standard error is closed, the line is lost.
        self.bar.suspend(|| drop(writeln!(std::io::stderr(), "{line}")));
    }

    /// Names the things that are counted.
    pub fn say(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
