//! One record in a workgroup, with all its angles in the workgroup's memory, beside the kernel's own form.

use sagnac_engine::kinds::allan::verify::{NamedRecords, THINNED, lgk_400, named_records};
use sagnac_kernel::curve::Recorded;
use sagnac_kernel::part;
use sagnac_kernel::recipe::{FOUR_STREAMS, Level, Recipe};
use sagnac_kernel::shader::{Constants, Part, Shader, Variant};
use sagnac_kernel::width::Width;
use serde_json::json;
use wgpu::BufferUsages as Use;

use crate::lab::{Lab, best};
use crate::{Options, emit};

/// Samples of a pass: four for each lane.
const SPAN: u32 = 256;
const LANES: u32 = SPAN / 4;

static GROUPS: Part =
    Part { stem: "record_group", wgsl: include_str!("record_group.wgsl"), constants: || constants() };

fn constants() -> Constants {
    let own = [("SPAN", SPAN), ("LANES", LANES), ("SCAN_STEPS", LANES.ilog2()), ("QUAD", 4)];
    let own = own.map(|(name, value)| (name.to_owned(), value.into()));
    let kernel = [&part::noise, &part::record, &part::curve, &part::allan];
    kernel.into_iter().flat_map(|part| (part.constants)()).chain(own).collect()
}

/// The levels with the starts and lengths of their rings, then the slots; and the place of each slot.
fn tables(recipe: &Recipe) -> (Vec<[u32; 4]>, Vec<usize>) {
    let (mut levels, mut slots, mut places) = (vec![], vec![], vec![]);
    let (mut ring, mut place) = (0, 0);
    for (index, Level { stride, spans }) in recipe.levels.iter().enumerate() {
        let new = SPAN.div_ceil(*stride);
        let depth = recipe.order * spans.iter().max().expect("a level has spans") + new;
        levels.push([*stride, ring, depth, 0]);
        ring += depth;
        for &span in spans {
            for first in (0..new).step_by(4) {
                slots.push([index as u32, first, span, 0]);
                places.push(place);
            }
            place += 1;
        }
    }
    levels.extend(slots);
    (levels, places)
}

fn shader(recipe: &Recipe, tables: &[[u32; 4]], slots: usize, variant: Variant) -> String {
    let octaves = recipe.octaves();
    let items = |octave: u32| (SPAN >> octave) / if (octave as usize) < FOUR_STREAMS { 4 } else { 1 };
    let last_short = SPAN.ilog2();
    let short_items: u32 =
        (1..=last_short).take_while(|&octave| (octave as usize) < octaves).map(items).sum();
    let [_, start, depth, _] = tables[recipe.levels.len() - 1];
    // The declaration of the parameters is that of the kernel's own shader.
    let (whole, _) = recipe.shader(variant);
    let declared = &whole[whole.find("struct Parameters").expect("parameters")..];
    let declared = &declared[..declared.find("}\n").expect("an end") + 2];
    Shader {
        parts: vec![&part::philox, &part::normal, &part::sine, &GROUPS],
        constants: vec![
            ("OCTAVES", octaves),
            ("LEVELS", recipe.levels.len()),
            ("PLACES", recipe.places()),
            ("ORDER", recipe.order as usize),
            ("SLOTS", slots),
            ("ROUNDS_OF_SLOTS", slots.div_ceil(LANES as usize)),
            ("RING_WORDS", (start + depth) as usize),
            ("SHORT_ITEMS", short_items as usize),
            ("LAST_SHORT", last_short as usize),
        ],
        flags: vec![
            ("FLICKER_HOLDS", octaves > 1),
            ("WALK_STEPS", recipe.walk > 0),
            ("MARKOV_STEPS", recipe.markov.is_some()),
            ("SINE_WAVE", recipe.sine.is_some()),
            ("QUANTIZATION_NOISE", recipe.quantization > 0),
            ("PULSE", recipe.pulse.is_some()),
            ("DRIFT", !recipe.drift.is_empty()),
            ("THIRD_ORDER", recipe.order == 3),
        ],
        declarations: declared.to_owned(),
    }
    .text(variant)
}

/// Returns whether all sums were those of the CPU.
pub fn groups(options: &Options) -> bool {
    let lab = Lab::open(options);
    // Short records of every kind to check the sums, and long ones to measure.
    let mut all: Vec<(NamedRecords, u32)> = named_records()
        .into_iter()
        .filter(|named| named.switching.is_none())
        .map(|named| (named, if options.tiny { 3 } else { 64 }))
        .collect();
    if !options.tiny {
        let long = |count| {
            let (name, parts) = ("lgk-400, m/64", lgk_400());
            (
                NamedRecords {
                    name,
                    parts,
                    samples: 32_400,
                    estimator: THINNED,
                    readout_lsb: 0.0,
                    switching: None,
                },
                count,
            )
        };
        all.extend([1024, 4096, 16_384].map(long));
    }
    all.iter()
        .map(|(named, count)| one(&lab, named, *count, options.seconds))
        .fold(true, |all, same| all & same)
}

/// Makes `count` records; returns whether the sums of the last one are those of the CPU.
fn one(lab: &Lab, named: &NamedRecords, count: u32, seconds: f64) -> bool {
    let lowered = named.lowered();
    let recipe = lowered.recipe();
    let (tables, places) = tables(recipe);
    let slots = places.len();
    let variant = Variant { int64: lab.int64, checked: false, workgroup: LANES };
    let pipeline = lab.pipeline(&shader(recipe, &tables, slots, variant), variant.checked);
    let [words, tables, sums, drift] = [
        lab.upload(&recipe.parameters(0, count, [0, 0]), Use::UNIFORM),
        lab.upload(tables.as_flattened(), Use::STORAGE),
        lab.buffer(12 * slots as u64 * u64::from(count), Use::STORAGE | Use::COPY_SRC),
        lab.upload(&recipe.drift, Use::STORAGE),
    ];
    let drift = (!recipe.drift.is_empty()).then_some((5, &drift));
    let bound = [(0, &lab.normals), (1, &words), (2, &tables), (3, &sums)];
    let group = lab.group(&pipeline, bound.into_iter().chain(drift));
    let seconds = best(seconds, || lab.dispatch(&pipeline, &group, [count, 1]));
    let found = lab.read(&sums);
    let mut of_places = vec![0_u128; recipe.places()];
    let last = found[..3 * slots * count as usize].chunks_exact(3).skip(slots * (count as usize - 1));
    for (words, &place) in last.zip(&places) {
        of_places[place] += (0..3).map(|k| u128::from(words[k]) << (32 * k)).sum::<u128>();
    }
    let same = of_places == recipe.sums(Width::widest(), u64::from(count) - 1, 1);
    let (samples, name) = (recipe.samples, named.name);
    let rate = f64::from(count) * f64::from(samples) / seconds;
    eprintln!(
        "{name:24} {samples:7} samples, {count:6} records, a workgroup each: {:10.2} ms, {:9.4} G samples/s, same: {same}",
        seconds * 1e3,
        rate / 1e9
    );
    emit(&json!({ "part": "groups", "what": name, "samples": samples, "records": count,
        "seconds": seconds, "samples_per_second": rate, "same": same }));
    same
}
