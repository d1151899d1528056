//! Named navigators that cover every distinction made by their kernel.

use std::sync::Arc;

use crate::device::{Work, Workload};
use crate::key::Streams;
use crate::kinds::navigation::lower::Lowered;
use crate::kinds::navigation::{Inputs, Navigation, Solution};
use crate::noise::{Noise, Switching};
use sagnac_theory::allan::terms::Term;

/// Quantization noise, angle random walk and bias instability of the LGK-400 of the Allan paper's table 2, ″ and s.
const LGK_400: [(Term, f64); 3] =
    [(Term::Quantization, 0.24), (Term::AngleRandomWalk, 0.00067 * 60.0), (Term::BiasInstability, 0.00192)];

/// A navigator at 60° whose gyros have this noise, with samples of 1 s.
pub fn navigator(solution: Solution, noise: Noise, duration_s: f64) -> Lowered {
    let study = asked(solution, noise, duration_s);
    let lowered = Lowered::new(&study.points[0], &study, SEED, Streams::Independent);
    lowered.unwrap_or_else(|error| panic!("a named navigator does not lower: {error}"))
}

/// The seed of named navigators.
const SEED: u64 = 1;

/// The study of such a navigator.
fn asked(solution: Solution, noise: Noise, duration_s: f64) -> Navigation {
    let is_compass = solution == Solution::Gyrocompass;
    Navigation::new(Inputs {
        solution,
        duration_s: if is_compass { 0.0 } else { duration_s },
        alignment_s: if is_compass { duration_s } else { 0.0 },
        calibrates: false,
        filter: None,
        latitude_arcsec: 216_000.0,
        speed_m_per_s: 0.0,
        course_arcsec: 0.0,
        sample_s: Some(1.0),
        noise,
    })
}

/// A noise with these coefficients, in ″ and s.
pub fn noise_of(terms: &[(Term, f64)]) -> Noise {
    let mut noise = Noise::default();
    terms.iter().for_each(|(term, size)| noise.set(*term, 0, *size));
    noise
}

/// A noise of one term with a shape, in ″ and s.
pub fn shaped(term: Term, size: f64, shape: f64) -> Noise {
    let mut noise = noise_of(&[(term, size)]);
    noise.set(term, 1, shape);
    noise
}

/// The noise of an LGK-400.
pub fn lgk_400() -> Noise {
    noise_of(&LGK_400)
}

/// The loads on which the kernel is checked.
pub fn loads() -> Vec<Workload> {
    let load = |(name, solution, noise, duration_s): (&'static str, Solution, Noise, f64)| {
        let gyros = navigator(solution, noise, duration_s).gyros;
        let navigation = gyros.last().map(|gyro| gyro.navigation.clone());
        let work = navigation.map(|navigation| Work::Records(Arc::new(navigation)));
        let self_test_units = (name == "inertial-everything").then_some(40 * 700);
        work.map(|work| Workload { name, work, self_test_units })
    };
    named_navigators().into_iter().filter_map(load).collect()
}

/// The names, solutions, noises and durations of navigators that cover every distinction made by the kernel.
fn named_navigators() -> Vec<(&'static str, Solution, Noise, f64)> {
    let mut everything =
        noise_of(&[&LGK_400[..], &[(Term::RateRandomWalk, 2e-4), (Term::RateRamp, 1e-5)]].concat());
    for (term, [size, shape]) in
        [(Term::Markov, [2e-3, 40.0]), (Term::Sine, [0.02, 0.0137]), (Term::WarmUp, [0.03, 200.0])]
    {
        everything.set(term, 0, size);
        everything.set(term, 1, shape);
    }
    // Switches at arbitrary places within chunks.
    everything.switching = Some(Switching {
        interval_s: 37.0,
        magnetic: 0.7,
        warm_up_s: Some(150.0),
        initial_magnetic: 0.02,
        residual: 10.0,
        residual_noise: 0.3,
    });
    let white = noise_of(&[(Term::AngleRandomWalk, 0.0288)]);
    vec![
        ("heading-white", Solution::Heading, white, 2000.0),
        ("gyrocompass-lgk-400", Solution::Gyrocompass, lgk_400(), 600.0),
        ("inertial-lgk-400", Solution::Inertial, lgk_400(), 3600.0),
        ("inertial-everything", Solution::Inertial, everything, 700.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::navigation::columns::Quantity;
    use crate::kinds::navigation::lower::PhysicalTheory;

    /// The largest difference from the closed form of the inputs, and the least and the largest ratio of a bound to its rms.
    fn compare(name: &str, solution: Solution, noise: Noise, duration_s: f64) -> (f64, f64) {
        let study = asked(solution, noise, duration_s);
        let point = &study.points[0];
        let lowered = Lowered::new(point, &study, SEED, Streams::Independent).unwrap();
        let physical = PhysicalTheory::new(point, &study, SEED);
        let (mut most, mut loosest) = (0.0_f64, 0.0_f64);
        for quantity in Quantity::of(solution) {
            let errors = quantity.errors();
            let squares: f64 = lowered.distributions(errors).iter().map(|one| one.mean_square()).sum();
            let rms = libm::sqrt(squares);
            let found = lowered.representation(errors, rms, &physical);
            let found = found.unwrap_or_else(|error| panic!("{name}, {quantity:?}: {error}")).unwrap();
            let bound = lowered.representation_bound(errors, rms) / rms;
            println!("{name}, {quantity:?}: {found:.2e}, bound {bound:.2e}");
            (most, loosest) = (most.max(found.abs()), loosest.max(bound));
        }
        (most, loosest)
    }

    #[test]
    fn closed_forms_of_the_words_are_those_of_the_inputs_within_the_rounding_of_words() {
        for (name, solution, noise, duration_s) in named_navigators() {
            let (most, loosest) = compare(name, solution, noise, duration_s);
            assert!(most > 0.0 && loosest < 1e-3, "{name}: {most}, bound {loosest}");
        }
    }

    #[test]
    fn every_part_of_the_noise_alone_has_the_closed_form_of_its_input() {
        let white = noise_of(&[(Term::AngleRandomWalk, 0.0288)]);
        let switched = |switching: Switching| {
            let mut noise = white.clone();
            noise.switching = Some(switching);
            noise
        };
        let none = Switching { interval_s: 37.0, ..Switching::default() };
        let mut beside_ramp = white.clone();
        beside_ramp.set(Term::RateRamp, 0, 1e-5);
        for (name, noise) in [
            ("quantization", noise_of(&[(Term::Quantization, 0.24)])),
            ("white", white.clone()),
            ("flicker", noise_of(&[(Term::BiasInstability, 0.00164)])),
            ("walk", noise_of(&[(Term::RateRandomWalk, 2e-5)])),
            ("Markov", shaped(Term::Markov, 0.002, 300.0)),
            ("fast Markov", shaped(Term::Markov, 0.002, 0.4)),
            ("sine", shaped(Term::Sine, 0.01, 0.001_3)),
            ("ramp", beside_ramp),
            ("warm-up", shaped(Term::WarmUp, 0.03, 200.0)),
            ("a warm-up longer than the record", shaped(Term::WarmUp, 0.03, 1e5)),
            ("sawtooth", switched(Switching { magnetic: 0.7, warm_up_s: Some(150.0), ..none })),
            ("steady sawtooth", switched(Switching { initial_magnetic: 0.02, ..none })),
            ("residual", switched(Switching { residual: 10.0, ..none })),
            ("noise of residuals", switched(Switching { residual_noise: 0.3, ..none })),
        ] {
            for solution in [Solution::Heading, Solution::Inertial] {
                let (_, loosest) = compare(name, solution, noise.clone(), 700.0);
                assert!(loosest < 1e-2, "{name}: bound {loosest}");
            }
        }
    }
}
