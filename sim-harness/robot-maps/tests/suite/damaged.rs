//! Maps with bytes changed, left out and put in: each is read, or refused in one line.

use std::time::{Duration, Instant};

use cave_survey::Memory;
use png::{BitDepth, ColorType, Encoder};
use robot_maps::map_server;

use super::map_server::{bmp, greys};

const YAML: &str = "image: m\nresolution: 0.05\norigin: [-1.0, 2.0, -nan]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.25\nmode: trinary\n";

fn pixels() -> Vec<u8> {
    (0..600_u32).map(|n| if n % 30 == 0 { 0 } else { [254, 254, 205][(n % 3) as usize] }).collect()
}

fn png(colour: ColorType, depth: BitDepth) -> Vec<u8> {
    let mut bytes = Vec::new();
    let width = colour.samples() * if depth == BitDepth::Sixteen { 2 } else { 1 };
    let data: Vec<u8> = pixels().into_iter().flat_map(|pixel| vec![pixel; width]).collect();
    let mut encoder = Encoder::new(&mut bytes, 30, 20);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    bytes
}

/// The rows from the lowest one, of 30 bytes each, filled up to 32.
fn rows_of_bmp() -> Vec<u8> {
    pixels().chunks(30).rev().flat_map(|row| [row, &[0, 0]].concat()).collect()
}

fn images() -> Vec<(&'static str, Vec<u8>)> {
    let plain: Vec<String> = pixels().iter().map(u8::to_string).collect();
    vec![
        ("binary PGM", [b"P5\n# made\n30 20\n255\n".as_slice(), &pixels()].concat()),
        ("PGM as text", format!("P2 30 20 255\n{}", plain.join(" ")).into_bytes()),
        ("PNG", png(ColorType::Grayscale, BitDepth::Eight)),
        ("BMP", bmp([30, 20], 8, &greys(), &rows_of_bmp())),
        ("PNG of 16 bits with transparency", png(ColorType::Rgba, BitDepth::Sixteen)),
    ]
}

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

fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    match random.below(6) {
        0 | 1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes[at] = random.below(256) as u8,
        3 => drop(bytes.remove(at)),
        4 => bytes.insert(at, random.below(256) as u8),
        _ if random.below(4) == 0 => bytes.truncate(at),
        _ => {
            let end = (at + 4).min(bytes.len());
            bytes[at..end].fill(0xff);
        }
    }
}

/// Reads so many maps of each image, with the image or its YAML file damaged.
fn read(count: u64) {
    for (name, image) in images() {
        let (mut read, mut refused) = (0, 0);
        // The longest that one took, with its number. It is printed, and no test depends on it.
        let mut slowest = (Duration::ZERO, 0);
        for number in 0..count {
            let mut random = Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
            let (mut yaml, mut image) = (YAML.as_bytes().to_vec(), image.clone());
            let of_image = random.below(4) > 0;
            for _ in 0..=random.below(3) {
                damage(if of_image { &mut image } else { &mut yaml }, &mut random);
            }
            let files = Memory::default().with("m.yaml", yaml).with("m", image);
            let began = Instant::now();
            let done = map_server::read(&files, "m.yaml");
            slowest = slowest.max((began.elapsed(), number));
            match done {
                Ok(_) => read += 1,
                Err(refusal) => {
                    let line = refusal.to_string();
                    assert!(line.lines().count() == 1 && line.contains("; "), "{number}: {line}");
                    refused += 1;
                }
            }
        }
        println!(
            "{name}: {read} read, {refused} refused; number {} took {:?}",
            slowest.1, slowest.0
        );
    }
}

#[test]
fn a_damaged_map_is_read_or_refused_in_one_line() {
    read(500);
}

/// `DAMAGED_MAPS` says how many maps of each image.
#[test]
#[ignore = "takes minutes; UCHAIN_LONG=1 .ci/run test runs it"]
fn every_damaged_map_is_read_or_refused_in_one_line() {
    let count = std::env::var("DAMAGED_MAPS").ok().and_then(|it| it.parse().ok());
    read(count.unwrap_or(20_000));
}
