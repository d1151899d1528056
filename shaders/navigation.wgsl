// Errors of a navigator: exact sums of the weighted increments of the angle of a synthetic record.
// Twin of crates/kernel/src/navigation.rs.
//
// An invocation makes the record of one gyro. The weights follow the angles common to all records in `table`, from
// p.weights.x on.

// The place of the last angle in the state.
const LAST = STATE_WORDS + HOLD_WORDS * STREAMS * OCTAVES;

// Only here: `records` of Rust.
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    lane = id.x;
    if lane >= p.lanes {
        return;
    }
    let low = p.low + lane;
    address = Address(low, p.high, schedule(vec2<u32>(p.key_0, p.key_1)));
    var last = 0u;
    if p.chunk_from == 0u {
        begin();
    } else {
        load_state();
        last = kept(LAST);
    }
    for (var c = p.chunk_from; c < p.chunk_to; c += 1u) {
        chunk(c * CHUNK);
        last = increments(last);
        for (var f = 0u; f < FUNCTIONALS; f += 1u) {
            add(f, weighted(p.weights.x + (c * FUNCTIONALS + f) * CHUNK));
        }
    }
    store_state();
    keep(LAST, last);
}

// Replaces the angles of a chunk by their increments from the `last` angle before them, and returns the new last one.
fn increments(last: u32) -> u32 {
    var before = last;
    for (var i = 0u; i < CHUNK; i += 1u) {
        let angle = angles[i];
        angles[i] = angle - before;
        before = angle;
    }
    return before;
}

// Weighted sum of the increments of a chunk, raised so that it is not negative; its weights start at `start`.
fn weighted(start: u32) -> Wide {
    var sum = wide(0u, RAISED_WORD);
    for (var i = 0u; i < CHUNK; i += 1u) {
        sum = add_wide(sum, mul_wide(angles[i], table[start + i]));
    }
    return sum;
}
