//! The instructions of ARMv6-M, decoded.

/// The number of a core register: 13 is SP, 14 is LR, 15 is PC.
pub type Register = u8;

/// An operation of two registers whose result goes into the first (ARMv6-M Architecture Reference
/// Manual, A5.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "each name is the mnemonic")]
pub enum Alu {
    And,
    Eor,
    Lsl,
    Lsr,
    Asr,
    Adc,
    Sbc,
    Ror,
    Tst,
    Rsb,
    Cmp,
    Cmn,
    Orr,
    Mul,
    Bic,
    Mvn,
}

/// The kind of a shift by a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "each name is the mnemonic")]
pub enum Shift {
    Lsl,
    Lsr,
    Asr,
}

/// A load or a store of one register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "each name is the mnemonic")]
pub enum Access {
    Str,
    Strh,
    Strb,
    Ldr,
    Ldrh,
    Ldrb,
    Ldrsh,
    Ldrsb,
}

/// An instruction that changes the width or the byte order of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "each name is the mnemonic")]
pub enum Change {
    Sxth,
    Sxtb,
    Uxth,
    Uxtb,
    Rev,
    Rev16,
    Revsh,
}

/// An instruction with its operands. `d` is the register of the result, `n` and `m` are operands, `t`
/// is the register that is loaded or stored; offsets are in bytes, those of branches from the
/// instruction's address plus 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the fields are those of the manual, named above")]
pub enum Op {
    /// LSLS, LSRS, ASRS by a constant of 0 to 32.
    Shift { shift: Shift, d: Register, m: Register, by: u8 },
    /// ADDS of registers.
    Add { d: Register, n: Register, m: Register },
    /// SUBS of registers.
    Sub { d: Register, n: Register, m: Register },
    /// ADDS with a constant.
    AddConstant { d: Register, n: Register, constant: u8 },
    /// SUBS with a constant.
    SubConstant { d: Register, n: Register, constant: u8 },
    /// MOVS with a constant.
    MovConstant { d: Register, constant: u8 },
    /// CMP with a constant.
    CmpConstant { n: Register, constant: u8 },
    /// An operation of two registers.
    Alu { alu: Alu, d: Register, m: Register },
    /// ADD of any registers, which leaves the flags alone.
    AddAny { d: Register, m: Register },
    /// CMP of any registers.
    CmpAny { n: Register, m: Register },
    /// MOV of any registers, which leaves the flags alone.
    MovAny { d: Register, m: Register },
    /// BX.
    BranchExchange { m: Register },
    /// BLX.
    CallExchange { m: Register },
    /// LDR from an address relative to PC.
    LoadLiteral { t: Register, offset: u16 },
    /// A load or store at the sum of two registers.
    AccessRegister { access: Access, t: Register, n: Register, m: Register },
    /// A load or store at a register plus a constant.
    AccessConstant { access: Access, t: Register, n: Register, offset: u16 },
    /// ADR.
    Adr { d: Register, offset: u16 },
    /// ADD of SP and a constant into a register.
    AddSp { d: Register, offset: u16 },
    /// ADD or SUB of a constant to SP.
    MoveSp { offset: i16 },
    /// An extension or a change of the byte order.
    Change { change: Change, d: Register, m: Register },
    /// PUSH; bit 14 of the list is LR.
    Push { list: u16 },
    /// POP; bit 15 of the list is PC.
    Pop { list: u16 },
    /// STM.
    StoreMany { n: Register, list: u8 },
    /// LDM.
    LoadMany { n: Register, list: u8 },
    /// CPSIE i or CPSID i.
    Mask { masked: bool },
    /// NOP, YIELD, SEV and the barriers, which have no effect here.
    Nothing { cycles: u8 },
    /// WFI and WFE.
    Wait,
    /// B with a condition.
    BranchIf { condition: u8, offset: i16 },
    /// B.
    Branch { offset: i16 },
    /// BL.
    Call { offset: i32 },
    /// MSR.
    WriteSpecial { n: Register, special: u8 },
    /// MRS.
    ReadSpecial { d: Register, special: u8 },
    /// SVC.
    SupervisorCall,
    /// BKPT, UDF, and every encoding that ARMv6-M leaves undefined.
    Undefined,
}

impl Op {
    /// The size of the instruction in bytes.
    #[must_use]
    pub const fn size(self) -> u32 {
        match self {
            // Only barriers are among the wide ones that have no effect.
            Self::Nothing { cycles } if cycles > 1 => 4,
            Self::Call { .. } | Self::WriteSpecial { .. } | Self::ReadSpecial { .. } => 4,
            _ => 2,
        }
    }
}
