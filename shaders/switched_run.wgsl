// One run of a gyro that switches modes: the error of its angle at the end, at its largest, and at chosen times.
// Twin of crates/kernel/src/switched_run.

// The warm-up of a run whose time constant is drawn: A in 2^−32 LSB per unit of time; τ relative to the nominal one and
// the nominal one relative to τ, 2^−26; τ tanh(MT/2τ); e^{−t/τ} at the last switch, 2^−30.
struct WarmUp {
    heated: u32,
    ratio: u32,
    inverse: u32,
    tanh: u32,
    last: u32,
}

// The random state of a run: deviations of A, Ω_m0, Ω_nm in standard deviations, 2^−28; the mode, negative where the
// run starts in the other one; the phase of each tone at the next switch; the sum of all random parts so far, 2^−32
// LSB; the sum of the effects of relocking so far, LSB; and the relative error of f0 in the temperature curve.
struct Run {
    deviation: vec3<u32>,
    mode: u32,
    phase: array<u32, TONE_ROOM>,
    random: Wide,
    relocked: u32,
    wrong: u32,
    warm_up: WarmUp,
}

fn start(address: Address) -> Run {
    var run: Run;
    run.random = wide(0u, 0u);
    run.warm_up.last = DECAY_ONE;
    //#if SPREAD
    let words = draw(address, FOR_RUN_DEVIATION, 0u);
    run.deviation = vec3<u32>(normal(words[0]), normal(words[1]), normal(words[2]));
    run.mode = words[3];
    //#end
    //#if WARM_UP
    run.warm_up = warm_up(run.deviation[0], normal(draw(address, FOR_RUN_DEVIATION, 1u)[0]));
    //#end
    //#if RELOCKING
    run.wrong = relock_wrong(address);
    //#end
    //#for block in 0..PHASE_BLOCKS
    {
        let phases = draw(address, FOR_RUN_PHASE, block);
        for (var t = 4u * block; t < min(TONES, 4u * block + 4u); t++) {
            run.phase[t] = phases[t % 4u] & p[RUN_SPREAD + t];
        }
    }
    //#end
    return run;
}

//#if WARM_UP
// The warm-up of a run from the deviations of its A and its ln τ.
fn warm_up(magnetic: u32, time: u32) -> WarmUp {
    // The factor between a drawn τ and the nominal one is at most 2^5.
    let five = MAX_STRETCH << LOG_BITS;
    let log = high_word(mul_wide(time, p[WARM_UP_SPREAD]));
    let ratio = exp2_minus(five - log);
    let inverse = exp2_minus(five + log);
    let lost = exp2_minus(halvings(inverse, p[HALVINGS]));
    let one = EXP2_ONE;
    // log2 of τ (1 − q)/(1 + q) with q = e^{−MT/τ}; then 2^x is computed as 2^31 · 2^−(31 − x).
    let tanh = log + log2_word(one - lost) - log2_word(one + lost) + ((LOG_BITS + p[TIME_BITS]) << LOG_BITS);
    let heated = p[HEATED] + bits_from(mul_wide(magnetic, p[HEATED + 1u]), NORMAL_BITS);
    return WarmUp(heated, ratio, inverse, exp2_minus(MAX_MINUS - tanh), DECAY_ONE);
}

// Converts a number of halvings of the nominal τ to halvings of this τ, 2^−26, at most 31.
fn halvings(inverse: u32, usual: u32) -> u32 {
    let bits = p[HALVING_BITS];
    let product = mul_wide(inverse, usual);
    let within = sar(high_word(product) - (MAX_HALVINGS << (bits - (32u - LOG_BITS))), 31u);
    return (bits_from(product, bits) & within) + (MAX_MINUS & (within ^ 0xffffffffu));
}

// ∫ s (1 − e^{−t/τ}) dt at a row of the table in interval `k`, and e^{−t/τ} there; `words` is the place of the last two
// words of the row.
fn heating(warm_up: WarmUp, k: u32, words: u32) -> vec2<u32> {
    let bits = p[TIME_BITS];
    let now = exp2_minus(halvings(warm_up.inverse, table_word(words + 1u))) >> 1u;
    let one = DECAY_ONE;
    let even = k % 2u == 0u;
    let signed = select(0u - warm_up.last, warm_up.last, even);
    let pairs = bits_from(mul_wide(warm_up.tanh, one - signed), DECAY_BITS);
    let rest = bits_from(mul_wide(warm_up.ratio, warm_up.last - now), DECAY_BITS - bits);
    let decayed = select(pairs - rest, pairs + rest, even);
    return vec2<u32>(table_word(words) - decayed, now);
}
//#end

// The angle at a row of the table in interval `k`, with the random part `more` added since the last switch; `words` is
// the place of the row.
fn angle(run: Run, k: u32, words: u32, more: Wide) -> u32 {
    var random = add_wide(add_wide(run.random, more), wide(HALF, 0u));
    var magnetic = wide(0u, 0u);
    var at = words + 1u;
    //#if MODE
    at++;
    //#end
    //#if MAGNETIC
    magnetic = add_wide(magnetic, mul_wide(run.deviation[0], table_word(at)));
    at++;
    //#end
    //#if INITIAL
    magnetic = add_wide(magnetic, mul_wide(run.deviation[1], table_word(at)));
    at++;
    //#end
    //#if NON_MAGNETIC
    random = add_wide(random, mul_wide(run.deviation[2], table_word(at)));
    at++;
    //#end
    //#if WARM_UP
    magnetic = add_wide(magnetic, mul_wide(heating(run.warm_up, k, at)[0], run.warm_up.heated));
    //#end
    //#if MODE
    let whole = high_word(magnetic) + table_word(words + 1u);
    return table_word(words) + run.relocked + high_word(random) + with_sign(whole, run.mode);
    //#else
    return table_word(words) + run.relocked + high_word(add_wide(random, magnetic));
    //#end
}

// The residual of the switch after interval `k`, 2^−32 LSB; `words` are those of the interval.
fn residual(run: ptr<function, Run>, address: Address, k: u32, words: vec4<u32>) -> Wide {
    var residual = wide(p[CONSTANT], p[CONSTANT + 1u]);
    //#if NOISE
    residual = add_wide(residual, mul_wide(normal(words[1]), p[NOISE]));
    //#end
    var more = words;
    //#for t in 0..TONES
    {
        if t >= 2u && t % 4u == 2u {
            more = draw_beyond(address, FOR_SWITCH_PHASE, t / 4u, k);
        }
        let drawn = more[(t + 2u) % 4u] & p[SWITCH_SPREAD + t];
        residual = add_wide(residual, mul_wide(sine((*run).phase[t] + drawn), p[AMPLITUDE + t]));
        (*run).phase[t] += p[PHASE_STEP + t];
    }
    //#end
    return residual;
}

//#if RELOCKING
// The effect of relocking after the switch that ends interval `k`, LSB: the ticks themselves and their effect on the
// filler.
fn relocked(run: Run, address: Address, k: u32) -> u32 {
    var left = relock_ticks(address, k, run.wrong);
    let bits = p[RELOCK_BITS];
    var sum = wide(1u << (bits - 1u), 0u);
    //#for i in 0..RELOCK_TICKS
    sum = add_wide(sum, mul_wide(left[i], p[RELOCK_WEIGHT + i]));
    //#end
    return bits_from(sum, bits);
}
//#end

fn trial(low: u32, high: u32) -> array<u32, ESTIMATES> {
    let address = Address(low, high, schedule(vec2<u32>(p[KEY], p[KEY + 1u])));
    let intervals = p[INTERVALS];
    var run = start(address);
    var error: array<u32, ESTIMATES>;
    let nothing = wide(0u, 0u);
    //#if ANY_END
    let end = (intervals + TIMES) * ROW + (draw(address, FOR_RUN_END, 0u)[0] >> (32u - END_BITS)) * END_ROW;
    let end_interval = table_word(end + ROW);
    //#end
    for (var k = 0u; k < intervals; k++) {
        let words = draw(address, FOR_INTERVAL, k);
        let is_last = k + 1u == intervals;
        //#if WALK
        let step = normal(words[0]);
        //#end
        //#for t in 0..TIMES
        if p[TIME_INTERVAL + t] == k {
            var part = nothing;
            //#if WALK
            let bridge = normal(draw(address, FOR_BRIDGE, k)[0]);
            part = add_wide(mul_wide(step, p[TIME_WALK + t]), mul_wide(bridge, p[TIME_BRIDGE + t]));
            //#end
            error[FIRST_TIME + t] = angle(run, k, (intervals + t) * ROW, part);
        }
        //#end
        // A run that ends before the end of this interval has no angle there.
        var counts = 0xffffffffu;
        //#if ANY_END
        // The ends lie in the last three intervals.
        if k + 3u >= intervals {
            counts = sar(k - end_interval, 31u);
        }
        if k + 3u >= intervals && k == end_interval {
            var part = nothing;
            //#if WALK
            let bridge = normal(draw(address, FOR_BRIDGE, k)[0]);
            part = add_wide(mul_wide(step, table_word(end + ROW + 1u)), mul_wide(bridge, table_word(end + ROW + 2u)));
            //#end
            error[0] = angle(run, k, end, part);
            error[1] = max_signed(error[1], with_sign(error[0], error[0]));
        }
        //#end
        //#if WALK
        run.random = add_wide(run.random, mul_wide(step, select(p[WALK_SIGMA], p[WALK_SIGMA + 1u], is_last)));
        //#end
        let before = angle(run, k, k * ROW, nothing);
        //#if ENDS
        //#if ANY_END
        //#else
        error[0] = before;
        //#end
        error[1] = max_signed(error[1], with_sign(before, before) & counts);
        //#end
        if !is_last {
            run.random = add_wide(run.random, residual(&run, address, k, words));
            //#if RELOCKING
            run.relocked += relocked(run, address, k);
            //#end
            //#if ENDS
            let after = angle(run, k, k * ROW, nothing);
            error[1] = max_signed(error[1], with_sign(after, after) & counts);
            //#end
            //#if WARM_UP
            run.warm_up.last = heating(run.warm_up, k, (k + 1u) * ROW - 2u)[1];
            //#end
        }
    }
    return error;
}
