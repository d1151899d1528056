//! Records sample by sample: the numbers whose variances the kernels sum up.

use std::io::{Error, Write};
use std::time::Instant;

use sagnac::record::log::Log;
use sagnac::record::log::measure::Data;
use sagnac::record::log::read::{Hints, Request, Timing};
use sagnac::record::write::Form;
use sagnac::use_cases::{Numbers, SimulateRequest, Simulation};
use sagnac_engine::device::Cpu;
use sagnac_engine::kinds::allan::lower::{Asked, Records};
use sagnac_kernel::width::Width;
use sagnac_theory::allan::{Estimator, Part, Process};

const SAMPLES: u64 = 5000;
const MS: [u64; 4] = [1, 7, 100, 1250];
const STEP_S: f64 = 0.5;

fn records(parts: Vec<Part>, readout_lsb: f64, mean_rate: f64) -> Records {
    Records::new(&Asked {
        process: &Process { sample_s: STEP_S, parts },
        readout_lsb,
        mean_rate,
        switching: None,
        samples: SAMPLES,
        estimator: Estimator::OVERLAPPING,
        ms: &MS,
        key: [3, 4],
    })
    .unwrap()
}

/// Records of a noise at `1 / step_s`.
fn simulation(step_s: f64, length_s: f64) -> Simulation {
    let noise = "angle_random_walk = \"0.01 deg/sqrt(h)\"\nreadout_lsb = \"0.02 arcsec\"\n";
    let request = SimulateRequest {
        sample_s: Some(step_s),
        length_s: Some(length_s),
        seed: Some(3),
        ..Default::default()
    };
    Simulation::parse("noise.toml", noise, &request).unwrap()
}

#[test]
fn pulses_without_a_motion_are_those_of_the_kernel() {
    let parts = vec![Part::angle_random_walk(0.04), Part::rate_random_walk(2e-4)];
    for (readout_lsb, mean_rate) in [(0.0, 3.0), (0.7, 0.0), (0.7, -15.04), (0.7, 720_000.0)] {
        let records = records(parts.clone(), readout_lsb, mean_rate);
        for number in [0, 1 << 40] {
            let still = records.turned_increments(number, std::iter::repeat(0));
            assert!(still.eq(records.increments(number)), "{readout_lsb} {mean_rate} {number}");
        }
    }
}

#[test]
fn pulses_are_those_of_noise_and_motion_together() {
    let still = records(vec![Part::angle_random_walk(0.04)], 0.0, 0.0);
    let read = records(vec![Part::angle_random_walk(0.04)], 0.7, 0.0);
    // A turn of 3″ back and forth.
    let turned = |lsb: f64| {
        let angle = move |k: u64| (3.0 * (0.01 * k as f64).sin() / lsb * 2_f64.powi(32)).round() as i128;
        (0..SAMPLES).map(move |k| angle(k + 1) - angle(k))
    };
    let pulses: Vec<f64> = read.turned_increments(5, turned(read.lsb_arcsec())).collect();
    let (mut angle, mut counted, mut errors) = (0.0, 0.0, vec![]);
    for (smooth, pulses) in still.turned_increments(5, turned(still.lsb_arcsec())).zip(pulses) {
        assert!((pulses / 0.7 - (pulses / 0.7).round()).abs() < 1e-9, "{pulses}");
        angle += smooth;
        counted += pulses;
        errors.push(angle - counted);
    }
    let [least, most] = [f64::min, f64::max].map(|of| errors.iter().copied().reduce(of).unwrap());
    // The same noise in another unit; the start in a pulse is drawn.
    assert!(most - least < 0.7 + 1e-3 && most - least > 0.69, "{least} to {most}");
}

/// The overlapping Allan variance of angles, (″/s)².
fn variance(angles: &[f64], m: usize) -> f64 {
    let terms = angles.len() - 2 * m;
    let square = |k: usize| {
        let difference = angles[k + 2 * m] - 2.0 * angles[k + m] + angles[k];
        difference * difference
    };
    let tau_s = m as f64 * STEP_S;
    (0..terms).map(square).sum::<f64>() / (2.0 * tau_s * tau_s * terms as f64)
}

#[test]
fn a_record_has_the_variances_that_the_kernel_sums_up_whatever_its_noise() {
    let noises = [
        (vec![Part::angle_random_walk(0.04)], 0.0, 0.0),
        (
            vec![Part::quantization(0.3), Part::rate_random_walk(2e-4), Part::bias_instability(3e-3, 0)],
            0.0,
            15.0,
        ),
        (vec![Part::markov(0.01, 40.0), Part::rate_ramp(1e-6)], 0.0, -2.0),
        (vec![Part::angle_random_walk(0.04)], 0.7, 720_000.0),
        (vec![Part::angle_random_walk(0.04)], 0.7, -15.04),
    ];
    for (parts, readout_lsb, mean_rate) in noises {
        let records = records(parts.clone(), readout_lsb, mean_rate);
        for number in [0, 6, 1 << 40] {
            // Without the constant rate, beside which small differences would be lost.
            let constant = mean_rate * STEP_S;
            let mut angles = vec![0.0];
            for increment in records.increments(number) {
                angles.push(angles[angles.len() - 1] + (increment - constant));
            }
            assert_eq!(angles.len() as u64, SAMPLES + 1);
            let sums = Cpu::new(Width::widest(), 1).unwrap().sums(records.recipe(), number, 1, &|_| {});
            for (m, expected) in MS.into_iter().zip(records.variances(&sums)) {
                let found = variance(&angles, m as usize);
                assert!((found / expected - 1.0).abs() < 1e-6, "{parts:?} {number} {m}: {found} {expected}");
            }
            let rate = angles[SAMPLES as usize] / (SAMPLES as f64 * STEP_S);
            assert!(rate.abs() < 0.05, "{parts:?}: {rate}");
        }
    }
}

#[test]
fn every_form_is_read_as_the_samples_and_the_step_that_were_written() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = simulation(0.01, 50.0);
    for (numbers, data) in
        [(Numbers::Rate, Data::Rate), (Numbers::Increment, Data::Increment), (Numbers::Angle, Data::Angle)]
    {
        let expected: Vec<f64> = simulation.numbers(7, 0, numbers).collect();
        assert_eq!(expected.len(), 5000);
        for form in [Form::Csv, Form::Npz, Form::Mat, Form::Hdf5, Form::Mcap] {
            if form == Form::Mcap && numbers != Numbers::Rate {
                assert!(simulation.check(numbers, form).is_err());
                continue;
            }
            simulation.check(numbers, form).unwrap();
            let path = folder.path().join(format!("record.{}", form.ending()));
            simulation.write(7, numbers, form, &mut std::fs::File::create(&path).unwrap()).unwrap();
            let columns = if form == Form::Mcap { vec!["gz".to_owned()] } else { vec![] };
            let timing = Timing::Stamps { step_s: None, column: None, unit: None };
            let data = Some(data);
            let request =
                Request { columns, timing, data, units: vec![], temperature: None, hints: Hints::default() };
            let log =
                Log::read(&path, &request).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
            assert!((log.step_s / 0.01 - 1.0).abs() < 1e-12, "{form:?}: {}", log.step_s);
            let channel = &log.channels[0];
            assert_eq!(channel.samples.len(), expected.len(), "{form:?}");
            // Rates in rad/s are rounded.
            let most = if form == Form::Mcap { 1e-15 } else { 0.0 };
            let is_same = |(found, expected): (&f64, &f64)| {
                (found * channel.unit.factor - expected).abs() <= most * expected.abs()
            };
            assert!(channel.samples.iter().zip(&expected).all(is_same), "{form:?} {numbers:?}");
        }
    }
}

/// A disk that is full after some bytes.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or_else(|| Error::other("full"))?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn nothing_is_computed_once_the_output_fails() {
    let simulation = simulation(1.0, (1_u64 << 26) as f64);
    for form in Form::ALL {
        let start = Instant::now();
        assert!(simulation.write(0, Numbers::Rate, form, &mut Full(1 << 20)).is_err(), "{form:?}");
        // The whole record takes several seconds.
        assert!(start.elapsed().as_secs_f64() < 1.0, "{form:?}");
    }
}

#[test]
fn a_billion_samples_are_made_one_by_one() {
    let noise = "angle_random_walk = \"0.01 deg/sqrt(h)\"\nrate_random_walk = \"0.01 deg/h/sqrt(h)\"\nmarkov = { amplitude = \"1 deg/h\", time = \"10 s\" }\n";
    let request = SimulateRequest { sample_s: Some(1e-3), length_s: Some(1e6), ..Default::default() };
    let simulation = Simulation::parse("noise.toml", noise, &request).unwrap();
    assert_eq!(simulation.samples(), 1_000_000_000);
    let count = 200_000;
    let sum: f64 = simulation.numbers(0, 0, Numbers::Increment).take(count).map(|angle| angle * angle).sum();
    // 0.6 ″/√s; the other terms are small in so short a time.
    let found = (sum / count as f64).sqrt() / (0.6 * 1e-3_f64.sqrt());
    assert!((found - 1.0).abs() < 0.01, "{found}");
}
