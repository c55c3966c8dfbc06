//! The floating-point unit (DDI 0403, A6.4 to A6.7).

use super::{Aim, Form, Rule};

pub(super) fn float(forms: &mut Vec<Form>) {
    for (name, high, low) in [
        ("VMLA", "0f00", '0'),
        ("VMLS", "0f00", '1'),
        ("VNMLS", "0f01", '0'),
        ("VNMLA", "0f01", '1'),
        ("VMUL", "0f10", '0'),
        ("VNMUL", "0f10", '1'),
        ("VADD", "0f11", '0'),
        ("VSUB", "0f11", '1'),
        ("VDIV", "1f00", '0'),
        ("VFNMS", "1f01", '0'),
        ("VFNMA", "1f01", '1'),
        ("VFMA", "1f10", '0'),
        ("VFMS", "1f10", '1'),
    ] {
        forms.push(Form::new(name, &format!("11101110{high}ggggffff1010g{low}e0eeee")));
    }
    let plain = [
        ("VMOV imm", "111011101f11iiiiffff10100000iiii"),
        ("VMOV reg", "111011101f110000ffff101001e0eeee"),
        ("VABS", "111011101f110000ffff101011e0eeee"),
        ("VNEG", "111011101f110001ffff101001e0eeee"),
        ("VSQRT", "111011101f110001ffff101011e0eeee"),
        ("VCVT from half", "111011101f110010ffff1010x1e0eeee"),
        ("VCVT to half", "111011101f110011ffff1010x1e0eeee"),
        ("VCMP", "111011101f110100ffff1010x1e0eeee"),
        ("VCMP zero", "111011101f110101ffff1010x1000000"),
        ("VCVT from int", "111011101f111000ffff1010x1e0eeee"),
        ("VCVT to signed", "111011101f111101ffff1010x1e0eeee"),
        ("VCVT to unsigned", "111011101f111100ffff1010x1e0eeee"),
        ("VMOV to S", "111011100000ggggtttt1010g0010000"),
        ("VMOV from S", "111011100001ggggtttt1010g0010000"),
        ("VMOV to half of D", "1110111000x0ggggtttt101100010000"),
        ("VMOV from half of D", "1110111000x1ggggtttt101100010000"),
        ("VMOV to D", "111011000100uuuutttt10110001eeee"),
        ("VMSR", "1110111011100001tttt101000010000"),
        ("VMRS flags", "11101110111100011111101000010000"),
        ("VMRS", "1110111011110001tttt101000010000"),
    ];
    forms.extend(plain.map(|(name, pattern)| Form::new(name, pattern)));
    // As many fraction bits as there are bits, and no more (A7.7, VCVT (between
    // floating-point and fixed-point)).
    let fraction: Rule = |f, e| {
        let bits = f.f(b'i', e) & 0xF;
        f.f(b'x', e) == 1 || (bits << 1 | e >> 5 & 1) <= 16
    };
    for (name, code) in [("from fixed", "101"), ("to fixed", "111")] {
        let pattern = format!("111011101f11{code}yffff1010x1i0iiii");
        forms.push(Form::new(&format!("VCVT {name}"), &pattern).rule(fraction));
    }
    let two: Rule = |_, e| e & 0x2F != 0x2F;
    let two_apart: Rule = |f, e| e & 0x2F != 0x2F && f.f(b't', e) != f.f(b'u', e);
    forms.push(Form::new("VMOV to two S", "111011000100uuuutttt101000e1eeee").rule(two));
    forms.push(Form::new("VMOV from two S", "111011000101uuuutttt101000e1eeee").rule(two_apart));
    forms.push(
        Form::new("VMOV from D", "111011000101uuuutttt10110001eeee")
            .rule(|f, e| f.f(b't', e) != f.f(b'u', e)),
    );
    float_memory(forms);
}

fn float_memory(forms: &mut Vec<Form>) {
    for (kind, low, d) in [("S", "1010", "f"), ("D", "1011", "0")] {
        let mut add = |name: &str, pattern: String, aim| {
            forms.push(Form::new(&format!("{name}.{kind}"), &pattern).aim(aim));
        };
        add("VLDR literal", format!("11101101x{d}011111ffff{low}iiiiiiii"), Aim::Nothing);
        add("VLDR", format!("11101101x{d}01NNNNffff{low}iiiiiiii"), Aim::Base);
        add("VSTR", format!("11101101x{d}00NNNNffff{low}iiiiiiii"), Aim::Base);
        let rule: Rule = if kind == "S" {
            |f, e| {
                let first = e >> 11 & 0x1E | e >> 22 & 1;
                let count = f.f(b'i', e);
                count != 0 && first + count <= 32
            }
        } else {
            |f, e| {
                let count = f.f(b'i', e);
                count != 0 && count & 1 == 0 && (e >> 12 & 0xF) + count / 2 <= 16
            }
        };
        for (name, bit) in [("VLDM", '1'), ("VSTM", '0')] {
            for (way, code) in [("ia", format!("111011001{d}w")), ("db", format!("111011010{d}1"))]
            {
                let pattern = format!("{code}{bit}NNNNffff{low}iiiiiiii");
                forms.push(
                    Form::new(&format!("{name} {way}.{kind}"), &pattern).aim(Aim::Base).rule(rule),
                );
            }
        }
    }
}
