// The tally of scalar estimates: sum, sum of squares, extremes and a histogram, all exact integers.
// Twin of src/kernel/moments.rs, which gives FLUSH, BINS, BIN_BITS and LEVEL_OFFSET.
//
// A workgroup takes one job. An invocation adds up at most FLUSH trials in 64 bits; the workgroup's sums have 96.

// The trials high·2^32 + low and on, count of them; slot is where the histograms go.
struct Job {
    low: u32,
    high: u32,
    count: u32,
    slot: u32,
}

@group(0) @binding(2) var<storage, read> jobs: array<Job>;
@group(0) @binding(3) var<storage, read_write> partials: array<u32>;
//#if HISTOGRAM
@group(0) @binding(4) var<storage, read_write> histograms: array<atomic<u32>>;
var<workgroup> counts: array<atomic<u32>, ESTIMATES * BINS>;
//#end
var<workgroup> lanes: array<u32, 3u * WORKGROUP>;

struct Sums {
    sum: Wide,
    square: Wide,
    least: i32,
    greatest: i32,
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let index = group.y * GROUPS_PER_ROW + group.x;
    if index >= arrayLength(&jobs) {
        return;
    }
    let job = jobs[index];
    //#if HISTOGRAM
    for (var i = lane; i < ESTIMATES * BINS; i += WORKGROUP) {
        atomicStore(&counts[i], 0u);
    }
    workgroupBarrier();
    //#end

    var sums: array<Sums, ESTIMATES>;
    //#for e in 0..ESTIMATES
    sums[e] = Sums(wide(0u, 0u), wide(0u, 0u), 0x7fffffff, -0x7fffffff - 1);
    //#end
    for (var i = lane; i < job.count; i += WORKGROUP) {
        let error = trial(job.low + i, job.high);
        //#for e in 0..ESTIMATES
        sums[e] = add(sums[e], error[e]);
        //#end
        //#if HISTOGRAM
        //#for e in 0..ESTIMATES
        atomicAdd(&counts[e * BINS + bin(error[e], bin_base(e))], 1u);
        //#end
        //#end
    }

    let base = index * ESTIMATES * PARTIAL_WORDS;
    //#for e in 0..ESTIMATES
    reduce_sum(lane, base + e * PARTIAL_WORDS, sums[e].sum, sar(high_word(sums[e].sum), 31u));
    reduce_sum(lane, base + e * PARTIAL_WORDS + 3u, sums[e].square, 0u);
    reduce_extremes(lane, base + e * PARTIAL_WORDS + 6u, sums[e].least, sums[e].greatest);
    //#end

    //#if HISTOGRAM
    for (var i = lane; i < ESTIMATES * BINS; i += WORKGROUP) {
        let count = atomicLoad(&counts[i]);
        if count != 0u {
            atomicAdd(&histograms[job.slot * ESTIMATES * BINS + i], count);
        }
    }
    //#end
}

fn add(sums: Sums, error: u32) -> Sums {
    return Sums(
        add_wide(sums.sum, mul_wide(error, 1u)),
        add_wide(sums.square, mul_wide(error, error)),
        min(sums.least, bitcast<i32>(error)),
        max(sums.greatest, bitcast<i32>(error)),
    );
}

// Adds up one 96-bit number of each invocation and writes the sum to three words of the partials.
fn reduce_sum(lane: u32, to: u32, number: Wide, top: u32) {
    lanes[lane] = low_word(number);
    lanes[WORKGROUP + lane] = high_word(number);
    lanes[2u * WORKGROUP + lane] = top;
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half >>= 1u) {
        if lane < half {
            let other = lane + half;
            let word0 = lanes[lane] + lanes[other];
            let carry0 = select(0u, 1u, word0 < lanes[lane]);
            let plain1 = lanes[WORKGROUP + lane] + lanes[WORKGROUP + other];
            let word1 = plain1 + carry0;
            let carry1 = select(0u, 1u, plain1 < lanes[WORKGROUP + lane]) + select(0u, 1u, word1 < plain1);
            lanes[lane] = word0;
            lanes[WORKGROUP + lane] = word1;
            lanes[2u * WORKGROUP + lane] += lanes[2u * WORKGROUP + other] + carry1;
        }
        workgroupBarrier();
    }
    if lane < 3u {
        partials[to + lane] = lanes[lane * WORKGROUP];
    }
    workgroupBarrier();
}

fn reduce_extremes(lane: u32, to: u32, least: i32, greatest: i32) {
    lanes[lane] = bitcast<u32>(least);
    lanes[WORKGROUP + lane] = bitcast<u32>(greatest);
    workgroupBarrier();
    for (var half = WORKGROUP / 2u; half > 0u; half >>= 1u) {
        if lane < half {
            let other = lane + half;
            lanes[lane] = bitcast<u32>(min(bitcast<i32>(lanes[lane]), bitcast<i32>(lanes[other])));
            lanes[WORKGROUP + lane] =
                bitcast<u32>(max(bitcast<i32>(lanes[WORKGROUP + lane]), bitcast<i32>(lanes[WORKGROUP + other])));
        }
        workgroupBarrier();
    }
    if lane < 2u {
        partials[to + lane] = lanes[lane * WORKGROUP];
    }
    workgroupBarrier();
}

// The bin of |error|, below BINS: log-linear, 128 to the octave, starting at the level `base`.
fn bin(error: u32, base: u32) -> u32 {
    let sign = sar(error, 31u);
    let a = max((error ^ sign) - sign, 1u);
    let zeros = countLeadingZeros(a);
    let level = ((a << zeros) >> (31u - BIN_BITS)) - (zeros << BIN_BITS);
    let above = bitcast<i32>(level - (base - LEVEL_OFFSET - 1u));
    return u32(clamp(above, 0, i32(BINS) - 1));
}
