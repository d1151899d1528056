//! Part `limit`: how many integer operations per second the device does in chains that wait for nothing.

use std::fmt::Write as _;

use serde_json::json;
use wgpu::BufferUsages as Use;

use crate::lab::{Lab, best};
use crate::{Options, emit};

/// Independent chains of an invocation, and the steps of each chain in a round of the loop.
const CHAINS: u64 = 8;
const STEPS: u64 = 8;

/// Rounds of an invocation: some milliseconds on a large GPU, half a second on a small one.
const ROUNDS: u64 = 1024;

/// A multiplication, an addition and two logic operations.
const OPERATIONS: u64 = 4;

const WORKGROUP: u32 = 64;

/// What the chains multiply by, add and combine with, which the compiler must not know.
const FACTORS: [u32; 4] = [0x9E37_79B1, 0x7F4A_7C15, 0x1656_67B1, 0xFFFF_FFFB];

pub fn limit(options: &Options) {
    let lab = Lab::open(options);
    let groups: u32 = if options.tiny { 16 } else { 16_384 };
    let pipeline = lab.pipeline(&shader(), false);
    let factors = lab.upload(&FACTORS, Use::STORAGE);
    let results = lab.buffer(4 * u64::from(groups * WORKGROUP), Use::STORAGE);
    let group = lab.group(&pipeline, [(1, &factors), (2, &results)]);
    let seconds = best(options.seconds, || lab.dispatch(&pipeline, &group, [groups, 1]));
    let operations = u64::from(groups * WORKGROUP) * ROUNDS * STEPS * CHAINS * OPERATIONS;
    let rate = operations as f64 / seconds;
    eprintln!("integer limit: {:.0} billion operations/s", rate / 1e9);
    emit(&json!({ "part": "limit", "operations_per_second": rate, "stamps": lab.has_stamps }));
}

fn shader() -> String {
    let mut text = format!(
        "@group(0) @binding(1) var<storage, read> f: array<u32, 4>;
        @group(0) @binding(2) var<storage, read_write> results: array<u32>;
        @compute @workgroup_size({WORKGROUP})
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
            let a = f[0]; let b = f[1]; let c = f[2]; let d = f[3];\n"
    );
    for chain in 0..CHAINS {
        let _ = writeln!(text, "var x{chain} = id.x + {chain}u * a;");
    }
    let _ = writeln!(text, "for (var round = 0u; round < {ROUNDS}u; round++) {{");
    for chain in (0..STEPS).flat_map(|_| 0..CHAINS) {
        let _ = writeln!(text, "x{chain} = ((x{chain} * a + b) ^ c) & d;");
    }
    let all: Vec<String> = (0..CHAINS).map(|chain| format!("x{chain}")).collect();
    let _ = writeln!(text, "}}\nresults[id.x] = {};\n}}", all.join(" ^ "));
    text
}
