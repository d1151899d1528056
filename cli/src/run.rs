//! `sagnac run`, with the causes that end a run early, and the share of a study that it samples.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use sagnac::device::Device;
use sagnac::run::{Plan, RESOLVED, RunStats, keep};
use sagnac::store::Store;
use sagnac::store::folder::Folder;
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::use_cases::{Sampled, check_places};
use sagnac::view::pictures;
use sagnac_base::quantity::Dimension;
use sagnac_base::quantity::number::{short, significant};
#[cfg(unix)]
use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};

use crate::arg_parsers::value_of;
use crate::failure::Failure;
use crate::output::{print, print_documents};
use crate::program::{DeviceArg, Sampling};
use crate::progress::{How, Planning, Shown, leave};
use crate::reading;
use crate::results::Ran;

const EXAMPLES: &str = "\
Examples:
  sagnac run studies/error_vs_dtnu.toml --plot
  sagnac run my.toml --trials 1000000 --device cpu --progress plain
  sagnac run my.toml --shard 2/4 --time-limit 8:00:00
  sagnac run studies/smoke.toml --json --out results/smoke

A run that is stopped keeps its completed work. Repeating the command resumes it, and a larger --trials adds trials.";

#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Options {
    /// Study files
    #[arg(required = true, value_name = "STUDY")]
    studies: Vec<PathBuf>,
    #[command(flatten)]
    device: DeviceArg,
    /// Results folder [default: results/<name of the study file>, or the own folder of a resolved_study.toml; with
    /// --shard its subfolder shard-I-of-N]
    #[arg(help_heading = "Output", long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Sample only share I of N, which `sagnac merge` combines with the others; slurm takes I and N from the job array
    #[arg(help_heading = "Sampling", long, value_name = "I/N", conflicts_with = "json", value_parser = shard)]
    shard: Option<Shard>,
    /// Stop within this time, such as "55 min" or 8:00:00, with exit code 4; run again to continue
    #[arg(help_heading = "Sampling", long, value_name = "TIME", value_parser = time)]
    time_limit: Option<Duration>,
    #[command(flatten)]
    sampling: Sampling,
}

/// The subfolder of a share.
fn share_folder(share: Share) -> String {
    format!("shard-{}-of-{}", share.number(), share.of())
}

/// The command that merges shares in folders with their default names.
fn merging(folder: &Path, share: Share) -> String {
    let of = share.of();
    match folder.parent().filter(|_| folder.ends_with(share_folder(share))) {
        Some(whole) if whole == Path::new("") => format!("sagnac merge shard-*-of-{of} --out whole"),
        Some(whole) => {
            let whole = whole.display().to_string();
            let is_plain = |c: char| c.is_alphanumeric() || "_./-+,:@%".contains(c);
            let quoted = match whole.chars().all(is_plain) {
                true => whole,
                false => format!("'{}'", whole.replace('\'', r"'\''")),
            };
            format!("sagnac merge {quoted}/shard-*-of-{of} --out {quoted}")
        }
        None => format!("sagnac merge SHARE… --out DIR, with the folders of all {of}"),
    }
}

/// A duration with its unit, or in the notation of schedulers.
fn time(text: &str) -> Result<Duration, String> {
    if text.contains(':') {
        return clock(text).ok_or_else(|| {
            "expected hours:minutes:seconds as in 8:00:00, or days before that, 1-08:00:00".to_owned()
        });
    }
    Duration::try_from_secs_f64(value_of(text, Dimension::Time)?)
        .map_err(|_| "expected a time from now, such as \"55 min\"".to_owned())
}

/// A duration such as `8:00:00` or `1-08:00:00`. With two parts, one scheduler would read minutes and another hours.
fn clock(text: &str) -> Option<Duration> {
    let (days, text) = text.split_once('-').unwrap_or(("0", text));
    let number =
        |text: &str| text.parse::<u64>().ok().filter(|_| text.bytes().all(|byte| byte.is_ascii_digit()));
    let parts = text.split(':').map(number).collect::<Option<Vec<u64>>>()?;
    let [hours, minutes, seconds] = parts[..] else { return None };
    let whole = number(days)?.checked_mul(24)?.checked_add(hours)?.checked_mul(60)?;
    (minutes < 60 && seconds < 60).then_some(())?;
    whole.checked_add(minutes)?.checked_mul(60)?.checked_add(seconds).map(Duration::from_secs)
}

/// The share to sample, and the causes to stop.
struct Course {
    share: Share,
    stop: Stop,
}

/// Runs the studies in sequence. All are read and checked before the first starts.
pub fn run(options: &Options) -> Result<(), Failure> {
    let share = match options.shard {
        None => Share::WHOLE,
        Some(shard) => shard.share(|name| std::env::var(name).ok()).map_err(Failure::Usage)?,
    };
    let course = Course { share, stop: Stop::listen(options.time_limit).map_err(Failure::Signals)? };
    let studies = studies(options, share)?;
    let how = options.sampling.how();
    let plans = studies.iter().map(|(_, study)| checked(study, how, Some(&course.stop)));
    let plans = plans.collect::<Result<Vec<_>, _>>()?;
    let is_sampled = plans.iter().any(Plan::is_sampled);
    let mut device =
        is_sampled.then(|| options.device.select(!options.sampling.printed.quiet)).transpose()?;
    let mut documents: Vec<String> = Vec::new();
    let mut ended = Ok(());
    for (at, ((folder, study), plan)) in studies.iter().zip(&plans).enumerate() {
        if at > 0 && !options.sampling.json && !options.sampling.printed.quiet {
            print("\n")?;
        }
        match run_study(study, plan, folder, device.as_mut(), &course, options) {
            Ok(document) => documents.extend(document),
            Err(failure) => {
                ended = Err(failure);
                break;
            }
        }
    }
    // Completed studies are shown, whatever ended the next one.
    print_documents(&documents, studies.len())?;
    ended
}

/// The studies with their results folders, which are all different.
fn studies(options: &Options, share: Share) -> Result<Vec<(PathBuf, Study)>, Failure> {
    if options.out.is_some() && options.studies.len() > 1 {
        let message =
            "--out names one folder, but there are several studies\nrun them one by one, or without --out";
        return Err(Failure::Usage(message.to_owned()));
    }
    let mut studies = Vec::new();
    for path in &options.studies {
        let mut study = reading::study(path)?;
        options.sampling.apply(&mut study);
        if options.shard.is_some() && study.precision.is_some() {
            if options.sampling.trials.is_none() {
                return Err(Failure::Study(study.error_at(
                    study.place_of("precision"),
                    "a share cannot stop at a precision, because it does not know the trials of the others",
                    "give a fixed number with --trials N, or run the study as a whole",
                )));
            }
            study.fix_trials()?;
        }
        let folder = folder(options, path, share);
        if studies.iter().any(|(taken, _)| *taken == folder) {
            let message = format!(
                "several studies would write to {}, the last one {}\nrun them one by one, each with its --out DIR",
                folder.display(),
                path.display()
            );
            return Err(Failure::Usage(message));
        }
        studies.push((folder, study));
    }
    Ok(studies)
}

fn folder(options: &Options, study: &Path, share: Share) -> PathBuf {
    let whole = match study.parent() {
        // A resolved study goes into its own folder, where its results are.
        Some(here) if study.file_name() == Some(RESOLVED.as_ref()) && here == Path::new("") => {
            PathBuf::from(".")
        }
        Some(results) if study.file_name() == Some(RESOLVED.as_ref()) => results.to_owned(),
        _ => Path::new("results").join(study.file_stem().unwrap_or_default()),
    };
    let default = || match share.is_whole() {
        true => whole,
        false => whole.join(share_folder(share)),
    };
    options.out.clone().unwrap_or_else(default)
}

/// The plan of a study, with checks for errors that would otherwise occur after sampling. `how` is the kind of progress.
///
/// # Errors
/// A point cannot be represented, a chart cannot be drawn, or there is a cause to `stop`.
pub fn checked<'a>(study: &'a Study, how: How, stop: Option<&Stop>) -> Result<Plan<'a>, Failure> {
    let planning = Planning::new(how, stop);
    let stopped = || {
        let cause = stop.and_then(Stop::cause).unwrap_or(Cause::TimeLimit);
        Failure::Unplanned { cause, reached: planning.reached() }
    };
    let plan = Plan::watched(study, &planning)?.ok_or_else(stopped)?;
    pictures(study, &plan.blank_tables(), 0)?;
    Ok(plan)
}

/// Runs one study, and returns its results as JSON if requested.
fn run_study(
    study: &Study,
    plan: &Plan,
    folder: &Path,
    device: Option<&mut Device>,
    course: &Course,
    options: &Options,
) -> Result<Option<String>, Failure> {
    let results = Folder::open(folder)?;
    check_places(plan, &results)?;
    // Closed forms too have a store, which binds the folder to one study.
    let mut store = Store::open_in(&results, &plan.identity())?;
    // Kept from the start, as the run may be killed.
    for name in keep(study, &results)? {
        note!("{name} changed since the last run; the affected points are resampled");
    }
    store.note_share(course.share)?;
    let shown = Shown::new(options.sampling.how()).until(&course.stop);
    let device = device.filter(|_| plan.is_sampled());
    let name = device.as_ref().map(|device| device.name());
    let done = device.map(|device| {
        let done = course.stop.sampling(|| plan.run(&mut store, device, course.share, &shown))?;
        let cause = course.stop.cause().filter(|cause| done.stopped || *cause != Cause::TimeLimit);
        match cause {
            Some(cause) => {
                Err(Failure::Stopped { cause, reached: shown.reached(), folder: folder.to_owned() })
            }
            None => Ok(done),
        }
    });
    let done = done.transpose()?;
    if !course.share.is_whole() {
        shown.clear();
        for note in done.iter().flat_map(|done| &done.degraded) {
            note!("{note}");
        }
        if !options.sampling.printed.quiet {
            let share = course.share;
            say!(
                "{share} is done and in {}; when all are done: {}",
                folder.display(),
                merging(folder, share)
            );
        }
        return Ok(None);
    }
    let ran = Ran {
        plan,
        folder: &results,
        path: folder,
        sampled: Sampled { run: done.clone().zip(name), lacking: 0 },
        json: options.sampling.json,
        shown: options.sampling.printed,
    };
    let rate = |done: &RunStats| {
        if done.trials == 0 {
            return "nothing was left to sample".to_owned();
        }
        let seconds = match done.seconds {
            0.0..0.1 => "less than 0.1".to_owned(),
            seconds => significant(seconds, 3),
        };
        let again = match plan.counts_again(done.trials) {
            true => " (counted once per separate launch)",
            false => "",
        };
        format!("{} trials{again} in {seconds} s", short(done.trials as f64))
    };
    ran.show(&store, &shown, done.as_ref().map(rate))
}

/// Other systems have no such signals; an interruption ends the program at once, and completed work is kept.
#[cfg(not(unix))]
const SIGINT: i32 = 2;
#[cfg(not(unix))]
const SIGTERM: i32 = 15;
#[cfg(not(unix))]
const SIGUSR1: i32 = 10;

/// The cause for which a run ends early.
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
enum Shard {
    Given(Share),
    /// The share of this task of a Slurm job array.
    Slurm,
}

/// Reads `I/N` or `slurm`.
fn shard(text: &str) -> Result<Shard, String> {
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
    fn share(self, variable: impl Fn(&str) -> Option<String>) -> Result<Share, String> {
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

    #[test]
    fn the_command_that_merges_survives_names_that_shells_read() {
        let share: Share = "1/2".parse().unwrap();
        let command = |whole: &str| merging(&Path::new(whole).join(share_folder(share)), share);
        assert_eq!(command("results/my"), "sagnac merge results/my/shard-*-of-2 --out results/my");
        assert_eq!(command("a $b"), "sagnac merge 'a $b'/shard-*-of-2 --out 'a $b'");
        assert_eq!(command("it's"), r"sagnac merge 'it'\''s'/shard-*-of-2 --out 'it'\''s'");
    }

    #[test]
    fn a_time_limit_is_read_as_studies_and_as_schedulers_write_it() {
        let seconds = |text: &str| time(text).map(|limit| limit.as_secs());
        assert_eq!(seconds("55 min"), Ok(3300));
        assert_eq!(seconds("1:00:00"), Ok(3600));
        assert_eq!(seconds("00:55:00"), Ok(3300));
        assert_eq!(seconds("1-08:00:30"), Ok(115_230));
        for wrong in [
            "55:00",
            "1:60:00",
            "1:00:60",
            ":00:00",
            "1:-1:00",
            "1:00:00:00",
            "x-1:00:00",
            "99999999999999999999:00:00",
        ] {
            assert!(seconds(wrong).is_err_and(|why| why.contains("8:00:00")), "{wrong}");
        }
    }

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
