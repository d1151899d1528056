//! A point that is proven to fit. Of its lowered form only what tables and the stop rule need is kept; the words of its
//! launches are made again for the batches that sample it.

use crate::filler::latency_ticks;
use crate::filler::read::Error;
use crate::key::row::Refusal;
use crate::kinds::gap_fill::GapFill;
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::judged::{Judge, Size};
use crate::kinds::gap_fill::lower::Lowered;
use crate::kinds::gap_fill::lower::estimate::{Estimate, Theory};
use crate::kinds::gap_fill::lower::physical_theory::PhysicalTheory;
use crate::kinds::gap_fill::point::Point;
use crate::kinds::plan::{Lacking, Launched};
use crate::sampling;
use crate::sampling::batches::Work;
use crate::store::Address;
use crate::store::error::StoreError;
use crate::study::Study;
use crate::tally::{Block, Id};
use sagnac_kernel::launch::Launch;
use sagnac_kernel::moments::MAX_ESTIMATES;
use sagnac_theory::rows::sides;

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
    fn of(inputs: &Inputs, estimate: &Estimate) -> Option<Specified> {
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
pub(crate) const STEPS: u64 = 1;

impl Proof {
    /// # Errors
    /// The closed form of the words differs from that of the inputs by more than the rounding of words explains.
    fn of(
        name: &str,
        filler: usize,
        estimate: &Estimate,
        inputs: &Inputs,
        physical: &PhysicalTheory,
    ) -> Result<Proof, Refusal> {
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
            specified: Specified::of(inputs, estimate),
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
    ) -> Result<Proven<'a>, Refusal> {
        let lowered = Lowered::new(point, &subject.fillers, &subject.errors, study.seed, study.streams)?;
        let (id, replay) = (lowered.id, lowered.whole_replays(1));
        let physical = PhysicalTheory::new(&point.inputs, point.sides());
        let fillers = lowered.fillers.iter().zip(&subject.fillers).enumerate();
        let proofs = fillers.flat_map(|(place, (all, filler))| {
            let physical = &physical;
            all.iter().map(move |estimate| Proof::of(&filler.name, place, estimate, &point.inputs, physical))
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
    pub(crate) fn launch(&self, fillers: &[usize]) -> Result<Launch, Refusal> {
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
