// The arithmetic of the kernels: 32-bit words that wrap. Twin of crates/kernel/src/word.rs.
//
// WGSL has no upper half of a product. It is computed from 16-bit parts or, where the device has 64-bit registers
// (INT64), taken from one of them; both ways give the same bits.

fn sar(x: u32, n: u32) -> u32 {
    return bitcast<u32>(bitcast<i32>(x) >> n);
}

// The larger value, compared as signed numbers.
fn max_signed(x: u32, other: u32) -> u32 {
    return bitcast<u32>(max(bitcast<i32>(x), bitcast<i32>(other)));
}

// x, negated where `sign` is negative.
fn with_sign(x: u32, sign: u32) -> u32 {
    let mask = sar(sign, 31u);
    return (x ^ mask) - mask;
}

//#if INT64
alias Wide = i64;

fn mulhi(a: u32, b: u32) -> u32 {
    return u32((u64(a) * u64(b)) >> 32u);
}

fn mul_wide(a: u32, b: u32) -> Wide {
    return i64(bitcast<i32>(a)) * i64(bitcast<i32>(b));
}

// Only here: `+` of Rust.
fn add_wide(a: Wide, b: Wide) -> Wide {
    return a + b;
}

// Only here: `-` of Rust.
fn sub_wide(a: Wide, b: Wide) -> Wide {
    return a - b;
}

// Only here: a lane of 64 bits in Rust.
fn wide(low: u32, high: u32) -> Wide {
    return i64((u64(high) << 32u) | u64(low));
}

// Only here: a cast in Rust.
fn low_word(a: Wide) -> u32 {
    return u32(u64(a) & 0xfffffffflu);
}

fn high_word(a: Wide) -> u32 {
    return u32(u64(a) >> 32u);
}

fn bits_from(a: Wide, n: u32) -> u32 {
    return u32((u64(a) >> n) & 0xfffffffflu);
}
//#else
alias Wide = vec2<u32>;

fn mulhi(a: u32, b: u32) -> u32 {
    let a0 = a & 0xffffu;
    let a1 = a >> 16u;
    let b0 = b & 0xffffu;
    let b1 = b >> 16u;
    let cross = a0 * b1;
    let middle = ((a0 * b0) >> 16u) + (cross & 0xffffu) + a1 * b0;
    return a1 * b1 + (cross >> 16u) + (middle >> 16u);
}

fn mul_wide(a: u32, b: u32) -> Wide {
    return vec2<u32>(a * b, mulhi(a, b) - (sar(a, 31u) & b) - (sar(b, 31u) & a));
}

// Only here: `+` of Rust.
fn add_wide(a: Wide, b: Wide) -> Wide {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// Only here: `-` of Rust.
fn sub_wide(a: Wide, b: Wide) -> Wide {
    return vec2<u32>(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

// Only here: a lane of 64 bits in Rust.
fn wide(low: u32, high: u32) -> Wide {
    return vec2<u32>(low, high);
}

// Only here: a cast in Rust.
fn low_word(a: Wide) -> u32 {
    return a.x;
}

fn high_word(a: Wide) -> u32 {
    return a.y;
}

fn bits_from(a: Wide, n: u32) -> u32 {
    // A shift by 32 would be a shift by 0.
    return (a.x >> n) | select(a.y << (32u - n), 0u, n == 0u);
}
//#end
