//! Weights of fillers, by Gram and Schmidt and by elimination.

use super::polynomial::polynomial;
use super::{Gyro, band_covariance};

/// How a filler weighs its ticks.
#[derive(Debug, Clone)]
pub enum Method {
    Polynomial(i32),
    /// Designed for a band of frequencies, or for the gyro's own motion.
    MinimumVariance(Option<[f64; 2]>),
    /// Of the residual and of the extrapolation.
    Given(Vec<f64>, Vec<f64>),
}

#[derive(Debug, Clone)]
pub struct Filler {
    pub name: &'static str,
    pub method: Method,
    pub fit_ticks: Vec<i32>,
    pub extrapolation_ticks: Vec<i32>,
}

impl Filler {
    /// A polynomial on the default ticks.
    pub fn polynomial(order: i32, n: i32) -> Filler {
        Filler {
            name: ["const", "linear", "quadratic"][order as usize],
            method: Method::Polynomial(order),
            fit_ticks: vec![-1, 0, n + 1, n + 2],
            extrapolation_ticks: vec![-3, -2, -1, 0],
        }
    }

    /// As in the list of fillers of a study.
    pub fn toml(&self) -> String {
        let kind = match &self.method {
            Method::Polynomial(order) => ["const", "linear", "quadratic"][*order as usize],
            Method::MinimumVariance(_) => "minimum-variance",
            Method::Given(..) => "weights",
        };
        let more = match &self.method {
            Method::Polynomial(_) | Method::MinimumVariance(None) => String::new(),
            Method::MinimumVariance(Some([low, high])) => format!(", band = [\"{low} Hz\", \"{high} Hz\"]"),
            Method::Given(residual, extrapolation) => {
                format!(", weights = {residual:?}, extrapolation_weights = {extrapolation:?}")
            }
        };
        let Filler { name, fit_ticks, extrapolation_ticks, .. } = self;
        format!(
            "{{ kind = \"{kind}\", name = \"{name}\", fit_ticks = {fit_ticks:?}, extrapolation_ticks = \
             {extrapolation_ticks:?}{more} }}"
        )
    }

    /// Weights of the residual or of the extrapolation over the first `length` ticks of the gap; `None` where the filler
    /// has none.
    pub fn weights(&self, gyro: &Gyro, residual: bool, length: i32) -> Option<Vec<f64>> {
        let ticks = if residual { &self.fit_ticks } else { &self.extrapolation_ticks };
        match &self.method {
            Method::Polynomial(order) => Some(polynomial(ticks, *order, length)),
            Method::MinimumVariance(band) => Some(minimum_variance(gyro, *band, ticks, length)),
            Method::Given(own, other) => {
                (length == gyro.n).then(|| if residual { own.clone() } else { other.clone() })
            }
        }
    }
}

/// [K + noise, 1; 1ᵀ, 0] [w; λ] = [k; length] by elimination with pivots. K of a record is the mean of products over all
/// places of the gap with as many ticks on both sides as the filler reads on one.
fn minimum_variance(gyro: &Gyro, band: Option<[f64; 2]>, ticks: &[i32], length: i32) -> Vec<f64> {
    let places = [ticks, &[1, length]].concat();
    let lags = (places.iter().max().unwrap() - places.iter().min().unwrap()) as usize + 1;
    let record = if band.is_none() { gyro.deviations() } else { vec![] };
    let covariance: Vec<f64> = match band {
        None if record.is_empty() => gyro.covariance(lags),
        None => vec![],
        // As much motion as the gyro has: for tones of fixed rate amplitude the sum of their squares.
        Some(band) => {
            let square: f64 = gyro.tones.iter().map(|tone| tone.amplitude.mean_square()).sum();
            (0..lags).map(|lag| square * band_covariance(band, lag as f64)).collect()
        }
    };
    let sides = ticks.iter().map(|&tick| if tick > 0 { tick - gyro.n } else { 1 - tick }).max().unwrap();
    let between = |a: i32, b: i32| {
        if record.is_empty() {
            return covariance[a.abs_diff(b) as usize];
        }
        let windows = record.windows((gyro.n + 2 * sides) as usize);
        let count = windows.len() as f64;
        windows.map(|own| own[(a - 1 + sides) as usize] * own[(b - 1 + sides) as usize]).sum::<f64>() / count
    };
    let noise = gyro.noise_covariance();
    let count = ticks.len();
    let mut rows: Vec<Vec<f64>> = ticks
        .iter()
        .map(|&a| {
            let of_noise = |b: i32| noise.get(a.abs_diff(b) as usize).unwrap_or(&0.0);
            let gap: f64 = (1..=length).map(|j| between(a, j)).sum();
            ticks.iter().map(|&b| between(a, b) + of_noise(b)).chain([1.0, gap]).collect()
        })
        .collect();
    rows.push([vec![1.0; count], vec![0.0, f64::from(length)]].concat());
    let mut solution = eliminated(rows);
    solution.truncate(count);
    solution
}

/// The solution of a system whose last column is its right side.
fn eliminated(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let count = rows.len();
    for k in 0..count {
        let pivot = (k..count).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs())).unwrap();
        rows.swap(k, pivot);
        let pivot_row = rows[k].clone();
        for row in &mut rows[k + 1..] {
            let factor = row[k] / pivot_row[k];
            row.iter_mut().zip(&pivot_row).for_each(|(x, above)| *x -= factor * above);
        }
    }
    for k in (0..count).rev() {
        let known: f64 = (k + 1..count).map(|j| rows[k][j] * rows[j][count]).sum();
        rows[k][count] = (rows[k][count] - known) / rows[k][k];
    }
    rows.iter().map(|row| row[count]).collect()
}
