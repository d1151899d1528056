//! The deviations and their properties, the units of their curves, and the averaging times of a curve.

use std::fmt;
use std::str::FromStr;

use sagnac_base::names;
use sagnac_theory::allan::{Difference, Estimator, Stride};

use crate::allan::theo;

names! {
    /// A deviation of a record of angles, which determines differences and averages. Their order is that of
    /// `--deviation`.
    pub enum Deviation {
        /// Allan deviation of adjacent groups, in the unit of the rate.
        Adev = "adev",
        /// Overlapping Allan deviation: the same, over groups that start at every sample.
        Oadev = "oadev",
        /// Modified Allan deviation: second differences of angles averaged over τ.
        Mdev = "mdev",
        /// Time deviation: τ/√3 times the modified Allan deviation, in the unit of the angle.
        Tdev = "tdev",
        /// Hadamard deviation of adjacent groups: third differences, which are free of a linear drift of the rate.
        Hdev = "hdev",
        /// Overlapping Hadamard deviation.
        Ohdev = "ohdev",
        /// Total deviation: the overlapping Allan deviation of the record extended by its reflections.
        Totdev = "totdev",
        /// Modified total deviation: the same for the modified Allan deviation.
        Mtotdev = "mtotdev",
        /// Theo1, of averaging times up to three quarters of the record.
        Theo1 = "theo1",
        /// ThêoH: the overlapping Allan deviation, and from a fifth of the record on Theo1 without its bias.
        Theoh = "theoh",
        /// Parabolic deviation: differences of the rates of straight lines through the angles.
        Pdev = "pdev",
        /// MTIE: the greatest range of the angle about the mean rate within a time, in the unit of the angle.
        Mtie = "mtie",
    }
}

impl Deviation {
    /// Name for the user.
    pub fn title(self) -> &'static str {
        match self {
            Deviation::Adev => "Allan deviation",
            Deviation::Oadev => "overlapping Allan deviation",
            Deviation::Mdev => "modified Allan deviation",
            Deviation::Tdev => "time deviation",
            Deviation::Hdev => "Hadamard deviation",
            Deviation::Ohdev => "overlapping Hadamard deviation",
            Deviation::Totdev => "total deviation",
            Deviation::Mtotdev => "modified total deviation",
            Deviation::Theo1 => "Theo1 deviation",
            Deviation::Theoh => "ThêoH deviation",
            Deviation::Pdev => "parabolic deviation",
            Deviation::Mtie => "MTIE",
        }
    }

    /// Whether it is a mean square of finite differences of angles, or of their means, for which closed forms are known.
    pub fn is_of_differences(self) -> bool {
        self as usize <= Deviation::Ohdev as usize
    }

    /// Order of the differences of angles: d of Greenhall and Riley.
    pub fn differences(self) -> usize {
        if matches!(self, Deviation::Hdev | Deviation::Ohdev) { 3 } else { 2 }
    }

    /// Whether the angles are averaged over τ before they are differenced.
    pub fn is_modified(self) -> bool {
        matches!(self, Deviation::Mdev | Deviation::Tdev)
    }

    /// Whether terms start at every sample instead of only at the end of the first group of the term before.
    pub fn overlaps(self) -> bool {
        !matches!(self, Deviation::Adev | Deviation::Hdev)
    }

    /// Whether it is in the unit of the angle instead of the rate.
    pub fn is_of_angle(self) -> bool {
        matches!(self, Deviation::Tdev | Deviation::Mtie)
    }

    /// The differences of angles and their distance; a modified deviation averages the angles too.
    pub fn estimator(self) -> Estimator {
        Estimator {
            difference: if self.differences() == 2 { Difference::Second } else { Difference::Third },
            stride: if self.overlaps() { Stride::Sample } else { Stride::Cluster },
        }
    }

    /// Number of angles spanned by one term at the averaging factor `m`.
    pub fn span(self, m: usize) -> usize {
        match self {
            Deviation::Mtotdev => m.saturating_mul(3),
            Deviation::Theo1 | Deviation::Mtie => m.saturating_add(1),
            Deviation::Pdev if m > 1 => m.saturating_mul(2).saturating_add(1),
            _ if self.is_modified() => m.saturating_mul(self.differences() + 1),
            _ => m.saturating_mul(self.differences()).saturating_add(1),
        }
    }

    /// The averaging time of the factor `m`, in samples.
    pub fn tau(self, m: usize) -> f64 {
        if self == Deviation::Theo1 { 0.75 * m as f64 } else { m as f64 }
    }

    /// The largest averaging factor at which `angles` angles give a term; 0 where none does.
    pub fn largest_factor(self, angles: usize) -> usize {
        let samples = angles.saturating_sub(1);
        match self {
            Deviation::Theo1 if samples < theo::SHORTEST => 0,
            Deviation::Theo1 => samples / 2 * 2,
            Deviation::Theoh if samples >= SHORTEST_OF_THEOH => samples / 4 * 3,
            Deviation::Mtotdev => angles / 3,
            Deviation::Mtie => samples,
            _ if self.is_modified() => angles / (self.differences() + 1),
            _ => samples / self.differences(),
        }
    }

    /// The number of terms at `m` over `angles` angles without a gap.
    pub fn terms(self, angles: usize, m: usize) -> usize {
        if m == 0 || m > self.largest_factor(angles) {
            return 0;
        }
        match self {
            Deviation::Totdev => angles - 2,
            Deviation::Theo1 => (angles - m) * (m / 2),
            Deviation::Theoh => {
                let (deviation, m) = self.at(m, angles);
                deviation.terms(angles, m)
            }
            _ if self.overlaps() => angles + 1 - self.span(m),
            _ => (angles - self.span(m)) / m + 1,
        }
    }

    /// Whether its work at one τ grows with τ.
    fn grows_with_tau(self) -> bool {
        matches!(self, Deviation::Mtotdev | Deviation::Theo1 | Deviation::Theoh)
    }

    /// The factor that takes the place of `m`, where not all have a value.
    fn nearest(self, m: usize, angles: usize) -> Option<usize> {
        match self {
            Deviation::Theo1 => (m >= theo::SHORTEST).then_some(m / 2 * 2),
            Deviation::Theoh if !is_allan(m, angles) => Some(m / 3 * 3),
            _ => Some(m),
        }
    }

    /// The deviation that ThêoH is at the averaging time of `m` samples, and its factor; any other one is itself.
    pub(crate) fn at(self, m: usize, angles: usize) -> (Deviation, usize) {
        match self {
            Deviation::Theoh if is_allan(m, angles) => (Deviation::Oadev, m),
            Deviation::Theoh => (Deviation::Theo1, m / 3 * 4),
            _ => (self, m),
        }
    }

    /// Number that a sum of squares is divided by to give the variance, or for MTIE its square.
    pub(crate) fn divisor(self, terms: u64, tau_s: f64) -> f64 {
        let times = match self {
            Deviation::Mtie => return 1.0,
            // The sum over (m τ₀)² is 0.75 times the variance, and τ is 0.75 m τ₀.
            Deviation::Theo1 => 4.0 / 3.0,
            _ if self.differences() == 2 => 2.0,
            _ => 6.0,
        };
        times * terms as f64 * tau_s * tau_s
    }
}

/// Part of the record up to which ThêoH is the Allan deviation, and the samples of the shortest record in which it goes further.
const MAX_OF_ALLAN: usize = 5;
const SHORTEST_OF_THEOH: usize = 50;

fn is_allan(m: usize, angles: usize) -> bool {
    let samples = angles.saturating_sub(1);
    samples < SHORTEST_OF_THEOH || m <= samples / MAX_OF_ALLAN
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Deviation {
    type Err = UnknownDeviation;

    fn from_str(name: &str) -> Result<Deviation, UnknownDeviation> {
        let found = Deviation::ALL.into_iter().find(|deviation| deviation.name() == name);
        found.ok_or_else(|| UnknownDeviation { name: name.to_owned() })
    }
}

/// The error for an unknown name of a deviation.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{name}` is not a deviation; the deviations are {}", Deviation::ALL.map(Deviation::name).join(", "))]
pub struct UnknownDeviation {
    name: String,
}

/// The unit of the curves of a record, which follows from what the sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// °/h and ″, of rotation.
    Angular,
    /// µg and µg·s, of acceleration.
    Acceleration,
    /// The unknown unit of plain numbers.
    Plain,
}

impl Unit {
    /// All units, in the order of results.
    pub const ALL: [Unit; 3] = [Unit::Angular, Unit::Acceleration, Unit::Plain];

    /// Unit in files, such as `deg/h`; empty for plain numbers.
    pub fn in_files(self, deviation: Deviation) -> &'static str {
        match (self, deviation.is_of_angle()) {
            (Unit::Angular, false) => "deg/h",
            (Unit::Angular, true) => "arcsec",
            (Unit::Acceleration, false) => "ug",
            (Unit::Acceleration, true) => "ug*s",
            (Unit::Plain, _) => "",
        }
    }

    /// Unit for the user.
    pub fn symbol(self, deviation: Deviation) -> &'static str {
        match self.in_files(deviation) {
            "deg/h" => "°/h",
            "arcsec" => "″",
            "ug" => "µg",
            "ug*s" => "µg·s",
            other => other,
        }
    }

    /// What a sample measures, in a sentence. Plain numbers are taken for rates.
    pub fn measured(self) -> &'static str {
        if self == Unit::Acceleration { "acceleration" } else { "rate" }
    }

    /// What records of this unit have, in a sentence.
    pub fn content(self) -> &'static str {
        match self {
            Unit::Angular => "angular rates",
            Unit::Acceleration => "accelerations",
            Unit::Plain => "plain numbers",
        }
    }
}

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

/// Most samples for [`Taus::All`] of modified total, Theo1 and ThêoH deviations, whose work grows with their cube.
const MAX_FOR_ALL_OF_CUBE: usize = 5000;

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
    /// A time is too short for Theo1.
    #[error(
        "τ = {tau_s} s is too short for {}: here τ ≥ {shortest_s} s\ngive `theoh`, which has all times, or leave it out",
        Deviation::Theo1
    )]
    ShortOfTheo1 {
        /// Requested time, s.
        tau_s: f64,
        /// The shortest τ, s.
        shortest_s: f64,
    },
    /// The computation would take too long for this number of samples.
    #[error(
        "`tau = all` is for at most {MAX_FOR_ALL} samples, the record has {0}: its work grows with their square\n\
         give `tau = decade20`, whose points are as good as all of them on a chart"
    )]
    TooMany(usize),
    /// The record is too long for all averaging times of a deviation whose work at one τ grows with τ.
    #[error(
        "`tau = all` of {deviation} is for at most {MAX_FOR_ALL_OF_CUBE} samples, the record has {samples}: its work grows with \
         their cube\ngive `tau = decade20`"
    )]
    TooManyOfCube {
        /// Number of samples.
        samples: usize,
        /// The deviation.
        deviation: Deviation,
    },
    /// The curves of all columns together would take more memory than they may.
    #[error(
        "`tau = all` is for at most {MAX_OF_COLUMNS} samples of all columns together, the log has {0}\n\
         give fewer columns, or `tau = decade20`, whose points are as good as all of them on a chart"
    )]
    TooManyTogether(usize),
}

impl Deviation {
    /// Length of the shortest record with a term, in units of τ.
    fn largest_factor_of_length(self) -> &'static str {
        match self {
            Deviation::Adev | Deviation::Oadev | Deviation::Totdev | Deviation::Pdev => "2",
            Deviation::Theo1 | Deviation::Theoh => "4/3",
            Deviation::Mtie => "1",
            Deviation::Mdev | Deviation::Tdev | Deviation::Hdev | Deviation::Ohdev | Deviation::Mtotdev => {
                "3"
            }
        }
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
        let factors: Vec<usize> = match self {
            Taus::Octave => std::iter::successors(Some(1), |m: &usize| m.checked_mul(2))
                .take_while(|&m| m <= largest)
                .collect(),
            Taus::Decade(points) => (0..)
                .map(|i| libm::round(libm::pow(10.0, f64::from(i) / f64::from((*points).max(1)))))
                .take_while(|&m| m <= largest as f64)
                .map(|m| m as usize)
                .collect(),
            Taus::All if deviation.grows_with_tau() && samples > MAX_FOR_ALL_OF_CUBE => {
                return Err(TauError::TooManyOfCube { samples, deviation });
            }
            Taus::All if samples > MAX_FOR_ALL => return Err(TauError::TooMany(samples)),
            Taus::All => (1..=largest).collect(),
            Taus::Seconds(taus) => taus
                .iter()
                .map(|&tau_s| factor(tau_s, samples, step_s, deviation))
                .collect::<Result<_, _>>()?,
        };
        let mut factors: Vec<usize> =
            factors.into_iter().filter_map(|m| deviation.nearest(m, angles)).collect();
        factors.sort_unstable();
        factors.dedup();
        Ok(factors)
    }
}

fn factor(tau_s: f64, samples: usize, step_s: f64, deviation: Deviation) -> Result<usize, TauError> {
    if !(tau_s > 0.0 && tau_s.is_finite()) {
        return Err(TauError::NoTime(tau_s));
    }
    // The factors of Theo1 are even.
    let unit = if deviation == Deviation::Theo1 { 2 } else { 1 };
    let m = unit as f64 * libm::round(tau_s / (deviation.tau(unit) * step_s));
    let largest = deviation.largest_factor(samples + 1);
    if m < 1.0 {
        Err(TauError::Short { tau_s, step_s })
    } else if deviation == Deviation::Theo1 && m < theo::SHORTEST as f64 {
        Err(TauError::ShortOfTheo1 { tau_s, shortest_s: deviation.tau(theo::SHORTEST) * step_s })
    } else if m > largest as f64 {
        let [length_s, longest_s] = [samples as f64, deviation.tau(largest)].map(|count| count * step_s);
        Err(TauError::Long { tau_s, length_s, longest_s, deviation })
    } else {
        Ok(m as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_factor_has_a_term_and_the_next_one_none() {
        for deviation in Deviation::ALL {
            for angles in 0..60 {
                let largest = deviation.largest_factor(angles);
                let name = deviation.name();
                assert_eq!(deviation.terms(angles, largest + 1), 0, "{name}, {angles} angles");
                if largest > 0 {
                    assert!(deviation.terms(angles, largest) > 0, "{name}, {angles} angles, m = {largest}");
                }
            }
        }
    }

    #[test]
    fn names_are_read_back_and_others_refused_with_the_list() {
        for deviation in Deviation::ALL {
            assert_eq!(deviation.name().parse(), Ok(deviation));
        }
        let error = "avar".parse::<Deviation>().unwrap_err().to_string();
        assert!(error.contains("`avar`") && error.contains("oadev"), "{error}");
    }

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
        let many = Taus::All.factors(5002, 1.0, Deviation::Theo1).unwrap_err();
        assert!(many.to_string().contains("of theo1 is for at most 5000"), "{many}");
    }

    #[test]
    fn the_factors_of_theo1_are_even_and_those_of_theoh_meet_it() {
        assert_eq!(factors(Taus::Octave, 100, Deviation::Theo1), [16, 32, 64]);
        assert_eq!(factors(Taus::Seconds(vec![7.5, 21.0]), 100, Deviation::Theo1), [10, 28]);
        assert_eq!(factors(Taus::Octave, 100, Deviation::Theoh), [1, 2, 4, 8, 16, 30, 63]);
        let short = Taus::Seconds(vec![3.0]).factors(101, 1.0, Deviation::Theo1).unwrap_err().to_string();
        assert!(short.contains("τ ≥ 7.5 s"), "{short}");
    }
}
