//! Starts the command `uchain-ground`.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};

/// A running station; it is killed when it is dropped.
pub(crate) struct StationProcess {
    process: Child,
    pub(crate) page: SocketAddr,
}

pub(crate) fn command() -> Command {
    Command::new(env!("CARGO_BIN_EXE_uchain-ground"))
}

impl StationProcess {
    /// Starts a station on a free port.
    pub(crate) fn start(base: &str, options: &[&str]) -> Self {
        Self::start_with(&[&[base], options].concat())
    }

    /// Starts a station with these arguments on a free port.
    pub(crate) fn start_with(arguments: &[&str]) -> Self {
        Self::of(command().args(["--port", "0"]).args(arguments))
    }

    /// Starts a station on the port of one that was killed.
    pub(crate) fn start_again(base: &str, page: SocketAddr) -> Self {
        Self::of(command().args(["--port", &page.port().to_string(), base]))
    }

    /// Starts a station that may have so many files open.
    #[cfg(unix)]
    pub(crate) fn start_with_files(base: &str, files: u32) -> Self {
        let station = env!("CARGO_BIN_EXE_uchain-ground");
        let script = format!("ulimit -n {files} && exec '{station}' --port 0 '{base}'");
        Self::of(Command::new("sh").args(["-c", &script]))
    }

    /// The station that this command starts.
    fn of(command: &mut Command) -> Self {
        Self::running(command.stdout(Stdio::piped()).spawn().unwrap())
    }

    /// A station that was started, with its output piped.
    pub(crate) fn running(process: Child) -> Self {
        Self::read(process).0
    }

    /// Starts a station with these arguments on a free port, and returns the line that it prints.
    pub(crate) fn start_and_read(arguments: &[&str]) -> (Self, String) {
        let mut command = command();
        command.args(["--port", "0"]).args(arguments).stdout(Stdio::piped());
        Self::read(command.spawn().unwrap())
    }

    fn read(mut process: Child) -> (Self, String) {
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (_, rest) = line.split_once("http://").expect(&line);
        let (page, _) = rest.split_once('/').unwrap();
        (Self { page: page.parse().unwrap(), process }, line)
    }

    /// The folder in which the system lists the files that the station has open.
    #[cfg(target_os = "linux")]
    pub(crate) fn files(&self) -> std::path::PathBuf {
        format!("/proc/{}/fd", self.process.id()).into()
    }

    /// Suspends the station, or lets it go on.
    #[cfg(unix)]
    pub(crate) fn signal(&self, signal: &str) {
        let pid = self.process.id().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
    }

    /// Kills the station, as a crash of the machine would.
    pub(crate) fn kill(mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

impl Drop for StationProcess {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
