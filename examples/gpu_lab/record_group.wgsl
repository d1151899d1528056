// The kernel of records with one record in a workgroup, an experiment of the lab: a lane makes four samples of each pass
// of SPAN, sums run over the lanes, and all angles that differences need are in the workgroup's memory. The sums are those
// of shaders/allan.wgsl. Fill residuals are left out.

@group(0) @binding(1) var<uniform> p: Parameters;
// For each level its stride, the start and length of its ring; then for each slot its level, its first new angle and
// its span. A slot takes four of the differences of a place in each pass.
@group(0) @binding(2) var<storage, read> tables: array<vec4<u32>>;
// Three words for each slot of each record.
@group(0) @binding(3) var<storage, read_write> sums: array<u32>;
//#if DRIFT
@group(0) @binding(5) var<storage, read> drift: array<u32>;
//#end

// Changes of the rate, then the angles of the pass.
var<workgroup> chunk: array<atomic<u32>, SPAN>;
var<workgroup> rings: array<u32, RING_WORDS>;
// For each level the first new angle, counted in strides, the number of new ones, and the place of the first.
var<workgroup> heads: array<vec3<u32>, LEVELS>;
// Two of each, which take turns.
var<workgroup> scanned: array<u32, 2 * LANES>;
var<workgroup> scanned_wide: array<Wide, 2 * LANES>;
//#if FLICKER_HOLDS
var<workgroup> grids: array<u32, OCTAVES * STREAMS>;
//#end
//#if MARKOV_STEPS
var<workgroup> markov_rates: array<u32, SPAN>;
//#end

var<private> lane: u32;
var<private> address: Address;
var<private> totals: array<vec3<u32>, ROUNDS_OF_SLOTS>;

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    lane = index;
    address = Address(p.low + group.x, p.high, schedule(vec2<u32>(p.key_0, p.key_1)));
    let at_start = draw(address, FOR_RECORD_START, 0u);
    var flicker = 0u;
    var walk = wide(0u, 0u);
    var angle = wide(0u, 0u);
    //#if MARKOV_STEPS
    var markov = mul_wide(normal(at_start.z), p.markov_start);
    //#end
    //#if FLICKER_HOLDS
    sum_over_lanes(first_holds());
    flicker = scanned[LANES - 1u];
    workgroupBarrier();
    //#end
    for (var first = 0u; first <= p.samples; first += SPAN) {
        let mine = first + 4u * lane;
        var rate: array<u32, 4>;
        //#if FLICKER_HOLDS
        //#for k in 0..QUAD
        atomicStore(&chunk[k * LANES + lane], 0u);
        //#end
        workgroupBarrier();
        for (var item = lane; item < SHORT_ITEMS; item += LANES) {
            change_in_item(item, first);
        }
        if lane > LAST_SHORT && lane < OCTAVES {
            change_in_long(lane, first);
        }
        workgroupBarrier();
        var changes = 0u;
        //#for k in 0..QUAD
        changes += atomicLoad(&chunk[4u * lane + k]);
        rate[k] = changes;
        //#end
        let flicker_before = flicker + sum_over_lanes(changes) - changes;
        //#for k in 0..QUAD
        rate[k] += flicker_before;
        //#end
        flicker += scanned[LANES - 1u];
        //#end
        //#if WALK_STEPS
        {
            let words = draw(address, FOR_WALK, mine / 4u);
            var steps: array<Wide, 4>;
            var walked = wide(0u, 0u);
            //#for k in 0..QUAD
            walked = add_wide(walked, mul_wide(normal(words[k]), p.walk));
            steps[k] = walked;
            //#end
            let before = add_wide(walk, sub_wide(sum_over_lanes_wide(walked), walked));
            //#for k in 0..QUAD
            rate[k] += high_word(add_wide(before, steps[k]));
            //#end
            walk = add_wide(walk, scanned_wide[LANES - 1u]);
            workgroupBarrier();
        }
        //#end
        //#if MARKOV_STEPS
        {
            let words = draw(address, FOR_MARKOV, mine / 4u);
            //#for k in 0..QUAD
            markov_rates[4u * lane + k] = normal(words[k]);
            //#end
            workgroupBarrier();
            // Each step depends on the one before.
            if lane == 0u {
                for (var i = 0u; i < SPAN; i += 1u) {
                    let lost = mul_wide(bits_from(markov, 30u), p.markov_loss);
                    markov = add_wide(sub_wide(markov, lost), mul_wide(markov_rates[i], p.markov_step));
                    markov_rates[i] = bits_from(markov, 30u);
                }
            }
            workgroupBarrier();
            //#for k in 0..QUAD
            rate[k] += markov_rates[4u * lane + k];
            //#end
        }
        //#end
        let words = draw(address, FOR_WHITE, mine / 4u);
        var before: array<Wide, 4>;
        var turned = wide(0u, 0u);
        //#for k in 0..QUAD
        before[k] = turned;
        turned = add_wide(turned, add_wide(mul_wide(rate[k], p.rate_scale), mul_wide(normal(words[k]), p.white)));
        //#end
        let angle_before = add_wide(angle, sub_wide(sum_over_lanes_wide(turned), turned));
        angle = add_wide(angle, scanned_wide[LANES - 1u]);
        //#if QUANTIZATION_NOISE
        let quantization = draw(address, FOR_QUANTIZATION, mine / 4u);
        //#end
        //#for k in 0..QUAD
        {
            var reading = high_word(add_wide(angle_before, before[k]));
            //#if DRIFT
            reading += drift[min(mine + k, p.samples)];
            //#end
            //#if SINE_WAVE
            let cosine = sine(at_start.y + (mine + k) * p.sine_step + QUARTER_TURN);
            reading -= high_word(mul_wide(cosine, p.sine_amplitude));
            //#end
            //#if QUANTIZATION_NOISE
            reading += scaled(quantization[k], p.quantization);
            //#end
            //#if PULSE
            reading = (reading + (at_start.x & ((1u << p.pulse) - 1u))) & (0xffffffffu << p.pulse);
            //#end
            atomicStore(&chunk[4u * lane + k], reading);
        }
        //#end
        if lane < LEVELS {
            let level = tables[lane];
            let from_ = (first + level.x - 1u) / level.x;
            let beyond = (min(first + SPAN - 1u, p.samples) + level.x) / level.x;
            heads[lane] = vec3<u32>(from_, beyond - from_, from_ % level.z);
        }
        workgroupBarrier();
        //#for l in 0..LEVELS
        for (var i = lane; i < heads[l].y; i += LANES) {
            let level = tables[l];
            let at = within(heads[l].z + i, level.z);
            rings[level.y + at] = atomicLoad(&chunk[(heads[l].x + i) * level.x - first]);
        }
        //#end
        workgroupBarrier();
        //#for r in 0..ROUNDS_OF_SLOTS
        if r * LANES + lane < SLOTS {
            let square = squares(tables[LEVELS + r * LANES + lane]);
            let low = totals[r].x + low_word(square);
            let carry = select(0u, 1u, low < totals[r].x);
            let middle = totals[r].y + carry;
            let sum = middle + high_word(square);
            totals[r] = vec3<u32>(low, sum, totals[r].z + select(0u, 1u, middle < carry) + select(0u, 1u, sum < middle));
        }
        //#end
        workgroupBarrier();
    }
    //#for r in 0..ROUNDS_OF_SLOTS
    if r * LANES + lane < SLOTS {
        let at = 3u * (group.x * SLOTS + r * LANES + lane);
        sums[at] = totals[r].x;
        sums[at + 1u] = totals[r].y;
        sums[at + 2u] = totals[r].z;
    }
    //#end
}

// Sum of the squares of the differences of a slot.
fn squares(slot: vec4<u32>) -> Wide {
    let head = heads[slot.x];
    let level = tables[slot.x];
    var sum = wide(0u, 0u);
    let end = min(slot.y + 4u, head.y);
    for (var i = max(slot.y, max(ORDER * slot.z, head.x) - head.x); i < end; i += 1u) {
        let at = within(head.z + i, level.z);
        let first = angle(level, at);
        let second = angle(level, back(at, slot.z, level.z));
        let third = angle(level, back(at, 2u * slot.z, level.z));
        var difference = first - second - (second - third);
        //#if THIRD_ORDER
        let fourth = angle(level, back(at, 3u * slot.z, level.z));
        difference = difference - (second - third - (third - fourth));
        //#end
        sum = add_wide(sum, mul_wide(difference, difference));
    }
    return sum;
}

fn angle(level: vec4<u32>, at: u32) -> u32 {
    return rings[level.y + at];
}

// A place of a ring that is less than its depth beyond its end.
fn within(at: u32, depth: u32) -> u32 {
    return select(at, at - depth, at >= depth);
}

fn back(at: u32, by: u32, depth: u32) -> u32 {
    return select(at - by, at + depth - by, at < by);
}

// The sum of the words of this lane and all before it. The sum of all is the last of `scanned`.
fn sum_over_lanes(word: u32) -> u32 {
    var sum = word;
    scanned[lane] = sum;
    workgroupBarrier();
    //#for d in 0..SCAN_STEPS
    if lane >= (1u << d) {
        sum += scanned[(d & 1u) * LANES + lane - (1u << d)];
    }
    scanned[((d + 1u) & 1u) * LANES + lane] = sum;
    workgroupBarrier();
    //#end
    return sum;
}

// The same for 64 bits.
fn sum_over_lanes_wide(word: Wide) -> Wide {
    var sum = word;
    scanned_wide[lane] = sum;
    workgroupBarrier();
    //#for d in 0..SCAN_STEPS
    if lane >= (1u << d) {
        sum = add_wide(sum, scanned_wide[(d & 1u) * LANES + lane - (1u << d)]);
    }
    scanned_wide[((d + 1u) & 1u) * LANES + lane] = sum;
    workgroupBarrier();
    //#end
    return sum;
}

fn scaled(word: u32, sigma: u32) -> u32 {
    return high_word(mul_wide(normal(word), sigma));
}

//#if FLICKER_HOLDS
fn flicker_sigma(octave: u32) -> u32 {
    return p.flicker[octave / 4u][octave % 4u];
}

fn streams(octave: u32) -> u32 {
    return select(STREAMS, 1u, octave < FOUR_STREAMS);
}

// Keeps where the holds of an octave, that of the lane, begin. Returns the sum of those in which the record starts.
fn first_holds() -> u32 {
    var sum = 0u;
    if lane > 0u && lane < OCTAVES {
        let grid = draw(address, FOR_FLICKER_GRID, lane);
        let words = draw_beyond(address, FOR_FLICKER, lane, 0u);
        for (var stream = 0u; stream < streams(lane); stream += 1u) {
            grids[lane * STREAMS + stream] = grid[stream] >> (32u - lane);
            sum += scaled(words[stream], flicker_sigma(lane));
        }
    }
    return sum;
}

// Applies the changes of an item of the short octaves: four holds of one stream, or one hold of four.
fn change_in_item(item: u32, first: u32) {
    var octave = 1u;
    var at = item;
    while at >= items(octave) {
        at -= items(octave);
        octave += 1u;
    }
    let sigma = flicker_sigma(octave);
    if octave < FOUR_STREAMS {
        let block = (first >> octave) / 4u + at;
        let words = draw_beyond(address, FOR_FLICKER, octave, block);
        let next = draw_beyond(address, FOR_FLICKER, octave, block + 1u);
        var value = scaled(words.x, sigma);
        let values = vec4<u32>(scaled(words.y, sigma), scaled(words.z, sigma), scaled(words.w, sigma), scaled(next.x, sigma));
        for (var k = 0u; k < 4u; k += 1u) {
            atomicAdd(&chunk[((4u * at + k) << octave) + grids[octave * STREAMS]], values[k] - value);
            value = values[k];
        }
    } else {
        let hold = (first >> octave) + at;
        let words = draw_beyond(address, FOR_FLICKER, octave, hold);
        let next = draw_beyond(address, FOR_FLICKER, octave, hold + 1u);
        for (var stream = 0u; stream < STREAMS; stream += 1u) {
            let place = (at << octave) + grids[octave * STREAMS + stream];
            atomicAdd(&chunk[place], scaled(next[stream], sigma) - scaled(words[stream], sigma));
        }
    }
}

// Number of items of an octave in a pass.
fn items(octave: u32) -> u32 {
    return (SPAN >> octave) / select(1u, 4u, octave < FOUR_STREAMS);
}

// Applies the changes of an octave whose holds last longer than a pass.
fn change_in_long(octave: u32, first: u32) {
    let place = first & ((1u << octave) - 1u);
    for (var stream = 0u; stream < STREAMS; stream += 1u) {
        let to_go = grids[octave * STREAMS + stream] - place;
        if to_go < SPAN {
            let hold = first >> octave;
            let words = draw_beyond(address, FOR_FLICKER, octave, hold);
            let next = draw_beyond(address, FOR_FLICKER, octave, hold + 1u);
            let sigma = flicker_sigma(octave);
            atomicAdd(&chunk[to_go], scaled(next[stream], sigma) - scaled(words[stream], sigma));
        }
    }
}
//#end
