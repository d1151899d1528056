//! Studies of a suspension: its response as a function of the vibration frequency, in closed form.

use std::sync::Arc;

use crate::chart::{Source, TableSchema};
use crate::key::document::SpanMap;
use crate::key::sweep::{SweepTarget, Sweep, Sweepable, SweepValue};
use crate::key::{Key, ParseContext, ValueType, keys, measure};
use crate::kinds::plan::{ClosedFormPlan, table};
use crate::motion::keys::{GYROS, MODE_FREQUENCIES, QS, RESPONSES, SuspensionKeys};
use crate::sampling::Planned;
use crate::study::{Kind, Study, Subject};
use sagnac_base::diagnostics::{Fault, Wrong};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::Dimension;
use sagnac_base::table::column::abouts;
use sagnac_base::table::{ColumnOf, Role, Unit, Usual};
use sagnac_theory::vibration::{Response, Suspension};

/// The part of a study that is specific to a suspension.
#[derive(Debug, Clone)]
pub(crate) struct SuspensionStudy {
    /// All points, in order; without a sweep, a single one.
    pub points: Vec<Point>,
    /// The inputs that all points have in common.
    base: Point,
}

/// One combination of swept values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Point {
    /// Name of each swept key with its value here, in the order of the sweeps.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// Suspension.
    pub suspension: Arc<Suspension>,
    /// Frequency of the vibration, Hz.
    pub frequency_hz: f64,
}

impl Point {
    /// The study whose points have these inputs, but for some sweeps.
    fn with_points(self, sweeps: &[Sweep]) -> SuspensionStudy {
        let points = sweepable().points(&self, sweeps).map(|(swept, point)| Point { swept, ..point });
        SuspensionStudy { points: points.collect(), base: self }
    }

    pub(crate) fn response(&self) -> Response {
        self.suspension.response(self.frequency_hz)
    }
}

keys! {
    /// The keys of the suspension.
    static KEYS;
    /// The suspension of a gyro, given by the name of a known one or by its modes.
    SUSPENSION_TABLE = "suspension", "", Fixed, ValueType::Table, "[suspension]\ngyro = \"LGK-400\"\nfrequency = \"380 Hz\"";
    /// Suspension of "LGK-400" or "LGV-1": frequencies as published, Q factors and responses assumed.
    GYRO = "suspension.gyro", "gyro", Choice, GYROS, r#"gyro = "LGK-400""#;
    /// Modes of the suspension instead of a name, second-order resonances with the useful one first.
    MODES = "suspension.modes", "", Fixed, ValueType::List(&ValueType::Table), r#"modes = [{ frequency = "380 Hz", q = 100, response = "20000 arcsec/s/g" }]"#;
    /// Natural frequency: "380 Hz".
    MODE_FREQUENCY = "suspension.modes.frequency", "", Fixed, MODE_FREQUENCIES, r#"frequency = "380 Hz""#, required;
    /// Q factor, a number.
    MODE_Q = "suspension.modes.q", "", Fixed, QS, "q = 100", required;
    /// Amplitude of the rate per acceleration at resonance, for this mode alone; negative where it turns the other way:
    /// "20000 arcsec/s/g".
    MODE_RESPONSE = "suspension.modes.response", "", Fixed, RESPONSES, r#"response = "20000 arcsec/s/g""#, required;
    /// Frequency of the vibration: "380 Hz"; absent where it is swept.
    FREQUENCY = "suspension.frequency", "vibration frequency", Condition, FREQUENCIES, r#"frequency = "380 Hz""#;
}

const FREQUENCIES: ValueType = measure(&[Dimension::Frequency], 1e-6, 1e7, "1e-6 Hz to 1e7 Hz");

const OF_SUSPENSION: SuspensionKeys = SuspensionKeys {
    table: &SUSPENSION_TABLE,
    gyro: &GYRO,
    modes: &MODES,
    mode: [&MODE_FREQUENCY, &MODE_Q, &MODE_RESPONSE],
};

static SETTINGS: [SweepTarget<Point>; 1] =
    [SweepTarget::new(&FREQUENCY, |point, frequency| point.frequency_hz = frequency.value)];

/// Every key of this kind.
fn keys() -> Vec<&'static Key> {
    KEYS.to_vec()
}

/// The keys that can be swept.
fn sweepable() -> Sweepable<Point> {
    let gyro = |point: &mut Point, name: &str| SuspensionKeys::set(&mut point.suspension, name);
    Sweepable::new().own(&SETTINGS).name(&GYRO, gyro)
}

/// Reads the part of a study that belongs to this kind.
fn read(reading: &mut ParseContext) -> Result<SuspensionStudy, Wrong> {
    reading.note(&[&SUSPENSION_TABLE]);
    let suspension = OF_SUSPENSION.read(reading)?;
    let mut base = Point { swept: vec![], suspension, frequency_hz: 0.0 };
    if reading.sweep(&FREQUENCY).is_none() {
        reading.table.needed(&FREQUENCY)?;
    }
    reading.set(&mut base, &SETTINGS)?;
    reading.notes.extend(OF_SUSPENSION.assumed(reading));
    Ok(base.with_points(reading.sweeps))
}

/// The rotation of a gyro on its suspension under vibration.
pub(crate) static SUSPENSION: Kind = Kind {
    name: "suspension",
    subject: "The rotation of a gyro on its suspension under vibration, in closed form.",
    about: "Samples nothing: the response of an elastic suspension to a vibration of its base. points.csv has `response`, the rate \
            divided by the acceleration, and its `phase` at each swept frequency.",
    template: include_str!("template.toml"),
    is_exact: true,
    trials: 1_000_000,
    needs: &["suspension"],
    keys,
    sweepable: || sweepable().keys(),
    columns: &[(Source::Points, || abouts(&columns()))],
    kernels: || "none".to_owned(),
    loads: Vec::new,
    read: |reading| Ok(Arc::new(read(reading)?)),
};

impl Subject for SuspensionStudy {
    fn plan<'a>(&'a self, study: &'a Study, _: &dyn Progress) -> Planned<'a> {
        let table = table(&study.sweeps, &columns(), &self.points, |point| &point.swept);
        Ok(Some(Box::new(ClosedFormPlan(table))))
    }

    fn with_points(&self, sweeps: &[Sweep], _: &SpanMap) -> Result<Arc<dyn Subject>, Fault> {
        Ok(Arc::new(self.base.clone().with_points(sweeps)))
    }

    fn grounds(&self) -> Vec<TableSchema> {
        vec![TableSchema {
            legend: ["", ""],
            ..TableSchema::new(Source::Points, abouts(&columns()), [], &[Dimension::RatePerAcceleration])
        }]
    }
}

/// The columns except the swept keys, in the order of the file.
#[rustfmt::skip]
fn columns() -> Vec<ColumnOf<Point>> {
    type Of = ColumnOf<Point>;
    vec![
        Of::new("response", Unit::ARCSEC_PER_S_PER_G, "rate per acceleration", |point| point.response().amplitude().into())
            .is(Role::Estimate, "Rate of the gyro per acceleration of the base, ″/s per g.")
            .usual(Usual::Estimate),
        Of::new("phase", Unit::DEG, "phase of the rate", |point| point.response().phase_deg().into())
            .is(Role::Estimate, "Phase of the rate relative to the acceleration, °; negative where the rate lags."),
        Of::new("normalized", Unit::NONE, "response relative to the useful mode", |point| {
            (point.response().amplitude() / point.suspension.useful()).into()
        })
        .is(Role::Estimate, "`response` divided by the response at the first mode."),
    ]
}
