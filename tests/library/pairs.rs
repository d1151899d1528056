//! Identity of pairs: every value of every setting beside every value of every other, the same bits everywhere.

use std::sync::Arc;

use crate::devices::{Coverage, adapters, on_cpu, on_gpu, open, reference};
use sagnac::device::gpu::Gpu;
use sagnac::record::Record;
use sagnac::tally::cover;
use sagnac::theory::minimum_variance::Band;
use sagnac::theory::vibration::Psd;
use sagnac_engine::filler::read::Error;
use sagnac_engine::filler::{Filler, Method, Target};
use sagnac_engine::kinds::gap_fill::inputs::TickNoise;
use sagnac_engine::kinds::gap_fill::verify::Configuration;
use sagnac_engine::motion::keys::{Design, Interpolation, Phase, Position};
use sagnac_engine::motion::{Amplitude, Frequency, Gaussian, Motion, Profile, Tone, Value};
use sagnac_kernel::launch::Launch;
use sagnac_kernel::width::Width;

/// A record of two tones and a drift, 4 s long.
fn profile(position: Position) -> Motion {
    let rate = |i: usize| {
        let t = i as f64 * 0.002;
        9000.0 * libm::sin(120.0 * t) + 4000.0 * libm::sin(271.0 * t) + 50.0 * t
    };
    let record = Arc::new(Record { step_s: 0.002, rates: (0..2000).map(rate).collect() });
    let profile = Profile {
        file: "made up".to_owned(),
        record,
        position,
        interpolation: Interpolation::BandLimited,
        design: Design::Whole,
    };
    Motion { profile: Some(profile), ..Motion::default() }
}

fn drawn(value: Value) -> Amplitude {
    Amplitude { of_angle: false, value }
}

fn band(low_hz: f64, high_hz: f64) -> Frequency {
    Frequency::Band(Band { low_hz, high_hz })
}

/// A motion of every kind, by its place in the list of kinds; a fixed phase goes to all tones that can have one.
fn motion(kind: usize, phase: Phase) -> Motion {
    let tone = |rate, frequency| Tone { phase, ..Tone::of_rate(rate, frequency) };
    let of_gaussian = |gaussian| Motion { gaussian: Some(gaussian), ..Motion::default() };
    match kind {
        0 => Motion::of_tone(tone(12000.0, 20.0)),
        1 => Motion {
            tones: vec![tone(9000.0, 7.0), tone(6000.0, 20.0), tone(3000.0, 33.3)],
            ..Motion::default()
        },
        2 => Motion::of_tone(Tone { amplitude: drawn(Value::Uniform([2000.0, 12000.0])), ..tone(0.0, 20.0) }),
        // Its phase is random, as lowering takes it and a study asks for.
        3 => Motion::of_tone(Tone { amplitude: drawn(Value::Rayleigh(6000.0)), ..Tone::of_rate(0.0, 20.0) }),
        // Beside a tone of fixed frequency and one of drawn angle.
        4 => Motion {
            tones: vec![
                Tone { frequency: band(18.0, 22.0), ..tone(9000.0, 20.0) },
                tone(5000.0, 41.0),
                Tone {
                    amplitude: Amplitude { of_angle: true, value: Value::Uniform([0.0, 40.0]) },
                    frequency: band(1.0, 90.0),
                    phase,
                },
            ],
            ..Motion::default()
        },
        5 => of_gaussian(Gaussian::Band { rms: 8485.0, band: Band { low_hz: 1.0, high_hz: 60.0 } }),
        6 => of_gaussian(Gaussian::Psd(Arc::new(
            Psd::new(vec![[2.0, 1e4], [15.0, 4e6], [30.0, 4e6], [95.0, 1e5]]).unwrap(),
        ))),
        7 => profile(Position::Random),
        8 => profile(Position::Every),
        9 => Motion { rate: -36_000.0, acceleration: 90_000.0, ..Motion::of_tone(tone(12000.0, 20.0)) },
        10 => Motion::default(),
        _ => panic!("no motion of kind {kind}"),
    }
}

/// Weights that sum to n, none of them a fraction of a small denominator.
fn weights(ticks: &[i32], n: u32) -> Vec<f64> {
    let count = ticks.len() as f64;
    (0..ticks.len()).map(|k| f64::from(n) / count + 0.370_37 * (k as f64 - 0.5 * (count - 1.0))).collect()
}

/// Sets of fillers.
fn fillers(set: usize, n: u32, fit_ticks: &[i32], extrapolation_ticks: &[i32]) -> Vec<Filler> {
    let named = |name: &str, method| Filler { name: name.to_owned(), method };
    let own = || named("mv", Method::MinimumVariance(Target::Own));
    let banded =
        || named("banded", Method::MinimumVariance(Target::Band(Band { low_hz: 18.0, high_hz: 22.0 })));
    let weighted = |extrapolation: bool| {
        let extrapolation = extrapolation.then(|| weights(extrapolation_ticks, n));
        named("weights", Method::Weights { residual: weights(fit_ticks, n), extrapolation })
    };
    let [constant, linear, quadratic] = [0, 1, 2].map(Filler::polynomial);
    match set {
        0 => vec![constant, linear, quadratic],
        1 => vec![quadratic],
        2 => vec![constant, own()],
        3 => vec![linear, weighted(true)],
        4 => vec![own()],
        5 => vec![weighted(true), constant, quadratic],
        6 => vec![weighted(false), banded()],
        _ => panic!("no set {set} of fillers"),
    }
}

/// The values that the pairwise cover combines, by their place in each list.
struct Factors;

/// Places of the factors that a rule names.
const NOISE: usize = 2;
const FILLERS: usize = 4;
const READOUT: usize = 8;

impl Factors {
    const GAP_TICKS: [u32; 4] = [1, 2, 3, 5];
    const MOTIONS: usize = 11;
    const NOISES: [TickNoise; 3] =
        [TickNoise::Std(1.6 / 3.0), TickNoise::AngleRandomWalk(2.0), TickNoise::Std(0.0)];
    const FILLER_SETS: usize = 7;
    const FIRST_TRIALS: [u64; 4] = [0, 12_345, (1 << 32) - (1 << 15), 1 << 40];
    const EXTRAPOLATIONS: [&[i32]; 3] = [&[-3, -2, -1, 0], &[-7, -6, -5, -4, -3, -2, -1, 0], &[-5, -2, 0]];
    const PHASES: [Phase; 3] = [Phase::Uniform, Phase::ZeroCrossing, Phase::Extremum];
    const READOUTS: [f64; 3] = [0.0, 3.2, 0.37];
    const RELOCKS: [&[f64]; 2] = [&[], &[20.3, 14.8]];
    const ERRORS: [&[Error]; 6] = [
        &[Error::Residual, Error::Extrapolation],
        &[Error::Residual],
        &[Error::Extrapolation],
        &[Error::InGap],
        &[Error::Residual, Error::Extrapolation, Error::InGap],
        &[Error::Residual, Error::InGap],
    ];

    /// Default; eight before; asymmetrical; many after; before only; after only.
    fn fit_ticks(n: i32) -> [Vec<i32>; 6] {
        [
            vec![-1, 0, n + 1, n + 2],
            (-7..=0).chain(n + 1..=n + 2).collect(),
            vec![-3, -1, 0, n + 1],
            (-1..=0).chain(n + 1..=n + 7).collect(),
            vec![-3, -2, -1, 0],
            vec![n + 1, n + 2, n + 3],
        ]
    }

    fn sizes() -> [usize; 11] {
        [
            Self::GAP_TICKS.len(),
            Self::MOTIONS,
            Self::NOISES.len(),
            Self::fit_ticks(1).len(),
            Self::FILLER_SETS,
            Self::FIRST_TRIALS.len(),
            Self::EXTRAPOLATIONS.len(),
            Self::PHASES.len(),
            Self::READOUTS.len(),
            Self::RELOCKS.len(),
            Self::ERRORS.len(),
        ]
    }

    fn configuration(row: &[usize]) -> (Configuration, u64) {
        let configuration = Configuration::new("pairwise", |c| {
            let n = Self::GAP_TICKS[row[0]];
            c.inputs.gap_ticks = n;
            c.inputs.motion = motion(row[1], Self::PHASES[row[7]]);
            c.inputs.tick_noise = Self::NOISES[row[NOISE]];
            c.inputs.readout_lsb = Self::READOUTS[row[READOUT]];
            c.inputs.relock = Self::RELOCKS[row[9]].to_vec();
            c.fit_ticks = Self::fit_ticks(n as i32)[row[3]].clone();
            c.extrapolation_ticks = Self::EXTRAPOLATIONS[row[6]].to_vec();
            c.fillers = fillers(row[FILLERS], n, &c.fit_ticks, &c.extrapolation_ticks);
            c.errors = Self::ERRORS[row[10]].to_vec();
        });
        (configuration, Self::FIRST_TRIALS[row[5]])
    }

    /// The only combination that cannot be lowered: a minimum-variance filler of ticks that neither noise nor pulses
    /// disturb. Of its three settings two may stand together, so that one is changed which is not in `kept`.
    fn mend(row: &mut [usize], kept: &[(usize, usize); 2]) {
        let designed = [2, 4, 6].contains(&row[FILLERS]);
        if designed && row[NOISE] == 2 && row[READOUT] == 0 {
            let free = |factor: usize| kept.iter().all(|(own, _)| *own != factor);
            let factor = if free(READOUT) { READOUT } else { NOISE };
            row[factor] = usize::from(factor == READOUT);
        }
    }
}

/// Rows in which every pair of values of two factors occurs. Greedy: each row takes an uncovered pair and then, factor
/// by factor, the value that covers most.
fn pairwise(sizes: &[usize]) -> Vec<Vec<usize>> {
    let mut uncovered: Vec<[(usize, usize); 2]> = Vec::new();
    for second in 0..sizes.len() {
        for first in 0..second {
            for a in 0..sizes[first] {
                uncovered.extend((0..sizes[second]).map(|b| [(first, a), (second, b)]));
            }
        }
    }
    let mut rows = Vec::new();
    while let Some(&seed) = uncovered.first() {
        let mut row: Vec<Option<usize>> = vec![None; sizes.len()];
        seed.iter().for_each(|&(factor, value)| row[factor] = Some(value));
        for factor in 0..sizes.len() {
            let gain = |value: usize| {
                let covers = |pair: &&[(usize, usize); 2]| {
                    pair.contains(&(factor, value))
                        && pair.iter().all(|&(f, v)| f == factor || row[f] == Some(v))
                };
                uncovered.iter().filter(covers).count()
            };
            // The first of the best: the order of the lists decides, nothing random.
            let best = (0..sizes[factor]).rev().max_by_key(|&value| gain(value));
            row[factor] = row[factor].or(best);
        }
        let mut row: Vec<usize> = row.into_iter().flatten().collect();
        Factors::mend(&mut row, &seed);
        uncovered.retain(|pair| !pair.iter().all(|&(factor, value)| row[factor] == value));
        rows.push(row);
    }
    rows
}

#[test]
fn the_pairwise_rows_cover_every_pair() {
    let sizes = Factors::sizes();
    let rows = pairwise(&sizes);
    for second in 0..sizes.len() {
        for first in 0..second {
            for a in 0..sizes[first] {
                for b in 0..sizes[second] {
                    assert!(
                        rows.iter().any(|row| row[first] == a && row[second] == b),
                        "{first}:{a} {second}:{b}"
                    );
                }
            }
        }
    }
}

/// The launches of a configuration; of fillers that have other errors than their neighbours one for each kind.
fn launches(configuration: &Configuration) -> Vec<Launch> {
    let lowered = configuration.lowered();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    // Weights know no error in the gap but the one at its end, and without weights of their own no extrapolation.
    let with_errors = (0..lowered.fillers.len()).filter(|&filler| !lowered.fillers[filler].is_empty());
    for filler in with_errors {
        let joins = |group: &&mut Vec<usize>| {
            let errors = |filler: usize| lowered.fillers[filler].iter().map(|estimate| estimate.error);
            group.len() < lowered.most_fillers(filler) && errors(group[0]).eq(errors(filler))
        };
        match groups.iter_mut().find(joins) {
            Some(group) => group.push(filler),
            None => groups.push(vec![filler]),
        }
    }
    groups.iter().map(|group| lowered.launch(group)).collect()
}

#[test]
fn every_pair_of_settings_is_the_same_everywhere() {
    const TRIALS: u64 = 1 << 16;
    let mut coverage = Coverage::start();
    let rows = pairwise(&Factors::sizes());
    let mut gpus: Vec<Gpu> = adapters().iter().map(|adapter| open(adapter, adapter.variant())).collect();
    let mut without_launch = 0;
    for row in &rows {
        let (configuration, first) = Factors::configuration(row);
        // A cover is made of aligned blocks, so a range across a multiple of 2^32 is split there.
        let blocks = cover(first..first + TRIALS, 63);
        let launches = launches(&configuration);
        without_launch += usize::from(launches.is_empty());
        for launch in &launches {
            let reference = reference(launch, &blocks, true);
            assert!(reference.iter().all(|tally| tally.count == TRIALS));
            for width in Width::available() {
                let found = on_cpu(width, 0, launch, &blocks, true);
                assert_eq!(found, reference, "{} from {first}, row {row:?}: {configuration:?}", width.name());
                coverage.comparisons += 1;
            }
            for gpu in &mut gpus {
                let found = on_gpu(gpu, launch, &blocks, true);
                assert_eq!(found, reference, "{} from {first}, row {row:?}: {configuration:?}", gpu.name());
                coverage.comparisons += 1;
            }
        }
    }
    assert_eq!(without_launch, 0, "rows in which no filler has an error");
    coverage.end(&format!("pairwise cover: {} rows, none refused, 2^16 trials each", rows.len()));
}
