//! Exact quantiles of any number of values in a bounded memory.
//!
//! The values are kept in a file, and counted by their upper 16 bits as they come. When all of them are
//! there, these counts say between which upper halves a rank lies, and the file is read once more to
//! count the lower halves there: a selection by radix. So the result is a value of the list itself,
//! whatever the order in which the values came.

use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};

use super::estimate::{Estimate, Ranks};

/// The values of one half of a key.
const HALF: usize = 1 << 16;

/// `N` quantities of many runs.
pub(super) struct Quantiles<const N: usize, S: Write> {
    store: BufWriter<S>,
    runs: usize,
    /// Of each quantity, how many values have each upper half.
    upper: [Vec<usize>; N],
}

/// The bits of a number in the order of [`f32::total_cmp`].
const fn key_of(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | (1 << 31) }
}

const fn value_of(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}

/// The place of a rank among counts, and the rank within that place.
fn find(counts: &[usize], rank: usize) -> Option<(usize, usize)> {
    let mut before = 0;
    for (place, count) in counts.iter().enumerate() {
        if rank < before + count {
            return Some((place, rank - before));
        }
        before += count;
    }
    None
}

impl<const N: usize, S: Read + Write + Seek> Quantiles<N, S> {
    /// No values yet; they will be kept in this file.
    pub(super) fn new(store: S) -> Self {
        let upper = std::array::from_fn(|_| vec![0; HALF]);
        Self { store: BufWriter::new(store), runs: 0, upper }
    }

    /// Adds the values of a run.
    pub(super) fn add(&mut self, values: [f32; N]) -> io::Result<()> {
        self.runs += 1;
        for (upper, value) in self.upper.iter_mut().zip(values) {
            let key = key_of(value);
            upper[(key >> 16) as usize] += 1;
            self.store.write_all(&key.to_le_bytes())?;
        }
        Ok(())
    }

    /// The q-quantile of a quantity over all runs; an infinite value counts as such.
    pub(super) fn estimate(&mut self, quantity: usize, q: f64) -> io::Result<Estimate> {
        let ranks = Ranks::of(self.runs, q);
        let mut wanted: Vec<usize> = ranks.all().collect();
        wanted.sort_unstable();
        let values = self.at(quantity, &wanted)?;
        Ok(ranks.estimate(|rank| values[wanted.binary_search(&rank).ok()?]))
    }

    /// The values of a quantity at these places of its sorted list.
    fn at(&mut self, quantity: usize, ranks: &[usize]) -> io::Result<Vec<Option<f32>>> {
        let found: Vec<_> = ranks.iter().map(|rank| find(&self.upper[quantity], *rank)).collect();
        let mut uppers: Vec<usize> = found.iter().flatten().map(|(upper, _)| *upper).collect();
        uppers.dedup();
        let mut lower: Vec<Vec<usize>> = uppers.iter().map(|_| vec![0; HALF]).collect();
        self.each(quantity, |key| {
            if let Ok(n) = uppers.binary_search(&((key >> 16) as usize)) {
                lower[n][key as usize % HALF] += 1;
            }
        })?;
        let value = |(upper, rank): (usize, usize)| {
            let n = uppers.binary_search(&upper).ok()?;
            let (low, _) = find(&lower[n], rank)?;
            Some(value_of((upper * HALF + low) as u32))
        };
        Ok(found.into_iter().map(|found| found.and_then(value)).collect())
    }

    /// Reads all values of a quantity back.
    fn each(&mut self, quantity: usize, mut each: impl FnMut(u32)) -> io::Result<()> {
        self.store.seek(SeekFrom::Start(0))?;
        let mut reader = BufReader::new(self.store.get_mut());
        let mut run = [[0; 4]; N];
        for _ in 0..self.runs {
            reader.read_exact(run.as_flattened_mut())?;
            each(u32::from_le_bytes(run[quantity]));
        }
        self.store.seek(SeekFrom::End(0)).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::super::quantile_of;
    use super::*;

    #[test]
    fn keys_are_in_the_order_of_the_values() {
        let values = [f32::NEG_INFINITY, -2.5, -0.0, 0.0, 1e-40, 0.2, 0.4, f32::INFINITY, f32::NAN];
        assert!(values.windows(2).all(|pair| key_of(pair[0]) < key_of(pair[1])));
        assert!(values.iter().all(|value| value_of(key_of(*value)).to_bits() == value.to_bits()));
    }

    /// Values of both signs, with many equal ones, infinite ones, and neighbours that share their upper
    /// halves; in two orders.
    #[test]
    fn quantiles_are_those_of_the_sorted_list_whatever_the_order() {
        for count in [1_usize, 2, 3, 5, 40, 41, 5_000] {
            let value = |n: usize| match n % 7 {
                0 => f32::INFINITY,
                1 => 12.4,
                2 => -(n as f32),
                _ => 30.0 + (n * 7919 % 1000) as f32 * 1e-4,
            };
            let values: Vec<f32> = (0..count).map(value).collect();
            for order in [values.clone(), values.iter().rev().copied().collect()] {
                let mut quantiles = Quantiles::<2, _>::new(Cursor::new(Vec::new()));
                order.iter().for_each(|value| quantiles.add([0.5, *value]).unwrap());
                for q in [0.5, 0.95, 0.05] {
                    let expected = quantile_of(&values, q, |value| *value);
                    assert_eq!(quantiles.estimate(1, q).unwrap(), expected, "{count}");
                }
                assert_eq!(quantiles.estimate(0, 0.5).unwrap().value, 0.5);
            }
        }
    }
}
