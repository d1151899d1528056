// Logarithms and powers to base 2. Twin of crates/kernel/src/power.rs.

// The logarithm of x >= 1 in units of 2^-26, from 0 to below 32.
fn log2_word(x: u32) -> u32 {
    let octave = countLeadingZeros(x);
    let u = (x << octave) << 1u;
    var sum = LOG2[9];
    sum = LOG2[8] - mulhi(sum, u);
    sum = LOG2[7] - mulhi(sum, u);
    sum = LOG2[6] - mulhi(sum, u);
    sum = LOG2[5] - mulhi(sum, u);
    sum = LOG2[4] - mulhi(sum, u);
    sum = LOG2[3] - mulhi(sum, u);
    sum = LOG2[2] - mulhi(sum, u);
    sum = LOG2[1] - mulhi(sum, u);
    sum = LOG2[0] - mulhi(sum, u);
    let fraction = u + mulhi(between(u), sum);
    return ((31u - octave) << LOG_BITS) + (fraction >> (32u - LOG_BITS));
}

// 2^u for a fraction u in units of 2^-32, in units of 2^-31.
fn exp2_fraction(u: u32) -> u32 {
    var sum = EXP2[5];
    sum = EXP2[4] + mulhi(sum, u);
    sum = EXP2[3] + mulhi(sum, u);
    sum = EXP2[2] + mulhi(sum, u);
    sum = EXP2[1] + mulhi(sum, u);
    sum = EXP2[0] + mulhi(sum, u);
    return EXP2_ONE + ((u - mulhi(between(u), sum)) >> 1u);
}

// 2^-x for x in units of 2^-26, from 0 to MAX_MINUS, in units of 2^-31.
fn exp2_minus(x: u32) -> u32 {
    let whole = (x + (1u << LOG_BITS) - 1u) >> LOG_BITS;
    return exp2_fraction((0u - x) << (32u - LOG_BITS)) >> whole;
}

// u(1 - u) for a fraction u.
fn between(u: u32) -> u32 {
    return mulhi(u, ~u);
}
