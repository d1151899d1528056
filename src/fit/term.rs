//! The terms of a fitted curve.

use crate::theory::allan::part::Part;

/// A term, with its reported coefficient. Its Allan variance is proportional to the square of the coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    /// Quantisation noise Q, ″.
    Quantisation,
    /// Angle random walk N, ″/√s.
    AngleRandomWalk,
    /// Bias instability B, ″/s.
    BiasInstability,
    /// Rate random walk K, ″/s^1.5.
    RateRandomWalk,
    /// Rate ramp R, ″/s².
    RateRamp,
    /// Markov noise by the rms σ of its rate, ″/s; its shape is T_c, s. IEEE's q_c is σ√(2/T_c).
    Markov,
    /// Sine by the amplitude Ω_0 of its rate, ″/s; its shape is f, Hz.
    Sine,
}

impl Term {
    /// The five terms of A(4).
    pub const MODEL: [Term; 5] = [
        Term::Quantisation,
        Term::AngleRandomWalk,
        Term::BiasInstability,
        Term::RateRandomWalk,
        Term::RateRamp,
    ];

    /// Every term.
    pub const ALL: [Term; 7] = [
        Term::Quantisation,
        Term::AngleRandomWalk,
        Term::BiasInstability,
        Term::RateRandomWalk,
        Term::RateRamp,
        Term::Markov,
        Term::Sine,
    ];

    /// Name in studies and tables.
    pub fn symbol(self) -> &'static str {
        match self {
            Term::Quantisation => "Q",
            Term::AngleRandomWalk => "N",
            Term::BiasInstability => "B",
            Term::RateRandomWalk => "K",
            Term::RateRamp => "R",
            Term::Markov => "markov",
            Term::Sine => "sine",
        }
    }

    /// The term for a part of a model; `None` for a warm-up.
    pub(crate) fn of(part: &Part) -> Option<Term> {
        match part {
            Part::Quantisation { .. } => Some(Term::Quantisation),
            Part::AngleRandomWalk { .. } => Some(Term::AngleRandomWalk),
            Part::BiasInstability { .. } => Some(Term::BiasInstability),
            Part::RateRandomWalk { .. } => Some(Term::RateRandomWalk),
            Part::RateRamp { .. } => Some(Term::RateRamp),
            Part::Markov { .. } => Some(Term::Markov),
            Part::Sine { .. } => Some(Term::Sine),
            Part::WarmUp { .. } => None,
        }
    }

    /// Conversion from ″ and s to the unit of data sheets: the factor, the unit in files, and its symbol for the user.
    pub fn data_sheet_unit(self) -> (f64, &'static str, &'static str) {
        match self {
            Term::Quantisation => (1.0, "arcsec", "″"),
            Term::AngleRandomWalk => (1.0 / 60.0, "deg/sqrt(h)", "°/√h"),
            Term::RateRandomWalk => (60.0, "deg/h/sqrt(h)", "°/h/√h"),
            Term::RateRamp => (3600.0, "deg/h/h", "°/h/h"),
            Term::BiasInstability | Term::Markov | Term::Sine => (1.0, "deg/h", "°/h"),
        }
    }

    /// Whether a time or frequency is fitted too.
    pub fn has_shape(self) -> bool {
        matches!(self, Term::Markov | Term::Sine)
    }

    /// Number of parameters in a fit.
    pub fn parameters(self) -> usize {
        1 + usize::from(self.has_shape())
    }

    /// The part of the angle for the square of the coefficient, its shape, and the number of octaves of flicker.
    pub fn part(self, square: f64, shape: f64, octaves: usize) -> Part {
        let coefficient = libm::sqrt(square);
        match self {
            Term::Quantisation => Part::Quantisation { q: coefficient },
            Term::AngleRandomWalk => Part::AngleRandomWalk { n: coefficient },
            Term::BiasInstability => Part::BiasInstability { b: coefficient, octaves },
            Term::RateRandomWalk => Part::RateRandomWalk { k: coefficient },
            Term::RateRamp => Part::RateRamp { r: coefficient },
            Term::Markov => Part::Markov { q_c: coefficient * libm::sqrt(2.0 / shape), time_s: shape },
            Term::Sine => Part::Sine { amplitude: coefficient, frequency_hz: shape },
        }
    }

    /// Term, square of the coefficient and shape of a part, which are the arguments of [`Term::part`]; `None` for a
    /// warm-up.
    pub fn of_part(part: &Part) -> Option<(Term, f64, f64)> {
        let plain = |term, coefficient: f64| Some((term, coefficient * coefficient, 1.0));
        match *part {
            Part::Quantisation { q } => plain(Term::Quantisation, q),
            Part::AngleRandomWalk { n } => plain(Term::AngleRandomWalk, n),
            Part::BiasInstability { b, .. } => plain(Term::BiasInstability, b),
            Part::RateRandomWalk { k } => plain(Term::RateRandomWalk, k),
            Part::RateRamp { r } => plain(Term::RateRamp, r),
            Part::Markov { q_c, time_s } => Some((Term::Markov, 0.5 * q_c * q_c * time_s, time_s)),
            Part::Sine { amplitude, frequency_hz } => Some((Term::Sine, amplitude * amplitude, frequency_hz)),
            Part::WarmUp { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_taken_back_to_its_term() {
        for term in Term::ALL {
            let shape = if term.has_shape() { 0.7 } else { 1.0 };
            let (found, square, found_shape) = Term::of_part(&term.part(0.3, shape, 24)).unwrap();
            assert_eq!((found, found_shape), (term, shape));
            assert!((square / 0.3 - 1.0).abs() < 1e-14, "{term:?}: {square}");
        }
        assert_eq!(Term::of_part(&Part::WarmUp { amplitude: 1.0, time_s: 1.0 }), None);
    }
}
