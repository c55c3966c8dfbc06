//! A decoded instruction: what is done, with which registers, and what is known beforehand.
//!
//! A value that depends on the instruction's own address is computed when it is decoded: literals,
//! targets of branches, the address of a table. No operand is R15 any more when it is executed.

use crate::bus::Width;

use super::dsp::{Lanes, Prefix};

/// One instruction. What the fields mean to each [`Kind`] is said there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Op {
    pub(super) kind: Kind,
    /// Sets no flags within an IT block, though it does outside.
    pub(super) quiet_in_it: bool,
    /// The line of flash that it begins in; see [`timing`](super::timing).
    pub(super) line: u16,
    /// The length in bytes: 2 or 4.
    pub(super) len: u8,
    /// Cycles, without what only turns out when it is executed.
    pub(super) cycles: u8,
    pub(super) d: u8,
    pub(super) n: u8,
    pub(super) m: u8,
    pub(super) a: u8,
    pub(super) imm: u32,
}

/// The line of an instruction outside the flash. It is also the last line of 1 MiB, in which no code
/// lies.
pub(super) const NO_LINE: u16 = u16::MAX;

// Four to a line of a cache.
const _: () = assert!(size_of::<Op>() == 16);

/// How a register is shifted. The amount is `a`: for LSR and ASR 1 to 32, for ROR 1 to 31.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shift {
    Lsl,
    Lsr,
    Asr,
    Ror,
    Rrx,
}

/// The conversion of the bits by a load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Load {
    Word,
    Half,
    Byte,
    SignedHalf,
    SignedByte,
}

impl Load {
    pub(super) const fn width(self) -> Width {
        match self {
            Self::Word => Width::Word,
            Self::Half | Self::SignedHalf => Width::Half,
            Self::Byte | Self::SignedByte => Width::Byte,
        }
    }

    #[inline(always)]
    pub(super) const fn extend(self, value: u32) -> u32 {
        match self {
            Self::SignedHalf => value as i16 as u32,
            Self::SignedByte => value as i8 as u32,
            _ => value,
        }
    }
}

/// The address of a load into PC or SP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Rn + imm.
    Offset,
    /// Rn + (Rm << a).
    Register,
    /// Rn + imm, which Rn becomes.
    Pre,
    /// Rn, which becomes Rn + imm.
    Post,
    /// imm.
    Literal,
}

/// The new value of the stack pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ToSp {
    /// Rm.
    Mov,
    /// Rn + (Rm << a).
    Add,
    /// Rn - (Rm << a).
    Sub,
    /// Rn + imm.
    AddImm,
    /// Rn - imm.
    SubImm,
}

/// Extensions of a register that is rotated right by `a` first; Rn is added where it is not 15.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extend {
    SignedByte,
    SignedHalf,
    SignedBytes16,
    UnsignedByte,
    UnsignedHalf,
    UnsignedBytes16,
}

/// Multiplications of the DSP extension, on Rn, Rm and, where they accumulate, Ra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Multiply {
    /// SMULxy: top halves of n and m.
    Halves(bool, bool),
    /// SMLAxy.
    AccumulateHalves(bool, bool),
    /// SMULWy.
    Wide(bool),
    /// SMLAWy.
    AccumulateWide(bool),
    /// SMUAD, SMLAD; with the halves of m exchanged.
    DualAdd(bool),
    /// SMUSD, SMLSD.
    DualSub(bool),
    /// SMMUL, SMMLA; rounded.
    Most(bool),
    /// SMMLS.
    MostSub(bool),
    /// USAD8, USADA8.
    Differences,
}

/// Multiplications into RdHi (`a`) and RdLo (`d`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Long {
    Unsigned,
    Signed,
    AccumulateUnsigned,
    AccumulateSigned,
    /// UMAAL.
    AccumulateTwice,
    /// SMLALxy.
    Halves(bool, bool),
    /// SMLALD, with X.
    DualAdd(bool),
    /// SMLSLD, with X.
    DualSub(bool),
}

/// Saturating additions: Rd, Rm, Rn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Saturating {
    Add,
    Sub,
    DoubleAdd,
    DoubleSub,
}

/// Floating-point operations of Sd (`d`), Sn and Sm whose result is a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Accumulate {
    Nmla,
    Nmls,
    Fma,
    Fms,
    Fnma,
    Fnms,
}

/// An operation. Unless said otherwise an instruction works on Rd, Rn and `imm` (`Imm`), Rm (`Reg`)
/// or a shifted Rm (`Shifted`); one whose name ends in `S` sets the flags.
///
/// Logical instructions with an immediate keep in `a` what the carry becomes: 2 for what it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    // Arithmetic and logic.
    AddImm,
    AddImmS,
    SubImm,
    SubImmS,
    RsbImm,
    RsbImmS,
    /// SBC too, of the inverted immediate.
    AdcImm,
    AdcImmS,
    CmpImm,
    CmnImm,
    /// BIC too.
    AndImm,
    AndImmS,
    /// ORN too.
    OrrImm,
    OrrImmS,
    EorImm,
    EorImmS,
    /// MVN too.
    MovImm,
    MovImmS,
    TstImm,
    TeqImm,
    /// Sets the upper half.
    Movt,

    AddReg,
    AddRegS,
    SubReg,
    SubRegS,
    AdcReg,
    AdcRegS,
    SbcReg,
    SbcRegS,
    RsbReg,
    RsbRegS,
    CmpReg,
    CmnReg,
    AndReg,
    AndRegS,
    BicReg,
    BicRegS,
    OrrReg,
    OrrRegS,
    OrnReg,
    OrnRegS,
    EorReg,
    EorRegS,
    MovReg,
    MovRegS,
    MvnReg,
    MvnRegS,
    TstReg,
    TeqReg,

    AddShifted(Shift),
    AddShiftedS(Shift),
    SubShifted(Shift),
    SubShiftedS(Shift),
    AdcShifted(Shift),
    AdcShiftedS(Shift),
    SbcShifted(Shift),
    SbcShiftedS(Shift),
    RsbShifted(Shift),
    RsbShiftedS(Shift),
    CmpShifted(Shift),
    CmnShifted(Shift),
    AndShifted(Shift),
    AndShiftedS(Shift),
    BicShifted(Shift),
    BicShiftedS(Shift),
    OrrShifted(Shift),
    OrrShiftedS(Shift),
    OrnShifted(Shift),
    OrnShiftedS(Shift),
    EorShifted(Shift),
    EorShiftedS(Shift),
    MvnShifted(Shift),
    MvnShiftedS(Shift),
    TstShifted(Shift),
    TeqShifted(Shift),

    /// Shifts by an immediate (`a`): of Rm.
    LslImm,
    LslImmS,
    LsrImm,
    LsrImmS,
    AsrImm,
    AsrImmS,
    RorImm,
    RorImmS,
    Rrx,
    RrxS,
    /// Shifts of Rn by Rm.
    LslReg,
    LslRegS,
    LsrReg,
    LsrRegS,
    AsrReg,
    AsrRegS,
    RorReg,
    RorRegS,
    /// The low bits of the new SP are cleared.
    ToSp(ToSp),
    /// Also sets the flags. Not [`ToSp::Mov`].
    ToSpS(ToSp),

    // Multiplication and division.
    Mul,
    MulS,
    Mla,
    Mls,
    Long(Long),
    Multiply(Multiply),
    Sdiv,
    Udiv,

    // Bits, extensions, saturation.
    /// Lowest bit `a`, mask (not shifted) `imm`.
    Bfi,
    Bfc,
    Ubfx,
    Sbfx,
    Clz,
    Rbit,
    Rev,
    Rev16,
    Revsh,
    Sxtb,
    Sxth,
    Uxtb,
    Uxth,
    Extend(Extend),
    /// Saturates the shifted Rn to `imm` bits.
    Ssat(Shift),
    Usat(Shift),
    Ssat16,
    Usat16,
    Saturating(Saturating),
    Parallel(Prefix, Lanes),
    Sel,
    /// Rm is shifted by `a`: to the left; to the right, 1 to 32.
    Pkhbt,
    Pkhtb,

    // Loads and stores: Rd and [Rn + imm] or [Rn + (Rm << a)].
    LdrImm,
    LdrReg,
    /// Loads from the address `imm`.
    LdrLiteral,
    LdrbImm,
    LdrbReg,
    LdrhImm,
    LdrhReg,
    LdrsbImm,
    LdrsbReg,
    LdrshImm,
    LdrshReg,
    StrImm,
    StrReg,
    StrbImm,
    StrbReg,
    StrhImm,
    StrhReg,
    LoadLiteral(Load),
    /// Rn becomes Rn + imm, which is the address, too.
    LoadPre(Load),
    /// Rn becomes Rn + imm, which is not yet the address.
    LoadPost(Load),
    StorePre(Width),
    StorePost(Width),
    /// LDRT and its like.
    LoadUnprivileged(Load),
    StoreUnprivileged(Width),
    LoadPc(Mode),
    LoadSp(Mode),
    /// Rd and Ra.
    Ldrd(Mode),
    Strd(Mode),
    /// Registers `imm` from Rn on; Rn becomes the end if `a`.
    LdmIa,
    StmIa,
    /// Registers `imm` up to Rn.
    LdmDb,
    StmDb,
    /// Registers `imm`, PC not among them.
    Push,
    Pop,
    /// PC among them.
    PopPc,
    Ldrex,
    LdrexNarrow(Width),
    /// Status in Rd, value in Ra.
    Strex,
    StrexNarrow(Width),
    Clrex,

    // Branches, to Rm or to `imm`: an address, or in a program a place. There, `d` is the
    // condition.
    B,
    Beq,
    Bne,
    Bcs,
    Bcc,
    Bmi,
    Bpl,
    Bvs,
    Bvc,
    Bhi,
    Bls,
    Bge,
    Blt,
    Bgt,
    Ble,
    Bl,
    Blx,
    Bx,
    Cbz,
    Cbnz,
    /// The table is at Rn, or where Rn is 15 at `imm`; its bytes count from the next instruction.
    Tbb,
    Tbh,
    /// MOV to PC.
    MovPc,
    /// ADD to PC, of which `imm` is the value.
    AddPc,
    /// ITSTATE is `imm`.
    It,
    /// An IT whose block stands in the program once more, as what is executed if its condition
    /// passes (at the place `imm`) and then as what is executed otherwise. ITSTATE is `d`, the block
    /// has `a` instructions. `m` is 0 if none of them is executed where the condition does not pass,
    /// and all lie in the line of flash that the IT does: then the core can pass over all at once.
    Block,

    // With the branch that stands behind it. Alone, it is what its name says.
    CmpImmThen,
    CmpRegThen,
    TstImmThen,
    LslImmSThen,

    // Floating point: Sd, Sn, Sm.
    Vadd,
    Vsub,
    Vmul,
    Vnmul,
    Vdiv,
    Vmla,
    Vmls,
    Accumulate(Accumulate),
    Vsqrt,
    Vabs,
    Vneg,
    Vmov,
    /// Bits `imm`.
    VmovImm,
    /// With Sm; signalling.
    Vcmp(bool),
    /// With zero.
    VcmpZero(bool),
    /// Signed, towards zero.
    VcvtToInt(bool, bool),
    /// Signed.
    VcvtFromInt(bool),
    /// Of `imm` bits, `a` of them behind the point; signed.
    VcvtToFixed(bool),
    VcvtFromFixed(bool),
    /// The top half of Sm; of Sd.
    VcvtFromHalf(bool),
    VcvtToHalf(bool),
    /// Rd from Sn; Sn from Rd.
    VmovToCore,
    VmovFromCore,
    /// Rd and Ra from Sm and the next; Sm and the next from Rd and Ra.
    VmovToCores,
    VmovFromCores,
    /// Rd; 15 for the flags.
    Vmrs,
    Vmsr,
    Vldr,
    Vstr,
    VldrLiteral,
    /// Two registers.
    VldrDouble,
    VstrDouble,
    VldrDoubleLiteral,
    /// `a` registers from Sd on. Rn, and what is done to it: nothing, the end after, the start
    /// before.
    Vldm(Multiple),
    Vstm(Multiple),

    // The system.
    Nop,
    /// DMB, DSB, ISB.
    Barrier,
    Wfe,
    Wfi,
    Sev,
    /// Number `imm`.
    Svc,
    Bkpt,
    /// Special register `imm`.
    Mrs,
    /// Special register `imm`, mask `a`.
    Msr,
    /// Enables; bits of `imm`: 1 for PRIMASK, 0 for FAULTMASK.
    Cps(bool),

    // What is no instruction of this core.
    Undefined,
    /// An instruction of a coprocessor that is not there.
    NoCoprocessor,
    /// An encoding whose effect the manual leaves open; no compiler emits it.
    Unpredictable,
    /// The place is not, or not wholly, in the program.
    Outside,
    /// No instruction: what comes next stands at the place `imm` in the program.
    Goto,
    /// The run loop stops here; the program knows what it stands for.
    Trap,
}

/// The use of the base by VLDM and VSTM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Multiple {
    /// The registers begin at Rn.
    From,
    /// The registers begin at Rn, and Rn becomes their end.
    FromAndUpdate,
    /// Up to Rn, and Rn becomes the start.
    UpToAndUpdate,
}

impl Op {
    /// An instruction without operands.
    pub(super) const fn new(kind: Kind, len: u8) -> Self {
        Self {
            kind,
            quiet_in_it: false,
            line: NO_LINE,
            len,
            cycles: 1,
            d: 0,
            n: 0,
            m: 0,
            a: 0,
            imm: 0,
        }
    }

    /// An operation that goes on at another place.
    pub(super) const fn goto(place: u32) -> Self {
        Self { imm: place, ..Self::new(Kind::Goto, 0) }
    }

    /// The same operands with another operation.
    pub(super) const fn as_kind(self, kind: Kind) -> Self {
        Self { kind, ..self }
    }

    /// The same instruction within an IT block.
    #[inline(always)]
    pub(super) const fn in_it(self) -> Self {
        if self.quiet_in_it { self.as_kind(self.kind.quiet()) } else { self }
    }
}

impl Kind {
    /// The instruction fused with the branch that follows.
    pub(super) const fn with_branch(self) -> Self {
        match self {
            Self::CmpImm => Self::CmpImmThen,
            Self::CmpReg => Self::CmpRegThen,
            Self::TstImm => Self::TstImmThen,
            Self::LslImmS => Self::LslImmSThen,
            other => other,
        }
    }

    /// The number of the condition that it branches on.
    pub(super) const fn condition(self) -> Option<u8> {
        Some(match self {
            Self::Beq => 0,
            Self::Bne => 1,
            Self::Bcs => 2,
            Self::Bcc => 3,
            Self::Bmi => 4,
            Self::Bpl => 5,
            Self::Bvs => 6,
            Self::Bvc => 7,
            Self::Bhi => 8,
            Self::Bls => 9,
            Self::Bge => 10,
            Self::Blt => 11,
            Self::Bgt => 12,
            Self::Ble => 13,
            _ => return None,
        })
    }

    /// Whether it branches to `imm`.
    pub(super) const fn branches(self) -> bool {
        matches!(
            self,
            Self::B
                | Self::Beq
                | Self::Bne
                | Self::Bcs
                | Self::Bcc
                | Self::Bmi
                | Self::Bpl
                | Self::Bvs
                | Self::Bvc
                | Self::Bhi
                | Self::Bls
                | Self::Bge
                | Self::Blt
                | Self::Bgt
                | Self::Ble
                | Self::Bl
                | Self::Cbz
                | Self::Cbnz
        )
    }

    /// Whether a block may have a copy with this in it: it leaves the flags alone, falls through,
    /// and is often enough in blocks.
    pub(super) const fn falls_through(self) -> bool {
        matches!(
            self,
            Self::AddImm
                | Self::SubImm
                | Self::RsbImm
                | Self::AdcImm
                | Self::AndImm
                | Self::OrrImm
                | Self::EorImm
                | Self::MovImm
                | Self::Movt
                | Self::AddReg
                | Self::SubReg
                | Self::AdcReg
                | Self::SbcReg
                | Self::RsbReg
                | Self::AndReg
                | Self::BicReg
                | Self::OrrReg
                | Self::EorReg
                | Self::MovReg
                | Self::MvnReg
                | Self::AddShifted(_)
                | Self::SubShifted(_)
                | Self::AndShifted(_)
                | Self::OrrShifted(_)
                | Self::EorShifted(_)
                | Self::LslImm
                | Self::LsrImm
                | Self::AsrImm
                | Self::LslReg
                | Self::LsrReg
                | Self::Mul
                | Self::Mla
                | Self::Mls
                | Self::Bfi
                | Self::Bfc
                | Self::Ubfx
                | Self::Uxtb
                | Self::Uxth
                | Self::LdrImm
                | Self::LdrReg
                | Self::LdrLiteral
                | Self::LdrbImm
                | Self::LdrbReg
                | Self::LdrhImm
                | Self::LdrhReg
                | Self::StrImm
                | Self::StrReg
                | Self::StrbImm
                | Self::StrbReg
                | Self::StrhImm
                | Self::StrhReg
                | Self::Ldrd(_)
                | Self::Strd(_)
                | Self::Vadd
                | Self::Vsub
                | Self::Vmul
                | Self::Vneg
                | Self::Vmov
                | Self::VmovImm
                | Self::VmovToCore
                | Self::VmovFromCore
                | Self::Vldr
                | Self::VldrLiteral
                | Self::Vstr
        )
    }

    /// The same for the last instruction of a block.
    pub(super) const fn ends_block(self) -> bool {
        self.falls_through()
            || matches!(
                self,
                Self::CmpImm
                    | Self::CmpReg
                    | Self::TstImm
                    | Self::Vmrs
                    | Self::B
                    | Self::Bl
                    | Self::Bx
                    | Self::Blx
                    | Self::Pop
                    | Self::PopPc
            )
    }

    /// A 16-bit operation that sets flags, without setting them.
    const fn quiet(self) -> Self {
        match self {
            Self::AddImmS => Self::AddImm,
            Self::SubImmS => Self::SubImm,
            Self::RsbImmS => Self::RsbImm,
            Self::MovImmS => Self::MovImm,
            Self::AddRegS => Self::AddReg,
            Self::SubRegS => Self::SubReg,
            Self::AdcRegS => Self::AdcReg,
            Self::SbcRegS => Self::SbcReg,
            Self::AndRegS => Self::AndReg,
            Self::BicRegS => Self::BicReg,
            Self::OrrRegS => Self::OrrReg,
            Self::EorRegS => Self::EorReg,
            Self::MvnRegS => Self::MvnReg,
            Self::LslImmS | Self::LslImmSThen => Self::LslImm,
            Self::LsrImmS => Self::LsrImm,
            Self::AsrImmS => Self::AsrImm,
            Self::LslRegS => Self::LslReg,
            Self::LsrRegS => Self::LsrReg,
            Self::AsrRegS => Self::AsrReg,
            Self::RorRegS => Self::RorReg,
            Self::MulS => Self::Mul,
            other => other,
        }
    }
}
