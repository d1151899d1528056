// One run of a gyro that switches modes: the angle that it has wrong at the end, at most, and at chosen times.
// Twin of kernel/src/switched_run.

// The warm-up of a run, whose time constant is drawn: A, 2^−32 LSB in a unit of time; τ as a part of the usual one and what the
// usual one is of it, 2^−26; τ tanh(MT/2τ); e^{−t/τ} at the last switch, 2^−30.
struct WarmUp {
    heated: u32,
    ratio: u32,
    inverse: u32,
    tanh: u32,
    last: u32,
}

// What is drawn once for a run: deviations of A, Ω_m0, Ω_nm in standard deviations, 2^−28; negative where the first mode is the
// other one; phase of each tone at the next switch; all that is random so far, 2^−32 LSB; what relocking has added so
// far, LSB; by how much the temperature curve has f0 wrong.
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
// The warm-up of a run whose A and ln τ deviate by so much.
fn warm_up(magnetic: u32, time: u32) -> WarmUp {
    // No draw makes τ more than 2^5 times longer or shorter.
    let five = MOST_STRETCH << LOG_BITS;
    let log = high_word(mul_wide(time, p[WARM_UP_SPREAD]));
    let ratio = exp2_minus(five - log);
    let inverse = exp2_minus(five + log);
    let lost = exp2_minus(halvings(inverse, p[HALVINGS]));
    let one = EXP2_ONE;
    // log2 of τ (1 − q)/(1 + q), q = e^{−MT/τ}; then 2^x is 2^31 of 2^−(31 − x).
    let tanh = log + log2_word(one - lost) - log2_word(one + lost) + ((LOG_BITS + p[TIME_BITS]) << LOG_BITS);
    let heated = p[HEATED] + bits_from(mul_wide(magnetic, p[HEATED + 1u]), NORMAL_BITS);
    return WarmUp(heated, ratio, inverse, exp2_minus(LARGEST_MINUS - tanh), DECAY_ONE);
}

// A number of halvings of the usual τ as that of this τ, 2^−26, at most 31.
fn halvings(inverse: u32, usual: u32) -> u32 {
    let bits = p[HALVING_BITS];
    let product = mul_wide(inverse, usual);
    let within = sar(high_word(product) - (MOST_HALVINGS << (bits - (32u - LOG_BITS))), 31u);
    return (bits_from(product, bits) & within) + (LARGEST_MINUS & (within ^ 0xffffffffu));
}

// ∫ s (1 − e^{−t/τ}) dt where a row of the table is, whose last two words are at `words`, in interval `k`; and e^{−t/τ} there.
fn heating(warm_up: WarmUp, k: u32, words: u32) -> vec2<u32> {
    let bits = p[TIME_BITS];
    let now = exp2_minus(halvings(warm_up.inverse, table[words + 1u])) >> 1u;
    let one = DECAY_ONE;
    let even = k % 2u == 0u;
    let signed = select(0u - warm_up.last, warm_up.last, even);
    let pairs = bits_from(mul_wide(warm_up.tanh, one - signed), DECAY_BITS);
    let rest = bits_from(mul_wide(warm_up.ratio, warm_up.last - now), DECAY_BITS - bits);
    let decayed = select(pairs - rest, pairs + rest, even);
    return vec2<u32>(table[words] - decayed, now);
}
//#end

// The angle where a row of the table is, in interval `k`, with `more` that is random since the last switch.
fn angle(run: Run, k: u32, row: u32, more: Wide) -> u32 {
    let words = row * ROW;
    var random = add_wide(add_wide(run.random, more), wide(HALF, 0u));
    var magnetic = wide(0u, 0u);
    var at = words + 1u;
    //#if MODE
    at++;
    //#end
    //#if MAGNETIC
    magnetic = add_wide(magnetic, mul_wide(run.deviation[0], table[at]));
    at++;
    //#end
    //#if INITIAL
    magnetic = add_wide(magnetic, mul_wide(run.deviation[1], table[at]));
    at++;
    //#end
    //#if NON_MAGNETIC
    random = add_wide(random, mul_wide(run.deviation[2], table[at]));
    at++;
    //#end
    //#if WARM_UP
    magnetic = add_wide(magnetic, mul_wide(heating(run.warm_up, k, at)[0], run.warm_up.heated));
    //#end
    //#if MODE
    let whole = high_word(magnetic) + table[words + 1u];
    return table[words] + run.relocked + high_word(random) + with_sign(whole, run.mode);
    //#else
    return table[words] + run.relocked + high_word(add_wide(random, magnetic));
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
// What relocking after the switch that ends interval `k` adds, LSB: the ticks themselves, and what they do to the filler.
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
            error[FIRST_TIME + t] = angle(run, k, intervals + t, part);
        }
        //#end
        //#if WALK
        run.random = add_wide(run.random, mul_wide(step, select(p[WALK_SIGMA], p[WALK_SIGMA + 1u], is_last)));
        //#end
        let before = angle(run, k, k, nothing);
        //#if ENDS
        error[0] = before;
        error[1] = max_signed(error[1], with_sign(before, before));
        //#end
        if !is_last {
            run.random = add_wide(run.random, residual(&run, address, k, words));
            //#if RELOCKING
            run.relocked += relocked(run, address, k);
            //#end
            //#if ENDS
            let after = angle(run, k, k, nothing);
            error[1] = max_signed(error[1], with_sign(after, after));
            //#end
            //#if WARM_UP
            run.warm_up.last = heating(run.warm_up, k, (k + 1u) * ROW - 2u)[1];
            //#end
        }
    }
    return error;
}
