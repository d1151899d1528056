// Synthetic angles of a gyro at rest, chunk by chunk, with white, flicker, random-walk and Markov rate noise, a sine,
// drift, fill residuals and readout.
// Twin of crates/kernel/src/noise.rs, which describes the method.

// One stream of an octave: the newest number, its difference from the one before, and the sample at which records
// switch to it.
struct Hold {
    value: u32,
    change: u32,
    grid: u32,
}

// State carried from chunk to chunk.
struct Noise {
    angle: Wide,
    flicker: u32,
    // In 2^-32 units of the rate; rounded steps would add up to a ramp.
    walk: Wide,
    // In 2^-30 units of the rate.
    markov: Wide,
    phase: u32,
    // In 2^-32 LSB; rounded fill residuals would add up to a drift.
    residuals: Wide,
    start: u32,
}

var<private> noise: Noise;
var<private> holds: array<Hold, HOLD_ROOM>;

fn begin() {
    begin_at(0u);
}

// The state before sample `first`, a multiple of a chunk, except what adds up from sample to sample.
fn begin_at(first: u32) {
    let words = draw(address, FOR_RECORD_START, 0u);
    noise = Noise(wide(0u, 0u), 0u, wide(0u, 0u), wide(0u, 0u), words.y, wide(0u, 0u), 0u);
    //#if PULSE
    noise.start = words.x & ((1u << p.pulse) - 1u);
    //#end
    //#if MARKOV_STEPS
    noise.markov = mul_wide(normal(words.z), p.markov_start);
    //#end
    //#if SINE_WAVE
    noise.phase += p.sine_step * first;
    //#end
    //#if FLICKER_HOLDS
    for (var octave = 1u; octave < OCTAVES; octave += 1u) {
        let grid = draw(address, FOR_FLICKER_GRID, octave);
        // The hold in which the record starts has number 0.
        let number = first >> octave;
        let place = first & ((1u << octave) - 1u);
        let of_block = select(1u, 4u, octave < FOUR_STREAMS);
        let words = draw_beyond(address, FOR_FLICKER, octave, number / of_block);
        // Within a hold the next one is drawn.
        var next = words;
        if place != 0u {
            next = draw_beyond(address, FOR_FLICKER, octave, number + 1u);
        }
        for (var stream = 0u; stream < streams(octave); stream += 1u) {
            let word = stream + number % of_block;
            let before = scaled(words[word], flicker_sigma(octave));
            let value = scaled(next[word], flicker_sigma(octave));
            let hold = Hold(value, value - before, grid[stream] >> (32u - octave));
            // All ones where it has begun.
            let begun = 0u - ((hold.grid - place) >> 31u);
            noise.flicker += before + (hold.change & begun);
            holds[octave * STREAMS + stream] = hold;
        }
    }
    //#end
}

// Computes the angles of the chunk that starts at sample `first`, in place of the changes of its flicker noise.
fn chunk(first: u32) {
    changes(first);
    for (var block = 0u; block < CHUNK / WORDS; block += 1u) {
        let at = first / WORDS + block;
        let white = draw(address, FOR_WHITE, at);
        //#if WALK_STEPS
        let walk = draw(address, FOR_WALK, at);
        //#end
        //#if MARKOV_STEPS
        let markov = draw(address, FOR_MARKOV, at);
        //#end
        //#if QUANTIZATION_NOISE
        let quantization = draw(address, FOR_QUANTIZATION, at);
        //#end
        //#for k in 0..WORDS
        {
            let i = WORDS * block + k;
            //#if FLICKER_HOLDS
            noise.flicker += angles[i];
            //#end
            var rate = noise.flicker;
            //#if WALK_STEPS
            noise.walk = add_wide(noise.walk, mul_wide(normal(walk[k]), p.walk));
            rate += high_word(noise.walk);
            //#end
            //#if MARKOV_STEPS
            let lost = mul_wide(bits_from(noise.markov, 30u), p.markov_loss);
            noise.markov = add_wide(sub_wide(noise.markov, lost), mul_wide(normal(markov[k]), p.markov_step));
            rate += bits_from(noise.markov, 30u);
            //#end
            var angle = high_word(noise.angle);
            let step = add_wide(mul_wide(rate, p.rate_scale), mul_wide(normal(white[k]), p.white));
            noise.angle = add_wide(noise.angle, step);
            //#if QUANTIZATION_NOISE
            angle += scaled(quantization[k], p.quantization);
            //#end
            angles[i] = reading(first + i, angle);
        }
        //#end
    }
}

// Computes the change of flicker noise in each sample.
fn changes(first: u32) {
    //#if FLICKER_HOLDS
    for (var i = 0u; i < CHUNK; i += 1u) {
        angles[i] = 0u;
    }
    short_holds(first);
    for (var octave = LONG_HOLDS; octave < OCTAVES; octave += 1u) {
        long_holds(octave, first);
    }
    //#end
}

// Applies the changes of holds that are shorter than a chunk.
fn short_holds(first: u32) {
    for (var octave = 1u; octave < min(OCTAVES, FOUR_STREAMS); octave += 1u) {
        // Hold 0 contains the start; the hold that begins at h 2^o has the number h + 1.
        let hold = first >> octave;
        var words = draw_beyond(address, FOR_FLICKER, octave, hold / 4u);
        for (var h = 0u; h < (CHUNK >> octave); h += 1u) {
            let number = hold + h + 1u;
            if number % 4u == 0u {
                words = draw_beyond(address, FOR_FLICKER, octave, number / 4u);
            }
            go_over(octave, 0u, scaled(words[number % 4u], flicker_sigma(octave)));
            let hold = holds[octave * STREAMS];
            angles[(h << octave) + hold.grid] += hold.change;
        }
    }
    for (var octave = FOUR_STREAMS; octave < min(OCTAVES, LONG_HOLDS); octave += 1u) {
        for (var h = 0u; h < (CHUNK >> octave); h += 1u) {
            let words = draw_beyond(address, FOR_FLICKER, octave, (first >> octave) + h + 1u);
            for (var stream = 0u; stream < STREAMS; stream += 1u) {
                go_over(octave, stream, scaled(words[stream], flicker_sigma(octave)));
                let hold = holds[octave * STREAMS + stream];
                angles[(h << octave) + hold.grid] += hold.change;
            }
        }
    }
}

// Applies the changes of the holds of an octave that last for a chunk or longer.
fn long_holds(octave: u32, first: u32) {
    let place = first & ((1u << octave) - 1u);
    if place == 0u {
        let words = draw_beyond(address, FOR_FLICKER, octave, (first >> octave) + 1u);
        for (var stream = 0u; stream < STREAMS; stream += 1u) {
            go_over(octave, stream, scaled(words[stream], flicker_sigma(octave)));
        }
    }
    for (var stream = 0u; stream < STREAMS; stream += 1u) {
        let hold = holds[octave * STREAMS + stream];
        let to_go = hold.grid - place;
        if to_go < CHUNK {
            angles[to_go] += hold.change;
        }
    }
}

// Sets the number of the next hold of a stream.
fn go_over(octave: u32, stream: u32, value: u32) {
    let at = octave * STREAMS + stream;
    holds[at].change = value - holds[at].value;
    holds[at].value = value;
}

// Adds drift, fill residuals and sine to the angle of a sample, and reads it in whole pulses.
fn reading(sample: u32, without: u32) -> u32 {
    var angle = without;
    //#if DRIFT
    angle += table[min(sample, p.samples)];
    //#end
    //#if FILL_RESIDUALS
    angle += high_word(noise.residuals);
    if sample > 0u && sample % p.switch_interval == 0u {
        jump(sample / p.switch_interval);
    }
    //#end
    //#if SINE_WAVE
    // The integral of a sine is minus its cosine; the product is in units of 2^-32 LSB.
    let cosine = sine(noise.phase + QUARTER_TURN);
    angle -= high_word(mul_wide(cosine, p.sine_amplitude));
    noise.phase += p.sine_step;
    //#end
    //#if PULSE
    angle = (angle + noise.start) & (0xffffffffu << p.pulse);
    //#end
    return angle;
}

//#if FILL_RESIDUALS
// Adds the fill residual of a switch to all records.
fn jump(number: u32) {
    let words = draw(address, FOR_FILL_RESIDUAL, number);
    let of_phase = mul_wide(sine(words.x), p.residual_amplitude);
    noise.residuals = add_wide(noise.residuals, add_wide(of_phase, mul_wide(normal(words.y), p.residual_noise)));
}
//#end

// Number of streams of an octave.
fn streams(octave: u32) -> u32 {
    return select(STREAMS, 1u, octave < FOUR_STREAMS);
}

// A normal number with a standard deviation `sigma` in 2^-4 units.
fn scaled(word: u32, sigma: u32) -> u32 {
    return high_word(mul_wide(normal(word), sigma));
}
