// What all kernels of records share: the exact sums of a record, one at each place, which carry over from chunk to chunk.
// Twin of crates/kernel/src/record.rs.
//
// An invocation makes one record, some chunks at a time; `sums` and `state` keep its data between dispatches, word by word
// for all lanes.

@group(0) @binding(1) var<uniform> p: Parameters;
@group(0) @binding(3) var<storage, read_write> sums: array<u32>;
@group(0) @binding(4) var<storage, read_write> state: array<u32>;

var<private> address: Address;
var<private> angles: array<u32, CHUNK>;
var<private> lane: u32;

// Adds the terms of a chunk, read as unsigned, to the sum at a place, which has three words.
fn add(place: u32, terms: Wide) {
    let at = SUM_WORDS * place * p.lanes + lane;
    let low = sums[at] + low_word(terms);
    let carry = select(0u, 1u, low < low_word(terms));
    let middle = sums[at + p.lanes] + carry;
    let carry_on = select(0u, 1u, middle < carry);
    let sum = middle + high_word(terms);
    sums[at] = low;
    sums[at + p.lanes] = sum;
    sums[at + 2u * p.lanes] += carry_on + select(0u, 1u, sum < middle);
}

// Only here to the end: state that is kept in structures in Rust.
fn kept(word: u32) -> u32 {
    return state[word * p.lanes + lane];
}

fn kept_wide(word: u32) -> Wide {
    return wide(kept(word), kept(word + 1u));
}

fn keep(word: u32, value: u32) {
    state[word * p.lanes + lane] = value;
}

fn keep_wide(word: u32, value: Wide) {
    keep(word, low_word(value));
    keep(word + 1u, high_word(value));
}
