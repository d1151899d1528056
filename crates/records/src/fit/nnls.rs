//! Least squares with non-negative coefficients.

use sagnac_theory::cholesky;

/// Relative gradient below which a coefficient stays 0, because it may be rounding.
const ROUNDING: f64 = 1e-12;

/// Steps per column after which only rounding keeps the method going.
const STEPS: usize = 8;

/// The x ≥ 0 that minimizes |Ax − b|², where `columns` are those of A.
///
/// The method is the active-set method of Lawson and Hanson (Solving Least Squares Problems, 1974, ch. 23) on normal
/// equations with columns scaled to length 1. Coefficients are accurate to rounding times the squared condition number
/// of the scaled columns. A column that depends on those in use to working precision stays out.
pub fn nnls(columns: &[Vec<f64>], b: &[f64]) -> Vec<f64> {
    let lengths: Vec<f64> = columns.iter().map(|column| libm::sqrt(dot(column, column))).collect();
    let is_usable = |j: usize| lengths[j].is_finite() && lengths[j] > 0.0;
    let gram = |i: usize, j: usize| dot(&columns[i], &columns[j]) / (lengths[i] * lengths[j]);
    let gram: Vec<Vec<f64>> =
        (0..columns.len()).map(|i| (0..columns.len()).map(|j| gram(i, j)).collect()).collect();
    let onto: Vec<f64> =
        columns.iter().zip(&lengths).map(|(column, length)| dot(column, b) / length).collect();
    let least_gradient = ROUNDING * libm::sqrt(dot(b, b));
    let mut x = vec![0.0; columns.len()];
    let mut used: Vec<usize> = Vec::new();
    let mut refused: Vec<usize> = Vec::new();
    // Every step decreases the residual, so no set of columns occurs twice except through rounding.
    for _ in 0..STEPS * columns.len() {
        let gradient = |j: usize| onto[j] - used.iter().map(|&i| gram[j][i] * x[i]).sum::<f64>();
        let candidates =
            (0..columns.len()).filter(|j| is_usable(*j) && !used.contains(j) && !refused.contains(j));
        let steepest = candidates.map(|j| (j, gradient(j))).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((entering, _)) = steepest.filter(|(_, gradient)| *gradient > least_gradient) else { break };
        used.push(entering);
        let Some(mut solution) = solve(&gram, &onto, &used).filter(|solution| solution[used.len() - 1] > 0.0)
        else {
            // The column depends on the others, or entered only through rounding.
            used.pop();
            refused.push(entering);
            continue;
        };
        refused.clear();
        // Columns that the new one makes negative leave where the path towards the solution reaches 0.
        while solution.iter().any(|value| *value <= 0.0) {
            let to_zero = |(&j, value): (&usize, &f64)| (*value <= 0.0).then(|| (x[j] / (x[j] - value), j));
            let mut ends: Vec<(f64, usize)> = used.iter().zip(&solution).filter_map(to_zero).collect();
            ends.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (step, leaving) = ends[0];
            for (&j, value) in used.iter().zip(&solution) {
                x[j] = (x[j] + step * (value - x[j])).max(0.0);
            }
            x[leaving] = 0.0;
            used.retain(|j| *j != leaving);
            match solve(&gram, &onto, &used) {
                Some(next) => solution = next,
                None => return unscaled(x, &lengths),
            }
        }
        for (&j, value) in used.iter().zip(&solution) {
            x[j] = *value;
        }
    }
    unscaled(x, &lengths)
}

fn unscaled(x: Vec<f64>, lengths: &[f64]) -> Vec<f64> {
    x.iter().zip(lengths).map(|(x, length)| if *x > 0.0 { x / length } else { 0.0 }).collect()
}

/// The least-squares solution for the columns in use.
fn solve(gram: &[Vec<f64>], onto: &[f64], used: &[usize]) -> Option<Vec<f64>> {
    let factor = cholesky::definite(used.len(), |i, j| gram[used[i]][used[j]])?;
    Some(cholesky::solve(&factor, used.iter().map(|&j| onto[j]).collect()))
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_satisfies_the_conditions_of_a_constrained_minimum() {
        // Deterministic columns and right-hand sides of every sign.
        let number = |seed: u32| libm::sin(f64::from(seed * seed % 7919) + 0.1 * f64::from(seed));
        for case in 0..200 {
            let columns: Vec<Vec<f64>> =
                (0..6).map(|j| (0..9).map(|i| number(1 + case * 101 + j * 17 + i)).collect()).collect();
            let b: Vec<f64> = (0..9).map(|i| number(7 + case * 31 + i * 5)).collect();
            let x = nnls(&columns, &b);
            let residual: Vec<f64> = (0..9)
                .map(|i| b[i] - columns.iter().zip(&x).map(|(column, x)| column[i] * x).sum::<f64>())
                .collect();
            for (j, (column, x)) in columns.iter().zip(&x).enumerate() {
                let gradient = dot(column, &residual);
                let is_minimum = *x >= 0.0 && gradient < 1e-9 && (*x == 0.0 || gradient.abs() < 1e-9);
                assert!(is_minimum, "case {case}, column {j}: x = {x}, gradient {gradient}");
            }
        }
    }

    #[test]
    fn dependent_and_empty_columns_stay_out() {
        let columns = [vec![1.0, 2.0, 3.0], vec![2.0, 4.0, 6.0], vec![0.0; 3], vec![f64::NAN; 3]];
        let x = nnls(&columns, &[1.0, 2.0, 3.0]);
        let sum = x[0] + 2.0 * x[1];
        assert!((sum - 1.0).abs() < 1e-12 && x[2] == 0.0 && x[3] == 0.0, "{x:?}");
        assert_eq!(nnls(&columns, &[-1.0, -2.0, -3.0]), [0.0; 4]);
    }
}
