//! Shares: equal parts of a study, for machines that do not communicate.
//!
//! ```
//! use sagnac_engine::tally::share::Share;
//!
//! let shares = [1, 2, 3].map(|number| Share::new(number, 3).unwrap().trials(1_000_000, 0));
//! assert!(shares[0].end == shares[1].start && shares[1].end == shares[2].start && shares[2].end == 1_000_000);
//! assert_eq!("2/3".parse::<Share>()?, Share::new(2, 3).unwrap());
//! # Ok::<(), sagnac_engine::tally::share::ShareError>(())
//! ```

use core::fmt;
use core::ops::Range;
use core::str::FromStr;

/// One of several equal parts of the trials of every point.
///
/// The trials of a share follow from the study alone, so the shares of a study are disjoint, make up the whole, and can
/// be sampled anywhere, in any order and repeatedly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    index: u64,
    of: u64,
}

/// log2 of the parts to which a share's ends are rounded; a sixteenth more or less work costs less than rows of odd
/// lengths.
const GRAIN: u32 = 4;

impl Share {
    /// The whole study.
    pub const WHOLE: Share = Share { index: 0, of: 1 };

    /// The most shares of a study.
    pub const MAX: u64 = 1 << 16;

    /// Share `number` of `of`, counted from 1; `None` where the numbers are out of range.
    pub fn new(number: u64, of: u64) -> Option<Share> {
        ((1..=of).contains(&number) && of <= Share::MAX).then(|| Share { index: number - 1, of })
    }

    /// Number of this share, counted from 1.
    pub fn number(&self) -> u64 {
        self.index + 1
    }

    /// Number of shares.
    pub fn of(&self) -> u64 {
        self.of
    }

    /// Whether the share is the whole study.
    pub fn is_whole(&self) -> bool {
        self.of == 1
    }

    /// Its part of the first `trials` trials of a point, the `turn`th of the study. Points take turns, so that with few
    /// trials of many points all shares get equally many.
    pub fn trials(&self, trials: u64, turn: usize) -> Range<u64> {
        let index = (self.index + turn as u64) % self.of;
        let grain = (trials / self.of).max(1).ilog2().saturating_sub(GRAIN);
        let start = |index: u64| match index {
            index if index == self.of => trials,
            index => {
                ((u128::from(trials) * u128::from(index) / u128::from(self.of)) as u64) >> grain << grain
            }
        };
        start(index)..start(index + 1)
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "share {} of {}", self.number(), self.of)
    }
}

/// The error for a text that names no share.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected I/N, share I of N, from 1/N to N/N with N up to {}", Share::MAX)]
pub struct ShareError;

impl FromStr for Share {
    type Err = ShareError;

    fn from_str(text: &str) -> Result<Share, ShareError> {
        let (number, of) = text.split_once('/').ok_or(ShareError)?;
        let number = number.parse().map_err(|_| ShareError)?;
        Share::new(number, of.parse().map_err(|_| ShareError)?).ok_or(ShareError)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(of: u64) -> impl Iterator<Item = Share> {
        (1..=of).filter_map(move |number| Share::new(number, of))
    }

    #[test]
    fn shares_are_disjoint_and_make_up_the_whole() {
        for of in [1, 2, 7, 64, 1000] {
            for trials in [1, 5, 63, 64, 1000, 1_000_000, (1 << 40) - 1] {
                for turn in [0, 1, 100] {
                    let mut parts: Vec<_> = all(of).map(|share| share.trials(trials, turn)).collect();
                    parts.sort_by_key(|part| (part.start, part.end));
                    let mut at = 0;
                    for part in parts {
                        assert_eq!(part.start, at, "{trials} trials in {of} shares");
                        at = part.end;
                    }
                    assert_eq!(at, trials);
                }
            }
        }
        assert_eq!(Share::WHOLE.trials(1000, 3), 0..1000);
    }

    #[test]
    fn shares_are_equal_but_for_an_eighth_and_points_take_turns() {
        for of in [2, 7, 64] {
            for share in all(of) {
                let part = share.trials(1_000_000, 0);
                let wanted = 1_000_000 / of;
                assert!((part.end - part.start).abs_diff(wanted) <= wanted / 8, "{share}: {part:?}");
                // With 3 trials per point.
                let few: u64 =
                    (0..of as usize).map(|turn| share.trials(3, turn)).map(|t| t.end - t.start).sum();
                assert_eq!(few, 3);
            }
        }
    }

    #[test]
    fn shares_are_written_as_i_of_n() {
        assert_eq!("2/7".parse(), Ok(Share { index: 1, of: 7 }));
        assert_eq!("2/7".parse::<Share>().unwrap().to_string(), "share 2 of 7");
        for text in ["0/4", "5/4", "1/0", "1", "1/4/4", "a/b", "-1/4", "1/65537", "", "/"] {
            assert_eq!(text.parse::<Share>(), Err(ShareError), "{text}");
        }
    }
}
