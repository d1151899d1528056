// The first ticks after one mode switch: the apparent rotation of the closing perimeter loop, less its compensation. Twin
// of crates/kernel/src/relock_ticks.rs. The places RELOCK_… of the parameters count from RELOCK, the place of their field in
// the surrounding kernel.

fn relock_ticks(address: Address, switch_number: u32, wrong: u32) -> array<u32, RELOCK_TICKS> {
    let miss = relock_miss(draw(address, FOR_RELOCK, switch_number * RELOCK_BLOCKS));
    let square = relock_square(miss);
    var left: array<u32, RELOCK_TICKS>;
    //#for i in 0..RELOCK_TICKS
    left[i] = relock_scaled(square, p[RELOCK + RELOCK_DRIFT + i]);
    //#end
    //#if RELOCK_BY_FREQUENCY
    return less_by_frequency(address, switch_number, square, wrong, left);
    //#else
    //#if RELOCK_BY_DETUNING
    return less_by_detuning(address, switch_number, miss, wrong, left);
    //#else
    return left;
    //#end
    //#end
}

// The relative error of f0 in the temperature curve, 2^-30; it is the same at all switches of a trial.
fn relock_wrong(address: Address) -> u32 {
    let words = draw(address, FOR_RELOCK, 0u);
    return high_word(mul_wide(normal(words[3]), p[RELOCK + RELOCK_TEMPERATURE]));
}

// The miss of the switch, in units of the detuning.
fn relock_miss(words: vec4<u32>) -> u32 {
    var sum = wide(HALF, p[RELOCK + RELOCK_MISS]);
    sum = add_wide(sum, mul_wide(normal(words[0]), p[RELOCK + RELOCK_HALF_WAVE]));
    sum = add_wide(sum, mul_wide(words[1] ^ MIDDLE, p[RELOCK + RELOCK_DAC_STEP]));
    sum = add_wide(sum, mul_wide(words[2] ^ MIDDLE, p[RELOCK + RELOCK_HYSTERESIS]));
    return high_word(sum);
}

// The square of the shifted miss, below 2^30.
fn relock_square(miss: u32) -> u32 {
    let magnitude = with_sign(miss, miss) << p[RELOCK + RELOCK_SQUARE_SHIFT];
    return mulhi(magnitude, magnitude);
}

// Scales `word`, which belongs to a square of 2^32, to this square.
fn relock_scaled(square: u32, word: u32) -> u32 {
    return high_word(add_wide(mul_wide(square, word), wide(HALF, 0u)));
}

//#if RELOCK_BY_FREQUENCY
// Subtracts the compensation by frequency. The beat counts up in the first half of a tick and down in the second; whole
// periods of both are counted.
fn less_by_frequency(
    address: Address,
    switch_number: u32,
    square: u32,
    wrong: u32,
    before: array<u32, RELOCK_TICKS>,
) -> array<u32, RELOCK_TICKS> {
    let one = EXP2_ONE;
    let counted = p[RELOCK + RELOCK_COUNTED];
    let half = p[RELOCK + RELOCK_HALF_BIAS];
    let bias = half << 1u;
    let assumed = bias + bits_from(mul_wide(bias, wrong), WRONG_BITS);
    var left = before;
    var phase = draw(address, FOR_RELOCK, switch_number * RELOCK_BLOCKS + 1u)[0] & ~counted;
    var first = 0u;
    var first_log = 0u;
    //#for i in 0..RELOCK_TICKS
    {
        let top = phase + half - relock_scaled(square, p[RELOCK + RELOCK_LOST_FIRST + i]);
        let end = top - half + relock_scaled(square, p[RELOCK + RELOCK_LOST_SECOND + i]);
        let error = ((top & counted) << 1u) - (phase & counted) - (end & counted) - assumed;
        phase = end;
        let log = log2_word(max_signed(0u - error, 1u));
        if i == 0u {
            first = error;
            first_log = log;
        } else {
            let decay = mulhi(max_signed(first_log - log, 1u), EXP2_ONE / max(i, 1u));
            let q = exp2_minus(max_signed(decay, 1u));
            let angle = relock_power(log + log2_word(one - q) - log2_word(one + q) + p[RELOCK + RELOCK_BEAT_LOG], LOG_BITS);
            let decays = sar(error, 31u) & sar(first - error, 31u);
            left[i] = left[i] - with_sign(angle & decays, p[RELOCK + RELOCK_SIGN]);
        }
    }
    //#end
    return left;
}
//#end

//#if RELOCK_BY_DETUNING
// Subtracts the compensation by detuning, from the mean detunings over the halves of a tick as an ADC reports them.
fn less_by_detuning(
    address: Address,
    switch_number: u32,
    miss: u32,
    wrong: u32,
    before: array<u32, RELOCK_TICKS>,
) -> array<u32, RELOCK_TICKS> {
    let one = EXP2_ONE;
    var left = before;
    var noise: vec4<u32>;
    //#for i in 0..RELOCK_TICKS
    {
        if i % 2u == 0u {
            noise = draw(address, FOR_RELOCK, switch_number * RELOCK_BLOCKS + 2u + i / 2u);
        }
        let plus = relock_shown(miss, p[RELOCK + RELOCK_MEAN_FIRST + i], noise[2u * (i % 2u)]);
        let minus = relock_shown(miss, p[RELOCK + RELOCK_MEAN_SECOND + i], noise[2u * (i % 2u) + 1u]);
        let first = with_sign(plus, plus);
        let second = with_sign(minus, minus);
        let log = log2_word(max_signed(first, 1u));
        let decay = max_signed(log - log2_word(max_signed(second, 1u)), 1u);
        let half_log = log + (log2_word(decay) >> 1u) + log2_word(one + exp2_minus(decay)) + p[RELOCK + RELOCK_DETUNING_LOG];
        let plain = relock_power(half_log, LOG_BITS - 1u);
        let angle = bits_from(mul_wide(plain, (1u << WRONG_BITS) + wrong), WRONG_BITS);
        let decays = sar(second - first, 31u) & sar(0u - second, 31u);
        let alike = ~sar(plus ^ minus, 31u);
        left[i] = left[i] - with_sign(angle & decays & alike, p[RELOCK + RELOCK_SIGN]);
    }
    //#end
    return left;
}

// A mean detuning with noise, rounded to the step of the ADC.
fn relock_shown(miss: u32, mean: u32, noise: u32) -> u32 {
    var sum = mul_wide(miss << 1u, mean);
    sum = add_wide(sum, mul_wide(normal(noise), p[RELOCK + RELOCK_ADC_SIGMA]));
    sum = add_wide(sum, wide(HALF, 0u));
    return (high_word(sum) + p[RELOCK + RELOCK_ADC_HALF]) & p[RELOCK + RELOCK_ADC_SHOWN];
}
//#end

// 2 to the power of `log`, which has `bits` fractional bits; 1 where `log` is negative.
fn relock_power(log: u32, bits: u32) -> u32 {
    let some = min(max_signed(log, 0u), (32u << bits) - 1u);
    return exp2_fraction(some << (32u - bits)) >> (31u - (some >> bits));
}
