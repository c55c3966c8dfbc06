//! The cycles of instructions, by table 3-1 of the Cortex-M0 Technical Reference Manual.

use nrf51_chip::core::Core;

use crate::flat::{Flat, RAM};

/// What an instruction is, its encoding, and its cycles.
const CYCLES: [(&str, &[u16], u32); 24] = [
    ("MOVS r0, #1", &[0x2001], 1),
    ("ADDS r0, r1, r2", &[0x1888], 1),
    ("MULS r0, r1", &[0x4348], 1),
    ("MOV pc, r3", &[0x469F], 3),
    ("ADD pc, r4", &[0x44A7], 3),
    ("LDR r0, [r5]", &[0x6828], 2),
    ("LDRB r0, [r5]", &[0x7828], 2),
    ("STRH r0, [r5]", &[0x8028], 2),
    ("LDM r5, {r0, r1, r2}", &[0xCD07], 4),
    ("STM r5, {r0}", &[0xC501], 2),
    ("PUSH {r0, lr}", &[0xB501], 3),
    ("POP {r0, r1}", &[0xBC03], 3),
    ("POP {r4, pc}", &[0xBD10], 6),
    ("B, always", &[0xE000], 3),
    ("BEQ, not taken", &[0xD000], 1),
    ("BNE, taken", &[0xD100], 3),
    ("BL", &[0xF000, 0xF800], 4),
    ("BX r3", &[0x4718], 3),
    ("BLX r3", &[0x4798], 3),
    ("MRS r0, PRIMASK", &[0xF3EF, 0x8010], 4),
    ("DSB", &[0xF3BF, 0x8F4F], 4),
    ("CPSID i", &[0xB672], 1),
    ("NOP", &[0xBF00], 1),
    ("WFE", &[0xBF20], 2),
];

#[test]
fn instructions_take_the_cycles_of_the_manual() {
    for (name, code, cycles) in CYCLES {
        let mut memory = Flat::with(&[(0, RAM + 0x800), (4, 0x101)], &[(0x100, code)]);
        // What POP loads into PC.
        memory.ram[0x804] = 0x01;
        memory.ram[0x805] = 0x02;
        let mut core = Core::new(&mut memory, 0).unwrap();
        core.set_register(3, 0x201);
        core.set_register(5, RAM + 0x100);
        assert_eq!(core.step(&mut memory), Ok(cycles), "{name}");
    }
}
