//! Running a gap-fill study: points are checked, trials that the store lacks are sampled, and what it holds is tabulated.

use crate::chart::Law;
use crate::filler::read::Error;
use crate::filler::{Filler, latency_ticks};
use crate::key::{Precision, Unrepresentable};
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::columns::{Judge, Row, Size, Tuning, columns, tuned};
use crate::kinds::gap_fill::inputs::{Inputs, Point};
use crate::kinds::gap_fill::lower::physical_theory::PhysicalTheory;
use crate::kinds::gap_fill::lower::{Estimate, Lowered, Theory};
use crate::kinds::plan::{Appended, Lacking, Launched, PointsPlan, Tabulated, table};
use crate::sampling::batches::Work;
use crate::sampling::{self, RowEstimates, RunError, Tables};
use crate::store::error::StoreError;
use crate::store::{Address, Held, Store};
use crate::study::Study;
use crate::tally::{Block, Estimates, Id, NORMAL_95, row_log2};
use sagnac_base::diagnostics::StudyError;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::Table;
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::{MAX_ESTIMATES, Moments};
use sagnac_theory::minimum_variance::sides;

/// The plan of a gap-fill study.
pub(crate) type Plan<'a> = PointsPlan<'a, GapFill, Proven<'a>>;

/// Most trials of a replayed record, because the lower half of a trial's number determines its place.
const MAX_REPLAYED: u64 = 1 << 32;

/// Refuses too many trials of a record that is replayed over all its places.
pub(crate) fn check_replays(plan: &Plan) -> Result<(), StudyError> {
    let (study, replays) = (plan.study, plan.points.iter().any(|point| point.trials(1) > 1));
    if !replays || study.trials <= MAX_REPLAYED {
        return Ok(());
    }
    let message = format!("{} trials of a record that is replayed over every place", study.trials);
    let help = format!("accepted: up to {MAX_REPLAYED} trials, or position = \"random\"");
    Err(study.error_at(study.place_of("motion.profile"), message, help))
}

/// About how many rows of the store, of 2 KiB at most, are read together, while a table is made of as many.
const READ_AT_ONCE: usize = 4096;

impl Plan<'_> {
    /// A note that fillers have different weights at each point, which firmware cannot have.
    fn designed_anew(&self) -> Option<String> {
        let (tuning, names) = tuned(self.study, self.subject)?;
        let how = match tuning {
            Tuning::Points => {
                "separately for the motion and noise of each point, which is the best possible; firmware has one set of weights"
            }
            Tuning::Frequency => {
                "for exactly this motion, which firmware does not know: it has one set of weights"
            }
        };
        Some(format!("{} without a band: designed {how}, designed for a band", names.join(", ")))
    }

    /// A note on errors that are smaller than what the arithmetic resolves, whose rows are blank.
    fn unresolved(&self, store: &Store) -> Result<Option<String>, StoreError> {
        let (mut count, mut largest) = (0, 0.0_f64);
        let proofs = self.points.iter().flat_map(|point| point.estimates.iter().map(move |own| (point, own)));
        for (point, proof) in proofs {
            let Proof { theory, bin_base, unit_arcsec, .. } = proof;
            // Spares reading the tallies of most rows.
            if theory.size >= theory.resolution {
                continue;
            }
            let found = RowEstimates::new(&store.total(&point.address(proof))?, *bin_base, *unit_arcsec);
            if found.estimates.is_some_and(|found| theory.is_below_resolution(found.rms)) {
                count += 1;
                largest = largest.max(theory.resolution);
            }
        }
        let rows = if count == 1 { "row is" } else { "rows are" };
        Ok((count > 0).then(|| {
            format!(
                "{count} {rows} below the resolution of the arithmetic, up to {}″, and blank: the error is theory_rms, or without a closed form less than that resolution",
                significant(largest, 2)
            )
        }))
    }

    /// Notes on requested errors that a filler does not have, each a sentence.
    fn absent(&self) -> Vec<String> {
        let mut sentences = Vec::new();
        for (index, filler) in self.subject.fillers.iter().enumerate() {
            let has = |error: Error| {
                let all = |point: &Proven| point.filler(index).iter().any(|estimate| estimate.error == error);
                self.points.iter().all(all)
            };
            let lacks: Vec<&str> =
                self.subject.errors.iter().filter(|error| !has(**error)).map(|error| error.name()).collect();
            if !lacks.is_empty() {
                let name = &filler.name;
                sentences
                    .push(format!("the weights of `{name}` do not give its errors: {}", lacks.join(", ")));
            }
        }
        sentences
    }
}

impl Plan<'_> {
    /// The rows of some points, with what is held of their tallies.
    fn part(&self, points: &[Proven], held: Option<&Held>) -> Result<Table, StoreError> {
        let blank = RowEstimates::default();
        let mut rows = Vec::new();
        for proven in points {
            let row = |estimate| Row { proven, filler: self.filler(estimate), estimate, found: &blank };
            rows.extend(proven.estimates.iter().map(row));
        }
        let found = |at: usize, tally: &Moments| {
            let Proof { bin_base, unit_arcsec, theory, .. } = *rows[at].estimate;
            let mut found = RowEstimates::new(tally, bin_base, unit_arcsec);
            found.estimates = found.estimates.filter(|found| !theory.is_below_resolution(found.rms));
            let known = theory.noise_of_square.zip(found.estimates.as_mut());
            if let Some((noise, estimates)) = known.filter(|(_, estimates)| estimates.rms > 0.0) {
                estimates.rms_se = Some(noise / libm::sqrt(found.trials as f64) / (2.0 * estimates.rms));
            }
            found
        };
        let found = held.map_or(Ok(vec![]), |held| held.totals(found))?;
        rows.iter_mut().zip(&found).for_each(|(row, found)| row.found = found);
        let mut table = table(&self.study.sweeps, &columns(self.subject.is_specified()), &rows, |row| {
            &row.proven.point.swept
        });
        let of_law = |law: Law| law.about().with(rows.iter().map(|row| row.law(law).into()).collect());
        table.columns.extend(self.study.laws().into_iter().map(of_law));
        Ok(table)
    }

    /// The filler of an estimate.
    fn filler(&self, estimate: &Proof) -> &Filler {
        &self.subject.fillers[usize::from(estimate.filler)]
    }
}

impl Tabulated for Plan<'_> {
    /// The table has a row for each point, filler and error, and a column for each law that a chart draws.
    fn tables(&self, store: Option<&Store>) -> Result<Tables, RunError> {
        let trials = self.study.trials;
        let rows_of_tally = trials.div_ceil(1 << row_log2(trials, STEPS)) as usize;
        let rows_of_point = self.points.first().map_or(0, |point| point.estimates.len()) * rows_of_tally;
        let mut parts = self.points.chunks((READ_AT_ONCE / rows_of_point.max(1)).max(1));
        let addresses = |points: &[Proven]| points.iter().flat_map(Launched::addresses).collect();
        let mut all = Appended::default();
        let mut add = |points, held: Option<&Held>| self.part(points, held).map(|part| all.push(part));
        match store {
            Some(store) => store.in_parts(parts, addresses, |points, held| add(points, Some(&held)))?,
            None => parts.try_for_each(|points| add(points, None))?,
        }
        Ok(Tables::of_points(all.into_table()))
    }

    fn notes(&self, store: &Store) -> Result<Vec<String>, StoreError> {
        let mut notes = self.absent();
        notes.extend(self.designed_anew());
        notes.extend(self.unresolved(store)?);
        let (imprecise, fillers) = self.imprecise(store)?;
        if imprecise > 0 {
            let trials = self.study.trials;
            notes.push(format!(
                "{imprecise} of {fillers} fillers at points have not reached the requested precision after {trials} trials"
            ));
        }
        Ok(notes)
    }

    fn raise(&self, wanted: &mut [u64], store: &Store) -> Result<bool, StoreError> {
        self.raise_imprecise(wanted, store)
    }
}

/// A point that is proven to fit.
#[derive(Debug)]
pub(crate) struct Proven<'a> {
    study: &'a Study,
    subject: &'a GapFill,
    pub(crate) point: &'a Point,
    id: Id,
    /// The least number of trials, of which others are multiples: the places of a record that is replayed over all of them.
    replay: u64,
    /// The estimates of all fillers, in their order, each with one estimate for each of its errors.
    pub(crate) estimates: Box<[Proof]>,
}

/// An estimate that is proven to fit, without its weights.
#[derive(Debug)]
pub(crate) struct Proof {
    /// Place of the filler.
    pub(crate) filler: u16,
    /// Number of ticks that it reads.
    pub(crate) ticks: u16,
    pub(crate) error: Error,
    pub(crate) bin_base: u32,
    pub(crate) unit_arcsec: f64,
    pub(crate) theory: Theory,
    /// Relative difference of the closed form from that of the physical inputs, where there is one.
    pub(crate) representation: Option<f64>,
    /// What a residual is on the specification, where there is one.
    pub(crate) specified: Option<Specified>,
    estimate: Id,
    digest: Id,
}

/// A residual on a specification.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Specified {
    /// Time from the end of the gap to the correction, s.
    pub(crate) latency_s: f64,
    /// The largest residual within the tolerances.
    pub(crate) worst: Size,
}

impl Specified {
    fn new(inputs: &Inputs, estimate: &Estimate) -> Option<Specified> {
        if inputs.specification.is_none() || estimate.error != Error::Residual {
            return None;
        }
        let ticks = &estimate.rows.ticks;
        let weights = estimate.rows.values().pop()?;
        Some(Specified {
            latency_s: f64::from(latency_ticks(ticks, inputs.gap_ticks)) * inputs.tick_s,
            worst: Judge::new(inputs, sides(ticks, inputs.gap_ticks)).judge(ticks, &weights).worst(),
        })
    }
}

/// Steps of a trial, which is a single switch.
const STEPS: u64 = 1;

impl Proof {
    /// # Errors
    /// The closed form of the words differs from that of the inputs by more than the rounding of words explains.
    fn new(
        name: &str,
        filler: usize,
        estimate: &Estimate,
        inputs: &Inputs,
        physical: &PhysicalTheory,
    ) -> Result<Proof, Unrepresentable> {
        let Estimate { error, address, mut theory, unit_arcsec, bin_base, .. } = *estimate;
        let physical_rms = theory.rms.and_then(|_| physical.rms(&estimate.rows, error));
        if let Some((words, inputs)) = theory.rms.zip(physical_rms) {
            let what = format!("the {} of `{name}`", error.name());
            sampling::check_representation(
                "switching.fillers",
                &what,
                [words, inputs],
                estimate.representation,
            )?;
        }
        let representation = sampling::representation(theory.rms, physical_rms, estimate.representation);
        if theory.rms.is_some_and(|rms| rms < theory.resolution) {
            // The words say nothing of so small an error, which the inputs do.
            theory.rms = physical_rms;
        }
        Ok(Proof {
            filler: filler as u16,
            ticks: estimate.rows.ticks.len() as u16,
            error,
            bin_base,
            unit_arcsec,
            theory,
            representation,
            specified: Specified::new(inputs, estimate),
            estimate: address.estimate,
            digest: address.digest,
        })
    }
}

impl<'a> Proven<'a> {
    /// Proves that a point of a study fits.
    ///
    /// # Errors
    /// The point cannot be represented.
    pub(crate) fn new(
        study: &'a Study,
        subject: &'a GapFill,
        point: &'a Point,
    ) -> Result<Proven<'a>, Unrepresentable> {
        let lowered = Lowered::new(point, &subject.fillers, &subject.errors, study.seed, study.streams)?;
        let (id, replay) = (lowered.id, lowered.whole_replays(1));
        let physical = PhysicalTheory::new(&point.inputs, point.sides());
        let fillers = lowered.fillers.iter().zip(&subject.fillers).enumerate();
        let proofs = fillers.flat_map(|(place, (all, filler))| {
            let physical = &physical;
            all.iter().map(move |estimate| Proof::new(&filler.name, place, estimate, &point.inputs, physical))
        });
        Ok(Proven { study, subject, point, id, replay, estimates: proofs.collect::<Result<_, _>>()? })
    }

    /// The address of the tallies of one of its estimates.
    pub(crate) fn address(&self, of: &Proof) -> Address {
        Address { point: self.id, estimate: of.estimate, digest: of.digest }
    }

    /// The estimates of a filler.
    pub(crate) fn filler(&self, filler: usize) -> &[Proof] {
        let before = self.estimates.partition_point(|own| usize::from(own.filler) < filler);
        let own = self.estimates[before..].partition_point(|own| usize::from(own.filler) == filler);
        &self.estimates[before..before + own]
    }

    /// The estimates of each filler.
    pub(crate) fn fillers(&self) -> impl Iterator<Item = &[Proof]> {
        (0..self.subject.fillers.len()).map(|filler| self.filler(filler))
    }

    /// The fillers, grouped into launches: those with the same errors that lack the same blocks share one.
    fn grouped(&self, lacking: impl IntoIterator<Item = Vec<Block>>) -> Vec<(Vec<Block>, Vec<usize>)> {
        let errors = |filler: usize| self.filler(filler).iter().map(|estimate| estimate.error);
        let mut groups: Vec<(Vec<Block>, Vec<usize>)> = Vec::new();
        for (filler, blocks) in lacking.into_iter().enumerate() {
            let most = MAX_ESTIMATES / self.filler(filler).len().max(1);
            let joins = |group: &&mut (Vec<Block>, Vec<usize>)| {
                group.0 == blocks && group.1.len() < most && errors(group.1[0]).eq(errors(filler))
            };
            match groups.iter_mut().find(joins) {
                Some(group) => group.1.push(filler),
                None => groups.push((blocks, vec![filler])),
            }
        }
        groups
    }

    /// The launch of some fillers with the same errors.
    pub(crate) fn launch(&self, fillers: &[usize]) -> Result<Launch, Unrepresentable> {
        let Proven { study, subject, point, .. } = self;
        let own = fillers.iter().map(|&filler| (&subject.fillers[filler], &point.fills[filler]));
        let lowered = Lowered::of(point, own, &subject.errors, study.seed, study.streams)?;
        Ok(lowered.launch(&Vec::from_iter(0..fillers.len())))
    }

    /// The addresses of the estimates of a launch, in its order.
    fn launched(&self, fillers: &[usize]) -> Vec<Address> {
        let of_error = |error| {
            let all = fillers.iter().flat_map(|&filler| self.filler(filler));
            all.filter(move |own| own.error == error)
        };
        Error::ALL.into_iter().flat_map(of_error).map(|own| self.address(own)).collect()
    }
}

impl Launched for Proven<'_> {
    fn id(&self) -> Id {
        self.id
    }

    fn addresses(&self) -> Vec<Address> {
        self.estimates.iter().map(|estimate| self.address(estimate)).collect()
    }

    fn launches(&self) -> usize {
        self.grouped(self.subject.fillers.iter().map(|_| vec![])).len()
    }

    fn work(&self, lacking: Lacking) -> Result<Vec<Work<'_>>, StoreError> {
        let mut lacks = Vec::new();
        for estimates in self.fillers() {
            let addresses: Vec<Address> = estimates.iter().map(|estimate| self.address(estimate)).collect();
            lacks.push(lacking(&addresses, STEPS)?);
        }
        let groups = self.grouped(lacks).into_iter().filter(|(blocks, _)| !blocks.is_empty());
        let work = |(blocks, fillers): (Vec<Block>, Vec<usize>)| {
            Work::new(STEPS, move || Ok((self.launch(&fillers)?, self.launched(&fillers))), blocks)
        };
        Ok(groups.map(work).collect())
    }

    fn trials(&self, asked: u64) -> u64 {
        asked.next_multiple_of(self.replay)
    }
}

impl Plan<'_> {
    /// Doubles the trials of points where an error is not precise enough; returns whether there were any.
    fn raise_imprecise(&self, wanted: &mut [u64], store: &Store) -> Result<bool, StoreError> {
        let Some(precision) = &self.study.precision else { return Ok(false) };
        let mut raised = false;
        for (point, wanted) in self.points.iter().zip(wanted) {
            let most = point.trials(self.study.trials);
            let mut estimates = point.estimates.iter().take_while(|_| *wanted < most);
            let is_imprecise = estimates.try_fold(false, |is_imprecise, estimate| {
                let within = |tally| known(precision, estimate, &tally);
                let address = point.address(estimate);
                Ok(is_imprecise || !within(store.total_within(&address, *wanted)?))
            })?;
            if is_imprecise {
                *wanted = (2 * *wanted).min(most);
                raised = true;
            }
        }
        Ok(raised)
    }

    /// The number of fillers at points whose errors lack the requested precision, followed by the number of all fillers
    /// at points.
    ///
    /// # Errors
    /// A row of the store is damaged, or the disk fails.
    fn imprecise(&self, store: &Store) -> Result<(usize, usize), StoreError> {
        let Some(precision) = &self.study.precision else { return Ok((0, 0)) };
        let (mut imprecise, mut all) = (0, 0);
        let fillers = self.points.iter().flat_map(|point| point.fillers().map(move |own| (point, own)));
        for (point, estimates) in fillers {
            let mut is_precise = true;
            for estimate in estimates {
                is_precise &= known(precision, estimate, &store.total(&point.address(estimate))?);
            }
            imprecise += usize::from(!is_precise);
            all += 1;
        }
        Ok((imprecise, all))
    }
}

/// Whether a tally gives the error of an estimate with the requested precision.
fn known(precision: &Precision, estimate: &Proof, tally: &Moments) -> bool {
    let Some(found) = Estimates::new(tally, estimate.bin_base, 1.0) else { return false };
    let within = |part: Option<f64>, half: Option<f64>, value: Option<f64>| {
        part.is_none_or(|part| half.zip(value).is_some_and(|(half, value)| half <= part * value))
    };
    let rms_half = found.rms_se.map(|se| NORMAL_95 * se);
    let q_half = found.p99_73.and_then(|q| q.low.zip(q.high)).map(|(low, high)| 0.5 * (high - low));
    within(precision.rms, rms_half, Some(found.rms))
        && within(precision.p99_73, q_half, found.p99_73.map(|q| q.value))
}
