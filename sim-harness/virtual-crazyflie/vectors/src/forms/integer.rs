//! Data processing of two halfwords (DDI 0403, A5.3.1, A5.3.3, A5.3.11 to A5.3.17).

use super::{Form, Rule};

/// The operations that come with a shifted register and with a modified immediate alike.
const OPERATIONS: [(&str, &str, Option<&str>, Option<&str>); 10] = [
    ("AND", "0000", Some("TST"), None),
    ("BIC", "0001", None, None),
    ("ORR", "0010", None, Some("MOV")),
    ("ORN", "0011", None, Some("MVN")),
    ("EOR", "0100", Some("TEQ"), None),
    ("ADD", "1000", Some("CMN"), None),
    ("ADC", "1010", None, None),
    ("SBC", "1011", None, None),
    ("SUB", "1101", Some("CMP"), None),
    ("RSB", "1110", None, None),
];

pub(super) fn shifted_register(forms: &mut Vec<Form>) {
    for (name, code, compare, single) in OPERATIONS {
        let tail = "iikkmmmm";
        if let Some(compare) = compare {
            let n = if matches!(name, "ADD" | "SUB") { "NNNN" } else { "nnnn" };
            let pattern = format!("1110101{code}1{n}0iii1111{tail}");
            forms.push(Form::new(&format!("{compare} reg.W"), &pattern));
        }
        if let Some(single) = single {
            let pattern = format!("1110101{code}s11110iiidddd{tail}");
            forms.push(Form::new(&format!("{single} reg.W"), &pattern));
        }
        if matches!(name, "ADD" | "SUB") {
            // With SP as the destination the shift is LSL by 3 at most (A7.7, ADD (SP plus
            // register)).
            let pattern = format!("1110101{code}0110100001101ii00mmmm");
            forms.push(Form::new(&format!("{name} sp reg.W"), &pattern));
            let pattern = format!("1110101{code}s11010iiidddd{tail}");
            forms.push(Form::new(&format!("{name} reg from sp.W"), &pattern));
        }
        let pattern = format!("1110101{code}snnnn0iiidddd{tail}");
        forms.push(Form::new(&format!("{name} reg.W"), &pattern));
    }
    forms.push(Form::new("PKH", "111010101100nnnn0iiiddddiik0mmmm"));
}

pub(super) fn immediates(forms: &mut Vec<Form>) {
    // A zero byte that is to be repeated (A5.3.2).
    let constant: Rule = |_, e| {
        let (high, byte) = (e >> 24 & 4 | e >> 12 & 7, e & 0xFF);
        e >> 26 & 1 == 1 || high == 0 || e >> 12 & 4 != 0 || byte != 0
    };
    for (name, code, compare, single) in OPERATIONS {
        let mut add = |name: &str, pattern: &str| {
            forms.push(Form::new(&format!("{name} imm.W"), pattern).rule(constant));
        };
        if let Some(compare) = compare {
            let n = if matches!(name, "ADD" | "SUB") { "NNNN" } else { "nnnn" };
            add(compare, &format!("11110i0{code}1{n}0iii1111iiiiiiii"));
        }
        if let Some(single) = single {
            add(single, &format!("11110i0{code}s11110iiiddddiiiiiiii"));
        }
        if matches!(name, "ADD" | "SUB") {
            add(&format!("{name} sp"), &format!("11110i0{code}011010iii1101iiiiiiii"));
            add(&format!("{name} from sp"), &format!("11110i0{code}s11010iiiddddiiiiiiii"));
        }
        add(name, &format!("11110i0{code}snnnn0iiiddddiiiiiiii"));
    }
    let plain = [
        ("ADR add", "11110i10000011110iiiddddiiiiiiii"),
        ("ADR sub", "11110i10101011110iiiddddiiiiiiii"),
        ("ADDW sp", "11110i10000011010iii1101iiiiiiii"),
        ("SUBW sp", "11110i10101011010iii1101iiiiiiii"),
        ("ADDW", "11110i100000NNNN0iiiddddiiiiiiii"),
        ("SUBW", "11110i101010NNNN0iiiddddiiiiiiii"),
        ("MOVW", "11110i100100iiii0iiiddddiiiiiiii"),
        ("MOVT", "11110i101100iiii0iiiddddiiiiiiii"),
        ("SSAT16", "111100110010nnnn0000dddd0000kkkk"),
        ("USAT16", "111100111010nnnn0000dddd0000kkkk"),
        ("SSAT lsl", "111100110000nnnn0iiiddddii0kkkkk"),
        ("USAT lsl", "111100111000nnnn0iiiddddii0kkkkk"),
    ];
    forms.extend(plain.map(|(name, pattern)| Form::new(name, pattern)));
    let fits: Rule = |f, e| f.f(b'i', e) + f.f(b'k', e) < 32;
    let ordered: Rule = |f, e| f.f(b'k', e) >= f.f(b'i', e);
    // By no bit at all it is SSAT16 or USAT16, in which the upper bit of k must be zero.
    let shifted: Rule = |f, e| f.f(b'i', e) != 0;
    for (name, pattern, rule) in [
        ("SSAT asr", "111100110010nnnn0iiiddddii0kkkkk", shifted),
        ("USAT asr", "111100111010nnnn0iiiddddii0kkkkk", shifted),
        ("SBFX", "111100110100nnnn0iiiddddii0kkkkk", fits),
        ("UBFX", "111100111100nnnn0iiiddddii0kkkkk", fits),
        ("BFC", "11110011011011110iiiddddii0kkkkk", ordered),
        ("BFI", "111100110110nnnn0iiiddddii0kkkkk", ordered),
    ] {
        forms.push(Form::new(name, pattern).rule(rule));
    }
}

pub(super) fn register(forms: &mut Vec<Form>) {
    for (code, name) in ["LSL", "LSR", "ASR", "ROR"].iter().enumerate() {
        let pattern = format!("111110100{code:02b}snnnn1111dddd0000mmmm");
        forms.push(Form::new(&format!("{name} reg.W"), &pattern));
    }
    let extend = ["SXTH", "UXTH", "SXTB16", "UXTB16", "SXTB", "UXTB"];
    for (code, name) in extend.iter().enumerate() {
        let (head, tail) = (format!("111110100{code:03b}"), "1111dddd10rrmmmm");
        let add = name.replace("XT", "XTA");
        forms.push(Form::new(&format!("{name}.W"), &format!("{head}1111{tail}")));
        forms.push(Form::new(&add, &format!("{head}nnnn{tail}")));
    }
    let lanes = [
        ("ADD8", "000"),
        ("ADD16", "001"),
        ("ASX", "010"),
        ("SUB8", "100"),
        ("SUB16", "101"),
        ("SAX", "110"),
    ];
    let kinds =
        [("S", "000"), ("Q", "001"), ("SH", "010"), ("U", "100"), ("UQ", "101"), ("UH", "110")];
    for (lane, code) in lanes {
        for (kind, bits) in kinds {
            let pattern = format!("111110101{code}nnnn1111dddd0{bits}mmmm");
            forms.push(Form::new(&format!("{kind}{lane}"), &pattern));
        }
    }
    for (code, name) in ["QADD", "QDADD", "QSUB", "QDSUB"].iter().enumerate() {
        forms.push(Form::new(name, &format!("111110101000nnnn1111dddd10{code:02b}mmmm")));
    }
    let same: Rule = |f, e| f.f(b'n', e) == f.f(b'm', e);
    for (code, name) in ["REV.W", "REV16.W", "RBIT", "REVSH.W"].iter().enumerate() {
        let pattern = format!("111110101001nnnn1111dddd10{code:02b}mmmm");
        forms.push(Form::new(name, &pattern).rule(same));
    }
    forms.push(Form::new("SEL", "111110101010nnnn1111dddd1000mmmm"));
    forms.push(Form::new("CLZ", "111110101011nnnn1111dddd1000mmmm").rule(same));
}

pub(super) fn multiply(forms: &mut Vec<Form>) {
    let accumulating = [
        ("MLA", "000", "0000", Some("MUL.W")),
        ("MLS", "000", "0001", None),
        ("SMLAxy", "001", "00xy", Some("SMULxy")),
        ("SMLAD", "010", "000x", Some("SMUAD")),
        ("SMLAW", "011", "000y", Some("SMULW")),
        ("SMLSD", "100", "000x", Some("SMUSD")),
        ("SMMLA", "101", "000r", Some("SMMUL")),
        ("SMMLS", "110", "000r", None),
        ("USADA8", "111", "0000", Some("USAD8")),
    ];
    for (name, code, second, without) in accumulating {
        if let Some(without) = without {
            forms.push(Form::new(without, &format!("111110110{code}nnnn1111dddd{second}mmmm")));
        }
        forms.push(Form::new(name, &format!("111110110{code}nnnnaaaadddd{second}mmmm")));
    }
    forms.push(Form::new("SDIV", "111110111001nnnn1111dddd1111mmmm"));
    forms.push(Form::new("UDIV", "111110111011nnnn1111dddd1111mmmm"));
    for (name, code, second) in [
        ("SMULL", "000", "0000"),
        ("UMULL", "010", "0000"),
        ("SMLAL", "100", "0000"),
        ("SMLALxy", "100", "10xy"),
        ("SMLALD", "100", "110x"),
        ("SMLSLD", "101", "110x"),
        ("UMLAL", "110", "0000"),
        ("UMAAL", "110", "0110"),
    ] {
        let pattern = format!("111110111{code}nnnnllllhhhh{second}mmmm");
        forms.push(Form::new(name, &pattern).rule(|f, e| f.f(b'l', e) != f.f(b'h', e)));
    }
}
