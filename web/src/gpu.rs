//! Shares of studies and the comparison of kernels on the GPU of a browser. A page cannot wait for its GPU, so the work is done twice:
//! the first time its dispatches are noted, the second time their answers are there.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use sagnac::device::Device;
use sagnac::run::Plan;
use sagnac::store::{Provenance, Store};
use sagnac::tally::Share;
use sagnac_base::progress::Progress;
use sagnac_engine::device::remote::{Dispatch, Remote, Runner};
use sagnac_engine::run::{Budget, Worker};
use sagnac_kernel::normal_table::NORMAL_TABLE;
use serde_json::{Value, json};

use crate::message::{Refusal, Reply};

/// Work of a batch, in trials' steps and in records.
const BATCH: Budget = Budget { steps: 1 << 26, records: 1024 };

/// Most words of the dispatches of such work, which are in memory together.
const MAX_WORDS: usize = 1 << 26;

/// Notes dispatches, of which nothing is known yet.
#[derive(Clone, Default)]
struct Recorder(Arc<Mutex<Noted>>);

#[derive(Default)]
struct Noted {
    dispatches: Vec<Dispatch>,
    /// Words of all of them, also of those that were too many to be kept.
    words: usize,
}

impl Runner for Recorder {
    fn name(&self) -> String {
        "WebGPU".to_owned()
    }

    fn run(&mut self, dispatch: Dispatch) -> Result<Option<Vec<u32>>, String> {
        let mut noted = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let inputs = dispatch.inputs.iter().map(|(_, words)| words.len());
        noted.words += inputs.sum::<usize>() + dispatch.words() + dispatch.shader.len() / 4;
        if noted.words <= MAX_WORDS {
            noted.dispatches.push(dispatch);
        }
        Ok(None)
    }
}

/// Gives the answers of the GPU in their order.
struct Player(VecDeque<Vec<u32>>);

impl Runner for Player {
    fn name(&self) -> String {
        "WebGPU".to_owned()
    }

    fn run(&mut self, _dispatch: Dispatch) -> Result<Option<Vec<u32>>, String> {
        self.0.pop_front().map(Some).ok_or_else(|| "there is no answer to it".to_owned())
    }
}

/// Runs a share in batches that do not depend on time, and stores the results if they are known.
fn run(
    plan: &Plan,
    share: Share,
    mut device: Device,
    is_known: bool,
    progress: &dyn Progress,
) -> Result<(Store, Vec<String>), Refusal> {
    if plan.study().precision.is_some() {
        return Err(Refusal::usage("a study that stops at a precision does not run on a GPU of a browser"));
    }
    let mut store = Store::in_memory(&plan.identity());
    let mut worker = Worker::new(&mut device, progress);
    let mut steps = plan.steps(&store, share)?;
    let mut trials = 0;
    let refused = |why: &dyn std::fmt::Display| Refusal::other(&why.to_string());
    while let Some(batch) = steps.next(BATCH).map_err(|why| refused(&why))? {
        let results = batch.make(&mut worker, &|_| ()).map_err(|why| refused(&why))?;
        trials += batch.trials();
        if is_known {
            let made = Provenance { device: "WebGPU".to_owned(), trials, seconds: 0.0 };
            batch.put(results, &mut store, &made)?;
        }
    }
    drop(steps);
    if is_known {
        plan.keep(&mut store, share)?;
    }
    Ok((store, worker.into_notes()))
}

/// The dispatches of a share, as [`noted`].
pub(crate) fn dispatches(plan: &Plan, share: Share, progress: &dyn Progress) -> Result<Reply, Refusal> {
    noted(|device| run(plan, share, device, false, progress))
}

/// The dispatches of some work on a device, as the page takes them: texts of shaders, each once, and words as files.
pub(crate) fn noted<R>(work: impl FnOnce(Device) -> Result<R, Refusal>) -> Result<Reply, Refusal> {
    let recorder = Recorder::default();
    work(Device::Remote(Remote::new(Box::new(recorder.clone()))))?;
    let noted = std::mem::take(&mut *recorder.0.lock().unwrap_or_else(PoisonError::into_inner));
    if noted.words > MAX_WORDS {
        return Err(Refusal::usage("the work for the GPU would take more memory than a page has"));
    }
    let mut shaders: Vec<String> = vec![];
    let mut files: Vec<Vec<u8>> = vec![bytes(NORMAL_TABLE.as_flattened())];
    let mut file = |words: &[u32]| -> usize {
        files.push(bytes(words));
        files.len() - 1
    };
    let all: Vec<Value> = noted
        .dispatches
        .iter()
        .map(|dispatch| {
            let shader = shaders.iter().position(|text| *text == dispatch.shader).unwrap_or_else(|| {
                shaders.push(dispatch.shader.clone());
                shaders.len() - 1
            });
            let inputs: Vec<Value> =
                dispatch.inputs.iter().map(|(binding, words)| json!([binding, file(words)])).collect();
            let passes: Vec<Value> = dispatch
                .passes
                .iter()
                .map(|pass| {
                    let uniform = (!pass.uniform.is_empty()).then(|| file(&pass.uniform));
                    json!({ "uniform": uniform, "grid": pass.grid })
                })
                .collect();
            json!({
                "shader": shader,
                "hasNormals": dispatch.has_normals,
                "inputs": inputs,
                "scratch": dispatch.scratch,
                "outputs": dispatch.outputs,
                "passes": passes,
            })
        })
        .collect();
    let reply = Reply::new(json!({ "shaders": shaders, "dispatches": all }));
    Ok(files.into_iter().fold(reply, Reply::with_file))
}

/// The rows of a share from the answers to its dispatches.
pub(crate) fn share(
    plan: &Plan,
    share: Share,
    answers: &[&[u8]],
    progress: &dyn Progress,
) -> Result<Reply, Refusal> {
    let (store, notes) = run(plan, share, answering(answers), true, progress)?;
    Ok(Reply::new(json!({ "notes": notes })).with_file(store.to_bytes()?))
}

/// A device that gives the answers to noted dispatches.
pub(crate) fn answering(answers: &[&[u8]]) -> Device {
    let word = |bytes: &[u8]| bytes.try_into().map_or(0, u32::from_le_bytes);
    let words = |answer: &&[u8]| answer.chunks_exact(4).map(word).collect();
    Device::Remote(Remote::new(Box::new(Player(answers.iter().map(words).collect()))))
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
