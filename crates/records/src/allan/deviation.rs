//! The six deviations and their properties.

use std::fmt;
use std::str::FromStr;

use sagnac_base::names;
use sagnac_theory::allan::{Difference, Estimator, Stride};

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
        }
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
        self == Deviation::Tdev
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
        match self.is_modified() {
            true => m.saturating_mul(self.differences() + 1),
            false => m.saturating_mul(self.differences()).saturating_add(1),
        }
    }

    /// The largest averaging factor at which `angles` angles give a term; 0 where none does.
    pub fn largest_factor(self, angles: usize) -> usize {
        match self.is_modified() {
            true => angles / (self.differences() + 1),
            false => angles.saturating_sub(1) / self.differences(),
        }
    }

    /// The number of terms at `m` over `angles` angles without a gap.
    pub fn terms(self, angles: usize, m: usize) -> usize {
        match (angles + 1).checked_sub(self.span(m)) {
            None | Some(0) => 0,
            Some(starts) if self.overlaps() => starts,
            Some(starts) => (starts - 1) / m + 1,
        }
    }
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
}
