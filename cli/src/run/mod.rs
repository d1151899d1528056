//! `sagnac run`.

pub mod control;

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use sagnac::device::Device;
use sagnac::run::{Plan, RESOLVED, RunStats, keep};
use sagnac::store::Store;
use sagnac::store::folder::Folder;
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::use_cases::{Sampled, check_places};
use sagnac::view::pictures;
use sagnac_base::quantity::number::{short, significant};
use sagnac_base::quantity::{Dimension, parse as parse_quantity};

use crate::failure::Failure;
use crate::output::{print, print_documents};
use crate::program::{DeviceArg, Sampling};
use crate::progress::{How, Planning, Shown};
use crate::reading;
use crate::results::Ran;
pub use crate::run::control::Cause;
use crate::run::control::{Shard, Stop};

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
    #[arg(help_heading = "Sampling", long, value_name = "I/N", conflicts_with = "json", value_parser = crate::run::control::parse)]
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
    let quantity = parse_quantity(text, &[Dimension::Time]).map_err(|error| error.to_string())?;
    Duration::try_from_secs_f64(quantity.value)
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
}
