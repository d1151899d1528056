//! What a record holds besides steady noise: noise bursts, spikes, steps, bursts, slow sines, warm-ups, the effect of a temperature,
//! telegraph noise, lines of the spectrum and whole units of the readout.
//!
//! ```text
//! Angles, Outliers, temperatures ─ Events::new ─┬─ noise bursts, spikes: left out
//!                                              ├─ slow: steps, bursts, sines, warm-ups, temperature ─ subtracted
//!                                              └─ lines of the spectrum ─ subtracted ─▶ Events: a list, and the record without them
//! ```

mod noise_bursts;
mod slow;
mod telegraph;

use core::f64::consts::{PI, TAU};
use std::borrow::Cow;

use rayon::prelude::*;

use crate::allan::Angles;
use crate::events::slow::{Course, Found, Slow};
use crate::record::log::outliers::{self, Outliers};
use crate::spectrum::{Density, Line, Welch, lines};
use sagnac_theory::allan::Term;

/// Most angles in which lines are looked for, from the middle of the record.
const MAX_EXAMINED: usize = 1 << 20;
/// Most lines that are subtracted.
const MAX_LINES: usize = 40;
/// Numbers of blocks at which telegraph noise is looked for.
const BLOCKS: [usize; 3] = [128, 512, 2048];
/// Increase of twice the logarithm of the likelihood by a straight line from which on a ramp is identified.
const OF_RAMP: f64 = 6.0;

/// The kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// A stretch in which the white noise is larger.
    NoiseBurst,
    /// Samples that stand out from their neighbours.
    Spikes,
    /// A change of the mean rate that lasts.
    Step,
    /// A change of the mean rate that ends again.
    Burst,
    /// A sine of few cycles.
    Sine,
    /// An exponential from the start on.
    WarmUp,
    /// A rate that follows a column of temperature.
    Temperature,
    /// Steps between levels.
    Telegraph,
    /// Noise with a correlation time, such as telegraph noise whose steps do not show.
    Correlated,
    /// A line of the spectrum.
    Line,
    /// A density at high frequencies that is neither white nor that of quantization: a filter, its alias, or a hump.
    Filter,
    /// Samples that are whole multiples of a unit.
    Units,
}

impl What {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            What::NoiseBurst => "noise burst",
            What::Spikes => "spikes",
            What::Step => "step",
            What::Burst => "burst",
            What::Sine => "slow sine",
            What::WarmUp => "warm-up",
            What::Temperature => "temperature",
            What::Telegraph => "telegraph noise",
            What::Correlated => "correlated noise",
            What::Line => "line",
            What::Filter => "filter or hump",
            What::Units => "whole units",
        }
    }
}

/// An event.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Kind.
    pub what: What,
    /// Its size, ″/s: the standard deviation of a sample of the noise that a noise burst adds, the change of a step, the amplitude of a
    /// sine or a line, half the distance of the levels of telegraph noise, the rate at the start of a warm-up, the largest distance of
    /// spikes, the unit of the readout; per K for a temperature.
    pub size: Option<f64>,
    /// Its first sample and the end of the last one; absent where it lasts through the record.
    pub samples: Option<[usize; 2]>,
    /// The frequency of a sine or line, Hz.
    pub frequency_hz: Option<f64>,
    /// The time of a warm-up or of correlated noise, or the mean time between steps of telegraph noise, s.
    pub time_s: Option<f64>,
    /// Number of spikes or steps.
    pub count: usize,
    /// The temperature that it refers to, by number.
    pub other: Option<usize>,
    /// The coefficient that it explains as well, if that is all that it does: it is not certain, and stays in the record.
    pub instead_of: Option<Term>,
}

impl Event {
    /// An event of a kind without any figures.
    pub fn new(what: What) -> Event {
        let (size, samples, frequency_hz, time_s) = Default::default();
        Event { what, size, samples, frequency_hz, time_s, count: 1, other: None, instead_of: None }
    }

    /// Whether an outlier is a part of one of some events.
    pub fn is_in(events: &[Event], outlier: usize) -> bool {
        let contains = |[from, to]: [usize; 2]| (from..to).contains(&outlier);
        let has_outliers = |event: &&Event| matches!(event.what, What::NoiseBurst | What::Spikes);
        events.iter().filter(has_outliers).any(|event| event.samples.is_some_and(contains))
    }
}

/// The events of a record, and the record without them.
#[derive(Debug)]
pub struct Events<'a> {
    /// The events, whole units, noise bursts and spikes first and lines last.
    pub list: Vec<Event>,
    /// The record without the noise bursts, the spikes, the slow events and the lines.
    pub without: Cow<'a, Angles>,
    /// Whether the record is of pulses that are larger than the noise of a sample.
    pub is_coarse: bool,
    /// The density of the record without them; absent for a short record.
    pub density: Option<Density>,
    /// What explains the record as well as a coefficient.
    pub explains: Explains,
}

/// What explains the record as well as a coefficient, which is then not identified.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Explains {
    /// Whether telegraph noise explains all slow noise.
    pub is_telegraph: bool,
    /// Another event in place of a rate random walk.
    pub walk: Option<Event>,
    /// Another event in place of a ramp, because a straight line adds nothing to the record.
    pub ramp: Option<Event>,
}

impl<'a> From<&'a Angles> for Events<'a> {
    /// A record as it is, in which no events are looked for.
    fn from(angles: &'a Angles) -> Events<'a> {
        let (list, explains) = Default::default();
        let is_coarse = is_coarse(angles);
        Events { list, without: Cow::Borrowed(angles), is_coarse, density: None, explains }
    }
}

impl<'a> Events<'a> {
    /// The events of a record with these outliers. `temperatures` are °C at each increment, NaN where unknown.
    pub fn new(angles: &'a Angles, outliers: &Outliers, temperatures: &[Vec<f64>]) -> Events<'a> {
        let mut events = Events::from(angles);
        events.list.extend(readout_units(angles));
        let bursts = noise_bursts::stretches(angles);
        let mut again = None;
        if !bursts.is_empty() {
            let without = angles.without(None, &bursts.iter().cloned().flatten().collect::<Vec<usize>>());
            events.list.extend(bursts.iter().map(|samples| noise_bursts::event(angles, samples, &without)));
            // The others stand out from less noise.
            again = Some(outliers::outliers(&without.rates(0..without.len() - 1)));
            events.without = Cow::Owned(without);
        }
        let outliers = again.as_ref().unwrap_or(outliers);
        if outliers.are_spikes(angles.len()) {
            events.list.push(spikes(&events.without, outliers));
            events.without = Cow::Owned(events.without.without(None, &outliers.samples));
        }
        events.slow(temperatures);
        events.lines();
        events
    }

    /// The correlation time of noise that explains the record without its events better than flicker noise, s, if any does. Blocks of
    /// the record are no shorter than `shortest_s`.
    pub fn correlation_time_s(&self, shortest_s: f64) -> Option<f64> {
        let angles: &Angles = &self.without;
        let most = BLOCKS[BLOCKS.len() - 1];
        let m = (angles.len() - 1).div_ceil(most).max(libm::round(shortest_s / angles.step_s) as usize);
        let (values, block_s) = means(angles, m);
        telegraph::correlation(&values).map(|blocks| blocks * block_s)
    }

    /// Keeps the list, and gives the record back as it is, for a fit that does not leave the events out.
    pub fn kept(self, angles: &'a Angles) -> Events<'a> {
        Events { list: self.list, ..Events::from(angles) }
    }

    /// The events with a record of their own.
    pub fn owned(self) -> Events<'static> {
        Events { without: Cow::Owned(self.without.into_owned()), ..self }
    }

    fn slow(&mut self, temperatures: &[Vec<f64>]) {
        let record = self.without.clone();
        let Some(slow) = Slow::new(&record, temperatures) else { return };
        let (found, as_line) = slow.events();
        let levels = telegraph_of(&record);
        let is_telegraph = Slow::is_telegraph(&found) || levels.is_some();
        let walk = slow.instead_of_walk(&found).and_then(|found| event(&record, &found));
        let has_line = slow.gain_of_line(&found) >= OF_RAMP;
        let ramp = as_line.or_else(|| if has_line { None } else { slow.instead_of_line(&found) });
        let ramp = ramp.and_then(|found| event(&record, &found));
        self.explains = Explains { is_telegraph, walk, ramp };
        let is_step = |found: &&Found| is_telegraph && matches!(found.course, Course::Step { .. });
        let steps: Vec<&Found> = found.iter().filter(is_step).collect();
        self.list.extend(levels.or_else(|| telegraph(&record, &steps)));
        let others = found.iter().filter(|found| !is_step(found));
        self.list.extend(others.filter_map(|found| event(&record, found)));
        if found.iter().any(|found| found.course != Course::Line) {
            self.without = Cow::Owned(record.without(Some(&slow.rates(&found)), &[]));
        }
    }

    fn lines(&mut self) {
        // The errors of coarse pulses have lines of their own.
        if self.is_coarse {
            return;
        }
        let of = |angles: &Angles| {
            let examined = angles.len().min(MAX_EXAMINED);
            let first = (angles.len() - examined) / 2;
            match examined == angles.len() {
                true => Density::new(angles, &Welch::default()).ok(),
                false => Density::new(&angles.part(first..first + examined), &Welch::default()).ok(),
            }
        };
        let Some(density) = of(&self.without) else { return };
        let mut found = lines(&density);
        found.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        found.truncate(MAX_LINES);
        if found.is_empty() {
            self.density = Some(density);
            return;
        }
        let rates = line_rates(&self.without, &density, &found);
        self.without = Cow::Owned(self.without.without(Some(&rates), &[]));
        self.density = of(&self.without);
        let event = |line: &Line| Event {
            size: Some(line.amplitude),
            frequency_hz: Some(line.frequency_hz),
            ..Event::new(What::Line)
        };
        self.list.extend(found.iter().map(event));
    }
}

fn spikes(angles: &Angles, outliers: &Outliers) -> Event {
    let size = |&sample: &usize| {
        let beside = |range| angles.mean_rate(range).map_or(0.0, |(mean, _)| mean);
        let near = [
            beside(sample.saturating_sub(3)..sample),
            beside(sample + 1..(sample + 4).min(angles.len() - 1)),
        ];
        libm::fabs(angles.rates(sample..sample + 1)[0] - 0.5 * (near[0] + near[1]))
    };
    let samples = &outliers.samples;
    Event {
        size: samples.iter().map(size).max_by(f64::total_cmp),
        samples: samples.first().zip(samples.last()).map(|(first, last)| [*first, last + 1]),
        count: samples.len(),
        ..Event::new(What::Spikes)
    }
}

/// Telegraph noise of a record, at the number of blocks at which it shows best.
fn telegraph_of(angles: &Angles) -> Option<Event> {
    let samples = angles.len() - 1;
    let at = |blocks: usize| {
        let (values, block_s) = means(angles, samples / blocks);
        let (gain, found) = telegraph::levels(&values)?;
        let time_s = found.blocks * block_s;
        let count = (samples as f64 * angles.step_s / time_s) as usize;
        let (size, time_s) = (Some(found.size), Some(time_s));
        Some((gain, Event { size, time_s, count, ..Event::new(What::Telegraph) }))
    };
    let found = BLOCKS.iter().filter(|blocks| **blocks <= samples).filter_map(|&blocks| at(blocks));
    found.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, event)| event)
}

/// The mean rates of whole blocks of `m` samples, NaN where none is known, and the length of a block, s.
fn means(angles: &Angles, m: usize) -> (Vec<f64>, f64) {
    let mean = |i: usize| angles.mean_rate(i * m..(i + 1) * m).map_or(f64::NAN, |(mean, _)| mean);
    ((0..(angles.len() - 1) / m).map(mean).collect(), m as f64 * angles.step_s)
}

fn telegraph(angles: &Angles, steps: &[&Found]) -> Option<Event> {
    let mean = steps.iter().map(|step| libm::fabs(step.sizes[0])).sum::<f64>() / steps.len() as f64;
    let length_s = (angles.len() - 1) as f64 * angles.step_s;
    (!steps.is_empty()).then(|| Event {
        size: Some(0.5 * mean),
        time_s: Some(length_s / (steps.len() + 1) as f64),
        count: steps.len(),
        ..Event::new(What::Telegraph)
    })
}

/// The event of a course; a straight line is none.
fn event(angles: &Angles, Found { course, sizes }: &Found) -> Option<Event> {
    let step_s = angles.step_s;
    let size = Some(sizes[0]);
    let last = angles.len() - 1;
    Some(match *course {
        Course::Step { at } => {
            Event { size, samples: Some([at as usize, at as usize + 1]), ..Event::new(What::Step) }
        }
        Course::Burst { from, to } => {
            Event { size, samples: Some([from as usize, (to as usize).min(last)]), ..Event::new(What::Burst) }
        }
        Course::Sine { cycles } => Event {
            size: Some(libm::hypot(sizes[0], sizes[1])),
            frequency_hz: Some(cycles / (last as f64 * step_s)),
            ..Event::new(What::Sine)
        },
        Course::WarmUp { time } => Event { size, time_s: Some(time * step_s), ..Event::new(What::WarmUp) },
        Course::Temperature(other) => Event { size, other: Some(other), ..Event::new(What::Temperature) },
        Course::Line => return None,
    })
}

/// Increments that are examined.
const EXAMINED: usize = 1 << 14;
/// Distance from a whole multiple, in units, that rounding may leave.
const ROUNDING: f64 = 1e-3;
/// Size of a unit that matters, in standard deviations of an increment about its neighbourhood.
const MIN_UNIT: f64 = 0.5;

/// Part of equal neighbouring increments from which on pulses are so large: the noise of a sample is below 1.4 pulses.
const COARSE: f64 = 0.2;
/// Difference of neighbouring increments, relative to that of most, which counts as none.
const EQUAL: f64 = 1e-2;

/// The unit of which neighbouring increments differ by whole multiples, if it is not small against the noise.
fn readout_units(angles: &Angles) -> Option<Event> {
    let count = angles.len().saturating_sub(1);
    let stride = (count / EXAMINED).max(1);
    let rates = |i: usize| angles.rates(i..(i + 2).min(count));
    let differences: Vec<f64> = (0..count.saturating_sub(1))
        .step_by(stride)
        .map(|i| libm::fabs(rates(i)[1] - rates(i)[0]))
        .filter(|x| x.is_finite())
        .collect();
    let scatter = libm::sqrt(angles.scatter()) / angles.step_s;
    let noise = 1e-6 * scatter;
    let unit = differences.iter().copied().filter(|x| *x > noise).fold(f64::INFINITY, f64::min);
    let is_whole = |x: &f64| {
        let times = x / unit;
        libm::fabs(times - libm::round(times)) < ROUNDING * times.max(1.0)
    };
    let is_large = unit.is_finite() && unit > MIN_UNIT * scatter;
    (is_large && differences.iter().all(is_whole))
        .then(|| Event { size: Some(unit), ..Event::new(What::Units) })
}

/// Whether many neighbouring increments are equal, as of pulses that are larger than the noise of a sample.
fn is_coarse(angles: &Angles) -> bool {
    let longest = angles.runs().iter().max_by_key(|run| run.len()).cloned().unwrap_or_default();
    let values = &angles.values()[longest.start..longest.end.min(longest.start + EXAMINED)];
    let all: Vec<f64> =
        values.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]).abs()).filter(|x| x.is_finite()).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let equal = all.iter().filter(|x| **x < EQUAL * mean).count();
    equal as f64 > COARSE * all.len() as f64
}

/// The rate of some lines at each increment, ″/s, 0 outside stretches without gaps.
///
/// The amplitude and phase of each line are estimated with a Hann window of the length of a segment of the density around places
/// half a segment apart, and interpolated between them, so that lines that wander are followed as far as the density resolves
/// them. That takes about three spacings of the density from the noise at each line too.
fn line_rates(angles: &Angles, density: &Density, lines: &[Line]) -> Vec<f64> {
    let solid = angles.bridged();
    let half = density.segment / 2;
    let mut rates = vec![0.0; angles.len() - 1];
    for run in solid.runs {
        let (start, count) = (run.start, run.len() - 1);
        let increment = |i: usize| (solid.values[start + i + 1] - solid.values[start + i]) / angles.step_s;
        let knots = count.div_ceil(half) + 1;
        for line in lines {
            let per_sample = TAU * line.frequency_hz * angles.step_s;
            let amplitude = |knot: usize| -> [f64; 2] {
                let middle = knot * half;
                let range = middle.saturating_sub(half)..(middle + half).min(count);
                let weight =
                    |i: usize| 0.5 + 0.5 * libm::cos(PI * (i as f64 + 0.5 - middle as f64) / half as f64);
                let (mut total, mut sum, mut parts, mut of_one) = (0.0, 0.0, [0.0; 2], [0.0; 2]);
                for i in range {
                    let (w, x) = (weight(i), increment(i));
                    let (sin, cos) = libm::sincos(per_sample * i as f64);
                    total += w;
                    sum += w * x;
                    parts = [parts[0] + w * x * sin, parts[1] + w * x * cos];
                    of_one = [of_one[0] + w * sin, of_one[1] + w * cos];
                }
                let mean = sum / total;
                [0, 1].map(
                    |part| if total > 0.0 { 2.0 * (parts[part] - mean * of_one[part]) / total } else { 0.0 },
                )
            };
            let amplitudes: Vec<[f64; 2]> = (0..knots).into_par_iter().map(amplitude).collect();
            rates[start..start + count].par_iter_mut().enumerate().for_each(|(i, rate)| {
                let (knot, part) = (i / half, (i % half) as f64 / half as f64);
                let later = 0.5 - 0.5 * libm::cos(PI * part);
                let between = |which: usize| {
                    (1.0 - later) * amplitudes[knot][which] + later * amplitudes[knot + 1][which]
                };
                let (sin, cos) = libm::sincos(per_sample * i as f64);
                *rate += between(0) * sin + between(1) * cos;
            });
        }
    }
    rates
}
