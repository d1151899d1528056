//! Running a gap-fill study: trials that the store lacks are sampled, and what it holds is tabulated.

pub(crate) mod proven;
pub(crate) mod stop;

use crate::chart::Law;
use crate::filler::Filler;
use crate::filler::read::Error;
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::columns::{Row, columns};
use crate::kinds::gap_fill::run::proven::{Proof, Proven, STEPS};
use crate::kinds::gap_fill::tuning::{Tuning, tuned};
use crate::kinds::plan::{Appended, Launched, PointsPlan, Tabulated, table};
use crate::sampling::{Found, RunError, Tables};
use crate::store::error::StoreError;
use crate::store::{Held, Store};
use crate::tally::row_log2;
use sagnac_base::quantity::number::significant;
use sagnac_base::source::diagnose::StudyError;
use sagnac_base::table::Table;
use sagnac_kernel::moments::Moments;

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
            let found = Found::of(&store.total(&point.address(proof))?, *bin_base, *unit_arcsec);
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
        let blank = Found::default();
        let mut rows = Vec::new();
        for proven in points {
            let row = |estimate| Row { proven, filler: self.filler(estimate), estimate, found: &blank };
            rows.extend(proven.estimates.iter().map(row));
        }
        let found = |at: usize, tally: &Moments| {
            let Proof { bin_base, unit_arcsec, theory, .. } = *rows[at].estimate;
            let mut found = Found::of(tally, bin_base, unit_arcsec);
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
