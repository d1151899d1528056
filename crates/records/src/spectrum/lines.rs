//! Lines: sines, such as a vibration of the table or what is left of a dither.

use core::f64::consts::PI;
use std::ops::Range;

use crate::allan::fisher;
use crate::spectrum::Density;
use crate::spectrum::median::Median;

/// Most probability that a record of Gaussian noise with a smooth density shows any line at all.
pub const FALSE_ALARM: f64 = 0.003;

/// The first multiple of the spacing that the removed means do not affect.
pub(crate) const FIRST: usize = 2;
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
pub(crate) fn tested_end(density: &Density) -> usize {
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
        let tails = fisher::tails(ratio, self.density.freedom, median.freedom(count));
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
