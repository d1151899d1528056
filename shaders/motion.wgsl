// Motion of the base in one trial: the angles through which it turns in the gap and in the ticks on either side.
// Twin of crates/kernel/src/motion.rs. Angles are in 2^-32 LSB until they are rounded; ticks are counted outward from the gap.

struct Motion {
    tone: array<vec2<u32>, TONE_ROOM>,
    peak: array<u32, TONE_ROOM>,
    half_turn: array<u32, TONE_ROOM>,
    start: u32,
}

//#if GAUSSIAN
// The normal numbers of the Gaussian motion; not part of Motion, which is passed by value.
var<private> gaussian: array<u32, GAUSSIANS>;
//#end

fn draw_motion(address: Address, first: vec4<u32>) -> Motion {
    var motion: Motion;
    var block = first;
    //#for t in 0..TONES
    if t > 0u && t % 2u == 0u {
        block = draw(address, FOR_NOISE_AFTER_AND_PHASE, t / 2u);
    }
    {
        let phase = p[PHASE + t] + (block[2u + t % 2u] & p[PHASE_SPREAD + t]);
        motion.tone[t] = vec2<u32>(sine(phase), sine(phase + QUARTER_TURN));
        //#if DRAWN
        let words = draw(address, FOR_TONE, t);
        //#if AMPLITUDES
        motion.tone[t] = with_amplitude(motion.tone[t], words, t);
        //#end
        //#if FREQUENCIES
        let turn = p[FREQUENCY_LOW + t] + mulhi(words[2], p[FREQUENCY_WIDTH + t]);
        motion.half_turn[t] = turn * p[FREQUENCY_SCALE + t];
        motion.peak[t] = peak_of(turn, motion.half_turn[t], t);
        //#end
        //#end
    }
    //#end
    //#if GAUSSIAN
    draw_gaussian(address);
    //#end
    //#if PROFILE
    //#if EVERY
    let position = in_turn(address.low);
    //#else
    let position = mulhi(draw(address, FOR_POSITION, 0u)[0], p[POSITIONS]);
    //#end
    motion.start = position + MARGIN;
    //#end
    return motion;
}

// The true angle over the ticks of the gap up to and including that of `row`, in LSB.
fn gap(motion: Motion, row: u32) -> u32 {
    var angle = wide(HALF, 0u);
    //#for t in 0..TONES
    {
        //#if FREQUENCIES
        let factor = gap_factors(motion, row, t);
        //#else
        //#if IN_GAP
        let factor = vec2<u32>(p[GAP_SIN + row * TONES + t], p[GAP_COS + row * TONES + t]);
        //#else
        let factor = vec2<u32>(p[GAP_SIN + row * TONES + t], 0u);
        //#end
        //#end
        angle = add_wide(angle, mul_wide(motion.tone[t].x, factor.x));
        //#if IN_GAP
        angle = add_wide(angle, mul_wide(motion.tone[t].y, factor.y));
        //#end
    }
    //#end
    //#if CONSTANTS
    angle = add_wide(angle, constant(GAP_CONSTANT, row));
    //#end
    //#if GAUSSIAN
    for (var i = 0u; i < GAP_TICKS; i++) {
        angle = add_wide(angle, mul_wide(gaussian[i], table_word(MOTION_TABLE + row * GAP_TICKS + i)));
    }
    //#end
    //#if PROFILE
    //#if IN_GAP
    let length = row + 1u;
    //#else
    let length = p[GAP_LENGTH];
    //#end
    return high_word(angle) + profile(motion.start + length) - profile(motion.start);
    //#else
    return high_word(angle);
    //#end
}

// The angles of the k-th tick before and after the gap without the profile, in 2^-32 LSB and with half an LSB added.
struct Side {
    before: Wide,
    after: Wide,
}

fn side_motion(motion: Motion, k: u32) -> Side {
    var even = wide(HALF, 0u);
    var odd = wide(0u, 0u);
    //#for t in 0..TONES
    {
        //#if FREQUENCIES
        let factor = side_factors(motion, k, t);
        //#else
        let factor = vec2<u32>(p[SIDE_SIN + k * TONES + t], p[SIDE_COS + k * TONES + t]);
        //#end
        even = add_wide(even, mul_wide(motion.tone[t].x, factor.x));
        odd = add_wide(odd, mul_wide(motion.tone[t].y, factor.y));
    }
    //#end
    var angles = Side(sub_wide(even, odd), add_wide(even, odd));
    //#if CONSTANTS
    if k < BEFORE {
        angles.before = add_wide(angles.before, constant(BEFORE_CONSTANT, k));
    }
    if k < AFTER {
        angles.after = add_wide(angles.after, constant(AFTER_CONSTANT, k));
    }
    //#end
    //#if GAUSSIAN
    if k < BEFORE {
        angles.before = add_wide(angles.before, gaussian_side(GAP_TICKS + 2u * k + 1u));
    }
    if k < AFTER {
        angles.after = add_wide(angles.after, gaussian_side(GAP_TICKS + 2u * k));
    }
    //#end
    return angles;
}

//#if PROFILE
// The angles of the k-th tick before and after the gap in the profile, in LSB.
fn profile_side(motion: Motion, k: u32) -> vec2<u32> {
    let end = motion.start + p[GAP_LENGTH] + k;
    let start = motion.start - k;
    return vec2<u32>(profile(start) - profile(start - 1u), profile(end + 1u) - profile(end));
}
//#end

//#if FREQUENCIES
// The angle of tone t, whose frequency is drawn, over the gap up to `row`, as factors of the sine and cosine at the
// middle.
fn gap_factors(motion: Motion, row: u32, t: u32) -> vec2<u32> {
    let n = p[GAP_LENGTH];
    var sum = vec2<u32>();
    //#if IN_GAP
    let count = row + 1u;
    //#else
    let count = n;
    //#end
    for (var i = 0u; i < count; i++) {
        sum += factors(motion, t, 2u * i + 1u - n);
    }
    return sum;
}

// The same factors for the k-th tick after the gap.
fn side_factors(motion: Motion, k: u32, t: u32) -> vec2<u32> {
    return factors(motion, t, p[GAP_LENGTH] + 1u + 2u * k);
}

// The same factors for a tick whose middle lies `half_ticks` half ticks after that of the gap.
fn factors(motion: Motion, t: u32, half_ticks: u32) -> vec2<u32> {
    let turn = motion.half_turn[t] * half_ticks;
    return vec2<u32>(
        high_word(add_wide(mul_wide(motion.peak[t], sine(turn + QUARTER_TURN)), wide(HALF, 0u))),
        high_word(add_wide(mul_wide(motion.peak[t], sine(turn)), wide(HALF, 0u))),
    );
}
//#end

//#if GAUSSIAN
// Draws the normal numbers of the Gaussian motion: those of the gap, then outward, alternately after and before it.
fn draw_gaussian(address: Address) {
    var after: vec4<u32>;
    var before: vec4<u32>;
    for (var i = 0u; i < GAP_TICKS; i++) {
        if i % 4u == 0u {
            after = draw(address, FOR_GAUSSIAN_GAP, i / 4u);
        }
        gaussian[i] = normal(after[i % 4u]);
    }
    for (var k = 0u; k < SIDES; k++) {
        if k % 4u == 0u {
            after = draw(address, FOR_GAUSSIAN_AFTER, k / 4u);
            before = draw(address, FOR_GAUSSIAN_BEFORE, k / 4u);
        }
        gaussian[GAP_TICKS + 2u * k] = normal(after[k % 4u]);
        gaussian[GAP_TICKS + 2u * k + 1u] = normal(before[k % 4u]);
    }
}

// The Gaussian motion of a tick on the side: its row of the factor times the normal numbers up to its own.
fn gaussian_side(place: u32) -> Wide {
    let row = GAUSSIAN_SIDES + (place * (place + 1u) - GAP_TICKS * (GAP_TICKS + 1u)) / 2u;
    var angle = wide(0u, 0u);
    for (var i = 0u; i <= place; i++) {
        angle = add_wide(angle, mul_wide(gaussian[i], table_word(row + i)));
    }
    return angle;
}
//#end

//#if PROFILE
// The angle of the profile since its start, at a boundary of its ticks.
fn profile(boundary: u32) -> u32 {
    return table_word(MOTION_TABLE + boundary);
}
//#end

//#if AMPLITUDES
// A tone with its own amplitude: a fraction of the largest one, or Rayleigh-distributed.
fn with_amplitude(tone: vec2<u32>, words: vec4<u32>, t: u32) -> vec2<u32> {
    let part = p[AMPLITUDE_LOW + t] + mulhi(words[0], p[AMPLITUDE_WIDTH + t]);
    let rayleigh = p[RAYLEIGH + t];
    return vec2<u32>(amplitude(tone.x, words[0], part, rayleigh), amplitude(tone.y, words[1], part, rayleigh));
}

// A fraction `part` of `tone`, or the normal number of `word` where all bits of `rayleigh` are set.
fn amplitude(tone: u32, word: u32, part: u32, rayleigh: u32) -> u32 {
    let scaled = bits_from(add_wide(mul_wide(tone, part), wide(1u << (AMPLITUDE_BITS - 1u), 0u)), AMPLITUDE_BITS);
    return scaled ^ ((scaled ^ normal(word)) & rayleigh);
}
//#end

//#if FREQUENCIES
// The angle of a tick at the peak of the rate, in 2^-4 LSB, for a frequency of `turn` times its scale, which is
// `half_turn` without whole turns.
fn peak_of(turn: u32, half_turn: u32, t: u32) -> u32 {
    var of_rate = sine_ratio(turn << 1u);
    // sinc 2x = sinc x * cos(pi x), from the frequency over its scale up.
    var half = turn;
    for (var doublings = p[FREQUENCY_SCALE + t] >> 1u; doublings > 0u; doublings >>= 1u) {
        let cos = sine((half + QUARTER_TURN) & HALF_TURN_MASK);
        of_rate = mulhi(of_rate, cos << 1u) << 1u;
        half <<= 1u;
    }
    let of_angle = sine(half_turn & HALF_TURN_MASK) << 1u;
    let ratio = of_rate ^ ((of_rate ^ of_angle) & p[OF_ANGLE + t]);
    return with_sign(mulhi(p[PEAK + t], ratio), half_turn);
}
//#end

//#if PROFILE
// The trial number modulo the number of positions.
fn in_turn(trial: u32) -> u32 {
    let positions = p[POSITIONS];
    let rest = trial - mulhi(trial, p[POSITIONS_INVERSE]) * positions;
    // The quotient may be too small by one.
    let less = rest - positions;
    return less + (sar(less, 31u) & positions);
}
//#end

//#if CONSTANTS
// A constant in 2^-32 LSB from its two words.
fn constant(words: u32, k: u32) -> Wide {
    return wide(p[words + 2u * k], p[words + 2u * k + 1u]);
}
//#end
