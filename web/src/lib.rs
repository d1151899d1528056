//! The use cases for a page in a browser, which runs them in workers that share nothing.
//!
//! ```text
//! JSON and files ─ message ─▶ call ─┬─ study: inspect, share, outcome ─┬─▶ JSON and files
//!                                   ├─ log: read, allan, model, … ─────┤
//!                                   └─ convert, verify, about ─────────┘
//! ```

mod gpu;
mod log;
mod message;
mod simulation;
mod study;

#[cfg(target_family = "wasm")]
mod exports;

use std::sync::atomic::{AtomicU64, Ordering};

use sagnac::device::Device;
use sagnac_base::progress::Progress;
use sagnac_engine::verify;
use sagnac_kernel::width::Width;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::message::{Message, Refusal, Reply};

/// A request of the page, which `call` names.
#[derive(Deserialize)]
#[serde(tag = "call", rename_all = "snake_case")]
enum Request {
    About,
    Inspect(study::Inspect),
    Share(study::Sample),
    GpuDispatches(study::Sample),
    GpuShare(study::Sample),
    Outcome(study::Finish),
    Read(log::OneLog),
    Allan(log::OneLog),
    Simulate(log::Simulate),
    Model(log::OneLog),
    Navigate(log::OneLog),
    StudyOfLog(log::OneLog),
    Compare(log::TwoLogs),
    Convert { text: String },
    Verify { units: u64 },
    GpuVerifyDispatches { units: u64 },
    GpuVerify { units: u64 },
}

/// Answers a message. `report` receives the units of work that are done, and their total.
pub fn call(message: &[u8], report: &(dyn Fn(u64, u64) + Sync)) -> Vec<u8> {
    let answered = Message::decode(message).and_then(|message| answer(message, &Watch::new(report)));
    answered.unwrap_or_else(Refusal::into_reply).encode()
}

fn answer(Message { json, files }: Message, progress: &Watch) -> Result<Reply, Refusal> {
    let request = serde_json::from_value(json).map_err(|error| Refusal::usage(&error.to_string()))?;
    match request {
        Request::About => {
            Ok(Reply::new(json!({ "version": env!("CARGO_PKG_VERSION"), "lanes": Width::widest().name() })))
        }
        Request::Inspect(asked) => asked.answer(),
        Request::Share(asked) => asked.answer(progress),
        Request::GpuDispatches(asked) => asked.dispatches(progress),
        Request::GpuShare(asked) => asked.with_answers(&files, progress),
        Request::Outcome(asked) => asked.answer(&files, progress),
        Request::Read(asked) => asked.columns(&files),
        Request::Allan(asked) => asked.allan(&files, progress),
        Request::Simulate(asked) => asked.answer(&files, progress),
        Request::Model(asked) => asked.model(&files, progress),
        Request::Navigate(asked) => asked.navigate(&files, progress),
        Request::StudyOfLog(asked) => asked.study(&files, progress),
        Request::Compare(asked) => asked.compare(&files),
        Request::Convert { text } => {
            let found =
                sagnac::use_cases::convert(&text).map_err(|error| Refusal::usage(&error.to_string()))?;
            Ok(Reply::new(json!(found)))
        }
        Request::Verify { units } => verified(&mut [], units),
        Request::GpuVerifyDispatches { units } => gpu::noted(|device| verified(&mut [device], units)),
        Request::GpuVerify { units } => verified(&mut [gpu::answering(&files)], units),
    }
}

/// The digests of all kernels, with whether all widths of this processor and some devices agree.
fn verified(devices: &mut [Device], units: u64) -> Result<Reply, Refusal> {
    let mut verdicts = vec![];
    verify::verify(devices, units, |verdict| verdicts.push(verdict.clone()))
        .map_err(|error| Refusal::other(&error.to_string()))?;
    let row = |verdict: &verify::Verdict| -> Value {
        let digest = format!("{:016x}", verdict.digest);
        json!({ "kernel": verdict.kernel, "digest": digest, "identical": verdict.differences.is_empty() })
    };
    let rows: Vec<Value> = verdicts.iter().map(row).collect();
    Ok(Reply::new(json!({ "digest": format!("{:016x}", verify::digest(&verdicts)), "rows": rows })))
}

/// Passes progress on to a page.
struct Watch<'a> {
    report: &'a (dyn Fn(u64, u64) + Sync),
    done: AtomicU64,
    total: AtomicU64,
}

impl Watch<'_> {
    fn new(report: &(dyn Fn(u64, u64) + Sync)) -> Watch<'_> {
        Watch { report, done: AtomicU64::new(0), total: AtomicU64::new(0) }
    }
}

impl Progress for Watch<'_> {
    fn start(&self, _unit: &'static str, done: u64, total: u64) {
        self.done.store(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
        (self.report)(done, total);
    }

    fn advance(&self, more: u64) {
        let done = self.done.fetch_add(more, Ordering::Relaxed) + more;
        (self.report)(done, self.total.load(Ordering::Relaxed));
    }
}
