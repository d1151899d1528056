// One trial of a relock: sums over its first ticks of the apparent rotation that remains after compensation.
// Twin of crates/kernel/src/relock.rs.

fn trial(low: u32, high: u32) -> array<u32, ESTIMATES> {
    let address = Address(low, high, schedule(vec2<u32>(p[KEY], p[KEY + 1u])));
    let ticks = relock_ticks(address, 0u, relock_wrong(address));
    var error: array<u32, ESTIMATES>;
    //#for e in 0..ESTIMATES
    {
        var sum = wide(1u << (WEIGHT_BITS - 1u), 0u);
        //#for i in 0..RELOCK_TICKS
        sum = add_wide(sum, mul_wide(ticks[i], p[WEIGHT + e * RELOCK_TICKS + i]));
        //#end
        error[e] = bits_from(sum, WEIGHT_BITS);
    }
    //#end
    return error;
}
