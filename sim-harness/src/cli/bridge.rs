//! `uchain bridge`: a UDP port for cfclient, behind which a real drone is.

use std::fmt::Write as _;
use std::net::Ipv4Addr;

use bridge::{self, Event, FIRST_PORT, Ports, RadioAddress, Rate, Tally};
use clap::Args;
use input::InputError;
use serde_json::json;
use units::Instant;

use super::{Trouble, Verdict, complain, interrupt, put};

/// The address that a Crazyflie has until it is given another.
const DEFAULT_ADDRESS: &str = "radio://0/80/2M/E7E7E7E7E7";

#[derive(Args)]
pub(super) struct BridgeArgs {
    /// The drone: radio://, number of the Crazyradio, channel, data rate and address
    #[arg(default_value = DEFAULT_ADDRESS)]
    address: String,
    /// Polls per second, 10 to 1000; where left out, the address's rate_limit, or 100
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    rate: Option<u16>,
    /// UDP port to listen on; cfclient's scan finds 19850 to 19859
    #[arg(long, allow_negative_numbers = true, default_value_t = FIRST_PORT, value_name = "N")]
    port: u16,
    /// IPv4 address to listen on; 0.0.0.0 listens on all addresses of this machine
    #[arg(long, default_value_t = Ipv4Addr::LOCALHOST, value_name = "ADDRESS")]
    host: Ipv4Addr,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Print the counts of packets at the end as one JSON value on standard output
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &BridgeArgs) -> Result<Verdict, Trouble> {
    let address: RadioAddress = args.address.parse()?;
    let rate = match args.rate {
        None => address.rate.unwrap_or(Rate::DEFAULT),
        Some(rate) => Rate::per_second(rate).ok_or_else(|| {
            let wrong = format!("--rate {rate} is out of range");
            InputError::new(wrong, format!("give {} to {}", Rate::LEAST, Rate::MOST))
        })?,
    };
    let mut radio = open(&address)?;
    let ports = Ports::open(args.host, args.port, 1)?;
    announce(args, &address, &ports)?;
    let asked = interrupt::asks("Ctrl-C: the drone is no longer polled");
    let tell = |now: Instant, event: Event| {
        if !args.quiet {
            complain(format_args!("{:8.2} s  {event}", now.as_micros() as f64 * 1e-6));
        }
    };
    match bridge::run(&mut radio, ports, rate, asked, tell) {
        Ok(tally) => {
            finish(args, &address, tally)?;
            Ok(Verdict::Good)
        }
        Err(lost) => {
            complain(lost);
            Ok(Verdict::Failed)
        }
    }
}

#[cfg(feature = "crazyradio")]
fn open(address: &RadioAddress) -> Result<impl bridge::Radio, InputError> {
    bridge::Crazyradio::open(address)
}

/// The stand-in in a build without the driver.
#[cfg(not(feature = "crazyradio"))]
fn open(_: &RadioAddress) -> Result<NoRadio, InputError> {
    let wrong = "bridge: this uchain was built without the Crazyradio's driver";
    Err(InputError::new(wrong, "use `cargo sim-radio` in place of `cargo sim`"))
}

#[cfg(not(feature = "crazyradio"))]
enum NoRadio {}

#[cfg(not(feature = "crazyradio"))]
impl bridge::Radio for NoRadio {
    fn exchange(&mut self, _: &[u8]) -> Result<Option<Vec<u8>>, bridge::RadioLost> {
        match *self {}
    }
}

/// Prints one line with the port, once clients can connect.
fn announce(args: &BridgeArgs, address: &RadioAddress, ports: &Ports) -> Result<(), Trouble> {
    let port = ports.addresses().first().map(|port| format!("udp://{port}")).unwrap_or_default();
    let line = format!("bridging {port} to {address}; Ctrl-C ends it\n");
    match (args.json, args.quiet) {
        (true, _) => {
            complain(line.trim_end());
            Ok(())
        }
        (false, true) => Ok(()),
        (false, false) => put(&line),
    }
}

fn finish(args: &BridgeArgs, address: &RadioAddress, tally: Tally) -> Result<(), Trouble> {
    let Tally { received, sent, polls, unacknowledged } = tally;
    if args.json {
        let summary = json!({
            "address": address.to_string(),
            "version": env!("CARGO_PKG_VERSION"),
            "received": received,
            "sent": sent,
            "polls": polls,
            "unacknowledged": unacknowledged,
        });
        return put(&format!("{summary:#}\n"));
    }
    if args.quiet {
        return Ok(());
    }
    let mut text = format!("{address}\n");
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  packets               {received} received, {sent} sent");
    let _ = writeln!(text, "  polls                 {polls}, {unacknowledged} not acknowledged");
    put(&text)
}
