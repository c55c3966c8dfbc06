//! Loads and stores of two halfwords, and what branches by a table (DDI 0403, A5.3.5 to A5.3.10).

use super::{Aim, Form, Rule};

pub(super) fn multiple(forms: &mut Vec<Form>) {
    for (name, code) in [("STM", "1110100010"), ("STMDB", "1110100100")] {
        let pattern = format!("{code}w0NNNN0r0rrrrrrrrrrrrr");
        forms.push(Form::new(name, &pattern).aim(Aim::Base).rule(|f, e| {
            let list = e & 0x5FFF;
            list.count_ones() >= 2 && (f.f(b'w', e) == 0 || list >> f.f(b'n', e) & 1 == 0)
        }));
    }
    for (name, code) in [("LDM", "1110100010"), ("LDMDB", "1110100100")] {
        let rule: Rule = |f, e| {
            let list = e & 0xDFFF;
            list.count_ones() >= 2
                && list >> 14 != 3
                && (f.f(b'w', e) == 0 || list >> f.f(b'n', e) & 1 == 0)
        };
        for (tail, top) in [("", "0r0"), (" pc", "100")] {
            let pattern = format!("{code}w1NNNN{top}rrrrrrrrrrrrr");
            forms.push(Form::new(&format!("{name}{tail}"), &pattern).aim(Aim::Base).rule(rule));
        }
    }
    for (name, code) in [("offset", "11101001x10"), ("pre", "11101001x11"), ("post", "11101000x11")]
    {
        let plain = name == "offset";
        forms.push(
            Form::new(&format!("STRD {name}"), &format!("{code}0NNNNttttuuuuiiiiiiii"))
                .aim(Aim::Base)
                .rule(if plain { |_, _| true } else { base_is_apart }),
        );
        if plain {
            forms.push(
                Form::new("LDRD literal", "11101001x1011111ttttuuuuiiiiiiii")
                    .rule(|f, e| f.f(b't', e) != f.f(b'u', e)),
            );
        }
        forms.push(
            Form::new(&format!("LDRD {name}"), &format!("{code}1NNNNttttuuuuiiiiiiii"))
                .aim(Aim::Base)
                .rule(if plain {
                    |f, e| f.f(b't', e) != f.f(b'u', e)
                } else {
                    |f, e| f.f(b't', e) != f.f(b'u', e) && base_is_apart(f, e)
                }),
        );
    }
}

fn base_is_apart(f: &Form, e: u32) -> bool {
    let n = f.f(b'n', e);
    f.f(b't', e) != n && f.field(b'u', e) != Some(n)
}

pub(super) fn exclusive_and_table(forms: &mut Vec<Form>) {
    let apart: Rule = |f, e| f.f(b'd', e) != f.f(b'n', e) && f.f(b'd', e) != f.f(b't', e);
    let add = |forms: &mut Vec<Form>, name, pattern, rule| {
        forms.push(Form::new(name, pattern).aim(Aim::Base).rule(rule));
    };
    add(forms, "STREX", "111010000100NNNNttttddddiiiiiiii", apart);
    add(forms, "STREXB", "111010001100NNNNtttt11110100dddd", apart);
    add(forms, "STREXH", "111010001100NNNNtttt11110101dddd", apart);
    add(forms, "LDREX", "111010000101NNNNtttt1111iiiiiiii", |_, _| true);
    add(forms, "LDREXB", "111010001101NNNNtttt111101001111", |_, _| true);
    add(forms, "LDREXH", "111010001101NNNNtttt111101011111", |_, _| true);
    for (name, bit) in [("TBB", '0'), ("TBH", '1')] {
        let (by_pc, by_register) = (
            format!("1110100011011111111100000 00{bit}mmmm"),
            format!("111010001101nnnn111100000 00{bit}mmmm"),
        );
        forms.push(Form::new(&format!("{name} pc"), &by_pc).aim(Aim::Indexed));
        forms.push(Form::new(name, &by_register).aim(Aim::Indexed));
    }
}

pub(super) fn single(forms: &mut Vec<Form>) {
    for (name, size, load) in [
        ("STRB", "00", false),
        ("STRH", "01", false),
        ("STR", "10", false),
        ("LDRB", "00", true),
        ("LDRH", "01", true),
        ("LDR", "10", true),
        ("LDRSB", "00", true),
        ("LDRSH", "01", true),
    ] {
        let sign = u8::from(name.starts_with("LDRS"));
        let bit = u8::from(load);
        let (short, long) =
            (format!("1111100{sign}0{size}{bit}"), format!("1111100{sign}1{size}{bit}"));
        let mut destinations = vec![("", "tttt")];
        if name == "LDR" {
            destinations.insert(0, (" pc", "1111"));
        } else if load && name != "LDRSH" {
            destinations.insert(0, (" hint", "1111"));
        }
        for (suffix, t) in destinations {
            if name == "LDRH" && suffix == " hint" {
                // PLDW is no part of ARMv7-M: the encodings are NOPs or UNDEFINED, and not generated.
                continue;
            }
            let mut add = |what: &str, pattern: String, aim, rule: Rule| {
                forms.push(
                    Form::new(&format!("{name}{suffix} {what}.W"), &pattern).aim(aim).rule(rule),
                );
            };
            let any: Rule = |_, _| true;
            let apart: Rule = |f, e| f.field(b't', e).is_none_or(|t| t != f.f(b'n', e));
            if load {
                add(
                    "literal",
                    format!("1111100{sign}x{size}{bit}1111{t}iiiiiiiiiiii"),
                    Aim::Nothing,
                    any,
                );
            }
            add("imm12", format!("{long}NNNN{t}iiiiiiiiiiii"), Aim::Base, any);
            add("reg", format!("{short}NNNN{t}000000iimmmm"), Aim::Indexed, any);
            add("minus", format!("{short}NNNN{t}1100iiiiiiii"), Aim::Base, any);
            if suffix != " hint" {
                if suffix.is_empty() {
                    add("unprivileged", format!("{short}NNNN{t}1110iiiiiiii"), Aim::Base, any);
                }
                add("pre", format!("{short}NNNN{t}11x1iiiiiiii"), Aim::Base, apart);
                add("post", format!("{short}NNNN{t}10x1iiiiiiii"), Aim::Base, apart);
            }
        }
    }
}
