//! A record and what it may depend on, averaged over blocks.

use crate::analysis::temperature::course::Course;
use crate::analysis::temperature::effect::Effect;

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
    pub fn of(rates: &[f64], course: &Course, step_s: f64) -> Option<Averages> {
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
