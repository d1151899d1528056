//! `sagnac run`.

use std::path::{Path, PathBuf};

use sagnac::backend::{Device, Selection, select};
use sagnac::chart::ChartError;
use sagnac::run::{Done, Plan, Tables};
use sagnac::store::Store;
use sagnac::study::{Chart, Kind, Source, Study, text_columns};
use sagnac::table::{Cell, Column, ColumnError, Table, significant};
use serde_json::{Value, json};

use super::Failure;
use super::charts::{Shown as Curves, draw, picture, refused, shown, written};
use super::one_point::one_point;
use super::output::{print, print_json, write};
use super::progress::{Shown, short};
use super::terminal::{aligned, pivot};
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
    let mut device = device(&plans, options)?;
    let mut documents: Vec<Value> = Vec::new();
    for (at, ((folder, study), plan)) in studies.iter().zip(&plans).enumerate() {
        if at > 0 && !options.json && !options.quiet {
            print("\n")?;
        }
        documents.extend(run_study(study, plan, folder, device.as_mut(), options)?);
    }
    match &documents[..] {
        [] => Ok(()),
        [document] => print_json(document),
        several => print_json(&several),
    }
}

/// The device that is asked for, if there is anything to sample.
fn device(plans: &[Plan], options: &super::Run) -> Result<Option<Device>, Failure> {
    if !plans.iter().any(Plan::is_sampled) {
        return Ok(None);
    }
    let Selection { device, reason } = select(&options.device.name)?;
    if !options.quiet {
        eprintln!("device: {}, {reason}", device.name());
    }
    Ok(Some(device))
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
    let blank = plan.blank_tables();
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
    device: Option<&mut Device>,
    options: &super::Run,
) -> Result<Option<Value>, Failure> {
    // Also of closed forms, as a folder is of one study.
    let mut store = Store::open(folder, &plan.identity())?;
    let progress = Shown::new(options.quiet);
    let device = device.filter(|_| plan.is_sampled());
    let name = device.as_ref().map(|device| device.name());
    let done = device.map(|device| plan.run(&mut store, device, &progress)).transpose()?;
    let tables = plan.tables(&store, &progress)?;
    for (name, table) in files(&tables) {
        let (path, mut csv) = (folder.join(name), Vec::new());
        table.write_csv(&mut csv).map_err(|source| Failure::Write { path: path.clone(), source })?;
        write(&path, &csv)?;
    }
    write(&folder.join(RESOLVED), study.resolved(plan.held(&store)?).as_bytes())?;
    let notes = draw(study, &tables, folder)?;
    let curves = shown(study, &tables)?;
    let verdicts = verdicts(study, &curves)?;
    let degraded = done.iter().filter_map(|done| done.degraded.clone());
    let notes: Vec<String> = degraded.chain(notes).chain(plan.notes(&store)?).collect();
    if options.json {
        return Ok(Some(to_json(study, name, done.as_ref(), &tables, &verdicts, &notes)));
    }
    if options.quiet {
        return Ok(None);
    }
    for note in notes {
        eprintln!("note: {note}");
    }
    print(&summary(study, &tables, &curves, &verdicts)?)?;
    let rate = match done {
        Some(done) if done.trials > 0 => {
            format!("{} trials in {:.1} s; ", short(done.trials as f64), done.seconds)
        }
        Some(_) => "nothing was left to sample; ".to_owned(),
        None => String::new(),
    };
    eprintln!("{rate}results are in {}", folder.display());
    Ok(None)
}

/// The tables of a study with the names of their files.
fn files(tables: &Tables) -> impl Iterator<Item = (&'static str, &Table)> {
    let coefficients = tables.coefficients.as_ref().map(|table| ("coefficients.csv", table));
    let trajectories = tables.trajectories.as_ref().map(|table| ("trajectories.csv", table));
    std::iter::once(("points.csv", &tables.points)).chain(coefficients).chain(trajectories)
}

/// The table of the first chart, coefficients, and all verdicts, for people.
fn summary(
    study: &Study,
    tables: &Tables,
    curves: &[Curves],
    verdicts: &[Verdict],
) -> Result<String, Failure> {
    let mut text = format!("{}\n", study.title);
    if !study.question.is_empty() {
        text += &format!("{}\n", study.question);
    }
    if let Some((chart, shown)) = study.charts.iter().zip(curves).next() {
        let shown = of_chart(study, shown, chart).map_err(|error| refused(study, chart, &error))?;
        text += &format!("\n{shown}");
    } else {
        let failed = |error: ColumnError| Failure::Picture(error.to_string());
        let shown = match study.kind() {
            Kind::SwitchedRun if study.sweeps.is_empty() => angles(&tables.points),
            Kind::GapFill if study.sweeps.is_empty() => one_point(&tables.points).map_err(failed)?,
            _ => undrawn(study, &tables.points).map_err(failed)?,
        };
        text += &format!("\n{shown}");
    }
    if let Some(coefficients) = &tables.coefficients {
        text += &format!("\n{}", coefficients_found(study, coefficients));
    }
    for verdict in verdicts {
        text += &format!("\n{}", verdict.text());
    }
    Ok(text)
}

/// Each column of a table in a line of its own, with its values.
fn columns(table: &Table) -> String {
    let line = |column: &Column| {
        let cell = |cell: &Cell| cell.number().map_or_else(|| cell.text(), |x| significant(x, 6));
        std::iter::once(column.title()).chain(column.cells.iter().map(cell)).collect::<Vec<String>>()
    };
    aligned(&table.columns.iter().map(line).collect::<Vec<_>>())
}

/// The points of a study without a chart as a grid, as after sweeps over names alone.
fn undrawn(study: &Study, table: &Table) -> Result<String, ColumnError> {
    let (estimate, rows) = match study.kind() {
        Kind::GapFill | Kind::Relock => ("rms", vec![]),
        Kind::SwitchedRun => ("drift_q9973", vec![("angle".to_owned(), "end".to_owned())]),
        Kind::Allan => ("adev", vec![]),
        Kind::DriftBudget | Kind::Suspension => return Ok(columns(table)),
    };
    let tau = (study.kind() == Kind::Allan).then_some("tau");
    let across: Vec<&str> = tau.into_iter().chain(study.sweeps.iter().map(|sweep| sweep.key.name)).collect();
    pivot(table, &across, estimate, &[], &text_columns(study, Source::Points), &rows)
}

/// The rows of a chart as a grid.
fn of_chart(study: &Study, shown: &Curves, chart: &Chart) -> Result<String, ChartError> {
    let table: &Table = &shown.table;
    let sweeps: Vec<&str> = study.sweeps.iter().map(|sweep| sweep.key.name).collect();
    let across = match study.kind() {
        kind if kind != Kind::Allan && !sweeps.is_empty() => sweeps,
        Kind::Allan => {
            let x = table.column(&chart.x.name)?.name.as_str();
            std::iter::once(x).chain(sweeps.into_iter().filter(|sweep| *sweep != x)).collect()
        }
        _ => vec![chart.x.name.as_str()],
    };
    let series: Vec<&str> = shown.series.iter().map(String::as_str).collect();
    let texts = text_columns(study, chart.source);
    Ok(pivot(table, &across, &shown.estimate, &series, &texts, &written(chart))?)
}

/// The angles of the runs of one point, a line each.
fn angles(table: &Table) -> String {
    const SHOWN: [&str; 7] =
        ["filler", "angle", "switches", "mean", "drift_mean", "drift_rms", "drift_q9973"];
    let is_shown = |column: &&Column| SHOWN.contains(&column.name.as_str());
    let columns: Vec<&Column> = table.columns.iter().filter(is_shown).collect();
    let cell = |cell: &Cell| cell.number().map_or_else(|| cell.text(), |x| significant(x, 4));
    let line = |row: usize| columns.iter().map(|column| cell(&column.cells[row])).collect();
    let heading: Vec<String> = columns.iter().map(|column| column.title()).collect();
    aligned(&std::iter::once(heading).chain((0..table.rows()).map(line)).collect::<Vec<_>>())
}

/// Most coefficients that are shown besides the file of them.
const MOST_COEFFICIENTS: usize = 24;

/// The coefficients of every point, a line each.
fn coefficients_found(study: &Study, table: &Table) -> String {
    if table.rows() > MOST_COEFFICIENTS {
        return format!("coefficients of {} points are in coefficients.csv\n", points_of(study));
    }
    let swept = study.sweeps.len();
    let shown = |name: &str| !["relative_rmse", "identified", "trials"].contains(&name);
    let columns: Vec<&Column> = table.columns.iter().filter(|column| shown(&column.name)).collect();
    let heading = |(at, column): (usize, &&Column)| {
        if at < swept { column.title() } else { column.name.clone() }
    };
    let line = |row: usize| {
        let cell = |column: &&Column| match &column.cells[row] {
            Cell::Number(x) => significant(*x, 4),
            cell => cell.text(),
        };
        columns.iter().map(cell).collect::<Vec<String>>()
    };
    let mut lines = vec![columns.iter().enumerate().map(heading).collect::<Vec<String>>()];
    lines.extend((0..table.rows()).map(line));
    format!("coefficients found in each record\n{}", aligned(&lines))
}

fn points_of(study: &Study) -> usize {
    study.sweeps.iter().map(|sweep| sweep.values.len()).product()
}

fn to_json(
    study: &Study,
    device: Option<String>,
    done: Option<&Done>,
    tables: &Tables,
    verdicts: &[Verdict],
    notes: &[String],
) -> Value {
    let cell = |cell: &Cell| match cell {
        Cell::Blank => json!(null),
        Cell::Text(text) => json!(text),
        Cell::Integer(integer) => json!(integer),
        Cell::Number(number) => json!(number),
    };
    let rows = |table: &Table| -> Vec<Value> {
        let row = |row: usize| {
            table.columns.iter().map(|column| (column.header(), cell(&column.cells[row]))).collect()
        };
        (0..table.rows()).map(row).collect()
    };
    let mut document = json!({
        "title": study.title,
        "question": study.question,
        "seed": done.map(|_| study.seed),
        "trials": done.map(|_| study.trials),
        "device": device,
        "sampled_trials": done.map(|done| done.trials),
        "seconds": done.map(|done| done.seconds),
        "notes": notes,
        "verdicts": verdicts.iter().map(Verdict::json).collect::<Vec<_>>(),
        "points": rows(&tables.points),
    });
    if let Some(coefficients) = &tables.coefficients {
        document["coefficients"] = json!(rows(coefficients));
    }
    document
}
