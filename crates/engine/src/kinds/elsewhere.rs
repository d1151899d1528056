//! A study at other points than its own.

use toml::{Spanned, Table, Value};

use crate::key::common::Streams;
use crate::key::row::Key;
use crate::key::scale::Scale;
use crate::key::setting::Swept;
use crate::key::sweep::Sweep;
use crate::study::Study;
use sagnac_base::source::diagnose::StudyError;

impl Study {
    /// The same study at the given points instead of its own: each has a value for each of the `keys`, which a sweep may
    /// vary, and all other inputs are as written. All points share their random numbers, so that their differences are
    /// those of the inputs. There are no charts, and no precision at which points stop.
    ///
    /// # Errors
    /// A value is outside the limits of its key, or a point is not a valid one; the error points at the key.
    pub fn at_points(&self, keys: &[&'static Key], points: &[Vec<Swept>]) -> Result<Study, StudyError> {
        let sweeps = keys.iter().enumerate().map(|(at, key)| self.joined(key, points, at));
        let sweeps = sweeps.collect::<Result<Vec<Sweep>, StudyError>>()?;
        let mut study = Study::check(&self.text, Some(sweeps)).map_err(|wrong| wrong.within(&self.text))?;
        (study.seed, study.trials, study.streams) = (self.seed, self.trials, Streams::Common);
        study.precision = None;
        Ok(study)
    }

    /// The study with other fillers: `edit` changes the entries of `switching.fillers`. Its text is written anew, without
    /// comments.
    ///
    /// # Errors
    /// A filler is not a valid one.
    pub fn with_fillers(&self, edit: impl FnOnce(&mut Vec<Value>)) -> Result<Study, StudyError> {
        // The text is that of a valid study.
        let mut root: Table = self.text.inner().parse().unwrap_or_default();
        let fillers = root.get_mut("switching").and_then(|table| table.get_mut("fillers"));
        if let Some(Value::Array(fillers)) = fillers {
            edit(fillers);
        }
        let text = toml::to_string(&root).unwrap_or_default();
        let study = Study::parse(self.text.name(), &text)?;
        let (seed, trials, streams) = (self.seed, self.trials, self.streams);
        Ok(Study { seed, trials, streams, precision: self.precision, ..study })
    }

    /// The values of one key at some points as a sweep.
    fn joined(&self, key: &'static Key, points: &[Vec<Swept>], at: usize) -> Result<Sweep, StudyError> {
        let span = self.place_of(key.name);
        let values: Vec<Swept> = points.iter().map(|point| point[at].clone()).collect();
        let outside = values.iter().filter_map(Swept::quantity).find(|value| !key.admits(value.value));
        if let Some(value) = outside {
            let message = format!("{} = {value} is out of range", key.name);
            return Err(self.error_at(span, message, format!("accepted: {}", key.range())));
        }
        let own = self.sweeps.iter().find(|sweep| std::ptr::eq(sweep.key, key));
        let file = |value: &Swept| {
            own.and_then(|own| {
                Some(own.files.get(own.values.iter().position(|known| known == value)?)?.clone())
            })
        };
        let files: Vec<Spanned<String>> = values.iter().filter_map(file).collect();
        let key_span = span.clone();
        Ok(Sweep { key, values, files, scale: Scale::Linear, key_span, span, is_joined: true })
    }
}

#[cfg(test)]
mod tests {
    use crate::key::setting::Swept;
    use crate::kinds::gap_fill::GapFill;
    use crate::study::Study;
    use sagnac_base::quantity::units::{Dimension, Quantity};

    #[test]
    fn points_have_the_values_given_and_all_others_as_written() {
        let study = Study::parse("s.toml", include_str!("../../../../studies/error_vs_dtnu.toml")).unwrap();
        let keys = [study.sweeps[0].key, study.sweeps[1].key];
        let frequency = |hz: f64| Swept::Quantity(Quantity::new(hz, Dimension::Frequency));
        let gap = |n: f64| Swept::Quantity(Quantity::new(n, Dimension::Count));
        let value =
            |key: usize, at: f64| if study.sweeps[key].key.is_whole() { gap(at) } else { frequency(at) };
        let points = [vec![value(0, 3.0), value(1, 5.0)], vec![value(0, 2.0), value(1, 4.0)]];
        let there = study.at_points(&keys, &points).unwrap();
        let asked = there.asked::<GapFill>().unwrap();
        assert_eq!((asked.points.len(), there.charts.len()), (2, 0));
        assert_eq!(asked.points[1].swept[0].1, points[1][0]);
        assert_eq!(asked.points[1].inputs.tick_s, study.asked::<GapFill>().unwrap().points[0].inputs.tick_s);
        let error = study.at_points(&keys, &[vec![value(0, -1.0), value(1, -1.0)]]).unwrap_err();
        assert!(error.render(false, 100).contains("is out of range"), "{error:?}");
    }
}
