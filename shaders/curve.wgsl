// Records whose angles come chunk by chunk from a source, and the exact sums of their squared differences.
// Twin of crates/kernel/src/curve.rs.
//
// Parameters are generated: for each level the stride, the start and length of its ring, and its first place.
@group(0) @binding(2) var<storage, read_write> rings: array<u32>;

// The place of the record's first angle in `rings`, and the distance to its next: up to RING_LANES records have their angles
// side by side.
var<private> ring: u32;
var<private> row: u32;

// The angles of a chunk that a level takes: the first, counted in strides, and their number; the place of the first in the
// chunk and in the ring.
struct Newest {
    first: u32,
    count: u32,
    sample: u32,
    at: u32,
}

// Only here: `records` of Rust.
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    lane = id.x;
    let last = p.levels[LEVELS - 1u];
    row = min(p.lanes, RING_LANES);
    ring = (lane / row) * (last.y + last.z) * row + lane % row;
    if lane >= p.lanes {
        return;
    }
    let low = p.low + lane;
    address = Address(low, p.high, schedule(vec2<u32>(p.key_0, p.key_1)));
    if p.chunk_from == 0u {
        begin();
    } else {
        load_state();
    }
    for (var c = p.chunk_from; c < p.chunk_to; c += 1u) {
        let first = c * CHUNK;
        chunk(first);
        let count = min(CHUNK, p.samples + 1u - first);
        //#for l in 0..LEVELS
        {
            let level = p.levels[l];
            let newest = push(level, first, count);
            for (var place = level.w; place < end_of_level(l); place += 1u) {
                add(place, squares(level, p.spans[place / 4u][place % 4u], newest));
            }
        }
        //#end
    }
    store_state();
}

// Only here: in Rust the levels are lists.
fn end_of_level(l: u32) -> u32 {
    if l + 1u == LEVELS {
        return PLACES;
    }
    return p.levels[l + 1u].w;
}

// Stores the angles of a chunk at multiples of the stride, and returns which these are.
fn push(level: vec4<u32>, start: u32, count: u32) -> Newest {
    let stride = level.x;
    let first = (start + stride - 1u) / stride;
    var newest = Newest(first, 0u, first * stride - start, first % level.z);
    var at = newest.at;
    for (var sample = newest.sample; sample < count; sample += stride) {
        rings[ring + (level.y + at) * row] = angles[sample];
        at = beyond(at, 1u, level.z);
        newest.count += 1u;
    }
    return newest;
}

// The place `by` places beyond `at` in a ring.
fn beyond(at: u32, by: u32, depth: u32) -> u32 {
    return select(at + by, at + by - depth, at + by >= depth);
}

// The place `by` places before `at` in a ring.
fn before(at: u32, by: u32, depth: u32) -> u32 {
    return select(at - by, at + depth - by, at < by);
}

// Sum of the squared differences of order ORDER over `span` strides that end at the newest angles.
fn squares(level: vec4<u32>, span: u32, newest: Newest) -> Wide {
    var sum = wide(0u, 0u);
    let start = max(newest.first, ORDER * span);
    if start >= newest.first + newest.count {
        return sum;
    }
    var sample = newest.sample + (start - newest.first) * level.x;
    var place = beyond(newest.at, start - newest.first, level.z);
    var at: array<u32, ORDER>;
    //#for k in 0..ORDER
    place = before(place, span, level.z);
    at[k] = place;
    //#end
    var left = newest.first + newest.count - start;
    while left > 0u {
        // The run ends where the first of the places reaches the end of the ring.
        var run = left;
        //#for k in 0..ORDER
        run = min(run, level.z - at[k]);
        //#end
        for (var i = 0u; i < run; i += 1u) {
            let first = angles[sample];
            let second = angle(level, at[0] + i);
            let third = angle(level, at[1] + i);
            var difference = first - second - (second - third);
            //#if THIRD_ORDER
            let fourth = angle(level, at[2] + i);
            difference = difference - (second - third - (third - fourth));
            //#end
            sum = add_wide(sum, mul_wide(difference, difference));
            sample += level.x;
        }
        //#for k in 0..ORDER
        at[k] = beyond(at[k], run, level.z);
        //#end
        left -= run;
    }
    return sum;
}

fn angle(level: vec4<u32>, at: u32) -> u32 {
    return rings[ring + (level.y + at) * row];
}
