//! `--shard`: which share of a study this machine runs.

use sagnac::tally::Share;

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
