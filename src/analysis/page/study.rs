//! The page of a study, with the sections that only some have.

use crate::analysis::answer::{facts, of_study};
use crate::analysis::decision::{DecisionError, decide, judge};
use crate::analysis::dynamic::{Dynamic, report};
use crate::analysis::log::Analysis;
use crate::analysis::page::record::by_name;
use crate::analysis::page::{chart, interval, study_file};
use crate::analysis::temperature::Temperature;
use crate::analysis::temperature::report::{Row, notes, rows};
use crate::analysis::{agreement, data_sheet, dynamic, temperature};
use crate::view::picture::{Drawn, incomplete, pictures, shown};
use crate::view::stack::Shown;
use sagnac_base::progress::Progress;
use sagnac_base::quantity::number::{short, significant};
use sagnac_base::table::text::hexadecimal;
use sagnac_base::table::{Cell, Role, Table};
use sagnac_engine::run::{Plan, RunError, Tables};
use sagnac_engine::store::error::StoreError;
use sagnac_engine::store::{Provenance, Store};
use sagnac_engine::study::{Input, Study};
use sagnac_report::answer::Answer;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Grid, Page, Section};
use sha2::{Digest, Sha256};

/// Most bytes of a file that a page shows.
const MAX_BYTES: usize = 16 << 10;

/// The results of a study that a store holds, with their answer.
pub struct Results<'a> {
    plan: &'a Plan<'a>,
    tables: &'a Tables,
    lacking: u64,
    /// The trials of a study that repeats the run.
    held: u64,
    provenance: Vec<Provenance>,
    notes: Vec<String>,
    charts: Vec<Drawn>,
    /// The part of a table that each chart shows.
    pub curves: Vec<Shown<'a>>,
    answer: Answer,
    /// Whether facts of the answer have to be sampled, which [`add_sampled_facts`] does.
    pub is_partial: bool,
}

/// The note of a page that is there before it is complete.
pub const PARTIAL: &str = "the error budget and the change that helps most are still being computed; the page is written again with them";

impl<'a> Results<'a> {
    /// The results from `tables`, which the plan made from the store, and which lack so many trials. `degraded` lists the
    /// deviations of a run from the requested execution. Facts that have to be sampled are left to [`add_sampled_facts`].
    ///
    /// # Errors
    /// The table lacks something that a chart requires, a row of the store is damaged, or the disk fails.
    pub fn new(
        plan: &'a Plan,
        store: &Store,
        tables: &'a Tables,
        lacking: u64,
        degraded: &[String],
    ) -> Result<Results<'a>, DecisionError> {
        let study = plan.study();
        let of_store = || {
            let index = store.index()?;
            let held = plan.held(&index)?;
            let uneven = if study.precision.is_some() { None } else { uneven(&tables.points) };
            let notes = incomplete(lacking).into_iter().chain(degraded.iter().cloned());
            let notes = notes.chain(plan.notes(store, &index, held)?).chain(uneven).collect();
            Ok::<_, StoreError>((notes, held, store.provenance()?))
        };
        // Both take long for a long table.
        let (mut charts, mut curves) = (Ok(vec![]), Ok(vec![]));
        let found = rayon::in_place_scope(|scope| {
            scope.spawn(|_| charts = pictures(study, tables, lacking));
            scope.spawn(|_| curves = shown(study, tables));
            of_store()
        });
        let (mut charts, curves) = (charts?, curves?);
        let (notes, held, provenance) = found.map_err(RunError::from)?;
        let sheet = if lacking > 0 { None } else { judge(study, tables)? };
        let answer = of_study(study, tables, &mut charts, &curves, lacking, sheet.as_ref())?;
        let is_partial = sheet.is_some_and(|sheet| sheet.is_partial);
        Ok(Results { plan, tables, lacking, held, provenance, notes, charts, curves, answer, is_partial })
    }

    /// The study that repeats the run.
    pub fn resolved(&self) -> String {
        self.plan.study().resolved(self.held)
    }

    /// The page without its tables, which [`Tables::into_files`] names. `digest` is the SHA-256 of the points that
    /// [`Table::write_csv`] returned.
    pub fn page(self, digest: &str) -> Page {
        let study = self.plan.study();
        let made = Section::new("source", "How it was made", self.made(digest));
        let mut charts = self.charts;
        // The chart that the answer marks is first.
        charts.sort_by_key(|drawn| !drawn.picture.is_marked());
        let trials = self.plan.is_sampled().then(|| format!(" × {} trials", short(study.trials as f64)));
        Page {
            title: study.title.clone(),
            subtitle: study.question.clone(),
            scope: format!("{}{}", points(study.points()), trials.unwrap_or_default()),
            answer: self.answer,
            notes: self.notes,
            sections: vec![
                Section::new("charts", "Charts", charts.into_iter().map(Block::Chart)),
                agreement::section(&self.tables.points),
                made,
            ],
            tables: vec![],
        }
    }

    /// How the results were made, and how to make them again.
    fn made(&self, digest: &str) -> Vec<Block> {
        let (study, kind) = (self.plan.study(), self.plan.study().kind());
        let mut facts = vec![("Study", vec![format!("{}, {}", kind.name, points(study.points()))])];
        let asked = match study.precision {
            _ if !self.plan.is_sampled() => "none: every value is a formula".to_owned(),
            None => grouped(self.held),
            Some(_) => {
                format!("at most {}, fewer where a point reaches its precision earlier", grouped(self.held))
            }
        };
        let missing = match self.lacking {
            0 => String::new(),
            lacking => format!(", of which {} over all points are missing", grouped(lacking)),
        };
        facts.extend(self.plan.is_sampled().then(|| ("Seed", vec![study.seed.to_string()])));
        facts.push(("Trials at each point", vec![asked + &missing]));
        let sampled = Provenance::trials_of(&self.provenance);
        if sampled > 0 {
            let again =
                if self.plan.counts_again(sampled) { ", counted once per separate launch" } else { "" };
            let all = std::iter::once(format!("{} trials in all{again}", grouped(sampled)));
            facts.push(("Sampled", all.chain(self.provenance.iter().map(by_device)).collect()));
        }
        let kernels = (kind.kernels)();
        let kernels = if kernels.is_empty() { kernels } else { format!("; kernels {kernels}") };
        facts.push(("Program", vec![format!("sagnac {}{kernels}", env!("CARGO_PKG_VERSION"))]));
        facts.push(("SHA-256 of points.csv", vec![format!("`{digest}`")]));
        let inputs = study.inputs();
        let beside = match inputs.len() {
            0 => "",
            _ => ", the files that it names in a folder `inputs` next to it,",
        };
        let result = match self.lacking {
            0 => "Then `again/points.csv` has the SHA-256 given above.",
            _ => {
                "This samples all trials, so `again/points.csv` will differ from the partial one, whose SHA-256 is given above."
            }
        };
        let again = format!(
            "The same study gives the same bits on any machine, device and number of threads. Save it as `study.toml`{beside} and run"
        );
        let blocks = [
            Block::Facts(facts),
            Block::Text(again),
            Block::Command("sagnac run study.toml --out again".to_owned()),
            Block::Text(result.to_owned()),
            study_file(study, self.held),
        ];
        blocks.into_iter().chain(inputs.into_iter().map(input)).collect()
    }
}

/// Adds the facts that have to be sampled to the answer on the page of a study, which has its tables: the error budget, and the
/// change of an input that helps most. `progress` receives the evaluations.
///
/// # Errors
/// A point cannot be evaluated again, or no threads can be started.
pub fn add_sampled_facts(
    study: &Study,
    page: &mut Page,
    progress: &dyn Progress,
) -> Result<(), DecisionError> {
    let tables = Tables::from_files(std::mem::take(&mut page.tables));
    let sheet = decide(study, &tables, progress)?;
    page.answer.facts = facts(study, &tables, sheet.as_ref(), &page.answer);
    page.tables = tables.into_files(&study.charts);
    Ok(())
}

/// A file that a study names; of a long one its digest.
fn input(input: &Input) -> Block {
    let Input { name, text, .. } = input;
    if text.len() <= MAX_BYTES {
        return Block::File(name.clone(), text.to_string());
    }
    let digest = hexadecimal(&Sha256::digest(text.as_bytes()));
    Block::Text(format!("`{name}` is in the results folder; its SHA-256 is `{digest}`"))
}

/// A number of points.
fn points(count: usize) -> String {
    if count == 1 { "1 point".to_owned() } else { format!("{count} points") }
}

/// The trials of a device with their rate.
fn by_device(by: &Provenance) -> String {
    let rate = match by.trials as f64 / by.seconds {
        _ if by.seconds <= 0.0 => String::new(),
        rate if rate < 1e6 => format!(", {} per second", significant(rate, 3)),
        rate => format!(", {} million per second", significant(rate / 1e6, 3)),
    };
    format!("{}: {} in {} s{rate}", by.device, grouped(by.trials), significant(by.seconds, 3))
}

/// A note that rows have different numbers of trials.
fn uneven(table: &Table) -> Option<String> {
    let column = table.of_role(Role::Trials)?;
    let trials = || column.cells.iter().filter_map(Cell::number);
    let (least, most) = (trials().reduce(f64::min)?, trials().reduce(f64::max)?);
    (least < most).then(|| format!("rows are from {} to {} trials", short(least), short(most)))
}

/// A count with separated thousands.
fn grouped(count: u64) -> String {
    let figures = count.to_string();
    let groups: Vec<_> = figures.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    groups.join("\u{202f}")
}

/// The section on the dependence of a log on temperature, with its analyses before and after compensation.
pub fn of_temperature(found: &Temperature, [before, after]: [&Analysis; 2]) -> Section {
    let charts = temperature::report::figures(found, [before, after]).into_iter();
    let charts = charts.map(|(stem, figure)| chart(&stem, Picture::Curves(figure)));
    let row = |(column, row): (&str, Row)| {
        let interval = row.interval.map(interval).unwrap_or_default();
        let value = row.value.map_or_else(|| "–".to_owned(), |value| significant(value, 4));
        let [_, unit] = row.unit;
        [column.to_owned(), row.name.to_owned(), value, interval, unit, row.verdict]
    };
    let of_column = |column| rows(column).into_iter().map(move |row| (&*column.name, row));
    let rows = found.columns.iter().flat_map(of_column).map(row);
    let head = ["column", "coefficient", "value", "95 % interval", "unit", "status"];
    let grids = [Grid::new(head, rows), compensated(found, [before, after])].into_iter();
    let grids = grids.filter(|grid| !grid.rows.is_empty()).map(Block::Grid);
    let range = found.columns.iter().filter_map(|column| {
        let [low, high] = column.found.as_ref().ok()?.averages.range_c.map(|end| significant(end, 4));
        Some((&*column.name, format!("{low} to {high} °C")))
    });
    let range = by_name(range.collect());
    let range = (!range.is_empty()).then(|| Block::Facts(vec![("Range", range)]));
    let notes = notes(found).into_iter().map(Block::Note);
    Section::new("temperature", "Temperature", charts.chain(grids).chain(range).chain(notes))
}

/// The coefficients of the noise before and after compensation, in the order before.
fn compensated(found: &Temperature, sides: [&Analysis; 2]) -> Grid {
    let of_column = |place: usize| {
        let [before, after] = sides.map(|side| side.columns[place].coefficients());
        let value = |rows: &[data_sheet::Row], name: &str| {
            let value = rows.iter().find(|row| row.name == name).and_then(|row| row.value);
            value.map_or_else(|| "–".to_owned(), |value| significant(value, 4))
        };
        let name = &*sides[0].columns[place].name;
        let rows = data_sheet::each_once(before.iter().chain(after)).into_iter().map(move |row| {
            let [before, after] = [before, after].map(|rows| value(rows, row.name));
            [name.to_owned(), row.name.to_owned(), before, after, row.symbol.to_owned()]
        });
        rows.collect::<Vec<_>>()
    };
    let known = (0..found.columns.len()).filter(|&place| found.columns[place].found.is_ok());
    let head = ["column", "noise", "before compensation", "after", "unit"];
    Grid::new(head, known.flat_map(of_column))
}

/// The section on navigators with the gyros of a log, beside another answer.
pub fn of_navigators(found: &Answer) -> Section {
    let headline = Block::Text(format!("{}.", found.headline));
    Section::new("navigators", "Navigators", [headline, Block::Options(found.table.clone())])
}

/// The section on the noise of a log over time.
pub fn of_dynamic(found: &Dynamic) -> Section {
    let said = found.columns.iter().map(|column| (&*column.name, report::sentence(column))).collect();
    let said = by_name(said).into_iter().map(Block::Text);
    let maps = dynamic::report::figures(found).into_iter();
    let maps = maps.map(|(stem, map)| chart(&stem, Picture::Map(map)));
    Section::new("dynamic", "Over time", said.chain(maps))
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn counts_have_their_thousands_apart() {
        let shown = [7, 999, 1000, 72_000_000].map(|count| grouped(count).replace('\u{202f}', " "));
        assert_eq!(shown, ["7", "999", "1 000", "72 000 000"]);
    }
}
