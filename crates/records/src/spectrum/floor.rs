//! The level of the white noise in a density.

use std::ops::Range;

use crate::fit::survival;
use crate::spectrum::Density;
use crate::spectrum::lines::{FIRST, Line, tested_end};
use crate::spectrum::median::Median;
use crate::spectrum::welch::ends;

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
    pub fn of(density: &Density, lines: &[Line]) -> Option<Floor> {
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
