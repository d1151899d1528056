//! Approximations of the interval at which the bound is least: those of the paper, and corrected ones.

use crate::drift::budget::{Budget, bisected};
use crate::drift::magnetic::Magnetic;

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
mod tests {
    use super::*;
    use crate::drift::budget::tests::{PAPER, random, reference};

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
