//! Files of the readers with bytes changed, left out and put in: each goes through the check of its
//! target, which asks for a survey, a map or one line that refuses it.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The check of a target.
type Check = fn(&[u8]);

/// The folder of a target's sound files in `fuzz/corpus`, and its check.
const READERS: [(&str, Check); 9] = [
    ("compass", fuzz_checks::surveys::compass),
    ("map_server", fuzz_checks::maps::map_server),
    ("pocket_topo", fuzz_checks::surveys::pocket_topo),
    ("subt", fuzz_checks::maps::subt),
    ("survex", fuzz_checks::surveys::survex),
    ("therion", fuzz_checks::surveys::therion),
    ("three_d", fuzz_checks::surveys::three_d),
    ("visual_topo", fuzz_checks::surveys::visual_topo),
    ("walls", fuzz_checks::surveys::walls),
];

/// Numbers that look drawn, the same each time (an xorshift generator, by Marsaglia).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }
}

/// What readers of text trip over.
const WORDS: [&[u8]; 14] = [
    b"-",
    b"*",
    b"\"",
    b"[",
    b"\\",
    b"\r",
    b"\t",
    b"#",
    b"0",
    b"1e308",
    b"-1e9",
    b"nan",
    b"99999999999",
    b"\xef\xbb\xbf",
];

fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len() + 1);
    let end = (at + random.below(40)).min(bytes.len());
    match random.below(8) {
        0 | 1 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
        2 if at < bytes.len() => bytes[at] = random.below(256) as u8,
        3 => drop(bytes.drain(at..end)),
        4 => bytes.insert(at, random.below(256) as u8),
        5 => drop(bytes.splice(at..at, WORDS[random.below(WORDS.len())].iter().copied())),
        6 => {
            let copy = bytes[at..end].to_vec();
            let to = random.below(bytes.len() + 1);
            drop(bytes.splice(to..to, copy));
        }
        _ if random.below(4) == 0 => bytes.truncate(at),
        _ => bytes[at..end].fill(0xff),
    }
}

fn sound(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpus").join(target);
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| fs::read(file).unwrap()).collect()
}

/// Reads so many files of each reader, each damaged at up to five places.
fn read(count: u64) {
    for (target, check) in READERS {
        let sound = sound(target);
        let mut slowest = (Duration::ZERO, 0);
        for number in 0..count {
            let mut random = Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
            let mut bytes = sound[number as usize % sound.len()].clone();
            for _ in 0..=random.below(4) {
                damage(&mut bytes, &mut random);
            }
            let began = Instant::now();
            if std::panic::catch_unwind(|| check(&bytes)).is_err() {
                panic!("{target}, number {number}:\n{}", String::from_utf8_lossy(&bytes));
            }
            slowest = slowest.max((began.elapsed(), number));
        }
        println!("{target}: {count} read or refused; number {} took {:?}", slowest.1, slowest.0);
    }
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    read(300);
}

/// `DAMAGED_FILES` says how many files of each reader.
#[test]
#[ignore = "takes minutes; UCHAIN_LONG=1 .ci/run test runs it"]
fn every_damaged_file_is_read_or_refused() {
    let count = std::env::var("DAMAGED_FILES").ok().and_then(|it| it.parse().ok());
    read(count.unwrap_or(20_000));
}
