//! `sagnac run`.

use std::path::{Path, PathBuf};

use sagnac::backend::{Device, Selection, select};
use sagnac::chart::ChartError;
use sagnac::run::{Done, Plan};
use sagnac::store::Store;
use sagnac::study::Study;
use sagnac::table::Table;
use serde_json::{Value, json};

use super::Failure;
use super::charts::{draw, picture, refused, written};
use super::one_point::one_point;
use super::output::{print, print_json, write};
use super::progress::{Shown, short};
use super::terminal::pivot;
use super::verdicts::{Verdict, verdicts};

/// Runs the studies one after the other. All are read and checked before the first starts.
pub fn run(options: &super::Run) -> Result<(), Failure> {
    if options.out.is_some() && options.studies.len() > 1 {
        let message =
            "--out names one folder, but there are several studies\nrun them one by one, or without --out";
        return Err(Failure::Usage(message.to_owned()));
    }
    let mut studies = Vec::new();
    for path in &options.studies {
        let mut study = Study::read(path)?;
        study.trials = options.trials.unwrap_or(study.trials);
        study.seed = options.seed.unwrap_or(study.seed);
        let folder = folder(options, path);
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
    let plans = studies.iter().map(|(_, study)| checked(study)).collect::<Result<Vec<_>, _>>()?;
    let Selection { mut device, reason } = select(&options.device.name)?;
    if !options.quiet {
        eprintln!("device: {}, {reason}", device.name());
    }
    let mut documents: Vec<Value> = Vec::new();
    for (at, ((folder, study), plan)) in studies.iter().zip(&plans).enumerate() {
        if at > 0 && !options.json && !options.quiet {
            print("\n")?;
        }
        documents.extend(run_study(study, plan, folder, &mut device, options)?);
    }
    match &documents[..] {
        [] => Ok(()),
        [document] => print_json(document),
        several => print_json(&several),
    }
}

/// The name of the study that a run writes beside its results.
const RESOLVED: &str = "resolved_study.toml";

fn folder(options: &super::Run, study: &Path) -> PathBuf {
    let default = || match study.parent() {
        // What repeats a run goes where its results are.
        Some(results) if study.file_name() == Some(RESOLVED.as_ref()) && results != Path::new("") => {
            results.to_owned()
        }
        _ => Path::new("results").join(study.file_stem().unwrap_or_default()),
    };
    options.out.clone().unwrap_or_else(default)
}

/// Finds what would otherwise fail after the sampling.
fn checked(study: &Study) -> Result<Plan<'_>, Failure> {
    let plan = Plan::new(study)?;
    let blank = plan.blank_table();
    for chart in &study.charts {
        picture(study, &blank, chart)?;
    }
    Ok(plan)
}

/// Runs one study, and returns its results as JSON where the options ask for that.
fn run_study(
    study: &Study,
    plan: &Plan,
    folder: &Path,
    device: &mut Device,
    options: &super::Run,
) -> Result<Option<Value>, Failure> {
    let mut store = Store::open(folder, &plan.identity())?;
    let done = plan.run(&mut store, device, &Shown::new(options.quiet))?;
    let table = plan.table(&store)?;
    let mut csv = Vec::new();
    table.write_csv(&mut csv).map_err(|source| Failure::Write { path: folder.join("points.csv"), source })?;
    write(&folder.join("points.csv"), &csv)?;
    // With a precision `trials` is the most there may be, and so part of the rule.
    let held = if study.precision.is_none() { plan.held(&store)? } else { None };
    let trials = held.unwrap_or(study.trials);
    write(&folder.join(RESOLVED), study.resolved(trials).as_bytes())?;
    let notes = draw(study, &table, folder)?;
    let verdicts = verdicts(study, &table)?;
    if options.json {
        return Ok(Some(to_json(study, device, done, &table, &verdicts)));
    }
    if options.quiet {
        return Ok(None);
    }
    for note in notes.into_iter().chain(plan.absent()) {
        eprintln!("note: {note}");
    }
    if trials > study.trials {
        let why =
            if plan.replays() { "whole replays of the record" } else { "the folder holds them already" };
        eprintln!("note: {trials} trials a point, not {}: {why}", study.trials);
    }
    let (imprecise, fillers) = plan.imprecise(&store)?;
    if imprecise > 0 {
        let trials = short(study.trials as f64);
        eprintln!(
            "note: {imprecise} of {fillers} fillers at points are not as precise as asked after {trials} trials"
        );
    }
    match plan.unasked(&store)? {
        0 => {}
        1 => {
            eprintln!("note: 1 point of earlier runs is kept but not shown: the study no longer asks for it")
        }
        n => eprintln!(
            "note: {n} points of earlier runs are kept but not shown: the study no longer asks for them"
        ),
    }
    print(&summary(study, &table, &verdicts)?)?;
    let rate = if done.trials > 0 {
        format!("{} trials in {:.1} s", short(done.trials as f64), done.seconds)
    } else {
        "nothing was left to sample".to_owned()
    };
    eprintln!("{rate}; results are in {}", folder.display());
    Ok(None)
}

/// The table of the first chart and all verdicts, for people.
fn summary(study: &Study, table: &Table, verdicts: &[Verdict]) -> Result<String, Failure> {
    let mut text = format!("{}\n", study.title);
    if !study.question.is_empty() {
        text += &format!("{}\n", study.question);
    }
    if let Some(chart) = study.charts.first() {
        let sweeps: Vec<&str> = study.sweeps.iter().map(|sweep| sweep.key.name).collect();
        let across = if sweeps.is_empty() { vec![chart.x.name.as_str()] } else { sweeps };
        let series: Vec<&str> = chart.series().iter().map(|column| column.name.as_str()).collect();
        let shown = pivot(table, &across, &chart.estimate().name, &series, &written(chart))
            .map_err(|error| refused(study, chart, &ChartError::Column(error)))?;
        text += &format!("\n{shown}");
    } else if study.sweeps.is_empty() {
        let shown = one_point(table).map_err(|error| Failure::Picture(error.to_string()))?;
        text += &format!("\n{shown}");
    }
    for verdict in verdicts {
        text += &format!("\n{}", verdict.text());
    }
    Ok(text)
}

fn to_json(study: &Study, device: &Device, done: Done, table: &Table, verdicts: &[Verdict]) -> Value {
    let cell = |cell: &sagnac::table::Cell| match cell {
        sagnac::table::Cell::Blank => json!(null),
        sagnac::table::Cell::Text(text) => json!(text),
        sagnac::table::Cell::Integer(integer) => json!(integer),
        sagnac::table::Cell::Number(number) => json!(number),
    };
    let rows: Vec<Value> = (0..table.rows())
        .map(|row| table.columns.iter().map(|column| (column.header(), cell(&column.cells[row]))).collect())
        .collect();
    json!({
        "title": study.title,
        "question": study.question,
        "seed": study.seed,
        "trials": study.trials,
        "device": device.name(),
        "sampled_trials": done.trials,
        "seconds": done.seconds,
        "verdicts": verdicts.iter().map(Verdict::json).collect::<Vec<_>>(),
        "points": rows,
    })
}
