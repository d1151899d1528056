// Allan variances of synthetic records of a gyro at rest. Twin of crates/kernel/src/allan.rs.

//#if TABLE
// The angles common to all records, where there are any.
@group(0) @binding(5) var<storage, read> table: array<u32>;
//#end

// Only here to the end: parameters and state that are structures in Rust.
fn flicker_sigma(octave: u32) -> u32 {
    return p.flicker[octave / 4u][octave % 4u];
}

fn load_state() {
    noise = Noise(kept_wide(0u), kept(2u), kept_wide(3u), kept_wide(5u), kept(7u), kept_wide(8u), kept(10u));
    //#if FLICKER_HOLDS
    for (var i = STREAMS; i < OCTAVES * STREAMS; i += 1u) {
        holds[i] = Hold(kept(STATE_WORDS + HOLD_WORDS * i), kept(STATE_WORDS + HOLD_WORDS * i + 1u), kept(STATE_WORDS + HOLD_WORDS * i + 2u));
    }
    //#end
}

fn store_state() {
    keep_wide(0u, noise.angle);
    keep(2u, noise.flicker);
    keep_wide(3u, noise.walk);
    keep_wide(5u, noise.markov);
    keep(7u, noise.phase);
    keep_wide(8u, noise.residuals);
    keep(10u, noise.start);
    //#if FLICKER_HOLDS
    for (var i = STREAMS; i < OCTAVES * STREAMS; i += 1u) {
        keep(STATE_WORDS + HOLD_WORDS * i, holds[i].value);
        keep(STATE_WORDS + HOLD_WORDS * i + 1u, holds[i].change);
        keep(STATE_WORDS + HOLD_WORDS * i + 2u, holds[i].grid);
    }
    //#end
}
