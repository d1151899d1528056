//! The study file exactly as users write it, and its JSON schema.
//!
//! The doc comments here are the descriptions in the schema.

pub mod allan;
pub mod drift;
pub mod either;
pub mod motion;
pub mod relock;
pub mod suspension;
pub mod switching;

use std::borrow::Cow;
use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use toml::Spanned;

use crate::chart::file::Charts;
use crate::key::scalar::Scalar;
use crate::kinds::KINDS;
use crate::study::kind::Kind;

use crate::key::file::allan::{AllanTable, NoiseTable, RecordTable};
use crate::key::file::drift::{DriftTable, RunTable};
pub(crate) use crate::key::file::either::Either;
use crate::key::file::motion::MotionTable;
pub use crate::key::file::motion::{Phase, Position};
pub use crate::key::file::relock::FirstHalf;
use crate::key::file::relock::RelockTable;
use crate::key::file::suspension::SuspensionTable;
pub use crate::key::file::switching::Error;
use crate::key::file::switching::SwitchingTable;

/// A study of sagnac: one question about a laser gyroscope, and all that its answer depends on.
///
/// Quantities are texts with a unit: "5 ms", "20 Hz", "1.6 arcsec", "12000 arcsec/s", "0.003 deg/sqrt(h)".
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "sagnac study", transform = tables_of_kinds)]
pub(crate) struct StudyFile {
    /// Shown above charts and reports.
    pub(crate) title: String,
    /// What the study is to answer, in one sentence.
    #[serde(default)]
    pub(crate) question: String,
    #[schemars(with = "KindName")]
    pub(crate) kind: Spanned<String>,
    /// Seed of all random numbers; 1 if absent.
    #[serde(default)]
    #[schemars(with = "i64", range(min = 0))]
    pub(crate) seed: Option<Spanned<Scalar>>,
    /// Monte Carlo trials at each point; 1 000 000 if absent, and 1000 records of kind = "allan"; unused where all is
    /// in closed form.
    #[serde(default)]
    #[schemars(with = "i64", range(min = 1, max = 1_099_511_627_776_i64))]
    pub(crate) trials: Option<Spanned<Scalar>>,
    /// How precise a point has to be known to stop before all `trials`: "0.5 %", half the 95 % interval of the rms as a part of it, or
    /// of other estimates by name. "none": all trials.
    #[serde(default)]
    #[schemars(with = "Either<PrecisionTable>", extend("examples" = ["0.5 %"]))]
    pub(crate) precision: Option<Spanned<Either<PrecisionTable>>>,
    #[serde(default)]
    pub(crate) streams: Streams,
    /// Of kind = "gap-fill" and "relock".
    #[serde(default)]
    #[schemars(with = "GyroTable")]
    pub(crate) gyro: Option<Spanned<GyroTable>>,
    /// Of kind = "gap-fill".
    #[serde(default)]
    #[schemars(with = "MotionTable")]
    pub(crate) motion: Option<Spanned<MotionTable>>,
    /// Of kind = "gap-fill".
    #[serde(default)]
    #[schemars(with = "SwitchingTable")]
    pub(crate) switching: Option<Spanned<SwitchingTable>>,
    /// Of kind = "drift-budget" and "switched-run".
    #[serde(default)]
    #[schemars(with = "DriftTable")]
    pub(crate) drift: Option<Spanned<DriftTable>>,
    /// Of kind = "drift-budget" and "switched-run".
    #[serde(default)]
    #[schemars(with = "RunTable")]
    pub(crate) run: Option<Spanned<RunTable>>,
    /// Of kind = "relock".
    #[serde(default)]
    #[schemars(with = "RelockTable")]
    pub(crate) relock: Option<Spanned<RelockTable>>,
    /// Of kind = "suspension".
    #[serde(default)]
    #[schemars(with = "SuspensionTable")]
    pub(crate) suspension: Option<Spanned<SuspensionTable>>,
    /// Of kind = "allan".
    #[serde(default)]
    #[schemars(with = "RecordTable")]
    pub(crate) record: Option<Spanned<RecordTable>>,
    /// Of kind = "allan"; of kind = "gap-fill" in place of gyro.tick_noise.
    #[serde(default)]
    #[schemars(with = "NoiseTable")]
    pub(crate) noise: Option<Spanned<NoiseTable>>,
    /// Of kind = "allan".
    #[serde(default)]
    #[schemars(with = "AllanTable")]
    pub(crate) allan: Option<Spanned<AllanTable>>,
    /// Each varies one key; several multiply, the first being the slowest to change.
    #[serde(default)]
    #[schemars(with = "Vec<SweepTable>")]
    pub(crate) sweep: Vec<SweepTable>,
    /// One chart or several; absent, a chart that suits the kind of study.
    #[serde(default)]
    pub(crate) chart: Charts,
}

/// Precision by estimate: half its 95 % interval as a part of it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrecisionTable {
    /// Of the rms: "0.5 %".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) rms: Option<Spanned<Scalar>>,
    /// Of the 99.73 % level: "2 %".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) q9973: Option<Spanned<Scalar>>,
}

/// The name of a kind of study.
struct KindName;

impl JsonSchema for KindName {
    fn schema_name() -> Cow<'static, str> {
        "Kind".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let of_kind =
            |kind: &&Kind| json!({ "description": kind.subject, "type": "string", "const": kind.name });
        let kinds: Vec<_> = KINDS.iter().map(of_kind).collect();
        schemars::json_schema!({ "description": "What is studied.", "oneOf": kinds })
    }
}

impl StudyFile {
    /// The tables that not every kind has, each with its place where it is written.
    pub(crate) fn tables(&self) -> [(&'static str, Option<Range<usize>>); 10] {
        [
            ("gyro", self.gyro.as_ref().map(Spanned::span)),
            ("motion", self.motion.as_ref().map(Spanned::span)),
            ("switching", self.switching.as_ref().map(Spanned::span)),
            ("drift", self.drift.as_ref().map(Spanned::span)),
            ("run", self.run.as_ref().map(Spanned::span)),
            ("relock", self.relock.as_ref().map(Spanned::span)),
            ("suspension", self.suspension.as_ref().map(Spanned::span)),
            ("record", self.record.as_ref().map(Spanned::span)),
            ("noise", self.noise.as_ref().map(Spanned::span)),
            ("allan", self.allan.as_ref().map(Spanned::span)),
        ]
    }
}

/// Whether the points of a study share their random numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Streams {
    /// Every point draws its own random numbers.
    #[default]
    Independent,
    /// A trial sees the same random numbers at every point: smooth curves, paired differences.
    Common,
}

impl Streams {
    /// As study files call it.
    pub fn name(self) -> &'static str {
        match self {
            Streams::Independent => "independent",
            Streams::Common => "common",
        }
    }
}

/// The gyro.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GyroTable {
    /// Length of a tick, the time between two readings of the angle: "5 ms".
    #[schemars(with = "String", extend("examples" = ["5 ms"]))]
    pub(crate) tick: Spanned<Scalar>,
    /// Absent where `[noise]` gives it.
    #[serde(default)]
    #[schemars(with = "TickNoiseTable")]
    pub(crate) tick_noise: Option<Spanned<TickNoiseTable>>,
    /// Angle of a pulse, where whole pulses are read: "3.2 arcsec". Not quantised if absent.
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) readout_lsb: Option<Spanned<Scalar>>,
    /// What the uncorrected relock adds to the ticks n+1, n+2, …: ["20.3 arcsec", "14.8 arcsec"].
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub(crate) relock: Option<Spanned<Vec<Spanned<Scalar>>>>,
}

/// Noise of the angle of one tick, independent from tick to tick; in exactly one of three forms.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1, "maxProperties" = 1))]
pub(crate) struct TickNoiseTable {
    /// Standard deviation, an angle: "0.53 arcsec".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) std: Option<Spanned<Scalar>>,
    /// Three standard deviations, an angle: "1.6 arcsec".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) three_sigma: Option<Spanned<Scalar>>,
    /// Angle random walk N, from which the standard deviation is N·√tick: "0.003 deg/sqrt(h)".
    #[serde(default)]
    #[schemars(with = "String")]
    pub(crate) angle_random_walk: Option<Spanned<Scalar>>,
}

/// Values for one key, in exactly one of three forms.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 2, "maxProperties" = 2))]
pub(crate) struct SweepTable {
    /// The key to vary: "motion.frequency".
    #[schemars(with = "String")]
    pub(crate) key: Spanned<String>,
    /// The values one by one.
    #[serde(default)]
    #[schemars(with = "Vec<ValueSchema>")]
    pub(crate) list: Option<Spanned<Vec<Spanned<Scalar>>>>,
    /// Values at equal differences.
    #[serde(default)]
    #[schemars(with = "SpacingTable")]
    pub(crate) linear: Option<Spanned<SpacingTable>>,
    /// Values at equal ratios.
    #[serde(default)]
    #[schemars(with = "SpacingTable")]
    pub(crate) log: Option<Spanned<SpacingTable>>,
}

/// Evenly spaced values, both ends included.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpacingTable {
    #[schemars(with = "ValueSchema")]
    pub(crate) from: Spanned<Scalar>,
    #[schemars(with = "ValueSchema")]
    pub(crate) to: Spanned<Scalar>,
    /// How many values.
    #[schemars(with = "i64", range(min = 1, max = 10_000))]
    pub(crate) points: Spanned<Scalar>,
}

/// The number of a tick, or an inclusive range: -1, "n+1", "-7..0".
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum TickSchema {
    Number(i32),
    Text(String),
}

/// A quantity as text with its unit, or a number where the key has no unit.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
pub(crate) enum ValueSchema {
    Number(f64),
    Text(String),
}

/// Which tables each kind needs.
fn tables_of_kinds(schema: &mut schemars::Schema) {
    let needs = |kind: &&Kind| {
        json!({
            "if": { "properties": { "kind": { "const": kind.name } } },
            "then": { "required": kind.needs },
        })
    };
    let kinds: Vec<_> = KINDS.iter().map(needs).collect();
    schema.insert("allOf".to_owned(), json!(kinds));
}

/// The JSON schema of study files, for editors and other programs.
pub fn schema() -> String {
    let schema = schemars::schema_for!(StudyFile);
    // The alternate form of a JSON value is the indented one.
    format!("{:#}\n", schema.as_value())
}
