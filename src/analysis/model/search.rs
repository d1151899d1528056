//! The search for a model, by least squares with constraints.

use crate::analysis::model::target::{Target, White, repeated};
use crate::analysis::model::{Aim, Markov, Model, ModelError, ModelRequest};
use rayon::prelude::*;
use sagnac_base::quantity::number::significant;
use sagnac_records::fit::nnls;
use sagnac_theory::allan::Part;
use sagnac_theory::{allan, cholesky};
use serde::Serialize;

/// Correlation times that are tried in each decade of τ.
pub const PER_DECADE: f64 = 6.0;
/// Most Markov states.
pub const MAX_STATES: usize = 3;
/// Most rows of a problem; of longer curves some points are left to the common factor at the end.
const MAX_ROWS: usize = 48;

/// Part of the excess to which a state has to lower it to be worth its place.
const WORTH: f64 = 0.9;

/// Part of the interval of N in which that of a description stays: the ends from simulated records, which `sagnac allan` gives, differ
/// a little from those in closed form.
const INSIDE: f64 = 0.9;

/// Factor for dips of a bound between two points of the curve.
const BETWEEN: f64 = 1.0001;
/// Least scale of a row, as a part of the variance of the curve.
const MIN_SCALE: f64 = 1e-9;

/// A model with how it lies to its target.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The model.
    pub model: Model,
    /// What each number of states from 0 on reaches, up to that of the model.
    pub tried: Vec<Tried>,
    /// The target of the bound at each point: the upper end of the band, or that of a repetition, in the unit of the curve.
    pub bounds: Vec<f64>,
}

/// The best model with a number of states. All numbers are absent where no model is possible.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct Tried {
    /// Number of Markov states.
    pub states: usize,
    /// How far it lies at most above the record, as a part: of the model that was found, its `largest_excess`.
    pub largest_excess: Option<f64>,
    /// How far a bound lies at most above what it bounds, as a part: of the model that was found, its `largest_excess_over_bound`.
    pub largest_excess_over_bound: Option<f64>,
    /// How far it lies at most above what it bounds, both without the quantization, as a part: states are added until this is within
    /// the margin.
    pub excess_without_quantization: Option<f64>,
}

impl Found {
    /// The largest excess over the curve of the record, with its τ.
    pub fn over_record(&self, target: &Target) -> [f64; 2] {
        over(&self.model, target, |i| target.points[i].value)
    }

    /// The largest shortfall below the curve of the record, with its τ; negative where the model is nowhere below.
    pub fn below_record(&self, target: &Target) -> [f64; 2] {
        let [least, tau_s] = lowest(&self.model, target, |i| target.points[i].value);
        [-least, tau_s]
    }

    /// The largest excess over what is bounded, with its τ.
    pub fn over_bound(&self, target: &Target) -> [f64; 2] {
        over(&self.model, target, |i| self.bounds[i])
    }
}

/// How far the deviation of a model lies above another one at each point, as a part, with its τ.
fn excesses(model: &Model, target: &Target, of: impl Fn(usize) -> f64) -> impl Iterator<Item = [f64; 2]> {
    let points = target.points.iter().enumerate();
    points.map(move |(i, point)| [model.deviation(point.tau_s) / of(i) - 1.0, point.tau_s])
}

fn over(model: &Model, target: &Target, of: impl Fn(usize) -> f64) -> [f64; 2] {
    excesses(model, target, of).max_by(|a, b| a[0].total_cmp(&b[0])).unwrap_or([0.0; 2])
}

fn lowest(model: &Model, target: &Target, of: impl Fn(usize) -> f64) -> [f64; 2] {
    excesses(model, target, of).min_by(|a, b| a[0].total_cmp(&b[0])).unwrap_or([0.0; 2])
}

/// The columns that a model may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Allowed<'a> {
    pub(crate) walk: bool,
    pub(crate) states: usize,
    pub(crate) times: &'a [f64],
}

/// What the model must reach at some averaging times: bounds of the variance, without the quantization.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Problem {
    pub(crate) taus: Vec<f64>,
    /// The variance to which rows are relative.
    pub(crate) scale: Vec<f64>,
    pub(crate) goal: Vec<f64>,
    pub(crate) least: Vec<f64>,
    pub(crate) most: Vec<f64>,
    /// N² of the white noise, with the ends between which it has to stay; absent where it is free.
    pub(crate) white: Option<[f64; 3]>,
}

/// The model of a target: one whose N is within the interval of that of the record, if such a description is possible.
///
/// # Errors
/// No model lies within the band, or there is no record whose repetition could be bounded.
pub(crate) fn find(target: &Target, request: &ModelRequest) -> Result<Found, ModelError> {
    let bounds = match request.aim {
        Aim::BoundRepeat => repeated(target, request.confidence)?,
        Aim::Describe | Aim::Bound => target.points.iter().map(|point| point.upper).collect(),
    };
    let free = problem(target, &bounds, request.aim);
    let times = times(target.taus(), target.step_s);
    let white = target.white.filter(|_| request.aim == Aim::Describe);
    let held = white.map(|White { value, interval: ends, .. }| {
        let [least, most] = ends.map(|end| value + INSIDE * (end - value));
        Problem { white: Some([value, least, most].map(|n| n * n)), ..free.clone() }
    });
    let found = held.and_then(|held| search(&held, target, &bounds, &times, request));
    let found = found.or_else(|| search(&free, target, &bounds, &times, request));
    found.ok_or_else(|| outside(target, &bounds, &times, request.states.unwrap_or(MAX_STATES)))
}

/// The model of the fewest states that solves a problem well enough, or else the nearest; `None` where none is possible.
fn search(
    problem: &Problem,
    target: &Target,
    bounds: &[f64],
    times: &[f64],
    request: &ModelRequest,
) -> Option<Found> {
    let is_bound = request.aim != Aim::Describe;
    // A bound may rise, and white noise of the record is no Markov noise.
    let least_white = target.white.filter(|_| is_bound).map_or(0.0, |white| white.value);
    let quantization = quantization(target, request.aim);
    let mut tried: Vec<Tried> = Vec::new();
    let mut best: Option<(f64, Model)> = None;
    for states in request.states.map_or(0..=MAX_STATES, |states| states..=states) {
        let found = problem.best(Allowed { walk: true, states, times });
        let excess = found.as_ref().map(|model| problem.excess(model));
        let model = found.map(|model| Model { quantization, white: model.white.max(least_white), ..model });
        let bounded = model.as_ref().filter(|_| is_bound);
        tried.push(Tried {
            states,
            largest_excess: model.as_ref().map(|model| over(model, target, |i| target.points[i].value)[0]),
            largest_excess_over_bound: bounded.map(|model| over(model, target, |i| bounds[i])[0]),
            excess_without_quantization: excess.filter(|_| is_bound),
        });
        let Some((excess, model)) = excess.zip(model) else { continue };
        let is_enough = !is_bound || excess <= request.margin;
        if best.as_ref().is_none_or(|(before, _)| excess < WORTH * *before) {
            best = Some((excess, model));
        }
        if is_enough {
            break;
        }
    }
    best.map(|(_, model)| Found { model, tried, bounds: bounds.to_vec() })
}

/// The problem that a target poses: its variances less that of the quantization. A record shows what is left only to the width of its
/// band, which is therefore the least scale.
fn problem(target: &Target, bounds: &[f64], aim: Aim) -> Problem {
    let q = Part::quantization(quantization(target, aim));
    let square = |x: f64| x * x;
    let left = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let points = target.points.iter().enumerate();
        let quantized = |tau_s: f64| allan::continuous_variance(&q, tau_s).unwrap_or(0.0);
        points.map(|(i, point)| (square(of(i)) - quantized(point.tau_s)).max(0.0)).collect()
    };
    let points = &target.points;
    let (goal, least, most) = match aim {
        Aim::Describe => (left(&|i| points[i].value), left(&|i| points[i].lower), left(&|i| points[i].upper)),
        Aim::Bound | Aim::BoundRepeat => {
            let bounds = left(&|i| bounds[i]);
            let open = vec![f64::INFINITY; bounds.len()];
            (bounds.clone(), bounds, open)
        }
    };
    let scale = goal.iter().zip(points).map(|(goal, point)| {
        let width = square(point.upper) - square(point.lower);
        goal.max(width).max(MIN_SCALE * square(point.value))
    });
    Problem {
        taus: points.iter().map(|point| point.tau_s).collect(),
        scale: scale.collect(),
        goal,
        least,
        most,
        white: None,
    }
}

/// Q of the model of a target.
fn quantization(target: &Target, aim: Aim) -> f64 {
    let [value, upper] = target.quantization.unwrap_or_default();
    if aim == Aim::Describe { value } else { upper }
}

/// The correlation times that are tried between two times: from half the shorter one on, but no shorter than two samples of a record,
/// which a filter at its rate cannot follow.
pub(crate) fn times([from_s, to_s]: [f64; 2], step_s: Option<f64>) -> Vec<f64> {
    let least = libm::fmax(0.5 * from_s, 2.0 * step_s.unwrap_or(0.0));
    let count = libm::ceil(PER_DECADE * libm::log10(to_s / least).max(0.0)) as u32;
    (0..=count).map(|i| least * libm::exp10(f64::from(i) / PER_DECADE)).collect()
}

impl Problem {
    /// The best model with exactly this number of states; `None` where none is possible.
    pub(crate) fn best(&self, allowed: Allowed) -> Option<Model> {
        let step = self.taus.len().div_ceil(MAX_ROWS).max(1);
        let mut rows: Vec<usize> = (0..self.taus.len()).step_by(step).collect();
        if rows.last() != Some(&(self.taus.len() - 1)) {
            rows.push(self.taus.len() - 1);
        }
        let column = |part: Part| -> Vec<f64> {
            let at =
                |&i: &usize| allan::continuous_variance(&part, self.taus[i]).unwrap_or(0.0) / self.scale[i];
            rows.iter().map(at).collect()
        };
        let relative = |of: &[f64]| rows.iter().map(|&i| of[i] / self.scale[i]).collect::<Vec<f64>>();
        let [mut goal, mut lower, mut upper] = [&self.goal, &self.least, &self.most].map(|of| relative(of));
        let shared = [Part::angle_random_walk(1.0), Part::rate_random_walk(1.0)];
        let mut shared: Vec<Vec<f64>> =
            shared.into_iter().take(1 + usize::from(allowed.walk)).map(column).collect();
        let mut of_times: Vec<Vec<f64>> = allowed.times.iter().map(|&time_s| column(unit(time_s))).collect();
        // A row for N, which the other columns do not have.
        if let Some([white, least, most]) = self.white {
            goal.push(1.0);
            lower.push(least / white);
            upper.push(most / white);
            shared.iter_mut().chain(&mut of_times).for_each(|column| column.push(0.0));
            shared[0][goal.len() - 1] = 1.0 / white;
        }
        let solve = |choice: &Vec<usize>| {
            let columns: Vec<Vec<f64>> =
                shared.iter().chain(choice.iter().map(|&place| &of_times[place])).cloned().collect();
            let x = least(&columns, &Rows { goal: &goal, least: &lower, most: &upper })?;
            let miss =
                |i: usize| columns.iter().zip(&x).map(|(column, x)| column[i] * x).sum::<f64>() - goal[i];
            let cost: f64 = (0..goal.len()).map(|i| miss(i) * miss(i)).sum();
            Some((cost, x))
        };
        let choices = choices(allowed.times.len(), allowed.states);
        let solved: Vec<Option<(f64, Vec<f64>)>> = choices.par_iter().map(solve).collect();
        let solved = solved.into_iter().zip(&choices).filter_map(|(solved, choice)| Some((solved?, choice)));
        let ((_, x), choice) = solved.min_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
        let of_states = x[shared.len()..].iter().zip(choice).filter(|(square, _)| **square > 0.0);
        let state = |(square, &place): (&f64, &usize)| Markov {
            sigma: libm::sqrt(*square),
            time_s: allowed.times[place],
        };
        let model = Model {
            white: libm::sqrt(x[0]),
            walk: if allowed.walk { libm::sqrt(x[1]) } else { 0.0 },
            markov: of_states.map(state).collect(),
            quantization: 0.0,
        };
        Some(self.raised(model))
    }

    /// The model raised by a common factor to the lower ends between the rows of the problem, and a bound beyond dips between them.
    fn raised(&self, model: Model) -> Model {
        let lacking = self.taus.iter().zip(&self.least).map(|(&tau_s, &least)| least / model.variance(tau_s));
        // A description has upper ends, which nothing may pass.
        let between = if self.most.iter().all(|most| most.is_infinite()) { BETWEEN } else { 1.0 };
        let factor = between * libm::sqrt(lacking.fold(1.0, f64::max));
        let markov = |state: &Markov| Markov { sigma: factor * state.sigma, ..*state };
        Model {
            white: factor * model.white,
            walk: factor * model.walk,
            markov: model.markov.iter().map(markov).collect(),
            quantization: model.quantization,
        }
    }

    /// How far a deviation lies at most above the scale.
    fn excess(&self, model: &Model) -> f64 {
        let ratio = |(&tau_s, scale): (&f64, &f64)| libm::sqrt(model.variance(tau_s) / scale) - 1.0;
        self.taus.iter().zip(&self.scale).map(ratio).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A Markov state of variance 1.
fn unit(time_s: f64) -> Part {
    Part::markov(libm::sqrt(2.0 / time_s), time_s)
}

/// All choices of `taken` of `count` places, in order.
fn choices(count: usize, taken: usize) -> Vec<Vec<usize>> {
    let mut all = vec![vec![]];
    for _ in 0..taken {
        all = all
            .into_iter()
            .flat_map(|choice: Vec<usize>| {
                let next = choice.last().map_or(0, |last| last + 1);
                (next..count).map(move |place| [choice.clone(), vec![place]].concat())
            })
            .collect();
    }
    all
}

/// Where the nearest model leaves the band: that of least squares of most states.
fn outside(target: &Target, bounds: &[f64], times: &[f64], states: usize) -> ModelError {
    let open = Problem {
        least: vec![0.0; bounds.len()],
        most: vec![f64::INFINITY; bounds.len()],
        ..problem(target, bounds, Aim::Describe)
    };
    let nearest = open.best(Allowed { walk: true, states, times }).unwrap_or_default();
    let nearest = Model { quantization: quantization(target, Aim::Describe), ..nearest };
    let off = target.points.iter().map(|point| {
        let deviation = nearest.deviation(point.tau_s);
        [(deviation / point.upper).max(point.lower / deviation) - 1.0, point.tau_s]
    });
    let [percent, tau_s] = off.max_by(|a, b| a[0].total_cmp(&b[0])).unwrap_or_default();
    let [from_s, to_s] = target.taus();
    let shown = |x: f64| significant(x, 4).into();
    ModelError::NotWithin {
        column: target.name.as_str().into(),
        most: states,
        from_s: shown(from_s),
        to_s: shown(to_s),
        tau_s: shown(tau_s),
        percent: significant(100.0 * percent.max(0.0), 2).into(),
    }
}

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
