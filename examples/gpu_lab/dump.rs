//! Part `dump`: the shaders of trials as text, with what they are given and the sums of the CPU, for other compilers
//! and profilers.

use sagnac_kernel::moments::{BINS, PARTIAL_WORDS};
use sagnac_kernel::normal_table::NORMAL_TABLE;
use sagnac_kernel::shader::Variant;
use serde_json::{Value, json};

use crate::edits::{ONE_PRODUCT, PLAIN, UNIFORM};
use crate::kernel::reference;
use crate::{Bench, Options, benches};

/// Trials whose sums are given.
const TRIALS: u64 = 1 << 20;

pub fn dump(options: &Options) {
    let folder = std::path::Path::new(&options.out);
    std::fs::create_dir_all(folder).expect("a folder");
    let write = |name: String, bytes: &[u8]| std::fs::write(folder.join(name), bytes).expect("written");
    write("normals.bin".to_owned(), bytemuck::cast_slice(&NORMAL_TABLE));
    for (at, bench) in benches().iter().enumerate() {
        let Bench { name, launch, histogram } = bench;
        let name = format!("{at}-{}{}", name.replace(' ', "-"), if *histogram { "-histogram" } else { "" });
        for (int64, products) in [(true, "u64"), (false, "split")] {
            for workgroup in [64, 256] {
                let (text, _) = launch.shader(*histogram, Variant { int64, checked: false, workgroup });
                for (short, edit) in [("", &PLAIN), ("-one", &ONE_PRODUCT), ("-uniform", &UNIFORM)] {
                    if let Some(text) = (edit.apply)(&text, int64) {
                        write(format!("{name}-{products}-{workgroup}{short}.wgsl"), text.as_bytes());
                    }
                }
            }
        }
        let mut words = launch.words().to_vec();
        words.resize(words.len().next_multiple_of(4), 0);
        write(format!("{name}.words"), bytemuck::cast_slice(&words));
        write(format!("{name}.table"), bytemuck::cast_slice(launch.table()));
        let trials = if options.tiny { 4096 } else { TRIALS };
        let tallies: Vec<Value> = reference(bench, trials)
            .iter()
            .map(|tally| {
                json!({ "sum": tally.sum.to_string(), "square": tally.square.to_string(),
                "least": tally.least, "greatest": tally.greatest, "bins": tally.bins })
            })
            .collect();
        let about = json!({ "estimates": launch.sampled().estimates(), "histogram": histogram, "bins": BINS,
            "trials": trials, "partial_words": PARTIAL_WORDS, "steps": launch.steps(), "tallies": tallies });
        write(format!("{name}.json"), about.to_string().as_bytes());
    }
}
