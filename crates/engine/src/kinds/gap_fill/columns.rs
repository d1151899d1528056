//! The columns and notes of a gap-fill study, with a row for each point, filler and error.
//!
//! A filler that is designed for the motion of its study looks better there than in a gyro, whose motion is never known
//! exactly. Of a recorded motion, fillers are judged on the half from which they were not designed. Any other motion is
//! played slower and faster by [`SHIFT`]: all its frequencies change, and the rms of its rate stays. Where a study has a
//! specification, all its fillers are judged on that instead, with each frequency off by its own tolerance.

use crate::chart::Law;
use crate::filler::read::Error;
use crate::filler::{FILLERS, Fill, Filler, LISTED, Method, Part, Target};
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::inputs::{Inputs, Point};
use crate::kinds::gap_fill::lower::Theory;
use crate::kinds::gap_fill::lower::fixed::{Rows, Statistics};
use crate::kinds::gap_fill::lower::physical::MAX_PROFILE_TICKS;
use crate::kinds::gap_fill::run::{Proof, Proven};
use crate::motion::keys::{
    DESIGN, Design, FREQUENCY_HIGH, FREQUENCY_LOW, INTERPOLATION, Interpolation, Phase,
};
use crate::motion::{Frequency, Gaussian, Motion, Profile, Tone, Value};
use crate::sampling::{self, RowEstimates};
use crate::study::Study;
use crate::tally::LEVEL;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::abouts;
use sagnac_base::table::{About, ColumnOf, Role, Unit, Usual};
use sagnac_kernel::gap_fill::shape::MARGIN;
use sagnac_theory::minimum_variance::{Band, TickRows, sides};
use sagnac_theory::quadrature::Rule;
use sagnac_theory::quantile::of_sine;

/// Meaning of the column of fillers, here and in other files.
pub const FILLER: &str = "Name of the gap filler, as in `switching.fillers`.";

/// The laws that a chart can draw, each in a column.
pub(crate) const LAWS: &[Law] =
    &[Law::TaylorExtremum, Law::TaylorZeroCrossing, Law::NoiseAsPublished, Law::Noise];

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) proven: &'a Proven<'a>,
    pub(crate) filler: &'a Filler,
    pub(crate) estimate: &'a Proof,
    pub(crate) found: &'a RowEstimates,
}

impl Row<'_> {
    /// A reference curve of the chart, ″.
    pub(crate) fn law(&self, law: Law) -> Option<f64> {
        law.arcsec(&self.proven.point.inputs, self.filler, self.estimate.error, self.estimate.ticks.into())
    }

    fn z(&self) -> Option<f64> {
        let Theory { rms, rounding, resolution, omitted, .. } = self.estimate.theory;
        // A bound larger than the standard error would hide what the trials show.
        let hides = self.found.rms_se().is_some_and(|se| rounding > se);
        self.found.z(rms, if hides { resolution + omitted } else { rounding })
    }
}

/// The columns except the swept keys, in the order of the file; those of a specification come first.
#[rustfmt::skip]
pub(crate) fn columns<'a>(is_specified: bool) -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    let specified = is_specified.then(of_specification).into_iter().flatten();
    let labelled = |label, of_motion| if is_specified { of_motion } else { label };
    let mut columns = vec![
        Of::new("dt_nu", Unit::NONE, "Δt·ν", |row| row.proven.point.inputs.dt_nu().into())
            .is_of("motion.frequency", Role::Coordinate, "Δt·ν with Δt = (n+1)T/2, from the middle of the gap to the nearest valid sample; for \
                one tone of fixed frequency, else blank.")
            .defined("Δt = (n+1)T/2"),
        Of::new("amplitude_noise", Unit::NONE, "rate amplitude · T / σ", |row| row.proven.point.inputs.amplitude_noise().into())
            .is(Role::Coordinate, "A_Ω·T/σ, the angle of a tick at the peak of the rate, divided by the noise of the tick (1 σ); for one \
                tone of fixed frequency and amplitude, else blank."),
        Of::new("filler", Unit::NONE, "filler", |row| row.filler.name.as_str().into())
            .is_of(FILLERS, Role::Key, FILLER)
            .styled(LISTED),
        Of::new("error", Unit::NONE, "error", |row| row.estimate.error.name().into())
            .is_of("switching.errors", Role::Key, "The error: `residual` after the gap is closed and corrected; `extrapolation` at the end of the gap, before the \
                correction; `in-gap`, the largest error while the gap is open."),
        Of::new("trials", Unit::NONE, "trials", |row| row.found.trials.into())
            .is(Role::Trials, "Number of trials behind the estimates of the row."),
        Of::new("mean", Unit::ARCSEC, labelled("mean error", "mean error on [motion]"), |row| row.found.cell(|found| found.mean))
            .is(Role::Estimate, "Mean error, ″, with its sign.")
            .linear()
            .within(|row| row.found.mean_band()),
        Of::new("rms", Unit::ARCSEC, labelled("rms error", "rms error on [motion]"), |row| row.found.cell(|found| found.rms))
            .is(Role::Error, "Root mean square error, ″, motion and noise together.")
            .brief()
            .usual(Usual::Estimate)
            .within(|row| row.found.rms_band()),
        Of::new("rms_se", Unit::ARCSEC, "standard error of the rms", |row| row.found.rms_se().into())
            .is_of("rms", Role::StandardError, sampling::RMS_SE),
        Of::new("max", Unit::ARCSEC, labelled("largest error seen", "largest error seen on [motion]"), |row| row.found.cell(|found| found.max))
            .is(Role::Error, "The largest magnitude of an error among the trials, ″; the noise reaches 6.3 standard deviations."),
        Of::new("p99_73", Unit::ARCSEC, labelled("99.73 % error", "99.73 % error on [motion]"), |row| row.found.level(|q| Some(q.value)).into())
            .is(Role::Error, "The level, ″, which 99.73 % of errors stay below in magnitude; for a Gaussian it is 3 σ.")
            .brief()
            .usual(Usual::Answer)
            .within(|row| row.found.level_band()),
        Of::new("p99_73_lo", Unit::ARCSEC, "99.73 % error (lower)", |row| row.found.level(|q| q.low).into())
            .is_of("p99_73", Role::Lower, sampling::LEVEL_LOWER),
        Of::new("p99_73_hi", Unit::ARCSEC, "99.73 % error (upper)", |row| row.found.level(|q| q.high).into())
            .is_of("p99_73", Role::Upper, sampling::LEVEL_UPPER),
        Of::new("theory_rms", Unit::ARCSEC, "rms error (closed form)", |row| row.estimate.theory.rms.into())
            .is_of("rms", Role::Theory, "`rms` in closed form, ″, for the rounded inputs of the computation; blank where there is no closed form."),
        Of::new("theory_max", Unit::ARCSEC, "largest error of the motion (closed form)", |row| row.estimate.theory.max.into())
            .is_of("max", Role::Theory, "The largest error due to the motion in closed form, ″, without noise; only for one tone of fixed amplitude."),
        Of::new("z", Unit::NONE, "deviation from the closed form, standard errors", |row| row.z().into())
            .is_of("rms", Role::Z, sampling::Z),
        Of::new("representation", Unit::NONE, "representation", |row| row.estimate.representation.into())
            .is_of("rms", Role::Representation, sampling::REPRESENTATION),
    ];
    if is_specified {
        // What is sampled is [motion] alone, which is not what fillers are judged on.
        columns.iter_mut().for_each(|column| column.about.usual = None);
    }
    specified.chain(columns).collect()
}

/// The columns of a study with a specification.
#[rustfmt::skip]
fn of_specification<'a>() -> [ColumnOf<Row<'a>>; 3] {
    type Of<'a> = ColumnOf<Row<'a>>;
    [
        Of::new("latency", Unit::S, "latency", |row| row.estimate.specified.map(|own| own.latency_s).into())
            .is(Role::Coordinate, "Time from the end of the gap to the correction, s; of the error `residual`.")
            .brief(),
        Of::new("specified_rms", Unit::ARCSEC, "rms error as specified", |row| row.estimate.specified.map(|own| own.worst.rms).into())
            .is(Role::Error, "The largest root mean square residual on the motion of `[specification]` with all its frequencies within their \
                tolerances, with noise, ″, in closed form.")
            .brief()
            .usual(Usual::Estimate),
        Of::new("specified_p99_73", Unit::ARCSEC, "99.73 % error as specified", |row| row.estimate.specified.map(|own| own.worst.level).into())
            .is_of("specified_rms", Role::Error, "The level, ″, which 99.73 % of these residuals stay below in magnitude; of several lines the one with the largest \
                residual counts as a sine, and all else as normally distributed.")
            .brief()
            .usual(Usual::Answer),
    ]
}

/// All possible columns of such a study except the swept keys.
pub(crate) fn described() -> Vec<About> {
    let laws = LAWS.iter().map(|law| law.about());
    let all = of_specification().into_iter().chain(columns(false)).collect::<Vec<_>>();
    abouts(&all).into_iter().chain(laws).collect()
}

/// Largest plausible rate of a gyro: 1000 °/s, in ″/s.
const PLAUSIBLE_RATE: f64 = 3.6e6;

/// Notes on the motion of the points, each once and as a sentence; `written` gives the number of written tones.
pub(crate) fn of_motion(written: &Inputs, points: &[Point]) -> Vec<String> {
    let written = written.motion.tones.len();
    aliased(written, points).into_iter().chain(fast(written, points)).collect()
}

/// Notes that a tone or Gaussian motion appears at another frequency in the ticks. Vibration through a suspension has its own
/// key for that.
fn aliased(written: usize, points: &[Point]) -> Option<String> {
    let highest = |point: &Point| {
        let tones = point.inputs.motion.tones.iter().take(written);
        let gaussian = point.inputs.motion.gaussian.as_ref().and_then(Gaussian::highest_hz);
        tones.map(|tone| tone.band().high_hz).chain(gaussian).fold(0.0, f64::max)
    };
    let periods = |point: &Point| highest(point) * point.inputs.tick_s;
    let most = points.iter().max_by(|a, b| periods(a).total_cmp(&periods(b)))?;
    (periods(most) > 0.5).then(|| {
        format!(
            "vibration of {} Hz is above half the tick rate, {} Hz: it appears in the ticks at a lower frequency, as it does in those of a \
             gyro",
            significant(highest(most), 4),
            significant(0.5 / most.inputs.tick_s, 4)
        )
    })
}

/// Notes that an amplitude of the angle gives an implausible rate.
fn fast(written: usize, points: &[Point]) -> Option<String> {
    let rate = |tone: &Tone| tone.amplitude.value.scale() * tone.rate_factor(tone.band().high_hz);
    let tones = points.iter().flat_map(|point| point.inputs.motion.tones.iter().take(written));
    let most = tones.filter(|tone| tone.amplitude.of_angle).max_by(|a, b| rate(a).total_cmp(&rate(b)))?;
    (rate(most) > PLAUSIBLE_RATE).then(|| {
        format!(
            "an angle of {}° at {} Hz is a rate of {} °/s at its peak; an amplitude of the rate is written as in \"5 deg/s\"",
            significant(most.amplitude.value.scale() / 3600.0, 4),
            significant(most.band().high_hz, 4),
            significant(rate(most) / 3600.0, 3)
        )
    })
}

/// Difference of two rms errors that is reported.
const REPORTED: f64 = 0.01;

/// Reports the filler whose rms residual, with noise and whole pulses, differs most if the record is interpolated in the
/// other way; `None` where no difference exceeds 1 %. Evaluated at the hardest point, over all places on which fillers are
/// judged, with fillers that are designed from the record as it is interpolated: what the table of such a study has.
pub(crate) fn interpolation_note<'a>(points: &[Point], fillers: &'a [Filler]) -> Option<String> {
    let point = Point::hardest(points)?;
    let inputs = &point.inputs;
    let profile = inputs.motion.profile.as_ref()?;
    let n = inputs.gap_ticks as usize;
    let (count, before) = profile.replayed(inputs.tick_s);
    // Lowering refuses other records.
    if count < 2 * MARGIN + n || count + before > MAX_PROFILE_TICKS {
        return None;
    }
    let other = match profile.interpolation {
        Interpolation::BandLimited => Interpolation::Linear,
        Interpolation::Linear => Interpolation::BandLimited,
    };
    let both = [profile.interpolation, other].map(|interpolation| {
        let profile = Profile { interpolation, ..profile.clone() };
        let angles = profile.tick_angles(inputs.tick_s);
        let motion = Motion { profile: Some(profile), ..inputs.motion.clone() };
        (angles, Inputs { motion, ..inputs.clone() })
    });
    let statistics = both.each_ref().map(|(_, inputs)| Statistics::new(inputs));
    let of_filler = |(filler, fill): (&'a Filler, &Fill)| {
        let ticks = &fill.fit_ticks;
        let rms = |which: usize| {
            let rows = Rows::new(filler, Error::Residual, ticks, &statistics[which]).ok()??;
            let weights = rows.values().pop()?;
            Some(residual_rms(
                &both[which].0[before..],
                ticks,
                &weights,
                n,
                of_noise(inputs, ticks, &weights),
            ))
        };
        let (own, other) = (rms(0)?, rms(1)?);
        (own > 0.0).then(|| (filler.name.as_str(), own, other / own - 1.0))
    };
    let all = fillers.iter().zip(point.fills.iter()).filter_map(of_filler);
    let (filler, own, change) = all.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
    (change.abs() > REPORTED).then(|| {
        format!(
            "between its samples, the rate of {} is taken as {}: with {} = \"{}\" the residual of {} would be {} instead of {}″ rms, {} % \
             {}{}",
            profile.file,
            profile.interpolation.name(),
            INTERPOLATION.name,
            other.name(),
            filler,
            significant(own * (1.0 + change), 3),
            significant(own, 3),
            significant(100.0 * change.abs(), 2),
            if change > 0.0 { "more" } else { "less" },
            point.place()
        )
    })
}

/// The rms over all places of a gap of n in a record of the error that some weights leave, which noise alone makes as large
/// as `of_noise`.
fn residual_rms(angles: &[f64], ticks: &[i32], weights: &[f64], n: usize, of_noise: f64) -> f64 {
    let places = MARGIN..angles.len() + 1 - MARGIN - n;
    let count = places.len() as f64;
    let square = |start: usize| {
        let lost: f64 = angles[start..start + n].iter().sum();
        let read = |&tick: &i32| angles[(start - 1).wrapping_add_signed(tick as isize)];
        let filled: f64 = ticks.iter().zip(weights).map(|(tick, w)| w * read(tick)).sum();
        (filled - lost) * (filled - lost)
    };
    let motion = places.map(square).sum::<f64>() / count;
    libm::hypot(libm::sqrt(motion), of_noise)
}

/// Relative change of all frequencies of a motion, down and up.
pub const SHIFT: f64 = 0.05;

/// The size of a residual with noise, ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Its rms.
    pub rms: f64,
    /// The level below which 99.73 % of its magnitudes stay.
    pub level: f64,
}

impl Size {
    /// The larger of each number.
    pub fn max(self, other: Size) -> Size {
        Size { rms: self.rms.max(other.rms), level: self.level.max(other.level) }
    }
}

/// The residual of a filler on the motion as given and on what it may be instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// That on the motion as given.
    pub own: Size,
    /// The largest with frequencies off by [`SHIFT`], or within the tolerances of a specification.
    pub shifted: Size,
}

impl Judged {
    /// Judges a filler that is designed for the motion of `inputs`, or any filler where there is a specification; `None` for
    /// other fillers, for recorded motion, for a motion at rest or of a fixed phase, and where the weights are not determined.
    pub fn of(inputs: &Inputs, filler: &Filler, fill: &Fill) -> Option<Judged> {
        if inputs.specification.is_none() && !is_for(&filler.method, &inputs.motion) {
            return None;
        }
        let ticks = &fill.fit_ticks;
        let rows = Rows::new(filler, Error::Residual, ticks, &Statistics::new(inputs)).ok()??;
        Judged::of_weights(inputs, ticks, &rows.values().pop()?)
    }

    /// Judges some weights; `None` without a specification for recorded motion and a motion at rest or of a fixed phase.
    pub fn of_weights(inputs: &Inputs, ticks: &[i32], weights: &[f64]) -> Option<Judged> {
        let motion = &inputs.motion;
        let is_drawn = motion.tones.iter().all(|tone| tone.phase == Phase::Uniform);
        let swings = !motion.tones.is_empty() || motion.gaussian.is_some();
        let has_level = inputs.specification.is_some() || motion.profile.is_none() && is_drawn && swings;
        has_level.then(|| Judge::new(inputs, sides(ticks, inputs.gap_ticks)).judge(ticks, weights))
    }

    /// The largest residual on the motion as given and with frequencies off.
    pub fn worst(self) -> Size {
        self.own.max(self.shifted)
    }
}

/// The relative change of all frequencies where fillers are judged; `None` where a specification has tolerances.
pub fn shift(inputs: &Inputs) -> Option<f64> {
    inputs.specification.is_none().then_some(SHIFT)
}

/// How far frequencies are off, after `with`.
pub fn deviation(shift: Option<f64>) -> String {
    match shift {
        Some(shift) => format!("all frequencies up to {} % lower or higher", 100.0 * shift),
        None => "all frequencies within their tolerances".to_owned(),
    }
}

/// The motions on which weights are judged: as given first, and as they may be instead.
pub struct Judge<'a> {
    inputs: &'a Inputs,
    motions: Motions<'a>,
}

enum Motions<'a> {
    /// The motion of the point, as it is, slower and faster.
    Played(Box<[Played<'a>; 3]>),
    /// The parts of the specification, each as it may be, and whether it is a line.
    Specified(Vec<(Vec<TickRows>, bool)>),
}

impl<'a> Judge<'a> {
    /// The motions of `inputs`, with `sides` ticks on either side of the gap.
    pub fn new(inputs: &'a Inputs, sides: usize) -> Judge<'a> {
        let rows = |tone| Motion::of_tone(tone).tick_rows(inputs.tick_s, inputs.gap_ticks, sides);
        let part = |part: &Part| (part.possible().into_iter().map(rows).collect(), part.is_line());
        let motions = match &inputs.specification {
            Some(specification) => Motions::Specified(specification.parts.iter().map(part).collect()),
            None => {
                let played = |speed| Played::new(inputs, speed, sides);
                Motions::Played(Box::new([1.0, 1.0 - SHIFT, 1.0 + SHIFT].map(played)))
            }
        };
        Judge { inputs, motions }
    }

    /// The residual that some weights leave.
    pub fn judge(&self, ticks: &[i32], weights: &[f64]) -> Judged {
        match &self.motions {
            Motions::Played(motions) => {
                let [own, slower, faster] = motions.each_ref().map(|motion| motion.errors(ticks, weights));
                Judged { own, shifted: slower.max(faster) }
            }
            Motions::Specified(parts) => {
                let noise = of_noise(self.inputs, ticks, weights);
                let variances = |(rows, is_line): &(Vec<TickRows>, bool)| {
                    let variance =
                        |rows: &TickRows| rows.error_variance(ticks, weights, self.inputs.gap_ticks);
                    (rows.iter().map(variance).collect::<Vec<_>>(), *is_line)
                };
                let parts: Vec<(Vec<f64>, bool)> = parts.iter().map(variances).collect();
                let size = |of_part: fn(&[f64]) -> f64| {
                    sum(noise, parts.iter().map(|(variances, is_line)| (of_part(variances), *is_line)))
                };
                let own = size(|variances| variances[0]);
                Judged { own, shifted: size(|variances| variances.iter().copied().fold(0.0, f64::max)) }
            }
        }
    }
}

/// The size of noise and of independent parts, each with its variance and whether it is a sine. The largest sine has the
/// distribution of a sine, and all else counts as normally distributed.
fn sum(noise_rms: f64, parts: impl Iterator<Item = (f64, bool)> + Clone) -> Size {
    let all = noise_rms * noise_rms + parts.clone().map(|(variance, _)| variance).sum::<f64>();
    let sine = parts.filter(|(_, is_line)| *is_line).map(|(variance, _)| variance).fold(0.0, f64::max);
    // A sine of uniform phase has half its squared amplitude as variance.
    let level = of_sine(&[(libm::sqrt(2.0 * sine), 1.0)], libm::sqrt((all - sine).max(0.0)), LEVEL);
    Size { rms: libm::sqrt(all), level }
}

/// The ticks of the motion played faster by a factor, ″, with `sides` ticks on either side of the gap.
fn played(inputs: &Inputs, speed: f64, sides: usize) -> TickRows {
    // A tick of the faster motion is a longer one of the slower motion, whose angles are as much larger.
    inputs.motion.tick_rows(inputs.tick_s * speed, inputs.gap_ticks, sides).scaled(1.0 / speed)
}

/// The rms residual that some weights leave of the noise and pulses of `inputs` alone, ″.
pub fn of_noise(inputs: &Inputs, ticks: &[i32], weights: &[f64]) -> f64 {
    rms(inputs, ticks, weights, &TickRows::default())
}

/// The rms residual that some weights leave of a motion, with the noise and pulses of `inputs`, ″.
fn rms(inputs: &Inputs, ticks: &[i32], weights: &[f64], motion: &TickRows) -> f64 {
    let noise = inputs.noise_covariance();
    let pairs = || ticks.iter().zip(weights);
    let shared = |(&a, u): (&i32, &f64)| {
        let of = |(&b, v): (&i32, &f64)| u * v * noise.get(a.abs_diff(b) as usize).copied().unwrap_or(0.0);
        pairs().map(of).sum::<f64>()
    };
    let motion = motion.error_variance(ticks, weights, inputs.gap_ticks);
    // Differences of equal numbers may come out below 0.
    libm::sqrt((motion + pairs().map(shared).sum::<f64>()).max(0.0))
}

/// Whether a filler is designed for this very motion.
fn is_for(method: &Method, motion: &Motion) -> bool {
    let band = match method {
        Method::MinimumVariance(Target::Own) => return true,
        Method::MinimumVariance(Target::Band(band)) => band,
        Method::MinimumVariance(Target::Specification(_)) | Method::Closed(_) | Method::Weights { .. } => {
            return false;
        }
    };
    let of_gaussian = match &motion.gaussian {
        None => vec![],
        Some(Gaussian::Band { band, .. }) => vec![*band],
        Some(Gaussian::Psd(_) | Gaussian::Vibration { .. }) => return false,
    };
    let bands: Vec<Band> = motion.tones.iter().map(Tone::band).chain(of_gaussian).collect();
    bands.iter().all(|own| own == band)
}

/// A note on the fillers that are judged on what they were designed from, or on the rest of a record; of a specification
/// the table says it.
pub(crate) fn mismatch_note(points: &[Point], fillers: &[Filler]) -> Option<String> {
    let point = Point::hardest(points).filter(|point| point.inputs.specification.is_none())?;
    let designed = fillers.iter().filter(|filler| filler.method == Method::MinimumVariance(Target::Own));
    let names: Vec<&str> = designed.map(|filler| filler.name.as_str()).collect();
    if let Some(profile) = &point.inputs.motion.profile {
        let (names, file) = (names.join(", "), &profile.file);
        return match profile.design {
            _ if names.is_empty() => None,
            Design::FirstHalf => Some(format!(
                "designed from the first half of {file}: {names}; all fillers are judged on its second half, unless {} = \"{}\"",
                DESIGN.name,
                Design::Whole.name()
            )),
            Design::Whole => Some(format!(
                "designed from the whole of {file}, on which it is judged too: {names}; another record will show a larger error"
            )),
        };
    }
    let number = |rms: f64| significant(rms, 3);
    let judged: Vec<String> = fillers
        .iter()
        .zip(point.fills.iter())
        .filter_map(|(filler, fill)| Some((filler, Judged::of(&point.inputs, filler, fill)?)))
        .map(|(filler, Judged { own, shifted })| {
            format!("{} {}″ and {}″", filler.name, number(own.rms), number(shifted.rms))
        })
        .collect();
    (!judged.is_empty()).then(|| {
        format!(
            "minimum-variance fillers designed for the motion on which they are judged, with the rms residual of \
             vibration and noise there, and if all frequencies are {} % lower or higher: {}{}",
            100.0 * SHIFT,
            judged.join(", "),
            point.place()
        )
    })
}

/// The ends of the band from which a frequency is drawn.
const BAND: [&str; 2] = [FREQUENCY_LOW.name, FREQUENCY_HIGH.name];

/// Tables whose keys enter the design of a filler of least variance.
const DESIGN_TABLES: [&str; 3] = ["motion.", "gyro.", "noise."];

/// What minimum-variance fillers without a band are designed for, so that firmware cannot have them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tuning {
    /// The very motion of each point, of which there are several.
    Points,
    /// One motion, whose frequency is fixed to the last digit.
    Frequency,
}

/// The fillers of a study that are designed without a band, and for what; `None` where there are none, or where they are
/// designed for the band from which the motion is drawn.
pub fn tuned<'a>(study: &Study, fill: &'a GapFill) -> Option<(Tuning, Vec<&'a str>)> {
    let is_bandless = |filler: &&Filler| filler.method == Method::MinimumVariance(Target::Own);
    let names: Vec<&str> =
        fill.fillers.iter().filter(is_bandless).map(|filler| filler.name.as_str()).collect();
    let tones = &fill.inputs.motion.tones;
    let is_fixed = tones.iter().any(|tone| matches!(tone.frequency, Frequency::Fixed(_)));
    // A band that is swept is known to the designer, who designs for each.
    let is_band = |key: &str| !is_fixed && !tones.is_empty() && BAND.contains(&key);
    let of_design = |key: &str| DESIGN_TABLES.iter().any(|table| key.starts_with(table)) && !is_band(key);
    let varies = study.sweeps.iter().any(|sweep| sweep.values.len() > 1 && of_design(sweep.key.name));
    let tuning = match (varies, is_fixed) {
        (true, _) => Tuning::Points,
        (false, true) => Tuning::Frequency,
        (false, false) => return None,
    };
    (!names.is_empty()).then_some((tuning, names))
}

/// A motion at a speed.
pub(crate) struct Played<'a> {
    inputs: &'a Inputs,
    /// Its ticks, ″.
    rows: TickRows,
    /// The sine that the motion is, at each of the frequencies from which it is drawn, with their probabilities; empty for
    /// other motions, whose errors count as normally distributed.
    sines: Vec<(TickRows, f64)>,
}

impl<'a> Played<'a> {
    /// The motion of `inputs` played faster by a factor, with `sides` ticks on either side of the gap.
    pub(crate) fn new(inputs: &'a Inputs, speed: f64, sides: usize) -> Played<'a> {
        let at = |frequency_hz: f64| {
            let tone = Tone { frequency: Frequency::Fixed(frequency_hz), ..inputs.motion.tones[0] };
            let inputs = Inputs { motion: Motion::of_tone(tone), ..inputs.clone() };
            played(&inputs, speed, sides)
        };
        let sines = match sine(&inputs.motion).map(|tone| &tone.frequency) {
            None => vec![],
            Some(Frequency::Fixed(frequency_hz)) => vec![(at(*frequency_hz), 1.0)],
            Some(Frequency::Band(band)) => {
                let mut sines = Vec::new();
                let width = band.high_hz - band.low_hz;
                Rule::Panels.integrate(band.low_hz, band.high_hz, 0.0, |frequency_hz, weight| {
                    sines.push((at(frequency_hz), weight / width));
                });
                sines
            }
        };
        Played { inputs, rows: played(inputs, speed, sides), sines }
    }

    /// The size of the error, with noise.
    pub(crate) fn errors(&self, ticks: &[i32], weights: &[f64]) -> Size {
        let Played { inputs, rows, sines } = self;
        let of = |rows: &TickRows| rms(inputs, ticks, weights, rows);
        let all = of(rows);
        if sines.is_empty() {
            return Size { rms: all, level: of_sine(&[(0.0, 1.0)], all, LEVEL) };
        }
        let amplitude = |(rows, share): &(TickRows, f64)| {
            // A sine of uniform phase has half its squared amplitude as variance.
            (libm::sqrt(2.0 * rows.error_variance(ticks, weights, inputs.gap_ticks)), *share)
        };
        let amplitudes: Vec<(f64, f64)> = sines.iter().map(amplitude).collect();
        Size { rms: all, level: of_sine(&amplitudes, of(&TickRows::default()), LEVEL) }
    }
}

/// The single sine of fixed amplitude and uniform phase that a motion is; `None` for other motions.
fn sine(motion: &Motion) -> Option<&Tone> {
    let [tone] = &motion.tones[..] else { return None };
    let is_alone = motion.gaussian.is_none() && motion.profile.is_none();
    let is_plain = tone.phase == Phase::Uniform && matches!(tone.amplitude.value, Value::Fixed(_));
    (is_alone && is_plain).then_some(tone)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::kinds::gap_fill::GapFill;
    use crate::study::Study;
    use sagnac_records::record::Record;
    use sagnac_theory::gap::{polynomial_weights, sine_response, tick_amplitude};
    use sagnac_theory::minimum_variance::dot;

    fn notes(amplitude: &str, motion: &str, sweep: &str) -> Vec<String> {
        let text = format!(
            "title = \"t\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"5 ms\"\ntick_noise = {{ std = \"1 arcsec\" }}\n[motion]\n\
             amplitude = \"{amplitude}\"\n{motion}\n[switching]\ngap_ticks = 3\nfillers = [\"const\"]\n{sweep}"
        );
        Study::parse("a.toml", &text).unwrap().notes
    }

    #[test]
    fn vibration_above_half_the_tick_rate_is_said_to_be_aliased() {
        let aliased = |motion: &str, sweep: &str| notes("12000 arcsec/s", motion, sweep);
        assert!(aliased("frequency = \"100 Hz\"", "").is_empty());
        let said = aliased("frequency = \"150 Hz\"", "");
        assert!(
            said.len() == 1 && said[0].starts_with("vibration of 150 Hz is above half the tick rate, 100 Hz")
        );
        let sweep = "[[sweep]]\nkey = \"gyro.tick\"\nlist = [\"5 ms\", \"20 ms\"]\n";
        let swept = aliased("frequency = \"30 Hz\"", sweep);
        assert!(
            swept.len() == 1 && swept[0].contains("30 Hz is above half the tick rate, 25 Hz"),
            "{swept:?}"
        );
    }

    #[test]
    fn an_angle_that_would_be_a_wild_rate_is_told() {
        let fast = |amplitude: &str| notes(amplitude, "frequency = \"35 Hz\"", "");
        assert!(fast("82 arcsec").is_empty() && fast("2000 deg/s").is_empty());
        let said = fast("5 deg");
        assert!(
            said.len() == 1 && said[0].starts_with("an angle of 5° at 35 Hz is a rate of 1100 °/s"),
            "{said:?}"
        );
    }

    #[test]
    fn a_recorded_sine_leaves_the_closed_form_up_to_four_fifths_of_half_its_sampling_rate() {
        let (step_s, n, ticks) = (0.001, 3, [-1, 0, 4, 5]);
        let quadratic = polynomial_weights(&ticks, 2, n).unwrap();
        let weights: Vec<f64> = quadratic.values().collect();
        for part in [0.05, 0.21, 0.4, 0.6, 0.8] {
            let nu = part * 0.5 / step_s;
            let rate = |i: i32| 12000.0 * libm::sin(2.0 * PI * nu * f64::from(i) * step_s);
            let record = Record { step_s, rates: (0..60_000).map(rate).collect() };
            for tick_s in [0.000503, 0.001, 0.00137, 0.00253] {
                let (a, b) = sine_response(&quadratic, n, nu * tick_s);
                let largest = 12000.0 * tick_amplitude(tick_s, nu * tick_s) * libm::hypot(a, b);
                let exact = largest.abs() / core::f64::consts::SQRT_2;
                let rms = |angles: Vec<f64>| residual_rms(&angles, &ticks, &weights, n as usize, 0.0);
                let found = rms(record.band_limited_tick_angles(tick_s));
                // What the window leaves of a tick, on all ticks alike, and a part of a turn among all places.
                let tolerance = 2e-5 * 12000.0 * tick_s * (3.0 + quadratic.largest_gain()) + 1e-3 * exact;
                assert!((found - exact).abs() < tolerance, "{part}, {tick_s} s: {found}, not {exact}");
                // Straight lines lose sinc² of the sine, and gain its images.
                let lines = rms(record.tick_angles(tick_s));
                assert!(part < 0.3 || (lines / exact - 1.0).abs() > 0.02, "{part}, {tick_s} s: {lines}");
            }
        }
    }

    /// The notes of a study of a record of a sine at a part of half the sampling rate, with ticks of a sample.
    fn notes_of_record(part: f64, profile: &str, fillers: &str) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        let rate = |i: u32| format!("{i}, {}\n", 3.0 * libm::sin(PI * part * f64::from(i)));
        let rows: String = (0..2000).map(rate).collect();
        std::fs::write(folder.path().join("base.csv"), format!("time [ms], rate [deg/s]\n{rows}")).unwrap();
        let text = format!(
            "title = \"t\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"1 ms\"\ntick_noise = {{ std = \"0.01 arcsec\" }}\n\
             [motion]\nprofile = {{ file = \"base.csv\"{profile} }}\n[switching]\ngap_ticks = 4\nfillers = [{fillers}]\n"
        );
        Study::parse(&folder.path().join("study.toml").display().to_string(), &text).unwrap().notes
    }

    #[test]
    fn a_difference_above_one_percent_is_said_with_both_numbers() {
        // sinc² of a tenth of the sampling rate is 0.968.
        let said = notes_of_record(0.2, "", "\"const\"");
        assert!(said.len() == 1 && said[0].contains("base.csv is taken as band-limited"), "{said:?}");
        assert!(
            said[0].contains("motion.profile.interpolation = \"linear\"") && said[0].contains(" % less"),
            "{said:?}"
        );
        let linear = notes_of_record(0.2, ", interpolation = \"linear\"", "\"const\"");
        assert!(linear.len() == 1 && linear[0].contains(" % more"), "{linear:?}");
        assert!(notes_of_record(0.05, "", "\"const\"").is_empty());
    }

    #[test]
    fn the_part_from_which_a_filler_is_designed_is_said() {
        let mv = "\"const\", { kind = \"minimum-variance\", name = \"mv\" }";
        let halves = notes_of_record(0.05, "", mv);
        assert!(
            halves[0].starts_with("designed from the first half of base.csv: mv; all fillers are judged"),
            "{halves:?}"
        );
        let whole = notes_of_record(0.05, ", design = \"whole\"", mv);
        assert!(
            whole[0].starts_with("designed from the whole of base.csv, on which it is judged too: mv"),
            "{whole:?}"
        );
        let banded = "{ kind = \"minimum-variance\", band = [\"20 Hz\", \"30 Hz\"] }";
        assert!(notes_of_record(0.05, "", banded).is_empty());
    }

    fn study(frequency: &str, more: &str) -> Study {
        let text = format!(
            "title = \"t\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"5 ms\"\ntick_noise = {{ three_sigma = \"1.6 arcsec\" }}\n\
             [motion]\namplitude = \"12000 arcsec/s\"\nfrequency = {frequency}\n[switching]\ngap_ticks = 3\nfillers = [\"const\", \
             {{ kind = \"minimum-variance\", name = \"mv\", fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"]{more} }}]\n"
        );
        Study::parse("a.toml", &text).unwrap()
    }

    #[test]
    fn a_filler_tuned_to_20_hz_is_judged_at_19_and_21() {
        let study = study("\"20 Hz\"", "");
        let asked = study.asked::<GapFill>().unwrap();
        let point = &asked.points[0];
        let judged = |filler: usize| Judged::of(&point.inputs, &asked.fillers[filler], &point.fills[filler]);
        assert_eq!(judged(0), None);
        let Judged { own, shifted } = judged(1).unwrap();
        let (own_rms, shifted_rms) = (own.rms, shifted.rms);
        // 1.13 ″ at 20 Hz and 21.6 ″ at 19 Hz, as in the tests of the weights; 21 Hz is worse or as bad.
        assert!((own_rms - 1.133).abs() < 2e-3, "{own_rms}");
        assert!(shifted_rms > 21.5 && shifted_rms < 30.0, "{shifted_rms}");
        assert!(
            study.notes.iter().any(|note| note.contains("5 % lower or higher: mv 1.13″ and 2")),
            "{:?}",
            study.notes
        );
    }

    #[test]
    fn a_filler_for_a_wider_band_than_the_motion_is_not_designed_for_it() {
        let of = |frequency: &str, more: &str| {
            let study = study(frequency, more);
            study.notes.iter().any(|note| note.contains("designed for the motion on which they are judged"))
        };
        let band = ", band = [\"18 Hz\", \"22 Hz\"]";
        assert!(!of("\"20 Hz\"", band) && of("[\"18 Hz\", \"22 Hz\"]", band));
    }

    /// The specifications of `benches/filler_numpy.py`, which integrates over their spectra by brute force.
    #[test]
    fn fillers_for_a_specification_leave_what_an_integral_over_its_spectrum_has() {
        let problem = "bands = [{ rms = \"1000 arcsec/s\", band = [\"30 Hz\", \"80 Hz\"], tolerance = \"5 %\" }]\n\
                       lines = [{ amplitude = \"90 arcsec\", frequency = \"345 Hz\", tolerance = \"0.1 %\" }]";
        let several = "bands = [{ rms = \"3000 arcsec/s\", band = [\"5 Hz\", \"20 Hz\"], tolerance = \"10 %\" },\n\
                       { rms = \"500 arcsec/s\", band = [\"60 Hz\", \"90 Hz\"], tolerance = \"2 %\" }]\n\
                       lines = [{ amplitude = \"200000 arcsec/s\", frequency = \"345 Hz\", tolerance = \"0.1 %\" },\n\
                       { amplitude = \"5000 arcsec/s\", frequency = \"140 Hz\", tolerance = \"1 %\" }]";
        let exact = "bands = [{ rms = \"1000 arcsec/s\", band = [\"30 Hz\", \"40 Hz\"] }]\n\
                     lines = [{ amplitude = \"4000 arcsec/s\", frequency = \"120 Hz\" }]";
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/gap_specification.csv");
        let mut rows = 0;
        for record in csv::Reader::from_path(path).unwrap().records().map(Result::unwrap) {
            let specification = match &record[0] {
                "problem" => problem,
                "several" => several,
                _ => exact,
            };
            let whole = |field: usize| record[field].parse::<i32>().unwrap();
            let text = format!(
                "title = \"t\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"2 ms\"\ntick_noise = {{ std = \"0.2 arcsec\" }}\n\
                 [motion]\nrate = \"0 deg/s\"\n[specification]\n{specification}\n[switching]\ngap_ticks = {}\nfillers = [\n\
                 {{ kind = \"minimum-variance\", fit_ticks = [\"{}..0\", \"n+1..n+{}\"] }}]\n",
                whole(1),
                1 - whole(2),
                whole(3)
            );
            let study = Study::parse("a.toml", &text).unwrap();
            let asked = study.asked::<GapFill>().unwrap();
            let point = &asked.points[0];
            let judged = Judged::of(&point.inputs, &asked.fillers[0], &point.fills[0]).unwrap();
            let found = [judged.own.rms, judged.own.level, judged.worst().rms, judged.worst().level];
            for (field, found) in (4..).zip(found) {
                let expected: f64 = record[field].parse().unwrap();
                // Weights are rounded to 2^−24, which changes what is left of the dither by up to 4e-6.
                assert!((found / expected - 1.0).abs() < 1e-5, "{record:?}: {found}, not {expected}");
            }
            rows += 1;
        }
        assert_eq!(rows, 6);
    }

    #[test]
    fn a_motion_played_faster_is_that_of_a_higher_frequency() {
        let at = |frequency: &str| study(frequency, "").asked::<GapFill>().unwrap().points[0].inputs.clone();
        let (slow, fast) = (at("\"20 Hz\""), at("\"21 Hz\""));
        let [played, own] = [played(&slow, 1.05, 8), fast.motion.tick_rows(0.005, fast.gap_ticks, 8)];
        for tick in -7..=8 {
            let covariance = |rows: &TickRows| dot(rows.tick(1), rows.tick(tick));
            let (found, expected) = (covariance(&played), covariance(&own));
            assert!(
                (found - expected).abs() < 1e-9 * dot(own.tick(1), own.tick(1)),
                "{tick}: {found}, not {expected}"
            );
        }
    }
}
