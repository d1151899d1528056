//! Lowering of whole runs: the drift in closed form, row by row, and the random parts of each filler's runs.
//!
//! Every part has a unit of at most 2^−29 of the largest angle that a run can reach.

pub(crate) mod drift;
pub(crate) mod fixed;
pub(crate) mod launch;
pub(crate) mod physical_theory;
pub(crate) mod relocking;
pub(crate) mod theory;
pub(crate) mod warm_up;

pub use crate::kinds::switched_run::lower::theory::RunTheory;

use crate::drift::{End, Schedule};
use crate::filler::Filler;
use crate::filler::read::Error;
use crate::key::row::{Refusal, Streams};
use crate::kinds::gap_fill::lower::physical_theory::{PhysicalTheory, Switch};
use crate::kinds::gap_fill::lower::residual::{Residual, ResidualTone};
use crate::kinds::gap_fill::lower::{Lowered, definition, words_of};
use crate::kinds::plan::identity;
use crate::kinds::switched_run::lower::drift::Drift;
use crate::kinds::switched_run::lower::fixed::Fixed;
use crate::kinds::switched_run::lower::physical_theory::PhysicalRun;
use crate::kinds::switched_run::lower::relocking::FixedRelocking;
use crate::kinds::switched_run::point::Point as RunPoint;
use crate::kinds::switched_run::{Angle as RunAngle, SwitchedRun};
use crate::sampling;
use crate::store::Address;
use crate::tally::Id;
use sagnac_kernel::moments::level;
use sagnac_kernel::switched_run;

/// A point of a study of whole runs, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct LoweredRun {
    /// Id of the point, under which its draws and tallies are found.
    pub id: Id,
    /// The runs of each filler, in the order of the study's fillers; a single entry where it has none.
    pub fillers: Vec<FilledRun>,
}

/// The runs of a point with one filler.
#[derive(Debug, Clone, PartialEq)]
pub struct FilledRun {
    key: [u32; 2],
    fixed: Fixed,
    /// These runs with an exact end, from which trajectories are made. Present where trajectories are kept and the end is drawn.
    exact: Option<Box<Fixed>>,
    /// Residual of a switch.
    pub residual: Residual,
    /// Estimates in the order of the study's angles.
    pub estimates: Vec<RunEstimate>,
    /// Address of the trajectories.
    pub trajectory: Address,
}

/// One angle of the runs.
#[derive(Debug, Clone, PartialEq)]
pub struct RunEstimate {
    /// The angle: at the end, the largest, or at one of the times.
    pub angle: RunAngle,
    /// Address of its tallies.
    pub address: Address,
    /// Closed form; absent for the largest angle, which has none.
    pub theory: Option<RunTheory>,
    /// Relative difference of its rms from that of the physical inputs, where there is one.
    pub representation: Option<f64>,
    /// Size of a unit of the tally, ″.
    pub unit_arcsec: f64,
    /// Level at which its histogram starts.
    pub bin_base: u32,
}

impl FilledRun {
    /// The runs that trajectories show.
    fn shown(&self) -> &Fixed {
        self.exact.as_deref().unwrap_or(&self.fixed)
    }

    /// Size of a unit of the angles of trajectories, ″.
    pub fn trajectory_unit_arcsec(&self) -> f64 {
        self.shown().lsb_arcsec
    }

    /// Mean and standard deviation of the effect of the relock of a switch, ″.
    fn relocked(&self) -> [f64; 2] {
        let relock = self.fixed.relock.as_ref();
        relock.map_or([0.0; 2], |relock| [relock.mean, libm::hypot(relock.deviation, relock.alike)])
    }

    /// Root mean square over switches of everything that a switch adds, ″.
    pub fn residual_rms(&self) -> f64 {
        let [mean, deviation] = self.relocked();
        let about_zero = self.residual.rms();
        libm::sqrt(
            about_zero * about_zero
                + 2.0 * mean * self.residual.constant_arcsec
                + mean * mean
                + deviation * deviation,
        )
    }

    /// Approximate largest effect of a switch, ″: sines at their peaks plus three standard deviations of the rest.
    pub fn residual_max(&self) -> f64 {
        let [mean, deviation] = self.relocked();
        let amplitudes: f64 = self.residual.tones.iter().map(|tone| tone.amplitude_arcsec).sum();
        let normal = libm::sqrt(self.residual.variance_arcsec2 + deviation * deviation);
        amplitudes + (self.residual.constant_arcsec + mean).abs() + SIGMAS * normal
    }

    /// Approximate rms of one of the angles, ″; for a compensated relock it is based on its first trials.
    pub fn expected_rms(&self, place: usize) -> f64 {
        self.fixed.expected_rms(self.estimates[place].angle, place) * self.fixed.lsb_arcsec
    }
}

/// Number of standard deviations that the paper takes as the largest error.
const SIGMAS: f64 = 3.0;

impl LoweredRun {
    /// Lowers a point of a study with this seed.
    ///
    /// # Errors
    /// The switch cannot be represented; see [`Refusal`].
    pub fn new(
        point: &RunPoint,
        study: &SwitchedRun,
        seed: u64,
        streams: Streams,
    ) -> Result<LoweredRun, Refusal> {
        let (switch, residuals) = residuals(point, study, seed, streams)?;
        let text = canonical(point, study, &switch);
        let (id, key) = identity("switched-run", seed, streams, &text);
        let drift = Drift::of(point, study);
        let schedule = Schedule { end: End::Exact, ..point.schedule };
        let exact = (study.trajectories > 0 && point.schedule.end != End::Exact)
            .then(|| RunPoint { schedule, ..point.clone() });
        let relocking = FixedRelocking::of(point)?;
        let physical = PhysicalRun::new(point, study);
        let filled = |Switched {
                          name,
                          definition,
                          residual,
                          physical: switch,
                          representation: of_switch,
                      }: Switched| {
            let relock = relocking.as_ref().map(|relocking| relocking.with(&residual.after));
            let exact = exact.as_ref().map(|point| {
                Box::new(Fixed::new(&Drift::of(point, study), &residual, relock.clone(), point, study))
            });
            let fixed = Fixed::new(&drift, &residual, relock, point, study);
            let of = |fixed: &Fixed, angle: String, more: Vec<u32>| {
                let estimate = Id::of(&format!("estimate\nfiller={definition}\nangle={angle}\n"));
                let words = [switched_run::VERSION, key[0], key[1]].into_iter().chain(fixed.words());
                Address { point: id, estimate, digest: Id::of_words(words.chain(more)) }
            };
            let estimate = |(place, angle): (usize, RunAngle)| {
                let theory = fixed.theory(angle, place);
                let inputs = switch.as_ref().and_then(|switch| physical.rms(switch, angle));
                let words = theory.map(|theory| theory.rms());
                let most = fixed.representation(point.switches() as f64 + 1.0, of_switch);
                if let Some(both) = words.zip(inputs) {
                    let what = format!("the angle `{}` of `{name}`", angle.name());
                    sampling::check_representation("run.duration", &what, both.into(), most)?;
                }
                let representation = sampling::representation(words, inputs, most);
                let bin_base = level((0.25 * fixed.expected_rms(angle, place)) as u32);
                let more = fixed.time_words(place).into_iter().chain([bin_base]);
                Ok(RunEstimate {
                    angle,
                    address: of(&fixed, angle.name(), more.chain(words_of(fixed.lsb_arcsec)).collect()),
                    theory,
                    representation,
                    unit_arcsec: fixed.lsb_arcsec,
                    bin_base,
                })
            };
            let estimates = study.angles().into_iter().enumerate();
            let estimates = estimates.map(estimate).collect::<Result<_, Refusal>>()?;
            let shown = exact.as_deref().unwrap_or(&fixed);
            let trajectory = of(shown, "trajectory".to_owned(), words_of(shown.lsb_arcsec).to_vec());
            Ok(FilledRun { key, estimates, trajectory, fixed, exact, residual })
        };
        let fillers = residuals.into_iter().map(filled).collect::<Result<_, Refusal>>()?;
        Ok(LoweredRun { id, fillers })
    }
}

/// The switch with a filler.
struct Switched {
    /// Name of the filler.
    name: String,
    definition: String,
    residual: Residual,
    /// The residual computed from the physical inputs; absent where it has no closed form.
    physical: Option<Switch>,
    /// Bound of the rms of the difference of the two, ″.
    representation: f64,
}

/// The identity of the switch, and the residual of each filler.
fn residuals(
    point: &RunPoint,
    study: &SwitchedRun,
    seed: u64,
    streams: Streams,
) -> Result<(String, Vec<Switched>), Refusal> {
    let Some(fill) = &point.fill else {
        let amplitude_arcsec = point.drift.residual_max;
        let tone = ResidualTone { amplitude_arcsec, tone: 0 };
        let tones = if amplitude_arcsec > 0.0 { vec![tone] } else { vec![] };
        let switched = Switched {
            name: "none".to_owned(),
            definition: "none".to_owned(),
            residual: Residual { tones, ..Residual::default() },
            physical: Some(Switch { mean: 0.0, variance: 0.0, sines: vec![(0, amplitude_arcsec)] }),
            representation: 0.0,
        };
        return Ok((format!("residual_max={amplitude_arcsec:.11e}"), vec![switched]));
    };
    let lowered = Lowered::new(fill, study.fillers(), &[Error::Residual], seed, streams)?;
    let theory = PhysicalTheory::new(&fill.inputs, fill.sides());
    // Delivered with the ticks, in addition to its effect on the filler.
    let relock: f64 = fill.inputs.relock.iter().sum();
    let of_filler = |(place, filler): (usize, &Filler)| {
        let mut residual = lowered.residual(place).unwrap_or_default();
        residual.constant_arcsec += relock;
        let estimate = lowered.fillers[place].first();
        let physical = estimate.map(|estimate| theory.switch(&estimate.rows));
        let definition = definition(filler, estimate.map(|estimate| &*estimate.rows), fill.designed());
        Switched {
            name: filler.name.clone(),
            definition: format!("{definition} ticks={:?}", fill.fills[place].fit_ticks),
            residual,
            physical: physical.map(|switch| Switch { mean: switch.mean + relock, ..switch }),
            representation: estimate.map_or(0.0, |estimate| estimate.representation),
        }
    };
    Ok((lowered.id.to_string(), study.fillers().iter().enumerate().map(of_filler).collect()))
}

/// The inputs that determine the draws and the angles to which they are added.
fn canonical(point: &RunPoint, study: &SwitchedRun, switch: &str) -> String {
    let Schedule { interval_s, duration_s, end } = point.schedule;
    // An exact end has no line.
    let end = if end == End::Exact { String::new() } else { format!("end={}\n", end.name()) };
    let relock = point.relock.as_ref().map_or_else(String::new, |relocking| {
        let (compensation, ticks) = (relocking.compensation.name(), relocking.relock.ticks);
        format!("compensation={compensation}\nrelock_ticks={ticks}\n{}", relocking.relock.identity())
    });
    format!(
        "interval_s={interval_s:.11e}\nduration_s={duration_s:.11e}\nfirst_mode={:?}\ntiming={:?}\nswitch={switch}\n{}{relock}{end}",
        study.first_mode,
        study.timing,
        point.drift.canonical(),
    )
}
