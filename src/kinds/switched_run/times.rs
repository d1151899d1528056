//! The times at which the angle of a run is estimated.

use crate::key::reading::Reading;
use crate::kinds::switched_run::TIMES;
use crate::source::diagnose::Fault;

/// Most times of a study.
const MOST_TIMES: usize = 100;

/// Reads the times in s, each once.
pub(crate) fn read(reading: &mut Reading) -> Result<Vec<f64>, Fault> {
    reading.note(&[&TIMES]);
    let Some(list) = reading.get(&TIMES) else { return Ok(vec![]) };
    let items = list.items();
    if items.len() > MOST_TIMES {
        let message = format!("run.times lists {} times", items.len());
        let help = format!("accepted: up to {MOST_TIMES}; trajectories show all of a run");
        return Err(list.fault(message, "too many", help));
    }
    let mut times = Vec::new();
    for given in items {
        let time = given.quantity()?;
        if time.value <= 0.0 {
            let message = format!("run.times lists {time}");
            return Err(given.fault(message, "not above 0", "give times after the start"));
        }
        if times.contains(&time.value) {
            let message = format!("run.times lists {time} twice");
            return Err(given.fault(message, "listed before", "leave it out here"));
        }
        times.push(time.value);
    }
    Ok(times)
}
