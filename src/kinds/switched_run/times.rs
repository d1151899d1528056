//! The times at which the angle of a run is estimated.

use crate::key::given::Given;
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
    let time = |given: Given| match given.quantity()? {
        time if time.value > 0.0 => Ok((time.to_string(), time.value)),
        time => {
            Err(given.fault(format!("run.times lists {time}"), "not above 0", "give times after the start"))
        }
    };
    list.distinct(time, "leave it out here")
}
