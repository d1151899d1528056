// One trial of a mode switch: the ticks round the gap, and how far each filler's angle is from the true one.
// Twin of crates/kernel/src/gap_fill.

// Reads motion and noise of the k-th tick on either side of the gap, where the shape has that tick, and adds them to
// the sums.
fn side(run: ptr<function, Run>, motion: Motion, k: u32, noise: vec2<u32>) {
    let angles = side_motion(motion, k);
    //#if PROFILE
    let of_profile = profile_side(motion, k);
    //#else
    let of_profile = vec2<u32>();
    //#end
    if k < BEFORE {
        var reading = high_word(add_wide(angles.before, mul_wide(normal(noise[0]), p[SIGMA]))) + of_profile[0];
        //#if READOUT
        let earlier = (*run).at_start - reading;
        reading = pulses((*run).at_start) - pulses(earlier);
        (*run).at_start = earlier;
        //#end
        //#if IN_GAP
        (*run).kept[k] = reading;
        //#end
        //#for filler in 0..FILLERS
        //#if RESIDUAL
        if k < RESIDUAL_BEFORE {
            (*run).sum[filler] =
                add_tick((*run).sum[filler], reading, p[RESIDUAL_WEIGHT + filler * (RESIDUAL_BEFORE + AFTER) + k]);
        }
        //#end
        //#if EXTRAPOLATION
        if k < EXTRAPOLATION_BEFORE {
            (*run).sum[EXTRAPOLATIONS + filler] = add_tick(
                (*run).sum[EXTRAPOLATIONS + filler],
                reading,
                p[EXTRAPOLATION_WEIGHT + filler * EXTRAPOLATION_BEFORE + k],
            );
        }
        //#end
        //#end
    }
    //#if RESIDUAL
    if k < AFTER {
        var reading = high_word(add_wide(angles.after, mul_wide(normal(noise[1]), p[SIGMA]))) + of_profile[1];
        //#if READOUT
        let later = (*run).at_end + reading;
        reading = pulses(later) - pulses((*run).at_end);
        (*run).at_end = later;
        //#end
        //#for filler in 0..FILLERS
        (*run).sum[filler] = add_tick(
            (*run).sum[filler],
            reading,
            p[RESIDUAL_WEIGHT + filler * (RESIDUAL_BEFORE + AFTER) + RESIDUAL_BEFORE + k],
        );
        //#end
    }
    //#end
}

// State carried from tick to tick: the sums, readings of the ticks before the gap, and the readout.
struct Run {
    sum: array<Sum, ESTIMATES>,
    kept: array<u32, KEPT>,
    at_start: u32,
    at_end: u32,
}

//#if READOUT
// The angle represented by the whole pulses up to `angle`.
fn pulses(angle: u32) -> u32 {
    return angle & p[READOUT_MASK];
}
//#end

fn trial(low: u32, high: u32) -> array<u32, ESTIMATES> {
    let address = Address(low, high, schedule(vec2<u32>(p[KEY], p[KEY + 1u])));

    let first = draw(address, FOR_NOISE_AFTER_AND_PHASE, 0u);
    let motion = draw_motion(address, first);
    let truth = gap(motion, ROWS - 1u);

    var run: Run;
    //#for filler in 0..FILLERS
    //#if RESIDUAL
    run.sum[filler] = less(truth, p[RESIDUAL_SCALE + filler]);
    //#end
    //#if EXTRAPOLATION
    run.sum[EXTRAPOLATIONS + filler] = less(truth, p[EXTRAPOLATION_SCALE + filler]);
    //#end
    //#end
    //#if READOUT
    let words = draw(address, FOR_READOUT, 0u);
    let gap_noise = high_word(add_wide(mul_wide(normal(words[1]), p[GAP_SIGMA]), wide(HALF, 0u)));
    run.at_start = words[0] - pulses(words[0]);
    run.at_end = run.at_start + truth + gap_noise;
    //#end
    var noise_before: vec4<u32>;
    var noise_after = first;
    //#for k in 0..SIDES
    if k % 4u == 0u && k < BEFORE {
        noise_before = draw(address, FOR_NOISE_BEFORE, k / 4u);
    }
    if k % 2u == 0u && 0u < k && k < AFTER {
        noise_after = draw(address, FOR_NOISE_AFTER_AND_PHASE, k / 2u);
    }
    side(&run, motion, k, vec2<u32>(noise_before[k % 4u], noise_after[k % 2u]));
    //#end

    var error: array<u32, ESTIMATES>;
    //#for e in 0..IN_GAPS
    error[e] = error_of(run.sum[e], e);
    //#end
    //#if IN_GAP
    for (var row = 0u; row < GAP_TICKS; row++) {
        let row_truth = gap(motion, row);
        //#for filler in 0..FILLERS
        {
            var sum = less(row_truth, p[IN_GAP_SCALE + filler]);
            for (var k = 0u; k < EXTRAPOLATION_BEFORE; k++) {
                sum = add_tick(sum, run.kept[k], table_word((filler * GAP_TICKS + row) * EXTRAPOLATION_BEFORE + k));
            }
            let found = error_of(sum, IN_GAPS + filler);
            error[IN_GAPS + filler] = max_signed(error[IN_GAPS + filler], with_sign(found, found));
        }
        //#end
    }
    //#end
    return error;
}

// A weighted sum of ticks less the scaled truth, kept in 32 bits where that is enough.
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
