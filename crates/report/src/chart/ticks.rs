//! Ticks at round numbers, with their labels.
//!
//! A tick is `count · 10^exponent` with integers, so that its label is exact and never 0.30000000000000004.

use serde::Serialize;

use crate::chart::axis::{Range, Scale};

/// The ticks of one axis.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Ticks {
    /// Ticks with a label.
    pub major: Vec<(f64, String)>,
    /// Ticks without a label.
    pub minor: Vec<f64>,
}

impl Ticks {
    /// Removes ticks that are not at whole numbers.
    pub fn keep_whole(&mut self) {
        self.major.retain(|(value, _)| value.fract() == 0.0);
        self.minor.retain(|value| value.fract() == 0.0);
    }
}

/// What the distances between even ticks are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Steps {
    /// 1, 2 and 5 times powers of ten.
    Decimal,
    /// Above 10°, the half of a right angle, a right angle, a half turn and a whole one.
    Phase,
    /// Seconds, minutes, hours and days on a logarithmic axis.
    Time,
}

impl Steps {
    /// The least distance that is at least `least`.
    fn step(self, least: f64) -> Decimal {
        let of_turn = [45, 90, 180, 360].into_iter().find(|&count| least <= count as f64 + 1e-9);
        match (self, of_turn) {
            (Steps::Phase, Some(count)) if least > 10.0 => Decimal { count, exponent: 0 },
            _ => Decimal::step(least),
        }
    }
}

/// The number `count · 10^exponent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Decimal {
    count: i64,
    exponent: i32,
}

/// The ticks of a whole axis and of its parts.
#[derive(Debug, Clone, Serialize)]
pub struct Ladder {
    /// Ticks by powers of ten, the best first; empty for a linear axis.
    levels: Vec<Ticks>,
    /// Even distances between ticks, rising.
    steps: Vec<Step>,
    /// Between these sizes labels are written in full.
    in_full: [f64; 2],
}

/// Ticks at even distances, with the format of their labels: multiples of `shown` with a number of decimals, and a
/// power of ten.
#[derive(Debug, Clone, Serialize)]
struct Step {
    step: f64,
    shown: f64,
    decimals: usize,
    power: String,
}

impl Step {
    /// The labels of multiples of `step` up to `largest`.
    fn new(step: Decimal, largest: f64) -> Step {
        let power = power_of(largest);
        let shown = Decimal { exponent: step.exponent - power, ..step };
        let suffix = if power == 0 { String::new() } else { format!("·10{}", superscript(power)) };
        Step { step: step.value(), shown: shown.value(), decimals: shown.decimals(), power: suffix }
    }
}

impl Decimal {
    /// The least of 1, 2 and 5 times a power of ten that is at least `least`.
    fn step(least: f64) -> Decimal {
        let exponent = libm::floor(libm::log10(least)) as i32;
        let leading = least / Decimal { count: 1, exponent }.value();
        match [1, 2, 5].into_iter().find(|&count| leading <= count as f64 + 1e-9) {
            Some(count) => Decimal { count, exponent },
            None => Decimal { count: 1, exponent: exponent + 1 },
        }
    }

    /// The step of the ticks without labels between those of this step.
    fn minor(self) -> Decimal {
        match self.count {
            1 => Decimal { count: 2, exponent: self.exponent - 1 },
            2 => Decimal { count: 5, exponent: self.exponent - 1 },
            45 => Decimal { count: 15, ..self },
            90 | 180 | 360 => Decimal { count: 45, ..self },
            _ => Decimal { count: 1, ..self },
        }
    }

    /// Number of decimals needed to write it in full.
    fn decimals(self) -> usize {
        (-self.exponent).max(0) as usize
    }

    /// The nearest f64, converted through text, which rounds correctly on every machine.
    fn value(self) -> f64 {
        format!("{}e{}", self.count, self.exponent).parse().unwrap_or(f64::NAN)
    }
}

impl Range {
    /// Ticks inside the range, with at most about `most` labels.
    pub fn ticks(&self, most: usize, steps: Steps) -> Ticks {
        match self.scale {
            Scale::Log => self.log_ticks(most, steps),
            Scale::Linear => self.linear_ticks(most, steps),
        }
    }

    fn holds(&self, tick: Decimal) -> bool {
        (-1e-9..=1.0 + 1e-9).contains(&self.fraction(tick.value()))
    }

    fn log_ticks(&self, most: usize, steps: Steps) -> Ticks {
        let suits = |ticks: &Ticks| (3..=most).contains(&ticks.major.len()) && self.is_spread(ticks);
        let even = |most: usize| self.linear_ticks(most, Steps::Decimal);
        let of_even =
            || Some(even(most)).filter(|ticks| ticks.major.len() > 2).unwrap_or_else(|| even(2 * most));
        self.log_levels(steps).into_iter().find(suits).unwrap_or_else(of_even)
    }

    /// Whether labels leave no more than three fifths of the axis without one.
    fn is_spread(&self, ticks: &Ticks) -> bool {
        let labelled = ticks.major.iter().map(|(value, _)| self.fraction(*value));
        let places: Vec<f64> = [0.0].into_iter().chain(labelled).chain([1.0]).collect();
        places.windows(2).all(|pair| pair[1] - pair[0] <= 0.6)
    }

    /// Ticks of a logarithmic axis: all decades, some of them, some digits of each, or every digit. The first with at least
    /// three labels that are spread over the axis, but not too many, are the best. If there are none, ticks at even distances
    /// are used.
    fn log_levels(&self, steps: Steps) -> Vec<Ticks> {
        if steps == Steps::Time {
            return TIMES.map(|times| self.times(times)).into();
        }
        let [first, last] = [self.low, self.high].map(|end| libm::floor(libm::log10(end)) as i32);
        let digits = |digits: &[i64]| -> Vec<Decimal> {
            let all = (first..=last)
                .flat_map(|exponent| digits.iter().map(move |&count| Decimal { count, exponent }));
            all.filter(|tick| self.holds(*tick)).collect()
        };
        let (decades, every) = (digits(&[1]), digits(&[1, 2, 3, 4, 5, 6, 7, 8, 9]));
        let strided = |(stride, first): (i32, i32)| -> Vec<Decimal> {
            decades.iter().copied().filter(|tick| tick.exponent.rem_euclid(stride) == first).collect()
        };
        let widest = (decades.len() / 2).max(1) as i32;
        // Few labels of a short axis may need another first one.
        let offsets =
            |stride: i32| (0..if stride <= 3 { stride } else { 1 }).map(move |first| (stride, first));
        let mut levels = vec![labelled_log(&decades, &every)];
        levels.extend((2..=widest).flat_map(offsets).map(|stride| labelled_log(&strided(stride), &decades)));
        let some = DIGITS.iter().map(|labels| digits(labels));
        levels.extend(
            some.chain([every.clone(), digits(&[1, 2, 3, 4, 6, 8])])
                .map(|labels| labelled_log(&labels, &every)),
        );
        levels
    }

    /// Labelled times, and all times without a label.
    fn times(&self, labelled: &[(f64, &str)]) -> Ticks {
        let held = |seconds: &f64| (0.0..=1.0).contains(&self.fraction(*seconds));
        let all = TIMES.iter().flat_map(|times| times.iter().map(|(seconds, _)| *seconds)).filter(held);
        let major: Vec<(f64, String)> = labelled
            .iter()
            .map(|&(seconds, label)| (seconds, label.to_owned()))
            .filter(|(seconds, _)| held(seconds))
            .collect();
        let minor = all.filter(|seconds| major.iter().all(|(other, _)| other != seconds)).collect();
        Ticks { major, minor }
    }

    fn linear_ticks(&self, most: usize, steps: Steps) -> Ticks {
        let major = steps.step((self.high / most as f64) - (self.low / most as f64));
        let labels = linear_labels(&self.multiples(major));
        Ticks { minor: without(&self.multiples(major.minor()), &labels), major: labels }
    }

    /// All ticks that parts of the range and its surroundings may have; only at whole numbers if the axis counts.
    pub fn ladder(&self, whole: bool, of: Steps) -> Ladder {
        /// Factor by which a reader may go beyond a logarithmic axis.
        const BEYOND: f64 = 100.0;
        let wider = Range { low: self.low / BEYOND, high: self.high * BEYOND, ..*self };
        let mut levels = if self.scale == Scale::Log { wider.log_levels(of) } else { vec![] };
        if whole {
            levels.iter_mut().for_each(Ticks::keep_whole);
        }
        let largest = self.low.abs().max(self.high.abs());
        // Down to a thousandth of the axis; on a logarithmic axis small values have as much room as large ones.
        let smallest = if self.scale == Scale::Log { self.low } else { self.high - self.low };
        let least = 1e-3 * smallest;
        let mut step = of.step(if whole { least.max(1.0) } else { least });
        let mut steps = vec![];
        while steps.is_empty() || step.value() < self.high - self.low {
            // A logarithmic axis has even distances only within less than a decade.
            let shown = if self.scale == Scale::Log { largest.min(30.0 * step.value()) } else { largest };
            let mut next = Step::new(step, shown);
            if of == Steps::Time {
                next.power += " s";
            }
            steps.push(next);
            step = of.step(1.001 * step.value());
        }
        // Times have their labels on each axis.
        let in_full = if of == Steps::Time { [1.0, 0.0] } else { IN_FULL };
        Ladder { levels, steps, in_full }
    }

    /// The multiples of `step` inside the range.
    fn multiples(&self, step: Decimal) -> Vec<Decimal> {
        let first = libm::floor(self.low / step.value()) as i64;
        let last = libm::ceil(self.high / step.value()) as i64;
        let all = (first..=last).map(|i| Decimal { count: i.saturating_mul(step.count), ..step });
        all.filter(|tick| self.holds(*tick)).collect()
    }
}

/// Times that are labelled together, the most usual first.
const TIMES: [&[(f64, &str)]; 3] = [
    &[
        (60.0, "1 min"),
        (900.0, "15 min"),
        (3600.0, "1 h"),
        (36e3, "10 h"),
        (86_400.0, "1 d"),
        (864e3, "10 d"),
        (864e4, "100 d"),
        (864e5, "1000 d"),
    ],
    &[
        (60.0, "1 min"),
        (600.0, "10 min"),
        (3600.0, "1 h"),
        (86_400.0, "1 d"),
        (864e3, "10 d"),
        (864e4, "100 d"),
        (864e5, "1000 d"),
    ],
    &[
        (60.0, "1 min"),
        (120.0, "2 min"),
        (300.0, "5 min"),
        (600.0, "10 min"),
        (1200.0, "20 min"),
        (1800.0, "30 min"),
        (3600.0, "1 h"),
        (7200.0, "2 h"),
        (14_400.0, "4 h"),
        (28_800.0, "8 h"),
        (57_600.0, "16 h"),
        (115_200.0, "32 h"),
    ],
];

/// Digits of each decade that are labelled together, the most usual first.
const DIGITS: [&[i64]; 5] = [&[1, 2, 5], &[1, 3], &[1, 2, 3, 5], &[1, 2, 4, 7], &[1, 5]];

/// The values of `all` without a label.
fn without(all: &[Decimal], labelled: &[(f64, String)]) -> Vec<f64> {
    let values = all.iter().map(|tick| tick.value());
    values
        .filter(|value| labelled.iter().all(|(label, _)| (label - value).abs() > 1e-9 * value.abs()))
        .collect()
}

/// Sizes of labels that are easier to read in full than as powers of ten.
const IN_FULL: [f64; 2] = [1e-3 * (1.0 - 1e-9), 1e5 * (1.0 + 1e-9)];

fn plain(size: f64) -> bool {
    size == 0.0 || (IN_FULL[0]..=IN_FULL[1]).contains(&size)
}

/// Labels in a common format: in full where that suits all of them, else as powers of ten.
fn labelled_log(labels: &[Decimal], all: &[Decimal]) -> Ticks {
    let in_full = labels.iter().all(|tick| plain(tick.value()));
    let text = |tick: Decimal| match (tick.count, tick.exponent) {
        (_, exponent) if in_full => format!("{:.*}", (-exponent).max(0) as usize, tick.value()),
        (count, exponent @ (0 | 1)) => format!("{count}{}", "0".repeat(exponent as usize)),
        (1, exponent) => format!("10{}", superscript(exponent)),
        (count, exponent) => format!("{count}·10{}", superscript(exponent)),
    };
    let major: Vec<_> = labels.iter().map(|&tick| (tick.value(), text(tick))).collect();
    Ticks { minor: without(all, &major), major }
}

/// The power of ten by which labels up to `largest` are divided.
fn power_of(largest: f64) -> i32 {
    if plain(largest) { 0 } else { libm::floor(libm::log10(largest) + 1e-9) as i32 }
}

/// Labels with the decimals of their step, with a common power of ten where the numbers are unwieldy.
fn linear_labels(labels: &[Decimal]) -> Vec<(f64, String)> {
    let largest = labels.iter().map(|tick| tick.value().abs()).fold(0.0, f64::max);
    let power = power_of(largest);
    let text = |tick: Decimal| {
        let shown = Decimal { exponent: tick.exponent - power, ..tick };
        let number = format!("{:.*}", shown.decimals(), shown.value()).replace('-', "−");
        match (tick.count, power) {
            (0, _) => "0".to_owned(),
            (_, 0) => number,
            _ => format!("{number}·10{}", superscript(power)),
        }
    };
    labels.iter().map(|&tick| (tick.value(), text(tick))).collect()
}

/// The signs of exponents with their plain forms.
pub fn raised_signs() -> impl Iterator<Item = (char, char)> {
    "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺".chars().zip("0123456789-+".chars())
}

/// An exponent in superscript digits.
pub fn superscript(exponent: i32) -> String {
    let raised = |figure| raised_signs().find(|(_, plain)| *plain == figure).map(|(raised, _)| raised);
    exponent.to_string().chars().filter_map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, low: f64, high: f64) -> Vec<String> {
        Range { scale, low, high }
            .ticks(9, Steps::Decimal)
            .major
            .into_iter()
            .map(|(_, label)| label)
            .collect()
    }

    #[test]
    fn decades_are_labelled_in_full_and_have_minor_ticks_at_2_to_9() {
        let ticks = Range { scale: Scale::Log, low: 0.01, high: 100.0 }.ticks(9, Steps::Decimal);
        let labels: Vec<_> = ticks.major.iter().map(|(_, label)| label.as_str()).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(ticks.minor.len(), 4 * 8);
        assert_eq!(ticks.minor[..8], [0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09]);
    }

    #[test]
    fn under_two_decades_2_and_5_are_labelled_too_and_under_half_a_decade_round_numbers() {
        assert_eq!(labels(Scale::Log, 0.009, 0.45), ["0.01", "0.02", "0.05", "0.1", "0.2"]);
        assert_eq!(labels(Scale::Log, 3.0, 9.5), ["3", "4", "5", "6", "7", "8", "9"]);
        assert_eq!(labels(Scale::Log, 11.0, 19.0), ["11", "12", "13", "14", "15", "16", "17", "18", "19"]);
    }

    #[test]
    fn many_decades_are_labelled_as_powers_with_an_even_stride() {
        assert_eq!(
            labels(Scale::Log, 1e-6, 200.0),
            ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1", "10", "10²"]
        );
        let ticks = Range { scale: Scale::Log, low: 1e-12, high: 1e12 }.ticks(9, Steps::Decimal);
        let shown: Vec<_> = ticks.major.iter().map(|(_, label)| label.as_str()).collect();
        assert_eq!(shown, ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "1", "10³", "10⁶", "10⁹", "10¹²"]);
        assert_eq!(ticks.minor.len(), 16);
    }

    #[test]
    fn linear_labels_have_the_decimals_of_their_step() {
        assert_eq!(labels(Scale::Linear, 0.0, 1.05), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(
            labels(Scale::Linear, -10.0, 35.0),
            ["−10", "−5", "0", "5", "10", "15", "20", "25", "30", "35"]
        );
        assert_eq!(labels(Scale::Linear, 0.0, 2.5e6)[1..3], ["0.5·10⁶", "1.0·10⁶"]);
        assert_eq!(labels(Scale::Linear, 1e-7, 1.4e-7)[0], "1.00·10⁻⁷");
    }

    #[test]
    fn phases_have_ticks_at_parts_of_a_turn() {
        let labels = |low: f64, high: f64| -> Vec<String> {
            let ticks = Range { scale: Scale::Linear, low, high }.ticks(9, Steps::Phase);
            ticks.major.into_iter().map(|(_, label)| label).collect()
        };
        assert_eq!(labels(-185.0, 5.0), ["−180", "−135", "−90", "−45", "0"]);
        assert_eq!(labels(-180.0, 360.0), ["−180", "−90", "0", "90", "180", "270", "360"]);
        assert_eq!(labels(0.0, 40.0), ["0", "5", "10", "15", "20", "25", "30", "35", "40"]);
        let ladder = Range { scale: Scale::Linear, low: -185.0, high: 5.0 }.ladder(false, Steps::Phase);
        let last = ladder.steps[ladder.steps.len() - 3..].iter().map(|step| step.step);
        assert_eq!(last.collect::<Vec<_>>(), [45.0, 90.0, 180.0]);
    }

    #[test]
    fn a_ladder_has_the_steps_of_every_part_of_an_axis() {
        let ladder = Range { scale: Scale::Linear, low: 0.0, high: 1.05 }.ladder(false, Steps::Decimal);
        assert!(ladder.levels.is_empty());
        let written = |step: &Step| format!("{:.*}{}", step.decimals, 3.0 * step.shown, step.power);
        let shown: Vec<String> = ladder.steps.iter().map(written).collect();
        assert_eq!(shown[..4], ["0.006", "0.015", "0.03", "0.06"]);
        assert_eq!(shown.last().map(String::as_str), Some("3"));
        let ladder = Range { scale: Scale::Linear, low: 0.0, high: 2.5e6 }.ladder(false, Steps::Decimal);
        assert_eq!(written(ladder.steps.last().unwrap()), "6·10⁶");
        let ladder = Range { scale: Scale::Log, low: 0.01, high: 100.0 }.ladder(false, Steps::Decimal);
        assert_eq!(ladder.levels[0].major.len(), 9, "two decades beyond either end");
        assert!(ladder.steps[0].step <= 1e-5 && ladder.steps.last().unwrap().step >= 50.0);
    }

    #[test]
    fn every_range_has_few_distinct_ticks_inside_it() {
        for exponent in (-240..=240).step_by(24) {
            for width in [1.0000001, 1.1, 1.7, 4.0, 30.0, 1e3, 1e9] {
                for scale in [Scale::Log, Scale::Linear] {
                    let low = Decimal { count: 3, exponent }.value();
                    let range = Range { scale, low, high: low * width };
                    let ticks = range.ticks(9, Steps::Decimal);
                    assert!((2..=12).contains(&ticks.major.len()), "{range:?}: {:?}", ticks.major);
                    assert!(ticks.major.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 != w[1].1), "{ticks:?}");
                    assert!(ticks.minor.len() <= 100, "{range:?}: {} minor ticks", ticks.minor.len());
                }
            }
        }
    }

    #[test]
    fn log_axes_of_half_a_decade_and_more_have_three_labels_that_are_spread_even_on_phones() {
        let widths = (0..40).flat_map(|start| (1..400).map(move |width| [start, width].map(f64::from)));
        for (most, [start, width]) in (5..=9).flat_map(|most| widths.clone().map(move |each| (most, each))) {
            let low = libm::pow(10.0, start / 40.0 - 2.0);
            let range = Range { scale: Scale::Log, low, high: low * libm::pow(10.0, 0.5 + width / 50.0) };
            let ticks = range.ticks(most, Steps::Decimal);
            let is_few = (3..=most + 1).contains(&ticks.major.len());
            assert!(is_few && range.is_spread(&ticks), "{most} {range:?}: {:?}", ticks.major);
        }
    }

    #[test]
    fn the_widest_and_the_smallest_ranges_have_ticks() {
        for values in
            [vec![1.1e-250, 9e249], vec![-9e249, 9e249], vec![5e-324], vec![1e15, 1e15 + 1.0], vec![0.0]]
        {
            for scale in [Scale::Log, Scale::Linear] {
                let range = Range::around(scale, values.iter().copied());
                let ticks = range.ticks(9, Steps::Decimal);
                assert!((2..=12).contains(&ticks.major.len()), "{values:?} {range:?}: {:?}", ticks.major);
            }
        }
    }
}
