//! The inputs that determine a point's draws and truth, in canonical form: a motion given as a rate or as an angle is
//! the same motion. Every number has 12 significant digits.

use std::fmt::Write as _;
use std::sync::{Arc, Weak};

use crate::filler::read::Error;
use crate::key::Unrepresentable;
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::lower::fixed::FixedProfile;
use crate::kinds::gap_fill::lower::readout::{self, Functional, Response};
use crate::kinds::gap_fill::lower::{Estimate, Lowered, functionals};
use crate::motion::keys::{Design, Phase, Position};
use crate::motion::{Acceleration, Frequency, Gaussian, Replay, Value};
use crate::tally::{Id, LEVEL};
use sagnac_base::quantity::round_12;
use sagnac_kernel::gap_fill::shape::MARGIN;
use sagnac_kernel::normal::REACH;
use sagnac_kernel::relock_ticks::MAX_TICKS;
use sagnac_theory::gap::tick_amplitude;
use sagnac_theory::minimum_variance::TickRows;
use sagnac_theory::quadrature::Memo;

/// Most ticks of a profile. A place is chosen by 32 random bits, which then favour no place by more than 1/1000.
pub(crate) const MAX_PROFILE_TICKS: usize = 1 << 22;

/// The canonical inputs, with angles in ″ per tick.
#[derive(Debug, Clone)]
pub(crate) struct Physical {
    pub(crate) gap_ticks: u32,
    pub(crate) sigma_arcsec: f64,
    /// Angle of a pulse, ″; 0 where the readout is not quantized.
    pub(crate) readout_lsb: f64,
    pub(crate) relock: Vec<f64>,
    pub(crate) tones: Vec<PhysicalTone>,
    pub(crate) gaussian: Option<PhysicalGaussian>,
    pub(crate) profile: Option<PhysicalProfile>,
    /// Constant rate and acceleration, ΩT and αT².
    pub(crate) rate_arcsec: f64,
    pub(crate) acceleration_arcsec: f64,
}

/// One tone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PhysicalTone {
    /// The key that gives it, for refusals.
    pub(crate) key: &'static str,
    pub(crate) kind: ToneKind,
    /// Distribution of the amplitude, relative to its scale.
    pub(crate) value: Value,
    pub(crate) phase: Phase,
}

/// The frequency and angle of a tone per tick.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ToneKind {
    /// A fixed frequency νT, with the angle of a tick with the peak of the rate in its middle, which is negative where
    /// sinc(νT) is.
    Fixed { tick_arcsec: f64, nu_t: f64 },
    /// A drawn frequency νT between two ends; `arcsec` is A_Ω T for amplitudes of the rate, and 2A for those of the
    /// angle.
    Drawn { arcsec: f64, of_angle: bool, nu_t: [f64; 2] },
}

/// Stationary Gaussian motion.
#[derive(Debug, Clone)]
pub(crate) struct PhysicalGaussian {
    /// The key that gives it, for refusals.
    pub(crate) key: &'static str,
    /// Its ticks, ″.
    pub(crate) rows: TickRows,
}

/// A recorded profile.
#[derive(Debug, Clone)]
pub(crate) struct PhysicalProfile {
    pub(crate) replay: Arc<Replay>,
    pub(crate) every: bool,
    /// Number of places that the gap can have.
    pub(crate) positions: usize,
}

impl Physical {
    /// The canonical inputs, with the Gaussian motion of that number of ticks on either side of the gap.
    pub(crate) fn new(inputs: &Inputs, sides: usize) -> Result<Physical, Unrepresentable> {
        let tick_s = round_12(inputs.tick_s);
        let motion = &inputs.motion;
        // Where one frequency is drawn, the kernel draws all of them, a fixed one from a band of zero width.
        let drawn = motion.tones.iter().any(|tone| matches!(tone.frequency, Frequency::Band(_)));
        // The tone of a sine through the suspension is the last one.
        let sine = motion.vibration.iter().filter(|v| matches!(v.acceleration, Acceleration::Sine { .. }));
        let written = motion.tones.len() - sine.count();
        let key = |index: usize| match (index < written, written) {
            (false, _) => "motion.suspension",
            (true, 1) => "motion.amplitude",
            (true, _) => "motion.tones",
        };
        let tones = motion
            .tones
            .iter()
            .enumerate()
            .map(|(index, tone)| {
                let scale = tone.amplitude.value.scale();
                let value = match tone.amplitude.value {
                    Value::Fixed(_) => Value::Fixed(1.0),
                    Value::Uniform([low, high]) => {
                        Value::Uniform([if high > 0.0 { round_12(low / high) } else { 1.0 }, 1.0])
                    }
                    Value::Rayleigh(_) => Value::Rayleigh(1.0),
                };
                let kind = match tone.frequency {
                    Frequency::Fixed(nu) if !drawn => {
                        let nu_t = round_12(tick_s * round_12(nu));
                        let rate = round_12(scale * tone.rate_factor(nu));
                        ToneKind::Fixed { tick_arcsec: round_12(rate * tick_amplitude(tick_s, nu_t)), nu_t }
                    }
                    Frequency::Fixed(_) | Frequency::Band(_) => {
                        let band = tone.band();
                        let of_angle = tone.amplitude.of_angle;
                        ToneKind::Drawn {
                            arcsec: round_12(if of_angle { 2.0 * scale } else { scale * tick_s }),
                            of_angle,
                            nu_t: [band.low_hz, band.high_hz].map(|nu| round_12(tick_s * nu)),
                        }
                    }
                };
                PhysicalTone { key: key(index), kind, value, phase: tone.phase }
            })
            .collect();
        let gaussian = motion.gaussian.as_ref().map(|gaussian| PhysicalGaussian {
            key: match gaussian {
                Gaussian::Band { .. } | Gaussian::Psd(_) => "motion.gaussian",
                Gaussian::Vibration { .. } => "motion.suspension",
            },
            rows: gaussian.tick_rows(tick_s, inputs.gap_ticks, sides),
        });
        let profile = motion.profile.as_ref().map(|profile| {
            let file = profile.file.clone();
            let (count, before) = profile.replayed(tick_s);
            if count + before > MAX_PROFILE_TICKS {
                let count = count + before;
                let found = format!("the record `{file}` has {count} ticks, more than {MAX_PROFILE_TICKS}");
                return Err(Unrepresentable::new("motion.profile", found, "cut the record, or take a longer tick"));
            }
            let needed = 2 * MARGIN + inputs.gap_ticks as usize;
            let Some(rest) = count.checked_sub(needed) else {
                let gap_ticks = inputs.gap_ticks;
                let (of, help) = match profile.design {
                    Design::FirstHalf => (
                        "the second half of the record",
                        "record for longer, or take a shorter tick or gap, or design = \"whole\"",
                    ),
                    Design::Whole => ("the record", "record for longer, or take a shorter tick or gap"),
                };
                let found = format!(
                    "{of} `{file}` has {count} whole ticks, too few for a gap of {gap_ticks} with {MARGIN} ticks on either side"
                );
                return Err(Unrepresentable::new("motion.profile", found, help));
            };
            let replay = profile.replay(tick_s);
            Ok(PhysicalProfile { replay, every: profile.position == Position::Every, positions: rest + 1 })
        });
        Ok(Physical {
            gap_ticks: inputs.gap_ticks,
            sigma_arcsec: round_12(inputs.sigma_arcsec()),
            readout_lsb: inputs.readout_lsb,
            relock: inputs.relock.clone(),
            tones,
            gaussian,
            profile: profile.transpose()?,
            rate_arcsec: round_12(motion.rate * tick_s),
            acceleration_arcsec: round_12(motion.acceleration * tick_s * tick_s),
        })
    }

    /// Largest angle of a tick for each part of the motion, ″, with the key that gives it.
    pub(crate) fn tick_sizes(&self) -> Vec<(&'static str, f64)> {
        let mut sizes = Vec::new();
        for tone in &self.tones {
            let arcsec = match tone.kind {
                ToneKind::Fixed { tick_arcsec, .. } => tick_arcsec.abs(),
                ToneKind::Drawn { arcsec, .. } => arcsec,
            };
            // The amplitude is made of two normal numbers.
            let reach = if let Value::Rayleigh(_) = tone.value { 2.0 * REACH } else { 1.0 };
            sizes.push((tone.key, arcsec * reach));
        }
        if let Some(gaussian) = &self.gaussian {
            // The first row has one number, the standard deviation of a tick.
            sizes.push((gaussian.key, REACH * gaussian.rows.tick(1)[0]));
        }
        if let Some(profile) = &self.profile {
            sizes.push((
                "motion.profile",
                profile.replay.angles.iter().fold(0.0, |most, x| most.max(x.abs())),
            ));
        }
        sizes
    }

    /// Largest angle of a tick that is common to all trials, ″.
    pub(crate) fn constant_size(&self) -> f64 {
        let farthest = (2 * MARGIN) as f64 + f64::from(self.gap_ticks);
        let relock = self.relock.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        self.rate_arcsec.abs() + self.acceleration_arcsec.abs() * farthest + relock
    }

    /// Everything that determines draws and truth, as lines of text.
    pub(crate) fn canonical(&self, inputs: &Inputs) -> String {
        // Every field, so that a new one cannot be left out by mistake; Gaussian motion is that of the inputs.
        let Physical {
            gap_ticks,
            sigma_arcsec,
            readout_lsb,
            relock,
            tones,
            gaussian: _,
            profile,
            rate_arcsec,
            acceleration_arcsec,
        } = self;
        let mut text = format!(
            "gap_ticks={gap_ticks}\nsigma_arcsec={sigma_arcsec:.11e}\nreadout_lsb={readout_lsb:.11e}\nrelock={relock:?}\n\
             rate_arcsec={rate_arcsec:.11e}\nacceleration_arcsec={acceleration_arcsec:.11e}\n"
        );
        let mut line = |line: std::fmt::Arguments| {
            // Writing to a text cannot fail.
            let _ = writeln!(text, "{line}");
        };
        for tone in tones {
            line(format_args!("tone={:?} {:?} {}", tone.kind, tone.value, tone.phase.name()));
        }
        match &inputs.motion.gaussian {
            Some(Gaussian::Band { rms, band }) => line(format_args!(
                "gaussian={:.11e} {:.11e} {:.11e}",
                round_12(rms * inputs.tick_s),
                round_12(band.low_hz * inputs.tick_s),
                round_12(band.high_hz * inputs.tick_s)
            )),
            Some(Gaussian::Psd(psd)) => {
                line(format_args!("psd={:?} tick_s={:.11e}", psd.points(), inputs.tick_s))
            }
            Some(Gaussian::Vibration { suspension, acceleration, scale }) => line(format_args!(
                "suspension={:?} acceleration={:?} scale={scale:.11e} tick_s={:.11e}",
                suspension.modes(),
                acceleration.points(),
                inputs.tick_s
            )),
            None => {}
        }
        if let Some(profile) = profile {
            line(format_args!("profile={} every={}", profile.replay.content, profile.every));
        }
        text
    }
}

/// The angles of a replay in units, and the responses to them.
#[derive(Debug)]
pub(crate) struct Rounded {
    /// Angle since the start at the boundaries of ticks, LSB, wrapped.
    pub(crate) angles: Arc<[u32]>,
    /// Identifies the angles.
    pub(crate) content: Id,
    responses: Memo<Asked, Response>,
}

/// What a response depends on besides the angles.
#[derive(Debug, PartialEq)]
struct Asked {
    ticks: Vec<i32>,
    weights: Vec<i64>,
    scale: i64,
    gap: i32,
    positions: usize,
    constant: u64,
}

/// Most responses that are kept of one replay: those of a dozen fillers at as many gaps.
const MAX_RESPONSES: usize = 256;

/// Number of positions that are summed together, tick by tick, so that the compiler can use vector instructions.
const AT_ONCE: usize = 256;

/// The angles of a replay, which is recognized by its place in memory, in units of so many ″. They have up to 16 MB each.
static ROUNDED: Memo<Unit, Arc<Rounded>> = Memo::new(8);

/// A replay with a unit of angle.
struct Unit {
    replay: Weak<Replay>,
    lsb: u64,
}

impl PartialEq for Unit {
    fn eq(&self, other: &Unit) -> bool {
        self.replay.ptr_eq(&other.replay) && self.lsb == other.lsb
    }
}

impl PartialEq for Rounded {
    fn eq(&self, other: &Rounded) -> bool {
        self.content == other.content
    }
}

impl Rounded {
    /// The angles of a replay in units of `lsb_arcsec`.
    pub(crate) fn new(replay: &Arc<Replay>, lsb_arcsec: f64) -> Arc<Rounded> {
        let unit = Unit { replay: Arc::downgrade(replay), lsb: lsb_arcsec.to_bits() };
        ROUNDED.get(unit, || {
            let mut sum = 0.0;
            let ends = replay.angles.iter().map(|angle| {
                sum += angle;
                // Only differences are used, so the angle may wrap.
                libm::round(sum / lsb_arcsec) as i64 as u32
            });
            let angles: Arc<[u32]> = core::iter::once(0).chain(ends).collect();
            let content = Id::of_words(angles.iter().copied());
            Arc::new(Rounded { angles, content, responses: Memo::new(MAX_RESPONSES) })
        })
    }
}

impl FixedProfile {
    /// The angle from the start of the gap at one of the positions to the end of a tick, LSB, wrapped.
    pub(crate) fn angle(&self, position: usize, tick: i32) -> i32 {
        let start = position + MARGIN;
        let end = start.wrapping_add_signed(tick as isize);
        self.rounded.angles[end].wrapping_sub(self.rounded.angles[start]) as i32
    }

    /// The response, with a `constant` error beside the motion.
    pub(crate) fn response(&self, f: &Functional, constant: f64) -> Response {
        let asked = Asked {
            ticks: f.ticks.to_vec(),
            weights: f.weights.to_vec(),
            scale: f.scale,
            gap: f.gap,
            positions: self.positions,
            constant: constant.to_bits(),
        };
        self.rounded.responses.get(asked, || self.compute_response(f, constant))
    }

    fn compute_response(&self, f: &Functional, constant: f64) -> Response {
        let (mut sum, mut square, mut terms) = (0.0, 0.0, 0.0_f64);
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut sizes = Vec::with_capacity(self.positions);
        let mut filled = [[0.0_f64; 2]; AT_ONCE];
        for start in (0..self.positions).step_by(AT_ONCE) {
            let filled = &mut filled[..AT_ONCE.min(self.positions - start)];
            filled.fill([0.0; 2]);
            for (&tick, &w) in f.ticks.iter().zip(f.weights) {
                let ends = &self.rounded.angles[(start + MARGIN).wrapping_add_signed(tick as isize - 1)..];
                for (filled, ends) in filled.iter_mut().zip(ends.windows(2)) {
                    let x = w as f64 * f64::from(ends[1].wrapping_sub(ends[0]) as i32);
                    *filled = [filled[0] + x, filled[1] + x.abs()];
                }
            }
            for (place, [filled, size]) in filled.iter().enumerate() {
                let gap = f.scale as f64 * f64::from(self.angle(start + place, f.gap));
                let e = filled - gap;
                sum += e;
                square += e * e;
                (least, greatest) = (least.min(e), greatest.max(e));
                sizes.push((e + constant).abs());
                terms = terms.max(size + gap.abs());
            }
        }
        let count = self.positions as f64;
        let mean = sum / count;
        let rank = ((LEVEL * count) as usize).min(self.positions - 1);
        let level = *sizes.select_nth_unstable_by(rank, f64::total_cmp).1;
        Response {
            mean,
            variance: (square / count - mean * mean).max(0.0),
            bound: least.abs().max(greatest.abs()),
            largest: Some((least + constant).abs().max((greatest + constant).abs())),
            level: Some(level),
            terms,
            ..Response::default()
        }
    }
}

/// The residual of a switch, ″.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Residual {
    /// Sines of the phases of the tones.
    pub tones: Vec<ResidualTone>,
    /// Constant part, the same at every switch.
    pub constant_arcsec: f64,
    /// Variance of the part that is normally distributed or taken as such: noise, Gaussian motion, fractions of a
    /// pulse, drawn amplitudes and frequencies, profiles.
    pub variance_arcsec2: f64,
    /// Weights of the filler on the ticks n+1, n+2, … as far as a relock can reach.
    pub after: Vec<f64>,
}

impl Residual {
    /// Root mean square over switches, ″.
    pub fn rms(&self) -> f64 {
        let squares = self.tones.iter().map(|tone| 0.5 * tone.amplitude_arcsec * tone.amplitude_arcsec);
        let swinging: f64 = squares.sum();
        libm::sqrt(self.constant_arcsec * self.constant_arcsec + self.variance_arcsec2 + swinging)
    }
}

/// The part of the residual from a tone of random phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualTone {
    /// Amplitude of the residual angle, ″.
    pub amplitude_arcsec: f64,
    /// Index of the tone in the motion.
    pub tone: usize,
}

impl Lowered {
    /// The residual of a filler, from the words with which its trials are sampled; `None` where it has none.
    pub fn residual(&self, filler: usize) -> Option<Residual> {
        let estimate: &Estimate =
            self.fillers[filler].iter().find(|estimate| estimate.error == Error::Residual)?;
        let fixed = &self.fixed;
        let all = functionals(&estimate.rows, Error::Residual, fixed.gap_ticks);
        let f = all.last()?;
        let whole = fixed.response(f);
        let (mut mean, mut variance) = (whole.mean, whole.variance);
        let mut tones = Vec::new();
        for (place, tone) in fixed.tones.iter().enumerate() {
            if tone.is_sine() {
                let part = tone.response(f, fixed.gap_ticks);
                // A sine of uniform phase has half its squared amplitude as variance.
                mean -= part.mean;
                variance -= part.variance;
                tones.push((place, libm::sqrt(2.0 * part.variance)));
            }
        }
        let sigma = fixed.sigma_lsb() * f.noise_gain();
        let fractions = readout::variance(fixed, f);
        let unit = fixed.lsb_arcsec / estimate.rows.denominator as f64;
        // Differences of equal numbers may come out below 0.
        let normal = (variance.max(0.0) + sigma * sigma + fractions).max(0.0);
        let weight = |tick: i32| {
            let place = f.ticks.iter().position(|&own| own == tick);
            place.map_or(0.0, |place| f.weights[place] as f64 / f.scale as f64)
        };
        let after = (1..=MAX_TICKS as i32).map(|k| weight(fixed.gap_ticks + k));
        let tones =
            tones.into_iter().map(|(tone, size)| ResidualTone { tone, amplitude_arcsec: size * unit });
        Some(Residual {
            tones: tones.filter(|tone| tone.amplitude_arcsec > 0.0).collect(),
            constant_arcsec: mean * unit,
            variance_arcsec2: normal * unit * unit,
            after: after.collect(),
        })
    }
}
