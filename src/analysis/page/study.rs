//! The page of a study, and the agreement of simulated values with their closed forms.

use crate::analysis::answer::of_study;
use crate::analysis::decision::{DecisionError, judge};
use crate::analysis::page::study_file;
use crate::view::{Drawn, incomplete, pictures, shown};
use sagnac_base::quantity::number::{short, significant};
use sagnac_base::table::text::hexadecimal;
use sagnac_base::table::{Cell, Column, Role, Table};
use sagnac_engine::run::{Plan, RunError, Tables};
use sagnac_engine::store::error::StoreError;
use sagnac_engine::store::{Provenance, Store};
use sagnac_engine::study::Input;
use sagnac_report::answer::reading::{capitalized, place};
use sagnac_report::answer::{Answer, Check};
use sagnac_report::page::{Block, Cell as GridCell, Grid, Page, Section};
use sha2::{Digest, Sha256};
use statrs::function::erf::erfc_inv;

/// Most bytes of a file that a page shows.
const MAX_BYTES: usize = 16 << 10;

/// The results of a study that a store holds, with their answer.
pub(crate) struct Results<'a> {
    plan: &'a Plan<'a>,
    tables: &'a Tables,
    lacking: u64,
    /// The trials of a study that repeats the run.
    held: u64,
    provenance: Vec<Provenance>,
    notes: Vec<String>,
    charts: Vec<Drawn>,
    answer: Answer,
    /// Whether facts of the answer have to be sampled, which [`StudyOutcome::complete`](crate::use_cases::StudyOutcome::complete) does.
    pub(crate) is_partial: bool,
}

impl<'a> Results<'a> {
    /// The results from `tables`, which the plan made from the store, and which lack so many trials. `degraded` lists the
    /// deviations of a run from the requested execution. Facts that have to be sampled are left out.
    ///
    /// # Errors
    /// The table lacks something that a chart requires, a row of the store is damaged, or the disk fails.
    pub(crate) fn new(
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
        Ok(Results { plan, tables, lacking, held, provenance, notes, charts, answer, is_partial })
    }

    /// The study that repeats the run.
    pub(crate) fn resolved(&self) -> String {
        self.plan.study().resolved(self.held)
    }

    /// The page without its tables, which [`Tables::into_files`] names. `digest` is the SHA-256 of the points that
    /// [`Table::write_csv`] returned.
    pub(crate) fn page(self, digest: &str) -> Page {
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
                closed_forms(&self.tables.points),
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

/// The deviations of an estimate from its closed form, in standard errors of the simulation.
#[derive(Debug, Clone, PartialEq)]
struct Agreement {
    /// Quantity that deviates, such as `rms error`.
    of: String,
    /// Number of rows with a closed form.
    rows: usize,
    /// Root mean square of the deviations, which is near 1 if they are due to chance only.
    rms: f64,
    /// The largest magnitude.
    largest: f64,
    /// Index of its row.
    at: usize,
}

/// The agreement of every estimate of a table that has closed forms.
fn agreements(table: &Table) -> Vec<Agreement> {
    let deviations = table.columns.iter().filter(|column| column.role == Role::Z);
    let of_column = |column: &Column| {
        Agreement::new(table.referred(column).unwrap_or(column).label.clone(), [column].into_iter())
    };
    deviations.filter_map(of_column).collect()
}

/// The agreement of all estimates as a check.
pub(crate) fn agreement(table: &Table) -> Option<Check> {
    let all = agreements(table);
    (!all.is_empty()).then(|| Check::Theory {
        values: all.iter().map(|one| one.rows).sum(),
        max_abs_z: all.iter().map(|one| one.largest).fold(0.0, f64::max),
        holds: all.iter().all(Agreement::holds),
    })
}

/// The section on closed forms, with a row for each estimate and one for the representation of the inputs by integers; without
/// blocks where nothing has a closed form.
fn closed_forms(table: &Table) -> Section {
    let row = |one: &Agreement, number: &dyn Fn(f64) -> String, below: &str, expected: String| {
        let largest = GridCell { text: number(one.largest), below: below.to_owned() };
        let first = [capitalized(&one.of), one.rows.to_string(), number(one.rms)].map(GridCell::from);
        first.into_iter().chain([largest, expected.into(), place_of(table, one.at).into()]).collect()
    };
    let of_estimate = |one: &Agreement| {
        let number = |z| significant(z, 3);
        let below = if one.holds() { "" } else { "by chance in less than 0.1 % of cases" };
        row(one, &number, below, [0.025, 0.975].map(|p| number(largest_normal(one.rows, p))).join(" … "))
    };
    let mut rows: Vec<Vec<GridCell>> = agreements(table).iter().map(of_estimate).collect();
    let mut text = "z is the difference from the closed form in standard errors; the largest of as many normal numbers is in the \
                    expected range in 95 of 100 cases."
        .to_owned();
    let columns = table.columns.iter().filter(|column| column.role == Role::Representation);
    if let Some(one) = Agreement::new("representation".to_owned(), columns).filter(|_| !rows.is_empty()) {
        let percent = |part: f64| format!("{} %", significant(100.0 * part, 2));
        rows.push(row(&one, &percent, "", "within rounding".to_owned()));
        text += " Representation is the relative difference of the closed forms for the sampled integers and for the inputs.";
    }
    let head = ["quantity", "values", "rms z", "max |z|", "expected", "at"];
    let blocks = (!rows.is_empty()).then(|| [Block::Text(text), Block::Grid(Grid::new(head, rows))]);
    Section::new("closed-forms", "Closed forms", blocks.into_iter().flatten())
}

/// The p quantile of the largest of n independent standard normal magnitudes, below which all n lie with probability p.
fn largest_normal(n: usize, p: f64) -> f64 {
    // 1 − p^(1/n), accurate even where it is tiny.
    let beyond = -libm::expm1(libm::log(p) / n as f64);
    std::f64::consts::SQRT_2 * erfc_inv(beyond)
}

impl Agreement {
    /// The sum of what is known of some columns; `None` without any.
    fn new<'t>(of: String, columns: impl Iterator<Item = &'t Column> + Clone) -> Option<Agreement> {
        let cells = || columns.clone().flat_map(|column| column.cells.iter().enumerate());
        let known = || cells().filter_map(|(row, cell)| Some((row, cell.number()?.abs())));
        let (at, largest) = known().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let rows = known().count();
        let squares: f64 = known().map(|(_, z)| z * z).sum();
        Some(Agreement { of, rows, rms: libm::sqrt(squares / rows as f64), largest, at })
    }

    /// Whether chance explains the largest deviation, which would be as large in more than one of 1000 cases.
    fn holds(&self) -> bool {
        self.largest <= largest_normal(self.rows, 0.999)
    }
}

/// The cells that distinguish a row; of a key and what follows from it, only the key.
fn place_of(table: &Table, row: usize) -> String {
    let told = table.columns.iter().take_while(|column| column.role != Role::Trials);
    let told = told.filter(|column| column.role != Role::Coordinate || column.of.is_empty());
    let unlike = told.filter(|column| column.cells.iter().any(|cell| *cell != column.cells[row]));
    place(&unlike.collect::<Vec<_>>(), row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_their_thousands_apart() {
        let shown = [7, 999, 1000, 72_000_000].map(|count| grouped(count).replace('\u{202f}', " "));
        assert_eq!(shown, ["7", "999", "1 000", "72 000 000"]);
    }

    fn table(z: &[Option<f64>]) -> Table {
        let column = |name: &str, role, cells: Vec<Cell>| Column {
            name: name.to_owned(),
            label: format!("the {name}"),
            role,
            of: if role == Role::Z { "rms".to_owned() } else { String::new() },
            cells: cells.into(),
            ..Column::default()
        };
        let fillers = (0..z.len()).map(|row| Cell::Text(format!("filler {row}"))).collect();
        let numbers = |value: f64| vec![Cell::Number(value); z.len()];
        Table {
            columns: vec![
                column("filler", Role::Key, fillers),
                column("trials", Role::Trials, numbers(8.0)),
                column("rms", Role::Error, numbers(1.0)),
                column("z", Role::Z, z.iter().map(|z| Cell::from(*z)).collect()),
            ],
        }
    }

    /// The texts of the first row of the section.
    fn row(table: &Table) -> Vec<String> {
        let [_, Block::Grid(grid)] = &closed_forms(table).blocks[..] else { panic!("no grid") };
        let cell = |cell: &GridCell| format!("{} {}", cell.text, cell.below).trim_end().to_owned();
        grid.rows[0].iter().map(cell).collect()
    }

    #[test]
    fn the_largest_of_many_is_where_the_normal_distribution_puts_it() {
        // For one magnitude: the quantiles of |z|.
        assert!((largest_normal(1, 0.95) - 1.959_963_985).abs() < 1e-8);
        // All of 100 within 3.3 with (1 − 2·Φ(−3.3))^100.
        let p = libm::pow(libm::erf(3.3 / std::f64::consts::SQRT_2), 100.0);
        assert!((largest_normal(100, p) - 3.3).abs() < 1e-9);
    }

    #[test]
    fn deviations_are_summed_up_over_the_rows_that_have_a_closed_form() {
        let table = table(&[Some(1.0), None, Some(-3.0), Some(2.0)]);
        let found = agreements(&table);
        assert_eq!((found.len(), found[0].rows, found[0].at, found[0].largest), (1, 3, 2, 3.0));
        assert!((found[0].rms - libm::sqrt(14.0 / 3.0)).abs() < 1e-12 && found[0].holds());
        assert_eq!(row(&table), ["The rms", "3", "2.16", "3", "0.375 … 2.64", "filler 2"]);
    }

    #[test]
    fn what_chance_does_not_explain_is_said_and_without_closed_forms_nothing_is() {
        let table = table(&[Some(0.5), Some(6.0)]);
        assert!(
            !agreements(&table)[0].holds() && row(&table)[3] == "6 by chance in less than 0.1 % of cases"
        );
        assert!(closed_forms(&self::table(&[None, None])).blocks.is_empty());
    }
}
