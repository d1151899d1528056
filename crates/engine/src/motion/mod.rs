//! The motion of the base at one point, in ″ and s: tones, vibration through the suspension, and recorded motion.

mod filter;
pub mod keys;
pub mod record;

use std::f64::consts::TAU;
use std::sync::{Arc, Weak};

use crate::key::ParseContext;
use crate::key::document::SpanMap;
use crate::motion::keys::{
    ACCELERATION_DENSITIES, ALIAS, Design, GAUSSIAN, GYRO, Interpolation, MODE_FREQUENCY, MODE_Q,
    MODE_RESPONSE, MODES, Phase, Position, RANDOM, RANDOM_PSD, RANDOM_RMS, SINE, SINE_ACCELERATION,
    SINE_FREQUENCY, SUSPENSION, SuspensionKeys, read_psd,
};
use crate::tally::Id;
use sagnac_base::diagnostics::Fault;
use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::round_12;
use sagnac_kernel::gap_fill::shape::MARGIN;
use sagnac_records::record::Record;
use sagnac_theory::cholesky::semidefinite;
use sagnac_theory::lines::{self, Double, Line};
use sagnac_theory::minimum_variance::{Band, Rows, TickRows, ticks};
use sagnac_theory::quadrature::{Memo, Rule};
use sagnac_theory::vibration::{Psd, Suspension};

/// The motion of the base, the sum of all its parts. The rate is that at the middle of the gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Tones, at most 8.
    pub tones: Vec<Tone>,
    /// Gaussian motion in addition to the tones.
    pub gaussian: Option<Gaussian>,
    /// A recorded profile, which excludes tones and Gaussian motion.
    pub profile: Option<Profile>,
    /// Vibration of the base. At a point, its tone or Gaussian motion is among the others.
    pub vibration: Option<Vibration>,
    /// Constant rate, ″/s.
    pub rate: f64,
    /// Angular acceleration, ″/s².
    pub acceleration: f64,
}

/// One sinusoidal rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Peak of the sine.
    pub amplitude: Amplitude,
    /// Frequency, fixed or drawn.
    pub frequency: Frequency,
    /// Phase at the middle of the gap.
    pub phase: Phase,
}

/// Amplitude of a tone: of its rate, ″/s, or of its angle, ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitude {
    /// Whether it is that of the angle, ″, instead of the rate, ″/s.
    pub of_angle: bool,
    /// Value, fixed or drawn.
    pub value: Value,
}

/// A value that is fixed or drawn for each trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// One value for all trials.
    Fixed(f64),
    /// Uniformly distributed between two ends.
    Uniform([f64; 2]),
    /// Rayleigh-distributed with this scale; with a uniform phase the rate is then normal with this standard deviation.
    Rayleigh(f64),
}

/// Frequency of a tone, Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Frequency {
    /// One value for all trials.
    Fixed(f64),
    /// Drawn uniformly from a band for each trial.
    Band(Band),
}

/// Stationary Gaussian motion.
#[derive(Debug, Clone, PartialEq)]
pub enum Gaussian {
    /// Motion of a given standard deviation, spread evenly over a band.
    Band {
        /// Standard deviation of the rate, ″/s.
        rms: f64,
        /// Band, Hz.
        band: Band,
    },
    /// Motion with this one-sided power spectral density of the rate.
    Psd(Arc<Psd>),
    /// Motion through a suspension of a base whose acceleration has `scale` times this density.
    Vibration {
        /// The suspension that turns acceleration into rotation.
        suspension: Arc<Suspension>,
        /// One-sided density of the acceleration, g²/Hz.
        acceleration: Arc<Psd>,
        /// Factor by which that density is multiplied.
        scale: f64,
    },
}

/// Caches of Gaussian motion of unit size: its rows by tick, gap and ticks on either side, for sampling, and its
/// structure by tick and number of lags, for theoretical values. The two come from quadratures of their own, so that the theory
/// checks the rows.
static ROWS: Memo<(Gaussian, f64, u32, usize), Arc<TickRows>> = Memo::new(64);
static STRUCTURES: Memo<(Gaussian, f64, usize), Arc<[Double]>> = Memo::new(128);

/// The largest distance of two ticks round a gap that fillers can read, s.
fn longest_s(tick_s: f64, gap_ticks: u32) -> f64 {
    (2 * MARGIN + gap_ticks as usize) as f64 * tick_s
}

/// A recorded motion to be replayed.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// File name in the study.
    pub file: String,
    /// Its samples.
    pub record: Arc<Record>,
    /// Place of the gap.
    pub position: Position,
    /// Its rate between samples.
    pub interpolation: Interpolation,
    /// Its part from which fillers are designed: the whole record where none is.
    pub design: Design,
}

impl Profile {
    /// The angle of each whole tick, ″.
    pub fn tick_angles(&self, tick_s: f64) -> Vec<f64> {
        match self.interpolation {
            Interpolation::BandLimited => self.record.band_limited_tick_angles(tick_s),
            Interpolation::Linear => self.record.tick_angles(tick_s),
        }
    }

    /// The angles of the ticks from which fillers are designed, ″.
    pub fn design_ticks(&self, tick_s: f64) -> Vec<f64> {
        let mut ticks = self.tick_angles(tick_s);
        // As many as are replayed, so that there is a place for the gap: of an odd number both halves have the middle one.
        let (replayed, _) = self.replayed(tick_s);
        ticks.truncate(replayed);
        ticks
    }

    /// The number of ticks that are replayed, and the number of those before them.
    pub fn replayed(&self, tick_s: f64) -> (usize, usize) {
        let count = self.record.whole_ticks(tick_s);
        let before = match self.design {
            Design::FirstHalf => count / 2,
            Design::Whole => 0,
        };
        (count - before, before)
    }
}

impl Tone {
    /// Whether the residual that a filler leaves of the tone is a sine of its phase, or normal.
    pub(crate) fn is_plain(&self) -> bool {
        let drawn = matches!(self.amplitude.value, Value::Uniform(_));
        matches!(self.frequency, Frequency::Fixed(_)) && !drawn
    }
}

impl Motion {
    /// One tone and nothing else.
    pub fn of_tone(tone: Tone) -> Motion {
        Motion { tones: vec![tone], ..Motion::default() }
    }

    /// Rate amplitude, ″/s, and frequency, Hz, where the motion has exactly one tone, of fixed amplitude and frequency,
    /// and no other random part.
    pub fn single_tone(&self) -> Option<(f64, f64)> {
        let [tone] = self.tones[..] else { return None };
        let (Value::Fixed(amplitude), Frequency::Fixed(frequency_hz)) =
            (tone.amplitude.value, tone.frequency)
        else {
            return None;
        };
        let alone = self.gaussian.is_none() && self.profile.is_none();
        alone.then(|| (amplitude * tone.rate_factor(frequency_hz), frequency_hz))
    }

    /// Standard deviation of the rate, ″/s; for a tone drawn from a band at its middle, for a profile over its ticks.
    pub fn rate_rms(&self, tick_s: f64) -> f64 {
        let mut square = 0.0;
        for tone in &self.tones {
            let band = tone.band();
            let factor = tone.rate_factor(0.5 * (band.low_hz + band.high_hz));
            square += 0.5 * tone.amplitude.value.mean_square() * factor * factor;
        }
        square += self.gaussian.as_ref().map_or(0.0, Gaussian::variance);
        if let Some(profile) = &self.profile {
            square += profile.variance(tick_s) / (tick_s * tick_s);
        }
        libm::sqrt(square)
    }

    /// The ticks of its random part as rows, ″, with `sides` ticks on either side of a gap: all of it but a constant rate
    /// and acceleration, with phases that count as uniformly drawn. Those of a profile are of the part from which
    /// fillers are designed.
    pub fn tick_rows(&self, tick_s: f64, gap_ticks: u32, sides: usize) -> TickRows {
        let mut rows = TickRows::default();
        for tone in &self.tones {
            let lines = lines::of_ticks(&tone.lines(longest_s(tick_s, gap_ticks), Rule::Sparse), tick_s);
            let own = TickRows::of_lines(&lines, gap_ticks, sides);
            rows = rows.beside(if lines.len() > 1 { own.triangular() } else { own });
        }
        if let Some(gaussian) = &self.gaussian {
            rows = rows.beside(gaussian.tick_rows(tick_s, gap_ticks, sides));
        }
        if let Some(profile) = &self.profile {
            rows = rows.beside(profile.tick_rows(tick_s, gap_ticks, sides));
        }
        rows
    }
}

impl Gaussian {
    /// Variance of the rate, (″/s)².
    pub fn variance(&self) -> f64 {
        match self {
            Gaussian::Band { rms, .. } => rms * rms,
            Gaussian::Psd(psd) => psd.variance(),
            Gaussian::Vibration { suspension, acceleration, scale } => {
                scale * suspension.variance(acceleration)
            }
        }
    }

    /// Its highest frequency, Hz; `None` for that of a vibration, which has limits of its own.
    pub(crate) fn highest_hz(&self) -> Option<f64> {
        match self {
            Gaussian::Band { band, .. } => Some(band.high_hz),
            Gaussian::Psd(psd) => psd.points().last().map(|point| point[0]),
            Gaussian::Vibration { .. } => None,
        }
    }

    /// The key that gives it.
    pub(crate) fn key(&self) -> &'static str {
        match self {
            Gaussian::Band { .. } | Gaussian::Psd(_) => GAUSSIAN.name,
            Gaussian::Vibration { .. } => SUSPENSION.name,
        }
    }

    /// Its lowest and its highest frequency, Hz.
    pub(crate) fn frequencies_hz(&self) -> [f64; 2] {
        match self {
            Gaussian::Band { band, .. } => [band.low_hz, band.high_hz],
            Gaussian::Psd(psd) | Gaussian::Vibration { acceleration: psd, .. } => {
                let points = psd.points();
                [points[0][0], points[points.len() - 1][0]]
            }
        }
    }

    /// Its ticks as rows, ″, with `sides` ticks on either side of a gap.
    pub fn tick_rows(&self, tick_s: f64, gap_ticks: u32, sides: usize) -> TickRows {
        let (unit, size) = self.unit();
        // The unit is made again only where it is not known yet: a copy for each point would cost more.
        let rows = ROWS.get((unit, tick_s, gap_ticks, sides), || {
            let lines =
                lines::of_ticks(&self.unit().0.lines(longest_s(tick_s, gap_ticks), Rule::Sparse), tick_s);
            TickRows::of_lines(&lines, gap_ticks, sides).triangular().into()
        });
        rows.as_ref().clone().scaled(size)
    }

    /// The [structure](lines::structure) of the angles at the ends of ticks, ″², at distances of 0 … `lags` − 1 ticks, and
    /// the factor that remains to be applied to it.
    pub(crate) fn structure(&self, tick_s: f64, lags: usize) -> (Arc<[Double]>, f64) {
        let (unit, size) = self.unit();
        let structure = STRUCTURES.get((unit, tick_s, lags), || {
            let lines = self.unit().0.lines(lags as f64 * tick_s, Rule::Panels);
            lines::structure(&lines::of_angles(&lines, tick_s), lags).into()
        });
        (structure, size * size)
    }

    /// This motion without its size, and the factor of its angles: what a sweep of its size leaves as it is.
    fn unit(&self) -> (Gaussian, f64) {
        match self {
            Gaussian::Band { rms, band } => (Gaussian::Band { rms: 1.0, band: *band }, *rms),
            Gaussian::Psd(_) => (self.clone(), 1.0),
            Gaussian::Vibration { suspension, acceleration, scale } => {
                let (suspension, acceleration) = (suspension.clone(), acceleration.clone());
                (Gaussian::Vibration { suspension, acceleration, scale: 1.0 }, libm::sqrt(*scale))
            }
        }
    }

    /// The lines of a motion of unit size.
    fn lines(&self, longest_s: f64, rule: Rule) -> Vec<Line> {
        match self {
            Gaussian::Band { band, .. } => band.lines(longest_s, rule),
            Gaussian::Psd(psd) => psd.lines(longest_s, rule),
            Gaussian::Vibration { suspension, acceleration, .. } => {
                suspension.lines(acceleration, longest_s, rule)
            }
        }
    }
}

impl Tone {
    /// A tone with a fixed rate amplitude, ″/s, a fixed frequency, Hz, and a random phase.
    pub fn of_rate(amplitude: f64, frequency_hz: f64) -> Tone {
        let amplitude = Amplitude { of_angle: false, value: Value::Fixed(amplitude) };
        Tone { amplitude, frequency: Frequency::Fixed(frequency_hz), phase: Phase::Uniform }
    }

    /// A tone with a fixed amplitude of the angle, ″, a fixed frequency, Hz, and a random phase.
    pub fn of_angle(amplitude: f64, frequency_hz: f64) -> Tone {
        let amplitude = Amplitude { of_angle: true, value: Value::Fixed(amplitude) };
        Tone { amplitude, frequency: Frequency::Fixed(frequency_hz), phase: Phase::Uniform }
    }

    /// The factor that converts the amplitude to that of the rate.
    pub fn rate_factor(&self, frequency_hz: f64) -> f64 {
        if self.amplitude.of_angle { TAU * frequency_hz } else { 1.0 }
    }

    /// The range of its frequencies.
    pub fn band(&self) -> Band {
        match self.frequency {
            Frequency::Fixed(nu) => Band { low_hz: nu, high_hz: nu },
            Frequency::Band(band) => band,
        }
    }

    /// Its lines, with which covariances are right to rounding up to a distance of `longest_s`.
    pub(crate) fn lines(&self, longest_s: f64, rule: Rule) -> Vec<Line> {
        let mut lines = self.band().lines(longest_s, rule);
        let square = 0.5 * self.amplitude.value.mean_square();
        for line in &mut lines {
            let factor = self.rate_factor(line.frequency_hz);
            line.power *= square * factor * factor;
        }
        lines
    }
}

impl Value {
    /// The mean square over trials.
    pub fn mean_square(self) -> f64 {
        match self {
            Value::Fixed(x) => x * x,
            Value::Uniform([a, b]) => (a * a + a * b + b * b) / 3.0,
            Value::Rayleigh(scale) => 2.0 * scale * scale,
        }
    }

    /// The largest value, or the scale of a Rayleigh distribution.
    pub fn scale(self) -> f64 {
        match self {
            Value::Fixed(x) | Value::Uniform([_, x]) | Value::Rayleigh(x) => x,
        }
    }
}

/// A linear vibration of the base, in g, which acts on the gyro through its suspension.
#[derive(Debug, Clone, PartialEq)]
pub struct Vibration {
    /// The modes of the mount.
    pub suspension: Arc<Suspension>,
    /// Acceleration: a sine or a spectrum.
    pub acceleration: Acceleration,
    /// Whether vibration above half the tick rate may appear at lower frequencies.
    pub alias: bool,
}

/// The acceleration of the base.
#[derive(Debug, Clone, PartialEq)]
pub enum Acceleration {
    /// A sine of random phase.
    Sine {
        /// Peak acceleration, g.
        amplitude_g: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
    },
    /// Stationary Gaussian acceleration with a density, which can be scaled to a standard deviation.
    Random {
        /// One-sided density, g²/Hz.
        psd: Arc<Psd>,
        /// Standard deviation to which it is scaled, g.
        rms_g: Option<f64>,
    },
}

/// The keys of the suspension of a vibration.
pub(crate) const KEYS: SuspensionKeys = SuspensionKeys {
    table: &SUSPENSION,
    gyro: &GYRO,
    modes: &MODES,
    mode: [&MODE_FREQUENCY, &MODE_Q, &MODE_RESPONSE],
};

/// Reads the vibration, if there is one.
pub(crate) fn read(reading: &mut ParseContext) -> Result<Option<Vibration>, Fault> {
    let Some(table) = reading.get(&SUSPENSION) else { return Ok(None) };
    let suspension = KEYS.read(reading)?;
    let acceleration = match (reading.get(&SINE), reading.get(&RANDOM)) {
        (Some(_), None) => Acceleration::Sine {
            amplitude_g: reading.table.needed(&SINE_ACCELERATION)?.quantity()?.value,
            frequency_hz: reading.table.needed(&SINE_FREQUENCY)?.quantity()?.value,
        },
        (None, Some(_)) => Acceleration::Random {
            psd: Arc::new(read_psd(reading.table.needed(&RANDOM_PSD)?, &ACCELERATION_DENSITIES)?),
            rms_g: reading.get(&RANDOM_RMS).map(|rms| rms.quantity()).transpose()?.map(|rms| rms.value),
        },
        _ => {
            let message = "motion.suspension needs exactly one of sine, random";
            let help = format!("accepted: {}, or {}", SINE.example, RANDOM.example);
            return Err(table.fault(message, "not exactly one", help));
        }
    };
    // The table comes last, so that an error about the whole points at the first part that is written.
    reading.note(&[&GYRO, &MODES, &SINE_ACCELERATION, &SINE_FREQUENCY, &RANDOM_PSD, &SUSPENSION]);
    let alias = reading.get(&ALIAS).is_some_and(|alias| alias.flag());
    Ok(Some(Vibration { suspension, acceleration, alias }))
}

impl Vibration {
    /// Adds the resulting rotation to a motion: a sine of amplitude a gives a tone of amplitude |H|·a, and a random
    /// acceleration gives Gaussian motion with the density |H|²·S.
    pub(crate) fn add_to(&self, motion: &mut Motion) {
        match &self.acceleration {
            Acceleration::Sine { amplitude_g, frequency_hz } => {
                let amplitude = self.suspension.response(*frequency_hz).amplitude() * amplitude_g;
                motion.tones.push(Tone::of_rate(round_12(amplitude), *frequency_hz));
            }
            Acceleration::Random { psd, rms_g } => {
                let scale = rms_g.map_or(1.0, |rms_g| round_12(rms_g * rms_g / psd.variance()));
                let (suspension, acceleration) = (self.suspension.clone(), psd.clone());
                motion.gaussian = Some(Gaussian::Vibration { suspension, acceleration, scale });
            }
        }
    }

    /// The highest frequency of the acceleration, Hz.
    fn highest_hz(&self) -> f64 {
        match &self.acceleration {
            Acceleration::Sine { frequency_hz, .. } => *frequency_hz,
            Acceleration::Random { psd, .. } => psd.points().last().map_or(0.0, |point| point[0]),
        }
    }

    /// Refuses vibration above half the tick rate where aliasing is not allowed, and vibration so far above it that the
    /// result would be meaningless.
    pub(crate) fn check(&self, tick_s: f64, most_tick_rates: f64, places: &SpanMap) -> Result<(), Fault> {
        const VIBRATION: [&str; 4] = [
            "motion.suspension.sine.frequency",
            "motion.suspension.random.psd",
            "motion.suspension",
            "gyro.tick",
        ];
        let number = |x: f64| significant(x, 6);
        let nyquist = 0.5 / tick_s;
        let highest = self.highest_hz();
        if highest * tick_s > most_tick_rates {
            let message = format!(
                "motion.suspension: a vibration of {} Hz is too fast for a tick rate of {} Hz (gyro.tick = {} s)",
                number(highest),
                number(1.0 / tick_s),
                number(tick_s)
            );
            let most = number(most_tick_rates / tick_s);
            let help = format!("accepted: up to {most_tick_rates} times the tick rate, {most} Hz here");
            return places.refuse(&VIBRATION, message, "too fast for the ticks", help);
        }
        if self.alias {
            return Ok(());
        }
        let modes = self.suspension.modes().iter().map(|mode| mode.frequency_hz);
        let mode = modes.filter(|frequency_hz| *frequency_hz > nyquist).min_by(f64::total_cmp);
        let (what, place) = match mode {
            Some(mode) => {
                let names = ["motion.suspension.gyro", "motion.suspension.modes", "motion.suspension"];
                (format!("the mode of {} Hz", number(mode)), places.blame(&names))
            }
            None if highest > nyquist => {
                (format!("a vibration of {} Hz", number(highest)), places.blame(&VIBRATION))
            }
            None => return Ok(()),
        };
        let (nyquist, tick) = (number(nyquist), number(tick_s));
        let message = format!(
            "motion.suspension: {what} is above {nyquist} Hz, the Nyquist frequency of ticks of {tick} s"
        );
        let help = format!(
            "add alias = true to motion.suspension: what is above {nyquist} Hz then shows in the ticks at a lower frequency, \
             as it does in those of a gyro; or take a shorter gyro.tick"
        );
        Err(Fault::new(place, message, "would be aliased", help))
    }
}

/// The ticks of a record that are replayed.
#[derive(Debug)]
pub(crate) struct Replay {
    /// Their angles, ″.
    pub(crate) angles: Vec<f64>,
    /// Identifies the angles by their bits.
    pub(crate) content: Id,
}

/// Means over all places of the gap in a record of the ticks round it, ″, and of their products, ″²; the first tick is that
/// farthest before the gap.
#[derive(Debug)]
pub(crate) struct WindowMeans {
    pub(crate) ticks: Vec<Double>,
    pub(crate) products: Vec<Vec<Double>>,
}

/// A record, recognized by its place in memory without being kept, with the tick, and how it is made of the samples.
struct Cut {
    record: Weak<Record>,
    tick_s: f64,
    interpolation: Interpolation,
    design: Design,
}

impl PartialEq for Cut {
    fn eq(&self, other: &Cut) -> bool {
        self.record.ptr_eq(&other.record)
            && self.tick_s.to_bits() == other.tick_s.to_bits()
            && (self.interpolation, self.design) == (other.interpolation, other.design)
    }
}

/// Replays have up to 32 MB each.
static REPLAYS: Memo<Cut, Arc<Replay>> = Memo::new(4);
/// Rows for a gap of some ticks with some ticks on either side.
static RECORD_ROWS: Memo<(Cut, u32, usize), Arc<TickRows>> = Memo::new(64);
/// Means of what is replayed, for a gap of some ticks with some ticks on either side.
static MEANS: Memo<(Cut, u32, usize), Arc<WindowMeans>> = Memo::new(16);
static VARIANCES: Memo<Cut, f64> = Memo::new(64);

impl Profile {
    fn cut(&self, tick_s: f64) -> Cut {
        let Profile { interpolation, design, .. } = *self;
        Cut { record: Arc::downgrade(&self.record), tick_s, interpolation, design }
    }

    /// The ticks that are replayed.
    pub(crate) fn replay(&self, tick_s: f64) -> Arc<Replay> {
        REPLAYS.get(self.cut(tick_s), || {
            let (_, before) = self.replayed(tick_s);
            let angles = self.tick_angles(tick_s).split_off(before);
            let words = angles.iter().map(|angle| angle.to_bits()).flat_map(|x| [x as u32, (x >> 32) as u32]);
            Arc::new(Replay { content: Id::of_words(words), angles })
        })
    }

    /// The ticks round a gap as rows, ″, whose products are means over all places of the gap, with `sides` ticks on either
    /// side, in the part from which fillers are designed. From them follow the weights of least squares over these
    /// places.
    ///
    /// The mean of all ticks is removed, which changes no filler that keeps a constant rate. A stationary estimate of the
    /// covariance by lag would leave several times the error where the motion is nearly predictable.
    pub(crate) fn tick_rows(&self, tick_s: f64, gap_ticks: u32, sides: usize) -> TickRows {
        let compute = || {
            let angles = self.design_ticks(tick_s);
            let mean = angles.iter().sum::<f64>() / angles.len().max(1) as f64;
            let swings: Vec<f64> = angles.iter().map(|angle| angle - mean).collect();
            let means = window_means(&swings, gap_ticks as usize + 2 * sides);
            let at = |tick: i32| (tick - 1 + sides as i32) as usize;
            let order: Vec<usize> = ticks(gap_ticks, sides).map(at).collect();
            let matrix: Vec<Vec<f64>> = order
                .iter()
                .map(|&i| order.iter().map(|&j| means.products[i][j].value()).collect())
                .collect();
            let mut rows = Rows::default();
            semidefinite(&matrix).iter().for_each(|row| rows.push(row, row.len(), &[]));
            TickRows::new(gap_ticks, rows).into()
        };
        RECORD_ROWS.get((self.cut(tick_s), gap_ticks, sides), compute).as_ref().clone()
    }

    /// Means over the places that are replayed, with `sides` ticks on either side of the gap.
    pub(crate) fn window_means(&self, tick_s: f64, gap_ticks: u32, sides: usize) -> Arc<WindowMeans> {
        MEANS.get((self.cut(tick_s), gap_ticks, sides), || {
            let angles = &self.replay(tick_s).angles;
            // The places of trials leave the margin free, whatever fillers read.
            let unread = MARGIN - sides;
            window_means(&angles[unread..angles.len() - unread], gap_ticks as usize + 2 * sides).into()
        })
    }

    /// Variance of the angles of all ticks, ″².
    pub(crate) fn variance(&self, tick_s: f64) -> f64 {
        VARIANCES.get(self.cut(tick_s), || {
            let angles = self.tick_angles(tick_s);
            let count = angles.len().max(1) as f64;
            let mean = angles.iter().sum::<f64>() / count;
            angles.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count
        })
    }
}

/// Means over all windows of `width` ticks; 0 where there is none.
fn window_means(x: &[f64], width: usize) -> WindowMeans {
    let mut ticks = vec![Double::default(); width];
    let mut products = vec![vec![Double::default(); width]; width];
    let Some(windows) = (x.len() + 1).checked_sub(width).filter(|windows| *windows > 0) else {
        return WindowMeans { ticks, products };
    };
    for j in 0..width {
        let later = &x[j..j + windows];
        ticks[j] = later.iter().fold(Double::default(), |sum, x| sum + Double::from(*x));
        let pairs = x[..windows].iter().zip(later);
        products[0][j] = pairs.fold(Double::default(), |sum, (a, b)| sum + Double::product(*a, *b));
        // Along a diagonal each window leaves its first product and takes one more.
        for i in 1..width - j {
            products[i][i + j] = products[i - 1][i + j - 1] - Double::product(x[i - 1], x[i + j - 1])
                + Double::product(x[windows + i - 1], x[windows + i + j - 1]);
        }
    }
    let part = Double::from(1.0 / windows as f64);
    ticks.iter_mut().for_each(|sum| *sum = *sum * part);
    products.iter_mut().flatten().for_each(|sum| *sum = *sum * part);
    for (i, j) in (0..width).flat_map(|i| (0..i).map(move |j| (i, j))) {
        products[i][j] = products[j][i];
    }
    WindowMeans { ticks, products }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_means_over_all_windows() {
        let x: Vec<f64> = (0..40).map(|k| libm::sin(f64::from(k * k))).collect();
        let found = window_means(&x, 7);
        for (i, j) in (0..7).flat_map(|i| (0..7).map(move |j| (i, j))) {
            let expected = (0..34).map(|s| x[s + i] * x[s + j]).sum::<f64>() / 34.0;
            let found = found.products[i][j].value();
            assert!((found - expected).abs() < 1e-14, "{i}, {j}: {found}, not {expected}");
        }
        assert_eq!(window_means(&x[..6], 7).products[0][0], Double::default());
    }
}
