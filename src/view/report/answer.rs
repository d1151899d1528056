//! The answer of a study to its question.

use crate::chart::{Chart, Source};
use crate::drift::schedule::INTERVAL;
use crate::filler::FILLERS;
use crate::kinds::allan::columns::is_absent;
use crate::kinds::navigation::keys::{ALIGNMENT, FILTER};
use crate::motion::keys::GYRO as SUSPENDED_GYRO;
use crate::noise::keys::FILE as NOISE_FILE;
use crate::quantity::list::listed;
use crate::quantity::number::{short, significant};
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::table::{Cell, Column, ColumnError, Role, Table, Usual, grouped};
use crate::view::chart::picture::Picture;
use crate::view::chart::stack::Shown;
use crate::view::picture::verdict::Verdict;
use crate::view::picture::{Drawn, refused};
use crate::view::report::bandless::Bandless;
use crate::view::report::curves::Curves;
use crate::view::report::sentences::{best, less_is_better, measured, of_map, side_by_side};
use crate::view::report::standing::of_verdict;
use crate::view::verdict::Answer as Judged;

/// Most rows or curves that a headline lists side by side.
const MOST_BESIDE: usize = 4;

/// Prefixes of keys that are conditions or requirements instead of choices of a designer.
const GIVEN: [&str; 14] = [
    "coefficient",
    "record.rate",
    "suspension.frequency",
    "run.",
    "motion.",
    "drift.",
    "noise.",
    "navigation.",
    "relock.adc_noise",
    "lock_in.threshold",
    "input.rate",
    "gyro.tick_noise",
    "gyro.readout_lsb",
    "switching.gap_ticks",
];

/// Keys of these between which a designer chooses: those that tell gyros or filters apart, and the time of alignment.
const CHOSEN: [&str; 4] = [SUSPENDED_GYRO.name, NOISE_FILE.name, FILTER.name, ALIGNMENT.name];

/// Whether a column is a condition or a requirement instead of a choice.
pub(crate) fn is_given(column: &Column) -> bool {
    let key = if column.of.is_empty() { &column.name } else { &column.of };
    !CHOSEN.contains(&key.as_str()) && GIVEN.iter().any(|given| key.starts_with(given))
}

/// The answer as a sentence, with its details.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Answer {
    /// One sentence; empty where there is nothing to say, as for a table without a value.
    pub headline: String,
    /// A heading for each chart with this kind of answer, with a sentence for each curve: its verdict, or its minimum.
    pub curves: Vec<(String, Vec<String>)>,
    /// The lines of the decision sheet, each with its heading; empty where there is none.
    pub sheet: Vec<(&'static str, String)>,
}

impl Answer {
    /// The answer of a study: the verdicts if there are any, else the content of the first chart, else the best row of
    /// the `points`. It states first how many trials are `lacking`.
    ///
    /// # Errors
    /// The table lacks something that a chart requires.
    pub(crate) fn of(
        study: &Study,
        points: &Table,
        charts: &[Drawn],
        shown: &[Shown],
        verdicts: &[Verdict],
        lacking: u64,
    ) -> Result<Answer, StudyError> {
        let refuse = |chart, error: ColumnError| refused(study, chart, &error.into());
        let charts = study.charts.iter().zip(shown).zip(charts).map(|((chart, shown), drawn)| {
            Resolved::of(study, chart, shown, drawn).map_err(|error| refuse(chart, error))
        });
        let charts = charts.collect::<Result<Vec<_>, _>>()?;
        let judged = charts.iter().find(|resolved| resolved.chart.limit.is_some() && resolved.has_curves());
        // Where records show a coefficient is what a study of records asks first.
        let shows = |resolved: &&Resolved| resolved.estimate.role == Role::Fraction && resolved.has_curves();
        let first = charts.iter().find(shows).or(charts.first());
        let headline = match (verdicts.first().zip(judged), first) {
            (Some((first, resolved)), _) => {
                let told = resolved.judged(first).map_err(|error| refuse(resolved.chart, error))?;
                // Charts of the same curves under other conditions answer the same question.
                let judged = charts.iter().filter(|other| other.chart.limit.is_some() && other.has_curves());
                let further = judged.filter(|other| resolved.is_continued_by(other)).filter_map(|other| {
                    let verdict = verdicts.iter().find(|verdict| verdict.is_of(&other.drawn.stem))?;
                    of_verdict(&verdict.answers, verdict.limit)
                });
                let further: Vec<String> = further.collect();
                let told = told.map(|told| [&[told], &further[..]].concat().join(" "));
                if further.is_empty() { resolved.with_conditions(told) } else { told }
            }
            (None, Some(resolved)) if !resolved.shown.is_supplied(resolved.chart) => {
                let told = resolved.of_picture().map_err(|error| refuse(resolved.chart, error))?;
                resolved.with_conditions(told)
            }
            _ => undrawn(study, points),
        };
        let mut curves: Vec<(String, Vec<String>)> =
            verdicts.iter().map(|verdict| (verdict.heading(), verdict.sentences())).collect();
        // The least over what is given, as over the run time, is nobody's choice.
        let has_minima = |resolved: &&Resolved| {
            let is_asked = resolved.is_environment() || !is_given(resolved.x);
            resolved.has_curves() && resolved.chart.limit.is_none() && is_asked
        };
        for resolved in charts.iter().filter(has_minima) {
            let is_largest = resolved.is_environment();
            let each = resolved.curves().map_or(vec![], |curves| curves.of_each(is_largest));
            if !each.is_empty() {
                let which = if is_largest { "largest" } else { "least" };
                let Drawn { stem, picture, .. } = resolved.drawn;
                curves.push((format!("{stem}: the {which} {} of each curve", picture.shown().label), each));
            }
        }
        let headline = match (headline, lacking) {
            (headline, 0) => headline.unwrap_or_default(),
            (headline, lacking) => {
                let so_far = headline.map_or(String::new(), |headline| format!(" So far: {headline}"));
                format!("Incomplete, {} trials are missing.{so_far}", short(lacking as f64))
            }
        };
        Ok(Answer { headline, curves, sheet: vec![] })
    }
}

/// A drawn chart of a study with its columns and rows, looked up in its table.
struct Resolved<'a> {
    study: &'a Study,
    chart: &'a Chart,
    shown: &'a Shown<'a>,
    drawn: &'a Drawn,
    x: &'a Column,
    estimate: &'a Column,
    series: Vec<&'a Column>,
    rows: Vec<usize>,
}

impl<'a> Resolved<'a> {
    fn of(
        study: &'a Study,
        chart: &'a Chart,
        shown: &'a Shown<'a>,
        drawn: &'a Drawn,
    ) -> Result<Resolved<'a>, ColumnError> {
        let table: &Table = &shown.table;
        let (x, estimate) = (table.column(&chart.x.name)?, table.column(&shown.estimate)?);
        let series = shown.series.iter().map(|name| table.column(name)).collect::<Result<_, _>>()?;
        let rows = table.rows_where(&chart.filter())?;
        Ok(Resolved { study, chart, shown, drawn, x, estimate, series, rows })
    }

    /// Whether another chart has the same curves for another value of a swept key.
    fn is_continued_by(&self, other: &Resolved) -> bool {
        let swept = |resolved: &Resolved| {
            let is_swept = |name: &str| self.study.sweeps.iter().any(|sweep| sweep.key.name.ends_with(name));
            let filter = resolved.chart.filter();
            (!filter.is_empty() && filter.iter().all(|(name, _)| is_swept(name))).then_some(filter)
        };
        let is_alike = self.x.name == other.x.name && self.estimate.name == other.estimate.name;
        is_alike && swept(self).zip(swept(other)).is_some_and(|(one, two)| one != two)
    }

    /// A headline with the values of swept keys under which the chart shows it.
    fn with_conditions(&self, told: Option<String>) -> Option<String> {
        let of_row = |(name, value): (String, String)| {
            let swept = self.study.sweeps.iter().find(|sweep| sweep.key.name.ends_with(&name))?;
            let column = self.shown.table.column(swept.key.name).ok()?;
            let value = value.parse::<f64>().map_or(value, |number| significant(number, 6));
            Some(column.valued(&value))
                .filter(|valued| told.as_ref().is_some_and(|told| !told.contains(valued)))
        };
        let under: Vec<String> = self.chart.filter().into_iter().filter_map(of_row).collect();
        match under.is_empty() {
            true => told,
            false => told.map(|told| format!("{told} That is for {}.", listed(&under))),
        }
    }

    /// A remark that the least value is at an end of the range of a chosen abscissa.
    fn at_end(&self, by: &[&Column]) -> &'static str {
        let is_chosen = self.has_curves() && !is_given(self.x) && self.x.usual.is_none();
        let row = best(&self.shown.table, self.estimate, &self.rows, by).and_then(|best| best.row);
        let x = row.and_then(|row| self.x.cells[row].number());
        let all = || self.rows.iter().filter_map(|&row| self.x.cells[row].number());
        let ends = [all().reduce(f64::min), all().reduce(f64::max)];
        let is_end = is_chosen && x.is_some() && ends[0] < ends[1] && ends.contains(&x);
        if is_end { " It is the end of the range." } else { "" }
    }

    fn has_curves(&self) -> bool {
        matches!(self.drawn.picture, Picture::Curves(_))
    }

    /// The columns that distinguish rows, with those of the chart first.
    fn by(&self) -> Result<Vec<&'a Column>, ColumnError> {
        let columns = self.series.iter().copied().chain([self.x]).collect();
        apart(self.study, self.chart.source, &self.shown.table, columns)
    }

    /// The verdict, after the minimum of a chart over the switching interval: the interval is chosen, so the limit
    /// alone does not answer the question.
    fn judged(&self, verdict: &Verdict) -> Result<Option<String>, ColumnError> {
        // Fillers that firmware cannot have answer no question on a limit, unless there are no others.
        let names = Bandless::of(self.study, &self.shown.table).map(|bandless| bandless.names);
        let is_usable = |answer: &&Judged| {
            let is_bandless = |cell: &Cell| names.iter().flatten().any(|name| cell.text() == *name);
            !answer.series.iter().any(|(column, cell)| column.of == FILLERS && is_bandless(cell))
        };
        let usable: Vec<Judged> = verdict.answers.iter().filter(is_usable).cloned().collect();
        let are_left_out = !usable.is_empty() && usable.len() < verdict.answers.len();
        let judged = of_verdict(if are_left_out { &usable } else { &verdict.answers }, verdict.limit);
        let chosen = match self.interval_for_each() {
            None if self.is_over_interval() => {
                best(&self.shown.table, self.estimate, &self.rows, &self.by()?).map(|best| best.sentence())
            }
            told => told,
        };
        let told = match chosen {
            Some(best) => judged.map(|judged| format!("{best} {judged}")),
            None => judged,
        };
        Ok(self.with_caveat(told, are_left_out))
    }

    fn of_picture(&self) -> Result<Option<String>, ColumnError> {
        if let Picture::Map(map) = &self.drawn.picture {
            return Ok(self.with_caveat(of_map(map), false));
        }
        let (table, by, filter) = (&self.shown.table, self.by()?, self.chart.filter());
        let ground = self.study.ground(self.chart.source);
        let whole =
            ground.and_then(|ground| ground.texts.iter().find_map(|text| Some((text.name, text.whole?))));
        let is_by_part = self.shown.is_named(self.chart) || self.x.role == Role::Coordinate;
        let whole = whole.filter(|(name, _)| is_by_part && filter.iter().all(|(column, _)| column != name));
        if let Some((name, whole)) = whole {
            // The least of all ticks says nothing about a compensation; the remainder in their sum does.
            let all = [&filter[..], &[(name.to_owned(), whole.to_owned())]].concat();
            let sums = table.rows_where(&all).unwrap_or_default();
            if let Some(beside) =
                side_by_side(self.estimate, &sums, &by).filter(|_| sums.len() <= MOST_BESIDE)
            {
                return Ok(Some(format!("All ticks together, {beside}.")));
            }
        }
        let curves = if self.is_environment() { self.curves() } else { None };
        let told = curves.and_then(|curves| curves.least_at_worst());
        let told = told.or_else(|| self.interval_for_each()).or_else(|| self.best_for_each_given());
        if let Some(told) = told.or_else(|| self.course()) {
            return Ok(self.with_caveat(Some(told), false));
        }
        let leading = leading(self.study, table, self.estimate, &self.rows, &by);
        let end = self.at_end(&by);
        Ok(leading.map(|leading| format!("{leading}{end}{}", self.beside_names().unwrap_or_default())))
    }

    /// The course of curves of which no single value is the answer.
    fn course(&self) -> Option<String> {
        let curves = Curves::of(self.x, self.estimate, &self.rows, &self.series);
        let is_error = less_is_better(&self.shown.table, self.estimate, &self.rows);
        let has_places = self.shown.table.usual(Usual::Places).is_some();
        let is_over_time = self.x.usual == Some(Usual::Abscissa) && !has_places;
        match self.estimate.role {
            _ if !self.has_curves() => None,
            Role::Fraction => curves.half(|rows| is_absent(&self.shown.table, rows)),
            _ if is_error && is_given(self.x) && !self.is_environment() => curves.growth(),
            _ if is_error && is_over_time => curves.minima(&self.series),
            Role::Estimate if !is_error && self.study.kind().is_exact => {
                curves.peaks().or_else(|| curves.ranges())
            }
            // Neither end of the range is better, and a condition is nobody's choice.
            Role::Estimate if !is_error && is_given(self.x) => curves.ranges(),
            _ => None,
        }
    }

    /// The least value for each name in a column of series other than fillers, as a further sentence.
    fn beside_names(&self) -> Option<String> {
        if is_given(self.x) || !less_is_better(&self.shown.table, self.estimate, &self.rows) {
            return None;
        }
        let is_named = |column: &&&Column| {
            column.of != FILLERS && self.rows.iter().all(|&row| matches!(column.cells[row], Cell::Text(_)))
        };
        let names = self.series.iter().find(is_named)?;
        let groups = grouped(self.rows.iter().copied(), |row| names.cells[row].text());
        let least = |(name, rows): &(String, Vec<usize>)| {
            let known = rows.iter().filter(|&&row| self.estimate.cells[row].number().is_some());
            let row = *known.min_by(|&&a, &&b| self.estimate.value(a).total_cmp(&self.estimate.value(b)))?;
            let place = match self.x.cells[row].number() {
                Some(x) => format!(" at {}", self.x.valued(&significant(x, 3))),
                None => String::new(),
            };
            Some(format!("{name} {}{place}", measured(self.estimate, self.estimate.value(row))))
        };
        let told: Vec<String> = groups.iter().map(least).collect::<Option<_>>()?;
        let is_few = (2..=MOST_BESIDE).contains(&told.len());
        is_few.then(|| format!(" The least by {}: {}.", names.label, told.join(", ")))
    }

    /// The minimum over the switching interval for each condition or requirement of a gyro, if its curves differ in
    /// these; the best of all of them would not help the others.
    fn interval_for_each(&self) -> Option<String> {
        if !self.is_over_interval() || !less_is_better(&self.shown.table, self.estimate, &self.rows) {
            return None;
        }
        let (given, chosen): (Vec<&Column>, Vec<&Column>) =
            self.series.iter().copied().partition(|column| is_given(column));
        let curves = Curves::of(self.x, self.estimate, &self.rows, &given);
        curves.least_for_each([&given, &chosen], MOST_BESIDE)
    }

    /// The minimum over a swept key that is chosen, for each of the conditions in which the curves differ.
    fn best_for_each_given(&self) -> Option<String> {
        let is_swept = self.study.sweeps.iter().any(|sweep| sweep.key.name == self.x.name);
        let is_chosen = is_swept && !is_given(self.x) && self.has_curves();
        let are_given = !self.series.is_empty() && self.series.iter().all(|column| is_given(column));
        self.curves().filter(|_| is_chosen && are_given)?.least_for_each([&self.series, &[]], MOST_BESIDE)
    }

    fn is_over_interval(&self) -> bool {
        self.x.name == INTERVAL.name
    }

    /// Whether the abscissa is a condition that is not chosen, so that the worst case counts.
    fn is_environment(&self) -> bool {
        let key = if self.x.role == Role::Coordinate { &self.x.of } else { &self.x.name };
        key.starts_with("motion.")
    }

    /// The curves of the chart, if less of the estimate is better.
    fn curves(&self) -> Option<Curves<'a>> {
        less_is_better(&self.shown.table, self.estimate, &self.rows)
            .then(|| Curves::of(self.x, self.estimate, &self.rows, &self.series))
    }

    /// A headline with a caveat on the fillers among the rows of the chart, which the headline may leave out.
    fn with_caveat(&self, headline: Option<String>, are_left_out: bool) -> Option<String> {
        let Some(Bandless { column, mut names, why }) = Bandless::of(self.study, &self.shown.table) else {
            return headline;
        };
        names.retain(|name| self.rows.iter().any(|&row| column.cells[row].text() == *name));
        if names.is_empty() {
            return headline;
        }
        let (is, they, all) = match names.len() {
            1 => ("is", "it is", listed(&names)),
            _ => ("are", "they are", listed(&names)),
        };
        let subject = match are_left_out {
            true => format!("Left out {is} {all}: without a band {they}"),
            false => format!("Without a band {all} {is}"),
        };
        let caveat = format!("{subject} designed for {why}, which firmware does not know.");
        headline.map(|headline| format!("{headline} {caveat}"))
    }
}

/// The best row, and where that has a filler that firmware cannot have, the best of the others.
fn leading(
    study: &Study,
    table: &Table,
    estimate: &Column,
    rows: &[usize],
    by: &[&Column],
) -> Option<String> {
    let first = best(table, estimate, rows, by)?;
    let sentence = first.sentence();
    let Some((row, Bandless { column, names, why })) = first.row.zip(Bandless::of(study, table)) else {
        return Some(sentence);
    };
    let is_bandless = |row: usize| names.contains(&column.cells[row].text().as_str());
    if !is_bandless(row) {
        return Some(sentence);
    }
    let others: Vec<usize> = rows.iter().copied().filter(|&row| !is_bandless(row)).collect();
    let aim = format!("designed for {why}, which firmware does not know");
    Some(match best(table, estimate, &others, by) {
        Some(second) => format!(
            "{} Fillers that are {aim}, are left out; the least of them is {}.",
            second.sentence(),
            first.value
        ),
        None => format!("{sentence} That filler is {aim}."),
    })
}

/// The best row of a study without its own chart.
fn undrawn(study: &Study, points: &Table) -> Option<String> {
    let estimate = points.usual(Usual::Answer)?;
    // Errors and angles that the study omits have no rows.
    let filter = Some(study.usual_rows()).filter(|rows| points.rows_where(rows).is_ok()).unwrap_or_default();
    let rows = points.rows_where(&filter).ok()?;
    // Every study of the kind has the columns.
    let abscissa = points.usual(Usual::Abscissa).into_iter().collect();
    let by = apart(study, Source::Points, points, abscissa).ok()?;
    leading(study, points, estimate, &rows, &by)
}

/// The columns that distinguish rows, each once, after some `columns`.
pub(crate) fn apart<'t>(
    study: &Study,
    source: Source,
    table: &'t Table,
    mut columns: Vec<&'t Column>,
) -> Result<Vec<&'t Column>, ColumnError> {
    let sweeps = study.sweeps.iter().map(|sweep| sweep.key.name);
    for name in study.text_columns(source).into_iter().chain(sweeps) {
        if columns.iter().all(|column| column.name != name) {
            columns.push(table.column(name)?);
        }
    }
    Ok(columns)
}
