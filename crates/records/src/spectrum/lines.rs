//! Lines: sines, such as a vibration of the table or what is left of a dither.
//!
//! [`Floor`] is the level of the white noise in a density, from the median of densities between the lines.

use core::f64::consts::{FRAC_2_PI, PI};
use std::ops::Range;

use crate::allan::distributions;
use crate::fit::survival;
use crate::spectrum::{Density, NEIGHBOURS, ends};

/// Most probability that a record of Gaussian noise with a smooth density shows any line at all.
pub const FALSE_ALARM: f64 = 0.003;

/// The first multiple of the spacing that the removed means do not affect.
const FIRST: usize = 2;
/// Fewest and most densities on each side of one that determine the floor around it.
const SIDES: [usize; 2] = [12, 50];
/// Half the width of a line in the density: the main lobe of the Hann window.
const LOBE: usize = 2;
/// Ratio to the leakage of a stronger line below which a density is not a line of its own.
const LEAKAGE: f64 = 4.0;

/// A line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Frequency, Hz, interpolated between those of the density.
    pub frequency_hz: f64,
    /// Amplitude of the sine of the rate, ″/s. That of a line broader than the window is of a sine with the same power.
    pub amplitude: f64,
    /// Highest density over that of the floor around it.
    pub over_floor: f64,
    /// Probability that noise alone has a density as high anywhere in the record.
    pub p: f64,
    /// The points of the density that it raises.
    pub places: Range<usize>,
}

/// The lines of a density, by rising frequency.
///
/// # Method
/// Each density is divided by that of the floor, the median of up to 50 densities on each side of it over the median of
/// their distribution. As many are taken on both sides, so that the median of a monotonic floor is the one in the middle;
/// beyond half the sampling rate the density is mirrored. The ratio has the F distribution, with the degrees of freedom
/// of the density and of the median. It belongs to a line where its probability times the number of tested frequencies is
/// below [`FALSE_ALARM`]. Up to 50 spacings beside a stronger line it must be so over the median of 12 on each side too,
/// because the skirt of a broad line is no line.
///
/// The power of a line is the sum of the densities above the floor, which does not depend on where the line lies between
/// two frequencies. The frequency is that at which the main lobe of the window has the ratio of the two highest densities.
///
/// # Limits
/// Lines below 14 spacings, where a floor cannot be told from the red noise of a gyro, and those closer than 3 spacings
/// to a stronger one are not found. The mean over a sample makes a sine smaller by sin πft0/πft0; this is not undone.
pub fn lines(density: &Density) -> Vec<Line> {
    let Some(median) = Median::new(density.freedom) else { return vec![] };
    let spectrum = Mirrored { density };
    let tested = FIRST + SIDES[0]..tested_end(density);
    let over: Vec<(f64, f64)> =
        tested.clone().map(|k| spectrum.over_floor(k, SIDES[1].min(k - FIRST), &median)).collect();
    let tests = tested.len() as f64;
    let p = |k: usize| tests * over[k - tested.start].1;
    let mut found: Vec<Line> = Vec::new();
    let significant: Vec<usize> = tested.clone().filter(|&k| p(k) < FALSE_ALARM).collect();
    for run in significant.chunk_by(|a, b| b - a <= LOBE) {
        let ratio = |k: usize| over[k - tested.start].0;
        let Some(&peak) = run.iter().max_by(|&&a, &&b| spectrum.at(a).total_cmp(&spectrum.at(b))) else {
            continue;
        };
        let floor = spectrum.at(peak) / ratio(peak);
        let bins = run[0] - LOBE..(run[run.len() - 1] + LOBE + 1).min(density.points.len() + 1);
        let power: f64 = bins.clone().map(|k| spectrum.at(k) - floor).sum();
        found.push(Line {
            frequency_hz: density.spacing_hz() * spectrum.centre(peak, floor),
            amplitude: libm::sqrt(2.0 * power.max(0.0) * density.spacing_hz()),
            over_floor: ratio(peak),
            p: p(peak),
            places: bins.start - 1..bins.end - 1,
        });
    }
    let all = found.clone();
    let is_narrow = |line: &Line| {
        let peak = libm::round(line.frequency_hz / density.spacing_hz()) as usize;
        tests * spectrum.over_floor(peak.max(tested.start), SIDES[0], &median).1 < FALSE_ALARM
    };
    found.retain(|line| {
        let stronger = all.iter().filter(|other| other.amplitude > line.amplitude);
        let mut near = stronger.map(|other| (other, spacings(line, other, density)));
        !near.any(|(other, apart)| {
            is_leakage(line, other, density) || apart < SIDES[1] as f64 && !is_narrow(line)
        })
    });
    found
}

/// The end of the multiples of the spacing that are tested: below half the sampling rate.
fn tested_end(density: &Density) -> usize {
    density.segment.div_ceil(2)
}

/// Distance of two lines in spacings.
fn spacings(line: &Line, other: &Line, density: &Density) -> f64 {
    (line.frequency_hz - other.frequency_hz).abs() / density.spacing_hz()
}

/// Whether the density of a line is no more than what the window spreads of a stronger one.
fn is_leakage(line: &Line, stronger: &Line, density: &Density) -> bool {
    let highest =
        |line: &Line| density.points[line.places.clone()].iter().map(|point| point.value).fold(0.0, f64::max);
    let apart = spacings(line, stronger, density);
    // Of a sine on a multiple of the spacing the highest density is a²/3 over the spacing.
    let peak = stronger.amplitude * stronger.amplitude / (3.0 * density.spacing_hz());
    let envelope = 1.0 / (PI * apart * (apart * apart - 1.0));
    apart > 1.0 && highest(line) <= LEAKAGE * peak * envelope * envelope
}

/// A density by multiples of the spacing, mirrored at half the sampling rate.
struct Mirrored<'a> {
    density: &'a Density,
}

impl Mirrored<'_> {
    fn at(&self, k: usize) -> f64 {
        let points = &self.density.points;
        let k = if k > points.len() { self.density.segment - k } else { k };
        points[k - 1].value
    }

    /// The density over the floor of some densities on each side, and the probability that noise has a ratio as high. A
    /// floor of 0 has no ratio.
    fn over_floor(&self, k: usize, side: usize, median: &Median) -> (f64, f64) {
        let values: Vec<f64> = (k - side..=k + side).map(|k| self.at(k)).collect();
        let count = values.len();
        let floor = median.mean(values).filter(|floor| *floor > 0.0);
        let ratio = floor.map_or(0.0, |floor| self.at(k) / floor);
        let tails = distributions::f_tails(ratio, self.density.freedom, median.freedom(count));
        (ratio, tails.map_or(1.0, |[_, above]| above))
    }

    /// The frequency of a line in spacings, from the amplitudes 1 and r of its two highest densities: ± (2r − 1)/(1 + r)
    /// beside the higher one, for the main lobe of the Hann window.
    fn centre(&self, peak: usize, floor: f64) -> f64 {
        let root = |k: usize| libm::sqrt((self.at(k) - floor).max(0.0));
        let (below, above) = (root(peak - 1), root(peak + 1));
        let side = if above > below { 1.0 } else { -1.0 };
        let ratio = below.max(above) / root(peak);
        peak as f64 + side * ((2.0 * ratio - 1.0) / (1.0 + ratio)).clamp(-0.5, 0.5)
    }
}

/// Fewest densities in a cell, the unit of a range of frequencies.
const MIN_IN_CELL: usize = 16;
/// Ratio of the ends of a cell.
const CELL: f64 = 1.189_207_115_002_721;
/// Fewest cells in a range, and least ratio of its ends.
const MIN_CELLS: usize = 3;
const MIN_RATIO: f64 = 2.0;
/// Probability of the scatter of the cells of a white range below which a range is not taken as white.
const UNLIKELY: f64 = 0.05;
/// Most standard errors of the slope of a white range.
const MAX_SLOPE: f64 = 2.0;

/// The density of the widest range of frequencies in which it is flat.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    /// The points of the density that are in the range; those of lines are left out.
    pub places: Range<usize>,
    /// Ends of the range, Hz.
    pub range_hz: [f64; 2],
    /// One-sided density, (″/s)²/Hz.
    pub density: f64,
    /// Its interval, with the probability of those of the density.
    pub interval: (f64, f64),
    /// Degrees of freedom of the density.
    pub freedom: f64,
}

/// The level of a cell.
struct Cell {
    bins: Range<usize>,
    /// Logarithms of the middle frequency and of the density.
    at: f64,
    level: f64,
    /// Inverse of the variance of `level`.
    weight: f64,
}

impl Floor {
    /// The floor of a density with these lines; `None` where no range of at least an octave is flat.
    ///
    /// # Method
    /// The frequencies are divided into cells of a quarter of an octave and at least 16 densities. The level of a cell is
    /// the median of its densities, without those of lines. A range of cells is flat if the χ² of the logarithms of their
    /// levels around their mean has a probability of at least 5 %, and a slope over the logarithm of the frequency is at
    /// most two standard errors. The floor is the median of all densities of the widest flat range over the median of
    /// their distribution.
    ///
    /// # Bias
    /// Other noise that is too weak in the range to show as a slope is part of the floor.
    pub fn new(density: &Density, lines: &[Line]) -> Option<Floor> {
        let median = Median::new(density.freedom)?;
        let is_clear = |k: &usize| !lines.iter().any(|line| line.places.contains(&(k - 1)));
        let values = |bins: Range<usize>| -> Vec<f64> {
            bins.filter(is_clear).map(|k| density.points[k - 1].value).collect()
        };
        let cell = |bins: Range<usize>| {
            let values = values(bins.clone());
            let weight = 0.5 * median.freedom(values.len());
            let level = libm::log(median.mean(values)?);
            let at = libm::log(0.5 * (bins.start + bins.end) as f64);
            level.is_finite().then_some(Cell { bins, at, level, weight })
        };
        let cells: Vec<Cell> = cells(FIRST..tested_end(density)).into_iter().filter_map(cell).collect();
        let bins = widest(&cells)?;
        Floor::over(density, lines, bins.start - 1..bins.end - 1)
    }

    /// The level of a density over some of its points, without those of lines, as if it were flat there; `None` if there are
    /// too few.
    pub fn over(density: &Density, lines: &[Line], places: Range<usize>) -> Option<Floor> {
        let median = Median::new(density.freedom)?;
        let is_clear = |place: &usize| !lines.iter().any(|line| line.places.contains(place));
        let values: Vec<f64> =
            places.clone().filter(is_clear).map(|place| density.points[place].value).collect();
        if values.len() < MIN_IN_CELL {
            return None;
        }
        let freedom = median.freedom(values.len());
        let level = median.mean(values)?;
        let (low, high) = ends(freedom, density.confidence)?;
        let hz = |place: usize| density.points[place].frequency_hz;
        Some(Floor {
            range_hz: [hz(places.start), hz(places.end - 1)],
            places,
            density: level,
            interval: (low * level, high * level),
            freedom,
        })
    }
}

/// Cells over a range of multiples of the spacing; a short rest belongs to the last one.
fn cells(all: Range<usize>) -> Vec<Range<usize>> {
    let mut cells = Vec::new();
    let mut start = all.start;
    while start < all.end {
        let end = (start + MIN_IN_CELL).max(libm::ceil(CELL * start as f64) as usize);
        let end = if end + MIN_IN_CELL > all.end { all.end } else { end };
        cells.push(start..end);
        start = end;
    }
    cells
}

/// The widest flat range of cells.
fn widest(cells: &[Cell]) -> Option<Range<usize>> {
    let mut best: Option<Range<usize>> = None;
    for first in 0..cells.len() {
        for end in first + MIN_CELLS..=cells.len() {
            let range = cells[first].bins.start..cells[end - 1].bins.end;
            let is_wider = best.as_ref().is_none_or(|best| range.len() > best.len());
            let is_octave = range.end as f64 >= MIN_RATIO * range.start as f64;
            if is_wider && is_octave && is_flat(&cells[first..end]) {
                best = Some(range);
            }
        }
    }
    best
}

/// Whether the levels of some cells are equal but for their scatter.
fn is_flat(cells: &[Cell]) -> bool {
    let weights: f64 = cells.iter().map(|cell| cell.weight).sum();
    let mean = |of: fn(&Cell) -> f64| cells.iter().map(|cell| cell.weight * of(cell)).sum::<f64>() / weights;
    let (level, at) = (mean(|cell| cell.level), mean(|cell| cell.at));
    let sum = |of: &dyn Fn(&Cell) -> f64| cells.iter().map(|cell| cell.weight * of(cell)).sum::<f64>();
    let chi_squared = sum(&|cell| (cell.level - level) * (cell.level - level));
    let slope =
        sum(&|cell| (cell.at - at) * cell.level) / libm::sqrt(sum(&|cell| (cell.at - at) * (cell.at - at)));
    survival(chi_squared, cells.len() - 1) >= UNLIKELY && slope.abs() <= MAX_SLOPE
}

/// The distribution of the median of densities at neighbouring frequencies, in units of their mean.
#[derive(Debug, Clone, Copy)]
struct Median {
    /// Median of one density.
    pub(crate) factor: f64,
    /// Variance of the median of n densities over its square, times n.
    variance: f64,
}

impl Median {
    /// That of densities with these degrees of freedom; `None` if they have no quantiles.
    ///
    /// The variance of a median of n values is Σ_d C_d/(4f²n) with the density f of one value at its median and the
    /// correlation C_d = (2/π) arcsin ρ_d of the signs of two values, d places apart, around it. The latter is that of
    /// normal values.
    pub(crate) fn new(freedom: f64) -> Option<Median> {
        let median = distributions::chi_squared_quantile(0.5, freedom)?;
        let half = 0.5 * freedom;
        let log = (half - 1.0) * libm::log(0.5 * median) - 0.5 * median - libm::lgamma(half);
        // Of χ² itself, whose mean is `freedom`: f times the median is free of the unit.
        let density = 0.5 * libm::exp(log) * median;
        let signs = 1.0 + NEIGHBOURS.map(|c| 2.0 * FRAC_2_PI * libm::asin(c)).iter().sum::<f64>();
        Some(Median { factor: median / freedom, variance: signs / (4.0 * density * density) })
    }

    /// Degrees of freedom of a mean that scatters as much as the median of `count` densities.
    pub(crate) fn freedom(&self, count: usize) -> f64 {
        2.0 * count as f64 / self.variance
    }

    /// The mean of densities by their median, which a few of them cannot change by much however large they are.
    pub(crate) fn mean(&self, mut values: Vec<f64>) -> Option<f64> {
        let middle = values.len() / 2;
        let is_even = values.len().is_multiple_of(2);
        if values.is_empty() {
            return None;
        }
        let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        let lower = below.iter().copied().filter(|_| is_even).fold(f64::NEG_INFINITY, f64::max);
        let median = if is_even { 0.5 * (lower + *upper) } else { *upper };
        Some(median / self.factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_and_the_variance_are_those_of_scipy() {
        // chi2.median(v)/v and Σ_d C_d/(4·(v·chi2.pdf(v·m, v))²)/m² with that m, SciPy 1.17.
        for (freedom, factor, variance) in FROM_SCIPY {
            let found = Median::new(freedom).unwrap();
            assert!((found.factor / factor - 1.0).abs() < 1e-7, "{freedom}: {}", found.factor);
            assert!((found.variance / variance - 1.0).abs() < 1e-7, "{freedom}: {}", found.variance);
        }
    }

    #[test]
    fn the_median_of_an_even_number_is_between_the_middle_ones() {
        let one = Median { factor: 1.0, variance: 1.0 };
        assert_eq!(one.mean(vec![4.0, 1.0, 9.0, 2.0]), Some(3.0));
        assert_eq!(one.mean(vec![4.0, 1.0, 9.0]), Some(4.0));
        assert_eq!(one.mean(vec![]), None);
    }

    const FROM_SCIPY: [(f64, f64, f64); 3] = [
        (2.0, 0.6931471805599455, 3.375497338446589),
        (5.785714285714286, 0.8874347777611452, 0.9703553261931418),
        (28.52112676056338, 0.9767251465076218, 0.1821607320326096),
    ];
}
