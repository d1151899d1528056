//! The terms of noise models; each has a file with all its properties, and this is the list of them.

mod angle_random_walk;
mod band_limit;
mod bias_instability;
mod markov;
mod quantization;
mod rate_ramp;
mod rate_random_walk;
mod sine;
mod warm_up;

use crate::allan::estimator::Difference;
use crate::allan::part::{Part, Trend};
use sagnac_base::quantity::expression::STANDARD_GRAVITY;

/// One µg in m/s².
const MICRO_G: f64 = STANDARD_GRAVITY * 1e-6;

/// Declares the terms, those of studies that can be fitted before the two others. Each has a module with its row and,
/// if arguments are given here, a function of that name that makes a part.
macro_rules! terms {
    ($($(#[$doc:meta])* $Term:ident = $term:ident $(($($args:ident),+))?,)+) => {
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
                    $(Term::$Term => &$term::ROW,)+
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
    Quantization = quantization(q),
    /// White rate: N, ″/√s.
    AngleRandomWalk = angle_random_walk(n),
    /// Flicker of the rate: B, ″/s. The Allan variance is flat at (2 ln2/π)B².
    BiasInstability = bias_instability,
    /// Random walk of the rate: K, ″/s^1.5.
    RateRandomWalk = rate_random_walk(k),
    /// Constant acceleration: R, ″/s².
    RateRamp = rate_ramp(r),
    /// Exponentially correlated rate: its rms σ, ″/s, and the time T_c, s. The part has IEEE's q_c = σ√(2/T_c).
    Markov = markov(q_c, time_s),
    /// Sine of the rate with a random phase: its amplitude Ω_0, ″/s, and frequency f, Hz.
    Sine = sine(amplitude, frequency_hz),
    /// What the filter of the sensor takes off the variance of the angles at averaging times beyond its memory: L, ″. Fits
    /// of logs add it by themselves, and no generator draws it.
    BandLimit = band_limit(l),
    /// Decay of the rate after the start of the record: the rate there, ″/s, and the time T in which it falls to 1/e,
    /// s.
    WarmUp = warm_up(amplitude, time_s),
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
    /// See [`Part::variance`].
    pub variance: fn(&Part, Difference, f64, u64) -> f64,
    /// See [`Part::trend`].
    pub trend: fn(&Part, Difference, f64, u64) -> Option<Trend>,
    /// Allan variance of the continuous noise at τ, (″/s)²; `None` if it depends on the length of the record.
    pub continuous: fn(&Part, f64) -> Option<f64>,
    /// See [`density`](crate::allan::spectrum::density).
    pub density: fn(&Part, f64, f64) -> Option<f64>,
    /// The covariance of two differences of noise, for a sampling time; `None` if samples are independent.
    pub kernel: fn(&Part, f64) -> Option<Kernel>,
    /// Covariance of two differences of noise without a kernel, from the product of the coefficients of angles that meet.
    pub covariance: fn(&Part, f64) -> f64,
    /// Product of two differences of a part that is not noise.
    pub product: fn(&Part, &Apart) -> f64,
    /// The angle of the part over some samples, for a sampling time.
    pub increment: fn(&Part, f64, u64) -> Increment,
    /// The generators for a sampling time and a number of samples.
    pub sources: fn(&Part, f64, u64) -> Vec<Source>,
    /// Largest angle that the rate of a coefficient can accumulate in a time, ″; 0 for noise of the angle.
    pub turned: fn(f64, f64) -> f64,
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
    /// Defaults for a noise of the rate without a shape and without closed forms.
    const NOISE: Row = Row {
        key: "",
        symbol: "",
        title: "",
        title_of_acceleration: None,
        name: [""; 2],
        unit: (1.0, "deg/h", "°/h"),
        unit_of_acceleration: (1.0, "ug", "µg"),
        plain: ("", ""),
        size: ("a noise of", 0.0),
        shape: None,
        part: |term, coefficient, shape, _| Part::new(term, [coefficient, shape]),
        square: |part| part.size * part.size,
        variance: |_, _, _, _| 0.0,
        trend: |_, _, _, _| None,
        continuous: |_, _| None,
        density: |_, _, _| None,
        kernel: |_, _| None,
        covariance: |_, _| 0.0,
        // A trend that decays is left out, because it is not stationary.
        product: |part, apart| {
            let at = |m: f64| part.trend(apart.difference, apart.sample_s, m as u64);
            let steady = |m| at(m).filter(|trend| trend.decay == 0.0).map_or(0.0, |trend| trend.first);
            steady(apart.a) * steady(apart.b)
        },
        increment: |_, _, _| Increment::Other,
        sources: |_, _, _| vec![],
        turned: |coefficient, time_s| coefficient.abs() * time_s,
    };
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
/// see [`generalized`](crate::allan::generalized).
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
