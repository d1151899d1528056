//! Running a study: what is missing in the store is sampled and added, then all that is held becomes a table.

use std::time::Instant;

use crate::backend::gpu::GpuError;
use crate::backend::{Device, Job};
use crate::block::{Block, base_log2, cover, missing};
use crate::kernel::launch::Launch;
use crate::lower::{Estimate, LowerError, Lowered};
use crate::stats::{Estimates, z_score};
use crate::store::{Identity, Provenance, Row, Store, StoreError};
use crate::study::{Error, Filler, Point, Precision, Study, StudyError};
use crate::table::{Cell, Column, Table, Unit};

/// Why a run ended early. What was computed before is in the store.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// A study whose every point is proven to fit.
#[derive(Debug)]
pub struct Plan<'a> {
    study: &'a Study,
    points: Vec<Lowered>,
}

/// A launch and the blocks of it that are missing.
struct Work {
    point: usize,
    fillers: Vec<usize>,
    launch: Launch,
    blocks: Vec<Block>,
}

/// What a run did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Done {
    /// Trials sampled, over all points.
    pub trials: u64,
    pub seconds: f64,
}

/// How long a batch should take: results are on disk this often.
const BATCH_SECONDS: f64 = 0.3;

/// Most jobs of a batch: their tallies are held in memory together, some 30 KiB each.
const MOST_JOBS: usize = 1024;

/// Trials of the first batch.
const FIRST_BATCH: u64 = 1 << 20;

impl<'a> Plan<'a> {
    /// Lowers every point.
    ///
    /// # Errors
    /// A point cannot be represented; the error points at the key to change.
    pub fn new(study: &'a Study) -> Result<Plan<'a>, StudyError> {
        let lower = |point: &Point| {
            Lowered::new(point, &study.fillers, &study.errors, study.seed, study.streams)
                .map_err(|error| refused(study, point, &error))
        };
        let points = study.points().iter().map(lower).collect::<Result<_, _>>()?;
        Ok(Plan { study, points })
    }

    /// What makes the results those of this study.
    pub fn identity(&self) -> Identity {
        Identity {
            kind: self.study.kind.name().to_owned(),
            seed: self.study.seed,
            streams: self.study.streams.name().to_owned(),
        }
    }

    /// Samples what the store lacks. `progress` hears how many trials there are in all and, as it comes, what is done.
    ///
    /// With a precision, a filler at a point stops after 1, 2, 4, … base blocks of trials, where all its errors are known
    /// as well as is asked: a rule that depends on nothing but the study.
    ///
    /// # Errors
    /// The device or the disk fails.
    pub fn run(
        &self,
        store: &mut Store,
        device: &mut Device,
        progress: &(dyn Progress + Sync),
    ) -> Result<Done, RunError> {
        let most = |point: &Lowered| point.trials(self.study.trials);
        let first = |point: &Lowered| match self.study.precision {
            None => most(point),
            Some(_) => most(point).min(1 << base_log2(most(point))),
        };
        let mut wanted: Vec<Vec<u64>> =
            self.points.iter().map(|point| vec![first(point); point.fillers.len()]).collect();
        let started = Instant::now();
        let mut trials = 0;
        for round in 0.. {
            let work = self.missing(store, &wanted)?;
            let total: u64 = work.iter().flat_map(|work| &work.blocks).map(Block::trials).sum();
            if round == 0 {
                let asked = self.points.iter().map(most).sum::<u64>();
                let rest = if self.study.precision.is_some() { asked } else { total };
                progress.start(asked.saturating_sub(rest), asked.max(rest));
            }
            self.sample(&work, store, device, progress, started)?;
            trials += total;
            if !self.raise(&mut wanted, store)? {
                break;
            }
        }
        let seconds = started.elapsed().as_secs_f64();
        progress.finish();
        Ok(Done { trials, seconds })
    }

    /// Samples all of `work` in batches, each of which is kept as soon as it is done.
    fn sample(
        &self,
        work: &[Work],
        store: &mut Store,
        device: &mut Device,
        progress: &(dyn Progress + Sync),
        started: Instant,
    ) -> Result<(), RunError> {
        let mut rest: Vec<(&Work, Job)> = work
            .iter()
            .flat_map(|work| {
                work.blocks.iter().map(move |&block| (work, Job { launch: &work.launch, block }))
            })
            .rev()
            .collect();
        let (mut batch_trials, mut sampled) = (FIRST_BATCH, 0);
        while !rest.is_empty() {
            let batch_started = Instant::now();
            let batch = take_batch(&mut rest, batch_trials);
            let jobs: Vec<Job> = batch.iter().map(|(_, job)| *job).collect();
            let results = device.tally(&jobs, true, &|trials| progress.advance(trials))?;
            let rows: Vec<Row> = batch
                .iter()
                .zip(results)
                .flat_map(|((work, job), tallies)| {
                    let estimates = self.points[work.point].launched(&work.fillers);
                    estimates.zip(tallies).map(|(estimate, tally)| Row {
                        address: estimate.address,
                        block: job.block,
                        tally,
                    })
                })
                .collect();
            sampled += batch.iter().map(|(_, job)| job.block.trials()).sum::<u64>();
            let seconds = started.elapsed().as_secs_f64();
            store.insert(&rows, &Provenance { device: device.name(), trials: sampled, seconds })?;
            let factor = (BATCH_SECONDS / batch_started.elapsed().as_secs_f64().max(1e-3)).clamp(0.25, 4.0);
            batch_trials = ((batch_trials as f64 * factor) as u64).max(1);
        }
        Ok(())
    }

    /// Doubles the trials of fillers that are not precise enough yet; whether there are such.
    fn raise(&self, wanted: &mut [Vec<u64>], store: &Store) -> Result<bool, StoreError> {
        let Some(precision) = &self.study.precision else { return Ok(false) };
        let mut raised = false;
        for (point, wanted) in self.points.iter().zip(wanted) {
            let most = point.trials(self.study.trials);
            for (estimates, wanted) in point.fillers.iter().zip(wanted) {
                if *wanted < most && !precise(precision, estimates, *wanted, store)? {
                    *wanted = (2 * *wanted).min(most);
                    raised = true;
                }
            }
        }
        Ok(raised)
    }

    /// Fillers at points whose errors are not as precise as is asked, and how many there are in all.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn imprecise(&self, store: &Store) -> Result<(usize, usize), StoreError> {
        let Some(precision) = &self.study.precision else { return Ok((0, 0)) };
        let (mut imprecise, mut all) = (0, 0);
        for estimates in self.points.iter().flat_map(|point| &point.fillers) {
            imprecise += usize::from(!precise(precision, estimates, u64::MAX, store)?);
            all += 1;
        }
        Ok((imprecise, all))
    }

    /// Errors that were asked for and that a filler does not have, each in a sentence.
    pub fn absent(&self) -> Vec<String> {
        let mut sentences = Vec::new();
        for (index, filler) in self.study.fillers.iter().enumerate() {
            let has = |error: Error| {
                let all = |point: &Lowered| point.fillers[index].iter().any(|estimate| estimate.error == error);
                self.points.iter().all(all)
            };
            let lacks: Vec<&str> =
                self.study.errors.iter().filter(|error| !has(**error)).map(|error| error.name()).collect();
            if !lacks.is_empty() {
                let name = &filler.name;
                sentences.push(format!("the weights of `{name}` do not give its errors: {}", lacks.join(", ")));
            }
        }
        sentences
    }

    /// What the store lacks: fillers of a point that lack the same trials share a launch.
    fn missing(&self, store: &Store, wanted: &[Vec<u64>]) -> Result<Vec<Work>, StoreError> {
        let mut all = Vec::new();
        for (index, point) in self.points.iter().enumerate() {
            let log2 = base_log2(point.trials(self.study.trials));
            let mut groups: Vec<(Vec<Block>, Vec<usize>)> = Vec::new();
            for (filler, estimates) in point.fillers.iter().enumerate() {
                let trials = wanted[index][filler];
                let mut blocks = Vec::new();
                for estimate in estimates {
                    let held = store.blocks(&estimate.address)?;
                    blocks.extend(missing(&held, trials).into_iter().flat_map(|gap| cover(gap, log2)));
                }
                blocks.sort();
                blocks.dedup();
                let joins = |group: &&mut (Vec<Block>, Vec<usize>)| {
                    group.0 == blocks
                        && group.1.len() < point.most_fillers(filler)
                        && point.alike(group.1[0], filler)
                };
                match groups.iter_mut().find(joins) {
                    Some(group) => group.1.push(filler),
                    None => groups.push((blocks, vec![filler])),
                }
            }
            for (blocks, fillers) in groups.into_iter().filter(|group| !group.0.is_empty()) {
                all.push(Work { point: index, launch: point.launch(&fillers), fillers, blocks });
            }
        }
        Ok(all)
    }

    /// Points that the store holds and the study no longer asks for.
    ///
    /// # Errors
    /// The disk fails.
    pub fn unasked(&self, store: &Store) -> Result<usize, StoreError> {
        let points = store.points()?;
        Ok(points.iter().filter(|id| self.points.iter().all(|point| point.id != **id)).count())
    }

    /// The table before anything is sampled: all rows, without estimates.
    pub fn blank_table(&self) -> Table {
        let mut columns = Columns::new(self.study);
        self.rows(|point, filler, estimate| columns.push(point, &filler.name, estimate, 0, None));
        self.with_laws(columns.table)
    }

    /// All estimates held, a row for each point, filler and error.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    pub fn table(&self, store: &Store) -> Result<Table, StoreError> {
        let mut columns = Columns::new(self.study);
        let mut failed = None;
        self.rows(|point, filler, estimate| match store.total(&estimate.address) {
            Ok(tally) => {
                let found = Estimates::of(&tally, estimate.bin_base, estimate.unit_arcsec);
                columns.push(point, &filler.name, estimate, tally.count, found);
            }
            Err(error) => drop(failed.get_or_insert(error)),
        });
        failed.map_or_else(|| Ok(self.with_laws(columns.table)), Err)
    }

    /// The table with a column for each law that a chart draws.
    fn with_laws(&self, mut table: Table) -> Table {
        for law in self.study.laws() {
            let mut cells = vec![];
            self.rows(|point, filler, estimate| {
                cells.push(law.arcsec(&point.inputs, filler, estimate.error, estimate.rows.ticks.len()).into());
            });
            let (name, label) = (law.column().to_owned(), law.label().to_owned());
            table.columns.push(Column { name, label, unit: Unit::ARCSEC, cells, band: None });
        }
        table
    }

    /// Every point, filler and error, in the order of the table.
    fn rows(&self, mut row: impl FnMut(&Point, &Filler, &Estimate)) {
        for (point, lowered) in self.study.points().iter().zip(&self.points) {
            for (filler, estimates) in self.study.fillers.iter().zip(&lowered.fillers) {
                for estimate in estimates {
                    row(point, filler, estimate);
                }
            }
        }
    }
}

/// Who hears how a run goes on.
pub trait Progress {
    /// `done` of `total` trials are there already.
    fn start(&self, done: u64, total: u64);
    /// So many more are done.
    fn advance(&self, trials: u64);
    fn finish(&self);
}

/// Whether all errors of a filler are as precise as is asked in their first `trials` trials.
fn precise(
    precision: &Precision,
    estimates: &[Estimate],
    trials: u64,
    store: &Store,
) -> Result<bool, StoreError> {
    for estimate in estimates {
        let tally = store.total_within(&estimate.address, trials)?;
        let found = Estimates::of(&tally, estimate.bin_base, 1.0);
        let within = |part: Option<f64>, half: Option<f64>, value: Option<f64>| match (part, half, value) {
            (None, ..) => true,
            (Some(part), Some(half), Some(value)) => half <= part * value,
            _ => false,
        };
        let rms_half = found.and_then(|found| found.rms_se).map(|se| NORMAL_95 * se);
        let q = found.and_then(|found| found.q9973);
        let q_half = q.and_then(|q| q.low.zip(q.high)).map(|(low, high)| 0.5 * (high - low));
        if !within(precision.rms, rms_half, found.map(|found| found.rms))
            || !within(precision.q9973, q_half, q.map(|q| q.value))
        {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The error of a point that cannot be sampled, at the key of the study that has to change.
pub(crate) fn refused(study: &Study, point: &Point, error: &LowerError) -> StudyError {
    let at: Vec<String> = point.swept.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let place = if at.is_empty() { String::new() } else { format!(", at {}", at.join(", ")) };
    study.error_at(study.place_of(error.key()), format!("{error}{place}"), error.help())
}

fn take_batch<'a, 'b>(rest: &mut Vec<(&'a Work, Job<'b>)>, trials: u64) -> Vec<(&'a Work, Job<'b>)> {
    let (mut batch, mut taken) = (Vec::new(), 0);
    while batch.len() < MOST_JOBS
        && let Some(next) = rest.pop_if(|(_, job)| taken == 0 || taken + job.block.trials() <= trials)
    {
        taken += next.1.block.trials();
        batch.push(next);
    }
    batch
}

/// The columns of a gap-fill table, row by row.
struct Columns {
    table: Table,
}

/// Half the width of a 95 % interval in standard errors.
const NORMAL_95: f64 = 1.959_963_985;

impl Columns {
    fn new(study: &Study) -> Columns {
        let column = |name: &str, label: &str, unit| Column {
            name: name.to_owned(),
            label: label.to_owned(),
            unit,
            cells: vec![],
            band: None,
        };
        let banded =
            |name: &str, label: &str| Column { band: Some(vec![]), ..column(name, label, Unit::ARCSEC) };
        let mut columns: Vec<Column> = study
            .sweeps
            .iter()
            .map(|sweep| {
                let unit = sweep.values.first().map_or(Unit::NONE, |value| value.dimension.unit());
                column(sweep.key.name, sweep.key.label, unit)
            })
            .collect();
        columns.extend([
            column("dt_nu", "Δt·ν", Unit::NONE),
            column("filler", "filler", Unit::NONE),
            column("error", "error", Unit::NONE),
            column("trials", "trials", Unit::NONE),
            column("mean", "mean error", Unit::ARCSEC),
            banded("rms", "rms error"),
            column("rms_se", "standard error of the rms", Unit::ARCSEC),
            column("max", "largest error seen", Unit::ARCSEC),
            banded("q9973", "99.73 % error"),
            column("q9973_lo", "99.73 % error, lower", Unit::ARCSEC),
            column("q9973_hi", "99.73 % error, upper", Unit::ARCSEC),
            column("oracle_rms", "rms error, closed form", Unit::ARCSEC),
            column("oracle_max", "largest error of the motion, closed form", Unit::ARCSEC),
            column("z", "deviation from the closed form, standard errors", Unit::NONE),
        ]);
        Columns { table: Table { columns } }
    }

    fn push(
        &mut self,
        point: &Point,
        filler: &str,
        estimate: &Estimate,
        trials: u64,
        found: Option<Estimates>,
    ) {
        let q = found.and_then(|found| found.q9973);
        let rms_se = found.and_then(|found| found.rms_se);
        let z = found
            .zip(rms_se)
            .zip(estimate.oracle.rms)
            .and_then(|((found, se), rms)| z_score(found.rms, rms, se, estimate.oracle.rounding));
        let cells = point.swept.iter().map(|(_, value)| value.cell()).chain([
            Cell::from(point.inputs.dt_nu()),
            Cell::Text(filler.to_owned()),
            Cell::Text(estimate.error.name().to_owned()),
            Cell::Integer(trials as i64),
            found.map(|found| found.mean).into(),
            found.map(|found| found.rms).into(),
            rms_se.into(),
            found.map(|found| found.max).into(),
            q.map(|q| q.value).into(),
            q.and_then(|q| q.low).into(),
            q.and_then(|q| q.high).into(),
            estimate.oracle.rms.into(),
            estimate.oracle.max.into(),
            z.into(),
        ]);
        let rms_band =
            found.zip(rms_se).map(|(found, se)| (found.rms - NORMAL_95 * se, found.rms + NORMAL_95 * se));
        let q_band = q.and_then(|q| q.low.zip(q.high));
        for (column, cell) in self.table.columns.iter_mut().zip(cells) {
            column.cells.push(cell);
            if let Some(band) = &mut column.band {
                band.push(if column.name == "rms" { rms_band } else { q_band });
            }
        }
    }
}
