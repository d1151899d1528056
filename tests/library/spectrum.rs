//! Spectra of records against SciPy, closed forms and the lines and floors that simulated records have.

use core::f64::consts::PI;

use rand::SeedableRng;
use rand::rngs::StdRng;
use sagnac::allan::angles::{Angles, Trend};
use sagnac::allan::deviation::Unit;
use sagnac::analysis::data_sheet::{DataSheet, Intervals};
use sagnac::events::Events;
use sagnac::fit::selection::Terms;
use sagnac::record::log::outliers::Outliers;
use sagnac::spectrum::{Density, Floor, Line, SpectrumError, Welch, lines};
use sagnac::theory::allan::{Part, density};

use crate::noise;

const STEP_S: f64 = 0.01;

/// The angles of these rates, 100 a second.
fn angles(rates: &[f64]) -> Angles {
    Angles::from_increments(rates, STEP_S, STEP_S, Trend::None)
}

/// A record of some parts.
fn record(parts: &[Part], samples: usize, seed: u64) -> Angles {
    let mut rng = StdRng::seed_from_u64(seed);
    let each: Vec<Vec<f64>> =
        parts.iter().map(|&part| noise::angles(part, STEP_S, samples, &mut rng)).collect();
    let sum: Vec<f64> = (0..=samples).map(|k| each.iter().map(|angles| angles[k]).sum()).collect();
    Angles::from_angles(&sum, 1.0, STEP_S, Trend::None)
}

fn of(angles: &Angles, segment: usize) -> Density {
    Density::new(angles, &Welch { segment: Some(segment), ..Welch::default() }).unwrap()
}

/// The numbers that tests/data/psd/welch.py makes.
fn lehmer(samples: usize) -> Vec<f64> {
    let mut state: u64 = 1_234_567_890;
    let mut next = |i: usize| {
        state = 16_807 * state % 2_147_483_647;
        2.0 * state as f64 / 2_147_483_647.0 - 1.0 + 0.01 * i as f64
    };
    (0..samples).map(&mut next).collect()
}

#[test]
fn densities_are_those_of_scipy() {
    let text = include_str!("../data/psd/welch.csv");
    let mut compared = 0;
    for (samples, segment, word, trend) in [
        (600, 64, "constant", Trend::None),
        (600, 65, "linear", Trend::Linear),
        (300, 300, "constant", Trend::None),
    ] {
        let welch = Welch { segment: Some(segment), trend, ..Welch::default() };
        let found = Density::new(&angles(&lehmer(samples)), &welch).unwrap();
        let start = format!("{samples},{segment},{word},");
        let rows: Vec<[f64; 2]> = text
            .lines()
            .filter_map(|line| line.strip_prefix(&start)?.split_once(','))
            .map(|(f, density)| [f.parse().unwrap(), density.parse().unwrap()])
            .collect();
        assert_eq!(rows.len(), found.points.len(), "{start}");
        for ([f, expected], point) in rows.into_iter().zip(&found.points) {
            assert!((point.frequency_hz / f - 1.0).abs() < 1e-14, "{start}: {} for {f}", point.frequency_hz);
            let error = point.value / expected - 1.0;
            assert!(error.abs() < 1e-9, "{start} {f} Hz: {}, not {expected}, {error:e}", point.value);
            compared += 1;
        }
    }
    assert_eq!(compared, text.lines().count() - 1);
}

#[test]
fn no_segment_crosses_a_gap() {
    let rates = lehmer(1500);
    // The second stretch has another mean, which a segment over the gap would show.
    let second: Vec<f64> = rates[700..].iter().map(|rate| rate + 1e3).collect();
    let both: Vec<f64> =
        rates[..600].iter().copied().chain([f64::NAN; 100]).chain(second.iter().copied()).collect();
    let [a, b, found] = [&rates[..600], &second, &both].map(|rates| of(&angles(rates), 64));
    assert_eq!((a.segments, b.segments, found.segments), (17, 24, 41));
    assert_eq!(found.unused, a.unused + b.unused);
    for (i, point) in found.points.iter().enumerate() {
        let expected = (17.0 * a.points[i].value + 24.0 * b.points[i].value) / 41.0;
        assert!((point.value / expected - 1.0).abs() < 1e-9, "{i}: {}, not {expected}", point.value);
    }
    // Of 39 pairs of neighbours each has the correlation 1/36.
    assert!(
        (found.freedom - 2.0 * 41.0 * 41.0 / (41.0 + 2.0 * 39.0 / 36.0)).abs() < 1e-9,
        "{}",
        found.freedom
    );
}

#[test]
fn a_default_segment_is_an_eighth_of_the_record_or_fits_between_gaps() {
    let segment = |rates: &[f64]| Density::new(&angles(rates), &Welch::default()).unwrap().segment;
    assert_eq!(segment(&lehmer(10_000)), 1024);
    assert_eq!(segment(&lehmer(200_000)), 16_384);
    assert_eq!(segment(&lehmer(20)), 16);
    // Single losses are bridged, and longer gaps are not.
    let mut gaps = lehmer(10_000);
    gaps.iter_mut().step_by(100).for_each(|rate| *rate = f64::NAN);
    assert_eq!(segment(&gaps), 1024);
    gaps.chunks_exact_mut(170).for_each(|chunk| chunk[..70].fill(f64::NAN));
    assert_eq!(segment(&gaps), 64);
}

/// The floor is that of the record without losses; straight lines between neighbours would take a fifth of it.
#[test]
fn lost_samples_leave_the_floor_and_a_line_where_they_are() {
    let mut rates = lehmer(40_000);
    rates.iter_mut().zip(1_u32..).for_each(|(rate, i)| *rate += 0.1 * libm::sin(2.0 * f64::from(i)));
    let losses = lehmer(80_000);
    let lossy: Vec<f64> =
        rates.iter().zip(&losses[40_000..]).map(|(x, y)| if *y < 0.2 { f64::NAN } else { *x }).collect();
    let [whole, found] = [rates, lossy].map(|rates| {
        let density = Density::new(&angles(&rates), &Welch::default()).unwrap();
        let lines = lines(&density);
        (Floor::new(&density, &lines).unwrap().density, lines)
    });
    assert!((found.0 / whole.0 - 1.0).abs() < 0.06, "{} and {}", found.0, whole.0);
    assert_eq!((found.1.len(), whole.1.len()), (1, 1));
    assert!((found.1[0].amplitude / whole.1[0].amplitude - 1.0).abs() < 0.15, "{found:?}");
}

#[test]
fn what_has_no_density_is_refused_by_name() {
    let refused = |rates: &[f64], segment| {
        Density::new(&angles(rates), &Welch { segment, ..Welch::default() }).unwrap_err()
    };
    assert_eq!(refused(&lehmer(15), None), SpectrumError::RecordTooShort { longest: 15 });
    let mut gaps = lehmer(1000);
    gaps.chunks_mut(75).for_each(|chunk| {
        let missing = chunk.len().min(66);
        chunk[..missing].fill(f64::NAN);
    });
    assert_eq!(refused(&gaps, None), SpectrumError::RecordTooShort { longest: 9 });
    let long = SpectrumError::SegmentTooLong { segment: 101, longest: 100, step_s: STEP_S };
    assert_eq!(refused(&lehmer(100), Some(101)), long);
    assert_eq!(
        refused(&lehmer(100), Some(15)),
        SpectrumError::SegmentTooShort { segment: 15, step_s: STEP_S }
    );
}

#[test]
fn the_density_of_each_noise_is_its_closed_form() {
    // From a place where the window does not smear a steep density, to one where the holds still have that of flicker.
    let table = [
        (Part::angle_random_walk(0.3), 2..500, 0.0),
        (Part::quantization(0.3), 8..500, 0.0),
        (Part::rate_random_walk(0.3), 40..500, 0.0),
        (Part::markov(0.3, 0.2), 8..500, 0.0),
        (Part::bias_instability(0.3, 24), 8..100, 0.07),
    ];
    for (seed, (part, places, apart)) in (0..).zip(table) {
        let found = of(&record(&[part], 1 << 17, seed), 1024);
        let count = places.len() as f64;
        let ratio = |place: usize| {
            let point = found.points[place];
            point.value / density(&part, STEP_S, point.frequency_hz).unwrap()
        };
        let mean = places.map(ratio).sum::<f64>() / count;
        // 4 standard errors of a mean over neighbours that are correlated as 4/9 and 1/36.
        let bound =
            4.0 * libm::sqrt(2.0 / found.freedom * (1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0)) / count) + apart;
        assert!((mean - 1.0).abs() < bound, "{part:?}: {mean} times the closed form, {bound}");
    }
}

#[test]
fn intervals_contain_the_density_as_often_as_they_say() {
    let (mut inside, mut all) = (0, 0);
    for seed in 0..100 {
        let found =
            Density::new(&record(&[Part::angle_random_walk(1.0)], 4096, seed), &Welch::default()).unwrap();
        assert_eq!(found.points[0].interval, None, "the mean is missing at the lowest frequency");
        for (low, high) in found.points.iter().filter_map(|point| point.interval) {
            all += 1;
            inside += i32::from(low < 2.0 && 2.0 < high);
        }
    }
    let part = f64::from(inside) / f64::from(all);
    // 4 standard errors of 25,500 values, of which about half are independent.
    assert!((part - 0.95).abs() < 4.0 * libm::sqrt(0.95 * 0.05 / 12_750.0), "{part}");
}

/// White noise with sines of some amplitudes and frequencies, and its lines.
fn lines_of(sines: &[(f64, f64)], seed: u64) -> (Density, Vec<Line>) {
    let parts: Vec<Part> = sines.iter().map(|&(amplitude, f)| Part::sine(amplitude, f)).collect();
    let found = Density::new(
        &record(&[&[Part::angle_random_walk(0.1)], &parts[..]].concat(), 32_768, seed),
        &Welch::default(),
    );
    let found = found.unwrap();
    let lines = lines(&found);
    (found, lines)
}

#[test]
fn a_line_has_its_frequency_and_amplitude_wherever_it_lies_between_two_frequencies() {
    let spacing = 100.0 / 4096.0;
    // Of a sine in a density of 2N² over the length of the record.
    let error = libm::sqrt(0.02 / 327.68);
    for (seed, offset) in (0..).zip([0.0, 0.13, 0.3, 0.5, 0.77]) {
        let f = spacing * (800.0 + offset);
        let (_, found) = lines_of(&[(0.2, f)], seed);
        assert_eq!(found.len(), 1, "{offset}: {found:?}");
        // The mean over a sample.
        let amplitude = 0.2 * libm::sin(PI * f * STEP_S) / (PI * f * STEP_S);
        let line = &found[0];
        assert!(
            (line.amplitude - amplitude).abs() < 4.0 * error,
            "{offset}: {}, not {amplitude}",
            line.amplitude
        );
        assert!((line.frequency_hz - f).abs() < 0.15 * spacing, "{offset}: {}, not {f}", line.frequency_hz);
        assert!(line.p < 1e-9 && line.over_floor > 5.0, "{offset}: {line:?}");
    }
}

#[test]
fn a_dither_line_hides_no_other_line_and_makes_none() {
    // 68 dB over the floor, half a spacing beside a frequency of the density, and two weak lines.
    let (_, found) = lines_of(&[(100.0, 23.84), (0.2, 10.0), (0.2, 40.0)], 7);
    let frequencies: Vec<f64> =
        found.iter().map(|line| libm::round(10.0 * line.frequency_hz) / 10.0).collect();
    assert_eq!(frequencies, [10.0, 23.8, 40.0], "{found:?}");
}

#[test]
fn a_dither_whose_phase_walks_is_one_line_with_its_power() {
    let mut rng = StdRng::seed_from_u64(8);
    let mut phase = 0.0;
    let rates: Vec<f64> = (0..131_072)
        .map(|_| {
            phase += 2.0 * PI * 20.3 * STEP_S + 0.02 * noise::normal(&mut rng);
            0.8 * phase.sin() + noise::normal(&mut rng)
        })
        .collect();
    let found = lines(&Density::new(&angles(&rates), &Welch::default()).unwrap());
    assert_eq!(found.len(), 1, "{found:?}");
    // The outermost power of its skirts is below the floor.
    assert!((found[0].amplitude - 0.76).abs() < 0.04, "{found:?}");
}

#[test]
fn noise_alone_shows_a_line_in_at_most_one_of_a_hundred_records() {
    let white = vec![Part::angle_random_walk(1.0)];
    let red = vec![Part::angle_random_walk(1.0), Part::rate_random_walk(30.0), Part::quantization(0.1)];
    for parts in [white, red] {
        let shows = |seed: u64| {
            let found = Density::new(&record(&parts, 8192, 1000 + seed), &Welch::default()).unwrap();
            !lines(&found).is_empty()
        };
        let shown = (0..100).filter(|&seed| shows(seed)).count();
        // More than 4 of 100 have a probability of 0.3 %.
        assert!(shown <= 4, "{shown} of 100 records show lines: {parts:?}");
    }
}

#[test]
fn n_of_the_floor_is_within_the_interval_of_the_fit_and_its_own_contains_the_truth() {
    let (mut within, mut covered) = (0, 0);
    for seed in 0..100 {
        let angles = record(&[Part::angle_random_walk(0.7)], 8192, 2000 + seed);
        let found = Density::new(&angles, &Welch::default()).unwrap();
        let floor = Floor::new(&found, &lines(&found)).unwrap();
        let closed = Intervals { records: 0, without: None };
        let sheet = DataSheet::new(
            &Events::new(&angles, &Outliers::default(), &[]),
            &Terms::of_model(Trend::None).into(),
            Unit::Angular,
            closed,
            None,
        )
        .unwrap();
        let row = sheet.rows.iter().find(|row| row.name == "N").unwrap();
        // In °/√h.
        let n = libm::sqrt(0.5 * floor.density) / 60.0;
        within += i32::from(row.interval.is_some_and(|[low, high]| low <= n && n <= high));
        covered += i32::from(floor.interval.0 <= 2.0 * 0.49 && 2.0 * 0.49 <= floor.interval.1);
    }
    assert!(within >= 95, "within the interval of the fit in {within} of 100 records");
    // 95 less 3 standard errors.
    assert!(covered >= 88, "the interval of the floor contains the truth in {covered} of 100 records");
}

#[test]
fn the_floor_is_where_the_density_is_flat() {
    let parts = [Part::angle_random_walk(0.1), Part::rate_random_walk(0.5), Part::quantization(0.0173)];
    let found = Density::new(&record(&parts, 1 << 18, 5), &Welch::default()).unwrap();
    let floor = Floor::new(&found, &lines(&found)).unwrap();
    let [from, to] = floor.range_hz;
    // The walk has the density of N at K/2πN = 0.8 Hz, and the errors of the angles have it at 9.2 Hz.
    assert!(from > 1.0 && to < 9.0, "{from} to {to} Hz");
    // Between them it is at least 1.17 times that of N.
    assert!((floor.density / 0.02 - 1.2).abs() < 0.1, "{}", floor.density);
    let walk = Density::new(&record(&[Part::rate_random_walk(1.0)], 1 << 18, 6), &Welch::default()).unwrap();
    assert_eq!(Floor::new(&walk, &[]), None);
}
