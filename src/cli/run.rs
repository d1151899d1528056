//! `sagnac run`.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};

use sagnac::backend::{Device, Selection, select};
use sagnac::chart::{self, ChartError, Figure, Scale, Spec};
use sagnac::run::{Done, Plan};
use sagnac::store::Store;
use sagnac::study::{self, Chart, Study, StudyError};
use sagnac::table::{ColumnError, Table, significant};
use sagnac::verdict::{Answer, Question, verdict};
use serde_json::{Value, json};

use super::Failure;
use super::output::{print, print_json};
use super::progress::{Shown, short};
use super::terminal::pivot;

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
        check(&study)?;
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
    let Selection { mut device, reason } = select(&options.device.name)?;
    if !options.quiet {
        eprintln!("device: {}, {reason}", device.name());
    }
    let run = |(folder, study): &(PathBuf, Study)| run_study(study, folder, &mut device, options);
    let results = studies.iter().map(run).collect::<Result<Vec<_>, _>>()?;
    let documents: Vec<Value> = results.into_iter().flatten().collect();
    match &documents[..] {
        [] => Ok(()),
        [document] => print_json(document),
        several => print_json(&several),
    }
}

fn folder(options: &super::Run, study: &Path) -> PathBuf {
    let default = || Path::new("results").join(study.file_stem().unwrap_or_default());
    options.out.clone().unwrap_or_else(default)
}

/// Finds what would otherwise fail after the sampling.
fn check(study: &Study) -> Result<(), Failure> {
    let blank = Plan::new(study)?.blank_table();
    for chart in &study.charts {
        Figure::from_table(&blank, &spec(study, chart)).map_err(|error| refused(study, chart, &error))?;
    }
    Ok(())
}

/// Runs one study, and returns its results as JSON where the options ask for that.
fn run_study(
    study: &Study,
    folder: &Path,
    device: &mut Device,
    options: &super::Run,
) -> Result<Option<Value>, Failure> {
    let plan = Plan::new(study)?;
    let mut store = Store::open(folder, &plan.identity())?;
    let done = plan.run(&mut store, device, &Shown::new(options.quiet))?;
    let table = plan.table(&store)?;
    let mut csv = Vec::new();
    table.write_csv(&mut csv).map_err(|source| Failure::Write { path: folder.join("points.csv"), source })?;
    write(&folder.join("points.csv"), &csv)?;
    write(&folder.join("resolved_study.toml"), study.resolved().as_bytes())?;
    let notes = draw(study, &table, folder)?;
    let answers = answers(study, &table)?;
    if options.json {
        return Ok(Some(to_json(study, device, done, &table, &answers)));
    }
    if options.quiet {
        return Ok(None);
    }
    for note in notes {
        eprintln!("note: {note}");
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
    print(&summary(study, &table, &answers)?)?;
    let rate = if done.trials > 0 {
        format!("{} trials in {:.1} s", short(done.trials as f64), done.seconds)
    } else {
        "nothing was left to sample".to_owned()
    };
    eprintln!("{rate}; results are in {}", folder.display());
    Ok(None)
}

/// Writes a file as a whole or not at all.
fn write(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    let failed = |source| Failure::Write { path: path.to_owned(), source };
    let partial = path.with_extension("partial");
    let written = std::fs::File::create(&partial).and_then(|mut file| file.write_all(contents));
    written.and_then(|()| std::fs::rename(&partial, path)).map_err(failed)
}

/// The names of a chart's files, without their endings.
fn chart_stem(index: usize, charts: usize) -> String {
    if charts == 1 { "chart".to_owned() } else { format!("chart-{}", index + 1) }
}

/// Draws every chart as SVG and PNG, removes those of earlier runs that are drawn no more, and returns what is to be
/// said of them.
fn draw(study: &Study, table: &Table, folder: &Path) -> Result<Vec<String>, Failure> {
    let mut notes = Vec::new();
    for (index, chart) in study.charts.iter().enumerate() {
        let stem = chart_stem(index, study.charts.len());
        let (figure, said) =
            Figure::from_table(table, &spec(study, chart)).map_err(|error| refused(study, chart, &error))?;
        let svg = figure.svg();
        let png = chart::png(&svg, 2.0)
            .map_err(|error| Failure::Picture(format!("cannot draw {stem}.png: {error}")))?;
        write(&folder.join(format!("{stem}.svg")), svg.as_bytes())?;
        write(&folder.join(format!("{stem}.png")), &png)?;
        notes.extend(said.sentence().map(|sentence| format!("{stem}: {sentence}")));
    }
    remove_undrawn(folder, study.charts.len())?;
    Ok(notes)
}

/// Removes the pictures of charts that a folder of `charts` charts does not have; other files are not ours.
fn remove_undrawn(folder: &Path, charts: usize) -> Result<(), Failure> {
    let failed = |source| Failure::Write { path: folder.to_owned(), source };
    let drawn: Vec<String> = (0..charts).map(|index| chart_stem(index, charts)).collect();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let stem = path.file_stem().and_then(OsStr::to_str).unwrap_or_default();
        let ending = path.extension().and_then(OsStr::to_str).unwrap_or_default();
        let picture = ["svg", "png"].contains(&ending) && is_chart_stem(stem);
        if picture && !drawn.iter().any(|drawn| drawn == stem) {
            std::fs::remove_file(&path).map_err(|source| Failure::Write { path, source })?;
        }
    }
    Ok(())
}

/// Whether [`chart_stem`] gives this name to some chart.
fn is_chart_stem(stem: &str) -> bool {
    let number = stem.strip_prefix("chart-").and_then(|number| number.parse().ok());
    stem == "chart" || number.is_some_and(|number: usize| number >= 1 && stem == format!("chart-{number}"))
}

fn spec(study: &Study, chart: &Chart) -> Spec {
    let scale = |scale| match scale {
        study::Scale::Log => Scale::Log,
        study::Scale::Linear => Scale::Linear,
    };
    Spec {
        title: chart.title.clone().unwrap_or_else(|| study.title.clone()),
        subtitle: (!study.question.is_empty()).then(|| study.question.clone()),
        x: chart.x.name.clone(),
        y: chart.y.name.clone(),
        x_scale: scale(chart.x_scale),
        y_scale: scale(chart.y_scale),
        series: chart.series.iter().map(|column| column.name.clone()).collect(),
        filter: chart.rows.iter().map(|(column, value)| (column.name.clone(), value.text())).collect(),
        limit: chart.limit_arcsec,
        laws: vec![],
        points: "Monte Carlo".to_owned(),
    }
}

/// A chart's error at the name in the study that caused it.
fn refused(study: &Study, chart: &Chart, error: &ChartError) -> StudyError {
    let named = || [&chart.x, &chart.y].into_iter().chain(&chart.series);
    let rows = || chart.rows.iter().map(|row| &row.0);
    let place = |mut names: Box<dyn Iterator<Item = &study::Named> + '_>, name: &str| {
        // A default is written nowhere; another name may be.
        names
            .find(|named| named.name == name && !named.span.is_empty())
            .map_or(0..0, |named| named.span.clone())
    };
    let column = "name a column of points.csv, with or without its unit";
    let (span, help) = match error {
        ChartError::Column(ColumnError::Unknown { name, .. } | ColumnError::Ambiguous { name, .. })
        | ChartError::NotNumbers { column: name, .. } => {
            (place(Box::new(named().chain(rows())), name), column)
        }
        ChartError::Column(ColumnError::NoRow { column, .. }) => {
            (place(Box::new(rows()), column), "`where` takes values that the column has in points.csv")
        }
        ChartError::NotAngle { column, .. } => (
            place(Box::new(std::iter::once(&chart.y)), column),
            "name an error in ″ as y, or leave out the limit",
        ),
        ChartError::TooManySeries { .. } => (0..0, column),
    };
    study.error_at(span, format!("chart: {error}"), help)
}

/// The verdict of every chart with a limit.
fn answers(study: &Study, table: &Table) -> Result<Vec<(f64, Vec<Answer>)>, Failure> {
    let mut all = Vec::new();
    for chart in &study.charts {
        if let Some(limit) = chart.limit_arcsec {
            let question = Question {
                x: &chart.x.name,
                series: chart.series.iter().map(|column| column.name.as_str()).collect(),
                filter: filter(chart),
                limit,
            };
            let found = verdict(table, &question)
                .map_err(|error| refused(study, chart, &ChartError::Column(error)))?;
            all.push((limit, found));
        }
    }
    Ok(all)
}

fn filter(chart: &Chart) -> Vec<(&str, String)> {
    chart.rows.iter().map(|(column, value)| (column.name.as_str(), value.text())).collect()
}

/// The table of the first chart and all verdicts, for people.
fn summary(study: &Study, table: &Table, answers: &[(f64, Vec<Answer>)]) -> Result<String, Failure> {
    let mut text = format!("{}\n{}\n", study.title, study.question);
    if let Some(chart) = study.charts.first() {
        let sweeps: Vec<&str> = study.sweeps.iter().map(|sweep| sweep.key.name).collect();
        let across = if sweeps.is_empty() { vec![chart.x.name.as_str()] } else { sweeps };
        let series: Vec<&str> = chart.series.iter().map(|column| column.name.as_str()).collect();
        let shown = pivot(table, &across, &chart.y.name, &series, &filter(chart))
            .map_err(|error| refused(study, chart, &ChartError::Column(error)))?;
        text += &format!("\n{shown}");
    }
    for (limit, found) in answers {
        text += "\n99.73 % error against the limit\n";
        for answer in found {
            text += &format!("  {}\n", answer.sentence(&format!("{} ″", significant(*limit, 6))));
        }
    }
    Ok(text)
}

fn to_json(
    study: &Study,
    device: &Device,
    done: Done,
    table: &Table,
    answers: &[(f64, Vec<Answer>)],
) -> Value {
    let cell = |cell: &sagnac::table::Cell| match cell {
        sagnac::table::Cell::Blank => json!(null),
        sagnac::table::Cell::Text(text) => json!(text),
        sagnac::table::Cell::Integer(integer) => json!(integer),
        sagnac::table::Cell::Number(number) => json!(number),
    };
    let rows: Vec<Value> = (0..table.rows())
        .map(|row| table.columns.iter().map(|column| (column.header(), cell(&column.cells[row]))).collect())
        .collect();
    let verdicts: Vec<Value> =
        answers.iter().map(|(limit, found)| json!({ "limit_arcsec": limit, "series": found })).collect();
    json!({
        "title": study.title,
        "question": study.question,
        "seed": study.seed,
        "trials": study.trials,
        "device": device.name(),
        "sampled_trials": done.trials,
        "seconds": done.seconds,
        "verdicts": verdicts,
        "points": rows,
    })
}
