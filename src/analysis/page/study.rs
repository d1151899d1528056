//! The page of a study.

use crate::analysis::agreement;
use crate::analysis::answer::of_study;
use crate::analysis::decision::{DecisionError, judge};
use crate::analysis::page::study_file;
use crate::view::{Drawn, incomplete, pictures, shown};
use sagnac_base::quantity::number::{short, significant};
use sagnac_base::table::text::hexadecimal;
use sagnac_base::table::{Cell, Role, Table};
use sagnac_engine::run::{Plan, RunError, Tables};
use sagnac_engine::store::error::StoreError;
use sagnac_engine::store::{Provenance, Store};
use sagnac_engine::study::Input;
use sagnac_report::answer::Answer;
use sagnac_report::page::{Block, Page, Section};
use sha2::{Digest, Sha256};

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

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn counts_have_their_thousands_apart() {
        let shown = [7, 999, 1000, 72_000_000].map(|count| grouped(count).replace('\u{202f}', " "));
        assert_eq!(shown, ["7", "999", "1 000", "72 000 000"]);
    }
}
