//! Binary formats: a file that was cut off or altered is refused, or gives its samples.
//!
//! Where checksums cover all numbers, those are the samples of the sound file, to the bit. Without one nothing tells an
//! altered number from another; there it is only the structure that is proved: no more numbers change than were altered.

use std::collections::HashSet;
use std::path::Path;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use tempfile::TempDir;

use crate::formats::{BINARIES, Sample, bits};
use crate::limits::within;

/// Number of files that are cut off, and of those that are altered, for each format.
const COUNT: u64 = 500;

/// Most bytes that are altered in a file, and so most samples, if its structure stays.
const MAX_ALTERED: usize = 4;

/// Reads damaged `bytes` within the limits of time and memory.
fn read(sample: &Sample, bytes: &[u8], folder: &Path) -> Option<Vec<Vec<u64>>> {
    let path = folder.join(sample.file);
    std::fs::write(&path, bytes).unwrap();
    let kept = std::env::temp_dir().join(format!("damaged_{}", sample.file));
    within(bytes, kept, || sample.read(&path).ok().map(|log| bits(&log))).0
}

/// Number of samples that a file does not hold; altered times may move samples and leave out others.
fn strangers(found: &[Vec<u64>], expected: &[Vec<u64>]) -> usize {
    let of_column = |(found, expected): (&Vec<u64>, &Vec<u64>)| {
        let known: HashSet<&u64> = expected.iter().collect();
        let missing = f64::NAN.to_bits();
        found.iter().filter(|bits| **bits != missing && !known.contains(bits)).count()
    };
    found.iter().zip(expected).map(of_column).sum()
}

#[test]
fn a_file_that_was_cut_off_is_refused_or_has_lost_no_sample_of_those_it_gives() {
    let folder = TempDir::new().unwrap();
    for (seed, sample) in (1..).zip(&BINARIES) {
        let whole = std::fs::read(sample.path()).unwrap();
        let expected = read(sample, &whole, folder.path()).unwrap();
        let (mut draws, mut given) = (StdRng::seed_from_u64(seed), 0);
        for _ in 0..COUNT {
            let end = draws.random_range(0..whole.len());
            let Some(found) = read(sample, &whole[..end], folder.path()) else { continue };
            given += 1;
            // A raw file may end after any row: it has no length of its own.
            let length = if sample.binary.is_some() { found[0].len() } else { expected[0].len() };
            let expected: Vec<&[u64]> = expected.iter().map(|samples| &samples[..length]).collect();
            assert_eq!(found, expected, "{} cut off after {end} bytes", sample.file);
        }
        println!("{}: {given} of {COUNT} were cut off without a trace", sample.file);
    }
}

#[test]
fn a_file_that_was_altered_is_refused_or_has_the_same_samples() {
    let folder = TempDir::new().unwrap();
    for (seed, sample) in (100..).zip(&BINARIES) {
        let whole = std::fs::read(sample.path()).unwrap();
        let expected = read(sample, &whole, folder.path()).unwrap();
        let (mut draws, mut given, mut other) = (StdRng::seed_from_u64(seed), 0, 0);
        for case in 0..COUNT {
            let mut bytes = whole.clone();
            for _ in 0..1 + draws.random_range(0..MAX_ALTERED) {
                // Half of them where headers are.
                let end = if case % 2 == 0 { whole.len().min(512) } else { whole.len() };
                let at = draws.random_range(0..end);
                bytes[at] = match draws.random_range(0..4) {
                    0 => 0,
                    1 => 0xff,
                    2 => bytes[at] ^ (1 << draws.random_range(0..8)),
                    _ => draws.random_range(0..256) as u8,
                };
            }
            let Some(found) = read(sample, &bytes, folder.path()) else { continue };
            given += 1;
            other += usize::from(found != expected);
            assert!(
                !sample.is_checked || found == expected,
                "{}: another number in case {case}",
                sample.file
            );
            let strangers = strangers(&found, &expected);
            assert!(
                strangers <= MAX_ALTERED,
                "{}: {strangers} numbers that the file does not hold in case {case}",
                sample.file
            );
        }
        println!("{}: {given} of {COUNT} alterations give samples, {other} other ones", sample.file);
    }
}

#[test]
fn a_file_with_removed_or_repeated_bytes_or_other_lengths_is_refused_or_has_the_same_samples() {
    let folder = TempDir::new().unwrap();
    for (seed, sample) in (200..).zip(&BINARIES) {
        let whole = std::fs::read(sample.path()).unwrap();
        let expected = read(sample, &whole, folder.path()).unwrap();
        let (mut draws, mut counts) = (StdRng::seed_from_u64(seed), [[0; 3]; 3]);
        for case in 0..COUNT as usize {
            let mut bytes = whole.clone();
            let at = draws.random_range(0..whole.len());
            let end = whole.len().min(at + 1 + draws.random_range(0..64));
            match case % 3 {
                0 => drop(bytes.drain(at..end)),
                1 => drop(bytes.splice(at..at, whole[at..end].to_vec())),
                _ => {
                    // Half of the words in the first bytes, where lengths are.
                    let at = draws.random_range(
                        0..(if case % 2 == 0 { 512.min(whole.len()) } else { whole.len() }) - 4,
                    );
                    let word = u32::from_le_bytes(whole[at..at + 4].try_into().unwrap());
                    let others = [word.wrapping_add(1), word.wrapping_sub(1), word.wrapping_mul(2), word / 2];
                    bytes[at..at + 4].copy_from_slice(&others[draws.random_range(0..4)].to_le_bytes());
                }
            }
            let found = read(sample, &bytes, folder.path());
            let outcome = match &found {
                None => 0,
                Some(found) if *found == expected => 1,
                Some(_) => 2,
            };
            counts[case % 3][outcome] += 1;
            // Raw files have no length, and words of numbers no checksum.
            let is_told = sample.is_checked || case % 3 < 2 && sample.binary.is_none();
            let strangers = found.map_or(0, |found| strangers(&found, &expected));
            assert!(
                outcome < 2 || !is_told && (strangers <= MAX_ALTERED || case % 3 < 2),
                "{}: {strangers} other numbers in case {case}",
                sample.file
            );
        }
        println!("{}: [refused, same, other] {counts:?}, removed, repeated, lengths", sample.file);
    }
}
