//! Our core against Unicorn, instruction by instruction: see README.md.

mod compare;
mod exemptions;
mod mutants;
mod report;
mod unicorn;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use core_vectors::random::Random;
use core_vectors::vectors::{self, SEED, STATES, Vector};
use core_vectors::{Outcome, States, forms, sweep};
use virtual_crazyflie::image::Image;

use compare::{Findings, Pair, Verdict, judge};

/// Our core against Unicorn, instruction by instruction.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    what: What,
    /// Where the counts go, as JSON.
    #[arg(long, global = true)]
    json: Option<PathBuf>,
    /// Of the states.
    #[arg(long, global = true, default_value_t = SEED)]
    seed: u64,
}

#[derive(Subcommand)]
enum What {
    /// Every encoding of these ELFs, and some of every form.
    All {
        /// An ELF with mapping symbols.
        #[arg(long)]
        elf: Vec<PathBuf>,
        /// Of each encoding.
        #[arg(long, default_value_t = 20)]
        states: usize,
        /// Of each form, beside those of the ELFs.
        #[arg(long, default_value_t = 40)]
        samples: usize,
    },
    /// So many encodings of random forms, and as many of random bits.
    Random {
        /// How many.
        count: u32,
    },
    /// Every bug that was put in on purpose must be caught.
    Mutants,
    /// Makes the file that the everyday test replays.
    Freeze {
        /// An ELF with mapping symbols.
        #[arg(long)]
        elf: Vec<PathBuf>,
        /// The path of the output.
        #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../vectors/core.bin"))]
        to: PathBuf,
        /// Of each form, at most.
        #[arg(long, default_value_t = 18)]
        encodings: usize,
    },
}

fn main() -> ExitCode {
    let Arguments { what, json, seed } = Arguments::parse();
    let result = match what {
        What::All { elf, states, samples } => all(&elf, states, samples, seed, json.as_deref()),
        What::Random { count } => random(count, seed, json.as_deref()),
        What::Mutants => mutants(seed, json.as_deref()),
        What::Freeze { elf, to, encodings } => freeze(&elf, &to, encodings),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Every encoding of these ELFs with how often it occurs.
fn encodings(elves: &[PathBuf]) -> Result<BTreeMap<u32, u32>, String> {
    let mut found = BTreeMap::new();
    for path in elves {
        let image = Image::open(path)?;
        let found_here =
            sweep::encodings(&image).map_err(|why| format!("{}: {why}", path.display()))?;
        for (encoding, count) in found_here {
            *found.entry(encoding).or_insert(0) += count;
        }
    }
    Ok(found)
}

fn all(
    elves: &[PathBuf],
    states: usize,
    samples: usize,
    seed: u64,
    json: Option<&Path>,
) -> Result<bool, String> {
    let mut wanted: BTreeSet<u32> = encodings(elves)?.into_keys().collect();
    let of_elves = wanted.len();
    let mut random = Random::new(seed);
    for form in forms::all() {
        let samples = if form.is_family() { 4 * samples } else { samples };
        wanted.extend((0..samples).map(|_| form.sample(&mut random)));
    }
    println!("{of_elves} encodings of the ELFs, {} with those of the forms", wanted.len());
    let mut pair = Pair::new();
    let mut findings = Findings::default();
    for &encoding in &wanted {
        pair.compare(encoding, seed, states, &mut findings, |_, _, _| ());
    }
    let expected = wanted.len() as u64 * states as u64;
    report::finish(&findings, expected, json)
}

fn random(count: u32, seed: u64, json: Option<&Path>) -> Result<bool, String> {
    const EACH: usize = 4;
    let mut random = Random::new(seed ^ 0xA11);
    let mut pair = Pair::new();
    let mut findings = Findings::default();
    let all = forms::all();
    for _ in 0..count {
        let form = &all[random.below(u32::try_from(all.len()).expect("some hundred")) as usize];
        let encoding = form.sample(&mut random);
        pair.compare(encoding, seed, EACH, &mut findings, |_, _, _| ());
    }
    let mut expected = u64::from(count) * EACH as u64;
    let mut bits = report::Bits::default();
    for _ in 0..count {
        let encoding = match random.word() {
            word if word >> 29 == 7 && word >> 27 != 0b11100 => word,
            word if random.once_in(2) => word >> 16,
            word => word | 0xE800_0000 | (1 + random.below(3)) << 27,
        };
        if forms::is_wide(encoding) != (encoding >> 16 >= 0xE800) || encoding >> 11 == 0x1F {
            continue;
        }
        match forms::of(encoding) {
            Some(form) if form.is_predictable(encoding) => {
                bits.regular += 1;
                expected += EACH as u64;
                pair.compare(encoding, seed, EACH, &mut findings, |_, _, _| ());
            }
            form => {
                let state = States::of(encoding, seed).next().expect("there is always one more");
                let outcomes = pair.outcomes(encoding, &state);
                bits.irregular(form.map(|form| form.name.as_str()), encoding, &outcomes);
            }
        }
    }
    bits.print();
    Ok(report::finish(&findings, expected, json)? && bits.is_right())
}

/// A mutant is caught where an outcome that is equal to the other core's no longer is.
fn mutants(seed: u64, json: Option<&Path>) -> Result<bool, String> {
    const ENCODINGS: usize = 24;
    const EACH: usize = 64;
    let mut pair = Pair::new();
    let mut random = Random::new(seed ^ 0xB06);
    let mut rows = Vec::new();
    for mutant in mutants::all() {
        let mut row = report::Row::new(mutant.name);
        for form in forms::all().iter().filter(|form| mutant.concerns(form)) {
            row.forms += 1;
            let encodings = if form.is_family() { 4 * ENCODINGS } else { ENCODINGS };
            for encoding in (0..encodings).map(|_| form.sample(&mut random)) {
                for state in States::of(encoding, seed).take(EACH) {
                    let (ours, other) = pair.outcomes(encoding, &state);
                    row.states += 1;
                    let Outcome::Done(after) = &ours else { continue };
                    if judge(Some(form), encoding, &state, &ours, &other) != Verdict::Equal {
                        continue;
                    }
                    let wrong = mutant.apply(form, encoding, &state, after);
                    if wrong == **after {
                        continue;
                    }
                    row.wrong += 1;
                    let frozen = wrong.hash() != after.hash();
                    let wrong = Outcome::Done(Box::new(wrong));
                    let verdict = judge(Some(form), encoding, &state, &wrong, &other);
                    row.caught += u64::from(matches!(verdict, Verdict::Different(_)));
                    row.caught_by_hash += u64::from(frozen);
                }
            }
        }
        rows.push(row);
    }
    report::mutants(&rows, json)
}

fn freeze(elves: &[PathBuf], to: &Path, limit: usize) -> Result<bool, String> {
    let mut by_form: BTreeMap<&str, Vec<(u32, u32)>> = BTreeMap::new();
    for (encoding, count) in encodings(elves)? {
        let Some(form) = forms::of(encoding) else {
            return Err(format!("{encoding:08x} has no form"));
        };
        by_form.entry(&form.name).or_default().push((count, encoding));
    }
    let mut pair = Pair::new();
    let mut random = Random::new(SEED);
    let mut findings = Findings::default();
    let mut kept = Vec::new();
    for form in forms::all() {
        let limit = if form.is_family() { 4 * limit } else { limit };
        // The commonest ones of the ELFs, and at least as many that no compiler may have made.
        let mut common = by_form.remove(form.name.as_str()).unwrap_or_default();
        common.sort_unstable_by(|a, b| b.cmp(a));
        let mut wanted: BTreeSet<u32> =
            common.iter().take(limit / 2).map(|(_, encoding)| *encoding).collect();
        for _ in 0..10 * limit {
            if wanted.len() < limit {
                wanted.insert(form.sample(&mut random));
            }
        }
        for encoding in wanted {
            let mut vector = Vector { encoding, compared: 0, hashes: [0; STATES] };
            pair.compare(encoding, SEED, STATES, &mut findings, |index, verdict, ours| {
                if let (Verdict::Equal, Outcome::Done(after)) = (verdict, ours) {
                    vector.compared |= 1 << index;
                    vector.hashes[index] = after.hash();
                }
            });
            if vector.compared != 0 {
                kept.push(vector);
            }
        }
    }
    if findings.total().different != 0 {
        report::cases(&findings);
        return Err("the cores differ: nothing is kept".to_owned());
    }
    let bytes = vectors::write(&kept);
    let states: u32 = kept.iter().map(|vector| vector.compared.count_ones()).sum();
    println!("{} encodings, {states} states, {} bytes", kept.len(), bytes.len());
    fs::write(to, bytes).map_err(|error| format!("{}: {error}", to.display()))?;
    Ok(true)
}
