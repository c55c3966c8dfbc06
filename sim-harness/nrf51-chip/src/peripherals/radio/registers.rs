//! The registers, events and shortcuts of RADIO, by their places (Nordic's `nrf51.h`).

/// The offsets of the registers.
pub(super) mod offset {
    pub(in crate::peripherals::radio) const TXEN: u32 = 0x000;
    pub(in crate::peripherals::radio) const RXEN: u32 = 0x004;
    pub(in crate::peripherals::radio) const START: u32 = 0x008;
    pub(in crate::peripherals::radio) const STOP: u32 = 0x00C;
    pub(in crate::peripherals::radio) const DISABLE: u32 = 0x010;
    pub(in crate::peripherals::radio) const RSSISTART: u32 = 0x014;
    pub(in crate::peripherals::radio) const RSSISTOP: u32 = 0x018;
    pub(in crate::peripherals::radio) const SHORTS: u32 = 0x200;
    pub(in crate::peripherals::radio) const CRCSTATUS: u32 = 0x400;
    pub(in crate::peripherals::radio) const RXMATCH: u32 = 0x408;
    pub(in crate::peripherals::radio) const RXCRC: u32 = 0x40C;
    pub(in crate::peripherals::radio) const PACKETPTR: u32 = 0x504;
    pub(in crate::peripherals::radio) const FREQUENCY: u32 = 0x508;
    pub(in crate::peripherals::radio) const TXPOWER: u32 = 0x50C;
    pub(in crate::peripherals::radio) const MODE: u32 = 0x510;
    pub(in crate::peripherals::radio) const PCNF0: u32 = 0x514;
    pub(in crate::peripherals::radio) const PCNF1: u32 = 0x518;
    pub(in crate::peripherals::radio) const BASE0: u32 = 0x51C;
    pub(in crate::peripherals::radio) const BASE1: u32 = 0x520;
    pub(in crate::peripherals::radio) const PREFIX0: u32 = 0x524;
    pub(in crate::peripherals::radio) const TXADDRESS: u32 = 0x52C;
    pub(in crate::peripherals::radio) const RXADDRESSES: u32 = 0x530;
    pub(in crate::peripherals::radio) const CRCCNF: u32 = 0x534;
    pub(in crate::peripherals::radio) const TIFS: u32 = 0x544;
    pub(in crate::peripherals::radio) const RSSISAMPLE: u32 = 0x548;
    pub(in crate::peripherals::radio) const STATE: u32 = 0x550;
    pub(in crate::peripherals::radio) const POWER: u32 = 0xFFC;
}

/// The events, by their place.
pub(super) mod event {
    pub(in crate::peripherals::radio) const READY: u32 = 0;
    pub(in crate::peripherals::radio) const ADDRESS: u32 = 1;
    pub(in crate::peripherals::radio) const PAYLOAD: u32 = 2;
    pub(in crate::peripherals::radio) const END: u32 = 3;
    pub(in crate::peripherals::radio) const DISABLED: u32 = 4;
    pub(in crate::peripherals::radio) const RSSIEND: u32 = 7;
    pub(in crate::peripherals::radio) const ALL: u32 = 0x9F;
}

/// The shortcuts, by their bits.
pub(super) mod short {
    pub(in crate::peripherals::radio) const READY_START: u32 = 1 << 0;
    pub(in crate::peripherals::radio) const END_DISABLE: u32 = 1 << 1;
    pub(in crate::peripherals::radio) const DISABLED_TXEN: u32 = 1 << 2;
    pub(in crate::peripherals::radio) const DISABLED_RXEN: u32 = 1 << 3;
    pub(in crate::peripherals::radio) const ADDRESS_RSSISTART: u32 = 1 << 4;
    pub(in crate::peripherals::radio) const END_START: u32 = 1 << 5;
}
