// Standard normal numbers, one word each, in units of 2^-28. Twin of crates/kernel/src/normal.rs.

@group(0) @binding(0) var<storage, read> normal_table: array<vec2<u32>, PAIRS>;

fn normal(r: u32) -> u32 {
    let tail = (r << 1u) ^ 1u;
    let octave = countLeadingZeros(tail);
    let mantissa = tail << octave;
    let segment = (octave << SEGMENT_BITS) + (mantissa >> (31u - SEGMENT_BITS));
    let f = mantissa << (SEGMENT_BITS + 1u);
    let entry = normal_table[segment];
    let curvature = entry.y & 0xfffu;
    let slope = (entry.y >> 8u) - (((f >> 17u) * curvature) >> 9u);
    let magnitude = entry.x - mulhi(f, slope);
    return with_sign(magnitude, r);
}
