//! `uchain serve` with the vendor's firmware in place of this project's.

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use bridge::Ports;
use input::InputError;
use serde_json::json;
use units::{Duration, Instant};

use crate::cli::{Common, Trouble, Verdict, VirtualArgs, complain};
use serve::{self, Event};
use stock::served::Served;
use stock::{StockDrone, StockFirmware};

/// The vendor's firmware, if it is in the file of virtual drones.
pub(in crate::cli) fn firmware(
    args: &VirtualArgs,
    is_virtual: bool,
) -> Result<Option<StockFirmware>, InputError> {
    let elf = args.elf.as_deref().filter(|elf| is_virtual && StockFirmware::is_at(elf));
    let open = |elf| StockFirmware::open(elf)?.with_radio(args.radio_elf.as_deref());
    elf.map(open).transpose()
}

/// Serves a drone that runs it.
pub(in crate::cli) fn serve(
    firmware: &StockFirmware,
    common: &Common,
    ports: Ports,
    (speed, duration): (f64, Option<Duration>),
    asked: &AtomicBool,
) -> Result<Verdict, Trouble> {
    let folder = common.folder()?;
    let line = format!(
        "serving crazyflie-firmware: udp://{}; Ctrl-C ends it\n",
        ports.addresses().first().map_or_else(String::new, ToString::to_string)
    );
    match (common.json, common.quiet) {
        (true, _) => complain(line.trim_end()),
        (false, true) => {}
        (false, false) => crate::cli::put(&line)?,
    }
    let tell = |now: Instant, event: Event| {
        if !common.quiet || event == Event::Late {
            complain(format_args!("{:8.2} s  {event}", now.as_micros() as f64 * 1e-6));
        }
    };
    let world = Served::new(StockDrone::new(firmware, common.seed));
    let (world, tally) = serve::serve(world, ports, speed, duration, asked, tell);
    let seconds = world.drone().now_ms() as f64 * 1e-3;
    let mut table = String::from("crazyflie-firmware\n");
    // Writing to a string cannot fail.
    let _ = writeln!(table, "  served for            {seconds:.1} s of simulated time");
    let _ =
        writeln!(table, "  packets               {} received, {} sent", tally.received, tally.sent);
    let summary = json!({
        "firmware": "crazyflie-firmware",
        "duration_s": seconds,
        "served": { "received": tally.received, "sent": tally.sent },
        "refused": world.halted(),
    });
    common.finish(folder, &table, &summary)?;
    if let Some(halted) = world.halted() {
        complain(halted);
        return Ok(Verdict::Failed);
    }
    Ok(Verdict::Good)
}
