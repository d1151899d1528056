// One trial of a mode switch: the ticks round the gap, and how far each filler's angle is from the true one.
// Twin of src/kernel/gap_fill.rs, which gives the shape (BEFORE, AFTER, …) and the places of the parameters.

@group(0) @binding(1) var<uniform> parameters: array<vec4<u32>, PARAMETER_VECTORS>;

// The parameters in registers: loaded where they are used, they are loaded anew in every trial.
var<private> p: array<u32, PARAMETER_WORDS>;

fn load_parameters() {
    //#for i in 0..PARAMETER_WORDS
    p[i] = parameters[i / 4u][i % 4u];
    //#end
}

fn bin_base(estimate: u32) -> u32 {
    return p[BIN_BASE + estimate];
}

fn trial(low: u32, high: u32) -> array<u32, ESTIMATES> {
    let address = Address(low, high, vec2<u32>(p[KEY], p[KEY + 1u]));

    var random = draw(address, NOISE_AFTER_AND_PHASE, 0u);
    let phase = p[PHASE] + (random[2] & p[PHASE_SPREAD]);
    let sin = sine(phase);
    let cos = sine(phase + QUARTER_TURN);
    let truth = high_word(angle(sin, cos, p[GAP_SIN], p[GAP_COS]));

    var after: array<u32, AFTER_LENGTH>;
    //#for k in 0..AFTER
    if k > 0u && k % 2u == 0u {
        random = draw(address, NOISE_AFTER_AND_PHASE, k / 2u);
    }
    after[k] = tick(angle(sin, cos, p[AFTER_SIN + k], p[AFTER_COS + k]), normal(random[k % 2u]), p[SIGMA]);
    //#end
    var before: array<u32, BEFORE_LENGTH>;
    //#for k in 0..BEFORE
    if k % 4u == 0u {
        random = draw(address, NOISE_BEFORE, k / 4u);
    }
    before[k] = tick(angle(sin, cos, p[BEFORE_SIN + k], p[BEFORE_COS + k]), normal(random[k % 4u]), p[SIGMA]);
    //#end

    var error: array<u32, ESTIMATES>;
    var sum: Sum;
    //#for filler in 0..FILLERS
    sum = less(truth, p[RESIDUAL_SCALE + filler]);
    //#for k in 0..RESIDUAL_BEFORE
    sum = add_tick(sum, before[k], p[RESIDUAL_WEIGHT + filler * (RESIDUAL_BEFORE + AFTER) + k]);
    //#end
    //#for k in 0..AFTER
    sum = add_tick(sum, after[k], p[RESIDUAL_WEIGHT + filler * (RESIDUAL_BEFORE + AFTER) + RESIDUAL_BEFORE + k]);
    //#end
    error[filler] = error_of(sum, filler);
    //#end
    //#for filler in 0..FILLERS
    sum = less(truth, p[EXTRAPOLATION_SCALE + filler]);
    //#for k in 0..EXTRAPOLATION_BEFORE
    sum = add_tick(sum, before[k], p[EXTRAPOLATION_WEIGHT + filler * EXTRAPOLATION_BEFORE + k]);
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

// The angle that the tone turns through, in 2^-32 LSB, with half an LSB for rounding.
fn angle(sin: u32, cos: u32, at_sin: u32, at_cos: u32) -> Wide {
    return add_wide(add_wide(mul_wide(sin, at_sin), mul_wide(cos, at_cos)), wide(0x80000000u, 0u));
}

// What the gyro delivers for a tick: the angle and sigma times the normal number z, in LSB.
fn tick(angle: Wide, z: u32, sigma: u32) -> u32 {
    return high_word(add_wide(angle, mul_wide(z, sigma)));
}
