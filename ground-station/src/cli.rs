//! The command `uchain-ground`.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

use clap::Parser;
use tokio::net::TcpListener;

use crate::access::{Access, Refused};
use crate::link::UdpLink;
use crate::recorder::Recorder;
use crate::{server, station};

/// The port of the page.
const PORT: u16 = 8430;

/// The exit status for bad input.
const BAD_INPUT: u8 = 2;

/// Serves the operator's page for a chain of drones, and gives its orders to the base
#[derive(Debug, Parser)]
#[command(name = "uchain-ground", version, max_term_width = 100)]
struct Arguments {
    /// The base: udp://HOST:PORT, the last address that `uchain serve` prints, or, with the feature
    /// crazyradio, radio:// with number, channel, data rate and address of a real one
    base: BaseAddress,
    /// The port of the page; 0 for any that is free
    #[arg(long, default_value_t = PORT)]
    port: u16,
    /// The address at which the page is served; any but this machine's own needs --token
    #[arg(long, default_value_t = Ipv4Addr::LOCALHOST.into(), value_name = "ADDRESS")]
    host: IpAddr,
    /// What other machines must add to the page's address, as ?token=TOKEN
    #[arg(long)]
    token: Option<String>,
    /// Records to packets.csv and station.mcap in this folder, which must not have them yet
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
}

/// The address of a base.
#[derive(Clone, Debug, PartialEq, Eq)]
enum BaseAddress {
    /// A base at a UDP port.
    Udp { host: String, port: u16 },
    /// A base at a Crazyradio, by the address that Bitcraze's tools use.
    Radio(String),
}

impl FromStr for BaseAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.starts_with("radio://") {
            return Ok(Self::Radio(text.to_owned()));
        }
        let parts = text.strip_prefix("udp://").and_then(|rest| rest.rsplit_once(':'));
        let address = parts.and_then(|(host, port)| {
            let host = host.trim_start_matches('[').trim_end_matches(']');
            let port = port.parse().ok().filter(|port| *port > 0)?;
            (!host.is_empty()).then(|| Self::Udp { host: host.to_owned(), port })
        });
        address.ok_or_else(|| "give udp://HOST:PORT, such as udp://127.0.0.1:19854".to_owned())
    }
}

/// Why the station cannot run.
#[derive(Debug)]
struct Unusable {
    wrong: String,
    remedy: String,
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.wrong, self.remedy)
    }
}

/// Runs the command.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { BAD_INPUT } else { 0 });
        }
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let done = match runtime {
        Ok(runtime) => runtime.block_on(run(&arguments)),
        Err(error) => {
            eprintln!("uchain-ground: this machine starts no tasks: {error}");
            return ExitCode::FAILURE;
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(unusable) => {
            eprintln!("uchain-ground: {unusable}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

async fn run(arguments: &Arguments) -> Result<(), Unusable> {
    let base = resolve(&arguments.base)?;
    let access = Access::new(arguments.host, arguments.token.clone()).map_err(no_access)?;
    let at = SocketAddr::from((arguments.host, arguments.port));
    let listener = TcpListener::bind(at).await.map_err(|error| Unusable {
        wrong: format!("the page cannot be served at {at} ({error})"),
        remedy: "end the other station, or give another --port".to_owned(),
    })?;
    let recorder = arguments.record.as_deref().map(Recorder::create).transpose();
    let recorder = recorder.map_err(|error| Unusable {
        wrong: format!("the recording cannot be created ({error})"),
        remedy: "give --record a folder that has no recording yet".to_owned(),
    })?;
    let link = UdpLink::open(base).await.map_err(|error| Unusable {
        wrong: format!("there is no way to {base} ({error})"),
        remedy: "check the base's address".to_owned(),
    })?;
    let page = listener.local_addr().unwrap_or(at);
    println!("the page is at http://{page}/; Ctrl-C ends the station");
    let app = server::router(access, station::start(link, recorder));
    let served = tokio::select! {
        served = axum::serve(listener, app) => served,
        _ = tokio::signal::ctrl_c() => Ok(()),
    };
    served.map_err(|error| Unusable {
        wrong: format!("the page is served no more ({error})"),
        remedy: "start the station again".to_owned(),
    })
}

fn no_access(refused: Refused) -> Unusable {
    match refused {
        Refused::Token => Unusable {
            wrong: "other machines can reach this address".to_owned(),
            remedy: "add --token with a secret of your own, or leave --host out".to_owned(),
        },
        Refused::Host | Refused::Origin | Refused::Session => Unusable {
            wrong: "this machine gives no random numbers for a session".to_owned(),
            remedy: "start the station on another machine".to_owned(),
        },
    }
}

fn resolve(base: &BaseAddress) -> Result<SocketAddr, Unusable> {
    match base {
        BaseAddress::Udp { host, port } => {
            let found = (host.as_str(), *port).to_socket_addrs().ok();
            found.and_then(|mut found| found.next()).ok_or_else(|| Unusable {
                wrong: format!("there is no machine {host}"),
                remedy: "check the name in the base's address".to_owned(),
            })
        }
        BaseAddress::Radio(address) => radio(address),
    }
}

#[cfg(feature = "crazyradio")]
fn radio(address: &str) -> Result<SocketAddr, Unusable> {
    crate::radio::open(address).map_err(|error| {
        let error = error.to_string();
        let (wrong, remedy) = error.split_once("; ").unwrap_or((&error, "check the address"));
        Unusable { wrong: wrong.to_owned(), remedy: remedy.to_owned() }
    })
}

/// The answer of a build without the driver.
#[cfg(not(feature = "crazyradio"))]
fn radio(address: &str) -> Result<SocketAddr, Unusable> {
    Err(Unusable {
        wrong: "this uchain-ground was built without the Crazyradio's driver".to_owned(),
        remedy: format!(
            "build it with --features crazyradio, or start `cargo sim-radio bridge {address}` and \
             give udp://127.0.0.1:19850"
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_udp_with_host_and_port() {
        let address = |host: &str, port| Ok(BaseAddress::Udp { host: host.to_owned(), port });
        assert_eq!("udp://127.0.0.1:19854".parse(), address("127.0.0.1", 19_854));
        assert_eq!("udp://[::1]:1".parse(), address("::1", 1));
        for wrong in
            ["", "127.0.0.1:19854", "udp://127.0.0.1", "udp://:1", "udp://a:0", "udp://a:b"]
        {
            assert!(wrong.parse::<BaseAddress>().is_err(), "{wrong}");
        }
        let radio = "radio://0/80/2M/E7E7E7E70F";
        assert_eq!(radio.parse(), Ok(BaseAddress::Radio(radio.to_owned())));
    }
}
