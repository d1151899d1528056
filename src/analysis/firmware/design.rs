//! The fillers of one point of a study as integer rules, with their errors in closed form.

use crate::analysis::firmware::shown;
use crate::analysis::firmware::{Rule, Trade};
use sagnac_base::diagnostics::StudyError;
use sagnac_base::quantity::number::significant;
use sagnac_engine::chart::Chart;
use sagnac_engine::filler::read::{Error, GAP_TICKS};
use sagnac_engine::filler::{Fill, Filler, Method, Part, Target, latency_ticks};
use sagnac_engine::key::Key;
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::kinds::gap_fill::GapFill;
use sagnac_engine::kinds::gap_fill::columns::{Judge, Judged, of_noise, shift};
use sagnac_engine::kinds::gap_fill::inputs::{Inputs, Point};
use sagnac_engine::kinds::gap_fill::lower::Lowered;
use sagnac_engine::kinds::gap_fill::lower::fixed::{Rows, Statistics};
use sagnac_engine::motion::keys::Design::{FirstHalf, Whole};
use sagnac_engine::study::Study;
use sagnac_theory::gap::{Weights, sine_response, tick_amplitude};
use sagnac_theory::minimum_variance::{Band, sides};

/// The fillers of one point of a study.
#[derive(Debug, Clone)]
pub struct Firmware {
    /// Title of the study.
    pub title: String,
    /// Value of each swept key.
    pub at: Vec<(&'static Key, SweepValue)>,
    /// The swept keys of which no value was asked for, each with the number of its values, as the weights are the same at all.
    pub unasked: Vec<(&'static Key, usize)>,
    /// Tick T, s; where it is unknown, times are in ticks and frequencies in cycles per tick.
    pub tick_s: Option<f64>,
    /// Number of lost ticks n.
    pub gap_ticks: u32,
    /// Rate amplitude, ″/s, and frequency, Hz, where the motion is a single tone, and there is no specification.
    pub tone: Option<(f64, f64)>,
    /// The motion that charts of the response mark: the single tone, or the parts of a specification.
    pub marks: Vec<Mark>,
    /// Relative change of all frequencies on which fillers are judged; `None` where a specification has tolerances.
    pub shift: Option<f64>,
    /// Fillers, in the order of the study or as requested.
    pub designs: Vec<Design>,
    /// Why there is no rms, where the point cannot be sampled.
    pub unsampled: Option<String>,
    /// Seed of the study, from which that of the test vectors is derived.
    pub seed: u64,
    /// The limit of the study on the 99.73 % residual, ″.
    pub limit_arcsec: Option<f64>,
    /// The search that found the ticks; absent where they are given.
    pub trade: Option<Trade>,
}

/// A line or a band of the motion in the chart of the response.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// What it is, such as `the motion`.
    pub name: &'static str,
    /// Nominal lowest and highest frequency, Hz; equal for a line.
    pub ends_hz: [f64; 2],
}

/// A filler.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Name in the study, after which the C functions are named.
    pub name: String,
    /// Description, such as `polynomial of order 2`.
    pub method: String,
    /// The rule for I_j once the ticks after the gap are known.
    pub interpolation: Rule,
    /// The rule for E_j while the gap is open; absent where the filler has none.
    pub extrapolation: Option<Rule>,
    /// Errors of the residual and of the extrapolation.
    pub errors: [Closed; 2],
    /// Ticks after the gap after which the correction comes.
    pub latency_ticks: u32,
    /// The residual as given and with frequencies off; present for a filler that is designed for the very motion of the
    /// point, and where there is a specification.
    pub judged: Option<Judged>,
    /// The residual as given and with frequencies off, of any filler; absent for recorded motion, and for a motion at rest or of a
    /// fixed phase.
    pub possible: Option<Judged>,
    /// The part of the rms residual that comes from noise and whole pulses, ″.
    pub noise_rms: f64,
    /// The rms residual of the C header where it is given the whole pulses of the readout and returns whole pulses, ″; absent
    /// without pulses, and where the motion has no rms.
    pub exported_rms: Option<f64>,
}

/// The closed form of an error, ″; values are absent where the motion has none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Closed {
    /// Largest error over the phase of a single tone, without noise.
    pub amplitude: Option<f64>,
    /// Rms error with noise.
    pub rms: Option<f64>,
}

/// The estimate that limits are on.
const LIMITED: &str = "p99_73";

/// The column that names the error of a row.
const ERROR: &str = "error";

/// The errors of [`Design::errors`].
const ERRORS: [Error; 2] = [Error::Residual, Error::Extrapolation];

impl Firmware {
    /// The firmware of `fillers` of the study at a point.
    ///
    /// # Errors
    /// The ticks do not determine the weights of a filler, or the weights need more than 32 bits.
    pub fn new(study: &Study, point: &Point, fillers: &[Filler]) -> Result<Firmware, StudyError> {
        let rules = rules(study, point, fillers)?;
        let fills = fillers.iter().filter_map(|filler| fill_of(study, point, filler).cloned()).collect();
        let point = Point { fills, ..point.clone() };
        let inputs = &point.inputs;
        // With a specification the motion that is sampled says nothing of the fillers.
        let is_sampled = inputs.specification.is_none();
        let tone = inputs.motion.single_tone().filter(|_| is_sampled);
        let lowered =
            is_sampled.then(|| Lowered::new(&point, fillers, &ERRORS, study.seed, study.streams)).transpose();
        let mut designs = Vec::new();
        for (place, (filler, (interpolation, extrapolation))) in fillers.iter().zip(rules).enumerate() {
            let amplitude = |rule: &Rule| {
                let (rate, frequency_hz) = tone?;
                Some(rate * response(&rule.whole(), inputs.gap_ticks, inputs.tick_s, frequency_hz))
            };
            let both = [Some(&interpolation), extrapolation.as_ref()];
            let rms = |i: usize| match lowered.as_ref().ok()? {
                Some(lowered) => {
                    let estimates = lowered.fillers.get(place)?;
                    estimates.iter().find(|estimate| estimate.error == ERRORS[i])?.theory.rms
                }
                None => Some(specified_rms(inputs, both[i]?)),
            };
            let amplitudes = both.map(|rule| rule.and_then(amplitude));
            let errors = [0, 1].map(|i| Closed { amplitude: amplitudes[i], rms: rms(i) });
            let (name, method) = (filler.name.clone(), method(filler, inputs));
            let judged = point.fills.get(place).and_then(|fill| Judged::of(inputs, filler, fill));
            let latency_ticks = latency_ticks(&interpolation.ticks, inputs.gap_ticks);
            let weights: Vec<f64> = interpolation.whole().values().collect();
            let noise_rms = of_noise(inputs, &interpolation.ticks, &weights);
            let possible = judged.or_else(|| Judged::of_weights(inputs, &interpolation.ticks, &weights));
            let rounded = inputs.readout_lsb * libm::sqrt(interpolation.rounding());
            let exported_rms = errors[0].rms.filter(|_| rounded > 0.0).map(|rms| libm::hypot(rms, rounded));
            designs.push(Design {
                name,
                method,
                interpolation,
                extrapolation,
                errors,
                latency_ticks,
                judged,
                possible,
                noise_rms,
                exported_rms,
            });
        }
        Ok(Firmware {
            title: study.title.clone(),
            at: study
                .sweeps
                .iter()
                .zip(&point.swept)
                .map(|(sweep, (_, value))| (sweep.key, value.clone()))
                .collect(),
            unasked: vec![],
            tick_s: Some(inputs.tick_s),
            gap_ticks: inputs.gap_ticks,
            tone,
            marks: marks(inputs, tone),
            shift: shift(inputs),
            designs,
            unsampled: lowered.err().map(|refusal| refusal.to_string()),
            seed: study.seed,
            limit_arcsec: limit(study),
            trade: None,
        })
    }

    /// The values of swept keys at the point, such as `vibration frequency 20 Hz, …`, without the gap; empty without other sweeps.
    pub fn place(&self) -> String {
        let each = self.at.iter().filter(|(key, _)| key.name != GAP_TICKS.name);
        let each =
            each.filter_map(|(key, value)| Some(format!("{} {}", key.label, shown(&value.quantity()?))));
        each.collect::<Vec<_>>().join(", ")
    }
}

/// The rms error that a rule leaves on the specification as given, with noise, ″.
fn specified_rms(inputs: &Inputs, rule: &Rule) -> f64 {
    let weights: Vec<f64> = rule.whole().values().collect();
    Judge::new(inputs, sides(&rule.ticks, inputs.gap_ticks)).judge(&rule.ticks, &weights).own.rms
}

/// The frequencies of a single tone or of a specification.
fn marks(inputs: &Inputs, tone: Option<(f64, f64)>) -> Vec<Mark> {
    let of_part = |part: &Part| {
        let Band { low_hz, high_hz } = part.tone.band();
        let name = if part.is_line() { "line" } else { "band" };
        Mark { name, ends_hz: [low_hz, high_hz] }
    };
    let parts = inputs.specification.iter().flat_map(|specification| &specification.parts).map(of_part);
    tone.map(|(_, nu)| Mark { name: "the motion", ends_hz: [nu; 2] }).into_iter().chain(parts).collect()
}

/// The limit of a study of gaps on the 99.73 % residual, ″: its requirement, else that of its first chart of residuals with one.
pub(crate) fn limit(study: &Study) -> Option<f64> {
    let of_charts = || {
        let is_of_residuals = |chart: &Chart| {
            chart.filter().iter().all(|(name, value)| name != ERROR || value == Error::Residual.name())
        };
        let judged = |chart: &&Chart| {
            chart.estimate().name.trim_end_matches("_arcsec") == LIMITED && is_of_residuals(chart)
        };
        study.charts.iter().filter(judged).find_map(|chart| chart.limit)
    };
    study.requirement.map(|required| required.limit).or_else(of_charts).map(|limit| limit.value)
}

impl Design {
    /// The two rules with the errors that they leave, as far as the filler has them.
    pub fn rules(&self) -> impl Iterator<Item = (Error, &Rule, Closed)> {
        let [residual, extrapolation] = self.errors;
        let second = self.extrapolation.as_ref().map(|rule| (Error::Extrapolation, rule, extrapolation));
        core::iter::once((Error::Residual, &self.interpolation, residual)).chain(second)
    }
}

/// The rules of fillers of a study at a point: that of the residual, and that of the extrapolation where there is one.
///
/// # Errors
/// It fails where [`Firmware::new`] does.
pub fn rules(
    study: &Study,
    point: &Point,
    fillers: &[Filler],
) -> Result<Vec<(Rule, Option<Rule>)>, StudyError> {
    let statistics = Statistics::new(&point.inputs);
    let mut rules = Vec::new();
    for filler in fillers {
        let Some(fill) = fill_of(study, point, filler) else { continue };
        let rule = |error, ticks: &[i32]| {
            let rows = match Rows::by_tick(filler, error, ticks, &statistics) {
                Ok(None) => Rows::new(filler, error, ticks, &statistics),
                by_tick => by_tick,
            };
            let rows = rows.map_err(|refusal| study.refused(&point.swept, &refusal))?;
            rows.map(|rows| Rule::new(&rows).ok_or_else(|| too_large(study, filler))).transpose()
        };
        let ticks = fill.extrapolation_ticks.as_deref();
        let extrapolation = ticks.map(|ticks| rule(Error::Extrapolation, ticks)).transpose()?.flatten();
        // Every filler has weights for its residual.
        rules.extend(
            rule(Error::Residual, &fill.fit_ticks)?.map(|interpolation| (interpolation, extrapolation)),
        );
    }
    Ok(rules)
}

/// Amplitude of the error of some weights for a vibration per amplitude of its rate, in ″ per ″/s, which is s.
///
/// T sinc νT |Σ w e^{iωt} − Σ_gap e^{iωt}|, the largest value over the phase.
pub(crate) fn response(weights: &Weights, gap_ticks: u32, tick_s: f64, frequency_hz: f64) -> f64 {
    let nu_t = frequency_hz * tick_s;
    let (a, b) = sine_response(weights, gap_ticks, nu_t);
    tick_amplitude(tick_s, nu_t).abs() * libm::hypot(a, b)
}

/// The description of a filler in ASCII, with the statistics for which it is designed.
fn method(filler: &Filler, inputs: &Inputs) -> String {
    let target = match &filler.method {
        Method::Closed(closed) => return closed.about.to_owned(),
        Method::Weights { .. } => return "weights as given".to_owned(),
        Method::MinimumVariance(target) => target,
    };
    let hz = |nu| significant(nu, 6);
    let recorded = inputs.motion.profile.as_ref().map(|profile| profile.design);
    let spread = match (target, recorded, inputs.motion.single_tone()) {
        (Target::Specification(_), ..) => ", as specified with its tolerances,".to_owned(),
        (Target::Band(band), ..) => format!(" from {} Hz to {} Hz", hz(band.low_hz), hz(band.high_hz)),
        (Target::Own, Some(FirstHalf), _) => ", as in the first half of the recorded profile,".to_owned(),
        (Target::Own, Some(Whole), _) => ", as in the whole recorded profile,".to_owned(),
        (Target::Own, None, Some((_, nu))) => format!(" at {} Hz", hz(nu)),
        (Target::Own, None, None) => String::new(),
    };
    let rate = match target {
        Target::Specification(specification) => specification.motion().rate_rms(inputs.tick_s),
        Target::Own | Target::Band(_) => inputs.motion.rate_rms(inputs.tick_s),
    };
    let rate = significant(rate, 6);
    let noise = significant(inputs.sigma_arcsec(), 6);
    let pulses = match inputs.readout_lsb {
        0.0 => String::new(),
        lsb => format!(", read in pulses of {} arcsec", significant(lsb, 6)),
    };
    format!("minimum variance for {rate} ″/s rms{spread} and {noise}″ rms of noise per tick{pulses}")
}

fn too_large(study: &Study, filler: &Filler) -> StudyError {
    let message = format!("switching.fillers: the weights of `{}` need more than 32 bits", filler.name);
    let help = "move its ticks nearer to the gap, or shorten the gap";
    study.error_at(study.place_of("switching.fillers"), message, help)
}

/// The ticks of a filler of a study at a point.
fn fill_of<'p>(study: &Study, point: &'p Point, filler: &Filler) -> Option<&'p Fill> {
    let place = study.asked::<GapFill>()?.fillers.iter().position(|own| own.name == filler.name)?;
    Some(&point.fills[place])
}
