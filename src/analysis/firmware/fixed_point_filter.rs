//! Fillers in integers: weights, memory, and the response to a vibration.

use crate::analysis::firmware::design::{Firmware, Mark, response};
use sagnac_base::quantity::number::significant;
use sagnac_engine::filler::read::Error;
use sagnac_engine::filler::{Fill, Filler, LISTED, Method};
use sagnac_engine::kinds::gap_fill::lower::fixed::Rows;
use sagnac_report::chart::figure::{Axis, Entry, Figure, Grouping, Law, Series, SeriesPoint};
use sagnac_report::chart::palette::of_names;
use sagnac_theory::gap::{Weights, greatest_common_divisor};

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

/// The greatest common divisor.
pub(crate) fn common_divisor(a: i64, b: i64) -> i64 {
    greatest_common_divisor(a.into(), b.into()) as i64
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
        let common = whole.numerators.iter().fold(whole.denominator, |common, &w| common_divisor(common, w));
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

/// Bytes of a number of ticks or weights, `int32_t`.
const WORD: u64 = 4;
/// Bytes of a filled tick and of the angle delivered over the gap, `int64_t`.
const LONG: u64 = 8;
/// Bytes of a `sagnac_rule`: four words and two pointers of 4 bytes, as on 32-bit processors.
const RULE: u64 = 24;

/// The memory of a filler, bytes.
///
/// It is that of one filler of the C header on a processor with pointers of 4 bytes. Code and the history of ticks
/// that firmware keeps anyway are not part of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Constants: the ticks and weights of both rules, and the `sagnac_filler` that points at them.
    pub constants: u64,
    /// State during a switch: the ticks `p` that each rule reads, the numbers `E` and `I` that it fills, and the sum `e`.
    pub state: u64,
}

impl Memory {
    /// The memory of a filler that reads these ticks, at a gap of `gap_ticks`.
    pub fn of_filler(filler: &Filler, fill: &Fill, gap_ticks: u32) -> Memory {
        let rows = match filler.method {
            Method::Closed(_) | Method::MinimumVariance(_) => u64::from(gap_ticks),
            // Given weights are those of the sum alone.
            Method::Weights { .. } => 1,
        };
        let rules = [Some(&fill.fit_ticks), fill.extrapolation_ticks.as_ref()];
        let counts = rules.into_iter().flatten().map(|ticks| ticks.len() as u64);
        let start = Memory { constants: 2 * RULE, state: LONG };
        counts.fold(start, |memory, ticks| Memory {
            constants: memory.constants + WORD * ticks * (1 + rows),
            state: memory.state + WORD * ticks + LONG * rows,
        })
    }

    /// All of it, bytes.
    pub fn bytes(self) -> u64 {
        self.constants + self.state
    }
}

/// Decades below the Nyquist frequency at which the chart begins, which is 1 Hz for ticks of 5 ms. Below it the errors
/// fall on straight lines.
const DECADES: f64 = 2.0;
/// Upper end of the chart relative to the highest frequency of a specification.
const BEYOND: f64 = 1.25;
/// Steps of a curve and of its markers.
const STEPS: usize = 720;
const MARKER_STEPS: usize = 60;
/// Lower end of the chart relative to the angle of the gap at a constant rate; smaller errors are lost in any noise.
const MIN_RELATIVE: f64 = 1e-4;

/// The styles of fillers, which are those of other charts.
fn styles_of(names: &[String]) -> Vec<usize> {
    let mut sorted = names.to_vec();
    sorted.sort_unstable();
    let styles = of_names(LISTED, &sorted);
    names.iter().filter_map(|name| Some(styles[sorted.binary_search(name).ok()?])).collect()
}

impl Firmware {
    /// The amplitude of the error per amplitude of the rate as a function of the vibration frequency, up to half the
    /// tick rate or beyond what is specified: a colour for each filler, solid for the residual and dashed for the
    /// extrapolation. The chart also has the angle of the gap itself, which is the error without any filler, and the
    /// frequency of a motion that is a single tone, or the lines and bands of a specification.
    pub fn response(&self) -> Figure {
        let tick_s = self.tick_s.unwrap_or(1.0);
        let nyquist = 0.5 / tick_s;
        let beyond = if self.shift.is_none() { BEYOND } else { 0.0 };
        let top = self.marks.iter().map(|mark| beyond * mark.ends_hz[1]).fold(nyquist, f64::max);
        let decades = DECADES + libm::log10(top / nyquist);
        let frequency = |i: usize| top * libm::pow(10.0, decades * (i as f64 / STEPS as f64 - 1.0));
        let of = |weights: &Weights, nu: f64| response(weights, self.gap_ticks, tick_s, nu);
        let mut series = Vec::new();
        let names: Vec<String> = self.designs.iter().map(|design| design.name.clone()).collect();
        let styles = styles_of(&names);
        for (&colour, design) in styles.iter().zip(&self.designs) {
            for (error, rule, _) in design.rules() {
                let weights = rule.whole();
                let point = |i: usize| SeriesPoint::new(frequency(i), of(&weights, frequency(i)));
                let visible =
                    |point: &SeriesPoint| point.y >= MIN_RELATIVE * tick_s * f64::from(self.gap_ticks);
                series.push(Series {
                    colour,
                    dash: usize::from(error == Error::Extrapolation),
                    points: (0..=STEPS).step_by(MARKER_STEPS).map(point).filter(visible).collect(),
                    law: (0..=STEPS).map(|i| (frequency(i), of(&weights, frequency(i)))).collect(),
                });
            }
        }
        let nothing = Weights { ticks: vec![], numerators: vec![], denominator: 1 };
        let gap = (0..=STEPS).map(|i| (frequency(i), of(&nothing, frequency(i)))).collect();
        let mut laws = vec![Law::line("the gap itself, not filled".to_owned(), gap)];
        let markers = || series.iter().flat_map(|series| &series.points).map(|point| point.y);
        let curves = series.iter().flat_map(|series| &series.law).map(|place| place.1);
        // The lower end of the axis, which for curves is a decade below the markers.
        let low = curves.fold(f64::INFINITY, f64::min).max(0.1 * markers().fold(f64::INFINITY, f64::min));
        let high = markers().fold(0.0, f64::max);
        for Mark { name, ends_hz: [from, to] } in &self.marks {
            if *to < frequency(0) || *from > top {
                continue;
            }
            let [begin, end] = [from, to].map(|nu| significant(*nu, 4));
            let (label, places) = match from == to {
                true => (format!("{name}, {begin} Hz"), vec![(*from, low), (*from, high)]),
                false => {
                    let from = from.max(frequency(0));
                    let places = vec![(from, low), (from, high), (*to, high), (*to, low)];
                    (format!("{name}, {begin} to {end} Hz"), places)
                }
            };
            laws.push(Law::line(label, places));
        }
        let entries = names.into_iter().zip(styles).map(|(name, style)| Entry { style, name });
        let extrapolates = self.designs.iter().any(|design| design.extrapolation.is_some());
        let errors: &[Error] =
            if extrapolates { &[Error::Residual, Error::Extrapolation] } else { &[Error::Residual] };
        let errors = errors.iter().map(|error| error.name().to_owned());
        let (frequency_unit, error_unit) = if self.tick_s.is_some() {
            ("Hz", "″ per ″/s")
        } else {
            ("cycles per tick", "″ per ″ a tick")
        };
        let mut figure = Figure {
            title: format!("Response to vibration of a gap of {}", self.ticks("tick")),
            subtitle: Some(self.title.clone()),
            x: Axis::new("vibration frequency", frequency_unit),
            y: Axis::new("error amplitude per rate amplitude", error_unit),
            colours: Grouping { title: "filler".to_owned(), entries: entries.collect() },
            dashes: Grouping::new("error", errors),
            lines: "closed form".to_owned(),
            series,
            laws,
            ..Figure::default()
        };
        figure.merge_coincident();
        figure
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
