// One trial of a mode switch: the ticks round the gap, and how far each filler's angle is from the true one.
// Twin of src/kernel/gap_fill.rs, which gives the shape (BEFORE, AFTER, …) and the places of the parameters.

@group(0) @binding(1) var<uniform> parameters: array<vec4<u32>, PARAMETER_VECTORS>;

// The parameters in registers: loaded where they are used, they are loaded anew in every trial.
var<private> p: array<u32, PARAMETER_WORDS>;

// Half of an LSB in 2^-32 LSB: turns a floor into a rounding.
const HALF = 0x80000000u;

fn load_parameters() {
    //#for i in 0..PARAMETER_WORDS
    p[i] = parameters[i / 4u][i % 4u];
    //#end
}

fn bin_base(estimate: u32) -> u32 {
    return p[BIN_BASE + estimate];
}

// The k-th tick on either side of the gap, where the shape has it: what the tone turns through and noise.
fn side(ticks: ptr<function, Ticks>, tone: vec2<u32>, k: u32, noise: vec2<u32>) {
    let even = add_wide(mul_wide(tone[0], p[SIDE_SIN + k]), wide(HALF, 0u));
    let odd = mul_wide(tone[1], p[SIDE_COS + k]);
    if k < BEFORE {
        (*ticks).before[k] = tick(sub_wide(even, odd), normal(noise[0]), p[SIGMA]);
    }
    if k < AFTER {
        (*ticks).after[k] = tick(add_wide(even, odd), normal(noise[1]), p[SIGMA]);
    }
}

// The ticks on both sides, outward from the gap.
struct Ticks {
    before: array<u32, SIDES>,
    after: array<u32, SIDES>,
}

fn trial(low: u32, high: u32) -> array<u32, ESTIMATES> {
    let address = Address(low, high, schedule(vec2<u32>(p[KEY], p[KEY + 1u])));

    let first = draw(address, NOISE_AFTER_AND_PHASE, 0u);
    let phase = p[PHASE] + (first[2] & p[PHASE_SPREAD]);
    let tone = vec2<u32>(sine(phase), sine(phase + QUARTER_TURN));
    let truth = high_word(add_wide(mul_wide(tone[0], p[GAP_SIN]), wide(HALF, 0u)));

    var ticks: Ticks;
    var noise_before: vec4<u32>;
    var noise_after = first;
    //#for k in 0..SIDES
    if k % 4u == 0u && k < BEFORE {
        noise_before = draw(address, NOISE_BEFORE, k / 4u);
    }
    if k % 2u == 0u && 0u < k && k < AFTER {
        noise_after = draw(address, NOISE_AFTER_AND_PHASE, k / 2u);
    }
    side(&ticks, tone, k, vec2<u32>(noise_before[k % 4u], noise_after[k % 2u]));
    //#end

    var error: array<u32, ESTIMATES>;
    var sum: Sum;
    //#for filler in 0..FILLERS
    sum = less(truth, p[RESIDUAL_SCALE + filler]);
    //#for k in 0..RESIDUAL_BEFORE
    sum = add_tick(sum, ticks.before[k], p[RESIDUAL_WEIGHT + filler * (RESIDUAL_BEFORE + AFTER) + k]);
    //#end
    //#for k in 0..AFTER
    sum = add_tick(sum, ticks.after[k], p[RESIDUAL_WEIGHT + filler * (RESIDUAL_BEFORE + AFTER) + RESIDUAL_BEFORE + k]);
    //#end
    error[filler] = error_of(sum, filler);
    //#end
    //#for filler in 0..FILLERS
    sum = less(truth, p[EXTRAPOLATION_SCALE + filler]);
    //#for k in 0..EXTRAPOLATION_BEFORE
    sum = add_tick(sum, ticks.before[k], p[EXTRAPOLATION_WEIGHT + filler * EXTRAPOLATION_BEFORE + k]);
    //#end
    error[FILLERS + filler] = error_of(sum, FILLERS + filler);
    //#end
    return error;
}

// A weighted sum of ticks less the scaled truth, in 32 bits where that is enough.
//#if WIDE
alias Sum = Wide;

fn less(truth: u32, scale: u32) -> Sum {
    return mul_wide(truth, 0u - scale);
}

fn add_tick(sum: Sum, tick: u32, weight: u32) -> Sum {
    return add_wide(sum, mul_wide(tick, weight));
}

fn error_of(sum: Sum, estimate: u32) -> u32 {
    let shift = p[SHIFT + estimate];
    return bits_from(add_wide(sum, wide((1u << shift) >> 1u, 0u)), shift);
}
//#else
alias Sum = u32;

fn less(truth: u32, scale: u32) -> Sum {
    return truth * (0u - scale);
}

fn add_tick(sum: Sum, tick: u32, weight: u32) -> Sum {
    return sum + tick * weight;
}

fn error_of(sum: Sum, estimate: u32) -> u32 {
    return sum;
}
//#end

// What the gyro delivers for a tick, in LSB: the angle, in 2^-32 LSB, and sigma times the normal number z.
fn tick(angle: Wide, z: u32, sigma: u32) -> u32 {
    return high_word(add_wide(angle, mul_wide(z, sigma)));
}
