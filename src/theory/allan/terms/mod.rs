//! The terms that noise models are made of: a file for each with all that is known of it, and the list of them.

mod angle_random_walk;
mod bias_instability;
mod markov;
mod quantisation;
mod rate_ramp;
mod rate_random_walk;
mod sine;
mod warm_up;

use crate::theory::allan::estimator::Difference;
use crate::theory::allan::part::{Part, Trend};

/// Declares the terms: those that a fit can find and the others, each with the module that has its row.
macro_rules! terms {
    (fitted { $($(#[$fitted_doc:meta])* $Fitted:ident = $fitted:ident,)+ }
     others { $($(#[$other_doc:meta])* $Other:ident = $other:ident,)+ }) => {
        /// A term of a noise model, with the coefficient that is reported for it. Its Allan variance is proportional to the
        /// coefficient's square.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Term {
            $($(#[$fitted_doc])* $Fitted,)+
            $($(#[$other_doc])* $Other,)+
        }

        impl Term {
            /// Every term that a fit can find.
            pub const ALL: [Term; [$(Term::$Fitted),+].len()] = [$(Term::$Fitted),+];

            /// Every term, also those that no fit finds.
            pub const EVERY: [Term; [$(Term::$Fitted,)+ $(Term::$Other),+].len()] =
                [$(Term::$Fitted,)+ $(Term::$Other),+];

            pub(crate) fn row(self) -> &'static Row {
                match self {
                    $(Term::$Fitted => &$fitted::ROW,)+
                    $(Term::$Other => &$other::ROW,)+
                }
            }
        }
    };
}

terms! {
    fitted {
        /// Q, ″.
        Quantisation = quantisation,
        /// N, ″/√s.
        AngleRandomWalk = angle_random_walk,
        /// B, ″/s.
        BiasInstability = bias_instability,
        /// K, ″/s^1.5.
        RateRandomWalk = rate_random_walk,
        /// R, ″/s².
        RateRamp = rate_ramp,
        /// The rms σ of the exponentially correlated rate, ″/s; its shape is T_c, s. IEEE's q_c is σ√(2/T_c).
        Markov = markov,
        /// The amplitude Ω_0 of the rate, ″/s; its shape is f, Hz.
        Sine = sine,
    }
    others {
        /// The rate at the start of the record, ″/s; its shape is the time T in which it falls to 1/e, s.
        WarmUp = warm_up,
    }
}

/// What a term is called, and in which units it is given.
pub(crate) struct Row {
    /// As studies have it: of a term with a shape the table of both.
    pub(crate) key: &'static str,
    /// As lists of terms and tables of coefficients have it.
    pub(crate) symbol: &'static str,
    /// For people, as on a data sheet: `bias instability B`.
    pub(crate) title: &'static str,
    /// In a sentence, and the article before it where it has one.
    pub(crate) name: &'static str,
    pub(crate) article: &'static str,
    /// From ″ and s to the unit of data sheets: the factor, the unit as files have it, and its symbol for people.
    pub(crate) unit: (f64, &'static str, &'static str),
    /// The unit of plain numbers, in files and for people: theirs times a power of s.
    pub(crate) plain: (&'static str, &'static str),
    /// What an impossible size is one of, and the least possible size.
    pub(crate) size: (&'static str, f64),
    pub(crate) shape: Option<Shape>,
    pub(crate) law: &'static dyn Law,
}

/// The time or frequency that goes with a coefficient.
pub(crate) struct Shape {
    /// Within the table of the term.
    pub(crate) key: &'static str,
    /// As tables of coefficients have it.
    pub(crate) symbol: &'static str,
    pub(crate) unit: &'static str,
    /// For people, and where it is not clear of which term it is.
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    /// What an impossible one is one of.
    pub(crate) what: &'static str,
    /// The letters of coefficient and shape in the legend of a chart.
    pub(crate) letters: [&'static str; 2],
    /// Shortest and longest that a curve from the first to the second τ can tell.
    pub(crate) range: fn([f64; 2]) -> [f64; 2],
    /// Points of a search for each factor of ten.
    pub(crate) per_decade: f64,
}

/// How a sampled part is made: a generator of the kernel, with angles in ″ and times in samples. A part may need several.
pub(crate) enum Source {
    /// Independent errors of all angles, of this standard deviation.
    Errors(f64),
    /// Independent increments of the angle, of this standard deviation.
    White(f64),
    /// Rates that are held for 1, 2, 4, … samples, of these standard deviations.
    Holds(Vec<f64>),
    /// A random walk of the rate with steps of this standard deviation.
    Walk(f64),
    /// r_k = e^{−decay}·r_{k−1} + …, of this stationary standard deviation; a record has at most one.
    Markov { sigma: f64, decay: f64 },
    /// A sine of the angle, of so many turns in a sample; a record has at most one.
    Sine { amplitude: f64, turns: f64 },
    /// The angle ½ · this · k².
    Ramp(f64),
    /// The angle reach·(1 − e^{−decay·k}).
    Decay { reach: f64, decay: f64 },
}

/// What a part adds to the angle between two samples.
pub(crate) enum Increment {
    /// A normal number of this variance, ″².
    Normal(f64),
    /// A sine of a random phase with this peak, ″.
    Sine(f64),
    /// No closed form is known.
    Other,
}

/// Second differences, m apart about the lag n ≥ 0, of the generalised covariance of an angle, ″², less a constant: see
/// [`generalised`](crate::theory::allan::generalised).
pub(crate) type Kernel = Box<dyn Fn(f64, f64) -> f64>;

/// Two differences of angles, over `a` and `b` samples, of which the second starts `lag` after the first, or anywhere in
/// `width` lags around that.
pub(crate) struct Apart {
    pub(crate) difference: Difference,
    pub(crate) sample_s: f64,
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) lag: f64,
    pub(crate) width: f64,
}

/// The closed forms of a term, for a part of it.
pub(crate) trait Law: Sync {
    /// The part with this coefficient and shape; `octaves` are those of flicker.
    fn part(&self, term: Term, coefficient: f64, shape: f64, _octaves: usize) -> Part {
        Part::new(term, coefficient, shape)
    }

    /// Square of the coefficient of a part.
    fn square(&self, part: &Part) -> f64 {
        part.size * part.size
    }

    /// Variance of a difference of angles `m` samples apart, ″²: as [`Part::variance`].
    fn variance(&self, _part: &Part, _difference: Difference, _sample_s: f64, _m: u64) -> f64 {
        0.0
    }

    /// The difference that is the same in every record: as [`Part::trend`].
    fn trend(&self, _part: &Part, _difference: Difference, _sample_s: f64, _m: u64) -> Option<Trend> {
        None
    }

    /// Largest |difference| of a part that is not noise: as [`Part::largest`].
    fn largest(&self, part: &Part, difference: Difference, sample_s: f64, m: u64) -> f64 {
        self.trend(part, difference, sample_s, m).map_or(0.0, |trend| trend.first.abs())
    }

    /// Allan variance of the continuous noise, (″/s)²; `None` where it depends on the length of the record.
    fn continuous(&self, part: &Part, tau_s: f64) -> Option<f64>;

    /// What gives two differences of noise their covariance; `None` where nothing reaches from one sample to another.
    fn kernel(&self, _part: &Part, _sample_s: f64) -> Option<Kernel> {
        None
    }

    /// Covariance of two differences of noise without kernel; `met` is the product of the coefficients of angles that meet.
    fn covariance(&self, _part: &Part, _met: f64) -> f64 {
        0.0
    }

    /// Product of two differences of what is no noise. A trend that decays is left out: it is not stationary.
    fn product(&self, part: &Part, apart: &Apart) -> f64 {
        let at = |m: f64| self.trend(part, apart.difference, apart.sample_s, m as u64);
        let steady = |m| at(m).filter(|trend| trend.decay == 0.0).map_or(0.0, |trend| trend.first);
        steady(apart.a) * steady(apart.b)
    }

    /// What it adds to the angle over `n` samples.
    fn increment(&self, _part: &Part, _sample_s: f64, _n: u64) -> Increment {
        Increment::Other
    }

    /// How a record of so many samples has it.
    fn sources(&self, part: &Part, sample_s: f64, samples: u64) -> Vec<Source>;

    /// The angle that a coefficient can turn through in a time, ″: 0 of noise of the angle.
    fn turned(&self, coefficient: f64, time_s: f64) -> f64 {
        coefficient.abs() * time_s
    }
}

impl Shape {
    /// A time that a curve tells within its τ, as the humps of its terms are wide.
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

/// Units of the coefficients of rates.
const DEG_PER_H: (f64, &str, &str) = (1.0, "deg/h", "°/h");

impl Term {
    /// The five terms of A(4).
    pub const MODEL: [Term; 5] = [
        Term::Quantisation,
        Term::AngleRandomWalk,
        Term::BiasInstability,
        Term::RateRandomWalk,
        Term::RateRamp,
    ];

    /// As studies and tables name it.
    pub fn symbol(self) -> &'static str {
        self.row().symbol
    }

    /// From ″ and s to the unit of data sheets: the factor, the unit as files have it, and its symbol for people.
    pub fn data_sheet_unit(self) -> (f64, &'static str, &'static str) {
        self.row().unit
    }

    /// The time or frequency of a term that has one.
    pub(crate) fn shape(self) -> Option<&'static Shape> {
        self.row().shape.as_ref()
    }

    /// Whether it has a time or frequency that is fitted too.
    pub fn has_shape(self) -> bool {
        self.shape().is_some()
    }

    /// Parameters that a fit of it takes.
    pub fn parameters(self) -> usize {
        1 + usize::from(self.has_shape())
    }

    /// The part of the angle with the square of the coefficient, its shape, and the octaves for flicker.
    pub fn part(self, square: f64, shape: f64, octaves: usize) -> Part {
        self.of_coefficient(libm::sqrt(square), shape, octaves)
    }

    /// The same with the coefficient itself, which may be negative of what is no noise.
    pub(crate) fn of_coefficient(self, coefficient: f64, shape: f64, octaves: usize) -> Part {
        self.row().law.part(self, coefficient, shape, octaves)
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
