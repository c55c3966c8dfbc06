//! USB OTG FS as a device without a host (RM0090, "USB on-the-go full-speed (OTG_FS)").
//!
//! The socket of a drone that flies is empty. A device that is switched on there pulls D+ up and
//! sees an idle bus: after 3 ms it is suspended, once, and nothing else happens. Registers keep what
//! software sets up. Host mode, packets and the wake-up by a cable are refused.

use crate::bus::Refused;
use crate::soc::wiring::Nanos;

const GOTGCTL: u32 = 0x000;
const GOTGINT: u32 = 0x004;
const GAHBCFG: u32 = 0x008;
const GUSBCFG: u32 = 0x00C;
const GRSTCTL: u32 = 0x010;
const GINTSTS: u32 = 0x014;
const GINTMSK: u32 = 0x018;
const GRXSTSR: u32 = 0x01C;
const GRXSTSP: u32 = 0x020;
const GRXFSIZ: u32 = 0x024;
const DIEPTXF0: u32 = 0x028;
const HNPTXSTS: u32 = 0x02C;
const GCCFG: u32 = 0x038;
const DIEPTXF1: u32 = 0x104;
const DCFG: u32 = 0x800;
const DCTL: u32 = 0x804;
const DSTS: u32 = 0x808;
const DIEPMSK: u32 = 0x810;
const DOEPMSK: u32 = 0x814;
const DAINT: u32 = 0x818;
const DAINTMSK: u32 = 0x81C;
const DIEPEMPMSK: u32 = 0x834;
const IN: u32 = 0x900;
const OUT: u32 = 0xB00;
const PCGCCTL: u32 = 0xE00;
const FIFOS: u32 = 0x1000;

/// Endpoints in each direction, and the distance between their registers.
const ENDPOINTS: usize = 4;
const BETWEEN: u32 = 0x20;

/// GAHBCFG: the gate of the interrupt.
const GINT: u32 = 1;
/// GUSBCFG: force host mode.
const FHMOD: u32 = 1 << 29;
/// GRSTCTL: resets and flushes end by themselves, at once here; the bus is idle.
const TXFNUM: u32 = 0x1F << 6;
const CSRST: u32 = 1;
const AHBIDL: u32 = 1 << 31;
/// GINTSTS.
const ESUSP: u32 = 1 << 10;
const USBSUSP: u32 = 1 << 11;
/// Empty transmit FIFOs.
const NPTXFE: u32 = 1 << 5;
/// The flags that are cleared by writing one.
const BY_WRITING: u32 = 0xF030_FC0A;
/// GCCFG: the transceiver is on; the supply of the cable is not looked at.
const PWRDWN: u32 = 1 << 16;
const NOVBUSSENS: u32 = 1 << 21;
/// DCTL: soft disconnect, and commands that read as zero.
const SDIS: u32 = 1 << 1;
const COMMANDS: u32 = 0xF << 7;
/// DSTS: suspended; full speed.
const SUSPSTS: u32 = 1;
const FULL_SPEED: u32 = 3 << 1;
/// DxEPCTL: enable, disable, what sets and clears NAK, NAK.
const EPENA: u32 = 1 << 31;
const EPDIS: u32 = 1 << 30;
const SNAK: u32 = 1 << 27;
const CNAK: u32 = 1 << 26;
const NAKSTS: u32 = 1 << 17;
const EPCTL: u32 = 0x03EC_87FF;
const USBAEP: u32 = 1 << 15;
/// DIEPINT: the transmit FIFO is empty.
const TXFE: u32 = 1 << 7;

/// An idle bus for so long suspends a device (USB 2.0, 7.1.7.6).
const IDLE: Nanos = 3_000_000;

/// The registers of an endpoint.
#[derive(Clone, Copy, Debug, Default)]
struct Endpoint {
    control: u32,
    size: u32,
}

/// The registers.
#[derive(Clone, Debug)]
pub(crate) struct Usb {
    gahbcfg: u32,
    gusbcfg: u32,
    txfnum: u32,
    gintsts: u32,
    gintmsk: u32,
    /// GRXFSIZ, DIEPTXF0 to DIEPTXF3.
    fifos: [u32; 5],
    gccfg: u32,
    dcfg: u32,
    dctl: u32,
    /// DIEPMSK, DOEPMSK, DAINTMSK, DIEPEMPMSK.
    masks: [u32; 4],
    ins: [Endpoint; ENDPOINTS],
    outs: [Endpoint; ENDPOINTS],
    pcgcctl: u32,
    /// When the idle bus suspends the device; `Nanos::MAX` for never.
    suspends: Nanos,
    suspended: bool,
}

impl Usb {
    pub(crate) fn new() -> Self {
        let mut endpoints = [Endpoint::default(); ENDPOINTS];
        endpoints[0].control = USBAEP;
        Self {
            gahbcfg: 0,
            gusbcfg: 0x0A00,
            txfnum: 0,
            gintsts: 0,
            gintmsk: 0,
            fifos: [0x200; 5],
            gccfg: 0,
            dcfg: 0x0220_0000,
            dctl: 0,
            masks: [0; 4],
            ins: endpoints,
            outs: endpoints,
            pcgcctl: 0,
            suspends: Nanos::MAX,
            suspended: false,
        }
    }

    pub(crate) const fn due(&self) -> Nanos {
        self.suspends
    }

    /// Everything happens that is due by now.
    pub(crate) fn settle(&mut self, now: Nanos) {
        if self.suspends <= now {
            self.suspends = Nanos::MAX;
            self.suspended = true;
            self.gintsts |= ESUSP | USBSUSP;
        }
    }

    /// OTG_FS's global interrupt.
    pub(crate) fn lines(&self) -> u128 {
        let raised = self.gahbcfg & GINT != 0 && self.status() & self.gintmsk != 0;
        u128::from(raised) << 67
    }

    fn status(&self) -> u32 {
        self.gintsts | NPTXFE
    }

    /// The pull-up of D+ is on: the transceiver has power, and the session counts as valid.
    fn is_attached(&self) -> bool {
        self.gccfg & (PWRDWN | NOVBUSSENS) == PWRDWN | NOVBUSSENS && self.dctl & SDIS == 0
    }

    /// The device may have been attached or detached.
    fn watch(&mut self, attached: bool, now: Nanos) {
        if self.is_attached() != attached {
            self.suspended = false;
            self.suspends = if attached { Nanos::MAX } else { now + IDLE };
        }
    }

    pub(crate) fn read(&mut self, offset: u32, now: Nanos) -> Result<u32, Refused> {
        self.settle(now);
        Ok(match offset {
            // CIDSTS: the ID pin is open.
            GOTGCTL => 1 << 16,
            GOTGINT | DAINT => 0,
            GAHBCFG => self.gahbcfg,
            GUSBCFG => self.gusbcfg,
            GRSTCTL => AHBIDL | self.txfnum,
            GINTSTS => self.status(),
            GINTMSK => self.gintmsk,
            GRXSTSR | GRXSTSP => return refuse("OTG_FS_GRXSTS: nothing was received"),
            GRXFSIZ | DIEPTXF0 => self.fifos[(offset - GRXFSIZ) as usize / 4],
            // All of the FIFO is free, and eight places of the queue.
            HNPTXSTS => 8 << 16 | self.fifos[1] >> 16,
            GCCFG => self.gccfg,
            DIEPTXF1..=0x10C => self.fifos[2 + (offset - DIEPTXF1) as usize / 4],
            DCFG => self.dcfg,
            DCTL => self.dctl,
            DSTS => FULL_SPEED | if self.suspended { SUSPSTS } else { 0 },
            DIEPMSK | DOEPMSK => self.masks[(offset - DIEPMSK) as usize / 4],
            DAINTMSK => self.masks[2],
            DIEPEMPMSK => self.masks[3],
            IN..FIFOS if offset != PCGCCTL => return self.read_endpoint(offset),
            PCGCCTL => self.pcgcctl,
            _ => return refuse("OTG_FS: a register of the host's or a FIFO"),
        })
    }

    fn read_endpoint(&self, offset: u32) -> Result<u32, Refused> {
        let (is_in, endpoint, register) = place(offset)?;
        let registers = if is_in { &self.ins } else { &self.outs };
        match register {
            0x00 => Ok(registers[endpoint].control),
            0x08 => Ok(if is_in { TXFE } else { 0 }),
            0x10 => Ok(registers[endpoint].size),
            // DTXFSTS: the words that are free.
            0x18 if is_in => Ok(self.fifos[1 + endpoint] >> 16),
            _ => refuse("OTG_FS: a reserved register of an endpoint"),
        }
    }

    pub(crate) fn write(&mut self, offset: u32, value: u32, now: Nanos) -> Result<(), Refused> {
        self.settle(now);
        let attached = self.is_attached();
        match offset {
            // Flags that nothing sets, or that are cleared elsewhere.
            GOTGINT | DAINT => {}
            GAHBCFG => self.gahbcfg = value & 0x181,
            GUSBCFG if value & FHMOD != 0 => return refuse("OTG_FS_GUSBCFG: host mode"),
            GUSBCFG => self.gusbcfg = value & 0xC000_3F47,
            GRSTCTL if value & CSRST != 0 => *self = self.after_core_reset(),
            GRSTCTL => self.txfnum = value & TXFNUM,
            GINTSTS => self.gintsts &= !(value & BY_WRITING),
            GINTMSK => self.gintmsk = value,
            GRXFSIZ | DIEPTXF0 => self.fifos[(offset - GRXFSIZ) as usize / 4] = value,
            GCCFG => self.gccfg = value & 0x003D_0000,
            DIEPTXF1..=0x10C => self.fifos[2 + (offset - DIEPTXF1) as usize / 4] = value,
            DCFG => self.dcfg = value & 0x0000_1FF7,
            DCTL => self.dctl = value & !COMMANDS & 0x0000_0873,
            DIEPMSK | DOEPMSK => self.masks[(offset - DIEPMSK) as usize / 4] = value,
            DAINTMSK => self.masks[2] = value,
            DIEPEMPMSK => self.masks[3] = value,
            IN..FIFOS if offset != PCGCCTL => return self.write_endpoint(offset, value),
            PCGCCTL if value != 0 => return refuse("OTG_FS_PCGCCTL: clocks that are stopped"),
            PCGCCTL => self.pcgcctl = value,
            _ => return refuse("OTG_FS: a register of the host's or a FIFO"),
        }
        self.watch(attached, now);
        Ok(())
    }

    fn write_endpoint(&mut self, offset: u32, value: u32) -> Result<(), Refused> {
        let (is_in, endpoint, register) = place(offset)?;
        let registers = if is_in { &mut self.ins } else { &mut self.outs };
        let Endpoint { control, size } = &mut registers[endpoint];
        match register {
            0x00 if value & EPDIS != 0 && *control & EPENA != 0 => {
                return refuse("OTG_FS: an endpoint switched off that waits for the host");
            }
            0x00 => {
                let nak = match (value & SNAK != 0, value & CNAK != 0) {
                    (true, _) => NAKSTS,
                    (false, true) => 0,
                    (false, false) => *control & NAKSTS,
                };
                // Once enabled, an endpoint waits for the host, which never comes.
                *control = value & EPCTL & !NAKSTS | nak | (value | *control) & EPENA;
            }
            // Flags that the host would set.
            0x08 => {}
            0x10 => *size = value,
            _ => return refuse("OTG_FS: a reserved register of an endpoint"),
        }
        Ok(())
    }

    /// The soft reset of the core: it leaves GCCFG alone, and GUSBCFG's choices (CSRST).
    fn after_core_reset(&self) -> Self {
        Self { gusbcfg: self.gusbcfg, gccfg: self.gccfg, ..Self::new() }
    }
}

/// The direction, endpoint and register of an address.
fn place(offset: u32) -> Result<(bool, usize, u32), Refused> {
    let is_in = offset < OUT;
    let within = offset - if is_in { IN } else { OUT };
    let endpoint = (within / BETWEEN) as usize;
    if endpoint >= ENDPOINTS {
        return refuse("OTG_FS: an endpoint that there is not");
    }
    Ok((is_in, endpoint, within % BETWEEN))
}

fn refuse<T>(what: &'static str) -> Result<T, Refused> {
    Err(Refused::Unmodelled { what })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn switched_on(now: Nanos) -> Usb {
        let mut usb = Usb::new();
        for (register, value) in
            [(GRSTCTL, CSRST), (GCCFG, PWRDWN | NOVBUSSENS), (GINTMSK, USBSUSP), (GAHBCFG, GINT)]
        {
            usb.write(register, value, now).expect("it is modelled");
        }
        usb
    }

    #[test]
    fn an_empty_socket_suspends_the_device_once() {
        let mut usb = switched_on(1_000);
        assert_eq!(usb.due(), 1_000 + IDLE);
        assert_eq!(usb.lines(), 0);
        usb.settle(1_000 + IDLE);
        assert_eq!(usb.lines(), 1 << 67);
        assert_eq!(usb.read(DSTS, 4_000_000), Ok(FULL_SPEED | SUSPSTS));
        assert_eq!(usb.write(GINTSTS, USBSUSP, 4_000_000), Ok(()));
        assert_eq!((usb.lines(), usb.due()), (0, Nanos::MAX));
    }

    #[test]
    fn a_device_that_is_detached_sees_no_bus() {
        let mut usb = switched_on(0);
        usb.write(DCTL, SDIS, 1).expect("it is modelled");
        assert_eq!(usb.due(), Nanos::MAX);
        let mut without_sensing = Usb::new();
        without_sensing.write(GCCFG, PWRDWN, 1).expect("it is modelled");
        assert_eq!(without_sensing.due(), Nanos::MAX, "VBUS is sensed, and there is none");
    }

    #[test]
    fn resets_and_flushes_end_by_themselves() {
        let mut usb = Usb::new();
        for command in [CSRST, 1 << 4, 1 << 5 | TXFNUM] {
            usb.write(GRSTCTL, command, 0).expect("it is modelled");
            let status = usb.read(GRSTCTL, 0).expect("it is modelled");
            assert_eq!((status & 0x3F, status & AHBIDL), (0, AHBIDL));
        }
    }

    #[test]
    fn an_endpoint_waits_for_a_host_that_never_comes() {
        let mut usb = switched_on(0);
        let control = OUT + BETWEEN;
        usb.write(control, EPENA | CNAK | 64, 0).expect("it is modelled");
        assert_eq!(usb.read(control, 0), Ok(EPENA | 64));
        usb.write(control, SNAK | 64, 0).expect("it is modelled");
        assert_eq!(usb.read(control, 0), Ok(EPENA | NAKSTS | 64));
        assert!(usb.write(control, EPDIS, 0).is_err());
        assert!(usb.read(OUT + 4 * BETWEEN, 0).is_err());
        assert!(usb.write(GUSBCFG, FHMOD, 0).is_err());
        assert!(usb.write(FIFOS, 1, 0).is_err());
    }
}
