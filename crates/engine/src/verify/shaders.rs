//! The shaders of all kernels as files, with a description that lets any host of WebGPU check its own stack: the buffers
//! of each shader, its dispatches, and the words that its results must consist of.
//!
//! The page `check.html` is such a host: it needs no server and no network.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::device::gpu::adapter::WORKGROUP;
use crate::device::gpu::tile::{Part, grid, partial};
use crate::device::load::Work;
use crate::verify::{items, loads};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::launch::{Launch, MOST_STEPS};
use sagnac_kernel::map::Map;
use sagnac_kernel::moments::Moments;
use sagnac_kernel::normal_table::NORMAL_TABLE;
use sagnac_kernel::record::SUM_WORDS;
use sagnac_kernel::shader::Variant;
use sagnac_kernel::width::Width;
use sagnac_kernel::{Form, KERNELS};

/// The file that describes all shaders.
pub const DESCRIPTION: &str = "shaders.json";

/// The page that runs all shaders without 64-bit integers, and compares their results.
pub const PAGE: &str = "check.html";

/// Items of a building block: several workgroups, the last of them not full.
const ITEMS: u64 = 1000;

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

#[derive(Serialize)]
struct Description<'a> {
    sagnac: &'static str,
    shaders: &'a [Shader],
    /// Texts of the files that the page runs.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    texts: BTreeMap<&'a str, &'a str>,
}

/// A shader with a load. Its entry point is `main`, and its buffers are in group 0.
#[derive(Serialize)]
struct Shader {
    name: String,
    wgsl: Files,
    workgroup_size: u32,
    buffers: Vec<Buffer>,
    /// In this order, each after the one before it is complete.
    dispatches: Vec<Dispatch>,
}

/// The variants of a shader: with 32-bit integers alone, and with 64-bit integers, which WebGPU lacks and naga has.
#[derive(Serialize)]
struct Files {
    u32: String,
    u64: String,
}

#[derive(Serialize)]
struct Buffer {
    binding: u32,
    name: String,
    /// The type of the binding, in the words of WebGPU.
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(flatten)]
    contents: Contents,
}

#[derive(Clone, Default, Serialize)]
struct Contents {
    /// Number of words.
    length: usize,
    /// Words before the first dispatch; without them all are zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    words: Option<Vec<u32>>,
    /// Words after the last dispatch.
    #[serde(skip_serializing_if = "Option::is_none")]
    expected: Option<Vec<u32>>,
}

impl Contents {
    fn zeros(length: usize) -> Contents {
        Contents { length, ..Contents::default() }
    }

    fn input(words: &[u32]) -> Contents {
        Contents { words: Some(words.to_vec()), ..Contents::zeros(words.len()) }
    }

    fn result(expected: Vec<u32>) -> Contents {
        Contents { length: expected.len(), expected: Some(expected), words: None }
    }
}

#[derive(Serialize)]
struct Dispatch {
    workgroups: [u32; 3],
    /// Words that a buffer receives before this dispatch, by its name.
    writes: BTreeMap<&'static str, Vec<u32>>,
}

impl Dispatch {
    fn of([columns, rows]: [u32; 2]) -> Dispatch {
        Dispatch { workgroups: [columns, rows, 1], writes: BTreeMap::new() }
    }
}

/// The contents of buffers by their names in the shader, and the dispatches.
type Run = (Vec<(&'static str, Contents)>, Vec<Dispatch>);

/// All files, by their names: each shader in two variants, the [description](DESCRIPTION) and the [page](PAGE).
pub fn files() -> Vec<(String, String)> {
    let (mut shaders, mut files) = (Vec::<Shader>::new(), Vec::new());
    let mut add = |name: String, text: &dyn Fn(Variant) -> String, run: Run| {
        // Several launches of a load have one name.
        let same =
            shaders.iter().filter(|shader| shader.name.split('.').next() == Some(name.as_str())).count();
        let name = if same == 0 { name } else { format!("{name}.{}", same + 1) };
        let of = |int64| text(Variant { int64, checked: true, workgroup: WORKGROUP });
        let wgsl = Files { u32: format!("{name}.u32.wgsl"), u64: format!("{name}.u64.wgsl") };
        files.extend([(wgsl.u32.clone(), of(false)), (wgsl.u64.clone(), of(true))]);
        let (contents, dispatches) = run;
        let buffers = buffers(&of(false), &contents);
        shaders.push(Shader { name, wgsl, workgroup_size: WORKGROUP, buffers, dispatches });
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
                    add(name, &|variant| recipe.shader(variant).0, of_records(&**recipe))
                }
            }
        }
    }
    let sagnac = env!("CARGO_PKG_VERSION");
    let described = json(&Description { sagnac, shaders: &shaders, texts: BTreeMap::new() });
    let text = |name: &str| files.iter().find(|(file, _)| file == name).map(|(_, text)| text.as_str());
    let texts =
        shaders.iter().filter_map(|shader| Some((&*shader.wgsl.u32, text(&shader.wgsl.u32)?))).collect();
    // Nothing in the data may end the element that contains it.
    let data = json(&Description { sagnac, shaders: &shaders, texts }).replace("</", "<\\/");
    let page = include_str!("../../../../assets/shaders/check.html").replace("DESCRIPTION", &data);
    files.extend([(DESCRIPTION.to_owned(), described), (PAGE.to_owned(), page)]);
    files
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("words and names are JSON")
}

/// The buffers that a shader declares, with their contents.
fn buffers(text: &str, contents: &[(&str, Contents)]) -> Vec<Buffer> {
    let declared = text.lines().filter_map(|line| {
        let (binding, rest) = line.strip_prefix("@group(0) @binding(")?.split_once(") var<")?;
        let (access, rest) = rest.split_once("> ")?;
        Some((binding.parse().ok()?, access, rest.split_once(':')?.0))
    });
    let buffer = |(binding, access, name): (u32, &str, &str)| {
        let kind = match access {
            "uniform" => "uniform",
            "storage, read" => "read-only-storage",
            _ => "storage",
        };
        let contents = match name {
            "normal_table" => Contents::input(bytemuck::cast_slice(&NORMAL_TABLE)),
            _ => contents.iter().find(|(own, _)| *own == name).expect("contents of every buffer").1.clone(),
        };
        Buffer { binding, name: name.to_owned(), kind, contents }
    };
    declared.map(buffer).collect()
}

fn of_map(map: &Map) -> Run {
    let items = items(map, 0..ITEMS);
    let contents = vec![
        ("items", Contents::input(&items)),
        ("results", Contents::result((map.cpu)(Width::PORTABLE, &items))),
    ];
    (contents, vec![Dispatch::of([(ITEMS as u32).div_ceil(WORKGROUP), 1])])
}

fn of_trials(launch: &Launch) -> Run {
    let trials = (MOST_STEPS / launch.steps()).clamp(TRIALS.0, TRIALS.1);
    let mut part = Part::default();
    part.push(launch, FIRST..FIRST + trials, 0);
    let jobs = part.jobs(part.trials_of_group(WORKGROUP, GROUPS));
    let mut total = vec![Moments::empty(true); launch.sampled().estimates()];
    let mut partials = Vec::new();
    for job in &jobs {
        let tallies = launch.tally(Width::PORTABLE, job.trials(true));
        partials.extend(tallies.iter().flat_map(partial));
        total.iter_mut().zip(&tallies).for_each(|(total, tally)| total.merge(tally));
    }
    let bins = total.iter().flat_map(|tally| &tally.bins);
    let contents = vec![
        ("parameters", Contents::input(&part.parameters())),
        ("jobs", Contents::input(bytemuck::cast_slice(&jobs))),
        ("partials", Contents::result(partials)),
        ("histograms", Contents::result(bins.map(|&bin| bin as u32).collect())),
        ("table", Contents::input(launch.table())),
    ];
    (contents, vec![Dispatch::of(grid(jobs.len() as u32))])
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
    let most = (MOST_STEPS as u32 / recipe.rounds() as u32).min(chunks / DISPATCHES).max(1);
    let parameters = |from: u32| recipe.parameters(FIRST, RECORDS as u32, [from, chunks.min(from + most)]);
    let dispatch = |from| Dispatch {
        writes: BTreeMap::from([("p", parameters(from))]),
        ..Dispatch::of([(RECORDS as u32).div_ceil(WORKGROUP), 1])
    };
    let contents = vec![
        ("p", Contents::zeros(parameters(0).len())),
        ("rings", Contents::zeros(recipe.curve().ring_words(RECORDS))),
        ("sums", Contents::result(expected)),
        ("state", Contents::zeros(recipe.state_words() * RECORDS)),
        ("table", Contents::input(recipe.table())),
    ];
    (contents, (0..chunks).step_by(most as usize).map(dispatch).collect())
}
