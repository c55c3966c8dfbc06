//! The handler of hard faults: bad addresses, undefined instructions, stack overflows.
//!
//! The stack itself may have failed, so the handler switches to another one before it pushes
//! anything. Then it stops the motors, writes the crash record and resets.
#![expect(unsafe_code, reason = "an exception's handler")]

use core::arch::naked_asm;

use cortex_m::peripheral::SCB;

use crate::board::motors;
use crate::safety::{panic, stack};

/// Switches to the stack that `memory.x` reserves for it, and calls [`hard_fault`] with the old stack
/// pointer.
///
/// It replaces cortex-m-rt's handler, whose first instruction needs the stack.
#[unsafe(naked)]
// SAFETY: nothing else has this name; cortex-m-rt leaves it to the program.
#[unsafe(export_name = "HardFault")]
unsafe extern "C" fn enter() -> ! {
    naked_asm!(
        "tst lr, #4",
        "ite eq",
        "mrseq r0, msp",
        "mrsne r0, psp",
        "movw r1, #:lower16:_fault_stack_start",
        "movt r1, #:upper16:_fault_stack_start",
        "msr msp, r1",
        "b {rest}",
        rest = sym hard_fault,
    )
}

/// Reads the exception frame and ends the run. `frame` is the address at which the processor has
/// pushed its registers, or would have if there had been room.
extern "C" fn hard_fault(frame: *const u32) -> ! {
    motors::stop();
    let address = frame.addr() as u32;
    let [lr, pc, psr] = [5, 6, 7].map(|word| {
        if !stack::holds_frame(address) {
            return 0;
        }
        // SAFETY: eight words from here on lie within the stack.
        unsafe { frame.wrapping_add(word).read_volatile() }
    });
    // SAFETY: two registers of the core, read without a side effect.
    let (cfsr, bfar) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).bfar.read()) };
    panic::end_by_fault([pc, lr, cfsr, bfar, psr & 0x1FF, address])
}
