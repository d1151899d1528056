//! Named gap-fill points that cover every distinction made by the kernel.

use std::sync::Arc;

use crate::device::Workload;
use crate::filler::read::Error;
use crate::filler::{Fill, Filler, Method, Target};
use crate::key::{Streams, Unrepresentable};
use crate::kinds::gap_fill::inputs::{Inputs, Point, TickNoise};
use crate::kinds::gap_fill::lower::Lowered;
use crate::motion::keys::{Design, Interpolation, Phase, Position};
use crate::motion::{Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value};
use sagnac_kernel::launch::Launch;
use sagnac_records::record::Record;
use sagnac_theory::minimum_variance::Band;

/// A gap-fill point on which identity is checked.
#[derive(Debug, Clone)]
pub struct Configuration {
    /// Name in reports.
    pub name: &'static str,
    /// Motion, noise and gap.
    pub inputs: Inputs,
    /// Fillers of the gap.
    pub fillers: Vec<Filler>,
    /// Errors of each filler.
    pub errors: Vec<Error>,
    /// Ticks of the residual.
    pub fit_ticks: Vec<i32>,
    /// Ticks of the extrapolation.
    pub extrapolation_ticks: Vec<i32>,
}

impl Configuration {
    /// The paper's point with some inputs, ticks or fillers changed.
    pub fn new(name: &'static str, change: impl FnOnce(&mut Configuration)) -> Configuration {
        let inputs = Inputs {
            tick_s: 0.005,
            tick_noise: TickNoise::Std(1.6 / 3.0),
            readout_lsb: 0.0,
            relock: vec![],
            motion: Motion::of_tone(Tone::of_rate(12000.0, 20.0)),
            specification: None,
            gap_ticks: 3,
        };
        let mut configuration = Configuration {
            name,
            inputs,
            fillers: Filler::polynomials(),
            errors: vec![Error::Residual, Error::Extrapolation],
            fit_ticks: vec![],
            extrapolation_ticks: vec![-3, -2, -1, 0],
        };
        change(&mut configuration);
        if configuration.fit_ticks.is_empty() {
            let n = configuration.inputs.gap_ticks as i32;
            configuration.fit_ticks = vec![-1, 0, n + 1, n + 2];
        }
        configuration
    }

    /// The single point of the configuration.
    pub fn point(&self) -> Point {
        let fill = Fill {
            fit_ticks: self.fit_ticks.clone(),
            extrapolation_ticks: Some(self.extrapolation_ticks.clone()),
        };
        let fills = vec![fill; self.fillers.len()].into();
        Point { swept: vec![], inputs: self.inputs.clone(), fills, design: None }
    }

    /// Lowers the point.
    ///
    /// # Errors
    /// The point cannot be represented.
    pub fn lower(&self) -> Result<Lowered, Unrepresentable> {
        Lowered::new(&self.point(), &self.fillers, &self.errors, 1, Streams::Independent)
    }

    /// Lowers a point that is known to fit.
    pub fn lowered(&self) -> Lowered {
        self.lower().unwrap_or_else(|error| panic!("{} does not lower: {error}", self.name))
    }

    /// The launches that sample the point.
    pub fn launches(&self) -> Vec<Launch> {
        let lowered = self.lowered();
        let all: Vec<usize> = (0..self.fillers.len()).collect();
        all.chunks(lowered.most_fillers(0)).map(|fillers| lowered.launch(fillers)).collect()
    }

    /// The single tone of the motion.
    pub fn tone(&mut self) -> &mut Tone {
        &mut self.inputs.motion.tones[0]
    }
}

/// A minimum-variance filler for the point's own motion.
pub fn minimum_variance() -> Filler {
    Filler { name: "minimum-variance".to_owned(), method: Method::MinimumVariance(Target::Own) }
}

/// A motion of some tones of decreasing amplitude.
pub fn tones(count: usize) -> Motion {
    let tone = |k: usize| Tone::of_rate(12000.0 / (k + 1) as f64, 7.3 + 6.1 * k as f64);
    Motion { tones: (0..count).map(tone).collect(), ..Motion::default() }
}

/// A synthetic record of two tones and a drift.
pub fn profile(position: Position) -> Motion {
    let rate = |i: usize| {
        let t = i as f64 * 0.002;
        9000.0 * libm::sin(120.0 * t) + 4000.0 * libm::sin(271.0 * t) + 50.0 * t
    };
    let record = Record { step_s: 0.002, rates: (0..3000).map(rate).collect() };
    let profile = Profile {
        file: "made up".to_owned(),
        record: Arc::new(record),
        position,
        interpolation: Interpolation::Linear,
        design: Design::Whole,
    };
    Motion { profile: Some(profile), ..Motion::default() }
}

/// Gaussian motion over a band.
pub fn gaussian(low_hz: f64, high_hz: f64) -> Motion {
    let gaussian = Gaussian::Band { rms: 8485.0, band: Band { low_hz, high_hz } };
    Motion { gaussian: Some(gaussian), ..Motion::default() }
}

/// The configurations with sums of 32 bits and of 64 bits.
const SELF_TEST: [&str; 2] = ["paper", "sparse-fit-ticks"];

/// The loads on which the kernel is checked.
pub fn loads() -> Vec<Workload> {
    let of = |c: Configuration| c.launches().into_iter().map(move |launch| (c.name, launch));
    Workload::of_launches(configurations().into_iter().flat_map(of).collect(), &SELF_TEST)
}

/// Points that cover every distinction made by the kernel.
pub fn configurations() -> Vec<Configuration> {
    let every_error = Error::ALL.to_vec();
    vec![
        Configuration::new("paper", |_| {}),
        Configuration::new("one-tick-gap", |c| c.inputs.gap_ticks = 1),
        Configuration::new("five-tick-gap", |c| c.inputs.gap_ticks = 5),
        Configuration::new("zero-crossing", |c| c.tone().phase = Phase::ZeroCrossing),
        Configuration::new("extremum-without-noise", |c| {
            c.tone().phase = Phase::Extremum;
            c.inputs.tick_noise = TickNoise::Std(0.0);
        }),
        Configuration::new("noise-without-motion", |c| {
            c.inputs.motion = Motion::of_tone(Tone::of_angle(0.0, 20.0));
            c.inputs.tick_noise = TickNoise::AngleRandomWalk(2.0);
        }),
        Configuration::new("many-fit-ticks", |c| {
            c.fit_ticks = (-9..=0).chain(4..=9).collect();
            c.extrapolation_ticks = (-6..=0).collect();
            c.fillers = vec![Filler::polynomial(2)];
        }),
        Configuration::new("sparse-fit-ticks", |c| {
            c.fit_ticks = vec![-5, -2, 0, 4, 7];
            c.extrapolation_ticks = vec![-12, -4, 0];
            c.fillers = vec![Filler::polynomial(2), Filler::polynomial(0)];
        }),
        Configuration::new("minimum-variance", |c| {
            c.fit_ticks = (-7..=0).chain(4..=5).collect();
            c.extrapolation_ticks = (-7..=0).collect();
            c.fillers = vec![minimum_variance()];
        }),
        Configuration::new("errors-in-the-gap", |c| {
            c.errors = every_error.clone();
            c.fillers.push(minimum_variance());
        }),
        Configuration::new("eight-tones", |c| c.inputs.motion = tones(8)),
        Configuration::new("drawn-amplitudes", |c| {
            c.inputs.motion = tones(2);
            let drawn = [Value::Uniform([2000.0, 12000.0]), Value::Rayleigh(5000.0)];
            for (tone, value) in c.inputs.motion.tones.iter_mut().zip(drawn) {
                tone.amplitude = Amplitude { of_angle: false, value };
            }
            c.errors = every_error.clone();
        }),
        Configuration::new("drawn-frequencies", |c| {
            c.inputs.motion = tones(3);
            c.tone().frequency = Frequency::Band(Band { low_hz: 1.0, high_hz: 99.0 });
            c.inputs.motion.tones[1].amplitude = Amplitude { of_angle: true, value: Value::Rayleigh(30.0) };
            c.inputs.motion.tones[1].frequency = Frequency::Band(Band { low_hz: 18.0, high_hz: 22.0 });
            c.errors = every_error.clone();
        }),
        Configuration::new("aliased-frequencies", |c| {
            c.inputs.motion = tones(3);
            c.tone().frequency = Frequency::Band(Band { low_hz: 120.0, high_hz: 1900.0 });
            c.inputs.motion.tones[1].amplitude = Amplitude { of_angle: true, value: Value::Fixed(30.0) };
            c.inputs.motion.tones[1].frequency = Frequency::Band(Band { low_hz: 350.0, high_hz: 420.0 });
        }),
        Configuration::new("gaussian-motion", |c| c.inputs.motion = gaussian(18.0, 22.0)),
        Configuration::new("gaussian-motion-everywhere", |c| {
            c.inputs.motion = Motion { tones: tones(2).tones, ..gaussian(1.0, 60.0) };
            c.inputs.gap_ticks = 2;
            c.fit_ticks = (-7..=0).chain(3..=10).collect();
            c.errors = every_error.clone();
            c.fillers.push(minimum_variance());
        }),
        Configuration::new("profile", |c| c.inputs.motion = profile(Position::Random)),
        Configuration::new("every-place-of-a-profile", |c| {
            c.inputs.motion = profile(Position::Every);
            c.errors = every_error.clone();
        }),
        Configuration::new("relock-and-acceleration", |c| {
            c.inputs.motion.rate = -36000.0;
            c.inputs.motion.acceleration = 90_000.0;
            c.inputs.relock = vec![20.3, 14.8];
            c.errors = every_error.clone();
        }),
        Configuration::new("whole-pulses", |c| c.inputs.readout_lsb = 3.2),
        Configuration::new("whole-pulses-of-all-kinds", |c| {
            c.inputs.motion = Motion { rate: 1234.5, acceleration: -300.0, ..profile(Position::Random) };
            c.inputs.relock = vec![5.0];
            c.inputs.readout_lsb = 2.0;
            c.fit_ticks = (-7..=0).chain(4..=7).collect();
            c.errors = every_error;
            c.fillers = vec![Filler::polynomial(1), minimum_variance()];
        }),
    ]
}
