//! Where loads and stores go.

use virtual_crazyflie::bus::Width;
use virtual_crazyflie::cpu::Stop;

use super::rig::{CODE, DATA, REGISTER, Rig};

/// LDR R1, [R2] and STR R1, [R2].
const LOAD: u16 = 0x6811;
const STORE: u16 = 0x6011;

#[test]
fn each_memory_is_where_it_is() {
    for address in [0x2000_0000, 0x2001_FFFC, 0x1000_0000, 0x1000_FFFC] {
        let mut rig = Rig::new(&[STORE, LOAD]).with(1, 0xCAFE_F00D).with(2, address);
        rig.steps(1);
        assert_eq!(rig.read(address), 0xCAFE_F00D);
        rig.cpu.set_register(1, 0);
        rig.steps(1);
        assert_eq!(rig.cpu.register(1), 0xCAFE_F00D);
    }
    // Flash is read, at its own address and where it is mapped at boot.
    for address in [CODE, CODE - 0x0800_0000] {
        let mut rig = Rig::new(&[LOAD, 0xBF00]).with(2, address);
        rig.steps(1);
        assert_eq!(rig.cpu.register(1), 0xBF00_6811);
    }
}

#[test]
fn a_bit_of_ram_can_be_reached_by_an_address_of_its_own() {
    for bit in [0, 7, 13, 31] {
        let alias = 0x2200_0000 + (DATA - 0x2000_0000) * 32 + bit * 4;
        let mut rig = Rig::new(&[STORE, LOAD]).with(1, 0xFFFF_FFFF).with(2, alias);
        rig.word(DATA, 0);
        rig.steps(2);
        assert_eq!(rig.read(DATA), 1 << bit);
        assert_eq!(rig.cpu.register(1), 1);
        let mut rig = Rig::new(&[STORE]).with(1, 0xFFFF_FFFE).with(2, alias);
        rig.word(DATA, u32::MAX);
        rig.steps(1);
        assert_eq!(rig.read(DATA), !(1 << bit));
    }
}

#[test]
fn a_bit_of_a_register_is_changed_by_a_load_and_a_store() {
    let mut rig = Rig::new(&[STORE]).with(1, 1).with(2, 0x4200_0000 + 9 * 4);
    rig.bus.value = 0x8000_0001;
    rig.steps(1);
    assert_eq!(rig.bus.value, 0x8000_0201);
    assert_eq!(rig.bus.stores.len(), 1);
    assert_eq!(rig.bus.stores[0].1, REGISTER);
}

#[test]
fn what_is_not_memory_is_asked_with_its_width() {
    // STRB, STRH, STR R1, [R2]
    for (code, width, value) in [
        (0x7011, Width::Byte, 0x78),
        (0x8011, Width::Half, 0x5678),
        (STORE, Width::Word, 0x1234_5678),
    ] {
        let mut rig = Rig::new(&[code]).with(1, 0x1234_5678).with(2, REGISTER);
        rig.steps(1);
        let (_, address, asked, stored) = rig.bus.stores[0];
        assert_eq!((address, asked), (REGISTER, width));
        assert_eq!(stored & (u32::MAX >> (32 - 8 * width.bytes())), value);
    }
}

#[test]
fn an_exclusive_store_succeeds_once_after_an_exclusive_load() {
    // LDREX R0, [R2]; STREX R3, R1, [R2]; STREX R4, R1, [R2]
    let code = [0xE852, 0x0F00, 0xE842, 0x1300, 0xE842, 0x1400];
    let mut rig = Rig::new(&code).with(1, 5).with(2, DATA);
    rig.word(DATA, 4);
    rig.steps(2);
    assert_eq!((rig.cpu.register(0), rig.cpu.register(3), rig.read(DATA)), (4, 0, 5));
    rig.word(DATA, 6);
    rig.steps(1);
    assert_eq!((rig.cpu.register(4), rig.read(DATA)), (1, 6));
}

#[test]
fn clrex_ends_it_and_so_nothing_is_stored() {
    // LDREXB R0, [R2]; CLREX; STREXB R3, R1, [R2]
    let code = [0xE8D2, 0x0F4F, 0xF3BF, 0x8F2F, 0xE8C2, 0x1F43];
    let mut rig = Rig::new(&code).with(1, 5).with(2, DATA + 1);
    rig.word(DATA, 0x0000_AA00);
    rig.steps(3);
    assert_eq!((rig.cpu.register(0), rig.cpu.register(3)), (0xAA, 1));
    assert_eq!(rig.read(DATA), 0x0000_AA00);
}

#[test]
fn code_in_ram_may_write_itself() {
    // STRH R1, [R2]; then what it has stored: MOVS R0, #42; B .
    let mut rig = Rig::new(&[0xBF00]).with(1, 0x202A).with(2, DATA + 2).with(0, 0);
    for (at, half) in [(DATA, 0x8011), (DATA + 2, 0xDE00), (DATA + 4, 0xE7FE)] {
        rig.memory.store(at, Width::Half, half);
    }
    rig.cpu.set_register(15, DATA);
    assert_eq!(rig.run(20), Stop::Until);
    assert_eq!(rig.cpu.register(0), 42);
}

#[test]
fn a_call_goes_out_of_the_program_and_comes_back() {
    // BLX R3; MOVS R1, #1; B .  and in RAM ADDS R0, #1; BX LR
    let mut rig = Rig::new(&[0x4798, 0x2101, 0xE7FE]).with(3, DATA | 1).with(0, 7);
    rig.memory.store(DATA, Width::Half, 0x3001);
    rig.memory.store(DATA + 2, Width::Half, 0x4770);
    rig.run(40);
    assert_eq!((rig.cpu.register(0), rig.cpu.register(1)), (8, 1));
    assert_eq!(rig.cpu.register(14), (CODE + 2) | 1);
    assert_eq!(rig.cpu.pc(), CODE + 4);
}

#[test]
fn a_jump_into_the_middle_of_an_instruction_executes_what_stands_there() {
    // B .+6; MOVW R1, #0x205, whose second half is MOVS R1, #5 (0x2105); B .
    let mut rig = Rig::new(&[0xE001, 0xBF00, 0xF240, 0x2105, 0xE7FE]).with(0, 0).with(1, 0);
    rig.cpu.set_register(15, CODE + 6);
    rig.run(10);
    assert_eq!((rig.cpu.register(0), rig.cpu.register(1)), (0, 5));
    let mut rig = Rig::new(&[0xE001, 0xBF00, 0xF240, 0x2105, 0xE7FE]).with(0, 0).with(1, 0);
    rig.cpu.set_register(15, CODE + 4);
    rig.run(10);
    assert_eq!((rig.cpu.register(0), rig.cpu.register(1)), (0, 0x205));
}
