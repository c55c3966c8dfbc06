//! The target of a Crazyflie at a debug probe, by probe-rs.
//!
//! No board was at hand when this file was written: it compiles, and was never run.

use std::fmt;
use std::path::Path;
use std::time::{Duration as WallDuration, Instant as WallInstant};

use input::InputError;
use probe_rs::probe::list::Lister;
use probe_rs::rtt::{Rtt, ScanRegion, find_rtt_control_block_in_raw_file, try_attach_to_rtt};
use probe_rs::{Permissions, Session};
use units::{Duration, Instant};

use super::target::{BUILD, DOWN, Lost, Target, UP};

/// The chip of the Crazyflie 2.1 and 2.1+, by its name in probe-rs.
const CHIP: &str = "STM32F405RGTx";
/// The firmware writes its control block before `main`, some milliseconds after the bootloader has
/// jumped to it.
const BOOT: WallDuration = WallDuration::from_secs(2);
/// Bytes that are taken at a time.
const CHUNK: usize = 1024;
/// How to get a probe to work.
const WIRE: &str = "see \"What to wire\" in the book's chapter \"Replay\"";

/// A Crazyflie at a debug probe, without propellers.
pub struct ProbeTarget {
    session: Session,
    rtt: Rtt,
    began: WallInstant,
}

impl ProbeTarget {
    /// Attaches to the chip at the only probe, resets it, and looks for the firmware's channels: at
    /// the address that the ELF names, or in all of the RAM.
    ///
    /// # Errors
    /// When there is no probe, or more than one; when the chip is another, or cannot be reached; and
    /// when its firmware has no channel for a replay.
    pub fn attach(elf: Option<&Path>) -> Result<Self, InputError> {
        let region = elf.map_or(Ok(ScanRegion::Ram), block_of)?;
        let probes = Lister::new().list_all();
        let probe = match probes.as_slice() {
            [] => return Err(InputError::new("there is no debug probe", WIRE)),
            [probe] => probe.open().map_err(|why| unusable("the debug probe", &why))?,
            several => {
                let wrong = format!("there are {} debug probes", several.len());
                return Err(InputError::new(wrong, "unplug all but one"));
            }
        };
        let mut session = probe
            .attach_under_reset(CHIP, Permissions::default())
            .map_err(|why| unusable("an STM32F405 at the debug probe", &why))?;
        let mut rtt = channels(&mut session, &region)?;
        if rtt.down_channel(DOWN as usize).is_none() || rtt.up_channel(UP as usize).is_none() {
            let wrong = "the firmware on the chip has no channel for a replay";
            return Err(InputError::new(wrong, BUILD));
        }
        Ok(Self { session, rtt, began: WallInstant::now() })
    }
}

/// The address of the control block that an ELF names.
fn block_of(elf: &Path) -> Result<ScanRegion, InputError> {
    let wrong = |what: String| InputError::new(what, BUILD).in_file(elf);
    let bytes = input::file::read(elf, input::file::LARGEST_ELF)
        .map_err(|why| wrong(format!("cannot be read: {why}")))?;
    let block = find_rtt_control_block_in_raw_file(&bytes)
        .map_err(|why| wrong(format!("is no ELF: {why}")))?;
    block.map(ScanRegion::Exact).ok_or_else(|| wrong("has no RTT control block".into()))
}

/// Starts the firmware from its reset, and waits for its control block.
fn channels(session: &mut Session, region: &ScanRegion) -> Result<Rtt, InputError> {
    let what = "the chip at the debug probe";
    let mut core = session.core(0).map_err(|why| unusable(what, &why))?;
    core.reset().map_err(|why| unusable(what, &why))?;
    try_attach_to_rtt(&mut core, BOOT, region)
        .map_err(|why| unusable("the channels of the firmware on the chip", &why))
}

fn unusable(what: &str, why: &dyn fmt::Display) -> InputError {
    // One line, whatever probe-rs says.
    let why = why.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    InputError::new(format!("{what} cannot be used: {why}"), WIRE)
}

fn lost(why: &dyn fmt::Display) -> Lost {
    Lost(why.to_string().split_whitespace().collect::<Vec<_>>().join(" "))
}

impl Target for ProbeTarget {
    const NAME: &'static str = "probe";

    fn write(&mut self, bytes: &[u8]) -> Result<usize, Lost> {
        let mut core = self.session.core(0).map_err(|why| lost(&why))?;
        let Some(channel) = self.rtt.down_channel(DOWN as usize) else { return Ok(0) };
        channel.write(&mut core, bytes).map_err(|why| lost(&why))
    }

    fn read(&mut self) -> Result<Vec<u8>, Lost> {
        let mut core = self.session.core(0).map_err(|why| lost(&why))?;
        let mut bytes = vec![0; CHUNK];
        let Some(channel) = self.rtt.up_channel(UP as usize) else { return Ok(Vec::new()) };
        let count = channel.read(&mut core, &mut bytes).map_err(|why| lost(&why))?;
        bytes.truncate(count);
        Ok(bytes)
    }

    fn run(&mut self, span: Duration) -> Result<(), Lost> {
        std::thread::sleep(WallDuration::from_micros(span.as_micros()));
        Ok(())
    }

    fn now(&self) -> Instant {
        Instant::from_micros(self.began.elapsed().as_micros() as u64)
    }
}
