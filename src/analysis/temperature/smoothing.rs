//! The smoothed temperature of a log with its slope, and averages of the rate beside it.

use crate::analysis::temperature::Effect;

/// Allowed distance of the smoothed temperature from the measured one, in errors of the sensor.
const TOLERANCE: f64 = 1.05;
/// Least error of a sensor, K.
const MIN_ERROR: f64 = 1e-9;
/// Distance beyond which longer windows are not tried.
const FAR: f64 = 3.0;
/// Shares of the record that a window may take at most.
const WINDOWS: usize = 8;
/// Ratio of the standard deviation of a normal distribution to its median absolute deviation.
const NORMAL: f64 = 1.4826;
/// Third differences of white noise have 20 times its variance.
const THIRD: f64 = 20.0;
/// Longest gap that is bridged by a straight line, in mean distances of the measurements.
const BRIDGED: usize = 4;

/// A temperature at every sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Temperatures, °C; NaN where none is known.
    pub values: Vec<f64>,
    /// Changes of the temperature per sample, K; NaN where no temperature is known.
    pub slopes: Vec<f64>,
    /// Number of samples on each side of the straight lines that smooth it; 0 if it is not smoothed.
    pub half_window: usize,
    /// Error of the sensor, K.
    pub error: f64,
    /// Whether most measurements repeat the one before, so that the error does not average out.
    pub is_coarse: bool,
}

impl Course {
    /// The course through the `measured` temperatures, NaN where one is missing. Gaps of up to `bridged` samples, or of four
    /// mean distances of the measurements, are bridged by straight lines, and ends are held as long.
    ///
    /// The error of the sensor is the median step over √12 where most measurements repeat the one before, as those of a
    /// coarse or slow sensor do; otherwise it is the white noise that third differences show, which includes the resolution.
    /// A straight line over 2^k samples on either side gives value and slope at each sample. The window is the longest
    /// one at which the course is within the error of the sensor from the measurements (root mean square). A sensor without
    /// errors is not smoothed, and slopes are then differences of neighbours.
    pub fn new(measured: &[f64], bridged: usize) -> Course {
        let filled = filled(measured, bridged);
        let (error, is_coarse) = error(measured);
        // What conversion of units leaves is no error of the sensor.
        let error = if error < MIN_ERROR { 0.0 } else { error };
        let mut course = Course { values: vec![], slopes: slopes(&filled), half_window: 0, error, is_coarse };
        let mut half_window = 1;
        while error > 0.0 && WINDOWS * half_window <= measured.len() {
            let (values, slopes) = lines(&filled, half_window);
            let known = || measured.iter().zip(&values).filter(|(x, y)| (*x - *y).is_finite());
            let squares: f64 = known().map(|(x, y)| (x - y) * (x - y)).sum();
            let excess = libm::sqrt(squares / known().count() as f64) / error;
            // A window of about one step of the resolution is off by more than a longer one.
            if excess <= TOLERANCE {
                course = Course { values, slopes, half_window, ..course };
            } else if excess > FAR {
                break;
            }
            half_window *= 2;
        }
        if course.half_window == 0 {
            course.values = filled;
        }
        course
    }

    /// The error of the mean of so many samples, K.
    pub fn error_of_mean(&self, samples: usize) -> f64 {
        if self.is_coarse { self.error } else { self.error / libm::sqrt(samples as f64) }
    }

    /// The course midway between samples, for the differences of angles.
    pub fn midway(&self) -> Course {
        let between = |x: &[f64]| x.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        Course { values: between(&self.values), slopes: between(&self.slopes), ..*self }
    }
}

fn median(mut numbers: Vec<f64>) -> f64 {
    let middle = numbers.len() / 2;
    if numbers.is_empty() { 0.0 } else { *numbers.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The error of the sensor, K, and whether most measurements repeat the one before.
fn error(measured: &[f64]) -> (f64, bool) {
    let known: Vec<f64> = measured.iter().copied().filter(|x| x.is_finite()).collect();
    let changes = || known.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|change| *change > 0.0);
    if 2 * changes().count() < known.len() {
        return (median(changes().collect()) / libm::sqrt(12.0), true);
    }
    let third = |x: &[f64]| (x[3] - 3.0 * x[2] + 3.0 * x[1] - x[0]).abs();
    (NORMAL * median(known.windows(4).map(third).collect()) / libm::sqrt(THIRD), false)
}

/// The measurements with straight lines over gaps that are not too long.
fn filled(measured: &[f64], bridged: usize) -> Vec<f64> {
    let known: Vec<usize> = (0..measured.len()).filter(|&i| measured[i].is_finite()).collect();
    let mut filled = measured.to_vec();
    let ([first, .., last] | [first @ last]) = known[..] else { return filled };
    let reach = bridged.max(BRIDGED * (last - first) / (known.len() - 1).max(1));
    for pair in known.windows(2).filter(|pair| pair[1] - pair[0] <= reach) {
        let (from, to) = (measured[pair[0]], measured[pair[1]]);
        for (i, value) in filled[pair[0]..pair[1]].iter_mut().enumerate() {
            *value = from + (to - from) * i as f64 / (pair[1] - pair[0]) as f64;
        }
    }
    filled[first.saturating_sub(reach)..first].fill(measured[first]);
    filled[last..measured.len().min(last + 1 + reach)].fill(measured[last]);
    filled
}

/// Differences of neighbours, of those on both sides where both are known.
fn slopes(filled: &[f64]) -> Vec<f64> {
    let at = |i: usize| filled.get(i).copied().unwrap_or(f64::NAN);
    let slope = |i: usize| {
        let before = if i > 0 { filled[i] - filled[i - 1] } else { f64::NAN };
        let after = at(i + 1) - filled[i];
        match (before.is_finite(), after.is_finite()) {
            (true, true) => 0.5 * (before + after),
            (true, false) => before,
            (false, _) => after,
        }
    };
    (0..filled.len()).map(slope).collect()
}

/// Values and slopes of least-squares lines over the known ones of `half_window` samples to either side of each.
fn lines(filled: &[f64], half_window: usize) -> (Vec<f64>, Vec<f64>) {
    let reach = half_window as f64;
    let origin = filled.iter().copied().find(|x| x.is_finite()).unwrap_or(0.0);
    // Sums over the window of 1, j, j², y and jy, where j counts from its middle, which moves by one sample each time.
    let mut sums = [0.0; 5];
    let add = |sums: &mut [f64; 5], i: usize, j: f64, sign: f64| {
        if let Some(y) = filled.get(i).map(|y| y - origin).filter(|y| y.is_finite()) {
            let terms = [1.0, j, j * j, y, j * y];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += sign * term);
        }
    };
    (0..half_window).for_each(|i| add(&mut sums, i, i as f64 + 1.0, 1.0));
    let mut line = |i: usize| {
        let [s0, s1, s2, y0, y1] = sums;
        sums = [s0, s1 - s0, s2 - 2.0 * s1 + s0, y0, y1 - y0];
        add(&mut sums, i + half_window, reach, 1.0);
        if i > half_window {
            add(&mut sums, i - half_window - 1, -reach - 1.0, -1.0);
        }
        let [s0, s1, s2, y0, y1] = sums;
        let determinant = s0 * s2 - s1 * s1;
        if filled[i].is_nan() || determinant <= 0.0 {
            return (filled[i], if filled[i].is_nan() { f64::NAN } else { 0.0 });
        }
        (origin + (s2 * y0 - s1 * y1) / determinant, (s0 * y1 - s1 * y0) / determinant)
    };
    (0..filled.len()).map(&mut line).unzip()
}

/// Most blocks of a record.
pub const MAX_BLOCKS: usize = 128;
/// Fewest blocks with enough known samples.
pub const MIN_BLOCKS: usize = 20;
/// Least share of the samples of a block that must be known.
const MIN_SHARE: f64 = 0.5;

/// Seconds of a minute and of a day, by which coefficients are quoted.
const MINUTE_S: f64 = 60.0;
const DAY_S: f64 = 86_400.0;

/// The mean rates of blocks with the means of what they may depend on.
#[derive(Debug, Clone)]
pub struct Averages {
    /// Number of samples of a block.
    pub m: usize,
    /// Time between samples, s.
    pub step_s: f64,
    /// Temperature from which differences count, °C: the mean of the blocks, to 0.1 K.
    pub reference_c: f64,
    /// Positions of the blocks.
    pub places: Vec<usize>,
    /// Share of the samples of each block that are known.
    pub shares: Vec<f64>,
    /// Mean rates, °/h.
    pub rates: Vec<f64>,
    /// Means of T − T_ref, K.
    pub temperatures: Vec<f64>,
    squares: Vec<f64>,
    /// Means of dT/dt, K/min.
    changes: Vec<f64>,
    /// Lowest and highest temperature of the samples, °C.
    pub range_c: [f64; 2],
}

impl Averages {
    /// The averages of `rates`, NaN where one is missing; `None` where fewer than [`MIN_BLOCKS`] blocks have both rates and
    /// temperatures for at least half of their samples.
    pub fn new(rates: &[f64], course: &Course, step_s: f64) -> Option<Averages> {
        let m = rates.len().div_ceil(MAX_BLOCKS).max(1);
        let known = |i: &usize| rates[*i].is_finite() && course.values[*i].is_finite();
        let samples = |place: usize| (place * m..(place + 1) * m).filter(known);
        let mean = |place: usize, x: &dyn Fn(usize) -> f64| {
            let (count, sum) = samples(place).fold((0.0, 0.0), |(count, sum), i| (count + 1.0, sum + x(i)));
            sum / count
        };
        let share = |place: &usize| samples(*place).count() as f64 / m as f64;
        let places: Vec<usize> = (0..rates.len() / m).filter(|place| share(place) >= MIN_SHARE).collect();
        if places.len() < MIN_BLOCKS {
            return None;
        }
        let each =
            |x: &dyn Fn(usize) -> f64| places.iter().map(|&place| mean(place, x)).collect::<Vec<f64>>();
        let all = each(&|i| course.values[i]);
        let reference_c = libm::round(10.0 * all.iter().sum::<f64>() / all.len() as f64) / 10.0;
        let from = |i: usize| course.values[i] - reference_c;
        let used = || places.iter().flat_map(|&place| samples(place)).map(|i| course.values[i]);
        Some(Averages {
            m,
            step_s,
            reference_c,
            shares: places.iter().map(share).collect(),
            rates: each(&|i| rates[i]),
            temperatures: each(&from),
            squares: each(&|i| from(i) * from(i)),
            changes: each(&|i| change(course, i, step_s)),
            range_c: [used().fold(f64::INFINITY, f64::min), used().fold(f64::NEG_INFINITY, f64::max)],
            places,
        })
    }

    /// Time from the start of the record to the end of the last block, s.
    pub fn length_s(&self) -> f64 {
        self.step_s * (self.m * self.places.last().map_or(0, |last| last + 1)) as f64
    }

    /// Standard deviation of the temperatures of the blocks, K.
    pub fn scatter(&self) -> f64 {
        let count = self.temperatures.len() as f64;
        let mean = self.temperatures.iter().sum::<f64>() / count;
        libm::sqrt(self.temperatures.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count)
    }

    /// The regressor of an effect; `time_s` is that of a warm-up.
    pub fn column(&self, effect: Effect, time_s: f64) -> Vec<f64> {
        let block_s = self.step_s * self.m as f64;
        let middles = || self.places.iter().map(|&place| block_s * (place as f64 + 0.5));
        match effect {
            Effect::Temperature => self.temperatures.clone(),
            Effect::Square => self.squares.clone(),
            Effect::Change => self.changes.clone(),
            // The mean over the block.
            Effect::WarmUp => {
                let half = 0.5 * block_s / time_s;
                middles().map(|t| libm::exp(-t / time_s) * libm::sinh(half) / half).collect()
            }
            Effect::Aging => middles().map(|t| t / DAY_S).collect(),
        }
    }

    /// The regressor of an effect at a sample.
    pub fn at(&self, effect: Effect, time_s: f64, course: &Course, i: usize) -> f64 {
        let from = course.values[i] - self.reference_c;
        let t = self.step_s * (i as f64 + 0.5);
        match effect {
            Effect::Temperature => from,
            Effect::Square => from * from,
            Effect::Change => change(course, i, self.step_s),
            Effect::WarmUp => libm::exp(-t / time_s),
            Effect::Aging => t / DAY_S,
        }
    }
}

/// dT/dt at a sample, K/min.
fn change(course: &Course, i: usize, step_s: f64) -> f64 {
    course.slopes[i] / step_s * MINUTE_S
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_temperature_is_left_as_it_is() {
        let measured: Vec<f64> = (0..2000).map(|i| 20.0 + 0.01 * f64::from(i)).collect();
        let course = Course::new(&measured, 10);
        assert_eq!((course.half_window, &course.values), (0, &measured));
        assert!(course.slopes.iter().all(|slope| (slope - 0.01).abs() < 1e-12));
    }

    #[test]
    fn steps_of_the_resolution_are_smoothed_to_the_line_behind_them() {
        let line = |i: usize| 20.0 + 3e-4 * i as f64;
        let measured: Vec<f64> = (0..20_000).map(|i| (line(i) / 0.0625).round() * 0.0625).collect();
        let course = Course::new(&measured, 10);
        assert!((course.error - 0.0625 / 12_f64.sqrt()).abs() < 1e-9, "{}", course.error);
        assert!(course.half_window >= 512, "{}", course.half_window);
        for i in (2000..18_000).step_by(100) {
            let (value, slope) = (course.values[i], course.slopes[i]);
            assert!((value - line(i)).abs() < 0.01 && (slope - 3e-4).abs() < 6e-5, "{i}: {value}, {slope}");
        }
    }

    #[test]
    fn short_gaps_are_bridged_and_long_ones_are_not() {
        let mut measured: Vec<f64> = (0..1000).map(|i| 0.1 * f64::from(i)).collect();
        measured[100..110].fill(f64::NAN);
        measured[500..700].fill(f64::NAN);
        measured[..5].fill(f64::NAN);
        let course = Course::new(&measured, 20);
        assert!((course.values[105] - 10.5).abs() < 1e-9 && (course.values[2] - 0.5).abs() < 1e-9);
        assert!(course.values[600].is_nan() && course.slopes[600].is_nan());
        assert!(Course::new(&[f64::NAN; 5], 3).values.iter().all(|x| x.is_nan()));
    }

    #[test]
    fn a_sensor_that_is_read_now_and_then_is_followed_between() {
        let measured: Vec<f64> =
            (0..1000).map(|i| if i % 50 == 0 { 0.1 * f64::from(i) } else { f64::NAN }).collect();
        let course = Course::new(&measured, 1);
        assert!((course.values[575] - 57.5).abs() < 1e-9 && (course.slopes[575] - 0.1).abs() < 1e-9);
    }
}
