//! Axes and their ticks, which are at whole numbers for counts and names, and at parts of a turn for phases.

use crate::chart::figure::Axis;
use crate::chart::layout::MAX_LABELS;
use crate::chart::scale::Scale;
use crate::chart::scale::{Range, extent};
use crate::chart::ticks::{Ladder, Steps, Ticks};
use sagnac_base::table::Unit;

/// Number of whole numbers that all get a label.
const FEW: f64 = 12.0;

impl Axis {
    /// The range of the axis that shows `values`, with a margin. An axis that counts does not extend to 0 merely
    /// because 0 is near.
    pub fn around(&self, values: impl IntoIterator<Item = f64>) -> Range {
        let values: Vec<f64> = values.into_iter().filter(|&value| self.scale.shows(value)).collect();
        if !self.names.is_empty() {
            return Range { scale: self.scale, low: 0.5, high: self.names.len() as f64 + 0.5 };
        }
        match extent(values.iter().copied()) {
            Some((low, high)) if self.whole && self.scale == Scale::Linear && 0.0 < low && low < high => {
                let margin = 0.05 * (high - low);
                Range { scale: self.scale, low: (low - margin).max(0.0), high: high + margin }
            }
            _ => Range::around(self.scale, values),
        }
    }

    /// The ticks in a range of the axis.
    pub fn ticks(&self, range: Range) -> Ticks {
        if !self.names.is_empty() {
            let major = (1..).zip(&self.names).map(|(place, name)| (f64::from(place), name.clone()));
            return Ticks { major: major.collect(), minor: vec![] };
        }
        let mut ticks = range.ticks(MAX_LABELS, self.steps());
        if !self.whole {
            return ticks;
        }
        let [first, last] = [libm::ceil(range.low), libm::floor(range.high)];
        if (1.0..FEW).contains(&(last - first)) {
            let all = (first as i64..=last as i64).map(|count| (count as f64, count.to_string()));
            return Ticks { major: all.collect(), minor: vec![] };
        }
        ticks.keep_whole();
        ticks
    }

    /// All ticks that parts of a range and its surroundings may have.
    pub fn ladder(&self, range: Range) -> Ladder {
        range.ladder(self.whole, self.steps())
    }

    /// The distances between even ticks.
    fn steps(&self) -> Steps {
        match self.times {
            true => Steps::Time,
            false if self.unit == Unit::DEG.symbol => Steps::Phase,
            false => Steps::Decimal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Labels, and the ticks without one, of an axis around these values.
    fn ticks(scale: Scale, whole: bool, values: &[f64]) -> (Vec<String>, Vec<f64>) {
        let axis = Axis { scale, whole, ..Axis::default() };
        let ticks = axis.ticks(axis.around(values.iter().copied()));
        (ticks.major.into_iter().map(|(_, label)| label).collect(), ticks.minor)
    }

    #[test]
    fn few_counts_have_a_label_each_and_no_tick_between_them() {
        for scale in [Scale::Linear, Scale::Log] {
            assert_eq!(ticks(scale, true, &[1.0, 2.0, 3.0]).0, ["1", "2", "3"], "{scale:?}");
            let (labels, minor) = ticks(scale, true, &[1.0, 2.0, 5.0, 10.0]);
            assert_eq!(
                (labels.len(), labels[9].as_str(), minor.len()),
                (10, "10", 0),
                "{scale:?} {labels:?}"
            );
        }
    }

    #[test]
    fn many_counts_have_ticks_at_whole_numbers() {
        for scale in [Scale::Linear, Scale::Log] {
            for high in [16.0, 23.0, 64.0, 5000.0] {
                let (labels, minor) = ticks(scale, true, &[1.0, high]);
                assert!(labels.len() >= 3 && labels.iter().all(|label| !label.contains('.')), "{labels:?}");
                assert!(minor.iter().all(|value| value.fract() == 0.0), "{scale:?} {high}: {minor:?}");
            }
        }
        assert_eq!(ticks(Scale::Linear, false, &[1.0, 3.0]).0, ["1.0", "1.5", "2.0", "2.5", "3.0"]);
        assert!(ticks(Scale::Linear, true, &[7.0]).0.contains(&"7".to_owned()));
    }
}
