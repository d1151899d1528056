// Random words: Philox4x32-10. Twin of src/kernel/philox.rs.

// Where the draws of a trial are found: its number in two halves, and the keys of its point.
struct Address {
    low: u32,
    high: u32,
    keys: array<vec2<u32>, 10>,
}

fn draw(address: Address, purpose: u32, block: u32) -> vec4<u32> {
    return philox(vec4<u32>(address.low, address.high, block, purpose), address.keys);
}

const MULTIPLIER = vec2<u32>(0xD2511F53u, 0xCD9E8D57u);
const WEYL = vec2<u32>(0x9E3779B9u, 0xBB67AE85u);

fn philox(counter: vec4<u32>, keys: array<vec2<u32>, 10>) -> vec4<u32> {
    var c = counter;
    //#for r in 0..10
    c = round_(c, keys[r]);
    //#end
    return c;
}

fn round_(c: vec4<u32>, k: vec2<u32>) -> vec4<u32> {
    let high0 = mulhi(MULTIPLIER.x, c.x);
    let low0 = MULTIPLIER.x * c.x;
    let high1 = mulhi(MULTIPLIER.y, c.z);
    let low1 = MULTIPLIER.y * c.z;
    return vec4<u32>(high1 ^ c.y ^ k.x, low1, high0 ^ c.w ^ k.y, low0);
}

// The keys of the rounds: the Weyl sequence from the point's key.
fn schedule(key: vec2<u32>) -> array<vec2<u32>, 10> {
    var keys: array<vec2<u32>, 10>;
    //#for r in 0..10
    keys[r] = key + r * WEYL;
    //#end
    return keys;
}
