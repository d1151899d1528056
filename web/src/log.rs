//! Logs and curves: what is recognised of one, its analysis, models for filters, navigators, and the comparison of two.

use std::path::Path;
use std::sync::Arc;

use sagnac::allan::angles::Trend;
use sagnac::analysis::compare::logs::Compared;
use sagnac::analysis::data_sheet::Intervals;
use sagnac::analysis::log::{NoiseRequest, Treatment};
use sagnac::analysis::model::writers::WRITERS;
use sagnac::analysis::model::{Aim, ModelRequest, Quantization};
use sagnac::analysis::navigators::NavigatorRequest;
use sagnac::analysis::temperature::Effects;
use sagnac::fit::selection::{Fitting, Terms};
use sagnac::record::binary::Binary;
use sagnac::record::curve_file::{CurveFile, CurveRequest};
use sagnac::record::log::measure::{Data, Unit};
use sagnac::record::log::read::{Hints, Request, Timing, step_of};
use sagnac::record::log::{Log, Thermometer};
use sagnac::use_cases::Outcome;
use sagnac::use_cases::{self, AllanRequest, CompareRequest, ModelSource, Segments};
use sagnac_base::diagnostics::decoded;
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
        let log = Log::read_bytes(name, bytes_of(file)?, &self.request()?)?;
        Ok(Treatment::AS_RECORDED.checked(log)?)
    }

    /// The curve in a file, if it has one and is not given as binary.
    fn curve(&self, name: &str, file: Option<&&[u8]>) -> Result<Option<CurveFile>, Refusal> {
        let bytes = bytes_of(file)?;
        if !self.binary.trim().is_empty() || !CurveFile::is_in(bytes) {
            return Ok(None);
        }
        self.check_curve(name)?;
        self.curve_in(name, bytes, false).map(Some)
    }

    /// Refuses options that a curve has not.
    fn check_curve(&self, name: &str) -> Result<(), Refusal> {
        let of_logs = [("rate", &self.rate), ("data", &self.data), ("time", &self.time)];
        match of_logs.iter().find(|(_, option)| !option.trim().is_empty()) {
            Some((option, _)) => Err(Refusal::usage(&format!(
                "{option} needs a log, and {name} is a curve by its column of `tau`"
            ))),
            None => Ok(()),
        }
    }

    /// The curve in these bytes. Beside a log, the column is that of the log, and the unit too unless the curve has none.
    fn curve_in(&self, name: &str, bytes: &[u8], is_beside_log: bool) -> Result<CurveFile, Refusal> {
        let given = |text: &str| Some(text.trim().to_owned()).filter(|text| !text.is_empty());
        let column = given(&self.column).filter(|_| !is_beside_log);
        let read = |unit: Option<String>| {
            let (column, time_unit) = (column.clone(), given(&self.time_unit));
            let request = CurveRequest { column, unit, time_unit, ..CurveRequest::default() };
            CurveFile::parse(name, &decoded(bytes), &request)
        };
        let unit = given(&self.unit);
        Ok(read(unit.clone().filter(|_| !is_beside_log)).or_else(|_| read(unit))?)
    }

    /// A log of which something is asked that a curve has not.
    fn log(&self, name: &str, file: Option<&&[u8]>, asked: &str) -> Result<Log, Refusal> {
        match self.curve(name, file)? {
            Some(_) => Err(Refusal::usage(&format!("{asked} needs a log, and {name} is a curve"))),
            None => self.read(name, file),
        }
    }
}

/// The bytes of a file of the message.
fn bytes_of<'a>(file: Option<&&'a [u8]>) -> Result<&'a [u8], Refusal> {
    file.copied().ok_or_else(|| Refusal::usage("the message has no file"))
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
        if let Some(curve) = self.options.curve(&self.name, files.first())? {
            let ends = [curve.points.first(), curve.points.last()];
            let taus = ends.map(|end| significant(end.map_or(0.0, |end| end.tau_s), 4)).join(" s to ");
            let symbol = curve.unit.in_files(curve.deviation);
            return Ok(Reply::new(json!({
                "points": curve.points.len(),
                "taus": format!("{taus} s"),
                "columns": [{ "name": curve.name, "unit": symbol }],
                "notes": curve.notes.iter().map(|note| in_page(note)).collect::<Vec<_>>(),
                "records": 0,
            })));
        }
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
        let mut log = self.options.log(&self.name, files.first(), "the position error")?;
        self.outcome(&mut log, navigators, simulator, progress)
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
        if let Some(curve) = self.options.curve(&self.name, files.first())? {
            let path = Path::new(&self.name);
            return Reply::of_outcome(&use_cases::fit_curve(curve, path, fitting().as_ref(), &[])?);
        }
        Reply::of_outcome(&self.analyzed(files, None, simulator, progress)?)
    }

    /// The distance from their place within which 95 % of navigators with such gyros are after an hour.
    pub(crate) fn navigate(&self, files: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let request = NavigatorRequest { duration_s: 3600.0, limit: None };
        Reply::of_outcome(&self.analyzed(files, Some(request), None, progress)?)
    }

    /// Models that bound the noise of further records, with files for all tools.
    pub(crate) fn model(&self, files: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let curve = self.options.curve(&self.name, files.first())?;
        let log = if curve.is_none() { Some(self.options.read(&self.name, files.first())?) } else { None };
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
        let path = Path::new(&self.name);
        let of_log = log.as_ref().map(|log| ModelSource::Log(log, path));
        let source = curve.as_ref().map(|curve| ModelSource::Curve(curve, path)).or(of_log);
        let source = source.ok_or_else(|| Refusal::usage("the message has no file"))?;
        Reply::of_outcome(&use_cases::model_noise(source, &request, progress)?)
    }

    /// A study that simulates records with the noise of one column of the log.
    pub(crate) fn study(&self, files: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let mut log = self.options.log(&self.name, files.first(), "a study of this gyro")?;
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

/// A side of a comparison.
enum Read {
    Log(Log),
    Curve(CurveFile),
}

impl Read {
    fn compared(&self) -> Compared<'_> {
        match self {
            Read::Log(log) => Compared::Log(log),
            Read::Curve(curve) => Compared::Curve(curve),
        }
    }
}

impl TwoLogs {
    pub(crate) fn compare(&self, files: &[&[u8]]) -> Result<Reply, Refusal> {
        let [a, b] = &self.names;
        let is_curve = [0, 1].map(|place| files.get(place).is_some_and(|file| CurveFile::is_in(file)));
        let is_beside_log = is_curve.contains(&false);
        if !is_beside_log {
            self.options.check_curve(a)?;
        }
        let read = |place: usize| -> Result<Read, Refusal> {
            let (name, file) = (&self.names[place], files.get(place));
            Ok(match is_curve[place] {
                true => Read::Curve(self.options.curve_in(name, bytes_of(file)?, is_beside_log)?),
                false => Read::Log(self.options.read(name, file)?),
            })
        };
        let read = [read(0)?, read(1)?];
        let request =
            CompareRequest { treatment: Treatment::AS_RECORDED, fitting: fitting(), limits: vec![] };
        let sides = [(Path::new(a), read[0].compared()), (Path::new(b), read[1].compared())];
        Reply::of_outcome(&use_cases::compare_logs(sides, &request)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVE: &[u8] = b"tau,adev\n1,3\n2,2.1213\n4,1.5\n8,1.0607\n16,0.75\n32,0.5303\n";

    /// The JSON of an answer, or of a refusal.
    fn json(answer: Result<Reply, Refusal>) -> Value {
        let bytes = answer.unwrap_or_else(Refusal::into_reply).encode();
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        serde_json::from_slice(&bytes[4..4 + length]).unwrap()
    }

    #[test]
    fn a_curve_is_read_like_a_log_and_refused_where_samples_are_needed() {
        let log = json!({ "name": "curve.csv", "options": { "unit": "deg/h" } });
        let log: OneLog = serde_json::from_value(log).unwrap();
        let read = json(log.columns(&[CURVE]));
        assert_eq!((&read["points"], &read["records"]), (&json!(6), &json!(0)), "{read}");
        assert_eq!(read["taus"], "1 s to 32 s");
        let fitted = json(log.allan(&[CURVE], &Silent));
        assert!(fitted["headline"].as_str().unwrap().starts_with("N = 0.05"), "{fitted}");
        assert!(json(log.model(&[CURVE], &Silent))["error"].is_null());
        for refused in [log.navigate(&[CURVE], &Silent), log.study(&[CURVE], &Silent)] {
            let text = json(refused)["error"]["text"].to_string();
            assert!(text.contains("needs a log, and curve.csv is a curve"), "{text}");
        }
        let two = json!({ "names": ["a.csv", "b.csv"], "options": { "unit": "deg/h" } });
        let two: TwoLogs = serde_json::from_value(two).unwrap();
        let headline = json(two.compare(&[CURVE, CURVE]))["headline"].to_string();
        assert!(headline.contains("one record"), "{headline}");
    }
}
