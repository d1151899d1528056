//! Colours for values, from dark for the least to light for the greatest.

/// Viridis of matplotlib, in tenths. Lightness rises evenly, so that equal steps look equal, even in greyscale and to
/// colour-blind readers. By S. van der Walt, N. Smith and E. Firing, in the public domain (CC0).
const VIRIDIS: [[u8; 3]; 11] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x24, 0x75],
    [0x41, 0x44, 0x87],
    [0x35, 0x5f, 0x8d],
    [0x2a, 0x78, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x22, 0xa8, 0x84],
    [0x44, 0xbf, 0x70],
    [0x7a, 0xd1, 0x51],
    [0xbd, 0xdf, 0x26],
    [0xfd, 0xe7, 0x25],
];

/// The colour at a fraction of the scale, 0 … 1, in SVG notation; beyond the ends, the colour of the end.
pub(crate) fn colour(fraction: f64) -> String {
    let last = VIRIDIS.len() - 1;
    let at = fraction.clamp(0.0, 1.0) * last as f64;
    let lower = (at as usize).min(last - 1);
    let mix = |part: usize| {
        let [a, b] = [lower, lower + 1].map(|anchor| f64::from(VIRIDIS[anchor][part]));
        libm::round(a + (b - a) * (at - lower as f64)) as u8
    };
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE L* of an sRGB colour.
    fn lightness(colour: &str) -> f64 {
        let linear = |at: usize| {
            let c = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
        };
        let y = 0.2126 * linear(1) + 0.7152 * linear(3) + 0.0722 * linear(5);
        116.0 * libm::cbrt(y) - 16.0
    }

    #[test]
    fn lightness_rises_in_even_steps() {
        let all: Vec<f64> = (0..=40).map(|step| lightness(&colour(f64::from(step) / 40.0))).collect();
        let mean = (all[40] - all[0]) / 40.0;
        assert!(all[0] < 20.0 && all[40] > 88.0, "from {} to {}", all[0], all[40]);
        for (step, pair) in all.windows(2).enumerate() {
            let rise = (pair[1] - pair[0]) / mean;
            assert!((0.6..1.4).contains(&rise), "step {step} rises by {rise} of the mean");
        }
    }

    #[test]
    fn the_ends_are_the_anchors_and_hold_beyond() {
        assert_eq!([colour(0.0), colour(-3.0)], ["#440154", "#440154"]);
        assert_eq!([colour(1.0), colour(20.0)], ["#fde725", "#fde725"]);
    }
}
