//! The answer of a study to its question.

use crate::chart::Chart;
use crate::chart::Source;
use crate::drift::schedule::INTERVAL;
use crate::filler::{FILLERS, Filler, Method};
use crate::kinds::gap_fill::GapFill;
use crate::kinds::switched_run::SwitchedRun;
use crate::motion::Frequency;
use crate::quantity::number::short;
use crate::run::Tables;
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::table::{Column, ColumnError, Role, Table, Usual};
use crate::view::chart::notes::ChartError;
use crate::view::chart::picture::Picture;
use crate::view::chart::stack::Shown;
use crate::view::picture::verdict::Verdict;
use crate::view::picture::{Drawn, refused};
use crate::view::report::curves::{Curves, least_for_each};
use crate::view::report::sentences::{best, less_is_better, of_map, side_by_side};
use crate::view::report::standing::of_verdict;

/// Most rows or curves that a headline lists side by side.
const MOST_BESIDE: usize = 4;

/// Prefixes of keys that are not chosen to reduce the drift.
const GIVEN: [&str; 5] = ["run.", "motion.", "drift.", "gyro.tick_noise", "gyro.readout_lsb"];

/// The answer as a sentence, with its details.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Answer {
    /// One sentence; empty where there is nothing to say, as for a table without a value.
    pub headline: String,
    /// A heading for each chart with this kind of answer, with a sentence for each curve: its verdict, or its minimum.
    pub curves: Vec<(String, Vec<String>)>,
}

/// The answer of a study: the verdicts if there are any, else the content of the first chart, else the best row of the
/// table.
///
/// `lacking` is the number of missing trials, which the answer states first.
///
/// # Errors
/// The table lacks something that a chart requires.
pub fn answer(
    study: &Study,
    tables: &Tables,
    charts: &[Drawn],
    shown: &[Shown],
    verdicts: &[Verdict],
    lacking: u64,
) -> Result<Answer, StudyError> {
    let all = || study.charts.iter().zip(shown).zip(charts);
    let judged = all()
        .find(|((chart, _), drawn)| chart.limit.is_some() && matches!(drawn.picture, Picture::Curves(_)));
    let headline = match (verdicts.first().zip(judged), all().next()) {
        (Some((first, ((chart, shown), _))), _) => {
            let judged = of_verdict(first.answers(), first.limit());
            let headline = match chosen_interval(study, chart, shown)
                .map_err(|error| refused(study, chart, &error.into()))?
            {
                Some(best) => judged.map(|judged| format!("{best} {judged}")),
                None => judged,
            };
            with_caveat(study, headline, &shown.table, &chart.filter())
                .map_err(|error| refused(study, chart, &error.into()))?
        }
        (None, Some(((chart, shown), _))) if shown.is_supplied(chart) => undrawn(study, tables),
        (None, Some(((chart, shown), drawn))) => {
            of_chart(study, chart, shown, &drawn.picture).map_err(|error| refused(study, chart, &error))?
        }
        (None, None) => undrawn(study, tables),
    };
    let mut curves: Vec<(String, Vec<String>)> =
        verdicts.iter().map(|verdict| (verdict.heading(), verdict.sentences())).collect();
    for ((chart, shown), drawn) in all() {
        let each = match &drawn.picture {
            Picture::Curves(_) if chart.limit.is_none() => {
                of_each(chart, shown).map_err(|error| refused(study, chart, &error.into()))?
            }
            _ => vec![],
        };
        if !each.is_empty() {
            let which = if is_environment(chart, shown) { "largest" } else { "least" };
            let heading =
                format!("{}: the {which} {} of each curve", drawn.stem, drawn.picture.shown().label);
            curves.push((heading, each));
        }
    }
    let headline = match (headline, lacking) {
        (headline, 0) => headline.unwrap_or_default(),
        (Some(headline), lacking) => {
            format!("Incomplete, {} trials are missing. So far: {headline}", short(lacking as f64))
        }
        (None, lacking) => format!("Incomplete, {} trials are missing.", short(lacking as f64)),
    };
    Ok(Answer { headline, curves })
}

fn of_chart(
    study: &Study,
    chart: &Chart,
    shown: &Shown,
    picture: &Picture,
) -> Result<Option<String>, ChartError> {
    if let Picture::Map(map) = picture {
        return Ok(with_caveat(study, of_map(map), &shown.table, &chart.filter())?);
    }
    let series = shown.series.iter().map(String::as_str).chain([chart.x.name.as_str()]);
    let by = apart(study, chart.source, series.collect());
    let rows = chart.filter();
    let ground = study.ground(chart.source);
    let whole = ground.and_then(|ground| ground.texts.iter().find_map(|text| Some((text.name, text.whole?))));
    let is_by_part =
        shown.is_named(chart) || shown.table.column(&chart.x.name).is_ok_and(|x| x.role == Role::Coordinate);
    let whole = whole.filter(|(name, _)| is_by_part && rows.iter().all(|(column, _)| column != name));
    if let Some((name, whole)) = whole {
        // The least of all ticks says nothing about a compensation; the remainder in their sum does.
        let all = [&rows[..], &[(name.to_owned(), whole.to_owned())]].concat();
        let sums = shown.table.rows_where(&all).unwrap_or_default();
        let beside = side_by_side(&shown.table, &shown.estimate, &sums, &by)?;
        if let Some(beside) = beside.filter(|_| sums.len() <= MOST_BESIDE) {
            return Ok(Some(format!("All ticks together, {beside}.")));
        }
    }
    if is_environment(chart, shown) {
        let told = of_range(chart, shown, |curves| curves.least_at_worst())?.flatten();
        if told.is_some() {
            return Ok(with_caveat(study, told, &shown.table, &rows)?);
        }
    }
    if let Some(told) = interval_for_each(chart, shown)? {
        return Ok(with_caveat(study, Some(told), &shown.table, &rows)?);
    }
    Ok(leading(study, &shown.table, &shown.estimate, &rows, &by)?)
}

/// The minimum of a chart over the switching interval: the interval is chosen, so the limit alone does not answer the
/// question.
fn chosen_interval(study: &Study, chart: &Chart, shown: &Shown) -> Result<Option<String>, ColumnError> {
    let table = &shown.table;
    if table.column(&chart.x.name)?.name != INTERVAL.name {
        return Ok(None);
    }
    let told = interval_for_each(chart, shown)?;
    if told.is_some() {
        return Ok(told);
    }
    let series = shown.series.iter().map(String::as_str).chain([chart.x.name.as_str()]);
    let by = apart(study, chart.source, series.collect());
    let best = best(table, &shown.estimate, &table.rows_where(&chart.filter())?, &by)?;
    Ok(best.map(|best| best.sentence()))
}

/// The minimum over the switching interval for each condition or requirement of a gyro, if its curves differ in these;
/// the best of all of them would not help the others.
fn interval_for_each(chart: &Chart, shown: &Shown) -> Result<Option<String>, ColumnError> {
    let table = &shown.table;
    let rows = table.rows_where(&chart.filter())?;
    let is_over_interval = table.column(&chart.x.name)?.name == INTERVAL.name;
    if !is_over_interval || !less_is_better(table, &shown.estimate, &rows)? {
        return Ok(None);
    }
    let series = shown.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let (given, chosen): (Vec<&Column>, Vec<&Column>) =
        series.into_iter().partition(|column| GIVEN.iter().any(|key| column.name.starts_with(key)));
    least_for_each(table, (&chart.x.name, &shown.estimate), &rows, [&given, &chosen], MOST_BESIDE)
}

/// Whether the abscissa is a condition that is not chosen, so that the worst case counts.
fn is_environment(chart: &Chart, shown: &Shown) -> bool {
    let Ok(x) = shown.table.column(&chart.x.name) else { return false };
    let key = if x.role == Role::Coordinate { &x.of } else { &x.name };
    key.starts_with("motion.")
}

/// The statement of `say` on the curves of a chart, if less of the estimate is better.
fn of_range<T>(chart: &Chart, shown: &Shown, say: impl Fn(&Curves) -> T) -> Result<Option<T>, ColumnError> {
    let (table, estimate) = (&shown.table, shown.estimate.as_str());
    let rows = table.rows_where(&chart.filter())?;
    if !less_is_better(table, estimate, &rows)? {
        return Ok(None);
    }
    let series: Vec<&str> = shown.series.iter().map(String::as_str).collect();
    Ok(Some(say(&Curves::of(table, (&chart.x.name, estimate), &rows, &series)?)))
}

/// The best row, and where that has a filler that firmware cannot have, the best of the others.
fn leading(
    study: &Study,
    table: &Table,
    estimate: &str,
    filter: &[(String, String)],
    by: &[&str],
) -> Result<Option<String>, ColumnError> {
    let rows = table.rows_where(filter)?;
    let Some(first) = best(table, estimate, &rows, by)? else { return Ok(None) };
    let sentence = first.sentence();
    let Some((row, (free, why))) = first.row.zip(free_fillers(study)) else { return Ok(Some(sentence)) };
    let Some(filler) = table.listed_by(FILLERS) else { return Ok(Some(sentence)) };
    let is_free = |row: usize| free.contains(&filler.cells[row].text().as_str());
    if !is_free(row) {
        return Ok(Some(sentence));
    }
    let others: Vec<usize> = rows.into_iter().filter(|&row| !is_free(row)).collect();
    let known = best(table, estimate, &others, by)?
        .map_or(", which firmware does not know".to_owned(), |second| {
            format!(", which firmware does not know; of the others the least is {}", second.value)
        });
    Ok(Some(format!("{sentence} That filler is designed for {why}{known}.")))
}

/// The names of fillers whose weights firmware cannot have, with the reason: designed without a band, they follow the
/// motion of each point, or one frequency to the last digit. For a motion that is drawn from a band, they are those of
/// the band.
fn free_fillers(study: &Study) -> Option<(Vec<&str>, &'static str)> {
    let gap_fill = study.asked::<GapFill>().or_else(|| study.asked::<SwitchedRun>()?.fill.as_ref())?;
    let is_free = |filler: &&Filler| filler.method == Method::MinimumVariance(None);
    let free: Vec<&str> =
        gap_fill.fillers.iter().filter(is_free).map(|filler| filler.name.as_str()).collect();
    let of_design = |key: &str| ["motion.", "gyro.", "noise."].iter().any(|table| key.starts_with(table));
    let varies = study.sweeps.iter().any(|sweep| sweep.values.len() > 1 && of_design(sweep.key.name));
    let is_tuned =
        gap_fill.inputs.motion.tones.iter().any(|tone| matches!(tone.frequency, Frequency::Fixed(_)));
    let why = match (varies, is_tuned) {
        (true, _) => "the very motion of each point",
        (false, true) => "exactly this frequency",
        (false, false) => return None,
    };
    (!free.is_empty()).then_some((free, why))
}

/// A headline with a caveat on the fillers among some rows.
fn with_caveat(
    study: &Study,
    headline: Option<String>,
    table: &Table,
    filter: &[(String, String)],
) -> Result<Option<String>, ColumnError> {
    let Some(headline) = headline else { return Ok(None) };
    let Some((mut free, why)) = free_fillers(study) else { return Ok(Some(headline)) };
    let Some(filler) = table.listed_by(FILLERS) else { return Ok(Some(headline)) };
    let rows = table.rows_where(filter)?;
    free.retain(|name| rows.iter().any(|&row| filler.cells[row].text() == *name));
    Ok(Some(match &free[..] {
        [] => headline,
        names => {
            let is = if names.len() == 1 { "is" } else { "are" };
            let names = names.join(" and ");
            format!(
                "{headline} Without a band {names} {is} designed for {why}, which firmware does not know."
            )
        }
    }))
}

/// The minimum of each curve of a chart, or the maximum where that counts; empty where neither is of interest.
fn of_each(chart: &Chart, shown: &Shown) -> Result<Vec<String>, ColumnError> {
    let is_largest = is_environment(chart, shown);
    let each =
        of_range(
            chart,
            shown,
            |curves| {
                if is_largest { curves.largest_of_each() } else { curves.least_of_each() }
            },
        );
    Ok(each?.unwrap_or_default())
}

/// The best row of a study without its own chart.
fn undrawn(study: &Study, tables: &Tables) -> Option<String> {
    let points = &tables.points;
    let estimate = points.usual(Usual::Answer)?;
    // Errors and angles that the study omits have no rows.
    let rows = Some(study.usual_rows()).filter(|rows| points.rows_where(rows).is_ok()).unwrap_or_default();
    let abscissa = points.usual(Usual::Abscissa).map(|column| column.name.as_str());
    let by = apart(study, Source::Points, abscissa.into_iter().collect());
    // Every study of the kind has the columns.
    let sentence = leading(study, points, &estimate.name, &rows, &by).ok().flatten()?;
    match points.chosen(&rows) {
        Ok(chosen) if !chosen.is_empty() => {
            Some(format!("{} ({}).", sentence.trim_end_matches('.'), chosen.join(", ")))
        }
        _ => Some(sentence),
    }
}

/// The columns that distinguish rows, each once, with those of a chart first.
fn apart<'n>(study: &'n Study, source: Source, mut columns: Vec<&'n str>) -> Vec<&'n str> {
    let sweeps = study.sweeps.iter().map(|sweep| sweep.key.name);
    for name in study.text_columns(source).into_iter().chain(sweeps) {
        // A chart may give only the end of a column's name.
        if !columns.iter().any(|column| name == *column || name.ends_with(&format!(".{column}"))) {
            columns.push(name);
        }
    }
    columns
}
