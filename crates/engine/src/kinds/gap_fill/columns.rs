//! The columns of a gap-fill study, with a row for each point, filler and error.

use crate::chart::Law;
use crate::filler::{FILLERS, Filler, LISTED};
use crate::kinds::gap_fill::lower::Theory;
use crate::kinds::gap_fill::run::proven::{Proof, Proven};
use crate::sampling::{self, Found};
use sagnac_base::table::column::abouts;
use sagnac_base::table::{About, ColumnOf, Role, Unit, Usual};

/// Meaning of the column of fillers, here and in other files.
pub const FILLER: &str = "Name of the gap filler, as in `switching.fillers`.";

/// The laws that a chart can draw, each in a column.
pub(crate) const LAWS: &[Law] =
    &[Law::TaylorExtremum, Law::TaylorZeroCrossing, Law::NoiseAsPublished, Law::Noise];

/// A row before it becomes cells.
pub(crate) struct Row<'a> {
    pub(crate) proven: &'a Proven<'a>,
    pub(crate) filler: &'a Filler,
    pub(crate) estimate: &'a Proof,
    pub(crate) found: &'a Found,
}

impl Row<'_> {
    /// A reference curve of the chart, ″.
    pub(crate) fn law(&self, law: Law) -> Option<f64> {
        law.arcsec(&self.proven.point.inputs, self.filler, self.estimate.error, self.estimate.ticks.into())
    }

    fn z(&self) -> Option<f64> {
        let Theory { rms, rounding, resolution, omitted, .. } = self.estimate.theory;
        // A bound larger than the standard error would hide what the trials show.
        let hides = self.found.rms_se().is_some_and(|se| rounding > se);
        self.found.z(rms, if hides { resolution + omitted } else { rounding })
    }
}

/// The columns except the swept keys, in the order of the file; those of a specification come first.
#[rustfmt::skip]
pub(crate) fn columns<'a>(is_specified: bool) -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    let specified = is_specified.then(of_specification).into_iter().flatten();
    let labelled = |label, of_motion| if is_specified { of_motion } else { label };
    let mut columns = vec![
        Of::new("dt_nu", Unit::NONE, "Δt·ν", |row| row.proven.point.inputs.dt_nu().into())
            .is_of("motion.frequency", Role::Coordinate, "Δt·ν with Δt = (n+1)T/2, from the middle of the gap to the nearest valid sample; for \
                one tone of fixed frequency, else blank.")
            .defined("Δt = (n+1)T/2"),
        Of::new("amplitude_noise", Unit::NONE, "rate amplitude · T / σ", |row| row.proven.point.inputs.amplitude_noise().into())
            .is(Role::Coordinate, "A_Ω·T/σ, the angle of a tick at the peak of the rate, divided by the noise of the tick (1 σ); for one \
                tone of fixed frequency and amplitude, else blank."),
        Of::new("filler", Unit::NONE, "filler", |row| row.filler.name.as_str().into())
            .is_of(FILLERS, Role::Key, FILLER)
            .styled(LISTED),
        Of::new("error", Unit::NONE, "error", |row| row.estimate.error.name().into())
            .is_of("switching.errors", Role::Key, "The error: `residual` after the gap is closed and corrected; `extrapolation` at the end of the gap, before the \
                correction; `in-gap`, the largest error while the gap is open."),
        Of::new("trials", Unit::NONE, "trials", |row| row.found.trials.into())
            .is(Role::Trials, "Number of trials behind the estimates of the row."),
        Of::new("mean", Unit::ARCSEC, labelled("mean error", "mean error on [motion]"), |row| row.found.cell(|found| found.mean))
            .is(Role::Estimate, "Mean error, ″, with its sign.")
            .linear()
            .within(|row| row.found.mean_band()),
        Of::new("rms", Unit::ARCSEC, labelled("rms error", "rms error on [motion]"), |row| row.found.cell(|found| found.rms))
            .is(Role::Error, "Root mean square error, ″, motion and noise together.")
            .brief()
            .usual(Usual::Estimate)
            .within(|row| row.found.rms_band()),
        Of::new("rms_se", Unit::ARCSEC, "standard error of the rms", |row| row.found.rms_se().into())
            .is_of("rms", Role::StandardError, sampling::RMS_SE),
        Of::new("max", Unit::ARCSEC, labelled("largest error seen", "largest error seen on [motion]"), |row| row.found.cell(|found| found.max))
            .is(Role::Error, "The largest magnitude of an error among the trials, ″; the noise reaches 6.3 standard deviations."),
        Of::new("p99_73", Unit::ARCSEC, labelled("99.73 % error", "99.73 % error on [motion]"), |row| row.found.level(|q| Some(q.value)).into())
            .is(Role::Error, "The level, ″, which 99.73 % of errors stay below in magnitude; for a Gaussian it is 3 σ.")
            .brief()
            .usual(Usual::Answer)
            .within(|row| row.found.level_band()),
        Of::new("p99_73_lo", Unit::ARCSEC, "99.73 % error (lower)", |row| row.found.level(|q| q.low).into())
            .is_of("p99_73", Role::Lower, sampling::LEVEL_LOWER),
        Of::new("p99_73_hi", Unit::ARCSEC, "99.73 % error (upper)", |row| row.found.level(|q| q.high).into())
            .is_of("p99_73", Role::Upper, sampling::LEVEL_UPPER),
        Of::new("theory_rms", Unit::ARCSEC, "rms error (closed form)", |row| row.estimate.theory.rms.into())
            .is_of("rms", Role::Theory, "`rms` in closed form, ″, for the rounded inputs of the computation; blank where there is no closed form."),
        Of::new("theory_max", Unit::ARCSEC, "largest error of the motion (closed form)", |row| row.estimate.theory.max.into())
            .is_of("max", Role::Theory, "The largest error due to the motion in closed form, ″, without noise; only for one tone of fixed amplitude."),
        Of::new("z", Unit::NONE, "deviation from the closed form, standard errors", |row| row.z().into())
            .is_of("rms", Role::Z, sampling::Z),
        Of::new("representation", Unit::NONE, "representation", |row| row.estimate.representation.into())
            .is_of("rms", Role::Representation, sampling::REPRESENTATION),
    ];
    if is_specified {
        // What is sampled is [motion] alone, which is not what fillers are judged on.
        columns.iter_mut().for_each(|column| column.about.usual = None);
    }
    specified.chain(columns).collect()
}

/// The columns of a study with a specification.
#[rustfmt::skip]
fn of_specification<'a>() -> [ColumnOf<Row<'a>>; 3] {
    type Of<'a> = ColumnOf<Row<'a>>;
    [
        Of::new("latency", Unit::S, "latency", |row| row.estimate.specified.map(|own| own.latency_s).into())
            .is(Role::Coordinate, "Time from the end of the gap to the correction, s; of the error `residual`.")
            .brief(),
        Of::new("specified_rms", Unit::ARCSEC, "rms error as specified", |row| row.estimate.specified.map(|own| own.worst.rms).into())
            .is(Role::Error, "The largest root mean square residual on the motion of `[specification]` with all its frequencies within their \
                tolerances, with noise, ″, in closed form.")
            .brief()
            .usual(Usual::Estimate),
        Of::new("specified_p99_73", Unit::ARCSEC, "99.73 % error as specified", |row| row.estimate.specified.map(|own| own.worst.level).into())
            .is_of("specified_rms", Role::Error, "The level, ″, which 99.73 % of these residuals stay below in magnitude; of several lines the one with the largest \
                residual counts as a sine, and all else as normally distributed.")
            .brief()
            .usual(Usual::Answer),
    ]
}

/// All possible columns of such a study except the swept keys.
pub(crate) fn described() -> Vec<About> {
    let laws = LAWS.iter().map(|law| law.about());
    let all = of_specification().into_iter().chain(columns(false)).collect::<Vec<_>>();
    abouts(&all).into_iter().chain(laws).collect()
}
