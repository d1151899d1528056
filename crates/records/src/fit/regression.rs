//! Linear regression on the means of blocks of a record, for its dependence on temperature; Allan curves are fitted elsewhere. The
//! noise is white noise with unknown parts of flicker and of a random walk.
//!
//! Slow noise imitates slow regressors, and how much of it there is must be learnt from the same record, which says little
//! about the slowest noise of all. A single estimate of the noise would therefore give intervals that are too short, at
//! the worst where no random walk shows although one is there. Instead, generalized least squares is done for each noise
//! of a grid of proportions, and the results are averaged with the probability of each noise: its restricted likelihood
//! (REML: that of all contrasts of the record that are free of the regressors, with the size of the noise integrated
//! out; Harville 1974) times a weight of its own. The distribution of a coefficient is then a mixture of Student
//! distributions, from which its interval is taken.

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::allan::distributions;
use crate::fit::search::dot;
use crate::fit::survival;
use sagnac_theory::cholesky;

/// Proportions of flicker and of random walk: powers of 4 with these exponents, and 0. The variance of either part about its
/// mean over the record is so many times that of the white noise of the blocks.
const FLICKER: std::ops::RangeInclusive<i32> = -2..=5;
const WALK: std::ops::RangeInclusive<i32> = -4..=8;

/// Weight of noise without flicker relative to each proportion of flicker, and exponent of the weight of a random walk as a
/// power of its proportion.
///
/// They were chosen by counting (docs/dev/numerics.md): with equal weights, the intervals of coefficients under a random walk
/// cover in 85 to 90 % of records, because flicker explains the same record with less noise at the slowest end.
const NO_FLICKER: f64 = 20.0;
const WALK_EXPONENT: f64 = 0.2;

/// Least squared length of a column beyond the others, relative to its own, for both to be distinguished.
const DISTINCT: f64 = 1e-8;

/// Smallest share of the squares of the record that counts as noise; less is rounding.
const ROUNDING: f64 = 1e-24;

/// Blocks of a record with what their means may depend on.
#[derive(Debug, Clone)]
pub struct Blocks {
    /// Positions of the blocks in the record, rising; blocks of missing samples are left out.
    pub places: Vec<usize>,
    /// Share of the samples of each block that are not missing, above 0.
    pub shares: Vec<f64>,
    /// Mean of each block.
    pub values: Vec<f64>,
    /// Regressors over the same blocks; the first must be constant.
    pub columns: Vec<Vec<f64>>,
    /// Covariance of the fast noise of two blocks by the difference of their places, up to its size, and those of flicker
    /// and of a random walk, each up to a constant; see [`blocks::covariance`](sagnac_theory::allan::block_covariance).
    pub noises: [Vec<f64>; 3],
}

/// The products of all columns and values under each noise, from which every choice of columns follows.
#[derive(Debug, Clone)]
pub struct Regression {
    blocks: Blocks,
    /// Noises with the factors from the covariances of `noises`, their weights and their products.
    nodes: Vec<Node>,
}

#[derive(Debug, Clone)]
struct Node {
    /// Factors of flicker and random walk.
    factors: [f64; 2],
    /// Logarithm of the weight over the square root of the determinant of the covariance.
    constant: f64,
    /// Products of whitened columns, the values last.
    products: Vec<Vec<f64>>,
}

/// The least-squares solution for some columns under one noise.
struct Solution {
    estimates: Vec<f64>,
    /// Covariance of the estimates in units of the noise.
    inverse: Vec<Vec<f64>>,
    chi_squared: f64,
    /// Logarithm of the determinant of the products of the columns.
    determinant: f64,
}

impl Regression {
    /// Whitens the blocks under each noise, which takes a third of the cube of their number in steps, 126 times; `None` where
    /// a covariance is not positive definite.
    pub fn new(mut blocks: Blocks) -> Option<Regression> {
        let base = spread(&blocks.noises[0], &blocks.places);
        for noise in &mut blocks.noises {
            let scale = spread(noise, &blocks.places) / base;
            noise.iter_mut().for_each(|cell| *cell /= scale);
        }
        let powers = |range: std::ops::RangeInclusive<i32>| {
            std::iter::once(0.0).chain(range.map(|exponent| libm::exp2(2.0 * f64::from(exponent))))
        };
        let factors: Vec<[f64; 2]> =
            powers(FLICKER).flat_map(|flicker| powers(WALK).map(move |walk| [flicker, walk])).collect();
        let nodes: Option<Vec<Node>> = factors.into_par_iter().map(|factors| blocks.node(factors)).collect();
        Some(Regression { nodes: nodes?, blocks })
    }

    /// The distribution of the coefficients of some columns, of which the first must be the constant one; `None` where columns
    /// depend on each other, or there are not more blocks than columns.
    pub fn posterior(&self, columns: &[usize]) -> Option<Posterior> {
        let degrees = self.blocks.values.len().checked_sub(columns.len()).filter(|degrees| *degrees > 0)?;
        let solutions: Option<Vec<Solution>> = self.nodes.iter().map(|node| node.solve(columns)).collect();
        let solutions = solutions?;
        let logarithm = |(node, solution): (&Node, &Solution)| {
            node.constant
                - 0.5 * solution.determinant
                - 0.5 * degrees as f64 * libm::log(solution.chi_squared)
        };
        let logarithms: Vec<f64> = self.nodes.iter().zip(&solutions).map(logarithm).collect();
        Some(Posterior::new(&logarithms, solutions, degrees))
    }

    /// Twice the negative logarithm of the likelihood of some columns relative to that of `all` of them, averaged over
    /// the noises that `all` leave likely: χ² where one noise is certain. Infinite where columns depend on each other.
    pub fn lack(&self, columns: &[usize], all: &Posterior) -> f64 {
        let likelihood = |(node, known): (&Node, &Known)| {
            let excess = node.solve(columns)?.chi_squared - known.chi_squared;
            Some(
                known.weight * libm::exp(-0.5 * (excess * all.degrees() as f64 / known.chi_squared).max(0.0)),
            )
        };
        // Noises without weight would only add zeros.
        let likely = self.nodes.iter().zip(all.known()).filter(|(_, known)| known.weight > 0.0);
        let sum: Option<f64> = likely.map(likelihood).sum();
        sum.map_or(f64::INFINITY, |sum| -2.0 * libm::log(sum))
    }
}

impl Blocks {
    fn node(&self, factors: [f64; 2]) -> Option<Node> {
        let factor = self.factor(factors)?;
        let whitened: Vec<Vec<f64>> =
            self.columns.iter().chain([&self.values]).map(|x| cholesky::whiten(&factor, x.clone())).collect();
        let products = whitened.iter().map(|a| whitened.iter().map(|b| dot(a, b)).collect()).collect();
        let half_determinant: f64 = factor.iter().enumerate().map(|(i, row)| libm::log(row[i])).sum();
        let [flicker, walk] = factors;
        let weight = if flicker == 0.0 { libm::log(NO_FLICKER) } else { 0.0 };
        let least = libm::exp2(2.0 * f64::from(*WALK.start()));
        let tilt = WALK_EXPONENT * libm::log(walk.max(least));
        Some(Node { factors, constant: weight + tilt - half_determinant, products })
    }

    /// The factor of the covariance with these factors of flicker and random walk. A constant is added to all its cells, which
    /// the constant column takes up.
    fn factor(&self, [flicker, walk]: [f64; 2]) -> Option<Vec<Vec<f64>>> {
        let [fast, others @ ..] = &self.noises;
        let slow = |lag: usize| flicker * others[0][lag] + walk * others[1][lag];
        let reach = self.places.last()? - self.places.first()?;
        let largest = (0..=reach).map(|lag| libm::fabs(slow(lag))).fold(fast[0], f64::max);
        cholesky::definite(self.places.len(), |i, j| {
            let lag = self.places[i].abs_diff(self.places[j]);
            let own = if i == j { fast[0] / self.shares[i] } else { fast[lag] };
            own + slow(lag) + 2.0 * largest
        })
    }
}

/// The variance of a noise about its mean over the blocks.
fn spread(noise: &[f64], places: &[usize]) -> f64 {
    let sum: f64 = places.iter().flat_map(|a| places.iter().map(|b| noise[a.abs_diff(*b)])).sum();
    noise[0] - sum / (places.len() * places.len()) as f64
}

impl Node {
    fn solve(&self, columns: &[usize]) -> Option<Solution> {
        let last = self.products.len() - 1;
        let lengths: Vec<f64> = columns.iter().map(|&i| libm::sqrt(self.products[i][i])).collect();
        let cosine = |i: usize, j: usize| self.products[columns[i]][columns[j]] / (lengths[i] * lengths[j]);
        let factor = cholesky::definite(columns.len(), cosine)?;
        if factor.iter().enumerate().any(|(i, row)| row[i] * row[i] < DISTINCT) {
            return None;
        }
        let towards: Vec<f64> =
            columns.iter().zip(&lengths).map(|(&i, length)| self.products[i][last] / length).collect();
        let found = cholesky::solve(&factor, towards.clone());
        let squares = self.products[last][last];
        let chi_squared = (squares - dot(&found, &towards)).max(ROUNDING * squares).max(f64::MIN_POSITIVE);
        let inverse = (0..columns.len()).map(|i| {
            let unit = (0..columns.len()).map(|j| if i == j { 1.0 / lengths[i] } else { 0.0 }).collect();
            cholesky::solve(&factor, unit).iter().zip(&lengths).map(|(x, length)| x / length).collect()
        });
        let logarithm = |(i, row): (usize, &Vec<f64>)| 2.0 * libm::log(row[i] * lengths[i]);
        Some(Solution {
            estimates: found.iter().zip(&lengths).map(|(x, length)| x / length).collect(),
            inverse: inverse.collect(),
            chi_squared,
            determinant: factor.iter().enumerate().map(logarithm).sum(),
        })
    }
}

/// Autocorrelations of the whitened residual that are tested together.
const TESTED: usize = 20;
/// Autocorrelations of the robust covariance, in square roots of the number of blocks (Lazarus et al. 2018).
const FOLLOWED: f64 = 1.3;

/// The residual and the columns of a solution, whitened by its most probable noise.
struct Whitened {
    residual: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl Regression {
    fn whitened(&self, columns: &[usize], posterior: &Posterior) -> Option<Whitened> {
        let at = posterior.mode();
        let factor = self.blocks.factor(self.nodes[at].factors)?;
        let white = |x: &Vec<f64>| cholesky::whiten(&factor, x.clone());
        let columns: Vec<Vec<f64>> = columns.iter().map(|&i| white(&self.blocks.columns[i])).collect();
        let mut residual = white(&self.blocks.values);
        for (column, estimate) in columns.iter().zip(&posterior.known()[at].estimates) {
            residual.iter_mut().zip(column).for_each(|(left, x)| *left -= estimate * x);
        }
        Some(Whitened { residual, columns })
    }

    /// Probability of residuals at least as correlated if the most probable noise is that of the record: the test of
    /// Ljung and Box over 20 autocorrelations, or as many as a fifth of the blocks.
    pub fn p_value(&self, columns: &[usize], posterior: &Posterior) -> Option<f64> {
        let Whitened { residual, .. } = self.whitened(columns, posterior)?;
        let (count, lags) = (residual.len(), TESTED.min(residual.len() / 5));
        let square = dot(&residual, &residual);
        let one = |lag: usize| {
            let correlation = dot(&residual[lag..], &residual[..count - lag]) / square;
            correlation * correlation / (count - lag) as f64
        };
        let statistic = (count * (count + 2)) as f64 * (1..=lags).map(one).sum::<f64>();
        Some(survival(statistic, lags))
    }

    /// The estimates of the most probable noise with intervals that suppose only that the whitened residual is stationary
    /// with a correlation that ends: the covariance of its products with the columns over 1.3 √n blocks with
    /// falling weights (Newey and West 1987), and Student's distribution with 1.5 times n over as many degrees of freedom.
    pub fn robust(&self, columns: &[usize], posterior: &Posterior) -> Option<Posterior> {
        let Whitened { residual, columns: whitened } = self.whitened(columns, posterior)?;
        let (node, count, width) = (&self.nodes[posterior.mode()], residual.len(), columns.len());
        let solution = node.solve(columns)?;
        let lags = libm::ceil(FOLLOWED * libm::sqrt(count as f64)) as usize;
        let scores: Vec<Vec<f64>> = whitened
            .iter()
            .map(|column| column.iter().zip(&residual).map(|(x, e)| x * e).collect())
            .collect();
        let product = |i: usize, j: usize| -> f64 {
            let at = |lag: usize| {
                let both = dot(&scores[i][lag..], &scores[j][..count - lag])
                    + dot(&scores[j][lag..], &scores[i][..count - lag]);
                if lag == 0 { 0.5 * both } else { both * (1.0 - lag as f64 / (lags + 1) as f64) }
            };
            (0..=lags.min(count - 1)).map(at).sum()
        };
        let middle: Vec<Vec<f64>> = (0..width).map(|i| (0..width).map(|j| product(i, j)).collect()).collect();
        let lost = count as f64 / (count - width) as f64;
        let towards: Vec<Vec<f64>> = solution
            .inverse
            .iter()
            .map(|row| (0..width).map(|j| (0..width).map(|k| row[k] * middle[k][j]).sum()).collect())
            .collect();
        let cell = |i: usize, j: usize| lost * dot(&towards[i], &solution.inverse[j]);
        let covariance = (0..width).map(|i| (0..width).map(|j| cell(i, j)).collect()).collect();
        let degrees = (1.5 * count as f64 / lags as f64) as usize;
        Some(Posterior::single(solution.estimates, covariance, degrees.max(1)))
    }
}

/// Least weight of a noise relative to the greatest; the sum of all that have less is far below the precision of an interval.
const MIN_WEIGHT: f64 = 1e-6;
/// Halvings of the bracket of a quantile, and its ends in standard errors.
const HALVINGS: usize = 60;
const FARTHEST: f64 = 40.0;

/// The coefficients under one noise.
#[derive(Debug, Clone)]
pub(crate) struct Known {
    /// Probability of the noise; 0 where it is negligible.
    pub weight: f64,
    pub estimates: Vec<f64>,
    /// Covariance of the estimates.
    pub covariance: Vec<Vec<f64>>,
    pub chi_squared: f64,
}

/// The distribution of the coefficients of a regression.
#[derive(Debug, Clone)]
pub struct Posterior {
    known: Vec<Known>,
    degrees: usize,
}

/// A coefficient, or a sum of coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean of its distribution.
    pub value: f64,
    /// Quantiles of 2.5 and 97.5 %.
    pub interval: [f64; 2],
}

impl Estimate {
    /// Whether the interval does not contain 0.
    pub fn is_identified(&self) -> bool {
        self.interval[0] > 0.0 || self.interval[1] < 0.0
    }
}

impl Posterior {
    fn new(logarithms: &[f64], solutions: Vec<Solution>, degrees: usize) -> Posterior {
        let largest = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let relative = logarithms.iter().map(|logarithm| libm::exp(logarithm - largest));
        let weights: Vec<f64> =
            relative.map(|weight| if weight < MIN_WEIGHT { 0.0 } else { weight }).collect();
        let sum: f64 = weights.iter().sum();
        let known = solutions.into_iter().zip(weights).map(|(solution, weight)| {
            let variance = solution.chi_squared / degrees as f64;
            let scaled = |row: Vec<f64>| row.into_iter().map(|cell| variance * cell).collect();
            Known {
                weight: weight / sum,
                estimates: solution.estimates,
                covariance: solution.inverse.into_iter().map(scaled).collect(),
                chi_squared: solution.chi_squared,
            }
        });
        Posterior { known: known.collect(), degrees }
    }

    /// The distribution under a single noise, with another covariance.
    fn single(estimates: Vec<f64>, covariance: Vec<Vec<f64>>, degrees: usize) -> Posterior {
        Posterior { known: vec![Known { weight: 1.0, estimates, covariance, chi_squared: 1.0 }], degrees }
    }

    pub(crate) fn known(&self) -> &[Known] {
        &self.known
    }

    /// Degrees of freedom of the Student distributions.
    pub fn degrees(&self) -> usize {
        self.degrees
    }

    /// The number of the most probable noise.
    fn mode(&self) -> usize {
        let weights = || self.known.iter().map(|known| known.weight);
        let largest = weights().fold(0.0, f64::max);
        weights().position(|weight| weight == largest).unwrap_or_default()
    }

    /// The mean of each coefficient.
    pub fn means(&self) -> Vec<f64> {
        let count = self.known.first().map_or(0, |known| known.estimates.len());
        (0..count).map(|i| self.known.iter().map(|known| known.weight * known.estimates[i]).sum()).collect()
    }

    /// The coefficient `i`.
    pub fn coefficient(&self, i: usize) -> Estimate {
        let count = self.known.first().map_or(0, |known| known.estimates.len());
        self.sum(&(0..count).map(|j| f64::from(u8::from(i == j))).collect::<Vec<_>>())
    }

    /// The sum of all coefficients times `weights`.
    pub fn sum(&self, weights: &[f64]) -> Estimate {
        let parts: Vec<[f64; 3]> = self
            .known
            .iter()
            .filter(|known| known.weight > 0.0)
            .map(|known| {
                let rows = known.covariance.iter().map(|row| dot(row, weights));
                let variance: f64 = rows.zip(weights).map(|(row, weight)| row * weight).sum();
                [known.weight, dot(&known.estimates, weights), libm::sqrt(variance.max(0.0))]
            })
            .collect();
        let value = parts.iter().map(|[weight, value, _]| weight * value).sum();
        Estimate { value, interval: [0.025, 0.975].map(|p| quantile(&parts, p, self.degrees as f64)) }
    }
}

/// The quantile of a mixture of Student distributions, each with its weight, middle and scale.
fn quantile(parts: &[[f64; 3]], probability: f64, degrees: f64) -> f64 {
    let below = |x: f64| -> f64 {
        let one = |[weight, middle, scale]: &[f64; 3]| weight * student((x - middle) / scale, degrees);
        parts.iter().map(one).sum()
    };
    let end = |sign: f64| parts.iter().map(move |[_, middle, scale]| middle + sign * FARTHEST * scale);
    let (mut low, mut high) =
        (end(-1.0).fold(f64::INFINITY, f64::min), end(1.0).fold(f64::NEG_INFINITY, f64::max));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if below(middle) < probability { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Probability that a Student variable is less than `x`; its square has the F distribution.
fn student(x: f64, degrees: f64) -> f64 {
    let farther = distributions::f_tails(x * x, 1.0, degrees)
        .map_or(if x == 0.0 { 1.0 } else { 0.0 }, |tails| tails[1]);
    if x > 0.0 { 1.0 - 0.5 * farther } else { 0.5 * farther }
}
