//! Executes instructions (DDI 0403, A7.7).
//!
//! When an instruction is executed, its cycles have been counted. Where it is abandoned, that
//! is taken back and no register has changed. R15 holds the address of the next instruction only for
//! those that need it there; all others leave it to a [`Position`].

mod access;
mod arithmetic;
mod branch;
mod float;
mod integer;
mod position;
mod transfer;

pub(super) use position::{Alone, Following, Position};

use super::Sleep;
use super::abort::Abort;
use super::op::{Kind, Load, Op};
use super::timing::{REFILL, REFILL_REGISTER};
use super::{Cpu, Fault, Program};
use crate::bus::{Bus, Width};
use crate::memory::Memory;

impl Cpu {
    /// Executes one instruction outside an IT block. An IT executes its block with it.
    #[inline(always)]
    #[expect(clippy::too_many_lines, reason = "one line for each instruction")]
    pub(super) fn execute<B: Bus, P: Position>(
        &mut self,
        op: &Op,
        position: &mut P,
        program: &Program,
        memory: &mut Memory,
        bus: &mut B,
    ) {
        self.cycles += u64::from(op.cycles);
        /// A condition of a branch.
        macro_rules! branch_if {
            ($condition:expr) => {
                if $condition {
                    position.branch(op.imm);
                    self.cycles += REFILL;
                }
            };
        }
        /// An instruction that needs its own position, or whose target is unknown until execution.
        macro_rules! jump {
            ($does:expr) => {{
                self.r[15] = position.next(program);
                $does;
                position.resume(self, program);
            }};
        }
        macro_rules! load {
            ($load:ident, $address:expr) => {{
                let address = $address;
                if let Some(value) = self.load(op, memory, bus, address, Load::$load) {
                    self.set(op.d, value);
                }
            }};
        }
        macro_rules! store {
            ($width:ident, $address:expr) => {{
                let address = $address;
                let value = self.get(op.d);
                self.store(op, memory, bus, address, Width::$width, value);
            }};
        }
        match op.kind {
            Kind::AddImm => self.set(op.d, self.get(op.n).wrapping_add(op.imm)),
            Kind::AddImmS => self.add_s(op.d, self.get(op.n), op.imm),
            Kind::SubImm => self.set(op.d, self.get(op.n).wrapping_sub(op.imm)),
            Kind::SubImmS => self.sub_s(op.d, self.get(op.n), op.imm),
            Kind::RsbImm => self.set(op.d, op.imm.wrapping_sub(self.get(op.n))),
            Kind::RsbImmS => self.sub_s(op.d, op.imm, self.get(op.n)),
            Kind::AdcImm => self.adc(op.d, self.get(op.n), op.imm),
            Kind::AdcImmS => self.adc_s(op.d, self.get(op.n), op.imm),
            Kind::CmpImm => self.compare(self.get(op.n), op.imm),
            Kind::CmnImm => self.compare_negative(self.get(op.n), op.imm),
            Kind::AndImm => self.set(op.d, self.get(op.n) & op.imm),
            Kind::AndImmS => self.logical_imm(op, self.get(op.n) & op.imm),
            Kind::OrrImm => self.set(op.d, self.get(op.n) | op.imm),
            Kind::OrrImmS => self.logical_imm(op, self.get(op.n) | op.imm),
            Kind::EorImm => self.set(op.d, self.get(op.n) ^ op.imm),
            Kind::EorImmS => self.logical_imm(op, self.get(op.n) ^ op.imm),
            Kind::MovImm => self.set(op.d, op.imm),
            Kind::MovImmS => self.logical_imm(op, op.imm),
            Kind::TstImm => self.test_imm(op, self.get(op.n) & op.imm),
            Kind::TeqImm => self.test_imm(op, self.get(op.n) ^ op.imm),
            Kind::Movt => self.set(op.d, self.get(op.d) & 0xFFFF | op.imm),

            Kind::AddReg => self.set(op.d, self.get(op.n).wrapping_add(self.get(op.m))),
            Kind::AddRegS => self.add_s(op.d, self.get(op.n), self.get(op.m)),
            Kind::SubReg => self.set(op.d, self.get(op.n).wrapping_sub(self.get(op.m))),
            Kind::SubRegS => self.sub_s(op.d, self.get(op.n), self.get(op.m)),
            Kind::AdcReg => self.adc(op.d, self.get(op.n), self.get(op.m)),
            Kind::AdcRegS => self.adc_s(op.d, self.get(op.n), self.get(op.m)),
            Kind::SbcReg => self.adc(op.d, self.get(op.n), !self.get(op.m)),
            Kind::SbcRegS => self.adc_s(op.d, self.get(op.n), !self.get(op.m)),
            Kind::RsbReg => self.set(op.d, self.get(op.m).wrapping_sub(self.get(op.n))),
            Kind::RsbRegS => self.sub_s(op.d, self.get(op.m), self.get(op.n)),
            Kind::CmpReg => self.compare(self.get(op.n), self.get(op.m)),
            Kind::CmnReg => self.compare_negative(self.get(op.n), self.get(op.m)),
            Kind::AndReg => self.set(op.d, self.get(op.n) & self.get(op.m)),
            Kind::AndRegS => self.logical(op.d, self.get(op.n) & self.get(op.m)),
            Kind::BicReg => self.set(op.d, self.get(op.n) & !self.get(op.m)),
            Kind::BicRegS => self.logical(op.d, self.get(op.n) & !self.get(op.m)),
            Kind::OrrReg => self.set(op.d, self.get(op.n) | self.get(op.m)),
            Kind::OrrRegS => self.logical(op.d, self.get(op.n) | self.get(op.m)),
            Kind::OrnReg => self.set(op.d, self.get(op.n) | !self.get(op.m)),
            Kind::OrnRegS => self.logical(op.d, self.get(op.n) | !self.get(op.m)),
            Kind::EorReg => self.set(op.d, self.get(op.n) ^ self.get(op.m)),
            Kind::EorRegS => self.logical(op.d, self.get(op.n) ^ self.get(op.m)),
            Kind::MovReg => self.set(op.d, self.get(op.m)),
            Kind::MovRegS => self.logical(op.d, self.get(op.m)),
            Kind::MvnReg => self.set(op.d, !self.get(op.m)),
            Kind::MvnRegS => self.logical(op.d, !self.get(op.m)),
            Kind::TstReg => self.set_nz(self.get(op.n) & self.get(op.m)),
            Kind::TeqReg => self.set_nz(self.get(op.n) ^ self.get(op.m)),

            Kind::AddShifted(by) => {
                self.set(op.d, self.get(op.n).wrapping_add(self.shifted(op, by).0));
            }
            Kind::AddShiftedS(by) => self.add_s(op.d, self.get(op.n), self.shifted(op, by).0),
            Kind::SubShifted(by) => {
                self.set(op.d, self.get(op.n).wrapping_sub(self.shifted(op, by).0));
            }
            Kind::SubShiftedS(by) => self.sub_s(op.d, self.get(op.n), self.shifted(op, by).0),
            Kind::AdcShifted(by) => self.adc(op.d, self.get(op.n), self.shifted(op, by).0),
            Kind::AdcShiftedS(by) => self.adc_s(op.d, self.get(op.n), self.shifted(op, by).0),
            Kind::SbcShifted(by) => self.adc(op.d, self.get(op.n), !self.shifted(op, by).0),
            Kind::SbcShiftedS(by) => self.adc_s(op.d, self.get(op.n), !self.shifted(op, by).0),
            Kind::RsbShifted(by) => {
                self.set(op.d, self.shifted(op, by).0.wrapping_sub(self.get(op.n)));
            }
            Kind::RsbShiftedS(by) => self.sub_s(op.d, self.shifted(op, by).0, self.get(op.n)),
            Kind::CmpShifted(by) => self.compare(self.get(op.n), self.shifted(op, by).0),
            Kind::CmnShifted(by) => self.compare_negative(self.get(op.n), self.shifted(op, by).0),
            Kind::AndShifted(by) => self.set(op.d, self.get(op.n) & self.shifted(op, by).0),
            Kind::AndShiftedS(by) => self.logical_shifted(op, by, |n, m| n & m),
            Kind::BicShifted(by) => self.set(op.d, self.get(op.n) & !self.shifted(op, by).0),
            Kind::BicShiftedS(by) => self.logical_shifted(op, by, |n, m| n & !m),
            Kind::OrrShifted(by) => self.set(op.d, self.get(op.n) | self.shifted(op, by).0),
            Kind::OrrShiftedS(by) => self.logical_shifted(op, by, |n, m| n | m),
            Kind::OrnShifted(by) => self.set(op.d, self.get(op.n) | !self.shifted(op, by).0),
            Kind::OrnShiftedS(by) => self.logical_shifted(op, by, |n, m| n | !m),
            Kind::EorShifted(by) => self.set(op.d, self.get(op.n) ^ self.shifted(op, by).0),
            Kind::EorShiftedS(by) => self.logical_shifted(op, by, |n, m| n ^ m),
            Kind::MvnShifted(by) => self.set(op.d, !self.shifted(op, by).0),
            Kind::MvnShiftedS(by) => self.logical_shifted(op, by, |_, m| !m),
            Kind::TstShifted(by) => {
                self.test_shifted(self.get(op.n) & self.shifted(op, by).0, op, by);
            }
            Kind::TeqShifted(by) => {
                self.test_shifted(self.get(op.n) ^ self.shifted(op, by).0, op, by);
            }

            Kind::LslImm => self.set(op.d, self.get(op.m) << (op.a & 31)),
            Kind::LslImmS => self.lsl_s(op),
            Kind::LsrImm => self.set(op.d, self.get(op.m).checked_shr(op.a.into()).unwrap_or(0)),
            Kind::LsrImmS => self.lsr_s(op),
            Kind::AsrImm => self.set(op.d, (self.get(op.m) as i32 >> op.a.min(31)) as u32),
            Kind::AsrImmS => self.asr_s(op),
            Kind::RorImm => self.set(op.d, self.get(op.m).rotate_right(op.a.into())),
            Kind::RorImmS => self.ror_s(op),
            Kind::Rrx => self.set(op.d, u32::from(self.flags.c) << 31 | self.get(op.m) >> 1),
            Kind::RrxS => self.rrx_s(op),
            Kind::LslReg => self.set(op.d, self.lsl_by_register(op).0),
            Kind::LslRegS => self.carrying(op.d, self.lsl_by_register(op)),
            Kind::LsrReg => self.set(op.d, self.lsr_by_register(op).0),
            Kind::LsrRegS => self.carrying(op.d, self.lsr_by_register(op)),
            Kind::AsrReg => self.set(op.d, self.asr_by_register(op).0),
            Kind::AsrRegS => self.carrying(op.d, self.asr_by_register(op)),
            Kind::RorReg => self.set(op.d, self.ror_by_register(op).0),
            Kind::RorRegS => self.carrying(op.d, self.ror_by_register(op)),
            Kind::ToSp(how) => self.sum_to_sp(op, how),
            Kind::ToSpS(how) => self.sum_to_sp_s(op, how),

            Kind::Mul => self.set(op.d, self.get(op.n).wrapping_mul(self.get(op.m))),
            Kind::MulS => self.logical(op.d, self.get(op.n).wrapping_mul(self.get(op.m))),
            Kind::Mla => {
                let product = self.get(op.n).wrapping_mul(self.get(op.m));
                self.set(op.d, self.get(op.a).wrapping_add(product));
            }
            Kind::Mls => {
                let product = self.get(op.n).wrapping_mul(self.get(op.m));
                self.set(op.d, self.get(op.a).wrapping_sub(product));
            }
            Kind::Long(long) => self.multiply_long(op, long),
            Kind::Multiply(multiply) => self.multiply(op, multiply),
            Kind::Sdiv => self.sdiv(op),
            Kind::Udiv => self.udiv(op),

            Kind::Bfi => {
                let mask = op.imm << (op.a & 31);
                let field = self.get(op.n) << (op.a & 31) & mask;
                self.set(op.d, self.get(op.d) & !mask | field);
            }
            Kind::Bfc => self.set(op.d, self.get(op.d) & !(op.imm << (op.a & 31))),
            Kind::Ubfx => {
                let top = 32 - op.imm;
                self.set(op.d, self.get(op.n) >> (op.a & 31) << (top & 31) >> (top & 31));
            }
            Kind::Sbfx => {
                let top = 32 - op.imm;
                let field = self.get(op.n) >> (op.a & 31) << (top & 31);
                self.set(op.d, (field as i32 >> (top & 31)) as u32);
            }
            Kind::Clz => self.set(op.d, self.get(op.m).leading_zeros()),
            Kind::Rbit => self.set(op.d, self.get(op.m).reverse_bits()),
            Kind::Rev => self.set(op.d, self.get(op.m).swap_bytes()),
            Kind::Rev16 => self.set(op.d, self.get(op.m).swap_bytes().rotate_left(16)),
            Kind::Revsh => self.set(op.d, (self.get(op.m) as u16).swap_bytes() as i16 as u32),
            Kind::Sxtb => self.set(op.d, self.get(op.m) as i8 as u32),
            Kind::Sxth => self.set(op.d, self.get(op.m) as i16 as u32),
            Kind::Uxtb => self.set(op.d, self.get(op.m) & 0xFF),
            Kind::Uxth => self.set(op.d, self.get(op.m) & 0xFFFF),
            Kind::Extend(extend) => self.extend(op, extend),
            Kind::Ssat(by) => self.ssat(op, by),
            Kind::Usat(by) => self.usat(op, by),
            Kind::Ssat16 => self.ssat16(op),
            Kind::Usat16 => self.usat16(op),
            Kind::Saturating(how) => self.saturating(op, how),
            Kind::Parallel(prefix, lanes) => self.parallel(op, prefix, lanes),
            Kind::Sel => self.sel(op),
            Kind::Pkhbt => self.pkhbt(op),
            Kind::Pkhtb => self.pkhtb(op),

            Kind::LdrImm => load!(Word, self.get(op.n).wrapping_add(op.imm)),
            Kind::LdrReg => load!(Word, self.indexed(op)),
            Kind::LdrLiteral => load!(Word, op.imm),
            Kind::LdrbImm => load!(Byte, self.get(op.n).wrapping_add(op.imm)),
            Kind::LdrbReg => load!(Byte, self.indexed(op)),
            Kind::LdrhImm => load!(Half, self.get(op.n).wrapping_add(op.imm)),
            Kind::LdrhReg => load!(Half, self.indexed(op)),
            Kind::LdrsbImm => load!(SignedByte, self.get(op.n).wrapping_add(op.imm)),
            Kind::LdrsbReg => load!(SignedByte, self.indexed(op)),
            Kind::LdrshImm => load!(SignedHalf, self.get(op.n).wrapping_add(op.imm)),
            Kind::LdrshReg => load!(SignedHalf, self.indexed(op)),
            Kind::StrImm => store!(Word, self.get(op.n).wrapping_add(op.imm)),
            Kind::StrReg => store!(Word, self.indexed(op)),
            Kind::StrbImm => store!(Byte, self.get(op.n).wrapping_add(op.imm)),
            Kind::StrbReg => store!(Byte, self.indexed(op)),
            Kind::StrhImm => store!(Half, self.get(op.n).wrapping_add(op.imm)),
            Kind::StrhReg => store!(Half, self.indexed(op)),
            Kind::LoadLiteral(load) => self.load_literal(op, memory, bus, load),
            Kind::LoadPre(load) => self.load_and_update(op, memory, bus, load, true),
            Kind::LoadPost(load) => self.load_and_update(op, memory, bus, load, false),
            Kind::StorePre(width) => self.store_and_update(op, memory, bus, width, true),
            Kind::StorePost(width) => self.store_and_update(op, memory, bus, width, false),
            Kind::LoadUnprivileged(load) => self.load_unprivileged(op, memory, bus, load),
            Kind::StoreUnprivileged(width) => self.store_unprivileged(op, memory, bus, width),
            Kind::LoadPc(mode) => jump!(self.load_pc(op, memory, bus, mode)),
            Kind::LoadSp(mode) => self.load_sp(op, memory, bus, mode),
            Kind::Ldrd(mode) => self.ldrd(op, memory, bus, mode),
            Kind::Strd(mode) => self.strd(op, memory, bus, mode),
            Kind::LdmIa if op.imm & 1 << 15 != 0 => jump!(self.ldm(op, memory, bus, false)),
            Kind::LdmDb if op.imm & 1 << 15 != 0 => jump!(self.ldm(op, memory, bus, true)),
            Kind::LdmIa => self.ldm(op, memory, bus, false),
            Kind::StmIa => self.stm(op, memory, bus, false),
            Kind::LdmDb => self.ldm(op, memory, bus, true),
            Kind::StmDb => self.stm(op, memory, bus, true),
            Kind::Push => self.push(op, memory, bus),
            Kind::Pop => self.pop(op, memory, bus),
            Kind::PopPc => jump!(self.pop_pc(op, memory, bus)),
            Kind::Ldrex => self.ldrex(op, memory, bus, Width::Word),
            Kind::LdrexNarrow(width) => self.ldrex(op, memory, bus, width),
            Kind::Strex => self.strex(op, memory, bus, Width::Word),
            Kind::StrexNarrow(width) => self.strex(op, memory, bus, width),
            Kind::Clrex => self.exclusive = None,

            Kind::B => branch_if!(true),
            Kind::Beq => branch_if!(self.flags.z),
            Kind::Bne => branch_if!(!self.flags.z),
            Kind::Bcs => branch_if!(self.flags.c),
            Kind::Bcc => branch_if!(!self.flags.c),
            Kind::Bmi => branch_if!(self.flags.n),
            Kind::Bpl => branch_if!(!self.flags.n),
            Kind::Bvs => branch_if!(self.flags.v),
            Kind::Bvc => branch_if!(!self.flags.v),
            Kind::Bhi => branch_if!(self.flags.c && !self.flags.z),
            Kind::Bls => branch_if!(!self.flags.c || self.flags.z),
            Kind::Bge => branch_if!(self.flags.n == self.flags.v),
            Kind::Blt => branch_if!(self.flags.n != self.flags.v),
            Kind::Bgt => branch_if!(!self.flags.z && self.flags.n == self.flags.v),
            Kind::Ble => branch_if!(self.flags.z || self.flags.n != self.flags.v),
            Kind::Bl => {
                self.r[14] = position.next(program) | 1;
                branch_if!(true);
            }
            Kind::Blx => jump!(self.branch_link_exchange(self.get(op.m))),
            Kind::Bx => jump!(self.branch_exchange(memory, self.get(op.m), REFILL_REGISTER)),
            Kind::Cbz => branch_if!(self.get(op.n) == 0),
            Kind::Cbnz => branch_if!(self.get(op.n) != 0),
            Kind::Tbb => jump!(self.table_branch(op, memory, bus, Load::Byte)),
            Kind::Tbh => jump!(self.table_branch(op, memory, bus, Load::Half)),
            Kind::MovPc => jump!(self.branch_plain(self.get(op.m))),
            Kind::AddPc => jump!(self.branch_plain(op.imm.wrapping_add(self.get(op.m)))),
            Kind::It => jump!({
                self.it = op.imm as u8;
                self.execute_it_block(program, memory, bus);
            }),
            Kind::CmpImmThen => {
                self.compare(self.get(op.n), op.imm);
                position.then(self, program);
            }
            Kind::CmpRegThen => {
                self.compare(self.get(op.n), self.get(op.m));
                position.then(self, program);
            }
            Kind::TstImmThen => {
                self.test_imm(op, self.get(op.n) & op.imm);
                position.then(self, program);
            }
            Kind::LslImmSThen => {
                self.lsl_s(op);
                position.then(self, program);
            }
            Kind::Block => {
                let count = u64::from(op.a);
                if self.passes(op.d >> 4) {
                    position.follow(op.imm);
                } else if op.m == 0 && self.cycles + count < self.deadline {
                    self.cycles += count;
                    self.instructions = self.instructions.wrapping_add(count);
                    position.pass(op.a);
                } else {
                    position.follow(op.imm + u32::from(op.a) + 1);
                }
            }

            Kind::Vadd => self.vadd(op, memory),
            Kind::Vsub => self.vsub(op, memory),
            Kind::Vmul => self.vmul(op, memory),
            Kind::Vnmul => self.vnmul(op, memory),
            Kind::Vdiv => self.vdiv(op, memory),
            Kind::Vmla => self.vmla(op, memory),
            Kind::Vmls => self.vmls(op, memory),
            Kind::Accumulate(how) => self.accumulate(op, memory, how),
            Kind::Vsqrt => self.vsqrt(op, memory),
            Kind::Vabs => self.vabs(op, memory),
            Kind::Vneg => self.vneg(op, memory),
            Kind::Vmov => self.vmov(op, memory),
            Kind::VmovImm => self.vmov_imm(op, memory),
            Kind::Vcmp(signalling) => self.vcmp(op, memory, signalling),
            Kind::VcmpZero(signalling) => self.vcmp_zero(op, memory, signalling),
            Kind::VcvtToInt(signed, to_zero) => self.vcvt_to_int(op, memory, signed, to_zero),
            Kind::VcvtFromInt(signed) => self.vcvt_from_int(op, memory, signed),
            Kind::VcvtToFixed(signed) => self.vcvt_to_fixed(op, memory, signed),
            Kind::VcvtFromFixed(signed) => self.vcvt_from_fixed(op, memory, signed),
            Kind::VcvtFromHalf(top) => self.vcvt_from_half(op, memory, top),
            Kind::VcvtToHalf(top) => self.vcvt_to_half(op, memory, top),
            Kind::VmovToCore => self.vmov_to_core(op, memory),
            Kind::VmovFromCore => self.vmov_from_core(op, memory),
            Kind::VmovToCores => self.vmov_to_cores(op, memory),
            Kind::VmovFromCores => self.vmov_from_cores(op, memory),
            Kind::Vmrs => self.vmrs(op, memory),
            Kind::Vmsr => self.vmsr(op, memory),
            Kind::Vldr => {
                let address = self.get(op.n).wrapping_add(op.imm);
                self.vldr(op, memory, bus, address);
            }
            Kind::Vstr => {
                let address = self.get(op.n).wrapping_add(op.imm);
                self.vstr(op, memory, bus, address);
            }
            Kind::VldrLiteral => self.vldr(op, memory, bus, op.imm),
            Kind::VldrDouble => {
                let address = self.get(op.n).wrapping_add(op.imm);
                self.load_floats(op, memory, bus, address, 2);
            }
            Kind::VstrDouble => {
                let address = self.get(op.n).wrapping_add(op.imm);
                self.store_floats(op, memory, bus, address, 2);
            }
            Kind::VldrDoubleLiteral => {
                self.load_floats(op, memory, bus, op.imm, 2);
            }
            Kind::Vldm(how) => self.vldm(op, memory, bus, how),
            Kind::Vstm(how) => self.vstm(op, memory, bus, how),

            Kind::Nop | Kind::Barrier => {}
            Kind::Wfe if self.event => self.event = false,
            Kind::Wfe => self.fall_asleep(Sleep::Event),
            Kind::Wfi => self.fall_asleep(Sleep::Interrupt),
            Kind::Sev => self.event = true,
            Kind::Svc => jump!({
                self.svc(memory, op.imm as u8);
                self.deadline = 0;
            }),
            Kind::Mrs => self.set(op.d, self.mrs(op.imm as u8)),
            Kind::Msr => self.msr(op.imm as u8, op.a, self.get(op.n)),
            Kind::Cps(enable) => self.cps(enable, op.imm & 2 != 0, op.imm & 1 != 0),
            Kind::Bkpt => self.refuse(op, Abort::Breakpoint),
            Kind::Undefined => self.refuse(op, Abort::Fault(Fault::Undefined)),
            Kind::NoCoprocessor => self.refuse(op, Abort::Fault(Fault::NoCoprocessor)),
            Kind::Unpredictable => self.refuse(op, Abort::Unpredictable),
            Kind::Trap => self.refuse(op, Abort::Trap),
            Kind::Outside => {
                self.forget(op);
                position.retreat(self, program);
                self.execute_outside(program, memory, bus);
                self.execute_it_block(program, memory, bus);
                position.resume(self, program);
            }
            Kind::Goto => {
                self.forget(op);
                position.follow(op.imm);
            }
        }
    }

    /// R0 to R14. No operand is R15.
    #[inline(always)]
    const fn get(&self, register: u8) -> u32 {
        self.r[(register & 15) as usize]
    }

    #[inline(always)]
    const fn set(&mut self, register: u8, value: u32) {
        self.r[(register & 15) as usize] = value;
    }

    /// Undoes the beginning of the instruction.
    #[inline(always)]
    const fn forget(&mut self, op: &Op) {
        self.cycles -= op.cycles as u64;
        self.instructions = self.instructions.wrapping_sub(1);
    }

    /// Abandons the instruction.
    #[cold]
    #[inline(never)]
    fn refuse(&mut self, op: &Op, abort: Abort) {
        self.forget(op);
        self.abandoned = true;
        self.abort(abort);
    }

    #[cold]
    fn fall_asleep(&mut self, sleep: Sleep) {
        self.asleep = Some(sleep);
        self.deadline = 0;
    }
}
