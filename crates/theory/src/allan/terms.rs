//! The terms of noise models: the properties of a term, the list of the terms, and a row for each of them.

use core::f64::consts::PI;

use crate::allan::flicker::{self, Holds, cubic};
use crate::allan::markov::{self, beyond_square};
use crate::allan::{Difference, FLAT_LEVEL, Part, Trend, sine_of_turns};
use sagnac_base::quantity::expression::STANDARD_GRAVITY;

/// One µg in m/s².
const MICRO_G: f64 = STANDARD_GRAVITY * 1e-6;

/// Declares the terms, those of studies that can be fitted before the two others. Each has a row and,
/// if arguments are given here, a function of that name that makes a part.
macro_rules! terms {
    ($($(#[$doc:meta])* $Term:ident: $ROW:ident = $term:ident $(($($args:ident),+))?,)+) => {
        /// A term of a noise model, with its reported coefficient. Its Allan variance is proportional to the square of
        /// the coefficient.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Term {
            $($(#[$doc])* $Term,)+
        }

        impl Term {
            /// Every term, including those that cannot be fitted.
            pub const EVERY: [Term; [$(Term::$Term),+].len()] = [$(Term::$Term),+];

            /// The properties of the term.
            pub fn row(self) -> &'static Row {
                match self {
                    $(Term::$Term => &$ROW,)+
                }
            }
        }

        impl Part {
            $($(#[doc = "A part of this term, in ″ and s."]
            pub const fn $term($($args: f64),+) -> Part {
                Part::new(Term::$Term, [$($args,)+ 1.0])
            })?)+
        }
    };
}

terms! {
    /// White error of the angles: its rms Q, ″.
    Quantization: QUANTIZATION = quantization(q),
    /// White rate: N, ″/√s.
    AngleRandomWalk: ANGLE_RANDOM_WALK = angle_random_walk(n),
    /// Flicker of the rate: B, ″/s. The Allan variance is flat at (2 ln2/π)B².
    BiasInstability: BIAS_INSTABILITY = bias_instability,
    /// Random walk of the rate: K, ″/s^1.5.
    RateRandomWalk: RATE_RANDOM_WALK = rate_random_walk(k),
    /// Constant acceleration: R, ″/s².
    RateRamp: RATE_RAMP = rate_ramp(r),
    /// Exponentially correlated rate: its rms σ, ″/s, and the time T_c, s. The part has IEEE's q_c = σ√(2/T_c).
    Markov: MARKOV = markov(q_c, time_s),
    /// Sine of the rate with a random phase: its amplitude Ω_0, ″/s, and frequency f, Hz.
    Sine: SINE = sine(amplitude, frequency_hz),
    /// What the filter of the sensor takes off the variance of the angles at averaging times beyond its memory: L, ″. Fits
    /// of logs add it by themselves, and no generator draws it.
    BandLimit: BAND_LIMIT = band_limit(l),
    /// Decay of the rate after the start of the record: the rate there, ″/s, and the time T in which it falls to 1/e,
    /// s.
    WarmUp: WARM_UP = warm_up(amplitude, time_s),
}

/// The properties of a term: its names, its units, and the closed forms for a part of it.
pub struct Row {
    /// Name in studies; for a term with a shape, the name of its table.
    pub key: &'static str,
    /// Name in lists of terms and in tables of coefficients.
    pub symbol: &'static str,
    /// Name on a data sheet.
    pub title: &'static str,
    /// Name on the data sheet of an accelerometer, where it is another one.
    pub title_of_acceleration: Option<&'static str>,
    /// Article, if it needs one, and name in a sentence.
    pub name: [&'static str; 2],
    /// Factor from ″ and s to the unit of data sheets, that unit in files, and its symbol for the user.
    pub unit: (f64, &'static str, &'static str),
    /// Factor and unit of the coefficient of an accelerometer, from µg and s to those of IEEE Std 1293 and of data sheets.
    pub unit_of_acceleration: (f64, &'static str, &'static str),
    /// Unit for a record of plain numbers, in files and for the user: a power of s.
    pub plain: (&'static str, &'static str),
    /// Words before a refused coefficient, and the least accepted one.
    pub size: (&'static str, f64),
    /// The time or frequency of the term, if it has one.
    pub shape: Option<Shape>,
    /// The part with this coefficient and shape; the octaves are those of flicker.
    pub part: fn(Term, f64, f64, usize) -> Part,
    /// Square of the coefficient of a part.
    pub square: fn(&Part) -> f64,
    /// The closed forms and generators of a part.
    pub forms: Forms,
}

/// The closed forms of a part, for a sampling time, and its generators. A term has to say each of them.
pub struct Forms {
    /// The differences of angles.
    pub differences: Differences,
    /// Allan variance of the continuous noise at τ, (″/s)²; `None` if it depends on the length of the record.
    pub continuous: fn(&Part, f64) -> Option<f64>,
    /// See [`density`](crate::allan::density).
    pub density: fn(&Part, f64, f64) -> Option<f64>,
    /// The covariance of two differences.
    pub covariance: Covariance,
    /// The angle of the part over some samples, for a sampling time.
    pub increment: fn(&Part, f64, u64) -> Increment,
    /// The generators for a sampling time and a number of samples.
    pub sources: fn(&Part, f64, u64) -> Vec<Source>,
    /// Largest angle that the rate of a coefficient can accumulate in a time, ″; 0 for noise of the angle.
    pub turned: fn(f64, f64) -> f64,
}

/// The differences of the angles of a part, for an order, a sampling time and an averaging factor.
pub enum Differences {
    /// Their variance, if each record has its own.
    Random(fn(&Part, Difference, f64, u64) -> f64),
    /// The differences themselves, if all records have the same.
    Shared(fn(&Part, Difference, f64, u64) -> Trend),
}

/// The covariance of two differences of the angles of a part.
pub enum Covariance {
    /// That of noise, for a sampling time.
    Kernel(fn(&Part, f64) -> Kernel),
    /// That of independent errors of the angles, from the product of the coefficients of angles that meet.
    Meeting(fn(&Part, f64) -> f64),
    /// The product of two differences of a part that is not noise.
    Product(fn(&Part, &Apart) -> f64),
}

/// The time or frequency that belongs to a coefficient.
pub struct Shape {
    /// Name in the table of the term.
    pub key: &'static str,
    /// Name in tables of coefficients.
    pub symbol: &'static str,
    /// Unit, s or Hz.
    pub unit: &'static str,
    /// Name for the user next to the term.
    pub name: &'static str,
    /// Name for the user on its own.
    pub title: &'static str,
    /// Words before a refused value.
    pub what: &'static str,
    /// Letters of coefficient and shape in the legend of a chart.
    pub letters: [&'static str; 2],
    /// Shortest and longest shape that a curve can resolve, from its shortest and longest τ.
    pub range: fn([f64; 2]) -> [f64; 2],
    /// Points of a search per decade.
    pub per_decade: f64,
}

impl Row {
    /// A noise of the rate without a shape, with its names in studies, in lists of terms and on data sheets, its name in a
    /// sentence, and its closed forms.
    const fn new(
        [key, symbol, title]: [&'static str; 3],
        name: [&'static str; 2],
        plain: (&'static str, &'static str),
        forms: Forms,
    ) -> Row {
        Row {
            key,
            symbol,
            title,
            title_of_acceleration: None,
            name,
            unit: (1.0, "deg/h", "°/h"),
            unit_of_acceleration: (1.0, "ug", "µg"),
            plain,
            size: ("a noise of", 0.0),
            shape: None,
            part: |term, coefficient, shape, _| Part::new(term, [coefficient, shape]),
            square: |part| part.size * part.size,
            forms,
        }
    }
}

/// The angle that a constant rate accumulates in a time.
fn at_constant_rate(coefficient: f64, time_s: f64) -> f64 {
    coefficient.abs() * time_s
}

/// The product of two differences that all records share. One that decays is left out, because it is not stationary.
fn product_of_trends(part: &Part, apart: &Apart) -> f64 {
    let at = |m: f64| part.trend(apart.difference, apart.sample_s, m as u64);
    let steady = |m| at(m).filter(|trend| trend.decay == 0.0).map_or(0.0, |trend| trend.first);
    steady(apart.a) * steady(apart.b)
}

impl Shape {
    /// A time, which a curve resolves within its τ.
    const TIME: Shape = Shape {
        key: "time",
        symbol: "time",
        unit: "s",
        name: "time constant",
        title: "time constant",
        what: "a time of",
        letters: ["", "T"],
        range: |taus| taus,
        per_decade: 12.0,
    };
}

/// A generator of the kernel that makes a sampled part, with angles in ″ and times in samples. A part may need several.
pub enum Source {
    /// Independent errors of all angles with this standard deviation.
    Errors(f64),
    /// Independent increments of the angle with this standard deviation.
    White(f64),
    /// Rates that are held for 1, 2, 4, … samples, with these standard deviations.
    Holds(Vec<f64>),
    /// A random walk of the rate with steps of this standard deviation.
    Walk(f64),
    /// The rate r_k = e^{−decay}·r_{k−1} + … with this stationary standard deviation. A record has at most one.
    Markov {
        /// Stationary standard deviation of the rate.
        sigma: f64,
        /// Sample time over the correlation time.
        decay: f64,
    },
    /// A sine of the angle that turns `turns` times per sample. A record has at most one.
    Sine {
        /// Peak of the angle.
        amplitude: f64,
        /// Turns per sample.
        turns: f64,
    },
    /// The angle ½ · this · k².
    Ramp(f64),
    /// The angle reach·(1 − e^{−decay·k}).
    Decay {
        /// Final angle.
        reach: f64,
        /// Sample time over the time constant.
        decay: f64,
    },
}

/// The contribution of a part to the angle between two samples.
pub enum Increment {
    /// A normal number with this variance, ″².
    Normal(f64),
    /// A sine of random phase with this peak, ″.
    Sine(f64),
    /// No closed form is known.
    Other,
}

/// Second difference, m apart around the lag n ≥ 0, of the generalized covariance of an angle, ″², up to a constant;
/// see [`generalized`](crate::allan::flicker).
pub type Kernel = Box<dyn Fn(f64, f64) -> f64>;

/// Two differences of angles at the averaging factors `a` and `b`. The second starts `lag` samples after the first,
/// averaged over `width` lags around that.
pub struct Apart {
    /// Order of both differences.
    pub difference: Difference,
    /// Sampling time, s.
    pub sample_s: f64,
    /// Averaging factor of the first difference.
    pub a: f64,
    /// Averaging factor of the second difference.
    pub b: f64,
    /// Samples from the start of the first difference to that of the second.
    pub lag: f64,
    /// Number of lags around it that are averaged.
    pub width: f64,
}

// `Term::ALL` leaves out the last two terms, of which this is the first.
const _: () = assert!(matches!(Term::EVERY[Term::ALL.len()], Term::BandLimit));

impl Term {
    /// Every term of a study that can be fitted: all but the band limit, which none has, and the warm-up.
    pub const ALL: [Term; Term::EVERY.len() - 2] = *Term::EVERY.first_chunk().unwrap();

    /// The five terms of A(4).
    pub const MODEL: [Term; 5] = [
        Term::Quantization,
        Term::AngleRandomWalk,
        Term::BiasInstability,
        Term::RateRandomWalk,
        Term::RateRamp,
    ];

    /// Name in studies and tables.
    pub fn symbol(self) -> &'static str {
        self.row().symbol
    }

    /// The averaging time, s, at which the Allan deviation of the term alone is its coefficient in base units; `None` of terms that
    /// are read off elsewhere.
    pub fn read_at(self) -> Option<f64> {
        Some(match self {
            Term::Quantization => libm::sqrt(3.0),
            Term::AngleRandomWalk => 1.0,
            Term::RateRandomWalk => 3.0,
            Term::RateRamp => core::f64::consts::SQRT_2,
            _ => return None,
        })
    }

    /// The time or frequency of a term, if it has one.
    pub fn shape(self) -> Option<&'static Shape> {
        self.row().shape.as_ref()
    }

    /// Whether a time or frequency is fitted too.
    pub fn has_shape(self) -> bool {
        self.shape().is_some()
    }

    /// Number of parameters in a fit.
    pub fn parameters(self) -> usize {
        1 + usize::from(self.has_shape())
    }

    /// The part of the angle for the square of the coefficient, its shape, and the number of octaves of flicker.
    pub fn part(self, square: f64, shape: f64, octaves: usize) -> Part {
        self.of_coefficient(libm::sqrt(square), shape, octaves)
    }

    /// The part for the coefficient itself, which may be negative if the term is not noise.
    pub fn of_coefficient(self, coefficient: f64, shape: f64, octaves: usize) -> Part {
        (self.row().part)(self, coefficient, shape, octaves)
    }
}

/// White error of the angles.
static QUANTIZATION: Row = Row {
    unit: (1.0, "arcsec", "″"),
    unit_of_acceleration: (MICRO_G, "m/s", "m/s"),
    ..Row::new(
        ["noise.quantization", "Q", "quantization noise Q"],
        ["", "quantization"],
        ("s", "· s"),
        Forms {
            // Σc² of the coefficients of the angles.
            differences: Differences::Random(|part, difference, _, _| {
                part.size * part.size * if difference == Difference::Second { 6.0 } else { 20.0 }
            }),
            continuous: |part, tau| Some(3.0 * part.size * part.size / (tau * tau)),
            // The difference of two errors over t0.
            density: |part, t0, f| {
                let step = 2.0 * part.size * sine_of_turns(0.5 * f * t0);
                Some(2.0 * step * step / t0)
            },
            covariance: Covariance::Meeting(|part, met| met * part.size * part.size),
            increment: |part, _, _| Increment::Normal(2.0 * part.size * part.size),
            sources: |part, _, _| vec![Source::Errors(part.size)],
            turned: |_, _| 0.0,
        },
    )
};

/// White rate.
static ANGLE_RANDOM_WALK: Row = Row {
    title_of_acceleration: Some("velocity random walk N"),
    unit: (1.0 / 60.0, "deg/sqrt(h)", "°/√h"),
    unit_of_acceleration: (60.0 * MICRO_G, "m/s/sqrt(h)", "m/s/√h"),
    ..Row::new(
        ["noise.angle_random_walk", "N", "angle random walk N"],
        ["an ", "angle random walk"],
        ("sqrt(s)", "· √s"),
        Forms {
            // Σc² of the coefficients of the increments.
            differences: Differences::Random(|part, difference, t0, m| {
                part.size * part.size * (t0 * m as f64) * difference.divisor()
            }),
            continuous: |part, tau| Some(part.size * part.size / tau),
            density: |part, _, _| Some(2.0 * part.size * part.size),
            // G = −|n|/2.
            covariance: Covariance::Kernel(|part, t0| {
                let scale = part.size * part.size * t0;
                Box::new(move |m, n| -scale * (m - n).max(0.0))
            }),
            increment: |part, t0, n| Increment::Normal(part.size * part.size * t0 * n as f64),
            sources: |part, t0, _| vec![Source::White(part.size * libm::sqrt(t0))],
            turned: |_, _| 0.0,
        },
    )
};

/// Flicker of the rate, as a sum of octave holds.
static BIAS_INSTABILITY: Row = Row {
    part: |_, b, _, octaves| Part::bias_instability(b, octaves),
    ..Row::new(
        ["noise.bias_instability", "B", "bias instability B"],
        ["a ", "bias instability"],
        ("", ""),
        Forms {
            differences: Differences::Random(|part, difference, t0, m| {
                let one = |(o, v): (usize, &f64)| v * flicker::mean_square(difference, 1 << o, m);
                FLAT_LEVEL
                    * part.size
                    * part.size
                    * t0
                    * t0
                    * octave_variances(part).iter().enumerate().map(one).sum::<f64>()
            }),
            continuous: |part, _| Some(FLAT_LEVEL * part.size * part.size),
            // That of continuous flicker; the holds have it within 14 % up to a tenth of the sampling rate.
            density: |part, _, f| Some(part.size * part.size / (PI * f)),
            covariance: Covariance::Kernel(|part, t0| {
                let scale = FLAT_LEVEL * part.size * part.size * t0 * t0;
                let holds =
                    Holds::new(octave_variances(part).iter().map(|variance| scale * variance).collect());
                Box::new(move |m, n| holds.at(m, n))
            }),
            increment: |_, _, _| Increment::Other,
            // The number of octaves is that which the record needs, regardless of the part.
            sources: |part, t0, samples| {
                let octaves = flicker::octaves(samples).unwrap_or_default();
                let sigma = |v: &f64| part.size * t0 * libm::sqrt(FLAT_LEVEL * v);
                vec![Source::Holds(octave_variances(&Part { octaves, ..*part }).iter().map(sigma).collect())]
            },
            turned: at_constant_rate,
        },
    )
};

/// The variance of each octave for an Allan variance of 1, or NaN.
fn octave_variances(part: &Part) -> Vec<f64> {
    flicker::variances(part.octaves).unwrap_or_else(|| vec![f64::NAN])
}

impl Part {
    /// Flicker of the rate with the coefficient B, ″/s, as a sum of `octaves` octave holds. It is NaN if there are no
    /// [variances](flicker::variances) for that number of octaves.
    pub const fn bias_instability(b: f64, octaves: usize) -> Part {
        Part { octaves, ..Part::new(Term::BiasInstability, [b, 1.0]) }
    }
}

/// Random walk of the rate.
static RATE_RANDOM_WALK: Row = Row {
    title_of_acceleration: Some("acceleration random walk K"),
    unit: (60.0, "deg/h/sqrt(h)", "°/h/√h"),
    unit_of_acceleration: (60.0, "ug/sqrt(h)", "µg/√h"),
    ..Row::new(
        ["noise.rate_random_walk", "K", "rate random walk K"],
        ["a ", "rate random walk"],
        ("1/sqrt(s)", "/ √s"),
        Forms {
            // Squares of 1, 2, … m, … 2, 1 for the second difference: K²τ/3·(1 + 1/2m²) as Allan variance, and K²τ/6·(1
            // + 1/m²) as Hadamard variance.
            differences: Differences::Random(|part, difference, t0, m| {
                let n = m as f64;
                let sum = match difference {
                    Difference::Second => (2.0 * n * n * n + n) / 3.0,
                    Difference::Third => n * n * n + n,
                };
                part.size * part.size * t0 * t0 * t0 * sum
            }),
            continuous: |part, tau| Some(part.size * part.size * tau / 3.0),
            // Steps of variance K²t0, divided by the response of a difference.
            density: |part, t0, f| {
                let walk = part.size * t0 / (2.0 * sine_of_turns(0.5 * f * t0));
                Some(2.0 * walk * walk)
            },
            // G = (|n|³ − |n|)/12.
            covariance: Covariance::Kernel(|part, t0| {
                let scale = part.size * part.size * t0 * t0 * t0;
                Box::new(move |m, n| scale * cubic(m, n))
            }),
            increment: |_, _, _| Increment::Other,
            sources: |part, t0, _| vec![Source::Walk(part.size * t0 * libm::sqrt(t0))],
            turned: |k, t| k * t * libm::sqrt(t),
        },
    )
};

/// Constant acceleration.
static RATE_RAMP: Row = Row {
    title_of_acceleration: Some("acceleration ramp R"),
    unit: (3600.0, "deg/h/h", "°/h/h"),
    unit_of_acceleration: (3600.0, "ug/h", "µg/h"),
    size: ("a ramp of", f64::MIN),
    ..Row::new(
        ["noise.rate_ramp", "R", "rate ramp R"],
        ["a ", "rate ramp"],
        ("1/s", "/ s"),
        Forms {
            differences: Differences::Shared(|part, difference, t0, m| {
                let tau = t0 * m as f64;
                let first = if difference == Difference::Second { part.size * tau * tau } else { 0.0 };
                Trend { first, decay: 0.0 }
            }),
            continuous: |part, tau| Some(part.size * part.size * tau * tau / 2.0),
            density: |_, _, _| None,
            covariance: Covariance::Product(product_of_trends),
            increment: |_, _, _| Increment::Other,
            sources: |part, t0, _| vec![Source::Ramp(part.size * t0 * t0)],
            turned: |r, t| 0.5 * r.abs() * t * t,
        },
    )
};

/// Exponentially correlated rate.
static MARKOV: Row = Row {
    shape: Some(Shape {
        symbol: "markov_time",
        name: "correlation time",
        title: "correlation time of the Markov noise",
        what: "a correlation time of",
        letters: ["Markov: σ", "T"],
        ..Shape::TIME
    }),
    part: |_, sigma, time_s, _| Part::markov(sigma * libm::sqrt(2.0 / time_s), time_s),
    square: |part| 0.5 * part.size * part.size * part.shape,
    ..Row::new(
        ["noise.markov", "markov", "Markov noise"],
        ["", "Markov noise"],
        ("", ""),
        Forms {
            differences: Differences::Random(|part, difference, t0, m| {
                increment_variance(part, t0) * markov::mean_square(difference, t0 / part.shape, m as f64)
            }),
            // (q_cT_c)²/τ·[1 − (T_c/2τ)(3 − 4e^{−τ/T_c} + e^{−2τ/T_c})].
            continuous: |part, tau| {
                let (q_c, time_s) = (part.size, part.shape);
                let z = tau / time_s;
                // 2z − 3 + 4e^{−z} − e^{−2z}, in which the powers up to z² cancel.
                let bracket = match z < 0.5 {
                    true => 4.0 * beyond_square(z) - beyond_square(2.0 * z),
                    false => 2.0 * z - 3.0 + 4.0 * libm::exp(-z) - libm::exp(-2.0 * z),
                };
                Some(q_c * q_c * time_s * time_s / tau * bracket / (2.0 * z))
            },
            // 2t0·σ²(1 − a²)/(1 − 2a cos 2πft0 + a²), whose differences are of small numbers where t0 is short.
            density: |part, t0, f| {
                let (decay, step) = (t0 / part.shape, 2.0 * sine_of_turns(0.5 * f * t0));
                let fallen = -libm::expm1(-decay);
                let response = fallen * fallen + libm::exp(-decay) * step * step;
                Some(part.size * part.size * part.shape * t0 * -libm::expm1(-2.0 * decay) / response)
            },
            covariance: Covariance::Kernel(|part, t0| {
                let (variance, decay) = (increment_variance(part, t0), t0 / part.shape);
                Box::new(move |m, n| variance * markov::kernel(decay, m, n))
            }),
            increment: |part, t0, n| {
                Increment::Normal(increment_variance(part, t0) * markov::summed(t0 / part.shape, n as f64))
            },
            sources: |part, t0, _| {
                let sigma = part.size * libm::sqrt(0.5 * part.shape) * t0;
                vec![Source::Markov { sigma, decay: t0 / part.shape }]
            },
            turned: at_constant_rate,
        },
    )
};

/// Variance of the rate times t0², ″².
fn increment_variance(part: &Part, t0: f64) -> f64 {
    0.5 * part.size * part.size * part.shape * t0 * t0
}

/// Sine of the rate with a random phase.
static SINE: Row = Row {
    size: ("an amplitude of", 0.0),
    shape: Some(Shape {
        key: "frequency",
        symbol: "sine_frequency",
        unit: "Hz",
        name: "frequency of the sine",
        title: "frequency of the sine",
        what: "a frequency of",
        letters: ["sine: Ω", "f"],
        // Its hump, a third of an octave wide, must lie within the curve; a slower sine looks like a ramp.
        range: |[shortest, longest]| [0.2 / longest, 0.5 / shortest],
        per_decade: 40.0,
    }),
    ..Row::new(
        ["noise.sine", "sine", "sine"],
        ["a ", "sine"],
        ("", ""),
        Forms {
            // The amplitude of the angle is Ω_0/2πf, and every difference multiplies it by 2 sin πfτ.
            differences: Differences::Random(|part, difference, t0, m| {
                let step = 2.0 * sine_of_turns(0.5 * part.shape * (t0 * m as f64));
                let angle = part.size / (2.0 * PI * part.shape);
                0.5 * angle * angle * libm::pow(step * step, difference.spans() as f64)
            }),
            // Ω_0²(sin²πfτ/πfτ)².
            continuous: |part, tau| {
                let sine = sine_of_turns(0.5 * part.shape * tau);
                let shape = sine * sine / (PI * part.shape * tau);
                Some(part.size * part.size * shape * shape)
            },
            density: |_, _, _| None,
            // The mean over the phase, averaged over the lags.
            covariance: Covariance::Product(|part, &Apart { difference, sample_s, a, b, lag, width }| {
                let turns = part.shape * sample_s;
                let spans = difference.spans() as f64;
                let step = |m: f64| libm::pow(2.0 * sine_of_turns(0.5 * turns * m), spans);
                let angle = part.size / (2.0 * PI * part.shape);
                let from_middle = lag + 0.5 * spans * (b - a);
                let (one, whole) = (sine_of_turns(0.5 * turns), sine_of_turns(0.5 * turns * width));
                let smoothed = if width == 1.0 || one == 0.0 { 1.0 } else { whole / (width * one) };
                0.5 * angle * angle * step(a) * step(b) * smoothed * sine_of_turns(0.25 + turns * from_middle)
            }),
            increment: |part, t0, n| {
                Increment::Sine(
                    part.size / (PI * part.shape) * sine_of_turns(0.5 * part.shape * (t0 * n as f64)),
                )
            },
            sources: |part, t0, _| {
                vec![Source::Sine { amplitude: part.size / (2.0 * PI * part.shape), turns: part.shape * t0 }]
            },
            turned: at_constant_rate,
        },
    )
};

/// The filter of the sensor itself, beyond its memory.
///
/// A filter of unit gain at rest leaves the random walk of the angle as it is, except that each angle is a mean of that walk over the
/// memory of the filter. The variance of an increment over n samples, as long as n exceeds that memory, is then less by a
/// constant, as quantization makes it greater by one. For white rate noise N through a first-order low-pass of the time T,
/// that constant is N²T, and L² = N²T/2.
static BAND_LIMIT: Row = Row {
    unit: (1.0, "arcsec", "″"),
    unit_of_acceleration: (MICRO_G, "m/s", "m/s"),
    ..Row::new(
        ["", "L", "band limit L"],
        ["a ", "band limit"],
        ("s", "· s"),
        Forms {
            differences: Differences::Random(|part, difference, t0, m| {
                -Part { term: Term::Quantization, ..*part }.variance(difference, t0, m)
            }),
            continuous: |part, tau| Some(-3.0 * part.size * part.size / (tau * tau)),
            density: |_, _, _| None,
            covariance: Covariance::Meeting(|part, met| -met * part.size * part.size),
            increment: |part, _, _| Increment::Normal(-2.0 * part.size * part.size),
            sources: |_, _, _| vec![],
            turned: |_, _| 0.0,
        },
    )
};

/// Decay of the rate after the start of the record.
static WARM_UP: Row = Row {
    size: ("an amplitude of", f64::MIN),
    shape: Some(Shape::TIME),
    ..Row::new(
        ["noise.warm_up", "warm_up", "warm-up"],
        ["a ", "warm-up"],
        ("", ""),
        Forms {
            // θ = AT(1 − e^{−t/T}): each difference multiplies e^{−t/T} by e^{−τ/T} − 1.
            differences: Differences::Shared(|part, difference, t0, m| {
                let (amplitude, time_s, tau) = (part.size, part.shape, t0 * m as f64);
                let power = f64::from(difference.spans() as u32);
                let first = -amplitude * time_s * libm::pow(libm::expm1(-tau / time_s), power);
                Trend { first, decay: t0 / time_s }
            }),
            continuous: |_, _| None,
            density: |_, _, _| None,
            covariance: Covariance::Product(product_of_trends),
            increment: |_, _, _| Increment::Other,
            sources: |part, t0, _| {
                vec![Source::Decay { reach: part.size * part.shape, decay: t0 / part.shape }]
            },
            turned: at_constant_rate,
        },
    )
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_taken_back_to_its_term() {
        for term in Term::EVERY {
            let shape = if term.has_shape() { 0.7 } else { 1.0 };
            let part = term.part(0.3, shape, 24);
            assert_eq!((part.term, part.shape), (term, shape));
            assert!((part.square() / 0.3 - 1.0).abs() < 1e-14, "{term:?}: {}", part.square());
        }
    }
}
