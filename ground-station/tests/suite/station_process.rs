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
        let mut process =
            command().args(["--port", "0"]).args(arguments).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (_, rest) = line.split_once("http://").expect(&line);
        let (page, _) = rest.split_once('/').unwrap();
        Self { process, page: page.parse().unwrap() }
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
