// The tally of scalar estimates: sum, sum of squares, extremes and a histogram, all exact integers.
// Twin of kernel/src/moments.rs. The kernel provides the places of its parameters and the function `trial`.
//
// A workgroup takes one job. An invocation adds up at most FLUSH trials in 64 bits; the workgroup's sums have 96 bits.

// `count` trials from number high·2^32 + low on; `slot` is the place of the histograms.
struct Job {
    low: u32,
    high: u32,
    count: u32,
    slot: u32,
}

@group(0) @binding(1) var<uniform> parameters: array<vec4<u32>, PARAMETER_VECTORS>;
@group(0) @binding(2) var<storage, read> jobs: array<Job>;
@group(0) @binding(3) var<storage, read_write> partials: array<u32>;
//#if HISTOGRAM
@group(0) @binding(4) var<storage, read_write> histograms: array<atomic<u32>>;
//#end
//#if TABLE
@group(0) @binding(5) var<storage, read> table: array<u32>;
//#end

// The parameters in registers; loaded where they are used, they would be reloaded in every trial.
var<private> p: array<u32, PARAMETER_WORDS>;

//#if HISTOGRAM
const SHARED_WORDS = ESTIMATES * max(BINS, STAGED_WORDS * WORKGROUP);
//#else
const SHARED_WORDS = ESTIMATES * STAGED_WORDS * WORKGROUP;
//#end

// Used first for the bin counts, then for the sums of the invocations, never for both at once.
var<workgroup> shared_words: array<atomic<u32>, SHARED_WORDS>;

// The sum is kept as its lower 32 bits and the sum of the upper halves.
struct Sums {
    sum: u32,
    halves: u32,
    square: Wide,
    least: i32,
    greatest: i32,
}

fn bin_base(estimate: u32) -> u32 {
    return p[BIN_BASE + estimate];
}

// Only here: on the processor, parameters are read in place.
fn load_parameters() {
    //#for i in 0..PARAMETER_WORDS
    p[i] = parameters[i / 4u][i % 4u];
    //#end
}

// Only here: `tally` and `accumulate` of Rust.
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let index = group.y * GROUPS_PER_ROW + group.x;
    if index >= arrayLength(&jobs) {
        return;
    }
    let job = jobs[index];
    load_parameters();
    //#if HISTOGRAM
    for (var i = lane; i < ESTIMATES * BINS; i += WORKGROUP) {
        atomicStore(&shared_words[i], 0u);
    }
    workgroupBarrier();
    //#end

    var sums: array<Sums, ESTIMATES>;
    //#for e in 0..ESTIMATES
    sums[e] = empty();
    //#end
    for (var i = lane; i < job.count; i += WORKGROUP) {
        let error = trial(job.low + i, job.high);
        //#for e in 0..ESTIMATES
        sums[e] = add(sums[e], error[e]);
        //#end
        //#if HISTOGRAM
        //#for e in 0..ESTIMATES
        atomicAdd(&shared_words[e * BINS + bin(error[e], bin_base(e))], 1u);
        //#end
        //#end
    }

    //#if HISTOGRAM
    workgroupBarrier();
    for (var i = lane; i < ESTIMATES * BINS; i += WORKGROUP) {
        let count = atomicLoad(&shared_words[i]);
        if count != 0u {
            atomicAdd(&histograms[job.slot * ESTIMATES * BINS + i], count);
        }
    }
    workgroupBarrier();
    //#end
    //#for e in 0..ESTIMATES
    stage(lane, e, sums[e]);
    //#end
    workgroupBarrier();
    if lane < ESTIMATES {
        flush(lane, (index * ESTIMATES + lane) * PARTIAL_WORDS);
    }
}

fn empty() -> Sums {
    return Sums(0u, 0u, wide(0u, 0u), 0x7fffffff, -0x7fffffff - 1);
}

fn add(sums: Sums, error: u32) -> Sums {
    return Sums(
        sums.sum + error,
        sums.halves + sar(error, 16u),
        add_wide(sums.square, mul_wide(error, error)),
        min(sums.least, bitcast<i32>(error)),
        max(sums.greatest, bitcast<i32>(error)),
    );
}

// Only here: lanes are registers in Rust. Stores the sums of an invocation where `flush` reads them: six words for each
// estimate and lane.
fn stage(lane: u32, estimate: u32, sums: Sums) {
    let to = estimate * STAGED_WORDS * WORKGROUP + lane;
    atomicStore(&shared_words[to], sums.sum);
    atomicStore(&shared_words[to + WORKGROUP], sums.halves);
    atomicStore(&shared_words[to + 2u * WORKGROUP], low_word(sums.square));
    atomicStore(&shared_words[to + 3u * WORKGROUP], high_word(sums.square));
    atomicStore(&shared_words[to + 4u * WORKGROUP], bitcast<u32>(sums.least));
    atomicStore(&shared_words[to + 5u * WORKGROUP], bitcast<u32>(sums.greatest));
}

// Adds up the sums of all lanes in 96 bits. One invocation does an estimate; a tree would need a barrier per level.
fn flush(estimate: u32, to: u32) {
    let base = estimate * STAGED_WORDS * WORKGROUP;
    var sum = vec3<u32>();
    var square = vec3<u32>();
    var least = 0x7fffffff;
    var greatest = -0x7fffffff - 1;
    for (var lane = base; lane < base + WORKGROUP; lane++) {
        sum = add96(sum, whole_sum(atomicLoad(&shared_words[lane]), atomicLoad(&shared_words[lane + WORKGROUP])));
        square = add96(square, vec3<u32>(
            atomicLoad(&shared_words[lane + 2u * WORKGROUP]),
            atomicLoad(&shared_words[lane + 3u * WORKGROUP]),
            0u,
        ));
        least = min(least, bitcast<i32>(atomicLoad(&shared_words[lane + 4u * WORKGROUP])));
        greatest = max(greatest, bitcast<i32>(atomicLoad(&shared_words[lane + 5u * WORKGROUP])));
    }
    partials[to] = sum.x;
    partials[to + 1u] = sum.y;
    partials[to + 2u] = sum.z;
    partials[to + 3u] = square.x;
    partials[to + 4u] = square.y;
    partials[to + 5u] = square.z;
    partials[to + 6u] = bitcast<u32>(least);
    partials[to + 7u] = bitcast<u32>(greatest);
}

// A sum of at most FLUSH errors, from its lower 32 bits and the sum of the errors' upper halves.
fn whole_sum(low: u32, halves: u32) -> vec3<u32> {
    let rest = low - (halves << 16u);
    return add96(vec3<u32>(halves << 16u, sar(halves, 16u), sar(halves, 31u)), vec3<u32>(rest, 0u, 0u));
}

// Only here: Rust adds in 128 bits.
fn add96(a: vec3<u32>, b: vec3<u32>) -> vec3<u32> {
    let x = a.x + b.x;
    let carry_x = select(0u, 1u, x < a.x);
    let plain = a.y + b.y;
    let y = plain + carry_x;
    let carry_y = select(0u, 1u, plain < a.y) + select(0u, 1u, y < plain);
    return vec3<u32>(x, y, a.z + b.z + carry_y);
}

// The bin of |error|, below BINS. Bins are log-linear, 128 to the octave, starting at the level `base`.
fn bin(error: u32, base: u32) -> u32 {
    let sign = sar(error, 31u);
    let a = max((error ^ sign) - sign, 1u);
    let zeros = countLeadingZeros(a);
    let level = ((a << zeros) >> (31u - BIN_BITS)) - (zeros << BIN_BITS);
    let above = bitcast<i32>(level - (base - LEVEL_OFFSET - 1u));
    return u32(clamp(above, 0, i32(BINS) - 1));
}
