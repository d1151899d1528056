//! Lower triangular factors of covariance matrices, computed in a fixed order.

/// Smallest pivot relative to the diagonal; anything below is rounding.
const LEAST_PIVOT: f64 = 1e-13;

/// The factor of a positive definite matrix, row by row; `None` where the matrix is not positive definite to working
/// precision.
pub fn definite(count: usize, matrix: impl Fn(usize, usize) -> f64) -> Option<Vec<Vec<f64>>> {
    let factor = semidefinite(count, matrix);
    factor.iter().enumerate().all(|(i, row)| row[i] > 0.0).then_some(factor)
}

/// The factor of a positive semidefinite matrix; rows that depend on those before have 0 on the diagonal.
pub fn semidefinite(count: usize, matrix: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(count);
    for i in 0..count {
        let mut row: Vec<f64> = Vec::with_capacity(i + 1);
        for above in &factor {
            let j = row.len();
            let known: f64 = (0..j).map(|k| row[k] * above[k]).sum();
            row.push(if above[j] > 0.0 { (matrix(i, j) - known) / above[j] } else { 0.0 });
        }
        let pivot = matrix(i, i) - row.iter().map(|x| x * x).sum::<f64>();
        row.push(if pivot > LEAST_PIVOT * matrix(i, i) { libm::sqrt(pivot) } else { 0.0 });
        factor.push(row);
    }
    factor
}

/// Solves L Lᵀ x = b for a factor L of a positive definite matrix.
pub fn solve(factor: &[Vec<f64>], b: Vec<f64>) -> Vec<f64> {
    solve_transposed(factor, whiten(factor, b))
}

/// Solves L x = b. For a b with the covariance L Lᵀ, x consists of independent numbers of variance 1.
pub fn whiten(factor: &[Vec<f64>], mut x: Vec<f64>) -> Vec<f64> {
    for i in 0..x.len() {
        let known: f64 = (0..i).map(|k| factor[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / factor[i][i];
    }
    x
}

/// Solves Lᵀ x = b.
pub fn solve_transposed(factor: &[Vec<f64>], mut x: Vec<f64>) -> Vec<f64> {
    let count = x.len();
    for i in (0..count).rev() {
        let known: f64 = (i + 1..count).map(|k| factor[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / factor[i][i];
    }
    x
}
