//! What ends a run early, and the share of a study that it samples.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::time::{Duration, Instant};

use crate::progress::leave;
use sagnac::tally::Share;
#[cfg(unix)]
use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};

/// Other systems have no such signals; an interruption ends the program at once, and completed work is kept.
#[cfg(not(unix))]
const SIGINT: i32 = 2;
#[cfg(not(unix))]
const SIGTERM: i32 = 15;
#[cfg(not(unix))]
const SIGUSR1: i32 = 10;

/// Why a run ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// A signal with its number.
    Signal(i32),
    TimeLimit,
}

impl Cause {
    /// The exit code: 130 for SIGINT, 143 for SIGTERM; 4 for SIGUSR1 and the time limit, after which the run is to
    /// continue.
    pub fn code(self) -> u8 {
        match self {
            Cause::Signal(signal) if signal != SIGUSR1 => 128_u8.wrapping_add(signal as u8),
            Cause::Signal(_) | Cause::TimeLimit => 4,
        }
    }
}

impl std::fmt::Display for Cause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match *self {
            Cause::TimeLimit => "the time limit",
            Cause::Signal(SIGINT) => "SIGINT",
            Cause::Signal(SIGTERM) => "SIGTERM",
            Cause::Signal(SIGUSR1) => "SIGUSR1",
            Cause::Signal(_) => "a signal",
        })
    }
}

/// Receives signals and watches the time limit. While the program [samples](Stop::sampling), a first signal ends it
/// after the current batch, and a second one at once. At other times, when everything not yet on disk can be
/// recomputed, the first one ends it at once.
#[derive(Debug, Clone)]
pub struct Stop {
    signal: Arc<AtomicI32>,
    sampling: Arc<AtomicBool>,
    deadline: Option<Instant>,
}

impl Stop {
    /// Starts listening; the time `limit` counts from now.
    ///
    /// # Errors
    /// The system refuses to register a handler.
    pub fn listen(limit: Option<Duration>) -> std::io::Result<Stop> {
        let deadline = limit.and_then(|limit| Instant::now().checked_add(limit));
        let stop = Stop {
            signal: Arc::new(AtomicI32::new(0)),
            sampling: Arc::new(AtomicBool::new(false)),
            deadline,
        };
        #[cfg(unix)]
        stop.hear()?;
        Ok(stop)
    }

    #[cfg(unix)]
    fn hear(&self) -> std::io::Result<()> {
        let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGUSR1])?;
        let stop = self.clone();
        std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
            for signal in signals.forever() {
                let first = stop.signal.swap(signal, Ordering::SeqCst) == 0;
                let cause = Cause::Signal(signal);
                if first && stop.sampling.load(Ordering::SeqCst) {
                    say!("{cause}: stopping after this batch; a second signal leaves at once");
                    continue;
                }
                leave();
                say!("stopped by {cause}; completed work is kept; resumable: run again to continue");
                signal_hook::low_level::exit(cause.code().into());
            }
        })?;
        Ok(())
    }

    /// The cause to stop, if there is one.
    pub fn cause(&self) -> Option<Cause> {
        match self.signal.load(Ordering::SeqCst) {
            0 if self.deadline.is_some_and(|deadline| Instant::now() >= deadline) => Some(Cause::TimeLimit),
            0 => None,
            signal => Some(Cause::Signal(signal)),
        }
    }

    /// Does work that stops by itself when there is a cause.
    pub fn sampling<T>(&self, work: impl FnOnce() -> T) -> T {
        self.sampling.store(true, Ordering::SeqCst);
        let done = work();
        self.sampling.store(false, Ordering::SeqCst);
        done
    }
}

/// The value of `--shard`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shard {
    Given(Share),
    /// The share of this task of a Slurm job array.
    Slurm,
}

/// Reads `I/N` or `slurm`.
pub fn parse(text: &str) -> Result<Shard, String> {
    match text {
        "slurm" => Ok(Shard::Slurm),
        text => text
            .parse()
            .map(Shard::Given)
            .map_err(|error| format!("{error}; or slurm, for the task of a job array")),
    }
}

impl Shard {
    /// The selected share.
    ///
    /// # Errors
    /// The variables of a job array are missing, or its task numbers are not evenly spaced.
    pub fn share(self, variable: impl Fn(&str) -> Option<String>) -> Result<Share, String> {
        match self {
            Shard::Given(share) => Ok(share),
            Shard::Slurm => of_array(variable),
        }
    }
}

/// The share of a task by its place in the array.
fn of_array(variable: impl Fn(&str) -> Option<String>) -> Result<Share, String> {
    const HELP: &str = "start it by `sbatch --array=1-N`, or give --shard I/N";
    let number = |name: &str| -> Result<u64, String> {
        let text = variable(name).ok_or_else(|| format!("--shard slurm: {name} is not set\n{HELP}"))?;
        text.parse().map_err(|_| format!("--shard slurm: {name} is `{text}`, not a number\n{HELP}"))
    };
    let task = number("SLURM_ARRAY_TASK_ID")?;
    let [least, most, count] =
        [number("SLURM_ARRAY_TASK_MIN")?, number("SLURM_ARRAY_TASK_MAX")?, number("SLURM_ARRAY_TASK_COUNT")?];
    let step = variable("SLURM_ARRAY_TASK_STEP").and_then(|step| step.parse().ok()).unwrap_or(1).max(1);
    let place = task.checked_sub(least).filter(|past| past % step == 0).map(|past| past / step);
    let even =
        (count.saturating_sub(1)).checked_mul(step).and_then(|span| least.checked_add(span)) == Some(most);
    // An array that begins later repeats some tasks of a larger one.
    let whole = even && least <= 1;
    place.filter(|_| whole).and_then(|place| Share::new(place + 1, count)).ok_or_else(|| {
        format!(
            "--shard slurm: task {task} of an array of {count} from {least} to {most} is not a share of the whole\n\
             number the tasks evenly, --array=1-N; to repeat some of them give --shard I/N"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(task: &str, least: &str, most: &str, count: &str, step: &str) -> Result<Share, String> {
        let all = [("ID", task), ("MIN", least), ("MAX", most), ("COUNT", count), ("STEP", step)];
        of_array(|name| {
            let value = all.iter().find(|(end, _)| name == format!("SLURM_ARRAY_TASK_{end}"))?.1;
            (!value.is_empty()).then(|| value.to_owned())
        })
    }

    #[test]
    fn tasks_of_even_arrays_are_shares() {
        assert_eq!(array("1", "1", "4", "4", "1"), Ok(Share::new(1, 4).unwrap()));
        assert_eq!(array("0", "0", "63", "64", ""), Ok(Share::new(1, 64).unwrap()));
        assert_eq!(array("1", "1", "1", "1", "1"), Ok(Share::WHOLE));
        assert_eq!(array("9", "1", "13", "4", "4"), Ok(Share::new(3, 4).unwrap()));
    }

    #[test]
    fn what_is_no_share_of_the_whole_is_refused() {
        // The array 1,3,7; a task between its tasks; one beyond; missing variables, and variables that are not numbers.
        for (task, least, most, count, step, piece) in [
            ("3", "1", "7", "3", "1", "number the tasks evenly"),
            ("2", "1", "13", "4", "4", "number the tasks evenly"),
            ("5", "1", "4", "4", "1", "number the tasks evenly"),
            ("17", "17", "17", "1", "1", "to repeat some of them give --shard I/N"),
            ("2", "2", "3", "2", "1", "to repeat some of them give --shard I/N"),
            ("1", "", "4", "4", "1", "SLURM_ARRAY_TASK_MIN is not set"),
            ("one", "1", "4", "4", "1", "is `one`, not a number"),
            ("1", "1", "18446744073709551615", "18446744073709551615", "3", "number the tasks evenly"),
        ] {
            let error = array(task, least, most, count, step).unwrap_err();
            assert!(error.contains(piece), "{error}");
        }
    }
}
