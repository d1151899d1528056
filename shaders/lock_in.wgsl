// A ring laser gyro with lock-in and dither: the angle by which its output departs from the input.
// Twin of crates/kernel/src/lock_in, which describes the method.

//#if TABLE
@group(0) @binding(5) var<storage, read> table: array<u32>;
//#end

// State carried from chunk to chunk.
struct LockIn {
    angle: Wide,
    start: u32,
    amplitude: u32,
    walk: Wide,
    phase: u32,
    first_third: Wide,
    last_third: Wide,
    number: u32,
    at: u32,
    left: u32,
    input: Wide,
    rate: Wide,
    sample_phase: Wide,
}

var<private> gyro: LockIn;

fn begin() {
    let nothing = wide(0u, 0u);
    let start = draw_beyond(address, FOR_OWN, 1u, 0u).x;
    let rate = wide(p.rate_low, p.rate_high);
    gyro = LockIn(nothing, start, 0u, nothing, 0u, nothing, nothing, 0u, 0u, 0u, nothing, rate, nothing);
    begin_half();
}

// Computes the angles of the chunk that starts at sample `first`.
fn chunk(first: u32) {
    for (var i = 0u; i < CHUNK; i += 1u) {
        let sample = first + i;
        if sample > p.samples {
            return;
        }
        let angle = reading();
        angles[i] = angle;
        if sample < p.third {
            gyro.first_third = add_wide(gyro.first_third, mul_wide(angle, 1u));
        }
        if sample > p.samples - p.third {
            gyro.last_third = add_wide(gyro.last_third, mul_wide(angle, 1u));
        }
        advance();
    }
}

// The angle of a sample.
fn reading() -> u32 {
    var exact = gyro.angle;
    //#if ENDS
    exact = add_wide(exact, mul_wide(end(), 1u));
    //#end
    let angle = bits_from(exact, p.lsb);
    //#if DITHERED
    var amplitude = gyro.amplitude;
    //#if DEMODULATED
    amplitude -= with_sign(p.amplitude, gyro.number << 31u);
    //#end
    let turn = high_word(gyro.sample_phase) & 0x7fffffffu;
    let dither = add_wide(mul_wide(amplitude, sine(with_noise(turn, sine(turn) << 1u))), wide(0x80000000u, 0u));
    return angle + sar(high_word(dither), p.dither_lsb);
    //#else
    return angle;
    //#end
}

//#if ENDS
// What the integral up to a zero crossing has beyond the sum of steps that ends there.
fn end() -> u32 {
    let phase = bits_from(gyro.angle, p.fine) + gyro.start + high_word(gyro.input);
    return high_word(mul_wide(sine(phase + QUARTER_TURN), p.end));
}
//#end

// A phase within the half-cycle with its noise; `sin` is its sine, 2^-31.
fn with_noise(turn: u32, sin: u32) -> u32 {
    //#if PHASE_NOISE
    return turn + bits_from(mul_wide(gyro.phase, sin), 31u);
    //#else
    return turn;
    //#end
}

// Goes on to the next sample.
fn advance() {
    let left = gyro.left + p.interval_fraction;
    var to_go = p.interval + select(0u, 1u, left < gyro.left);
    gyro.left = left;
    gyro.sample_phase = add_wide(gyro.sample_phase, wide(p.sample_phase_low, p.sample_phase_high));
    while to_go > 0u {
        let run = min(to_go, p.half_rounds - gyro.at);
        rounds(run);
        to_go -= run;
        if gyro.at == p.half_rounds {
            gyro.number += 1u;
            gyro.at = 0u;
            gyro.rate = add_wide(gyro.rate, wide(p.ramp_low, p.ramp_high));
            begin_half();
        }
    }
}

// Draws what is random in a half-cycle.
fn begin_half() {
    //#if RANDOM
    let words = draw(address, FOR_OWN, gyro.number);
    //#end
    var amplitude = p.amplitude;
    //#if AMPLITUDE_NOISE
    amplitude += high_word(mul_wide(normal(words.x), p.amplitude_noise));
    //#end
    //#if AMPLITUDE_WALK
    gyro.walk = add_wide(gyro.walk, mul_wide(normal(words.y), p.amplitude_walk));
    amplitude += high_word(gyro.walk);
    //#end
    gyro.amplitude = with_sign(amplitude, gyro.number << 31u);
    //#if PHASE_NOISE
    gyro.phase = high_word(mul_wide(normal(words.z), p.phase_noise));
    //#end
    //#if BEAM
    let noise = add_wide(mul_wide(normal(words.w), p.beam), wide(0x80000000u, 0u));
    gyro.angle = add_wide(gyro.angle, mul_wide(high_word(noise), 1u));
    //#end
}

// Makes some rounds of steps of one half-cycle.
fn rounds(count: u32) {
    var rate = gyro.rate;
    //#if MOTION
    rate = add_wide(rate, wide(0u, table[p.motion_start + gyro.number]));
    //#end
    let step = high_word(rate);
    let to_middle = sar(step, 1u);
    let twice = add_wide(rate, rate);
    let four = add_wide(twice, twice);
    let eight = add_wide(four, four);
    let of_round = add_wide(eight, eight);
    for (var round = gyro.at; round < gyro.at + count; round += 1u) {
        let first = round * ROUND;
        var at = bits_from(gyro.angle, p.fine) + gyro.start;
        at += high_word(gyro.input) + to_middle;
        var sum = 0u;
        //#for k in 0..ROUND
        {
            var phase = at + k * step;
            //#if DITHER
            phase += dither(first + k);
            //#end
            sum += kick(phase + sar(sum, p.fine));
        }
        //#end
        gyro.angle = add_wide(gyro.angle, mul_wide(sum, 1u));
        gyro.input = add_wide(gyro.input, of_round);
    }
    gyro.at += count;
}

//#if DITHER
// The dither's angle in the middle of a step of the half-cycle, as a turn word.
fn dither(step: u32) -> u32 {
    let sin = table[step];
    //#if PHASE_NOISE
    let noisy = sine(with_noise(table[p.steps + step], sin));
    return bits_from(mul_wide(gyro.amplitude, noisy), p.amplitude_bits - 2u);
    //#else
    return bits_from(mul_wide(gyro.amplitude, sin), p.amplitude_bits - 1u);
    //#end
}
//#end

// The lock-in of a step at a phase: an odd function of it, bit for bit.
fn kick(phase: u32) -> u32 {
    let half = phase << 1u;
    let mirror = sar(half, 31u);
    let z = (half ^ mirror) - mirror;
    let zz = mulhi(z, z);
    var sum = p.kick_3;
    sum = p.kick_2 - mulhi(sum, zz);
    sum = p.kick_1 - mulhi(sum, zz);
    sum = p.kick_0 - mulhi(sum, zz);
    return with_sign(mulhi(sum, z), phase);
}

// Only here to the end: state and values that are structures in Rust.
fn load_state() {
    gyro = LockIn(
        kept_wide(0u),
        kept(2u),
        kept(3u),
        kept_wide(4u),
        kept(6u),
        kept_wide(7u),
        kept_wide(9u),
        kept(11u),
        kept(12u),
        kept(13u),
        kept_wide(14u),
        kept_wide(16u),
        kept_wide(18u)
    );
}

fn store_state() {
    keep_wide(0u, gyro.angle);
    keep(2u, gyro.start);
    keep(3u, gyro.amplitude);
    keep_wide(4u, gyro.walk);
    keep(6u, gyro.phase);
    keep_wide(7u, gyro.first_third);
    keep_wide(9u, gyro.last_third);
    keep(11u, gyro.number);
    keep(12u, gyro.at);
    keep(13u, gyro.left);
    keep_wide(14u, gyro.input);
    keep_wide(16u, gyro.rate);
    keep_wide(18u, gyro.sample_phase);
    set_value(0u, gyro.first_third);
    set_value(1u, gyro.last_third);
}

// Sets one of the values besides the sums.
fn set_value(k: u32, value: Wide) {
    let at = SUM_WORDS * (PLACES + k) * p.lanes + lane;
    sums[at] = low_word(value);
    sums[at + p.lanes] = high_word(value);
}
