//! Plans of kinds: points that are sampled by launches, and closed forms; and the tables that they make.

use std::cell::Cell;
use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;

use crate::key::sweep::{Sweep, SweepValue};
use crate::key::{Streams, Unrepresentable};
use crate::sampling::batches::{Batch, Budget, Records, Steps, Trials, Wanted, Work, held_by_all, lacking};
use crate::sampling::{Plan, RunError, Tables};
use crate::store::error::StoreError;
use crate::store::{Address, Index, Store};
use crate::study::Study;
use crate::tally::{Block, Id, Share, base_log2, row_log2};
use sagnac_base::diagnostics::StudyError;
use sagnac_base::progress::Progress;
use sagnac_base::table::column::{Growing, columns_of};
use sagnac_base::table::{Cells, Column, ColumnOf, Role, Table};
use sagnac_kernel::curve::Recorded;

/// The identity of a point of a kind, and the key of its random numbers: its own one, or that of all points of the
/// study. `inputs` is everything else on which its draws depend, as lines of text.
pub(crate) fn identity(kind: &str, seed: u64, streams: Streams, inputs: &str) -> (Id, [u32; 2]) {
    let id = Id::from_text(&format!("point\nkind={kind}\nseed={seed}\nstreams={}\n{inputs}", streams.name()));
    match streams {
        Streams::Independent => (id, id.key()),
        Streams::Common => (id, Id::from_text(&format!("streams\nkind={kind}\nseed={seed}\n")).key()),
    }
}

/// The blocks that the store lacks of some estimates, whose trials have that many steps.
pub(crate) type Lacking<'a> = &'a dyn Fn(&[Address], u64) -> Result<Vec<Block>, StoreError>;

/// A lowered point, which launches sample.
pub(crate) trait Launched: fmt::Debug + Send + Sync {
    /// The identity of the point.
    fn id(&self) -> Id;

    /// The addresses of all its estimates.
    fn addresses(&self) -> Vec<Address>;

    /// Number of launches that sample all its estimates.
    fn launches(&self) -> usize;

    /// Its launches, each with the blocks that its estimates lack.
    ///
    /// # Errors
    /// A row of the store is damaged.
    fn work(&self, lacking: Lacking) -> Result<Vec<Work<'_>>, StoreError>;

    /// The least possible number of trials that is at least `asked`.
    fn trials(&self, asked: u64) -> u64 {
        asked
    }
}

/// A plan that turns what a store holds into tables and notes.
pub(crate) trait Tabulated {
    /// The tables of all that the store holds; without a store, all rows without estimates.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError>;

    /// Notes on the results, each a sentence.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn notes(&self, store: &Store) -> Result<Vec<String>, StoreError>;

    /// Doubles the wanted trials of points without the precision of the study; returns whether there were any.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn raise(&self, _wanted: &mut [u64], _store: &Store) -> Result<bool, StoreError> {
        Ok(false)
    }

    /// Stores what a share keeps besides tallies, after its trials.
    ///
    /// # Errors
    /// The disk fails.
    fn keep(&self, _store: &mut Store, _share: Share) -> Result<(), RunError> {
        Ok(())
    }

    /// The amount of missing results that [`keep`](Tabulated::keep) would store.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn lacks_kept(&self, _store: &Store, _share: Share) -> Result<u64, StoreError> {
        Ok(0)
    }
}

/// The plan of a study whose points are all proven to fit. `S` is the part of the study that belongs to its kind, and `L`
/// a point of it, lowered.
#[derive(Debug)]
pub(crate) struct PointsPlan<'a, S, L> {
    pub(crate) study: &'a Study,
    pub(crate) subject: &'a S,
    pub(crate) points: Vec<L>,
}

/// Number of points that are lowered, or looked up, before their order is looked at.
const LOWERED_AT_ONCE: usize = 1024;

/// log2 of the number of trials after which the stop rule first decides.
const MIN_LOG2: u32 = 10;

/// Lowers points, `at_once` of them in parallel, and hands each to `keep`, in order. Returns whether all are lowered, which
/// they are not if `progress` asks to stop.
///
/// # Errors
/// A point cannot be represented, or `keep` refuses it. The first such point in order is reported.
fn lower_all<'a, P: Sync, L: Send>(
    study: &Study,
    points: &'a [P],
    swept: fn(&P) -> &Values,
    at_once: usize,
    lower: impl Fn(&'a P) -> Result<L, Unrepresentable> + Sync,
    mut keep: impl FnMut(L) -> Result<(), StudyError>,
    progress: &dyn Progress,
) -> Result<bool, StudyError> {
    progress.start("points", 0, points.len() as u64);
    let lower = |point: &'a P| {
        if progress.stops() {
            return None;
        }
        let lowered = lower(point);
        progress.advance(1);
        Some(lowered)
    };
    // Points after a refused one are not needed, so they are lowered some at a time.
    for points in points.chunks(at_once) {
        let lowered: Vec<Option<Result<L, Unrepresentable>>> = points.par_iter().map(lower).collect();
        for (point, lowered) in points.iter().zip(lowered) {
            let Some(lowered) = lowered else { return Ok(false) };
            keep(lowered.map_err(|refusal| study.refused(swept(point), &refusal))?)?;
        }
    }
    Ok(true)
}

impl<'a, S, L: Launched> PointsPlan<'a, S, L> {
    /// Lowers every point. `P` is a point before it is lowered, and `swept` gives its values of the swept keys. `None` if
    /// `progress` asks to stop.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change. The first such point in order is reported,
    /// whichever thread found it.
    pub(crate) fn new<P: Sync>(
        study: &'a Study,
        subject: &'a S,
        points: &'a [P],
        swept: fn(&P) -> &Values,
        lower: impl Fn(&'a P) -> Result<L, Unrepresentable> + Sync,
        progress: &dyn Progress,
    ) -> Result<Option<PointsPlan<'a, S, L>>, StudyError> {
        let mut all = Vec::with_capacity(points.len());
        let keep = |lowered| {
            all.push(lowered);
            Ok(())
        };
        let is_complete = lower_all(study, points, swept, LOWERED_AT_ONCE, lower, keep, progress)?;
        Ok(is_complete.then_some(PointsPlan { study, subject, points: all }))
    }

    /// Whether the stop rule applies; it does not apply to a share.
    fn decides(&self, share: Share) -> bool {
        self.study.precision.is_some() && share.is_whole()
    }

    /// The number of trials of each point after which the stop rule first decides; all where there is no rule.
    fn first_wanted(&self, share: Share) -> Vec<u64> {
        let most = self.points.iter().map(|point| point.trials(self.study.trials));
        // Before that many trials, a standard error is too inaccurate to decide on.
        let first = |most: u64| most.min(1 << base_log2(most).max(MIN_LOG2));
        most.map(|most| if self.decides(share) { first(most) } else { most }).collect()
    }

    /// The work that the store lacks of a share of the wanted trials.
    fn missing<'p>(
        &'p self,
        store: &Store,
        wanted: &[u64],
        share: Share,
    ) -> Result<Vec<Work<'p>>, StoreError> {
        let index = store.index()?;
        let (asked, decides) = (self.study.trials, self.decides(share));
        let of_point = |(turn, (point, &trials)): (usize, (&'p L, &u64))| {
            let trials = share.trials(trials, turn);
            let most = point.trials(asked);
            let lacking = |addresses: &[Address], steps: u64| {
                // The stop rule evaluates only the first trials, and so needs rows that end with them.
                let log2 = if decides { base_log2(most) } else { row_log2(most, steps) };
                lacking(&index, addresses, trials.clone(), log2)
            };
            let mut work = point.work(&lacking)?;
            work.retain(|work| !work.blocks.is_empty());
            Ok(work)
        };
        let mut missing = Vec::new();
        let all: Vec<(usize, (&L, &u64))> = self.points.iter().zip(wanted).enumerate().collect();
        // Some at a time, as most points of a resumed run lack nothing, and then keep nothing.
        for some in all.chunks(LOWERED_AT_ONCE) {
            let work: Vec<Result<Vec<Work>, StoreError>> = some.par_iter().copied().map(of_point).collect();
            for work in work {
                missing.append(&mut work?);
            }
        }
        Ok(missing)
    }

    /// Total trials of all launches of a share of the wanted trials.
    fn launched_trials(&self, wanted: &[u64], share: Share) -> u64 {
        let points = self.points.iter().zip(wanted).enumerate();
        let of_point = |(turn, (point, &trials)): (usize, (&L, &u64))| {
            let trials = share.trials(trials, turn);
            point.launches() as u64 * (trials.end - trials.start)
        };
        points.map(of_point).sum()
    }
}

impl<S: fmt::Debug + Sync, L: Launched> Plan for PointsPlan<'_, S, L>
where
    Self: Tabulated,
{
    fn steps<'p>(&'p self, store: &Store, share: Share) -> Result<Box<dyn Steps + 'p>, StoreError> {
        let (wanted, trials) = (self.first_wanted(share), Trials::default());
        let mut steps = PointsSteps { plan: self, share, wanted, trials, all: 0 };
        steps.begin(store)?;
        Ok(Box::new(steps))
    }

    fn keep(&self, store: &mut Store, share: Share) -> Result<(), RunError> {
        Tabulated::keep(self, store, share)
    }

    fn lacks_kept(&self, store: &Store, share: Share) -> Result<u64, StoreError> {
        Tabulated::lacks_kept(self, store, share)
    }

    fn tables(&self, store: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        Tabulated::tables(self, store)
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        // With a precision, `trials` is the upper limit, and so part of the rule.
        if self.study.precision.is_some() {
            return Ok(None);
        }
        held_by_all(index, self.points.iter().flat_map(Launched::addresses))
    }

    fn ids(&self) -> Vec<Id> {
        self.points.iter().map(Launched::id).collect()
    }

    fn notes(&self, store: &Store) -> Result<Vec<String>, StoreError> {
        Tabulated::notes(self, store)
    }

    fn all_trials(&self) -> u64 {
        self.points.iter().map(|point| point.trials(self.study.trials)).sum()
    }

    fn steps_of_a_trial(&self) -> Option<u64> {
        let steps = Cell::new(0);
        let count = |_: &[Address], more: u64| {
            steps.set(steps.get() + more);
            Ok(vec![])
        };
        self.points.iter().try_for_each(|point| point.work(&count).map(drop)).ok()?;
        Some(steps.get())
    }

    fn surplus(&self) -> &'static str {
        let replays = self.points.iter().any(|point| point.trials(1) > 1);
        if replays { "whole replays of the record" } else { "the folder holds them already" }
    }
}

/// The steps of a plan of points.
///
/// With a precision, a point stops after 1, 2, 4, … base blocks of trials, and at least 1024 trials, when all its errors have the
/// requested precision. The rule depends on the study only. The estimates of a point keep the same trials, so that they are
/// compared on the same draws. A share does not know the others and takes all its trials.
struct PointsSteps<'p, 'a, S, L> {
    plan: &'p PointsPlan<'a, S, L>,
    share: Share,
    /// The trials of each point after which this round ends.
    wanted: Vec<u64>,
    trials: Trials<'p>,
    /// Trials of all launches up to there.
    all: u64,
}

impl<S, L: Launched> PointsSteps<'_, '_, S, L> {
    /// Begins a round with what the store lacks of the wanted trials.
    fn begin(&mut self, store: &Store) -> Result<(), StoreError> {
        self.trials = Trials::new(self.plan.missing(store, &self.wanted, self.share)?);
        self.all = self.plan.launched_trials(&self.wanted, self.share);
        Ok(())
    }
}

impl<'a, S: Sync, L: Launched> Steps for PointsSteps<'_, 'a, S, L>
where
    PointsPlan<'a, S, L>: Tabulated,
{
    fn unit(&self) -> &'static str {
        "trials"
    }

    fn amounts(&self) -> [u64; 2] {
        let left = self.trials.missing();
        let all = self.all.max(left);
        [all - left, all]
    }

    fn missing_trials(&self) -> u64 {
        self.trials.missing()
    }

    fn next(&mut self, budget: Budget) -> Result<Option<Batch>, Unrepresentable> {
        self.trials.next(budget.steps)
    }

    fn more(&mut self, store: &Store) -> Result<bool, StoreError> {
        let goes_on = self.plan.decides(self.share) && self.plan.raise(&mut self.wanted, store)?;
        if goes_on {
            self.begin(store)?;
        }
        Ok(goes_on)
    }
}

/// The part of a plan of records that belongs to its kind.
pub(crate) trait TabulatedRecords {
    /// Name of a trial in messages, in the plural.
    const TRIALS: &'static str;

    /// Makes the recipes of the records of a point, in their order. They are made whenever they are needed, because their
    /// tables may be large.
    ///
    /// # Errors
    /// The point is refused, which the plan has proven to fit.
    fn recipes(&self, point: usize) -> Result<Vec<Arc<dyn Recorded>>, Unrepresentable>;

    /// The tables of all that the store holds; without a store, all rows without estimates.
    ///
    /// # Errors
    /// A row of the store is damaged, the disk fails, or a closed form is not that of the inputs.
    fn tables(&self, store: Option<&Store>, progress: &dyn Progress) -> Result<Tables, RunError>;

    /// Notes on the results, each a sentence.
    fn notes(&self) -> Vec<String> {
        vec![]
    }

    /// Number of sets of coefficients of a point, each of which has an equal part of the trials.
    fn sets(&self) -> u64 {
        1
    }

    /// See [`Plan::steps_of_a_trial`].
    fn steps_of_a_trial(&self) -> Option<u64> {
        None
    }
}

/// The plan of a study whose trials are records. `S` is the part of the study that belongs to its kind, and `L` what it keeps
/// of each lowered point.
#[derive(Debug)]
pub(crate) struct RecordsPlan<'a, S, L> {
    pub(crate) study: &'a Study,
    pub(crate) subject: &'a S,
    pub(crate) points: Vec<L>,
    /// The records of each point, as many for every one.
    pub(crate) records: Vec<Records>,
}

impl<'a, S: Sync, L: Send + Sync> RecordsPlan<'a, S, L>
where
    Self: TabulatedRecords,
{
    /// Lowers every point, `at_once` of them in parallel. `lower` gives the records of a point, and what is kept of it;
    /// `swept` its values of the swept keys. `None` if `progress` asks to stop.
    ///
    /// # Errors
    /// A point cannot be represented, or its trials do not fit into memory; the error points at the key to change.
    pub(crate) fn new<P: Sync>(
        study: &'a Study,
        subject: &'a S,
        points: &'a [P],
        swept: fn(&P) -> &Values,
        at_once: usize,
        lower: impl Fn(&'a P) -> Result<(Vec<Records>, L), Unrepresentable> + Sync,
        progress: &dyn Progress,
    ) -> Result<Option<RecordsPlan<'a, S, L>>, StudyError> {
        let mut plan = RecordsPlan { study, subject, points: vec![], records: vec![] };
        let keep = |(records, point): (Vec<Records>, L)| {
            study.check_trials(records.iter().map(|records| records.width).sum(), Self::TRIALS)?;
            plan.records.extend(records);
            plan.points.push(point);
            Ok(())
        };
        let is_complete = lower_all(study, points, swept, at_once, lower, keep, progress)?;
        Ok(is_complete.then_some(plan))
    }

    /// The records of each point that the study wants.
    fn wanted(&self) -> Wanted<'_> {
        let of_point = (self.records.len() / self.points.len().max(1)).max(1);
        Wanted {
            trials: self.study.trials.div_ceil(self.sets()),
            records: &self.records,
            of_point,
            recipes: Box::new(|point| self.recipes(point)),
            // A trial has a record of each kind.
            of_trial: (of_point as u64 / self.sets()).max(1),
        }
    }
}

impl<S: fmt::Debug + Sync, L: fmt::Debug + Send + Sync> Plan for RecordsPlan<'_, S, L>
where
    Self: TabulatedRecords,
{
    fn steps<'p>(&'p self, store: &Store, share: Share) -> Result<Box<dyn Steps + 'p>, StoreError> {
        Ok(Box::new(self.wanted().steps(store, share)?))
    }

    fn tables(&self, store: Option<&Store>, progress: &dyn Progress) -> Result<Tables, RunError> {
        TabulatedRecords::tables(self, store, progress)
    }

    fn held(&self, index: &Index) -> Result<Option<u64>, StoreError> {
        let held = held_by_all(index, self.records.iter().map(|records| records.address))?;
        let (wanted, asked) = (self.wanted().trials, self.study.trials);
        Ok(held.map(|held| if held == wanted { asked } else { held * self.sets() }))
    }

    fn ids(&self) -> Vec<Id> {
        self.records.iter().map(|records| records.address.point).collect()
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(TabulatedRecords::notes(self))
    }

    fn all_trials(&self) -> u64 {
        u64::MAX
    }

    fn steps_of_a_trial(&self) -> Option<u64> {
        TabulatedRecords::steps_of_a_trial(self)
    }
}

/// The plan of a study in closed form, which consists of its table only.
#[derive(Debug)]
pub(crate) struct ClosedFormPlan(pub(crate) Table);

impl Plan for ClosedFormPlan {
    fn steps<'p>(&'p self, _: &Store, _: Share) -> Result<Box<dyn Steps + 'p>, StoreError> {
        Ok(Box::new(NoSteps))
    }

    fn tables(&self, _: Option<&Store>, _: &dyn Progress) -> Result<Tables, RunError> {
        Ok(Tables::of_points(self.0.clone()))
    }

    fn held(&self, _: &Index) -> Result<Option<u64>, StoreError> {
        Ok(None)
    }

    fn ids(&self) -> Vec<Id> {
        vec![]
    }

    fn notes(&self, _: &Store) -> Result<Vec<String>, StoreError> {
        Ok(vec!["all values are closed forms: trials, seed and device are not used".to_owned()])
    }

    fn all_trials(&self) -> u64 {
        u64::MAX
    }
}

/// The steps of closed forms, of which there are none.
struct NoSteps;

impl Steps for NoSteps {
    fn unit(&self) -> &'static str {
        "trials"
    }

    fn amounts(&self) -> [u64; 2] {
        [0, 0]
    }

    fn missing_trials(&self) -> u64 {
        0
    }

    fn next(&mut self, _: Budget) -> Result<Option<Batch>, Unrepresentable> {
        Ok(None)
    }
}

/// The name of each swept key with its value at a point, in the order of the sweeps.
pub(crate) type Values = [(&'static str, SweepValue)];

/// A table of these rows; `swept` gives the values of the swept keys in each row.
pub fn table<R: Sync>(
    sweeps: &[Sweep],
    columns: &[ColumnOf<R>],
    rows: &[R],
    swept: impl Fn(&R) -> &Values,
) -> Table {
    let of_sweep = |(at, sweep): (usize, &Sweep)| Column {
        cells: rows.iter().map(|row| swept(row)[at].1.cell()).collect(),
        ..column_of(sweep)
    };
    let keys = sweeps.iter().enumerate().map(of_sweep);
    Table { columns: keys.chain(columns_of(columns, rows)).collect() }
}

/// Tables with the same columns, one below the other. Each table is made when its rows are needed, so that only the cells
/// of all rows are in memory, and not what they are made from.
#[derive(Default)]
pub(crate) struct Appended {
    columns: Vec<(Column, Growing)>,
    rows: usize,
}

impl Appended {
    /// Adds the rows of a table.
    pub(crate) fn push(&mut self, table: Table) {
        if self.columns.is_empty() {
            let bare = |column: &Column| Column {
                cells: Cells::default(),
                band: column.band.as_ref().map(|_| vec![]),
                band_of_mean: None,
                ..column.clone()
            };
            self.columns = table.columns.iter().map(|column| (bare(column), Growing::default())).collect();
        }
        let (rows, more) = (self.rows, table.rows());
        // Looking up which cells of a long column are known takes as long as making them.
        self.columns.par_iter_mut().zip(table.columns).for_each(|((whole, cells), column)| {
            cells.append(column.cells);
            if let Some((band, own)) = whole.band.as_mut().zip(column.band)
                && (!band.is_empty() || own.iter().any(Option::is_some))
            {
                band.resize(rows, None);
                band.extend(own);
            }
        });
        self.rows += more;
    }

    /// All rows.
    pub(crate) fn into_table(self) -> Table {
        let whole = |(column, cells): (Column, Growing)| Column { cells: cells.into_cells(), ..column };
        Table { columns: self.columns.into_iter().map(whole).collect() }
    }
}

/// The column of a swept key, without its cells.
fn column_of(sweep: &Sweep) -> Column {
    Column {
        name: sweep.key.name.to_owned(),
        label: sweep.key.label.to_owned(),
        unit: sweep.values.first().map(SweepValue::unit).unwrap_or_default(),
        written: sweep.values.last().and_then(SweepValue::written),
        role: Role::Key,
        meaning: sweep.key.label.to_owned(),
        ..Column::default()
    }
}
