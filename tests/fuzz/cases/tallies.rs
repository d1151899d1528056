//! Tallies as the store keeps them: bytes stand for no tally, or for one that survives being written again.

use sagnac::store::Tally;
use sagnac_kernel::moments::Moments;
use sagnac_kernel::rows::Rows;

use super::Outcome;

/// Reads both shapes, as tallies of whatever numbers of trials the bytes could be meant for.
///
/// # Panics
/// A tally does not survive.
pub fn run(bytes: &[u8]) -> Vec<Outcome> {
    let count = leading(bytes);
    let numbers = bytes.iter().filter(|&&byte| byte < 0x80).count() as u64;
    let rows = numbers.saturating_sub(1).checked_div(count).unwrap_or(1);
    let mut outcomes = Vec::new();
    for trials in [count, rows, 0, 1, u64::MAX] {
        outcomes.push(read::<Moments>(bytes, trials, "Moments"));
        outcomes.push(read::<Rows>(bytes, trials, "Rows"));
    }
    outcomes
}

fn read<T: Tally + PartialEq + std::fmt::Debug>(bytes: &[u8], trials: u64, what: &str) -> Outcome {
    match T::decode(bytes, trials) {
        None => Outcome::Refused(what.to_owned()),
        Some(tally) => {
            assert_eq!(T::decode(&tally.encode(), trials), Some(tally), "{trials} trials do not survive");
            Outcome::Accepted(what.to_owned())
        }
    }
}

/// The number that the bytes begin with, of seven bits a byte; 0 where it has more than 64 bits.
fn leading(bytes: &[u8]) -> u64 {
    let length = bytes.iter().position(|&byte| byte < 0x80).map_or(0, |last| last + 1);
    let parts = bytes[..length].iter().rev();
    parts
        .fold(0_u128, |number, byte| (number << 7 | u128::from(byte & 0x7f)).min(u128::MAX >> 7))
        .try_into()
        .unwrap_or(0)
}
