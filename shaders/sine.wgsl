// Sine of a phase in turns, in units of 2^-30. Twin of crates/kernel/src/sine.rs.

fn sine(phase: u32) -> u32 {
    let half = phase << 1u;
    let mirror = sar(half, 31u);
    let z = (half ^ mirror) - mirror;
    return with_sign(mulhi(sine_ratio(z), z), phase);
}

// sin(pi z/2)/z, in units of 2^-31, for z from 0 to 2^31 in the same units.
fn sine_ratio(z: u32) -> u32 {
    let zz = mulhi(z, z) << 1u;
    var sum = SINE[5];
    sum = SINE[4] - mulhi(sum, zz);
    sum = SINE[3] - mulhi(sum, zz);
    sum = SINE[2] - mulhi(sum, zz);
    sum = SINE[1] - mulhi(sum, zz);
    return SINE[0] - mulhi(sum, zz);
}
