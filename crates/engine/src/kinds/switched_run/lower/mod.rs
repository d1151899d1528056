//! Lowering of whole runs: the drift in closed form, row by row, and the random parts of each filler's runs.
//!
//! Every part has a unit of at most 2^−29 of the largest angle that a run can reach.

pub(crate) mod theory;

use crate::drift::{End, Schedule};
use crate::filler::Filler;
use crate::filler::read::Error;
use crate::key::{Streams, Unrepresentable};
use crate::kinds::gap_fill::lower::fixed::{ANGLE_UNITS, SIGMA_UNITS, long_words, mask};
use crate::kinds::gap_fill::lower::physical::{Residual, ResidualTone};
use crate::kinds::gap_fill::lower::physical_theory::{PhysicalTheory, Switch};
use crate::kinds::gap_fill::lower::{Lowered, definition, words_of};
use crate::kinds::plan::identity;
pub use crate::kinds::switched_run::lower::theory::RunTheory;
use crate::kinds::switched_run::lower::theory::{
    Coupled, Drift, FixedRelocking, INTERVALS, PhysicalRun, Row, WarmUp,
};
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::kinds::switched_run::{Angle as RunAngle, FirstMode, SwitchedRun, Timing};
use crate::motion::Frequency;
use crate::sampling;
use crate::store::Address;
use crate::tally::Id;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::{LIMIT, MAX_ESTIMATES, level};
use sagnac_kernel::normal::REACH;
use sagnac_kernel::switched_run;
use sagnac_kernel::switched_run::shape::{Parameters, Shape};

/// A point of a study of whole runs, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct LoweredRun {
    /// Id of the point, under which its draws and tallies are found.
    pub id: Id,
    /// The runs of each filler, in the order of the study's fillers; a single entry where it has none.
    pub fillers: Vec<FilledRun>,
}

/// The runs of a point with one filler.
#[derive(Debug, Clone, PartialEq)]
pub struct FilledRun {
    key: [u32; 2],
    fixed: Fixed,
    /// These runs with an exact end, from which trajectories are made. Present where trajectories are kept and the end is drawn.
    exact: Option<Box<Fixed>>,
    /// Residual of a switch.
    pub residual: Residual,
    /// Estimates in the order of the study's angles.
    pub estimates: Vec<RunEstimate>,
    /// Address of the trajectories.
    pub trajectory: Address,
}

/// One angle of the runs.
#[derive(Debug, Clone, PartialEq)]
pub struct RunEstimate {
    /// The angle: at the end, the largest, or at one of the times.
    pub angle: RunAngle,
    /// Address of its tallies.
    pub address: Address,
    /// Closed form; absent for the largest angle, which has none.
    pub theory: Option<RunTheory>,
    /// Relative difference of its rms from that of the physical inputs, where there is one.
    pub representation: Option<f64>,
    /// Size of a unit of the tally, ″.
    pub unit_arcsec: f64,
    /// Level at which its histogram starts.
    pub bin_base: u32,
}

impl FilledRun {
    /// The runs that trajectories show.
    fn shown(&self) -> &Fixed {
        self.exact.as_deref().unwrap_or(&self.fixed)
    }

    /// Size of a unit of the angles of trajectories, ″.
    pub fn trajectory_unit_arcsec(&self) -> f64 {
        self.shown().lsb_arcsec
    }

    /// Mean and standard deviation of the effect of the relock of a switch, ″.
    fn relocked(&self) -> [f64; 2] {
        let relock = self.fixed.relock.as_ref();
        relock.map_or([0.0; 2], |relock| [relock.mean, libm::hypot(relock.deviation, relock.alike)])
    }

    /// Root mean square over switches of everything that a switch adds, ″.
    pub fn residual_rms(&self) -> f64 {
        let [mean, deviation] = self.relocked();
        let about_zero = self.residual.rms();
        libm::sqrt(
            about_zero * about_zero
                + 2.0 * mean * self.residual.constant_arcsec
                + mean * mean
                + deviation * deviation,
        )
    }

    /// Approximate largest effect of a switch, ″: sines at their peaks plus three standard deviations of the rest.
    pub fn residual_max(&self) -> f64 {
        let [mean, deviation] = self.relocked();
        let amplitudes: f64 = self.residual.tones.iter().map(|tone| tone.amplitude_arcsec).sum();
        let normal = libm::sqrt(self.residual.variance_arcsec2 + deviation * deviation);
        amplitudes + (self.residual.constant_arcsec + mean).abs() + SIGMAS * normal
    }

    /// Approximate rms of one of the angles, ″; for a compensated relock it is based on its first trials.
    pub fn expected_rms(&self, place: usize) -> f64 {
        self.fixed.expected_rms(self.estimates[place].angle, place) * self.fixed.lsb_arcsec
    }
}

/// Number of standard deviations that the paper takes as the largest error.
const SIGMAS: f64 = 3.0;

impl LoweredRun {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The switch cannot be represented; see [`Unrepresentable`].
    pub fn new(
        point: &RunPoint,
        study: &SwitchedRun,
        seed: u64,
        streams: Streams,
    ) -> Result<LoweredRun, Unrepresentable> {
        let (switch, residuals) = residuals(point, study, seed, streams)?;
        let text = canonical(point, study, &switch);
        let (id, key) = identity("switched-run", seed, streams, &text);
        let drift = Drift::new(point, study);
        let schedule = Schedule { end: End::Exact, ..point.schedule };
        let exact = (study.trajectories > 0 && point.schedule.end != End::Exact)
            .then(|| RunPoint { schedule, ..point.clone() });
        let relocking = FixedRelocking::new(point)?;
        let physical = PhysicalRun::new(point, study);
        let filled = |Switched {
                          name,
                          definition,
                          residual,
                          physical: switch,
                          representation: of_switch,
                      }: Switched| {
            let relock = relocking.as_ref().map(|relocking| relocking.with(&residual.after));
            let exact = exact.as_ref().map(|point| {
                Box::new(Fixed::new(&Drift::new(point, study), &residual, relock.clone(), point, study))
            });
            let fixed = Fixed::new(&drift, &residual, relock, point, study);
            let of = |fixed: &Fixed, angle: String, more: Vec<u32>| {
                let estimate = Id::from_text(&format!("estimate\nfiller={definition}\nangle={angle}\n"));
                let words = [switched_run::VERSION, key[0], key[1]].into_iter().chain(fixed.words());
                Address { point: id, estimate, digest: Id::of_words(words.chain(more)) }
            };
            let estimate = |(place, angle): (usize, RunAngle)| {
                let theory = fixed.theory(angle, place);
                let inputs = switch.as_ref().and_then(|switch| physical.rms(switch, angle));
                let words = theory.map(|theory| theory.rms());
                let most = fixed.representation(point.switches() as f64 + 1.0, of_switch);
                if let Some(both) = words.zip(inputs) {
                    let what = format!("the angle `{}` of `{name}`", angle.name());
                    sampling::check_representation("run.duration", &what, both.into(), most)?;
                }
                let representation = sampling::representation(words, inputs, most);
                let bin_base = level((0.25 * fixed.expected_rms(angle, place)) as u32);
                let more = fixed.time_words(place).into_iter().chain([bin_base]);
                Ok(RunEstimate {
                    angle,
                    address: of(&fixed, angle.name(), more.chain(words_of(fixed.lsb_arcsec)).collect()),
                    theory,
                    representation,
                    unit_arcsec: fixed.lsb_arcsec,
                    bin_base,
                })
            };
            let estimates = study.angles().into_iter().enumerate();
            let estimates = estimates.map(estimate).collect::<Result<_, Unrepresentable>>()?;
            let shown = exact.as_deref().unwrap_or(&fixed);
            let trajectory = of(shown, "trajectory".to_owned(), words_of(shown.lsb_arcsec).to_vec());
            Ok(FilledRun { key, estimates, trajectory, fixed, exact, residual })
        };
        let fillers = residuals.into_iter().map(filled).collect::<Result<_, Unrepresentable>>()?;
        Ok(LoweredRun { id, fillers })
    }
}

/// The switch with a filler.
struct Switched {
    /// Name of the filler.
    name: String,
    definition: String,
    residual: Residual,
    /// The residual computed from the physical inputs; absent where it has no closed form.
    physical: Option<Switch>,
    /// Bound of the rms of the difference of the two, ″.
    representation: f64,
}

/// The identity of the switch, and the residual of each filler.
fn residuals(
    point: &RunPoint,
    study: &SwitchedRun,
    seed: u64,
    streams: Streams,
) -> Result<(String, Vec<Switched>), Unrepresentable> {
    let Some(fill) = &point.fill else {
        let amplitude_arcsec = point.drift.residual_max;
        let tone = ResidualTone { amplitude_arcsec, tone: 0 };
        let tones = if amplitude_arcsec > 0.0 { vec![tone] } else { vec![] };
        let switched = Switched {
            name: "none".to_owned(),
            definition: "none".to_owned(),
            residual: Residual { tones, ..Residual::default() },
            physical: Some(Switch { mean: 0.0, variance: 0.0, sines: vec![(0, amplitude_arcsec)] }),
            representation: 0.0,
        };
        return Ok((format!("residual_max={amplitude_arcsec:.11e}"), vec![switched]));
    };
    let lowered = Lowered::new(fill, study.fillers(), &[Error::Residual], seed, streams)?;
    let theory = PhysicalTheory::new(&fill.inputs, fill.sides());
    // Delivered with the ticks, in addition to its effect on the filler.
    let relock: f64 = fill.inputs.relock.iter().sum();
    let of_filler = |(place, filler): (usize, &Filler)| {
        let mut residual = lowered.residual(place).unwrap_or_default();
        residual.constant_arcsec += relock;
        let estimate = lowered.fillers[place].first();
        let physical = estimate.map(|estimate| theory.switch(&estimate.rows));
        let definition = definition(filler, estimate.map(|estimate| &*estimate.rows), fill.designed());
        Switched {
            name: filler.name.clone(),
            definition: format!("{definition} ticks={:?}", fill.fills[place].fit_ticks),
            residual,
            physical: physical.map(|switch| Switch { mean: switch.mean + relock, ..switch }),
            representation: estimate.map_or(0.0, |estimate| estimate.representation),
        }
    };
    Ok((lowered.id.to_string(), study.fillers().iter().enumerate().map(of_filler).collect()))
}

/// The inputs that determine the draws and the angles to which they are added.
fn canonical(point: &RunPoint, study: &SwitchedRun, switch: &str) -> String {
    let Schedule { interval_s, duration_s, end } = point.schedule;
    // An exact end has no line.
    let end = if end == End::Exact { String::new() } else { format!("end={}\n", end.name()) };
    let relock = point.relock.as_ref().map_or_else(String::new, |relocking| {
        let (compensation, ticks) = (relocking.compensation.name(), relocking.relock.ticks);
        format!("compensation={compensation}\nrelock_ticks={ticks}\n{}", relocking.relock.identity())
    });
    format!(
        "interval_s={interval_s:.11e}\nduration_s={duration_s:.11e}\nfirst_mode={:?}\ntiming={:?}\nswitch={switch}\n{}{relock}{end}",
        study.first_mode,
        study.timing,
        point.drift.canonical(),
    )
}

/// The angle at the end and the largest one, which precede those at given times.
const ENDS: usize = 2;

impl FilledRun {
    /// The launches of the filler's runs, each with the indices of its estimates.
    pub fn launches(&self) -> Vec<(Launch, Vec<usize>)> {
        let all: Vec<usize> = (0..self.estimates.len()).collect();
        let launch = |places: &[usize]| (self.launch(&self.fixed, places), places.to_vec());
        all.chunks(MAX_ESTIMATES).map(launch).collect()
    }

    fn launch(&self, fixed: &Fixed, places: &[usize]) -> Launch {
        let ends = places[0] == 0;
        let times: Vec<usize> = places.iter().filter_map(|place| place.checked_sub(ENDS)).collect();
        let shape = shape(fixed, ends, times.len());
        let only = |wanted: bool, words: Vec<u32>| if wanted { words } else { vec![] };
        let of_tones = |word: fn(&FixedTone) -> u32| -> Vec<u32> { fixed.tones.iter().map(word).collect() };
        let of_times = |word: fn(&FixedTime) -> u32| -> Vec<u32> {
            times.iter().map(|&time| word(&fixed.times[time])).collect()
        };
        let of_warm_up =
            |words: fn(&WarmUp) -> Vec<u32>| -> Vec<u32> { fixed.warm_up.iter().flat_map(words).collect() };
        let bin_base: Vec<u32> = places.iter().map(|&place| self.estimates[place].bin_base).collect();
        let (relock_weight, bits) =
            fixed.relock.as_ref().map(|relock| relock.weights(fixed.lsb_arcsec)).unwrap_or_default();
        let words = Parameters {
            key: &self.key,
            intervals: &[fixed.ends.len() as u32],
            walk_sigma: &only(shape.walk, fixed.walk.to_vec()),
            noise: &only(shape.noise, vec![fixed.noise]),
            warm_up_spread: &of_warm_up(|warm_up| vec![warm_up.spread_word()]),
            halving_bits: &of_warm_up(|warm_up| vec![warm_up.halving_bits]),
            halvings: &of_warm_up(|warm_up| vec![warm_up.interval_halvings()]),
            time_bits: &of_warm_up(|warm_up| vec![warm_up.time_bits]),
            heated: &of_warm_up(|warm_up| warm_up.heated().map(|word| word as u32).to_vec()),
            relock: fixed.relock.as_ref().map_or(&[], |relock| &relock.words),
            relock_weight: &relock_weight,
            relock_bits: &only(fixed.relock.is_some(), vec![bits]),
            constant: &long_words(fixed.constant),
            amplitude: &of_tones(|tone| tone.amplitude),
            phase_step: &of_tones(|tone| tone.step),
            switch_spread: &of_tones(|tone| mask(tone.each)),
            run_spread: &of_tones(|tone| mask(!tone.each)),
            time_interval: &of_times(|time| time.row.switches as u32),
            time_walk: &only(shape.walk, of_times(|time| time.walk)),
            time_bridge: &only(shape.walk, of_times(|time| time.bridge)),
            bin_base: &bin_base,
        }
        .words();
        let rows = fixed.ends.iter().chain(times.iter().map(|&time| &fixed.times[time].row));
        let rows = rows.flat_map(|row| table_row(row, shape));
        let drawn = fixed.drawn.iter().filter(|_| shape.any_end).flat_map(|end| end_row(end, shape));
        let table = rows.chain(drawn).collect();
        Launch::new(shape, words, table).expect("lowered words and tables are those of the shape")
    }

    /// The launch of trajectories, and its shape.
    pub fn trajectories(&self) -> (Launch, Shape) {
        (self.launch(self.shown(), &[0, 1]), shape(self.shown(), true, 0))
    }
}

fn shape(fixed: &Fixed, ends: bool, times: usize) -> Shape {
    let deviates = |part: usize| fixed.ends.iter().any(|row| row.deviations[part] != 0);
    Shape {
        ends,
        times,
        walk: fixed.walk != [0, 0],
        noise: fixed.noise != 0,
        tones: fixed.tones.len(),
        magnetic: deviates(0),
        initial: deviates(1),
        non_magnetic: deviates(2),
        mode: fixed.mode,
        warm_up: fixed.warm_up.is_some(),
        relock: fixed.relock.as_ref().map(|relock| relock.shape),
        any_end: ends && !fixed.drawn.is_empty(),
    }
}

fn table_row(row: &FixedRow, shape: Shape) -> Vec<u32> {
    let Shape { mode, magnetic, initial, non_magnetic, warm_up, .. } = shape;
    let has = [true, mode, magnetic, initial, non_magnetic, warm_up, warm_up];
    has.into_iter().zip(row.words()).filter(|(has, _)| *has).map(|(_, word)| word).collect()
}

fn end_row(end: &FixedTime, shape: Shape) -> Vec<u32> {
    let walk = if shape.walk { vec![end.walk, end.bridge] } else { vec![] };
    table_row(&end.row, shape).into_iter().chain([end.row.switches as u32]).chain(walk).collect()
}

/// Number of standard deviations of the sum of many switches and the random walk for which there is room; not one run
/// in 10^27 exceeds it.
const ROOM: f64 = 16.0;

/// log2 of the finest unit of 2^−24 ″.
const FINEST: i32 = 24;

/// The runs of a point with one filler, with angles in LSB.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fixed {
    pub(crate) lsb_arcsec: f64,
    /// Drift at the end of each interval.
    pub(crate) ends: Vec<FixedRow>,
    pub(crate) times: Vec<FixedTime>,
    /// Ends that are equally likely; none where the end is that of the last interval.
    pub(crate) drawn: Vec<FixedTime>,
    /// Standard deviation of the random walk over an interval and over the last one, 2^−4 LSB.
    pub(crate) walk: [u32; 2],
    /// Standard deviation of the normal part of a residual, 2^−4 LSB.
    pub(crate) noise: u32,
    /// Part common to all residuals, 2^−32 LSB.
    pub(crate) constant: i64,
    pub(crate) tones: Vec<FixedTone>,
    /// Whether the first mode is drawn.
    pub(crate) mode: bool,
    /// Warm-up, where its time constant is drawn.
    pub(crate) warm_up: Option<WarmUp>,
    pub(crate) relock: Option<Coupled>,
}

/// The drift at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedRow {
    pub(crate) switches: usize,
    /// The whole drift, or its non-magnetic part where the first mode is drawn.
    pub(crate) angle: i32,
    /// The magnetic part where the first mode is drawn.
    pub(crate) magnetic: i32,
    /// Effects of one standard deviation of A, Ω_m0 and Ω_nm, 2^−4 LSB.
    pub(crate) deviations: [i32; 3],
    /// ∫ s dt and halvings as words, for a warm-up whose time constant is drawn; then the time, s, and the integral as
    /// numbers.
    pub(crate) heating: [i32; 2],
    pub(crate) time_s: f64,
    pub(crate) held_s: f64,
}

/// A time within an interval, with the parts of its random walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedTime {
    pub(crate) row: FixedRow,
    /// Standard deviation of the random walk up to the time, 2^−4 LSB.
    pub(crate) walk: u32,
    pub(crate) bridge: u32,
}

/// The part of the residual from a tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedTone {
    /// Amplitude, 2^−2 LSB.
    pub(crate) amplitude: u32,
    /// Phase advance from switch to switch, 2^−32 turns.
    pub(crate) step: u32,
    /// Whether its phase is drawn at each switch instead of once for the run.
    pub(crate) each: bool,
}

impl Fixed {
    pub(crate) fn new(
        drift: &Drift,
        residual: &Residual,
        relock: Option<Coupled>,
        point: &RunPoint,
        study: &SwitchedRun,
    ) -> Fixed {
        let mode = study.first_mode == FirstMode::Random;
        let lsb_arcsec = lsb(drift, residual, relock.as_ref(), point, study.timing);
        let sigma = |arcsec: f64| libm::round(arcsec / lsb_arcsec * SIGMA_UNITS) as u32;
        let warm_up = WarmUp::new(point, study, lsb_arcsec);
        let row = |row: &Row| fixed_row(row, mode, lsb_arcsec, warm_up.as_ref());
        let walk = point.drift.angle_random_walk;
        // The last interval, and its length.
        let last = drift.ends.len() - 1;
        let last_s = match point.schedule.end {
            End::Any => point.schedule.interval_s,
            End::Exact => point.schedule.duration_s - last as f64 * point.schedule.interval_s,
        };
        let time = |row_at: &Row| {
            // Elapsed time of the interval.
            let from = row_at.switches as f64 * point.schedule.interval_s;
            let length = if row_at.switches < last { point.schedule.interval_s } else { last_s };
            let part = ((row_at.time_s - from) / length).clamp(0.0, 1.0);
            let whole = walk * libm::sqrt(length);
            FixedTime {
                row: row(row_at),
                walk: sigma(whole * part),
                bridge: sigma(whole * libm::sqrt(part * (1.0 - part))),
            }
        };
        let tones = residual.tones.iter().map(|tone| FixedTone {
            amplitude: libm::round(tone.amplitude_arcsec / lsb_arcsec * ANGLE_UNITS) as u32,
            step: step(point, tone.tone, study.timing),
            each: study.timing == Timing::Random,
        });
        Fixed {
            lsb_arcsec,
            ends: drift.ends.iter().map(row).collect(),
            times: drift.times.iter().map(time).collect(),
            drawn: drift.drawn.iter().map(time).collect(),
            walk: [point.schedule.interval_s, last_s].map(|length| sigma(walk * libm::sqrt(length))),
            noise: sigma(libm::sqrt(residual.variance_arcsec2)),
            constant: libm::round(residual.constant_arcsec / lsb_arcsec * libm::exp2(32.0)) as i64,
            tones: tones.collect(),
            mode,
            warm_up,
            relock,
        }
    }

    /// The words that determine all runs.
    pub(crate) fn words(&self) -> Vec<u32> {
        let tones = self.tones.iter().flat_map(|tone| [tone.amplitude, tone.step, u32::from(tone.each)]);
        let fixed = [self.walk[0], self.walk[1], self.noise, u32::from(self.mode)];
        let words = fixed.into_iter().chain(long_words(self.constant)).chain(tones);
        let warm_up = self.warm_up.iter().flat_map(|warm_up| {
            let [a, spread] = warm_up.heated().map(|word| word as u32);
            let bits = [warm_up.halving_bits, warm_up.time_bits];
            [warm_up.spread_word(), warm_up.interval_halvings(), a, spread, bits[0], bits[1]]
        });
        let relock = self.relock.iter().flat_map(|relock| relock.identity(self.lsb_arcsec));
        let drawn = self.drawn.iter().flat_map(FixedTime::words);
        words
            .chain(warm_up)
            .chain(relock)
            .chain(self.ends.iter().flat_map(FixedRow::words))
            .chain(drawn)
            .collect()
    }

    /// The further words that determine one of the study's angles.
    fn time_words(&self, place: usize) -> Vec<u32> {
        let time = place.checked_sub(2).and_then(|time| self.times.get(time));
        time.map(|time| time.words().collect()).unwrap_or_default()
    }
}

impl FixedTime {
    /// The words that determine the angle at the time.
    fn words(&self) -> impl Iterator<Item = u32> {
        self.row.words().into_iter().chain([self.row.switches as u32, self.walk, self.bridge])
    }
}

impl FixedRow {
    /// The drift as words of the kernel.
    pub(crate) fn words(&self) -> [u32; 7] {
        let ([a, b, c], [d, e]) = (self.deviations, self.heating);
        [self.angle, self.magnetic, a, b, c, d, e].map(|word| word as u32)
    }
}

fn fixed_row(row: &Row, mode: bool, lsb_arcsec: f64, warm_up: Option<&WarmUp>) -> FixedRow {
    let angle = |arcsec: f64| libm::round(arcsec / lsb_arcsec) as i32;
    let (angle, magnetic) = if mode {
        (angle(row.non_magnetic), angle(row.magnetic))
    } else {
        (angle(row.non_magnetic + row.magnetic), 0)
    };
    let deviations = row.deviations.map(|deviation| libm::round(deviation / lsb_arcsec * SIGMA_UNITS) as i32);
    let heating = warm_up.map_or([0, 0], |w| [w.held(row), w.halvings(row.time_s) as i32]);
    let (switches, time_s, held_s) = (row.switches, row.time_s, row.held_s);
    FixedRow { switches, angle, magnetic, deviations, heating, time_s, held_s }
}

/// The unit of angle, ″: a power of two that leaves room for every run.
fn lsb(
    drift: &Drift,
    residual: &Residual,
    relock: Option<&Coupled>,
    point: &RunPoint,
    timing: Timing,
) -> f64 {
    let squares = residual.tones.iter().map(|tone| 0.5 * tone.amplitude_arcsec * tone.amplitude_arcsec);
    let each = residual.variance_arcsec2 + squares.sum::<f64>();
    let amplitudes: f64 = residual.tones.iter().map(|tone| tone.amplitude_arcsec).sum();
    let walk = point.drift.angle_random_walk;
    // The parts of the warm-up are larger than their sum.
    let warm_up = if point.drift.warm_up_spread > 0.0 {
        let rate = point.drift.magnetic.abs() + REACH * point.drift.magnetic_spread;
        INTERVALS * point.schedule.interval_s * rate
    } else {
        0.0
    };
    let most = |row: &Row| {
        // Includes the switch that follows.
        let switches = row.switches as f64 + 1.0;
        let added = libm::sqrt(switches * each + walk * walk * row.time_s);
        // Residuals of tones that are in phase with each other add up in full.
        let in_phase = if timing == Timing::Random { 0.0 } else { switches * amplitudes };
        row.non_magnetic.abs()
            + row.magnetic.abs()
            + REACH * row.deviations.iter().map(|deviation| deviation.abs()).sum::<f64>()
            + switches * residual.constant_arcsec.abs()
            + ROOM * added
            + in_phase
            + amplitudes
            + warm_up
            + relock.map_or(0.0, |relock| relock.most(switches, ROOM))
    };
    let bound = drift.ends.iter().map(most).fold(0.0, f64::max);
    // A few units are reserved for rounding.
    let bits = libm::floor(libm::log2((LIMIT - 16) as f64 / bound));
    libm::exp2(-bits.min(f64::from(FINEST)))
}

/// The phase advance of a tone from switch to switch, 2^−32 turns. A residual without a motion has the same phase at
/// every switch.
fn step(point: &RunPoint, tone: usize, timing: Timing) -> u32 {
    let tones = point.fill.as_ref().map_or(&[][..], |fill| &fill.inputs.motion.tones);
    match tones.get(tone).map(|tone| tone.frequency) {
        Some(Frequency::Fixed(frequency_hz)) if timing == Timing::Periodic => {
            let turns = frequency_hz * point.schedule.interval_s;
            // A fraction that rounds up to a whole turn becomes 0.
            libm::round((turns - libm::floor(turns)) * libm::exp2(32.0)) as u64 as u32
        }
        _ => 0,
    }
}
