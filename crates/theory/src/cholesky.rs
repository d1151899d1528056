//! Lower triangular factors of covariance matrices, computed in a fixed order.

/// Smallest pivot relative to the diagonal; anything below is rounding.
const MIN_PIVOT: f64 = 1e-13;

/// The factor of a positive definite matrix, row by row; `None` where the matrix is not positive definite to working
/// precision.
pub fn definite(count: usize, matrix: impl Fn(usize, usize) -> f64) -> Option<Vec<Vec<f64>>> {
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(count);
    for i in 0..count {
        let mut row: Vec<f64> = Vec::with_capacity(i + 1);
        for above in &factor {
            let j = row.len();
            let known: f64 = (0..j).map(|k| row[k] * above[k]).sum();
            row.push((matrix(i, j) - known) / above[j]);
        }
        let pivot = matrix(i, i) - row.iter().map(|x| x * x).sum::<f64>();
        if pivot <= MIN_PIVOT * matrix(i, i) || pivot.is_nan() {
            return None;
        }
        row.push(libm::sqrt(pivot));
        factor.push(row);
    }
    Some(factor)
}

/// Rows whose products are the numbers of a positive semidefinite matrix, with as many numbers as the matrix has rank.
///
/// The largest pivot comes first, so that what is left out is at most as large as the rounding of the largest number.
pub fn semidefinite(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let count = matrix.len();
    let mut rows = vec![Vec::with_capacity(count); count];
    let mut pivots: Vec<f64> = (0..count).map(|i| matrix[i][i]).collect();
    let least = pivots.iter().fold(0.0, |most: f64, x| most.max(*x)) * count as f64 * f64::EPSILON;
    for _ in 0..count {
        let Some(next) = (0..count).max_by(|&i, &j| pivots[i].total_cmp(&pivots[j])) else { break };
        if pivots[next] <= least {
            break;
        }
        let pivot = libm::sqrt(pivots[next]);
        let chosen: Vec<f64> = rows[next].clone();
        for i in 0..count {
            let known: f64 = rows[i].iter().zip(&chosen).map(|(a, b)| a * b).sum();
            let x = if i == next { pivot } else { (matrix[i][next] - known) / pivot };
            rows[i].push(x);
            pivots[i] -= x * x;
        }
        pivots[next] = f64::NEG_INFINITY;
    }
    rows
}

/// Solves L Lᵀ x = b for a factor L of a positive definite matrix.
pub fn solve(factor: &[impl AsRef<[f64]>], b: Vec<f64>) -> Vec<f64> {
    solve_transposed(factor, whiten(factor, b))
}

/// Solves L x = b. For a b with the covariance L Lᵀ, x consists of independent numbers of variance 1.
pub fn whiten(factor: &[impl AsRef<[f64]>], mut x: Vec<f64>) -> Vec<f64> {
    for i in 0..x.len() {
        let row = factor[i].as_ref();
        let known: f64 = (0..i).map(|k| row[k] * x[k]).sum();
        x[i] = (x[i] - known) / row[i];
    }
    x
}

/// Solves Lᵀ x = b.
pub fn solve_transposed(factor: &[impl AsRef<[f64]>], mut x: Vec<f64>) -> Vec<f64> {
    let count = x.len();
    for i in (0..count).rev() {
        let known: f64 = (i + 1..count).map(|k| factor[k].as_ref()[i] * x[k]).sum();
        x[i] = (x[i] - known) / factor[i].as_ref()[i];
    }
    x
}

/// The inverse of L Lᵀ, row by row.
pub fn inverse(factor: &[Vec<f64>]) -> Vec<f64> {
    let count = factor.len();
    let mut inverse = vec![0.0; count * count];
    // The rows of the inverse of L.
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(count);
    for (i, of_factor) in factor.iter().enumerate() {
        let mut row = vec![0.0; i + 1];
        for (above, size) in rows.iter().zip(of_factor) {
            row.iter_mut().zip(above).for_each(|(x, y)| *x -= size * y);
        }
        row[i] = 1.0;
        row.iter_mut().for_each(|x| *x /= of_factor[i]);
        for (j, x) in row.iter().enumerate() {
            inverse[j * count..].iter_mut().zip(&row).for_each(|(sum, y)| *sum += x * y);
        }
        rows.push(row);
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_times_the_matrix_is_one() {
        let at = |i: usize, j: usize| 1.0 / (1 + i + j) as f64 + f64::from(u8::from(i == j));
        let inverse = inverse(&definite(6, at).unwrap());
        for i in 0..6 {
            for j in 0..6 {
                let cell: f64 = (0..6).map(|k| inverse[6 * i + k] * at(k, j)).sum();
                assert!((cell - f64::from(u8::from(i == j))).abs() < 1e-14, "{i}, {j}: {cell}");
            }
        }
    }

    #[test]
    fn rows_of_a_singular_matrix_have_its_numbers_as_products() {
        // Nearly singular: covariances of a narrow band at 30 places.
        let at = |i: usize, j: usize| {
            let lag = i.abs_diff(j) as f64;
            (0..50).map(|k| libm::cos((0.6 + 0.002 * f64::from(k)) * lag)).sum::<f64>()
        };
        let matrix: Vec<Vec<f64>> = (0..30).map(|i| (0..30).map(|j| at(i, j)).collect()).collect();
        let rows = semidefinite(&matrix);
        assert!(rows[0].len() < 16, "{}", rows[0].len());
        for (i, j) in (0..30).flat_map(|i| (0..30).map(move |j| (i, j))) {
            let product: f64 = rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum();
            assert!((product - matrix[i][j]).abs() < 1e-12 * matrix[0][0], "{i}, {j}: {product}");
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        let of = |a: f64| definite(2, |i, j| if i == j { 1.0 } else { a });
        assert!(of(0.5).is_some() && of(1.0).is_none() && of(2.0).is_none());
    }
}
