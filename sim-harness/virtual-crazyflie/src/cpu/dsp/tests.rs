//! Each instruction against what it is defined to compute, in 64 bits or more, lane by lane.

use proptest::prelude::*;

use super::*;

fn word() -> impl Strategy<Value = u32> {
    let half = || {
        prop_oneof![
            prop::sample::select(vec![0u16, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0x8080, 0xFFFF]),
            any::<u16>(),
        ]
    };
    prop_oneof![
        prop::sample::select(vec![0x7FFF_FFFF, 0x8000_0000, 0x4000_0000, 0xC000_0000, u32::MAX]),
        (half(), half()).prop_map(|(high, low)| u32::from(high) << 16 | u32::from(low)),
        any::<u32>(),
    ]
}

fn signed(word: u32) -> i64 {
    i64::from(word as i32)
}

fn halves(word: u32) -> [i64; 2] {
    [i64::from(word as u16 as i16), i64::from((word >> 16) as u16 as i16)]
}

fn from_halves(halves: [i64; 2]) -> u32 {
    (halves[1] as u32) << 16 | halves[0] as u32 & 0xFFFF
}

/// The nearest of a range, and whether it is another.
fn nearest(value: i64, least: i64, greatest: i64) -> (u32, bool) {
    let near = value.max(least).min(greatest);
    (near as u32, near != value)
}

/// Lanes of a word, as the prefix sees them.
fn split(word: u32, bits: u32, signed: bool) -> Vec<i64> {
    (0..32 / bits)
        .map(|lane| {
            let value = i64::from(word >> (lane * bits)) % (1 << bits);
            if signed && value >= 1 << (bits - 1) { value - (1 << bits) } else { value }
        })
        .collect()
}

/// By definition: all lanes' sums first, then what the prefix makes of them, then GE.
fn parallel_by_definition(prefix: Prefix, lanes: Lanes, n: u32, m: u32) -> (u32, u8) {
    use Prefix as P;
    let is_signed = matches!(prefix, P::Signed | P::Saturating | P::SignedHalving);
    let bits = if matches!(lanes, Lanes::Add8 | Lanes::Sub8) { 8 } else { 16 };
    let (n, mut m) = (split(n, bits, is_signed), split(m, bits, is_signed));
    let signs: &[i64] = match lanes {
        Lanes::Add8 => &[1, 1, 1, 1],
        Lanes::Sub8 => &[-1, -1, -1, -1],
        Lanes::Add16 => &[1, 1],
        Lanes::Sub16 => &[-1, -1],
        Lanes::Asx => &[-1, 1],
        Lanes::Sax => &[1, -1],
    };
    if matches!(lanes, Lanes::Asx | Lanes::Sax) {
        m.reverse();
    }
    let modulus = 1i64 << bits;
    let (mut word, mut ge) = (0u32, 0u8);
    for (lane, sign) in signs.iter().enumerate() {
        let sum = n[lane] + sign * m[lane];
        let value = match prefix {
            P::Signed | P::Unsigned => sum,
            P::SignedHalving | P::UnsignedHalving => sum.div_euclid(2),
            P::Saturating => sum.max(-modulus / 2).min(modulus / 2 - 1),
            P::UnsignedSaturating => sum.max(0).min(modulus - 1),
        };
        word |= (value.rem_euclid(modulus) as u32) << (lane as u32 * bits);
        let carry = *sign == 1 && prefix == P::Unsigned;
        if (carry && sum >= modulus) || (!carry && sum >= 0) {
            ge |= if bits == 8 { 1 << lane } else { 3 << (2 * lane) };
        }
    }
    (word, ge)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn all_parallel_instructions_do_as_defined(n in word(), m in word()) {
        use Prefix as P;
        for prefix in [
            P::Signed, P::Saturating, P::SignedHalving,
            P::Unsigned, P::UnsignedSaturating, P::UnsignedHalving,
        ] {
            for lanes in [
                Lanes::Add8, Lanes::Add16, Lanes::Asx, Lanes::Sax, Lanes::Sub8, Lanes::Sub16,
            ] {
                let (word, ge) = parallel(prefix, lanes, n, m);
                let wanted = parallel_by_definition(prefix, lanes, n, m);
                prop_assert_eq!(word, wanted.0, "{:?} {:?}", prefix, lanes);
                if prefix.sets_ge() {
                    prop_assert_eq!(ge, wanted.1, "{:?} {:?}", prefix, lanes);
                }
            }
        }
    }

    #[test]
    fn saturating_sums_go_to_the_nearest(m in word(), n in word()) {
        const LEAST: i64 = i32::MIN as i64;
        const GREATEST: i64 = i32::MAX as i64;
        let (doubled, doubling) = nearest(2 * signed(n), LEAST, GREATEST);
        let either = |(value, q): (u32, bool)| (value, q || doubling);
        prop_assert_eq!(qadd(m, n), nearest(signed(m) + signed(n), LEAST, GREATEST));
        prop_assert_eq!(qsub(m, n), nearest(signed(m) - signed(n), LEAST, GREATEST));
        let sum = nearest(signed(m) + signed(doubled), LEAST, GREATEST);
        prop_assert_eq!(qdadd(m, n), either(sum));
        let difference = nearest(signed(m) - signed(doubled), LEAST, GREATEST);
        prop_assert_eq!(qdsub(m, n), either(difference));
    }

    #[test]
    fn saturation_goes_to_the_nearest(n in word(), bits in 0u32..32) {
        let power = |bits: u32| 1i64 << bits;
        prop_assert_eq!(ssat(n, bits + 1), nearest(signed(n), -power(bits), power(bits) - 1));
        prop_assert_eq!(usat(n, bits), nearest(signed(n), 0, power(bits) - 1));
        let bits = bits % 16;
        let both = |least: i64, greatest: i64| {
            let [low, high] = halves(n).map(|half| nearest(half, least, greatest));
            (from_halves([low.0.into(), high.0.into()]), low.1 || high.1)
        };
        prop_assert_eq!(ssat16(n, bits + 1), both(-power(bits), power(bits) - 1));
        prop_assert_eq!(usat16(n, bits), both(0, power(bits) - 1));
    }

    #[test]
    fn products_of_halves_are_summed_as_defined(
        n in word(), m in word(), a in word(), high in word(), x in any::<bool>(), y in any::<bool>()
    ) {
        let q = |exact: i64| (exact as u32, i32::try_from(exact).is_err());
        let product = halves(n)[usize::from(x)] * halves(m)[usize::from(y)];
        prop_assert_eq!(smulxy(n, m, x, y), product as u32);
        prop_assert_eq!(smlaxy(n, m, a, x, y), q(product + signed(a)));
        let wide = signed(n) * halves(m)[usize::from(y)];
        prop_assert_eq!(smulwy(n, m, y), wide.div_euclid(1 << 16) as u32);
        prop_assert_eq!(smlawy(n, m, a, y), q(wide.div_euclid(1 << 16) + signed(a)));

        let long = u64::from(high) << 32 | u64::from(a);
        let plus = |value: i64| (i128::from(long) + i128::from(value)) as u64;
        prop_assert_eq!(smlalxy(n, m, long, x, y), plus(product));
        let [first, second] = [0, 1].map(|half| halves(n)[half] * halves(m)[half ^ usize::from(x)]);
        prop_assert_eq!(smlad(n, m, a, x), q(first + second + signed(a)));
        prop_assert_eq!(smlsd(n, m, a, x), q(first - second + signed(a)));
        prop_assert_eq!(smlald(n, m, long, x), plus(first + second));
        prop_assert_eq!(smlsld(n, m, long, x), plus(first - second));
    }

    #[test]
    fn most_significant_words_are_those_of_the_exact_sum(
        n in word(), m in word(), a in word(), round in any::<bool>()
    ) {
        let half = if round { 1i128 << 31 } else { 0 };
        let product = i128::from(signed(n) * signed(m));
        let addend = i128::from(signed(a)) << 32;
        let upper = |exact: i128| (exact + half).div_euclid(1 << 32) as u32;
        prop_assert_eq!(smmla(n, m, a, round), upper(addend + product));
        prop_assert_eq!(smmls(n, m, a, round), upper(addend - product));
        let sum = u128::from(n) * u128::from(m) + u128::from(a) + u128::from(m);
        prop_assert_eq!(u128::from(umaal(n, m, a, m)), sum);
    }

    #[test]
    fn bytes_and_halves_are_taken_from_where_they_should_be(
        n in word(), m in word(), a in word(), ge in 0u8..16
    ) {
        let bytes = |word: u32| split(word, 8, false);
        let chosen = (0..4).map(|i| if ge & (1 << i) != 0 { bytes(n)[i] } else { bytes(m)[i] });
        prop_assert_eq!(bytes(sel(n, m, ge)), chosen.collect::<Vec<_>>());
        let apart: i64 = (0..4).map(|i| (bytes(n)[i] - bytes(m)[i]).abs()).sum();
        prop_assert_eq!(usada8(n, m, a), (apart + i64::from(a)) as u32);
        prop_assert_eq!(halves(pkhbt(n, m)), [halves(n)[0], halves(m)[1]]);
        prop_assert_eq!(halves(pkhtb(n, m)), [halves(m)[0], halves(n)[1]]);
        let signed_bytes = split(m, 8, true);
        let sums = [halves(n)[0] + signed_bytes[0], halves(n)[1] + signed_bytes[2]];
        prop_assert_eq!(sxtab16(n, m), from_halves(sums));
        let sums = [halves(n)[0] + bytes(m)[0], halves(n)[1] + bytes(m)[2]];
        prop_assert_eq!(uxtab16(n, m), from_halves(sums));
    }
}
