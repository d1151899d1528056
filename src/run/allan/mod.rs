//! Running a study of Allan curves: records for what the store lacks, batch by batch.

mod coefficients;
mod curves;

use std::ops::Range;
use std::time::Instant;

use super::{BATCH_SECONDS, Done, Progress, RunError, Tables};
use crate::backend::Device;
use crate::backend::cpu::{Cpu, Width};
use crate::backend::gpu::GpuError;
use crate::block::{Block, base_log2, cover, fold, missing};
use crate::fit::{Covariance, Curve};
use crate::id::Id;
use crate::kernel::recipe::Recipe;
use crate::kernel::rows::Rows;
use crate::lower::{LoweredCurve, RecordsError};
use crate::store::{Provenance, Row, Store, StoreError};
use crate::study::{Allan, RecordPoint, Study, StudyError};
use crate::table::Table;
use crate::theory::allan::Difference;

/// Longest averaging time of the fit, as a part of the record: beyond it intervals of K come out too short.
const LONGEST_FITTED: u64 = 8;

/// Samples of the first batch.
const FIRST_BATCH: u64 = 1 << 22;

/// A study of Allan curves whose every point is proven to fit.
#[derive(Debug)]
pub(super) struct Plan<'a> {
    study: &'a Study,
    allan: &'a Allan,
    points: Vec<LoweredCurve>,
}

impl<'a> Plan<'a> {
    /// Lowers every point.
    pub(super) fn new(study: &'a Study, allan: &'a Allan) -> Result<Plan<'a>, StudyError> {
        let lower = |point: &RecordPoint| {
            LoweredCurve::new(point, allan.estimator, study.seed, study.streams)
                .map_err(|error| refused(study, point, &error))
        };
        let points = allan.points.iter().map(lower).collect::<Result<_, _>>()?;
        let plan = Plan { study, allan, points };
        plan.check_fits()?;
        Ok(plan)
    }

    /// Samples what the store lacks, each batch kept as soon as it is done.
    pub(super) fn run(
        &self,
        store: &mut Store,
        device: &mut Device,
        progress: &(dyn Progress + Sync),
    ) -> Result<Done, RunError> {
        let trials = self.study.trials;
        let mut lacking = Vec::new();
        for lowered in &self.points {
            let gaps = missing(&store.blocks(&lowered.address)?, trials);
            lacking.extend(gaps.into_iter().map(|gap| (lowered, gap)));
        }
        let total: u64 = self.points.iter().map(|lowered| trials * samples(lowered)).sum();
        let left = lacking.iter().map(|(lowered, gap)| (gap.end - gap.start) * samples(lowered)).sum();
        progress.start("samples", total.saturating_sub(left), total);
        let started = Instant::now();
        let largest = base_log2(trials);
        let mut maker = Maker { device, cpu: None, degraded: None };
        let (mut batch_samples, mut made) = (FIRST_BATCH, 0);
        for (lowered, gap) in lacking {
            let mut first = gap.start;
            while first < gap.end {
                let batch_started = Instant::now();
                let records = (batch_samples / samples(lowered)).max(maker.device.records_at_once());
                let batch = first..gap.end.min((first + records).next_multiple_of(1 << largest));
                let advance = |records| progress.advance(records * samples(lowered));
                let sums = maker.sums(lowered.records.recipe(), batch.clone(), &advance)?;
                (first, made) = (batch.end, made + batch.end - batch.start);
                let seconds = started.elapsed().as_secs_f64();
                let so_far = Provenance { device: maker.name(), trials: made, seconds };
                store.insert(&rows(lowered, batch, largest, &sums), &so_far)?;
                let factor = BATCH_SECONDS / batch_started.elapsed().as_secs_f64().max(1e-3);
                batch_samples = ((batch_samples as f64 * factor.clamp(0.25, 4.0)) as u64).max(1);
            }
        }
        let seconds = started.elapsed().as_secs_f64();
        Ok(Done { trials: made, seconds, degraded: maker.degraded })
    }

    /// The tables before anything is sampled.
    pub(super) fn blank_tables(&self) -> Tables {
        let mut tables = self.empty_tables();
        for at in 0..self.points.len() {
            self.add(&mut tables, at, &[]);
        }
        tables
    }

    /// All estimates held. One point is in memory at a time.
    pub(super) fn tables(&self, store: &Store) -> Result<Tables, StoreError> {
        let mut tables = self.empty_tables();
        for (at, lowered) in self.points.iter().enumerate() {
            let estimates: Vec<Vec<f64>> =
                store.rows(&lowered.address)?.rows().map(|sums| lowered.records.variances(sums)).collect();
            self.add(&mut tables, at, &estimates);
        }
        Ok(tables)
    }

    fn empty_tables(&self) -> Tables {
        let coefficients = self.allan.terms.as_ref().map(|_| self.coefficient_columns());
        Tables {
            points: Table { columns: self.curve_columns() },
            coefficients: coefficients.map(|columns| Table { columns }),
        }
    }

    /// Adds the rows of a point with these estimates: of each record, (″/s)² at each averaging factor.
    fn add(&self, tables: &mut Tables, at: usize, estimates: &[Vec<f64>]) {
        self.add_curve(&mut tables.points, &self.allan.points[at], &self.points[at], estimates);
        if let (Some(table), Some(terms)) = (&mut tables.coefficients, &self.allan.terms) {
            self.add_coefficients(table, &self.allan.points[at], terms, estimates);
        }
    }

    /// Records that every point has, where all have the same number.
    pub(super) fn held(&self, store: &Store) -> Result<Option<u64>, StoreError> {
        let mut held = None;
        for lowered in &self.points {
            let blocks = store.blocks(&lowered.address)?.into_iter().map(|block| (block, ())).collect();
            let records = fold(blocks).iter().map(|(block, ())| block.trials()).sum();
            if *held.get_or_insert(records) != records {
                return Ok(None);
            }
        }
        Ok(held)
    }

    /// The identities of all points.
    pub(super) fn ids(&self) -> Vec<Id> {
        self.points.iter().map(|lowered| lowered.address.point).collect()
    }

    /// What should be known besides the results.
    pub(super) fn notes(&self) -> Vec<String> {
        let shortened =
            |point: &&RecordPoint| point.ms.iter().any(|&m| !is_fitted(m, point.inputs.samples()));
        if self.allan.terms.is_some() && self.allan.points.iter().any(|point| shortened(&point)) {
            return vec![
                "coefficients are fitted to averaging times up to an eighth of the record".to_owned(),
            ];
        }
        vec![]
    }

    /// Refuses fits to fewer points than parameters before anything is sampled.
    fn check_fits(&self) -> Result<(), StudyError> {
        let Some(terms) = &self.allan.terms else { return Ok(()) };
        for point in &self.allan.points {
            let fitted = curve_of(point, self.allan.estimator.difference, |_| 1.0);
            let parameters = coefficients::fewest_points(terms);
            let points = fitted.as_ref().map_or(0, |curve| curve.ms().len());
            if points < parameters {
                let message = format!(
                    "the record has {points} averaging times up to an eighth of it, too few for {parameters} parameters"
                );
                let help = "lengthen the record, take tau = \"decade10\", or fit fewer terms";
                return Err(super::refused(self.study, &point.swept, "record.length", &message, help));
            }
        }
        Ok(())
    }
}

/// Samples of a record.
fn samples(lowered: &LoweredCurve) -> u64 {
    u64::from(lowered.records.recipe().samples)
}

/// The rows of consecutive records, from their sums, in blocks of at most 2^`largest`.
fn rows(lowered: &LoweredCurve, records: Range<u64>, largest: u32, sums: &[u128]) -> Vec<Row<Rows>> {
    let (first, width) = (records.start, lowered.records.recipe().places());
    let row = |block: Block| {
        let [from, to] = [block.first, block.end()].map(|at| (at - first) as usize * width);
        Row { address: lowered.address, block, tally: Rows { width, values: sums[from..to].to_vec() } }
    };
    cover(records, largest).into_iter().map(row).collect()
}

/// Where records are made: on the device, but such as are too long for it on the processor.
struct Maker<'a> {
    device: &'a mut Device,
    cpu: Option<Cpu>,
    degraded: Option<String>,
}

impl Maker<'_> {
    fn sums(
        &mut self,
        recipe: &Recipe,
        records: Range<u64>,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<u128>, GpuError> {
        let (first, count) = (records.start, (records.end - records.start) as usize);
        let why = match self.device.sums(recipe, first, count, progress) {
            Err(error @ GpuError::TooLong { .. }) => error.to_string(),
            made => return made,
        };
        if self.cpu.is_none() {
            let threads = Cpu::new(Width::widest(), 0);
            self.cpu = Some(threads.map_err(|error| GpuError::Refused(error.to_string()))?);
            self.degraded =
                Some(format!("records of {} samples were made on the CPU: {why}", recipe.samples));
        }
        Ok(self.cpu.as_ref().map_or(vec![], |cpu| cpu.sums(recipe, first, count, progress)))
    }

    fn name(&self) -> String {
        match &self.cpu {
            Some(cpu) => format!("{} and {}", self.device.name(), cpu.name()),
            None => self.device.name(),
        }
    }
}

/// Whether a fit has this averaging factor.
fn is_fitted(m: u64, samples: u64) -> bool {
    LONGEST_FITTED * m <= samples
}

/// The curve that a fit has of a record, `variance` being that at a place of the point's averaging factors.
fn curve_of(point: &RecordPoint, difference: Difference, variance: impl Fn(usize) -> f64) -> Option<Curve> {
    let samples = point.inputs.samples();
    let fitted = point.ms.iter().enumerate().filter(|(_, m)| is_fitted(**m, samples));
    let (ms, variances) = fitted.map(|(at, &m)| (m, variance(at))).unzip();
    Curve::new(point.inputs.sample_s, samples, difference, ms, variances).ok()
}

/// The covariance of the estimates of a point's records, as the records themselves show it beside the closed form of
/// overlapping ones; `None` of too few records.
fn covariance(point: &RecordPoint, geometry: &Curve, estimates: &[Vec<f64>]) -> Option<Covariance> {
    let process = point.inputs.noise.process(point.inputs.sample_s, point.inputs.samples());
    let model = Covariance::of_process(&process, geometry).ok()?;
    let rows: Vec<Vec<f64>> = estimates.iter().map(|record| record[..geometry.ms().len()].to_vec()).collect();
    Covariance::of_realisations(&rows, &model).ok()
}

/// The error of a point that cannot be sampled, at the key of the study that has to change.
fn refused(study: &Study, point: &RecordPoint, error: &RecordsError) -> StudyError {
    super::refused(study, &point.swept, error.key(), &error.to_string(), error.help())
}
