//! Least squares for a set of terms, and the search for correlation time and frequency.
//!
//! For given shapes the squares follow by [`nnls()`], which leaves χ² as a function of the logarithms of the shapes
//! alone (variable projection; Golub and Pereyra 1973). It has more than one minimum, so a grid is searched first, then
//! golden sections around its best point.

use crate::fit::{Covariance, Curve};
use sagnac_theory::allan::Term;
use sagnac_theory::cholesky;

/// Golden sections of one bracket, which reduce it to 1e-8 of its length.
const SECTIONS: usize = 40;
/// Most rounds over several shapes, followed by the change of a logarithm that counts as none. A strong sine fits at no
/// frequency between those of the grid, and the best correlation time there can be many steps from that at the correct
/// frequency.
const ROUNDS: usize = 40;
const NEAR: f64 = 1e-6;

/// Columns of one term, each with its shape.
pub(crate) type Columns = Vec<(f64, Vec<f64>)>;

/// Contributions of terms of unit square to each point, (″/s)²; they are the same for all curves of one geometry.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Basis {
    /// The terms with their shapes, evenly spaced in their logarithm; a term without shape has the single shape 1.
    terms: Vec<(Term, Columns)>,
}

impl Basis {
    /// The columns of these terms over a curve.
    pub(crate) fn new(curve: &Curve, terms: &[Term]) -> Basis {
        let of_term = |&term: &Term| {
            let column = |shape: f64| (shape, curve.of_term(term, 1.0, shape));
            (term, shapes(curve, term).into_iter().map(column).collect())
        };
        Basis { terms: terms.iter().map(of_term).collect() }
    }

    /// The basis with every column changed by `change`.
    pub(crate) fn map(&self, change: impl Fn(&[f64]) -> Vec<f64>) -> Basis {
        let of_term = |(term, columns): &(Term, Columns)| {
            (*term, columns.iter().map(|(shape, column)| (*shape, change(column))).collect())
        };
        Basis { terms: self.terms.iter().map(of_term).collect() }
    }

    /// The columns of a term with their shapes; empty for a term outside the basis.
    pub(crate) fn of(&self, term: Term) -> &[(f64, Vec<f64>)] {
        self.terms.iter().find(|(other, _)| *other == term).map_or(&[], |(_, columns)| columns)
    }
}

fn shapes(curve: &Curve, term: Term) -> Vec<f64> {
    if !term.has_shape() {
        return vec![1.0];
    }
    let [low, high] = shape_range(curve, term);
    let count = libm::ceil(libm::log10(high / low) * per_decade(term)).max(1.0);
    (0..=count as u32).map(|i| low * libm::pow(high / low, f64::from(i) / count)).collect()
}

/// Shortest and longest shape that a curve can resolve: times T_c within its τ, or frequencies with a hump within them;
/// 1 for terms without shape.
///
/// Markov noise outside this range looks like a random walk or white noise to the curve, and a slower sine like a ramp.
pub(crate) fn shape_range(curve: &Curve, term: Term) -> [f64; 2] {
    term.shape().map_or([1.0; 2], |shape| (shape.range)(curve.tau_range()))
}

/// Grid points of shapes per decade.
fn per_decade(term: Term) -> f64 {
    term.shape().map_or(1.0, |shape| shape.per_decade)
}

/// A term of a fit: the square of its coefficient, and its shape (1 where it has none).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fitted {
    /// Term.
    pub term: Term,
    /// Square of the coefficient.
    pub square: f64,
    /// Correlation time, s, or frequency, Hz.
    pub shape: f64,
}

/// The least-squares solution for some terms.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solution {
    /// Terms in the given order, including those with a square of 0.
    pub terms: Vec<Fitted>,
    /// Weighted sum of squared residuals.
    pub chi_squared: f64,
}

/// A curve with the weights of its points.
pub(crate) struct System<'a> {
    curve: &'a Curve,
    covariance: &'a Covariance,
    target: Vec<f64>,
    /// Columns in standard deviations of independent points.
    basis: Basis,
}

impl<'a> System<'a> {
    /// The system of a curve for the terms of a basis.
    pub(crate) fn new(curve: &'a Curve, covariance: &'a Covariance, basis: &Basis) -> System<'a> {
        let basis = basis.map(|column| covariance.whiten(column));
        System { curve, covariance, target: covariance.whiten(curve.variances()), basis }
    }

    /// The curve that is fitted.
    pub(crate) fn curve(&self) -> &Curve {
        self.curve
    }

    /// A term of unit square, in standard deviations of independent points.
    pub(crate) fn column(&self, term: Term, shape: f64) -> Vec<f64> {
        match self.basis.of(term) {
            [(_, column)] if !term.has_shape() => column.clone(),
            _ => self.covariance.whiten(&self.curve.of_term(term, 1.0, shape)),
        }
    }

    /// Converts the coefficients of a linear function of such deviations to those of the points of the curve.
    pub(crate) fn weights(&self, coefficients: Vec<f64>) -> Vec<f64> {
        self.covariance.before_whitening(coefficients)
    }

    /// Residuals of a solution, in the same units.
    pub(crate) fn residual(&self, terms: &[Fitted]) -> Vec<f64> {
        let mut residual = self.target.clone();
        for fitted in terms.iter().filter(|fitted| fitted.square > 0.0) {
            let column = self.column(fitted.term, fitted.shape);
            residual.iter_mut().zip(&column).for_each(|(left, x)| *left -= fitted.square * x);
        }
        residual
    }

    /// The least-squares solution for `terms` with the best shapes.
    pub(crate) fn best(&self, terms: &[Term]) -> Solution {
        let places: Vec<usize> = (0..terms.len()).filter(|&i| terms[i].has_shape()).collect();
        let mut columns: Vec<Vec<f64>> = terms.iter().map(|&term| self.column(term, 1.0)).collect();
        let grids: Vec<&[(f64, Vec<f64>)]> = places.iter().map(|&i| self.basis.of(terms[i])).collect();
        let mut best = (f64::INFINITY, vec![0; places.len()]);
        let points: usize = grids.iter().map(|grid| grid.len()).product();
        for point in 0..points {
            let mut rest = point;
            let mut at = Vec::with_capacity(places.len());
            for (&place, grid) in places.iter().zip(&grids) {
                at.push(rest % grid.len());
                columns[place].clone_from(&grid[rest % grid.len()].1);
                rest /= grid.len();
            }
            let chi_squared = self.solve(&columns).1;
            if chi_squared < best.0 {
                best = (chi_squared, at);
            }
        }
        let mut shapes = vec![1.0; terms.len()];
        for ((&place, grid), &at) in places.iter().zip(&grids).zip(&best.1) {
            shapes[place] = grid[at].0;
        }
        self.refine(terms, &places, &mut shapes, &mut columns);
        self.given(terms, &shapes)
    }

    /// The least-squares solution for `terms` with these shapes.
    pub(crate) fn given(&self, terms: &[Term], shapes: &[f64]) -> Solution {
        let columns: Vec<Vec<f64>> =
            terms.iter().zip(shapes).map(|(&term, &shape)| self.column(term, shape)).collect();
        let (squares, chi_squared) = self.solve(&columns);
        let each = terms.iter().zip(squares).zip(shapes);
        let terms = each.map(|((&term, square), &shape)| Fitted { term, square, shape }).collect();
        Solution { terms, chi_squared }
    }

    fn solve(&self, columns: &[Vec<f64>]) -> (Vec<f64>, f64) {
        let squares = nnls(columns, &self.target);
        let mut residual = self.target.clone();
        for (column, square) in columns.iter().zip(&squares).filter(|(_, square)| **square > 0.0) {
            residual.iter_mut().zip(column).for_each(|(left, x)| *left -= square * x);
        }
        (squares, dot(&residual, &residual))
    }

    /// Refines one shape after the other by golden sections within one grid step to either side, until none moves.
    fn refine(&self, terms: &[Term], places: &[usize], shapes: &mut [f64], columns: &mut [Vec<f64>]) {
        let mut at = |place: usize, logarithm: f64| {
            columns[place] = self.column(terms[place], libm::exp(logarithm));
            self.solve(columns).1
        };
        let rounds = if places.len() > 1 { ROUNDS } else { 1 };
        for _ in 0..rounds {
            let before = shapes.to_vec();
            for &place in places {
                let [least, most] = shape_range(self.curve, terms[place]).map(libm::log);
                let step = core::f64::consts::LN_10 / per_decade(terms[place]);
                let start = libm::log(shapes[place]);
                let (low, high) = ((start - step).max(least), (start + step).min(most));
                let logarithm = golden(low, high, SECTIONS, |logarithm| at(place, logarithm));
                shapes[place] = libm::exp(logarithm);
                at(place, libm::log(shapes[place]));
            }
            let change = |(shape, before): (&f64, &f64)| libm::fabs(libm::log(shape / before));
            if shapes.iter().zip(&before).map(change).fold(0.0, f64::max) < NEAR {
                break;
            }
        }
    }
}

/// The place of the minimum between two ends, by golden sections.
pub(crate) fn golden(mut low: f64, mut high: f64, sections: usize, mut of: impl FnMut(f64) -> f64) -> f64 {
    let ratio = 0.5 * (libm::sqrt(5.0) - 1.0);
    let mut inner = [high - ratio * (high - low), low + ratio * (high - low)];
    let mut values = inner.map(&mut of);
    for _ in 0..sections {
        if values[0] <= values[1] {
            high = inner[1];
            inner = [high - ratio * (high - low), inner[0]];
            values = [of(inner[0]), values[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + ratio * (high - low)];
            values = [values[1], of(inner[1])];
        }
    }
    0.5 * (low + high)
}

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
