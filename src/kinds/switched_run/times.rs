//! The times at which the angle of a run is wanted.

use toml::Spanned;

use crate::key::scalar::{self, Scalar};
use crate::quantity::units::Dimension;
use crate::source::diagnose::Fault;
use crate::source::place::Places;

/// Most times of a study.
const MOST_TIMES: usize = 100;

/// Times in s, each once.
pub(crate) fn read(
    list: Option<&Spanned<Vec<Spanned<Scalar>>>>,
    places: &mut Places,
) -> Result<Vec<f64>, Fault> {
    let Some(list) = list else { return Ok(vec![]) };
    places.add("run.times", list.span());
    if list.get_ref().len() > MOST_TIMES {
        let message = format!("run.times lists {} times", list.get_ref().len());
        let help = format!("accepted: up to {MOST_TIMES}; trajectories show all of a run");
        return Err(Fault::new(list.span(), message, "too many", help));
    }
    let mut times = Vec::new();
    for given in list.get_ref() {
        let time = scalar::quantity("run.times", given, &[Dimension::Time])?;
        let fault = |message, label, help| Err(Fault::new(given.span(), message, label, help));
        if time.value <= 0.0 {
            return fault(format!("run.times lists {time}"), "not above 0", "give times after the start");
        }
        if times.contains(&time.value) {
            return fault(format!("run.times lists {time} twice"), "listed before", "leave it out here");
        }
        times.push(time.value);
    }
    Ok(times)
}
