//! The entry of studies of navigation in the list of kinds.

use std::sync::Arc;

use crate::chart::{Ground, Source};
use crate::key::row::Key;
use crate::kinds::navigation::columns::{self, LAWS, OF_FILTERS};
use crate::kinds::navigation::keys::Solution;
use crate::kinds::navigation::{Navigation, keys, parts, read, run, sweepable};
use crate::noise::values;
use crate::sampling::Planned;
use crate::study::{Dissected, Kind, Study, Subject};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::units::{Dimension, Quantity};
use sagnac_base::table::column::abouts;
use sagnac_kernel::navigation::VERSION;

/// Errors of navigators.
pub(crate) static NAVIGATION: Kind = Kind {
    name: "navigation",
    subject: "The error of heading, velocity and position that the noise of its gyros leaves a navigator.",
    about: "Simulates records of the gyros of a navigator with the noise of [noise] and sums their increments with the weights \
            that follow from its error equations. points.csv has the error of the position over the ground after the time of \
            navigation, `position_cep` and `position_p95`, below which half and 95 % of the trials stay, in nautical miles, and \
            likewise those of velocity, tilt and heading; for solution = \"heading\" and \"gyrocompass\" the heading alone. With \
            navigation.filter a Kalman filter keeps the heading, and the table has its consistency, `nees` and `within95`.",
    template: include_str!("template.toml"),
    is_exact: false,
    trials: 1000,
    needs: &["navigation", "noise"],
    keys,
    sweepable,
    columns: &[(Source::Points, columns::described)],
    kernels: || format!("navigation {VERSION}"),
    loads: crate::kinds::navigation::verify::loads,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for Navigation {
    fn plan<'a>(&'a self, study: &'a Study, progress: &dyn Progress) -> Planned<'a> {
        let plan = run::Plan::new(study, self, progress)?;
        Ok(plan.map(|plan| Box::new(plan) as _))
    }

    fn dissected(&self, point: usize) -> Option<Dissected> {
        let (parts, points) = parts::dissected(self.points.get(point)?);
        Some(Dissected { parts, subject: Arc::new(Navigation { points, ..self.clone() }) })
    }

    fn values(&self, point: usize) -> Vec<(&'static Key, Quantity)> {
        self.points.get(point).map(|point| values(&point.inputs.noise)).unwrap_or_default()
    }

    fn grounds(&self) -> Vec<Ground> {
        let columns = abouts(&columns::columns(self.solution, self.has_filter()));
        let limits: &[Dimension] = match self.solution {
            Solution::Inertial => &[Dimension::Distance, Dimension::Angle, Dimension::Speed],
            Solution::Heading | Solution::Gyrocompass => &[Dimension::Angle],
        };
        let laws = match self.solution {
            Solution::Inertial => &LAWS[..],
            Solution::Heading if self.has_filter() => &OF_FILTERS[..],
            Solution::Heading | Solution::Gyrocompass => &[],
        };
        vec![Ground { laws, ..Ground::of(Source::Points, columns, [], limits) }]
    }
}
