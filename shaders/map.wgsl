// The building blocks on their own, each a function of a few words, evaluated over a list of items.
// Twin of crates/kernel/src/map.rs, which generates the function `evaluate`.

@group(0) @binding(1) var<storage, read> items: array<u32>;
@group(0) @binding(2) var<storage, read_write> results: array<u32>;

// Only here: `run` of Rust.
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let item = id.x;
    if item >= arrayLength(&items) / INPUTS {
        return;
    }
    var x: array<u32, INPUTS>;
    for (var i = 0u; i < INPUTS; i++) {
        x[i] = items[item * INPUTS + i];
    }
    var y = evaluate(x);
    for (var i = 0u; i < OUTPUTS; i++) {
        results[item * OUTPUTS + i] = y[i];
    }
}
