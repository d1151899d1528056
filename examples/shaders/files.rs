//! The shaders of all kernels as files, with a description that lets any host of WebGPU check its own stack: the buffers
//! of each shader, its dispatches, and the words that its results must consist of.

use std::collections::BTreeMap;

use sagnac::device::Work;
use sagnac::verify::{items, loads};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::{Launch, MAX_STEPS};
use sagnac_kernel::map::Map;
use sagnac_kernel::moments::{GROUPS_PER_ROW, Moments, PARTIAL_WORDS, Trials};
use sagnac_kernel::normal_table::NORMAL_TABLE;
use sagnac_kernel::record::SUM_WORDS;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;
use sagnac_kernel::{Form, KERNELS};
use serde_json::{Value, json};

/// Invocations of a workgroup.
const WORKGROUP: u32 = 64;

/// Items of a building block: several workgroups, the last of them not full.
const ITEMS: u32 = 1000;

/// Number of the first trial or record: both of its words count.
const FIRST: u64 = 3 << 32;

/// Least and most trials of a load.
const TRIALS: (u64, u64) = (300, 5000);

/// Workgroups among which the trials are divided.
const GROUPS: u64 = 8;

/// Records of a load: two workgroups, the second not full.
const RECORDS: usize = 70;

/// Dispatches of a load of records at least: their state is kept from one to the next.
const DISPATCHES: u32 = 3;

/// The contents of a buffer.
#[derive(Clone)]
enum Contents {
    /// So many zeros.
    Zeros(usize),
    /// Words before the first dispatch.
    Input(Vec<u32>),
    /// Zeros before the first dispatch and these words after the last one.
    Result(Vec<u32>),
}

/// The contents of buffers by their names in the shader, and the dispatches.
type Run = (Vec<(&'static str, Contents)>, Vec<Value>);

/// All files by their names: each shader with 32-bit integers alone and with 64-bit ones, their description and the page.
pub fn files() -> Vec<(String, String)> {
    let (mut shaders, mut texts, mut files) = (vec![], BTreeMap::new(), vec![]);
    let mut count = BTreeMap::new();
    let mut add = |name: String, text: &dyn Fn(Variant) -> String, (contents, dispatches): Run| {
        // Several launches of a load have one name.
        let same = count.entry(name.clone()).or_insert(0);
        *same += 1;
        let name = if *same == 1 { name } else { format!("{name}.{same}") };
        let of = |int64| text(Variant { int64, checked: true, workgroup: WORKGROUP });
        let (narrow, wide) = (format!("{name}.u32.wgsl"), format!("{name}.u64.wgsl"));
        shaders.push(json!({
            "name": name, "wgsl": { "u32": narrow, "u64": wide }, "workgroup_size": WORKGROUP,
            "buffers": buffers(&of(false), &contents), "dispatches": dispatches,
        }));
        texts.insert(narrow.clone(), of(false));
        files.extend([(narrow, of(false)), (wide, of(true))]);
    };
    for kernel in KERNELS {
        if let Form::Map(map) = kernel.form {
            add(kernel.name.to_owned(), &|variant| map.shader(variant).0, of_map(&map));
        }
        for load in loads(kernel) {
            let name = format!("{}-{}", kernel.name, load.name.replace(' ', "-"));
            match &load.work {
                Work::Trials(launch) => {
                    add(name, &|variant| launch.shader(true, variant).0, of_trials(launch));
                }
                Work::Records(recipe) => {
                    add(name, &|variant| recipe.shader(variant).0, of_records(&**recipe));
                }
            }
        }
    }
    let mut description = json!({ "sagnac": env!("CARGO_PKG_VERSION"), "shaders": shaders });
    files.push(("shaders.json".to_owned(), description.to_string()));
    description["texts"] = json!(texts);
    // Nothing in the data may end the element that contains it.
    let data = description.to_string().replace("</", "<\\/");
    files.push(("check.html".to_owned(), include_str!("check.html").replace("DESCRIPTION", &data)));
    files
}

/// The buffers that a shader declares, with their contents.
fn buffers(text: &str, contents: &[(&str, Contents)]) -> Vec<Value> {
    let declared = text.lines().filter_map(|line| {
        let (binding, rest) = line.strip_prefix("@group(0) @binding(")?.split_once(") var<")?;
        let (access, rest) = rest.split_once("> ")?;
        Some((binding.parse::<u32>().ok()?, access, rest.split_once(':')?.0))
    });
    let buffer = |(binding, access, name): (u32, &str, &str)| {
        let kind = match access {
            "uniform" => "uniform",
            "storage, read" => "read-only-storage",
            _ => "storage",
        };
        let contents = match name {
            "normal_table" => Contents::Input(NORMAL_TABLE.as_flattened().to_vec()),
            _ => contents.iter().find(|(own, _)| *own == name).expect("contents of every buffer").1.clone(),
        };
        let mut buffer = json!({ "binding": binding, "name": name, "type": kind });
        let (length, key, words) = match contents {
            Contents::Zeros(length) => (length, None, vec![]),
            Contents::Input(words) => (words.len(), Some("words"), words),
            Contents::Result(words) => (words.len(), Some("expected"), words),
        };
        buffer["length"] = length.into();
        key.into_iter().for_each(|key| buffer[key] = json!(words));
        buffer
    };
    declared.map(buffer).collect()
}

/// A dispatch before which buffers receive words, by their names.
fn dispatch([columns, rows]: [u32; 2], writes: Value) -> Value {
    json!({ "workgroups": [columns, rows, 1], "writes": writes })
}

fn of_map(map: &Map) -> Run {
    let items = items(map, 0..ITEMS.into());
    let results = (map.cpu)(Width::PORTABLE, &items);
    let contents = vec![("items", Contents::Input(items)), ("results", Contents::Result(results))];
    (contents, vec![dispatch([ITEMS.div_ceil(WORKGROUP), 1], json!({}))])
}

fn of_trials(launch: &Launch) -> Run {
    let trials = (MAX_STEPS / launch.steps()).clamp(TRIALS.0, TRIALS.1);
    let of_group = trials.div_ceil(GROUPS).next_multiple_of(WORKGROUP.into());
    let mut total = vec![Moments::empty(true); launch.sampled().estimates()];
    let (mut jobs, mut partials) = (vec![], vec![]);
    for start in (0..trials).step_by(of_group as usize) {
        let (first, count) = (FIRST + start, of_group.min(trials - start));
        // The words of a job: low, high, count, point, slot.
        jobs.extend([first as u32, (first >> 32) as u32, count as u32, 0, 0]);
        let tallies = launch.tally(Width::PORTABLE, Trials { first, count, histogram: true });
        partials.extend(tallies.iter().flat_map(partial));
        total.iter_mut().zip(&tallies).for_each(|(total, tally)| total.merge(tally));
    }
    let bins = total.iter().flat_map(|tally| &tally.bins);
    let groups = jobs.len() as u32 / 5;
    let contents = vec![
        ("parameters", Contents::Input(launch.parameters(0))),
        ("jobs", Contents::Input(jobs)),
        ("partials", Contents::Result(partials)),
        ("histograms", Contents::Result(bins.map(|&bin| bin as u32).collect())),
        ("table", Contents::Input(launch.table().to_vec())),
    ];
    (contents, vec![dispatch([groups.min(GROUPS_PER_ROW), groups.div_ceil(GROUPS_PER_ROW)], json!({}))])
}

/// The words that a workgroup returns for a tally.
fn partial(tally: &Moments) -> [u32; PARTIAL_WORDS] {
    let [a, b] = [tally.sum as u128, tally.square].map(|sum| [0, 32, 64].map(|place| (sum >> place) as u32));
    [a[0], a[1], a[2], b[0], b[1], b[2], tally.least as u32, tally.greatest as u32]
}

fn of_records(recipe: &dyn Recorded) -> Run {
    let places = recipe.values();
    let sums = recipe.sums(Width::PORTABLE, FIRST, RECORDS);
    let mut expected = vec![0; SUM_WORDS * places * RECORDS];
    for (at, sum) in sums.iter().enumerate() {
        let (lane, place) = (at / places, at % places);
        for word in 0..SUM_WORDS {
            expected[(SUM_WORDS * place + word) * RECORDS + lane] = (sum >> (32 * word)) as u32;
        }
    }
    let chunks = recipe.curve().chunks();
    let most = (MAX_STEPS as u32 / recipe.rounds() as u32).min(chunks / DISPATCHES).max(1);
    let parameters = |from: u32| recipe.parameters(FIRST, RECORDS as u32, [from, chunks.min(from + most)]);
    let groups = (RECORDS as u32).div_ceil(WORKGROUP);
    let contents = vec![
        ("p", Contents::Zeros(parameters(0).len())),
        ("rings", Contents::Zeros(recipe.curve().ring_words(RECORDS))),
        ("sums", Contents::Result(expected)),
        ("state", Contents::Zeros(recipe.state_words() * RECORDS)),
        ("table", Contents::Input(recipe.table().to_vec())),
    ];
    let step = |from| dispatch([groups, 1], json!({ "p": parameters(from) }));
    (contents, (0..chunks).step_by(most as usize).map(step).collect())
}
