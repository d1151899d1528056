//! Least squares with non-negative coefficients between constraints.

use sagnac_records::fit::nnls;
use sagnac_theory::cholesky;

/// Value of the last residual above which the constraints contradict each other.
const FEASIBLE: f64 = -1e-9;
/// Relative amount by which rounding may violate a constraint.
const ROUNDING: f64 = 1e-6;

/// The rows of a problem: what is aimed at, and between what it has to stay.
pub(crate) struct Rows<'a> {
    pub(crate) goal: &'a [f64],
    pub(crate) least: &'a [f64],
    pub(crate) most: &'a [f64],
}

/// The x ≥ 0 that minimizes |Ax − goal|² under least ≤ Ax ≤ most, where `columns` are those of A and an infinite end is none.
/// `None` where the constraints contradict each other or columns depend on each other.
///
/// The problem is turned into one of least distance, whose dual is non-negative least squares (Lawson and Hanson, Solving Least
/// Squares Problems, 1974, ch. 23). A lower end that rounding has missed is repaired by a common factor, so that a bound is one.
pub(crate) fn least(columns: &[Vec<f64>], rows: &Rows) -> Option<Vec<f64>> {
    let count = columns.len();
    let lengths: Vec<f64> = columns.iter().map(|column| libm::sqrt(dot(column, column))).collect();
    let scaled: Vec<Vec<f64>> = columns
        .iter()
        .zip(&lengths)
        .map(|(column, length)| column.iter().map(|a| a / length).collect())
        .collect();
    let factor = cholesky::definite(count, |i, j| dot(&scaled[i], &scaled[j]))?;
    let start = cholesky::whiten(&factor, scaled.iter().map(|column| dot(column, rows.goal)).collect());
    // Each constraint g·x ≥ h, seen from the unconstrained minimum in coordinates where distances count.
    let seen = |g: Vec<f64>, h: f64| {
        let mut g = cholesky::whiten(&factor, g);
        let h = h - dot(&g, &start);
        g.push(h);
        g
    };
    let row = |i: usize, sign: f64| scaled.iter().map(|column| sign * column[i]).collect::<Vec<f64>>();
    let unit = |j: usize| (0..count).map(|k| f64::from(u8::from(k == j))).collect::<Vec<f64>>();
    let above =
        (0..rows.goal.len()).filter(|&i| rows.least[i] > 0.0).map(|i| seen(row(i, 1.0), rows.least[i]));
    let below =
        (0..rows.goal.len()).filter(|&i| rows.most[i].is_finite()).map(|i| seen(row(i, -1.0), -rows.most[i]));
    let constraints: Vec<Vec<f64>> =
        above.chain(below).chain((0..count).map(|j| seen(unit(j), 0.0))).collect();
    let mut last = vec![0.0; count + 1];
    last[count] = 1.0;
    let weights = nnls(&constraints, &last);
    let residual = |k: usize| -> f64 {
        constraints.iter().zip(&weights).map(|(constraint, weight)| weight * constraint[k]).sum::<f64>()
            - last[k]
    };
    let scale = residual(count);
    if scale > FEASIBLE {
        return None;
    }
    let moved: Vec<f64> = (0..count).map(|k| start[k] - residual(k) / scale).collect();
    let x = cholesky::solve_transposed(&factor, moved);
    let x: Vec<f64> = x.iter().zip(&lengths).map(|(x, length)| x.max(0.0) / length).collect();
    repaired(columns, rows, x)
}

/// The solution with its lower ends met exactly; `None` where it is off by more than rounding.
fn repaired(columns: &[Vec<f64>], rows: &Rows, x: Vec<f64>) -> Option<Vec<f64>> {
    let at = |i: usize| -> f64 { columns.iter().zip(&x).map(|(column, x)| column[i] * x).sum() };
    let lacking = (0..rows.goal.len()).map(|i| if rows.least[i] > 0.0 { rows.least[i] / at(i) } else { 1.0 });
    let factor = lacking.fold(1.0, f64::max);
    let exceeds = (0..rows.goal.len()).any(|i| factor * at(i) > rows.most[i] * (1.0 + ROUNDING));
    (factor <= 1.0 + ROUNDING && !exceeds).then(|| x.iter().map(|x| factor * x).collect())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: f64 = f64::INFINITY;

    #[test]
    fn a_line_over_points_touches_them() {
        // a + bt over 1, 2, 2, 5 at t = 0, 1, 2, 3: least squares would be below the first and the last.
        let columns = [vec![1.0; 4], vec![0.0, 1.0, 2.0, 3.0]];
        let points = [1.0, 2.0, 2.0, 5.0];
        let x = least(&columns, &Rows { goal: &points, least: &points, most: &[OPEN; 4] }).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-6 && (x[1] - 4.0 / 3.0).abs() < 1e-6, "{x:?}");
        assert!((0..4).all(|i| x[0] + x[1] * columns[1][i] >= points[i]), "{x:?}");
    }

    #[test]
    fn random_problems_have_no_better_neighbour() {
        let number = |seed: u32| 0.5 + 0.5 * libm::sin(f64::from(seed * seed % 7919) + 0.1 * f64::from(seed));
        for case in 0..50 {
            let columns: Vec<Vec<f64>> = (0..4)
                .map(|j| (0..12).map(|i| 0.1 + number(1 + case * 101 + j * 17 + i)).collect())
                .collect();
            let goal = [1.0; 12];
            let x = least(&columns, &Rows { goal: &goal, least: &goal, most: &[OPEN; 12] }).unwrap();
            let cost = |x: &[f64]| -> f64 {
                (0..12)
                    .map(|i| (columns.iter().zip(x).map(|(c, x)| c[i] * x).sum::<f64>() - 1.0).powi(2))
                    .sum()
            };
            let is_allowed = |x: &[f64]| {
                x.iter().all(|x| *x >= 0.0)
                    && (0..12)
                        .all(|i| columns.iter().zip(x).map(|(c, x)| c[i] * x).sum::<f64>() > 1.0 - 1e-12)
            };
            assert!(is_allowed(&x), "case {case}: {x:?}");
            // The problem is convex: if no allowed point nearby is better, none is.
            for step in 0..400 {
                let moved: Vec<f64> = x
                    .iter()
                    .zip(0..)
                    .map(|(x, j)| x + 0.02 * (number(step * 31 + j * 7 + case) - 0.5))
                    .collect();
                assert!(
                    !is_allowed(&moved) || cost(&moved) > cost(&x) - 1e-6,
                    "case {case}: {moved:?} beats {x:?}"
                );
            }
        }
    }

    #[test]
    fn contradictions_and_dependent_columns_are_told() {
        let columns = [vec![1.0, 1.0]];
        let apart = Rows { goal: &[1.0, 1.0], least: &[1.0, 3.0], most: &[2.0, 4.0] };
        assert_eq!(least(&columns, &apart), None);
        let twice = [vec![1.0, 2.0, 3.0], vec![2.0, 4.0, 6.0]];
        let open = Rows { goal: &[1.0; 3], least: &[1.0; 3], most: &[OPEN; 3] };
        assert_eq!(least(&twice, &open), None);
    }
}
