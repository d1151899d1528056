// The tally of scalar estimates: sum, sum of squares, extremes and a histogram, all exact integers.
// Twin of crates/kernel/src/moments.rs. The kernel provides the places of its parameters and the function `trial`.
//
// A workgroup takes one job. An invocation adds up at most FLUSH trials before it carries their sums over to its totals.

// `count` trials of a point from number high·2^32 + low on; `slot` is the place of the histograms.
struct Job {
    low: u32,
    high: u32,
    count: u32,
    point: u32,
    slot: u32,
}

// The parameters of all points, one after the other.
@group(0) @binding(1) var<storage, read> parameters: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> jobs: array<Job>;
@group(0) @binding(3) var<storage, read_write> partials: array<u32>;
//#if HISTOGRAM
@group(0) @binding(4) var<storage, read_write> histograms: array<atomic<u32>>;
//#end
//#if TABLE
@group(0) @binding(5) var<storage, read> table: array<u32>;
// The tables of the points follow one another; that of the point of this job starts here.
var<private> table_start: u32;

// Only here: on the processor, a table is a slice.
fn table_word(at: u32) -> u32 {
    return table[table_start + at];
}
//#end

// The parameters in registers; loaded where they are used, they would be reloaded in every trial.
var<private> p: array<u32, PARAMETER_WORDS>;

//#if HISTOGRAM
const SHARED_WORDS = ESTIMATES * max(BINS, PARTIAL_WORDS * WORKGROUP);
//#else
const SHARED_WORDS = ESTIMATES * PARTIAL_WORDS * WORKGROUP;
//#end

// Used first for the bin counts, then for the totals of the invocations, never for both at once.
var<workgroup> shared_words: array<atomic<u32>, SHARED_WORDS>;

// The sum is kept as its lower 32 bits and the sum of the upper halves.
struct Sums {
    sum: u32,
    halves: u32,
    square: Wide,
    least: i32,
    greatest: i32,
}

// Only here: Rust adds to its tallies. Σ and Σ² have 96 bits.
struct Totals {
    sum: vec3<u32>,
    square: vec3<u32>,
    least: i32,
    greatest: i32,
}

// Those of an invocation. They are used once in FLUSH trials, so that they need not stay in registers.
var<private> totals: array<Totals, ESTIMATES>;

fn bin_base(estimate: u32) -> u32 {
    return p[BIN_BASE + estimate];
}

// Only here: on the processor, parameters are read in place.
fn load_parameters(point: u32) {
    let from_ = point * PARAMETER_VECTORS;
    //#for i in 0..PARAMETER_WORDS
    p[i] = parameters[from_ + i / 4u][i % 4u];
    //#end
    //#if TABLE
    table_start = parameters[from_ + PARAMETER_WORDS / 4u][PARAMETER_WORDS % 4u];
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
    load_parameters(job.point);
    //#if HISTOGRAM
    for (var i = lane; i < ESTIMATES * BINS; i += WORKGROUP) {
        atomicStore(&shared_words[i], 0u);
    }
    workgroupBarrier();
    //#end

    //#for e in 0..ESTIMATES
    totals[e] = Totals(vec3<u32>(), vec3<u32>(), 0x7fffffff, -0x7fffffff - 1);
    //#end
    var i = lane;
    while i < job.count {
        let end = min(job.count, i + FLUSH * WORKGROUP);
        var sums: array<Sums, ESTIMATES>;
        //#for e in 0..ESTIMATES
        sums[e] = empty();
        //#end
        for (; i < end; i += WORKGROUP) {
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
        //#for e in 0..ESTIMATES
        totals[e] = flush(sums[e], totals[e]);
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
    stage(lane, e);
    //#end
    workgroupBarrier();
    if lane < ESTIMATES {
        unite(lane, (index * ESTIMATES + lane) * PARTIAL_WORDS);
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

fn flush(sums: Sums, total: Totals) -> Totals {
    return Totals(
        add96(total.sum, whole_sum(sums.sum, sums.halves)),
        add96(total.square, vec3<u32>(low_word(sums.square), high_word(sums.square), 0u)),
        min(total.least, sums.least),
        max(total.greatest, sums.greatest),
    );
}

// Only here: lanes are registers in Rust. Stores the totals of an invocation where `unite` reads
// them: PARTIAL_WORDS for each estimate and lane.
fn stage(lane: u32, estimate: u32) {
    let total = totals[estimate];
    let to = estimate * PARTIAL_WORDS * WORKGROUP + lane;
    atomicStore(&shared_words[to], total.sum.x);
    atomicStore(&shared_words[to + WORKGROUP], total.sum.y);
    atomicStore(&shared_words[to + 2u * WORKGROUP], total.sum.z);
    atomicStore(&shared_words[to + 3u * WORKGROUP], total.square.x);
    atomicStore(&shared_words[to + 4u * WORKGROUP], total.square.y);
    atomicStore(&shared_words[to + 5u * WORKGROUP], total.square.z);
    atomicStore(&shared_words[to + 6u * WORKGROUP], bitcast<u32>(total.least));
    atomicStore(&shared_words[to + 7u * WORKGROUP], bitcast<u32>(total.greatest));
}

// Only here: see `stage`. Unites the totals of all lanes. One invocation does an estimate; a tree would need a barrier per level.
fn unite(estimate: u32, to: u32) {
    let base = estimate * PARTIAL_WORDS * WORKGROUP;
    var all = Totals(vec3<u32>(), vec3<u32>(), 0x7fffffff, -0x7fffffff - 1);
    for (var lane = base; lane < base + WORKGROUP; lane++) {
        all.sum = add96(all.sum, staged96(lane));
        all.square = add96(all.square, staged96(lane + 3u * WORKGROUP));
        all.least = min(all.least, bitcast<i32>(atomicLoad(&shared_words[lane + 6u * WORKGROUP])));
        all.greatest = max(all.greatest, bitcast<i32>(atomicLoad(&shared_words[lane + 7u * WORKGROUP])));
    }
    partials[to] = all.sum.x;
    partials[to + 1u] = all.sum.y;
    partials[to + 2u] = all.sum.z;
    partials[to + 3u] = all.square.x;
    partials[to + 4u] = all.square.y;
    partials[to + 5u] = all.square.z;
    partials[to + 6u] = bitcast<u32>(all.least);
    partials[to + 7u] = bitcast<u32>(all.greatest);
}

// Only here: three words of `stage`.
fn staged96(at: u32) -> vec3<u32> {
    return vec3<u32>(
        atomicLoad(&shared_words[at]),
        atomicLoad(&shared_words[at + WORKGROUP]),
        atomicLoad(&shared_words[at + 2u * WORKGROUP]),
    );
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
