// Random words: Philox4x32-10. Twin of crates/kernel/src/philox.rs.

// The address of the draws of a trial: its number in two halves, and the keys of its point.
struct Address {
    low: u32,
    high: u32,
    keys: array<vec2<u32>, ROUNDS>,
}

fn draw(address: Address, purpose: u32, block: u32) -> vec4<u32> {
    return draw_beyond(address, purpose, 0u, block);
}

// The same for the purpose `beyond` places after the given one.
fn draw_beyond(address: Address, purpose: u32, beyond: u32, block: u32) -> vec4<u32> {
    return philox(vec4<u32>(address.low, address.high, block, purpose + beyond), address.keys);
}

fn philox(counter: vec4<u32>, keys: array<vec2<u32>, ROUNDS>) -> vec4<u32> {
    var c = counter;
    //#for r in 0..ROUNDS
    c = philox_round(c, keys[r]);
    //#end
    return c;
}

fn philox_round(c: vec4<u32>, k: vec2<u32>) -> vec4<u32> {
    let high0 = mulhi(MULTIPLIER[0], c.x);
    let low0 = MULTIPLIER[0] * c.x;
    let high1 = mulhi(MULTIPLIER[1], c.z);
    let low1 = MULTIPLIER[1] * c.z;
    return vec4<u32>(high1 ^ c.y ^ k.x, low1, high0 ^ c.w ^ k.y, low0);
}

// The keys of the rounds: the Weyl sequence from the point's key.
fn schedule(key: vec2<u32>) -> array<vec2<u32>, ROUNDS> {
    var keys: array<vec2<u32>, ROUNDS>;
    //#for r in 0..ROUNDS
    keys[r] = key + r * vec2<u32>(WEYL[0], WEYL[1]);
    //#end
    return keys;
}
