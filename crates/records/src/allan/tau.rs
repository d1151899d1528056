//! The averaging times of a curve.

use crate::allan::Deviation;

/// A list of averaging times.
#[derive(Debug, Clone, PartialEq)]
pub enum Taus {
    /// m = 1, 2, 4, …
    Octave,
    /// This number in each decade, evenly spaced on a logarithmic axis; those that round to the same m count once.
    Decade(u32),
    /// Every m.
    All,
    /// The given times, in s, each rounded to a whole number of samples.
    Seconds(Vec<f64>),
}

/// Most samples for [`Taus::All`], whose work grows with their square; at this limit it takes half a minute.
pub const MAX_FOR_ALL: usize = 200_000;

/// Most samples of all columns together for [`Taus::All`], whose points and charts take less than 1 GiB of memory then.
pub const MAX_OF_COLUMNS: usize = 2_000_000;

/// Why a curve cannot be computed at the requested times.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TauError {
    /// This time, in s, is not a positive number.
    #[error("τ = {0} s is not a time\ngive positive numbers of seconds, as in `tau = 1,10,100`")]
    NoTime(f64),
    /// A time is shorter than a sample.
    #[error(
        "τ = {tau_s} s is shorter than the sampling step of {step_s} s\ngive multiples of the step, or `tau = octave`"
    )]
    Short {
        /// Requested time, s.
        tau_s: f64,
        /// Time from sample to sample, s.
        step_s: f64,
    },
    /// A time is too long for any term.
    #[error(
        "τ = {tau_s} s is too long for a record of {length_s} s: {deviation} needs a record of {} τ, \
         here τ ≤ {longest_s} s\n\
         leave it out, record longer, or give `tau = octave`",
        deviation.largest_factor_of_length()
    )]
    Long {
        /// Requested time, s.
        tau_s: f64,
        /// Length of the record, s.
        length_s: f64,
        /// The longest τ that has a term, s.
        longest_s: f64,
        /// The deviation.
        deviation: Deviation,
    },
    /// The computation would take too long for this number of samples.
    #[error(
        "`tau = all` is for at most {MAX_FOR_ALL} samples, the record has {0}: its work grows with their square\n\
         give `tau = decade20`, whose points are as good as all of them on a chart"
    )]
    TooMany(usize),
    /// The curves of all columns together would take more memory than they may.
    #[error(
        "`tau = all` is for at most {MAX_OF_COLUMNS} samples of all columns together, the log has {0}\n\
         give fewer columns, or `tau = decade20`, whose points are as good as all of them on a chart"
    )]
    TooManyTogether(usize),
}

impl Deviation {
    /// Length of the shortest record with a term, in units of τ.
    fn largest_factor_of_length(self) -> usize {
        if self == Deviation::Adev || self == Deviation::Oadev { 2 } else { 3 }
    }
}

impl Taus {
    /// The averaging factors of a record of `angles` angles every `step_s` seconds, rising, up to the largest one with
    /// a term.
    ///
    /// # Errors
    /// A time of [`Taus::Seconds`] is outside the range of the record, or there are too many samples for [`Taus::All`].
    pub fn factors(&self, angles: usize, step_s: f64, deviation: Deviation) -> Result<Vec<usize>, TauError> {
        let largest = deviation.largest_factor(angles);
        let samples = angles.saturating_sub(1);
        let mut factors: Vec<usize> = match self {
            Taus::Octave => std::iter::successors(Some(1), |m: &usize| m.checked_mul(2))
                .take_while(|&m| m <= largest)
                .collect(),
            Taus::Decade(points) => (0..)
                .map(|i| libm::round(libm::pow(10.0, f64::from(i) / f64::from((*points).max(1)))))
                .take_while(|&m| m <= largest as f64)
                .map(|m| m as usize)
                .collect(),
            Taus::All if samples > MAX_FOR_ALL => return Err(TauError::TooMany(samples)),
            Taus::All => (1..=largest).collect(),
            Taus::Seconds(taus) => taus
                .iter()
                .map(|&tau_s| factor(tau_s, samples, step_s, deviation))
                .collect::<Result<_, _>>()?,
        };
        factors.sort_unstable();
        factors.dedup();
        Ok(factors)
    }
}

fn factor(tau_s: f64, samples: usize, step_s: f64, deviation: Deviation) -> Result<usize, TauError> {
    if !(tau_s > 0.0 && tau_s.is_finite()) {
        return Err(TauError::NoTime(tau_s));
    }
    let m = libm::round(tau_s / step_s);
    let largest = deviation.largest_factor(samples + 1);
    if m < 1.0 {
        Err(TauError::Short { tau_s, step_s })
    } else if m > largest as f64 {
        let [length_s, longest_s] = [samples, largest].map(|count| count as f64 * step_s);
        Err(TauError::Long { tau_s, length_s, longest_s, deviation })
    } else {
        Ok(m as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factors(taus: Taus, samples: usize, deviation: Deviation) -> Vec<usize> {
        taus.factors(samples + 1, 1.0, deviation).unwrap()
    }

    #[test]
    fn lists_end_at_half_of_the_record_for_allan_and_at_a_third_for_hadamard() {
        assert_eq!(factors(Taus::Octave, 64, Deviation::Oadev), [1, 2, 4, 8, 16, 32]);
        assert_eq!(factors(Taus::Octave, 63, Deviation::Oadev), [1, 2, 4, 8, 16]);
        assert_eq!(factors(Taus::All, 12, Deviation::Ohdev), [1, 2, 3, 4]);
        assert_eq!(factors(Taus::Decade(10), 40, Deviation::Adev), [1, 2, 3, 4, 5, 6, 8, 10, 13, 16, 20]);
        assert_eq!(factors(Taus::Seconds(vec![20.0, 2.4, 2.0]), 40, Deviation::Adev), [2, 20]);
    }

    #[test]
    fn times_that_the_record_cannot_have_are_refused_with_what_it_can() {
        let error = |tau: f64, deviation| {
            let error = Taus::Seconds(vec![tau]).factors(101, 0.5, deviation).unwrap_err();
            error.to_string()
        };
        for (deviation, tau, longest, needs) in
            [(Deviation::Oadev, 25.5, 25.0, "2 τ"), (Deviation::Hdev, 17.0, 16.5, "3 τ")]
        {
            let said = error(tau, deviation);
            assert!(said.contains(&format!("τ ≤ {longest} s")) && said.contains(needs), "{said}");
        }
        assert!(error(0.2, Deviation::Oadev).contains("sampling step of 0.5 s"));
        assert!(error(-1.0, Deviation::Oadev).contains("is not a time"));
        let many = Taus::All.factors(MAX_FOR_ALL + 2, 1.0, Deviation::Oadev).unwrap_err();
        assert!(many.to_string().contains("decade20"), "{many}");
    }
}
