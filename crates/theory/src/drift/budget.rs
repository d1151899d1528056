//! The paper's bound of the drift, the interval at which it is least, and approximations of that interval: those of the paper, and
//! corrected ones.

use crate::drift::Magnetic;

/// The parameters of the bound of the drift of a switched gyro.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// The drift that changes its sign with the mode.
    pub magnetic: Magnetic,
    /// Non-magnetic drift Ω_nm, ″/s.
    pub non_magnetic: f64,
    /// Largest error at a switch δP_max, ″.
    pub residual_max: f64,
}

/// The parts of the bound, ″/s, none of them negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Non-magnetic drift Ω_nm, ″/s.
    pub non_magnetic: f64,
    /// Remainder of the warm-up over two opposite intervals, ″/s — Z(4), Z(6).
    pub quasi_non_magnetic: f64,
    /// Drift of an interval that no other one cancels, MT·Ω_m(t)/t, ″/s.
    pub magnetic: f64,
    /// Errors at the switches, all of one sign, δP_max/MT, ″/s.
    pub residual: f64,
}

impl Bound {
    /// Bound of the drift Ω_g(MT), ″/s — Z(7), which is Z(3) plus the quasi-non-magnetic drift.
    pub fn total(&self) -> f64 {
        self.non_magnetic + self.quasi_non_magnetic + self.magnetic + self.residual
    }
}

/// The interval at which a bound is least, with the bound there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optimum {
    /// Switching interval MT, s.
    pub interval_s: f64,
    /// Bound Z(7) at that interval, ″/s.
    pub bound: f64,
}

/// Number of intervals, evenly spaced in their logarithm, among which the lowest minimum is sought.
const GRID: u32 = 512;

impl Budget {
    /// The parts of Z(7) after `t_s` with a switch every `interval_s`. Each is the magnitude of its drift, as the paper
    /// omits the signs; Z(6) prints the second part with a wrong sign and a wrong limit.
    pub fn bound(&self, interval_s: f64, t_s: f64) -> Bound {
        let Magnetic { amplitude, time_s, .. } = self.magnetic;
        let lost = -libm::expm1(-interval_s / time_s);
        Bound {
            non_magnetic: self.non_magnetic.abs(),
            quasi_non_magnetic: amplitude.abs() * time_s / (2.0 * interval_s) * lost * lost,
            magnetic: interval_s * self.magnetic.rate(t_s).abs() / t_s,
            residual: self.residual_max / interval_s,
        }
    }

    /// dΩ_g/d(MT) — Z(8).
    fn slope(&self, interval_s: f64, t_s: f64) -> f64 {
        let Magnetic { amplitude, time_s, .. } = self.magnetic;
        let decay = libm::exp(-interval_s / time_s);
        let lost = -libm::expm1(-interval_s / time_s);
        -(0.5 * amplitude.abs() * time_s * lost * lost + self.residual_max) / (interval_s * interval_s)
            + amplitude.abs() / interval_s * lost * decay
            + self.magnetic.rate(t_s).abs() / t_s
    }

    /// The exact minimum of Z(7) among the intervals up to `t_s`: the root of Z(8), or `t_s` itself where the bound
    /// falls up to there. `None` where switching costs nothing, δP_max = 0, so that no interval is too short.
    ///
    /// The bound has a second minimum at intervals beyond τ, which in the paper's case is the lower one for runs of
    /// more than 149 days. The lowest point of a grid is therefore found first, and the root beside it is then bisected
    /// to the last bit. The grid starts at δP_max/Ω_g(t), below which the residual alone exceeds Ω_g(t).
    pub fn optimum(&self, t_s: f64) -> Option<Optimum> {
        if self.residual_max <= 0.0 {
            return None;
        }
        let bound = |interval_s: f64| self.bound(interval_s, t_s).total();
        let shortest = (self.residual_max / (bound(t_s) - self.non_magnetic.abs())).min(t_s);
        let log_width = libm::log(t_s / shortest);
        let at = |k: u32| match k >= GRID {
            true => t_s,
            false => shortest * libm::exp(log_width * f64::from(k) / f64::from(GRID)),
        };
        let best = (0..=GRID).min_by(|a, b| bound(at(*a)).total_cmp(&bound(at(*b))))?;
        let (below, above) = (at(best.saturating_sub(1)), at(best + 1));
        let slope = |interval_s: f64| self.slope(interval_s, t_s);
        let interval_s = if slope(above) <= 0.0 { above } else { bisected(below, above, slope) };
        Some(Optimum { interval_s, bound: bound(interval_s) })
    }
}

/// The place where a function passes from below 0 to above it, by bisection to the last bit.
fn bisected(mut below: f64, mut above: f64, f: impl Fn(f64) -> f64) -> f64 {
    loop {
        let middle = 0.5 * (below + above);
        // The negation also ends the loop for values that are not numbers.
        let is_between = below < middle && middle < above;
        if !is_between {
            return middle;
        }
        *if f(middle) < 0.0 { &mut below } else { &mut above } = middle;
    }
}

/// The smaller positive root of b M² − c M³ = d, by bisection to the last bit. The difference of the two sides rises
/// from −d at 0 to its maximum at M = 2b/3c. `None` where that maximum is negative or a value is not a number.
fn smaller_root(b: f64, c: f64, d: f64) -> Option<f64> {
    if b.is_nan() || c.is_nan() || d.is_nan() || b <= 0.0 || d <= 0.0 {
        return None;
    }
    if c == 0.0 {
        return Some(libm::sqrt(d / b));
    }
    let left = |m: f64| m * m * (b - c * m) - d;
    let top = 2.0 * b / (3.0 * c);
    // An infinite range has no middle.
    let has_root = top.is_finite() && left(top) >= 0.0;
    has_root.then(|| bisected(0.0, top, left))
}

/// √(δP_max t/Ω_m), the paper's optimum for small A or large τ. It is the optimum for a magnetic drift that is present
/// from the start, Ω_m0 ≠ 0; otherwise [`Budget::limit`] is. `None` without a magnetic drift, and without residuals,
/// where no interval is too short.
pub fn limit_as_published(budget: &Budget, t_s: f64) -> Option<f64> {
    let rate = budget.magnetic.rate(t_s).abs();
    (rate > 0.0 && budget.residual_max > 0.0).then(|| libm::sqrt(budget.residual_max * t_s / rate))
}

impl Budget {
    /// Z(9) as printed, 2τ²Ω_m (MT)² − A t (MT)³ = 2τ² t δP_max; the smaller of its two positive roots. `None` where it
    /// has none, in the paper's case for t > 40656 s.
    ///
    /// It does not follow from Z(8): see [`Budget::optimum_expanded`].
    pub fn optimum_as_published(&self, t_s: f64) -> Option<f64> {
        let Magnetic { amplitude, time_s, .. } = self.magnetic;
        let rate = self.magnetic.rate(t_s).abs();
        let tau2 = time_s * time_s;
        smaller_root(2.0 * tau2 * rate, amplitude.abs() * t_s, 2.0 * tau2 * t_s * self.residual_max)
    }

    /// The expansion of Z(8) to first order in MT/τ, A τ t (MT)² − 2 A t (MT)³ + 2τ²Ω_m (MT)² = 2τ² t δP_max. Z(9)
    /// lacks its first term and a factor of 2. `None` where it has no root.
    pub fn optimum_expanded(&self, t_s: f64) -> Option<f64> {
        let Magnetic { amplitude, time_s, .. } = self.magnetic;
        let rate = self.magnetic.rate(t_s).abs();
        let tau2 = time_s * time_s;
        smaller_root(
            amplitude.abs() * time_s * t_s + 2.0 * tau2 * rate,
            2.0 * amplitude.abs() * t_s,
            2.0 * tau2 * t_s * self.residual_max,
        )
    }

    /// √(δP_max/(A/2τ + Ω_m/t)), the limit of the optimum for large τ. `None` without a magnetic drift or without
    /// residuals.
    pub fn limit(&self, t_s: f64) -> Option<f64> {
        let Magnetic { amplitude, time_s, .. } = self.magnetic;
        let growth = amplitude.abs() / (2.0 * time_s) + self.magnetic.rate(t_s).abs() / t_s;
        (growth > 0.0 && self.residual_max > 0.0).then(|| libm::sqrt(self.residual_max / growth))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    /// The paper's figures 4 and 5.
    pub(crate) const PAPER: Budget = Budget {
        magnetic: Magnetic { amplitude: 14.0, time_s: 3000.0, initial: 0.0 },
        non_magnetic: 0.05,
        residual_max: 10.0,
    };

    /// The columns of the reference: run, interval, bound, optimum, bound at the optimum, published root, limit.
    pub(crate) fn reference() -> impl Iterator<Item = [f64; 7]> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/drift_budget.csv");
        let of_record = |record: Result<csv::StringRecord, _>| {
            let record = record.unwrap();
            [0, 1, 2, 3, 4, 5, 6].map(|at| record[at].parse().unwrap())
        };
        csv::Reader::from_path(path).unwrap().into_records().map(of_record)
    }

    #[test]
    fn bounds_and_optima_are_those_of_the_reference() {
        for [t, interval, bound, optimum, optimum_bound, ..] in reference() {
            let found = PAPER.bound(interval, t).total();
            assert!((found / bound - 1.0).abs() < 1e-9, "{t} s, {interval} s: {found}, not {bound}");
            let best = PAPER.optimum(t).unwrap();
            // The reference minimizes the value, which determines the place of the minimum only to the square root of
            // rounding.
            assert!((best.interval_s / optimum - 1.0).abs() < 1e-7, "{t} s: {best:?}, not {optimum}");
            assert!((best.bound / optimum_bound - 1.0).abs() < 1e-9, "{t} s: {best:?}, not {optimum_bound}");
        }
    }

    /// Budgets with drifts of either sign, with and without Ω_m0, and their runs from 10 s to 10^7 s.
    pub(crate) fn random(count: usize, seed: u64) -> Vec<(Budget, f64)> {
        let mut rng = StdRng::seed_from_u64(seed);
        let mut power = |low: f64, high: f64| libm::exp10(rng.random_range(low..high));
        let mut of = |case: usize| {
            let amplitude = power(-2.0, 2.0) * [1.0, -1.0][case % 2];
            let initial = [0.0, amplitude * power(-3.0, 3.0), -amplitude * power(-3.0, 3.0), -amplitude];
            let magnetic = Magnetic { amplitude, time_s: power(0.0, 6.0), initial: initial[case / 2 % 4] };
            let budget = Budget { magnetic, non_magnetic: 0.05, residual_max: power(-2.0, 3.0) };
            (budget, power(1.0, 7.0))
        };
        (0..count).map(&mut of).collect()
    }

    #[test]
    fn for_random_budgets_no_interval_within_the_run_has_a_lower_bound_than_the_optimum() {
        for (budget, t_s) in random(200, 42) {
            let best = budget.optimum(t_s).unwrap();
            let bound = |interval_s: f64| budget.bound(interval_s, t_s).total();
            assert_eq!(best.bound, bound(best.interval_s), "{t_s} s, {budget:?}");
            assert!(best.interval_s <= t_s, "{t_s} s, {budget:?}: {best:?}");
            let at = |k: i32| t_s * libm::exp10(-10.0 * f64::from(k) / 20_000.0);
            let lowest = (0..=20_000).min_by(|a, b| bound(at(*a)).total_cmp(&bound(at(*b)))).unwrap();
            assert!(
                best.bound <= bound(at(lowest)) * (1.0 + 1e-12),
                "{t_s} s, {budget:?}: {best:?}, but {} ″/s at {} s",
                bound(at(lowest)),
                at(lowest)
            );
        }
    }

    #[test]
    fn the_bound_falls_to_the_non_magnetic_drift_only_in_months_and_at_intervals_of_days() {
        let best = PAPER.optimum(1e6).unwrap();
        assert!((best.bound - 0.352).abs() < 2e-3 && (best.interval_s - 67.0).abs() < 0.5, "{best:?}");
        // Beyond τ (2A/0.302)²/2 the minimum near √(τt/2) is the lower one, Ω_nm + A√(2τ/t).
        let [before, after] = [1.25e7, 1.35e7].map(|t| PAPER.optimum(t).unwrap().interval_s);
        assert!(before < 68.0 && after > 1e5, "{before} s, {after} s");
        let found = PAPER.optimum(1e12).unwrap().bound;
        let law = 0.05 + 14.0 * libm::sqrt(2.0 * 3000.0 / 1e12);
        assert!((found / law - 1.0).abs() < 1e-3, "{found}, not {law}");
    }

    #[test]
    fn with_a_twentieth_of_the_amplitude_the_optimum_is_that_of_the_misprint() {
        let budget = Budget { magnetic: Magnetic { amplitude: 0.7, ..PAPER.magnetic }, ..PAPER };
        let found = [600.0, 36000.0].map(|t| budget.optimum(t).unwrap().interval_s.round());
        assert_eq!(found, [178.0, 295.0]);
    }

    #[test]
    fn the_optimum_is_the_lowest_point_within_the_run_and_the_run_itself_where_the_bound_falls_up_to_it() {
        let wild = Magnetic { amplitude: -0.02, time_s: 5.0, initial: 0.021 };
        for (budget, t_s) in [
            (PAPER, 600.0),
            (PAPER, 20.0),
            (Budget { residual_max: 0.01, magnetic: wild, ..PAPER }, 1e4),
            (Budget { residual_max: 1e6, ..PAPER }, 600.0),
            (Budget { magnetic: Magnetic { amplitude: 0.0, ..PAPER.magnetic }, ..PAPER }, 600.0),
        ] {
            let best = budget.optimum(t_s).unwrap();
            let lowest = (1..=200_000)
                .map(|k| budget.bound(t_s * f64::from(k) / 200_000.0, t_s).total())
                .fold(f64::INFINITY, f64::min);
            assert!(best.bound <= lowest && best.interval_s <= t_s, "{budget:?}: {best:?}, not {lowest}");
            let slope = budget.slope(best.interval_s, t_s);
            assert!(
                best.interval_s == t_s || slope.abs() < 1e-12 * best.bound / best.interval_s * 1e3,
                "{budget:?}: a slope of {slope:e} at {best:?}"
            );
        }
        assert_eq!(Budget { residual_max: 0.0, ..PAPER }.optimum(600.0), None);
    }

    #[test]
    fn published_roots_and_limits_are_those_of_the_reference() {
        for [t, .., published, limit] in reference() {
            let found = PAPER.optimum_as_published(t).unwrap();
            assert!((found / published - 1.0).abs() < 1e-9, "{t} s: {found}, not {published}");
            let found = limit_as_published(&PAPER, t).unwrap();
            assert!((found / limit - 1.0).abs() < 1e-9, "{t} s: {found}, not {limit}");
        }
    }

    #[test]
    fn the_published_equation_has_no_root_for_runs_beyond_40656_s() {
        assert!(PAPER.optimum_as_published(40655.8).is_some());
        assert_eq!(PAPER.optimum_as_published(40655.9), None);
        assert_eq!(PAPER.optimum_as_published(1e9), None);
    }

    #[test]
    fn the_expansion_is_within_0_02_s_of_the_optimum_and_its_limit_near_it() {
        for (t, limit) in [(600.0, 39.0), (900.0, 39.6), (3600.0, 44.5), (36000.0, 60.6)] {
            let optimum = PAPER.optimum(t).unwrap().interval_s;
            let expanded = PAPER.optimum_expanded(t).unwrap();
            assert!((expanded - optimum).abs() < 0.021, "{t} s: {expanded}, not {optimum}");
            let found = PAPER.limit(t).unwrap();
            assert!((found - limit).abs() <= 0.05, "{t} s: {found}, not {limit}");
        }
    }

    #[test]
    fn limits_are_those_of_the_optimum_for_large_times_of_the_warm_up() {
        let slow =
            |initial| Budget { magnetic: Magnetic { time_s: 1e6, initial, ..PAPER.magnetic }, ..PAPER };
        let (with, without) = (slow(14.0), slow(0.0));
        let near = |found: Option<f64>, budget: &Budget| {
            let exact = budget.optimum(3600.0).unwrap().interval_s;
            (found.unwrap() / exact - 1.0).abs()
        };
        let off = [near(limit_as_published(&with, 3600.0), &with), near(with.limit(3600.0), &with)];
        assert!(off.iter().all(|off| *off < 2e-3), "{off:?}");
        let off =
            [near(limit_as_published(&without, 3600.0), &without), near(without.limit(3600.0), &without)];
        assert!(off[0] > 0.2 && off[1] < 2e-3, "{off:?}");
    }

    /// Without the terms that the paper's limit leaves out, both limits are the same.
    #[test]
    fn for_random_budgets_the_approximations_have_nearly_the_least_bound_at_intervals_far_below_the_warm_up()
    {
        let mut known = [0; 3];
        for (budget, t_s) in random(1000, 43) {
            let best = budget.optimum(t_s).unwrap();
            let Magnetic { amplitude, time_s, .. } = budget.magnetic;
            let is_steady = amplitude.abs() * t_s / (2.0 * time_s) < 0.001 * budget.magnetic.rate(t_s).abs();
            let published = limit_as_published(&budget, t_s).filter(|_| is_steady);
            let found = [budget.optimum_expanded(t_s), budget.limit(t_s), published];
            for ((interval_s, known), tolerance) in found.into_iter().zip(&mut known).zip([1e-5, 1e-3, 1e-3])
            {
                // At a longer optimum the bound may have its other minimum.
                let is_far_below = |interval_s: &f64| interval_s.max(best.interval_s) < 0.03 * time_s;
                let Some(interval_s) = interval_s.filter(is_far_below).filter(|found| *found <= t_s) else {
                    continue;
                };
                *known += 1;
                let bound = budget.bound(interval_s, t_s).total();
                assert!(
                    (1.0 - 1e-12..1.0 + tolerance).contains(&(bound / best.bound)),
                    "{t_s} s, {budget:?}: {bound} ″/s at {interval_s} s, but {best:?}"
                );
            }
        }
        assert!(known.iter().all(|known| *known > 50), "{known:?} of 1000 are far below the warm-up");
    }

    #[test]
    fn the_smaller_root_is_a_root_and_the_smaller_one() {
        // (M − 1)(M − 2)(M + 2/3) = M³ − 7/3 M² + 4/3.
        assert!((smaller_root(7.0 / 3.0, 1.0, 4.0 / 3.0).unwrap() - 1.0).abs() < 1e-15);
        assert_eq!(smaller_root(2.0, 0.0, 8.0), Some(2.0));
        for none in [(0.0, 1.0, 1.0), (-1.0, 0.0, 1.0), (1.0, 1.0, 0.0), (1.0, 1.0, 0.15)] {
            assert_eq!(smaller_root(none.0, none.1, none.2), None, "{none:?}");
        }
    }

    #[test]
    fn what_is_no_number_has_no_root_and_ends_the_search() {
        let strange = Budget { residual_max: f64::NAN, ..PAPER };
        assert_eq!(strange.optimum_as_published(600.0), None);
        for t in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0] {
            assert_eq!(PAPER.optimum_as_published(t).filter(|t| !t.is_finite()), None, "{t}");
            assert_eq!(PAPER.optimum_expanded(t).filter(|t| !t.is_finite()), None, "{t}");
        }
        assert!(strange.optimum(600.0).is_some_and(|best| best.bound.is_nan()));
        assert!(PAPER.optimum(f64::NAN).is_some_and(|best| best.bound.is_nan()));
    }

    #[test]
    fn without_a_magnetic_drift_there_is_nothing_to_switch_for() {
        let still = Budget { magnetic: Magnetic { amplitude: 0.0, ..PAPER.magnetic }, ..PAPER };
        let found =
            [still.limit(600.0), limit_as_published(&still, 600.0), still.optimum_as_published(600.0)];
        assert_eq!(found, [None; 3]);
    }

    #[test]
    fn without_residuals_no_interval_is_best() {
        let exact = Budget { residual_max: 0.0, ..PAPER };
        let found = [
            exact.limit(600.0),
            limit_as_published(&exact, 600.0),
            exact.optimum_as_published(600.0),
            exact.optimum_expanded(600.0),
        ];
        assert_eq!(found, [None; 4]);
    }
}
