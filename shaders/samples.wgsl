// Angles of synthetic records, of which devices make segments side by side. Twin of crates/kernel/src/samples.rs.
//
// The table has the sums at the starts of the segments. p.segments: the first of them in this dispatch, their number in a
// record, the first chunk of the first, and the chunks of each.

// Only here: in Rust, `sums` calls `segment` for one after the other.
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    lane = id.x;
    if lane < p.lanes {
        segment(p.segments.x + lane);
    }
}

// Makes a segment, and writes its angles, or the sums at its end.
fn segment(number: u32) {
    let place = number % p.segments.y;
    let low = p.low + number / p.segments.y;
    let high = p.high + select(0u, 1u, low < p.low);
    address = Address(low, high, schedule(vec2<u32>(p.key_0, p.key_1)));
    let base = p.segments.z + place * p.segments.w;
    if p.chunk_from == 0u {
        begin_at(base * CHUNK);
        let at = SUMS_WORDS * place;
        noise.angle = wide(table[at], table[at + 1u]);
        noise.walk = wide(table[at + 2u], table[at + 3u]);
        noise.markov = wide(table[at + 4u], table[at + 5u]);
        noise.residuals = wide(table[at + 6u], table[at + 7u]);
    } else {
        load_state();
    }
    for (var c = p.chunk_from; c < p.chunk_to; c += 1u) {
        chunk((base + c) * CHUNK);
        //#if ANGLES
        for (var i = 0u; i < CHUNK; i += 1u) {
            put(c * CHUNK + i, angles[i]);
        }
        //#end
    }
    store_state();
    //#if ANGLES
    //#else
    put_wide(0u, noise.angle);
    put_wide(2u, noise.walk);
    put_wide(4u, noise.markov);
    put_wide(6u, noise.residuals);
    //#end
}

// Only here to the end: the words of the results are a list in Rust.
fn put(word: u32, value: u32) {
    sums[word * p.lanes + lane] = value;
}

fn put_wide(word: u32, value: Wide) {
    put(word, low_word(value));
    put(word + 1u, high_word(value));
}
