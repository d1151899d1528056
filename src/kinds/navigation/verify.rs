//! Named navigators that cover every distinction made by their kernel.

use std::sync::Arc;

use crate::device::load::{Load, Work};
use crate::key::common::Streams;
use crate::kinds::navigation::keys::Solution;
use crate::kinds::navigation::lower::Lowered;
use crate::kinds::navigation::{Inputs, Navigation, Point};
use crate::noise::{Noise, Switching};
use crate::theory::allan::terms::Term;

/// Quantisation noise, angle random walk and bias instability of the LGK-400 of the Allan paper's table 2, ″ and s.
const LGK_400: [(Term, f64); 3] =
    [(Term::Quantisation, 0.24), (Term::AngleRandomWalk, 0.00067 * 60.0), (Term::BiasInstability, 0.00192)];

/// A navigator at 60° whose gyros have this noise, with samples of 1 s.
pub fn navigator(solution: Solution, noise: Noise, duration_s: f64) -> Lowered {
    let is_compass = solution == Solution::Gyrocompass;
    let inputs = Inputs {
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
    };
    let point = Point { swept: vec![], inputs, lack: None };
    let study = Navigation { solution, draws: 1, uncertain: vec![], points: vec![] };
    let lowered = Lowered::new(&point, &study, 1, Streams::Independent);
    lowered.unwrap_or_else(|error| panic!("a named navigator does not lower: {error}"))
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
pub fn loads() -> Vec<Load> {
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
    let load = |name, lowered: Lowered, self_test_units| {
        let navigation = lowered.gyros.last().map(|gyro| gyro.navigation.clone());
        let work = navigation.map(|navigation| Work::Records(Arc::new(navigation)));
        work.map(|work| Load { name, work, self_test_units })
    };
    [
        load("heading-white", navigator(Solution::Heading, white, 2000.0), None),
        load("gyrocompass-lgk-400", navigator(Solution::Gyrocompass, lgk_400(), 600.0), None),
        load("inertial-lgk-400", navigator(Solution::Inertial, lgk_400(), 3600.0), None),
        load("inertial-everything", navigator(Solution::Inertial, everything, 700.0), Some(40 * 700)),
    ]
    .into_iter()
    .flatten()
    .collect()
}
