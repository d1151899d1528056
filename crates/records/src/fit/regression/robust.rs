//! Whether the noise describes a record, and intervals where it does not.

use crate::fit::nnls::dot;
use crate::fit::regression::{Posterior, Regression};
use crate::fit::survival;
use sagnac_theory::cholesky;

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
