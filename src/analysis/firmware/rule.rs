//! The integer rule: integer weights on ticks, and the rounding of their sums.

use sagnac_engine::kinds::gap_fill::lower::fixed::Rows;
use sagnac_theory::gap::Weights;

/// Weights that give the lost ticks from others, as 32-bit integers over a denominator.
///
/// With S_j the sum of w·P over the rows 1 … j and R_j = ⌊S_j/D + ½⌋, the value of lost tick j is R_j − R_(j−1).
/// Rounding the running sum instead of each value keeps the angle within half a unit of the exact one throughout the
/// gap, whatever its length, as in a gyro that counts whole pulses. Halves are rounded up, towards +∞.
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Ticks that are read, ascending.
    pub ticks: Vec<i32>,
    /// A row of numerators for each lost tick, or a single row for their sum where the filler defines no more.
    pub rows: Vec<Vec<i32>>,
    /// Denominator D, positive.
    pub denominator: i32,
    /// Whether the fractions are the exact weights instead of the nearest ones over a power of two.
    pub exact: bool,
}

impl Rule {
    /// Makes the rule; `None` where a number needs more than 32 bits.
    pub(crate) fn new(rows: &Rows) -> Option<Rule> {
        let word = |w: &i64| i32::try_from(*w).ok();
        let words = |row: &Vec<i64>| row.iter().map(word).collect::<Option<Vec<_>>>();
        Some(Rule {
            ticks: rows.ticks.clone(),
            rows: rows.numerators.iter().map(words).collect::<Option<_>>()?,
            denominator: word(&rows.denominator)?,
            exact: rows.exact,
        })
    }

    /// The weights of the whole gap: the sum of the rows, over the same denominator.
    pub fn whole(&self) -> Weights {
        let of = |k: usize| self.rows.iter().map(|row| i64::from(row[k])).sum();
        Weights {
            ticks: self.ticks.clone(),
            numerators: (0..self.ticks.len()).map(of).collect(),
            denominator: i64::from(self.denominator),
        }
    }

    /// The mean square of what rounding the sum over the gap to a whole number adds, in units of the inputs: all remainders
    /// of the reduced weights are equally likely.
    pub(crate) fn rounding(&self) -> f64 {
        let whole = self.whole();
        let gcd = |a: i64, b: i64| {
            let (mut a, mut b) = (a.abs(), b.abs());
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        let common = whole.numerators.iter().fold(whole.denominator, |common, &w| gcd(common, w));
        let parts = (whole.denominator / common.max(1)) as f64;
        // Of an even number of parts one is a half, which is rounded up.
        let end = if whole.denominator / common.max(1) % 2 == 0 { 2.0 } else { -1.0 };
        (1.0 + end / (parts * parts)) / 12.0
    }

    /// The largest |P| for which every sum fits 63 bits, so that every difference of two fits 64; smaller inputs fit as
    /// well.
    pub fn largest_input(&self) -> i32 {
        let gain: i64 = self.rows.iter().flatten().map(|w| i64::from(*w).abs()).sum();
        let room = i64::MAX / 2 - i64::from(self.denominator);
        i32::try_from(room / gain.max(1)).unwrap_or(i32::MAX)
    }

    /// The lost ticks, or only their sum where the rule has a single row, from `inputs` on its ticks, which must be
    /// within [`Rule::largest_input`].
    pub fn fill(&self, inputs: &[i32]) -> Vec<i64> {
        let denominator = i128::from(self.denominator);
        let (mut sum, mut filled) = (0_i128, 0_i64);
        let value = |row: &Vec<i32>| {
            sum += row.iter().zip(inputs).map(|(w, p)| i128::from(*w) * i128::from(*p)).sum::<i128>();
            // Such inputs stay within 63 bits.
            let rounded = (sum + denominator / 2).div_euclid(denominator) as i64;
            let value = rounded - filled;
            filled = rounded;
            value
        };
        self.rows.iter().map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(rows: &[&[i32]], denominator: i32) -> Rule {
        let ticks = (0..rows[0].len() as i32).map(|k| k - 3).collect();
        Rule { ticks, rows: rows.iter().map(|row| row.to_vec()).collect(), denominator, exact: true }
    }

    #[test]
    fn halves_go_up_on_both_sides_of_0() {
        let half = rule(&[&[1]], 2);
        let found: Vec<i64> = [-5, -3, -2, -1, 0, 1, 3].map(|p| half.fill(&[p])[0]).into();
        assert_eq!(found, [-2, -1, -1, 0, 0, 1, 2]);
        let third = rule(&[&[1]], 3);
        let found: Vec<i64> = (-5..=5).map(|p| third.fill(&[p])[0]).collect();
        assert_eq!(found, [-2, -1, -1, -1, 0, 0, 0, 1, 1, 1, 2]);
    }

    #[test]
    fn rounding_does_not_add_up_over_the_gap() {
        let thirds = rule(&[&[1][..]; 60], 3);
        for p in -20..=20 {
            let values = thirds.fill(&[p]);
            let mut sum = 0;
            for (j, value) in (1..).zip(&values) {
                sum += value;
                assert!((3 * sum - j * i64::from(p)).abs() * 2 <= 3, "P = {p}, tick {j}: {sum}");
            }
            assert_eq!(sum, 20 * i64::from(p));
        }
    }

    #[test]
    fn the_mean_square_of_rounding_is_that_of_all_remainders() {
        for (row, denominator) in [([3], 7), ([5], 8), ([2], 8), ([4], 2), ([1], 1)] {
            let rule = rule(&[&row], denominator);
            let error = |p: i32| {
                let exact = f64::from(p * row[0]) / f64::from(denominator);
                (rule.fill(&[p])[0] as f64 - exact).powi(2)
            };
            let mean = (0..denominator).map(error).sum::<f64>() / f64::from(denominator);
            assert!(
                (rule.rounding() - mean).abs() < 1e-12,
                "{row:?}/{denominator}: {} {mean}",
                rule.rounding()
            );
        }
    }

    #[test]
    fn the_largest_input_is_the_last_that_leaves_room_for_differences() {
        assert_eq!(rule(&[&[-20, 50, 50, -20]], 20).largest_input(), i32::MAX);
        let large = rule(&[&[i32::MAX; 4], &[i32::MAX; 4]], 1 << 30);
        let most = i128::from(large.largest_input());
        let sum = |p: i128| 8 * i128::from(i32::MAX) * p + (1 << 30);
        let room = i128::from(i64::MAX / 2);
        assert!(sum(most) <= room && sum(most + 1) > room, "{most}");
    }
}
