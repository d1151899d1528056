//! Every motion, readout and filler against closed forms and against an independent gyro in floating point.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use crate::reference::weights::{Filler, Method};
use crate::reference::{Beside, Draw, Gyro, Tone};
use crate::studies::{Row, gap_fill, lowered, parsed, rows, run};
use rand::SeedableRng;
use rand::rngs::StdRng;

const TRIALS: usize = 1 << 18;

/// Trials of the reference.
const REFERENCE_TRIALS: usize = 1 << 16;

/// How much the angle's unit may move the 99.73 % level, in parts of the rms.
const LEVEL_ROUNDING: f64 = 1e-4;

/// Polynomials, also on ticks of their own; of least variance for the motion and for a band; given weights.
fn fillers(n: i32) -> Vec<Filler> {
    let eight_and_two: Vec<i32> = (-7..=0).chain(n + 1..=n + 2).collect();
    let mut fillers: Vec<Filler> = (0..3).map(|order| Filler::polynomial(order, n)).collect();
    fillers.push(Filler {
        name: "quadratic over seven",
        fit_ticks: vec![-5, -2, -1, 0, n + 1, n + 2, n + 4],
        extrapolation_ticks: (-6..=0).collect(),
        ..Filler::polynomial(2, n)
    });
    fillers.push(Filler {
        name: "own",
        method: Method::MinimumVariance(None),
        fit_ticks: eight_and_two,
        extrapolation_ticks: (-7..=0).collect(),
    });
    fillers.push(Filler {
        name: "given",
        method: Method::Given(
            vec![-0.0625, 0.1, f64::from(n) - 0.0375],
            vec![-0.7, -0.5, f64::from(n) + 1.2],
        ),
        fit_ticks: vec![-3, 0, n + 2],
        extrapolation_ticks: vec![-4, -1, 0],
    });
    fillers
}

/// A study of a gyro with all errors.
fn text(gyro: &Gyro, fillers: &[Filler]) -> String {
    let fillers: Vec<String> = fillers.iter().map(|filler| format!("  {},\n", filler.toml())).collect();
    format!(
        "title = \"A motion\"\nkind = \"gap-fill\"\nseed = 5\ntrials = {TRIALS}\n{}[switching]\ngap_ticks = {}\nfillers = \
         [\n{}]\nerrors = [\"residual\", \"extrapolation\", \"in-gap\"]\n",
        gyro.toml(),
        gyro.n,
        fillers.concat()
    )
}

/// Sums over the trials of the reference for one filler and error.
struct Sampled<'a> {
    row: Row<'a>,
    ticks: Vec<i32>,
    /// Of the whole gap, or of each of its first ticks.
    weights: Vec<(usize, Vec<f64>)>,
    largest_of_many: bool,
    /// The interval of the 99.73 % level, a little widened: errors of whole pulses are at its very edges.
    p99_73: [f64; 2],
    sum: f64,
    second: f64,
    fourth: f64,
    /// How many errors are beyond the two ends of that interval.
    beyond: [f64; 2],
}

impl<'a> Sampled<'a> {
    fn new(gyro: &Gyro, filler: &Filler, row: Row<'a>) -> Sampled<'a> {
        let error = row.text("error");
        let residual = error == "residual";
        let lengths = if error == "in-gap" { 1..=gyro.n } else { gyro.n..=gyro.n };
        let weights = |length| {
            let weights = filler.weights(gyro, residual, length);
            (length as usize, weights.unwrap_or_else(|| panic!("no weights: {}", row.place())))
        };
        Sampled {
            ticks: if residual { filler.fit_ticks.clone() } else { filler.extrapolation_ticks.clone() },
            weights: lengths.map(weights).collect(),
            largest_of_many: error == "in-gap",
            p99_73: [
                row.number("p99_73_lo") - LEVEL_ROUNDING * row.number("rms"),
                row.number("p99_73_hi") + LEVEL_ROUNDING * row.number("rms"),
            ],
            row,
            sum: 0.0,
            second: 0.0,
            fourth: 0.0,
            beyond: [0.0; 2],
        }
    }

    fn add(&mut self, trial: &crate::reference::Trial) {
        let errors = self.weights.iter().map(|(length, weights)| {
            let filled: f64 = self.ticks.iter().zip(weights).map(|(&tick, w)| w * trial.reading(tick)).sum();
            filled - trial.truth[length - 1]
        });
        let error =
            if self.largest_of_many { errors.map(f64::abs).fold(0.0, f64::max) } else { errors.sum() };
        self.sum += error;
        self.second += error * error;
        self.fourth += error.powi(4);
        for (beyond, level) in self.beyond.iter_mut().zip(self.p99_73) {
            *beyond += f64::from(u8::from(error.abs() > level));
        }
    }

    /// Largest deviation of mean, rms and 99.73 % level from the reference, in standard errors of both.
    fn compare(&self, name: &str) -> f64 {
        let (row, count) = (&self.row, REFERENCE_TRIALS as f64);
        let trials = row.number("trials");
        let (mean, second) = (self.sum / count, self.second / count);
        let rms = second.sqrt();
        let se = ((self.fourth / count - second * second) / count).sqrt() / (2.0 * rms);
        let variance = second - mean * mean;
        let mean_se = (variance / count + variance / trials).sqrt();
        let beyond_se = (0.0027 / count + 0.0027 / trials).sqrt();
        let [above_low, above_high] = self.beyond.map(|beyond| beyond / count);
        let deviations = [
            ("rms", row.number("rms"), rms, se.hypot(row.number("rms_se"))),
            ("mean", row.number("mean"), mean, mean_se),
            ("part beyond p99_73_lo", 0.0027, above_low.min(0.0027), beyond_se),
            ("part beyond p99_73_hi", 0.0027, above_high.max(0.0027), beyond_se),
        ];
        assert!(self.p99_73[1] < 1.1 * self.p99_73[0], "{name}: a level known to 10 %: {}", row.place());
        let mut largest: f64 = 0.0;
        for (what, found, expected, se) in deviations {
            let z = (found - expected) / se;
            assert!(
                z.abs() < 5.0,
                "{name}: {what} {found}, {expected} ± {se} by the reference, z = {z}: {}",
                row.place()
            );
            largest = largest.max(z.abs());
        }
        largest
    }
}

/// Whether a row has a closed form.
fn is_closed(gyro: &Gyro, error: &str) -> bool {
    let drawn = |tone: &Tone| {
        !matches!(tone.amplitude, Draw::Fixed(_) | Draw::Rayleigh(_)) || tone.frequency[0] < tone.frequency[1]
    };
    let readable = !gyro.tones.iter().any(drawn) && !matches!(gyro.beside, Beside::Profile { .. });
    (error != "in-gap" || gyro.n == 1) && (gyro.readout == 0.0 || readable)
}

/// Runs the study of a gyro and compares every row.
fn check(name: &str, gyro: &Gyro) {
    let fillers = fillers(gyro.n);
    let folder = tempfile::tempdir().unwrap();
    gyro.write_record(folder.path());
    let study = parsed(&folder.path().join("study.toml").display().to_string(), &text(gyro, &fillers));
    let table = run(&study, &folder.path().join("results"));

    let by_name: HashMap<&str, &Filler> = fillers.iter().map(|filler| (filler.name, filler)).collect();
    let mut closed: (usize, f64) = (0, 0.0);
    let mut all = Vec::new();
    for row in rows(&table) {
        assert_eq!(row.maybe("z").is_some(), is_closed(gyro, &row.text("error")), "{name}: {}", row.place());
        if let Some(z) = row.maybe("z") {
            assert!(z.abs() < 5.0, "{name}: z = {z} from the closed form: {}", row.place());
            closed = (closed.0 + 1, closed.1.max(z.abs()));
        }
        all.push(Sampled::new(gyro, by_name[row.text("filler").as_str()], row));
    }
    // Given weights say nothing of the first ticks of a gap.
    assert_eq!(all.len(), 3 * fillers.len() - usize::from(gyro.n > 1), "{name}");

    let ticks = || all.iter().flat_map(|sampled| &sampled.ticks).copied();
    let (first, last) = (ticks().min().unwrap(), ticks().max().unwrap().max(gyro.n));
    let prepared = gyro.prepared(first, last);
    let mut rng = StdRng::seed_from_u64(30);
    let in_turn = matches!(gyro.beside, Beside::Profile { every: true, .. });
    for trial in 0..REFERENCE_TRIALS {
        let position = in_turn.then(|| trial % prepared.positions());
        let trial = prepared.trial(position, &mut rng);
        all.iter_mut().for_each(|sampled| sampled.add(&trial));
    }
    let largest = all.iter().map(|sampled| sampled.compare(name)).fold(0.0, f64::max);
    println!(
        "{name}: {} rows, largest |z| {largest:.2}; {} with a closed form, largest |z| {:.2}",
        all.len(),
        closed.0,
        closed.1
    );

    let lowered = lowered(&study, &gap_fill(&study).points[0]);
    for (filler, estimates) in fillers.iter().zip(&lowered.fillers) {
        for estimate in estimates {
            let residual = estimate.error == sagnac_engine::filler::read::Error::Residual;
            let rows = estimate.rows.values();
            let first = gyro.n - rows.len() as i32 + 1;
            for (length, found) in (first..).zip(&rows) {
                let expected = filler.weights(gyro, residual, length).unwrap();
                for (found, expected) in found.iter().zip(&expected) {
                    let error = (found - expected).abs();
                    assert!(error < 1e-5, "{name}, {}: weight {found}, not {expected}", filler.name);
                }
            }
        }
    }
}

/// The gyro without and with whole pulses.
fn check_both(name: &str, gyro: &Gyro) {
    check(name, gyro);
    check(&format!("{name}, pulses of 3.2 ″"), &Gyro { readout: 3.2, ..gyro.clone() });
}

fn of_tones(tones: Vec<Tone>) -> Gyro {
    Gyro { tones, ..Gyro::still() }
}

#[test]
fn one_tone() {
    let gyro = of_tones(vec![Tone::of_rate(Draw::Fixed(12000.0), 20.0, 20.0)]);
    check_both("one tone", &gyro);
    check("one tone, n = 1", &Gyro { n: 1, ..gyro.clone() });
    check("one tone, n = 5, fine pulses", &Gyro { n: 5, readout: 0.37, ..gyro });
}

#[test]
fn tones_of_any_phase() {
    let tone = |rate, nu, phase| Tone { phase, ..Tone::of_rate(Draw::Fixed(rate), nu, nu) };
    let gyro = of_tones(vec![
        tone(6000.0, 7.0, None),
        tone(4000.0, 20.0, Some(FRAC_PI_2)),
        tone(3000.0, 33.3, Some(0.0)),
        Tone { of_angle: true, ..tone(20.0, 11.0, None) },
    ]);
    check_both("four tones", &gyro);
}

#[test]
fn an_amplitude_drawn_evenly() {
    let tone = Tone::of_rate(Draw::Uniform(4000.0, 12000.0), 20.0, 20.0);
    check_both("uniform amplitude", &of_tones(vec![tone]));
    let fixed = Tone { phase: Some(FRAC_PI_2), ..tone };
    check("uniform amplitude at the extremum", &of_tones(vec![fixed]));
    let angle = Tone { of_angle: true, amplitude: Draw::Uniform(0.0, 90.0), ..tone };
    check("uniform angle", &of_tones(vec![angle, Tone::of_rate(Draw::Fixed(3000.0), 31.0, 31.0)]));
}

#[test]
fn an_amplitude_of_rayleigh() {
    let tone = Tone::of_rate(Draw::Rayleigh(8485.0), 20.0, 20.0);
    check_both("Rayleigh amplitude", &of_tones(vec![tone]));
    let angle = Tone { of_angle: true, amplitude: Draw::Rayleigh(40.0), ..tone };
    check(
        "Rayleigh angle beside a tone",
        &of_tones(vec![angle, Tone::of_rate(Draw::Fixed(5000.0), 8.0, 8.0)]),
    );
}

#[test]
fn a_frequency_drawn_from_a_band() {
    check_both("band", &of_tones(vec![Tone::of_rate(Draw::Fixed(12000.0), 18.0, 22.0)]));
    let gyro = of_tones(vec![
        Tone::of_rate(Draw::Uniform(2000.0, 9000.0), 1.0, 60.0),
        Tone { of_angle: true, ..Tone::of_rate(Draw::Rayleigh(25.0), 10.0, 25.0) },
        Tone { phase: Some(FRAC_PI_2), ..Tone::of_rate(Draw::Fixed(2000.0), 3.0, 4.0) },
        Tone::of_rate(Draw::Fixed(2000.0), 41.0, 41.0),
    ]);
    check_both("bands of all kinds", &gyro);
}

#[test]
fn frequencies_above_half_the_tick_rate() {
    let angle = |amplitude, low, high| Tone { of_angle: true, ..Tone::of_rate(amplitude, low, high) };
    let drawn = angle(Draw::Fixed(25.0), 137.0, 139.0);
    check_both("a band above half the tick rate", &of_tones(vec![drawn]));
    let gyro = of_tones(vec![
        angle(Draw::Uniform(5.0, 20.0), 90.0, 200.0),
        Tone { phase: Some(FRAC_PI_2), ..angle(Draw::Fixed(9.0), 100.0, 110.0) },
        Tone { phase: Some(0.0), ..Tone::of_rate(Draw::Fixed(4000.0), 171.0, 171.0) },
        Tone::of_rate(Draw::Rayleigh(2000.0), 20.0, 22.0),
    ]);
    check_both("bands and a tone above half the tick rate", &gyro);
    let rate = |amplitude, low, high| of_tones(vec![Tone::of_rate(amplitude, low, high)]);
    check_both("a rate above half the tick rate", &rate(Draw::Fixed(20_000.0), 137.0, 139.0));
    check_both("a rate from slow to above the tick rate", &rate(Draw::Uniform(4000.0, 12_000.0), 5.0, 345.0));
    check_both("a rate about twice the tick rate", &rate(Draw::Rayleigh(30_000.0), 393.0, 411.0));
    check_both("a rate up to ten times the tick rate", &rate(Draw::Fixed(60_000.0), 1130.0, 2000.0));
    check_both(
        "an angle about three times the tick rate",
        &of_tones(vec![angle(Draw::Fixed(25.0), 560.0, 610.0)]),
    );
    let gaussian = Gyro { beside: Beside::Band(8485.0, [130.0, 260.0]), ..Gyro::still() };
    check_both("Gaussian 130–260 Hz", &gaussian);
}

#[test]
fn gaussian_motion_of_a_band() {
    let of_band = |band| Gyro { beside: Beside::Band(8485.0, band), ..Gyro::still() };
    check_both("Gaussian 18–22 Hz", &of_band([18.0, 22.0]));
    let mixed = Gyro {
        tones: vec![Tone::of_rate(Draw::Fixed(3000.0), 20.0, 20.0)],
        rate: -7200.0,
        ..of_band([1.0, 60.0])
    };
    check_both("Gaussian 1–60 Hz with a tone and a rate", &mixed);
}

#[test]
fn gaussian_motion_of_a_spectrum() {
    let points = vec![[2.0, 1e4], [15.0, 4e6], [30.0, 4e6], [95.0, 1e5]];
    check_both("spectrum", &Gyro { beside: Beside::Psd(points), ..Gyro::still() });
}

/// Resonances at 60 and 380 Hz, the second far above half the tick rate of 200 Hz.
fn shaken(sine: Option<[f64; 2]>, psd: Vec<[f64; 2]>) -> Gyro {
    let modes = vec![[60.0, 20.0, 9000.0], [380.0, 30.0, -30_000.0]];
    Gyro { beside: Beside::Vibration { modes, sine, psd }, ..Gyro::still() }
}

#[test]
fn a_sine_through_a_suspension() {
    check_both("sine at 57 Hz", &shaken(Some([0.8, 57.0]), vec![]));
    let beside = vec![Tone::of_rate(Draw::Fixed(3000.0), 20.0, 20.0)];
    check("sine at 383 Hz beside a tone", &Gyro { tones: beside, ..shaken(Some([1.0, 383.0]), vec![]) });
}

#[test]
fn random_vibration_through_a_suspension() {
    check_both("random 20–600 Hz", &shaken(None, vec![[20.0, 0.001], [100.0, 0.02], [600.0, 0.02]]));
}

/// A record of tones and drift, 4 s long, on 6 decimals.
fn record(every: bool) -> Gyro {
    let rate = |i: usize| {
        let t = i as f64 * 0.002;
        let rate = 9000.0 * (120.0 * t).sin() + 4000.0 * (271.0 * t).sin() * (1.3 * t).cos() + 50.0 * t;
        (rate * 1e6).round() / 1e6
    };
    let rates = (0..2001).map(rate).collect();
    Gyro { beside: Beside::Profile { file: "base.csv", step_s: 0.002, rates, every }, ..Gyro::still() }
}

#[test]
fn a_record_at_random_places() {
    check_both("record", &record(false));
}

#[test]
fn a_record_at_every_place() {
    check_both("record in turn", &record(true));
}

#[test]
fn a_rate_an_acceleration_and_the_relock() {
    let still = Gyro { rate: 36_000.0, acceleration: -90_000.0, relock: vec![20.3, 14.8], ..Gyro::still() };
    check_both("rate, acceleration and relock", &still);
    let vibrating = Gyro { tones: vec![Tone::of_rate(Draw::Fixed(12000.0), 20.0, 20.0)], ..still };
    check_both("the same under vibration", &vibrating);
}
