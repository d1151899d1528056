//! Tallies as the store keeps them: bytes stand for no tally, or for one that survives being written again.

use proptest::collection::vec;
use proptest::prelude::*;
use sagnac::store::Tally;
use sagnac_kernel::moments::{BINS, Moments};
use sagnac_kernel::rows::Rows;

use crate::campaign::{Target, fuzz};
use crate::cases::tallies::run;
use crate::edits::{apply, edits};

const TARGET: Target = Target { name: "tallies", ending: "bin", run };

#[test]
fn tallies() {
    let whole = tally();
    let edited = (tally(), edits(3, &["\0", "\u{1}", "\u{7f}"])).prop_map(|(mut bytes, edits)| {
        apply(&mut bytes, &edits);
        bytes
    });
    fuzz(&TARGET, prop_oneof![1 => vec(any::<u8>(), 0..64), 2 => whole, 4 => edited]);
}

/// The bytes of a tally, which is checked to come back from them.
fn tally() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        moments().prop_map(|tally| written(&tally, tally.count)),
        rows().prop_map(|rows| written(&rows, rows.trials() as u64)),
    ]
}

fn written<T: Tally + PartialEq + std::fmt::Debug>(tally: &T, trials: u64) -> Vec<u8> {
    let bytes = tally.encode();
    assert_eq!(T::decode(&bytes, trials).as_ref(), Some(tally), "it does not come back from its bytes");
    bytes
}

fn moments() -> impl Strategy<Value = Moments> {
    let bins = vec((0..BINS, number(64)), 0..20);
    (bins, any::<bool>(), number(128), number(128), any::<i32>(), any::<i32>()).prop_map(
        |(filled, is_negative, sum, square, least, greatest)| {
            let mut tally = Moments::empty(true);
            for (bin, count) in filled {
                let count = (count as u64).min(u64::MAX - tally.count);
                tally.bins[bin] += count;
                tally.count += count;
            }
            let sum = (sum >> 1).cast_signed();
            Moments { sum: if is_negative { !sum } else { sum }, square, least, greatest, ..tally }
        },
    )
}

fn rows() -> impl Strategy<Value = Rows> {
    (1_usize..40).prop_flat_map(|width| {
        vec(number(128), 0..200).prop_map(move |mut values| {
            values.truncate(values.len() / width * width);
            Rows { width, values }
        })
    })
}

/// Numbers of any length up to so many bits.
fn number(bits: u32) -> impl Strategy<Value = u128> {
    (any::<u128>(), 0..=bits).prop_map(|(number, bits)| number.checked_shr(128 - bits).unwrap_or(0))
}
