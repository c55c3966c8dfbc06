//! Instructions of one halfword (DDI 0403, A5.2).

use super::{Aim, Form, Rule};

pub(super) fn narrow(forms: &mut Vec<Form>) {
    let plain = [
        ("MOVS.N", "0000000000mmmddd"),
        ("LSL imm.N", "00000iiiiimmmddd"),
        ("LSR imm.N", "00001iiiiimmmddd"),
        ("ASR imm.N", "00010iiiiimmmddd"),
        ("ADD reg.N", "0001100mmmnnnddd"),
        ("SUB reg.N", "0001101mmmnnnddd"),
        ("ADD imm3.N", "0001110iiinnnddd"),
        ("SUB imm3.N", "0001111iiinnnddd"),
        ("MOV imm.N", "00100dddiiiiiiii"),
        ("CMP imm.N", "00101nnniiiiiiii"),
        ("ADD imm8.N", "00110dddiiiiiiii"),
        ("SUB imm8.N", "00111dddiiiiiiii"),
        ("ADD pc.N", "010001001mmmm111"),
        ("ADD sp.N", "010001001mmmm101"),
        ("ADD reg sp.N", "01000100d1101ddd"),
        ("ADD high.N", "01000100dmmmmddd"),
        ("MOV sp.N", "010001101mmmm101"),
        ("MOV from sp.N", "01000110d1101ddd"),
        ("MOV reg.N", "01000110dmmmmddd"),
        ("LDR literal.N", "01001tttiiiiiiii"),
        ("STR sp.N", "10010tttiiiiiiii"),
        ("LDR sp.N", "10011tttiiiiiiii"),
        ("ADR.N", "10100dddiiiiiiii"),
        ("ADD rd sp.N", "10101dddiiiiiiii"),
        ("ADD sp imm.N", "101100000iiiiiii"),
        ("SUB sp imm.N", "101100001iiiiiii"),
        ("CBZ", "101100i1iiiiinnn"),
        ("CBNZ", "101110i1iiiiinnn"),
        ("SXTH.N", "1011001000mmmddd"),
        ("SXTB.N", "1011001001mmmddd"),
        ("UXTH.N", "1011001010mmmddd"),
        ("UXTB.N", "1011001011mmmddd"),
        ("REV.N", "1011101000mmmddd"),
        ("REV16.N", "1011101001mmmddd"),
        ("REVSH.N", "1011101011mmmddd"),
        ("NOP.N", "1011111100000000"),
        ("YIELD.N", "1011111100010000"),
        ("WFE.N", "1011111100100000"),
        ("WFI.N", "1011111100110000"),
        ("SEV.N", "1011111101000000"),
        ("BKPT", "10111110iiiiiiii"),
        ("UDF.N", "11011110iiiiiiii"),
        ("SVC", "11011111iiiiiiii"),
        ("B cond.N", "1101cccciiiiiiii"),
        ("B.N", "11100iiiiiiiiiii"),
    ];
    forms.extend(plain.map(|(name, pattern)| Form::new(name, pattern)));
    let two = [
        "AND", "EOR", "LSL", "LSR", "ASR", "ADC", "SBC", "ROR", "TST", "RSB", "CMP", "CMN", "ORR",
        "MUL", "BIC", "MVN",
    ];
    for (code, name) in two.iter().enumerate() {
        forms.push(Form::new(&format!("{name}.N"), &format!("010000{code:04b}mmmddd")));
    }
    forms.push(
        Form::new("CMP high.N", "01000101NmmmmNNN")
            .rule(|f, e| f.f(b'n', e) >= 8 || f.f(b'm', e) >= 8),
    );
    forms.push(Form::new("MOV pc.N", "010001101mmmm111").aim(Aim::Target));
    // The PC is 15 in the fields of MOV: its own pattern must come first.
    let pc = forms.pop().expect("just pushed");
    let before = forms.iter().position(|f| f.name == "MOV sp.N").expect("in the list above");
    forms.insert(before, pc);
    forms.push(Form::new("BX", "010001110mmmm000").aim(Aim::Target));
    forms.push(Form::new("BLX", "010001111mmmm000").aim(Aim::Target));
    let indexed = ["STR", "STRH", "STRB", "LDRSB", "LDR", "LDRH", "LDRB", "LDRSH"];
    for (code, name) in indexed.iter().enumerate() {
        let pattern = format!("0101{code:03b}mmmnnnttt");
        forms.push(Form::new(&format!("{name} reg.N"), &pattern).aim(Aim::Indexed));
    }
    for (name, code) in [
        ("STR", "01100"),
        ("LDR", "01101"),
        ("STRB", "01110"),
        ("LDRB", "01111"),
        ("STRH", "10000"),
        ("LDRH", "10001"),
    ] {
        let pattern = format!("{code}iiiiinnnttt");
        forms.push(Form::new(&format!("{name} imm.N"), &pattern).aim(Aim::Base));
    }
    let some: Rule = |f, e| f.f(b'r', e) != 0;
    forms.push(Form::new("PUSH.N", "1011010rrrrrrrrr").rule(some));
    forms.push(Form::new("POP.N", "10111100rrrrrrrr").rule(some));
    forms.push(Form::new("POP pc.N", "10111101rrrrrrrr"));
    // The base is written back: in the list, it must be the lowest (A7.7, STM).
    forms.push(Form::new("STM.N", "11000nnnrrrrrrrr").aim(Aim::Base).rule(|f, e| {
        let (list, n) = (f.f(b'r', e), f.f(b'n', e));
        list != 0 && (list >> n & 1 == 0 || list.trailing_zeros() == n)
    }));
    forms.push(Form::new("LDM.N", "11001nnnrrrrrrrr").aim(Aim::Base).rule(some));
    forms.push(Form::new("CPS", "10110110011x00if").rule(|f, e| f.f(b'i', e) | f.f(b'f', e) != 0));
    forms.push(Form::new("IT", "10111111ccccxxxx").rule(|f, e| {
        let (c, x) = (f.f(b'c', e), f.f(b'x', e));
        x != 0 && c != 15 && (c != 14 || x.count_ones() == 1)
    }));
}
