//! A program for the tests of what reads ELF files. It counts, logs once by defmt over RTT, and asks
//! itself for a supervisor call. Compiled, with `rustc` 1.95 in this directory:
//!
//! ```sh
//! rustc --edition 2024 --target thumbv7em-none-eabihf --crate-name tiny -C opt-level=s \
//!     -C debuginfo=2 -C panic=abort -C symbol-mangling-version=v0 -C force-unwind-tables=no \
//!     -C link-arg=-Ttiny.x -C link-arg=--nmagic --remap-path-prefix "$PWD=/house" \
//!     --remap-path-prefix "$(rustc --print sysroot)=/rust" tiny.rs -o tiny.elf
//! ```
#![no_std]
#![no_main]

use core::arch::{asm, naked_asm};

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}

unsafe extern "C" {
    static mut __sdata: u32;
    static mut __edata: u32;
    static __sidata: u32;
}

#[repr(C)]
pub struct Channel {
    name: u32,
    buffer: u32,
    size: u32,
    write: u32,
    read: u32,
    flags: u32,
}

#[repr(C)]
pub struct Header {
    id: [u8; 16],
    up: u32,
    down: u32,
    channel: Channel,
}

#[unsafe(no_mangle)]
static mut _SEGGER_RTT: Header = Header {
    id: *b"SEGGER RTT\0\0\0\0\0\0",
    up: 1,
    down: 0,
    channel: Channel { name: 0, buffer: 0, size: 16, write: 0, read: 0, flags: 0 },
};
static mut BUFFER: [u8; 16] = [0; 16];
pub static mut COUNT: u32 = 7;

#[unsafe(link_section = ".defmt")]
#[unsafe(export_name = "{\"package\":\"tiny\",\"tag\":\"defmt_info\",\"data\":\"counted to {=u8}\",\"disambiguator\":\"1\",\"crate_name\":\"tiny\"}")]
#[used]
static COUNTED: u8 = 0;
#[unsafe(export_name = "_defmt_encoding_ = rzcobs")]
#[used]
static ENCODING: u8 = 0;

#[unsafe(link_section = ".vector_table")]
#[unsafe(no_mangle)]
#[used]
static __RESET_VECTOR: [unsafe extern "C" fn(); 15] = {
    let other = wait as unsafe extern "C" fn();
    [
        reset, other, other, other, other, other, other, other, other, other, svcall, other, other,
        other, other,
    ]
};

extern "C" fn wait() {
    loop {}
}

#[unsafe(no_mangle)]
unsafe extern "C" fn reset() {
    unsafe {
        let (mut to, mut from) = (&raw mut __sdata, &raw const __sidata);
        while to < &raw mut __edata {
            to.write_volatile(from.read_volatile());
            (to, from) = (to.add(1), from.add(1));
        }
        // VTOR: a bootloader leaves it as it is.
        (0xE000_ED08 as *mut u32).write_volatile((&raw const __RESET_VECTOR as u32) - 4);
        (&raw mut _SEGGER_RTT.channel.buffer).write_volatile(&raw const BUFFER as u32);
    }
    main()
}

fn main() {
    log(COUNTED_INDEX, 42);
    loop {
        outer(3);
    }
}

const COUNTED_INDEX: u8 = 1;

/// One message: what it is, two bytes with the low one first, and an argument; rzCOBS has the zero
/// behind the index as a bit.
#[inline(never)]
fn log(index: u8, value: u8) {
    unsafe {
        let buffer = &raw mut BUFFER as *mut u8;
        for (at, byte) in [index, value, 0x7A, 0].into_iter().enumerate() {
            buffer.add(at).write_volatile(byte);
        }
        (&raw mut _SEGGER_RTT.channel.write).write_volatile(4);
    }
}

#[inline(never)]
pub fn outer(n: u32) -> u32 {
    let mut sum = 0;
    for i in 0..n {
        sum += middle(i);
    }
    sum
}

#[inline(always)]
fn middle(n: u32) -> u32 {
    inner(n) + 1
}

#[inline(never)]
pub fn inner(n: u32) -> u32 {
    unsafe {
        let count = (&raw const COUNT).read_volatile();
        (&raw mut COUNT).write_volatile(count + n);
        call_supervisor();
        count
    }
}

#[inline(always)]
fn call_supervisor() {
    unsafe { asm!("svc 0", options(nomem)) };
}

#[unsafe(no_mangle)]
unsafe extern "C" fn svcall() {
    supervise(core::hint::black_box(5));
    supervise(core::hint::black_box(6));
}

#[inline(never)]
fn supervise(n: u32) {
    unsafe { (&raw mut COUNT).write_volatile((&raw const COUNT).read_volatile() + n) };
    leaf();
}

/// Without a frame, and with data among its code.
#[unsafe(naked)]
extern "C" fn leaf() {
    naked_asm!("ldr r0, 1f", "nop", "bx lr", ".balign 4", "1: .word 0x12345678")
}
