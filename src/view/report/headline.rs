//! A chart of a study with its answer.

use crate::chart::Chart;
use crate::chart::ground::Text;
use crate::drift::schedule::INTERVAL;
use crate::filler::FILLERS;
use crate::kinds::allan::columns::is_absent;
use crate::quantity::list::listed;
use crate::quantity::number::significant;
use crate::study::Study;
use crate::table::{Cell, Column, ColumnError, Role, Table, Usual, grouped};
use crate::view::chart::picture::Picture;
use crate::view::chart::stack::Shown;
use crate::view::picture::Drawn;
use crate::view::picture::verdict::Verdict;
use crate::view::report::answer::{apart, is_given, leading};
use crate::view::report::bandless::Bandless;
use crate::view::report::curves::Curves;
use crate::view::report::sentences::{best, less_is_better, measured, of_map, side_by_side};
use crate::view::report::standing::of_verdict;
use crate::view::verdict::Answer as Judged;

/// Most rows or curves that a headline lists side by side.
const MOST_BESIDE: usize = 4;

/// A drawn chart of a study with its columns and rows, looked up in its table.
pub(super) struct Resolved<'a> {
    study: &'a Study,
    pub(super) chart: &'a Chart,
    pub(super) shown: &'a Shown<'a>,
    pub(super) drawn: &'a Drawn,
    pub(super) x: &'a Column,
    pub(super) estimate: &'a Column,
    series: Vec<&'a Column>,
    rows: Vec<usize>,
}

impl<'a> Resolved<'a> {
    pub(super) fn of(
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

    /// The swept keys of which the chart shows a single value, with that value.
    fn conditions(&self) -> Vec<(&'a Column, String)> {
        let of_row = |(name, value): (String, String)| {
            let column = self.shown.table.column(&name).ok()?;
            let is_swept = self.study.sweeps.iter().any(|sweep| sweep.key.name == column.name);
            is_swept.then_some((column, value))
        };
        self.chart.filter().into_iter().filter_map(of_row).collect()
    }

    /// Whether another chart has the same curves for another value of a swept key, and no other rows.
    pub(super) fn is_continued_by(&self, other: &Resolved) -> bool {
        let values = |resolved: &Resolved| {
            let conditions = resolved.conditions();
            let is_all = conditions.len() == resolved.chart.filter().len();
            let named = conditions.into_iter().map(|(column, value)| (column.name.clone(), value));
            is_all.then(|| named.collect::<Vec<_>>()).filter(|all| !all.is_empty())
        };
        let is_alike = self.x.name == other.x.name && self.estimate.name == other.estimate.name;
        is_alike && values(self).zip(values(other)).is_some_and(|(one, two)| one != two)
    }

    /// A headline with the values of swept keys for which the chart shows it.
    pub(super) fn with_conditions(&self, told: Option<String>) -> Option<String> {
        let told = told?;
        let valued = |(column, value): (&Column, String)| {
            column.valued(&value.parse::<f64>().map_or(value, |number| significant(number, 6)))
        };
        let mut under: Vec<String> = self.conditions().into_iter().map(valued).collect();
        under.retain(|valued| !told.contains(valued));
        let under = (!under.is_empty()).then(|| format!("for {}", listed(&under)));
        let parts: Vec<String> = self.moment().map(str::to_owned).into_iter().chain(under).collect();
        Some(if parts.is_empty() { told } else { format!("{told} That is {}.", parts.join(", ")) })
    }

    /// When its estimates hold, where another chart of the study shows those of another time.
    fn moment(&self) -> Option<&'static str> {
        let filter = self.chart.filter();
        let ground = self.study.ground(self.chart.source)?;
        let of_text = |text: &Text| {
            let of = |filter: &[(String, String)]| {
                filter.iter().find(|(name, _)| name == text.name).map(|(_, value)| value.clone())
            };
            let own = of(&filter)?;
            let differs = |other: &Chart| of(&other.filter()).is_some_and(|value| value != own);
            self.study.charts.iter().any(differs).then(|| (text.when)(&own)).flatten()
        };
        ground.texts.iter().find_map(of_text)
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

    pub(super) fn has_curves(&self) -> bool {
        matches!(self.drawn.picture, Picture::Curves(_))
    }

    /// The columns that distinguish rows, with those of the chart first.
    fn by(&self) -> Result<Vec<&'a Column>, ColumnError> {
        let columns = self.series.iter().copied().chain([self.x]).collect();
        apart(self.study, self.chart.source, &self.shown.table, columns)
    }

    /// The verdict, after the minimum of a chart over the switching interval: the interval is chosen, so the limit
    /// alone does not answer the question.
    pub(super) fn judged(&self, verdict: &Verdict) -> Result<Option<String>, ColumnError> {
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

    pub(super) fn of_picture(&self) -> Result<Option<String>, ColumnError> {
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
    pub(super) fn is_environment(&self) -> bool {
        let key = if self.x.role == Role::Coordinate { &self.x.of } else { &self.x.name };
        key.starts_with("motion.")
    }

    /// The curves of the chart, if less of the estimate is better.
    pub(super) fn curves(&self) -> Option<Curves<'a>> {
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
