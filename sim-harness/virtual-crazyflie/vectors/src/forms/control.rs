//! Branches, hints, barriers and special registers, in two halfwords (DDI 0403, A5.3.4).

use super::Form;

pub(super) fn control(forms: &mut Vec<Form>) {
    let plain = [
        ("NOP.W", "11110011101011111000000000000000"),
        ("YIELD.W", "11110011101011111000000000000001"),
        ("WFE.W", "11110011101011111000000000000010"),
        ("WFI.W", "11110011101011111000000000000011"),
        ("SEV.W", "11110011101011111000000000000100"),
        ("CLREX", "11110011101111111000111100101111"),
        ("DSB", "1111001110111111100011110100iiii"),
        ("DMB", "1111001110111111100011110101iiii"),
        ("ISB", "1111001110111111100011110110iiii"),
        ("UDF.W", "111101111111iiii1010iiiiiiiiiiii"),
        ("B.W", "11110siiiiiiiiii10j1kiiiiiiiiiii"),
        ("BL", "11110siiiiiiiiii11j1kiiiiiiiiiii"),
    ];
    forms.extend(plain.map(|(name, pattern)| Form::new(name, pattern)));
    forms.push(
        Form::new("MRS", "11110011111011111000ddddyyyyyyyy")
            .rule(|f, e| matches!(f.f(b'y', e), 0..=3 | 5..=9 | 16..=20)),
    );
    // The flags by mask 10, GE by 01: other registers know 10 only (B5.2.3).
    forms.push(Form::new("MSR", "111100111000nnnn1000xx00yyyyyyyy").rule(
        |f, e| match f.f(b'y', e) {
            0..=3 => f.f(b'x', e) != 0,
            5..=9 | 16..=20 => f.f(b'x', e) == 2,
            _ => false,
        },
    ));
    forms.push(
        Form::new("B cond.W", "11110scccciiiiii10j0kiiiiiiiiiii").rule(|f, e| f.f(b'c', e) < 14),
    );
}
