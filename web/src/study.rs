//! Studies: what sliders need to know of one, a share of its trials, and its outcome.

use std::collections::BTreeMap;
use std::ops::Range;

use sagnac::device::{Cpu, Device};
use sagnac::run::Plan;
use sagnac::store::Store;
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::use_cases::{Sampled, study_outcome};
use sagnac_base::progress::Progress;
use sagnac_base::quantity::{Dimension, Quantity, parse};
use sagnac_engine::key::Key;
use sagnac_engine::key::sweep::SweepValue;
use sagnac_engine::run::Tables;
use sagnac_kernel::width::Width;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::gpu;
use crate::message::{Refusal, Reply};

/// A study as a page has it.
#[derive(Deserialize)]
struct Source {
    text: String,
    name: String,
    /// The texts of the files that it names.
    #[serde(default)]
    files: BTreeMap<String, String>,
    /// Number of trials instead of its own.
    trials: Option<u64>,
}

/// Asks for the title, question and sweeps of a study, and for the numbers in it that a slider can change.
#[derive(Deserialize)]
pub(crate) struct Inspect {
    #[serde(flatten)]
    source: Source,
}

/// One share of the trials of a study.
#[derive(Deserialize)]
pub(crate) struct Sample {
    #[serde(flatten)]
    source: Source,
    number: u64,
    of: u64,
}

/// The outcome of a study of which all shares are there.
#[derive(Deserialize)]
pub(crate) struct Finish {
    #[serde(flatten)]
    source: Source,
    /// Whether facts that have to be sampled are added.
    complete: bool,
}

impl Inspect {
    pub(crate) fn answer(&self) -> Result<Reply, Refusal> {
        let study = self.source.read()?;
        let keys = study.values.iter().filter_map(|(key, value)| slider(&study, key, *value));
        let keys: Vec<Value> = keys.collect();
        let sweep = |sweep: &sagnac_engine::key::sweep::Sweep| {
            let values: Vec<String> = sweep.values.iter().map(SweepValue::to_string).collect();
            json!({
                "key": sweep.key.name,
                "label": sweep.key.label,
                "values": values,
                "span": in_utf_16(study.text(), &study.place_of(sweep.key.name)),
            })
        };
        Ok(Reply::new(json!({
            "title": study.title,
            "question": study.question,
            "kind": study.kind().name,
            "trials": study.trials,
            "is_sampled": !study.kind().is_exact,
            "keys": keys,
            "sweeps": study.sweeps.iter().map(sweep).collect::<Vec<_>>(),
        })))
    }
}

impl Sample {
    fn share(&self) -> Result<Share, Refusal> {
        let missing = || Refusal::usage(&format!("there is no share {} of {}", self.number, self.of));
        Share::new(self.number, self.of).ok_or_else(missing)
    }

    /// Lists the dispatches that the GPU of the browser has to run.
    pub(crate) fn dispatches(&self, progress: &dyn Progress) -> Result<Reply, Refusal> {
        let study = self.source.read()?;
        gpu::dispatches(&Plan::new(&study)?, self.share()?, progress)
    }

    /// The share, from what the GPU of the browser did.
    pub(crate) fn with_answers(&self, answers: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let study = self.source.read()?;
        gpu::share(&Plan::new(&study)?, self.share()?, answers, progress)
    }

    pub(crate) fn answer(&self, progress: &dyn Progress) -> Result<Reply, Refusal> {
        let study = self.source.read()?;
        let plan = Plan::new(&study)?;
        let share = self.share()?;
        let mut store = Store::in_memory(&plan.identity());
        if plan.is_sampled() {
            let cpu = Cpu::new(Width::widest(), 1).map_err(|error| Refusal::other(&error.to_string()))?;
            plan.run(&mut store, &mut Device::Cpu(cpu), share, progress)?;
        }
        Ok(Reply::new(json!({})).with_file(store.to_bytes()?))
    }
}

impl Finish {
    pub(crate) fn answer(&self, shares: &[&[u8]], progress: &dyn Progress) -> Result<Reply, Refusal> {
        let study = self.source.read()?;
        let plan = Plan::new(&study)?;
        let mut store = Store::in_memory(&plan.identity());
        shares.iter().try_for_each(|share| store.add_bytes(share))?;
        let lacking = if plan.is_sampled() { plan.lacks(&store, Share::WHOLE)? } else { 0 };
        let mut digest = String::new();
        let write = |tables: &Tables| {
            let written = tables.points.write_csv(std::io::sink());
            digest = written.map_err(|error| Refusal::other(&error.to_string()))?;
            Ok::<_, Refusal>(digest.clone())
        };
        let mut results = study_outcome(&plan, &store, &Sampled { run: None, lacking }, write, progress)?;
        if self.complete {
            results.complete(progress)?;
        }
        let reply = Reply::of_outcome(&results.outcome)?;
        Ok(reply.with("digest", digest).with("is_partial", results.is_partial))
    }
}

impl Source {
    fn read(&self) -> Result<Study, Refusal> {
        let files: BTreeMap<String, Vec<u8>> =
            self.files.iter().map(|(name, text)| (name.clone(), text.clone().into_bytes())).collect();
        let mut study = Study::parse_with(&self.name, &self.text, &files)?;
        study.trials = self.trials.unwrap_or(study.trials);
        Ok(study)
    }
}

/// A number of the text with its limits in its own unit; `None` for one that is not written as a number with a unit.
fn slider(study: &Study, key: &Key, value: Quantity) -> Option<Value> {
    let place = study.place_of(key.name);
    let written = study.text().get(place.clone())?;
    let bare = written.trim_matches(['"', '\'']);
    let digits = bare.find(|c: char| !(c.is_ascii_digit() || "+-._eE".contains(c))).unwrap_or(bare.len());
    let number: f64 = bare[..digits].trim().replace('_', "").parse().ok()?;
    let unit = bare[digits..].trim();
    let one = match unit {
        "" => 1.0,
        "%" => 0.01,
        unit => parse(&format!("1 {unit}"), &[value.dimension]).ok()?.value,
    };
    let limits = key.limits().map(|limits| limits.map(|limit| limit / one));
    let end = |at: usize| limits.map(|limits| limits[at]).filter(|limit| limit.is_finite());
    Some(json!({
        "name": key.name,
        "label": key.label,
        "value": bare,
        "number": number,
        "unit": unit,
        "low": end(0),
        "high": end(1),
        "is_whole": value.dimension == Dimension::Count,
        "span": in_utf_16(study.text(), &place),
    }))
}

/// A range of bytes of a text in the units of JavaScript.
fn in_utf_16(text: &str, place: &Range<usize>) -> [usize; 2] {
    [place.start, place.end].map(|end| text.get(..end).map_or(0, |part| part.encode_utf16().count()))
}
