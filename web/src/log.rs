//! Logs: what is recognised of one, its analysis, models for filters, navigators, and the comparison of two.

use std::path::Path;
use std::sync::Arc;

use sagnac::allan::angles::Trend;
use sagnac::analysis::compare::logs::Compared;
use sagnac::analysis::data_sheet::Intervals;
use sagnac::analysis::log::{NoiseRequest, Treatment};
use sagnac::analysis::model::writers::WRITERS;
use sagnac::analysis::model::{Aim, ModelRequest, Quantization};
use sagnac::analysis::navigators::NavigatorRequest;
use sagnac::analysis::temperature::regressors::Effects;
use sagnac::fit::selection::{Fitting, Terms};
use sagnac::record::binary::Binary;
use sagnac::record::log::measure::{Data, Unit};
use sagnac::record::log::read::{Hints, Request, Timing, step_of};
use sagnac::record::log::{Log, Thermometer};
use sagnac::use_cases::Outcome;
use sagnac::use_cases::{self, AllanRequest, CompareRequest, ModelSource, Segments};
use sagnac_base::progress::{Progress, Silent};
use sagnac_base::quantity::number::significant;
use sagnac_engine::kinds::allan::run::Simulator;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::message::{Refusal, Reply, in_page};
use crate::simulation::{Part, Player, Recorder};

/// The options for reading a log; an empty one leaves the choice to the file.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Options {
    /// Sampling rate or step, such as `100 Hz`.
    rate: String,
    /// Unit of the numbers, such as `deg/h`.
    unit: String,
    /// Kind of the numbers: `rate`, `increment` or `angle`.
    data: String,
    /// Names or numbers of the columns, separated by commas.
    column: String,
    /// Name or number of the column of the time stamps, or `none`.
    time: String,
    /// Unit of the time stamps, such as `ms`.
    #[serde(rename = "time-unit")]
    time_unit: String,
    /// Layout of a raw binary file, such as `f64 x7, little, time 1, rate 3`.
    binary: String,
    /// Name or number of the column of the temperature.
    temperature: String,
}

/// A log with what is asked of it.
#[derive(Deserialize)]
pub(crate) struct OneLog {
    name: String,
    #[serde(default)]
    options: Options,
    /// Number of simulated records for the intervals of coefficients: 0 for intervals in closed form, by default as many as the
    /// program makes.
    simulated: Option<usize>,
    /// Number of parts of simulated records whose files follow that of the log; none where they are still to be made.
    #[serde(default)]
    parts: usize,
    /// Place of the column among those that were read, of which a study is made; by default the first.
    column: Option<usize>,
}

/// A part of the records that are simulated for the intervals of a log.
#[derive(Deserialize)]
pub(crate) struct Simulate {
    #[serde(flatten)]
    log: OneLog,
    #[serde(flatten)]
    part: Part,
}

/// Two logs that are compared.
#[derive(Deserialize)]
pub(crate) struct TwoLogs {
    names: [String; 2],
    #[serde(default)]
    options: Options,
}

impl Options {
    fn request(&self) -> Result<Request, Refusal> {
        let kind = Data::ALL.into_iter().find(|data| data.name() == self.data);
        if kind.is_none() && !self.data.is_empty() {
            return Err(Refusal::usage(&format!("`data = {}` is no kind of numbers", self.data)));
        }
        let data = kind.unwrap_or(Data::Rate);
        let unit = |text: &str| {
            let unit = Unit::of_header(text.trim(), data);
            unit.map_err(|wrong| Refusal::usage(&format!("unit: {}\n{}", wrong.message, wrong.help)))
        };
        let units = parts(&self.unit).map(unit).collect::<Result<Vec<_>, _>>()?;
        let step_s = Some(self.rate.trim()).filter(|rate| !rate.is_empty()).map(step).transpose()?;
        let given = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
        let timing = Timing::new(step_s, given(&self.time), given(&self.time_unit))
            .map_err(|why| Refusal::usage(&why))?;
        let binary = given(&self.binary).map(|layout| Binary::parse(&layout)).transpose();
        let binary = binary.map_err(|why| Refusal::usage(&why.to_string()))?;
        let thermometer = |column| Thermometer { column, unit: None };
        Ok(Request {
            columns: parts(&self.column).map(str::to_owned).collect(),
            timing,
            // A unit that is given is that of a rate unless the kind is given too.
            data: kind.or((!units.is_empty()).then_some(data)),
            units,
            temperature: given(&self.temperature).map(thermometer),
            hints: Hints { binary, ..Hints::default() },
        })
    }

    fn read(&self, name: &str, file: Option<&&[u8]>) -> Result<Log, Refusal> {
        let bytes = file.ok_or_else(|| Refusal::usage("the message has no file"))?;
        let log = Log::read_bytes(name, bytes, &self.request()?)?;
        Ok(Treatment::AS_RECORDED.checked(log)?)
    }
}

/// The texts between commas.
fn parts(list: &str) -> impl Iterator<Item = &str> {
    list.split(',').map(str::trim).filter(|part| !part.is_empty())
}

/// The sampling interval for a rate, s.
fn step(rate: &str) -> Result<f64, Refusal> {
    let wrong = |why: String| {
        Refusal::usage(&format!(
            "`rate = {rate}`: {why}\ngive samples per second, as in 100 Hz, or the time between them"
        ))
    };
    step_of(rate).map_err(wrong)
}

fn fitting() -> Option<Fitting> {
    Some(Fitting { terms: Terms::of_model(Trend::None), from_s: None, to_s: None, is_forced: false })
}

impl OneLog {
    /// Lists the columns, the rate and the number of samples that were recognized in the file.
    pub(crate) fn columns(&self, files: &[&[u8]]) -> Result<Reply, Refusal> {
        let log = self.options.read(&self.name, files.first())?;
        let column = |channel: &sagnac::record::log::Channel| -> Value {
            json!({ "name": channel.name, "unit": channel.unit.text })
        };
        Ok(Reply::new(json!({
            "samples": log.samples(),
            "step_s": log.step_s,
            "rate": format!("{} Hz", significant(1.0 / log.step_s, 6)),
            "data": log.data.name(),
            "columns": log.channels.iter().map(column).collect::<Vec<_>>(),
            "notes": log.notes.iter().map(|note| in_page(note)).collect::<Vec<_>>(),
            "records": Intervals::simulated(None, log.samples() * log.channels.len()).records,
        })))
    }

    fn analyzed(
        &self,
        files: &[&[u8]],
        navigators: Option<NavigatorRequest>,
        simulator: Option<Arc<dyn Simulator>>,
        progress: &dyn Progress,
    ) -> Result<Outcome, Refusal> {
        self.outcome(&mut self.options.read(&self.name, files.first())?, navigators, simulator, progress)
    }

    fn outcome(
        &self,
        log: &mut Log,
        navigators: Option<NavigatorRequest>,
        simulator: Option<Arc<dyn Simulator>>,
        progress: &dyn Progress,
    ) -> Result<Outcome, Refusal> {
        let request = AllanRequest {
            treatment: Treatment::AS_RECORDED,
            noise: NoiseRequest {
                fitting: fitting(),
                simulated: self.simulated,
                simulator,
                ..NoiseRequest::default()
            },
            segments: Some(Segments { length_s: None, trend: Trend::None, is_required: false }),
            effects: Effects::parse("auto").map_err(|why| Refusal::usage(&why))?,
            is_compensated: false,
            window_s: None,
            navigators,
            limits: vec![],
        };
        Ok(use_cases::allan(log, Path::new(&self.name), &request, &mut vec![], progress)?)
    }

    pub(crate) fn allan(&self, files: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let made = (self.parts > 0).then(|| Player::new(files.get(1..).unwrap_or_default(), self.parts));
        let simulator = made.map(|made| Arc::new(made) as Arc<dyn Simulator>);
        Reply::of_outcome(&self.analyzed(files, None, simulator, progress)?)
    }

    /// The distance from their place within which 95 % of navigators with such gyros are after an hour.
    pub(crate) fn navigate(&self, files: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let request = NavigatorRequest { duration_s: 3600.0, limit: None };
        Reply::of_outcome(&self.analyzed(files, Some(request), None, progress)?)
    }

    /// Models that bound the noise of further records, with files for all tools.
    pub(crate) fn model(&self, files: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let log = self.options.read(&self.name, files.first())?;
        let request = ModelRequest {
            from_s: None,
            to_s: None,
            aim: Aim::Bound,
            margin: 0.2,
            states: None,
            quantization: Quantization::Measurement,
            filter_hz: None,
            confidence: 0.95,
            treatment: Treatment::AS_RECORDED,
            fitting: fitting(),
            writers: WRITERS.to_vec(),
        };
        let source = ModelSource::Log(&log, Path::new(&self.name));
        Reply::of_outcome(&use_cases::model_noise(source, &request, progress)?)
    }

    /// A study that simulates records with the noise of one column of the log.
    pub(crate) fn study(&self, files: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let mut log = self.options.read(&self.name, files.first())?;
        let place = self.column.unwrap_or(0);
        if place >= log.channels.len() {
            return Err(Refusal::usage("the log has no such column"));
        }
        log.channels = vec![log.channels.swap_remove(place)];
        let column = log.channels[0].name.clone();
        let outcome = self.outcome(&mut log, None, None, progress)?;
        let is_noise = |(name, _): &&(String, Vec<u8>)| name.starts_with("noise") && name.ends_with(".toml");
        let (_, noise) = outcome.files.iter().find(is_noise).ok_or_else(|| {
            Refusal::usage(
                "no coefficients describe the log\nonly a fit that describes its curve can be simulated",
            )
        })?;
        let noise = format!("\n{}", String::from_utf8_lossy(noise)).replace("\n[", "\n[noise.");
        let title = format!("Records like {column} of {}", self.name).replace(['"', '\\'], "'");
        let [step, length] = [log.step_s, log.step_s * log.samples() as f64]
            .map(|seconds| format!("{} s", significant(seconds, 9)));
        let text = format!(
            "title = \"{title}\"\nquestion = \"What Allan deviation do such records have?\"\nkind = \"allan\"\ntrials = 200\n\n\
             [record]\nsample = \"{step}\"\nlength = \"{length}\"\n\n[allan]\nfit = \"auto\"\n\n[noise]{noise}"
        );
        Ok(Reply::new(json!({ "text": text })))
    }
}

impl Simulate {
    /// The sums of a part of the records.
    pub(crate) fn answer(&self, files: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let recorder = Arc::new(Recorder::default());
        self.log.analyzed(files, None, Some(recorder.clone()), &Silent)?;
        let sums = recorder.sums(&self.part, progress)?;
        Ok(sums.into_iter().fold(Reply::new(json!({})), Reply::with_file))
    }
}

impl TwoLogs {
    pub(crate) fn compare(&self, files: &[&[u8]]) -> Result<Reply, Refusal> {
        let [a, b] = &self.names;
        let logs = [self.options.read(a, files.first())?, self.options.read(b, files.get(1))?];
        let request =
            CompareRequest { treatment: Treatment::AS_RECORDED, fitting: fitting(), limits: vec![] };
        let sides = [(Path::new(a), Compared::Log(&logs[0])), (Path::new(b), Compared::Log(&logs[1]))];
        Reply::of_outcome(&use_cases::compare_logs(sides, &request)?)
    }
}
