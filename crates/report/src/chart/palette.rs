//! The styles that distinguish curves, and those of names that look the same in every chart.

use serde::Serialize;

use crate::chart::figure::Entry;
use crate::chart::plot::{MARKED, MAX_MARKED};
use sagnac_base::table::{Cell, Column};

/// Colours that colour-blind readers can distinguish, the first three also by lightness in greyscale (L* 29, 48, 69).
/// After Paul Tol's schemes and Okabe and Ito.
pub const COLOURS: [&str; 8] =
    ["#004488", "#c24a00", "#4fb9a8", "#aa3377", "#e0a100", "#5aaae0", "#444444", "#999933"];

/// The colours for dark backgrounds: lighter, in the same hues.
const ON_DARK: [&str; 8] =
    ["#6fa8ff", "#ff9457", "#63d3c2", "#e58cc4", "#f2c14a", "#a3dcff", "#bdbdbd", "#cfcf6b"];

/// The colours mixed with 28 % and with 62 % of white, for areas and for the background.
const TINTS: [[&str; 8]; 2] = [
    ["#4778a9", "#d37d47", "#80cdc0", "#c26c9d", "#e9bb47", "#88c2e9", "#787878", "#b6b66c"],
    ["#9eb8d2", "#e8ba9e", "#bce4de", "#dfb1cb", "#f3db9e", "#c0dff3", "#b8b8b8", "#d8d8b1"],
];

/// Dash patterns for `stroke-dasharray`.
const DASHES: [&str; 6] = ["", "7 3", "2 2.5", "9 3 2 3", "14 4", "9 3 2 3 2 3"];

/// Dash patterns for thin lines, none of them solid.
const THIN_DASHES: [&str; 7] = ["6 3", "2 2", "8 3 2 3", "12 4", "8 3 2 3 2 3", "4 2", "12 3 4 3"];

/// Dash patterns for broad lines.
const BROAD_DASHES: [&str; 4] = ["", "12 5", "3 4", "12 4 3 4"];

/// Markers of about equal area, as corners in units of the radius; without corners a circle.
const MARKERS: [&[(f64, f64)]; 6] = [
    &[],
    &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
    &[(0.0, -1.3), (1.2, 0.85), (-1.2, 0.85)],
    &[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)],
    &[(0.0, 1.3), (1.2, -0.85), (-1.2, -0.85)],
    &[(0.0, -1.15), (1.1, -0.35), (0.7, 0.95), (-0.7, 0.95), (-1.1, -0.35)],
];

/// Text and axes.
pub(crate) const INK: &str = "#222222";
/// Secondary text.
pub(crate) const MUTED: &str = "#5c5c5c";
/// Secondary items in the background.
pub(crate) const PALE_MUTED: &str = "#c1c1c1";
/// Grid lines at the labelled ticks, and between them.
pub(crate) const GRID: [&str; 2] = ["#d9dde1", "#eff1f3"];
/// The limit line.
pub(crate) const LIMIT: &str = "#b3001b";

/// The styles that pages need to draw like pictures.
#[derive(Debug, Serialize)]
pub(crate) struct Looks {
    dashes: &'static [&'static str],
    thin_dashes: &'static [&'static str],
    broad_dashes: &'static [&'static str],
    markers: &'static [&'static [(f64, f64)]],
    /// Colours from the least to the greatest value, evenly spaced.
    viridis: Vec<String>,
    /// Colours from far within a limit to far beyond it, evenly spaced.
    diverging: Vec<String>,
    /// Most points of a line that all have markers, and the number of markers of a line with more.
    most_marked: usize,
    marked: usize,
}

impl Looks {
    pub fn new() -> Looks {
        /// Number of colours, more than can be distinguished.
        const COLOURS: u8 = 200;
        let all = |shades: Shades| {
            (0..=COLOURS).map(|at| shades.colour(f64::from(at) / f64::from(COLOURS))).collect()
        };
        Looks {
            dashes: &DASHES,
            thin_dashes: &THIN_DASHES,
            broad_dashes: &BROAD_DASHES,
            markers: &MARKERS,
            viridis: all(Shades::Rising),
            diverging: all(Shades::AboutLimit),
            most_marked: MAX_MARKED,
            marked: MARKED,
        }
    }
}

/// A style sheet with the colours of styles on light and on dark backgrounds, for the classes `c0` and so on.
pub(crate) fn style_sheet() -> String {
    let colours = COLOURS.iter().zip(ON_DARK).enumerate();
    colours.map(|(style, (light, dark))| format!(".c{style}{{--c:light-dark({light},{dark})}}\n")).collect()
}

/// The colour of a style; they repeat.
pub(crate) fn colour(style: usize) -> &'static str {
    COLOURS[style % COLOURS.len()]
}

/// The colour of a style for a whole area.
pub(crate) fn area_colour(style: usize) -> &'static str {
    TINTS[0][style % COLOURS.len()]
}

/// The colour of a style in the background.
pub(crate) fn pale(style: usize) -> &'static str {
    TINTS[1][style % COLOURS.len()]
}

/// The dash pattern of a style; they repeat.
pub(crate) fn dash(style: usize) -> &'static str {
    DASHES[style % DASHES.len()]
}

/// The dash pattern of a broad line; they repeat.
pub(crate) fn broad_dash(style: usize) -> &'static str {
    BROAD_DASHES[style % BROAD_DASHES.len()]
}

/// The dash pattern of a thin line; they repeat.
pub(crate) fn thin_dash(style: usize) -> &'static str {
    THIN_DASHES[style % THIN_DASHES.len()]
}

/// The corners of a style's marker; they repeat.
pub(crate) fn marker(style: usize) -> &'static [(f64, f64)] {
    MARKERS[style % MARKERS.len()]
}

/// Viridis of matplotlib, in tenths. Lightness rises evenly, so that equal steps look equal, even in greyscale and to
/// colour-blind readers. By S. van der Walt, N. Smith and E. Firing, in the public domain (CC0).
const VIRIDIS: [u32; 11] = [
    0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884, 0x44bf70, 0x7ad151, 0xbddf26,
    0xfde725,
];

/// Blue to red through nearly white, in eighths, which colour-blind readers can distinguish. By C. Brewer (RdBu, Apache 2.0).
const DIVERGING: [u32; 9] =
    [0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b];

/// The colours of the values of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shades {
    /// From the least value to the greatest.
    Rising,
    /// From far within a limit to far beyond it; the limit itself is nearly white.
    AboutLimit,
}

impl Shades {
    /// The colour at a fraction of the scale, 0 … 1, in SVG notation; beyond the ends, the colour of the end.
    pub fn colour(self, fraction: f64) -> String {
        let anchors: &[u32] = match self {
            Shades::Rising => &VIRIDIS,
            Shades::AboutLimit => &DIVERGING,
        };
        let last = anchors.len() - 1;
        let at = fraction.clamp(0.0, 1.0) * last as f64;
        let lower = (at as usize).min(last - 1);
        let mix = |part: usize| {
            let [a, b] = [lower, lower + 1].map(|anchor| f64::from(anchors[anchor].to_be_bytes()[part]));
            libm::round(a + (b - a) * (at - lower as f64)) as u8
        };
        format!("#{:02x}{:02x}{:02x}", mix(1), mix(2), mix(3))
    }
}

/// The styles of the values of a column. Of a column with fixed names, these have the first styles, and every other name has one that
/// follows from the name; names of one column that would share a colour take the next that is free, as long as there is one.
pub fn styles(column: Option<&Column>, entries: &[Entry]) -> Vec<usize> {
    let Some(column) = column.filter(|column| !column.styled.is_empty()) else {
        return (0..entries.len()).collect();
    };
    // Of the whole column, so that all charts of a table agree.
    let mut names: Vec<String> =
        column.cells.iter().filter(|cell| **cell != Cell::Blank).map(Cell::text).collect();
    names.sort_unstable();
    names.dedup();
    let styles = of_names(column.styled, &names);
    let style =
        |entry: &Entry| names.iter().position(|name| *name == entry.name).map_or(0, |place| styles[place]);
    entries.iter().map(style).collect()
}

/// The styles of names in alphabetical order, of which the `fixed` ones have the first.
pub fn of_names(fixed: &[&str], names: &[String]) -> Vec<usize> {
    let others = COLOURS.len() - fixed.len();
    let mut taken: Vec<usize> = Vec::new();
    let mut free = |name: &String| {
        // Once all colours are taken they repeat, with other dashes and markers.
        let round = taken.len() / others;
        let style = |step: usize| round * COLOURS.len() + fixed.len() + (hash(name) + step) % others;
        let style = (0..others).map(style).find(|style| !taken.contains(style)).unwrap_or_default();
        taken.push(style);
        style
    };
    let style = |name: &String| fixed.iter().position(|known| known == name).unwrap_or_else(|| free(name));
    names.iter().map(style).collect()
}

/// FNV-1a in 32 bits, which gives short names different numbers.
fn hash(name: &str) -> usize {
    name.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
        as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red, green and blue of `#rrggbb`.
    fn parts(colour: &str) -> [f64; 3] {
        [1, 3, 5].map(|at| f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()))
    }

    #[test]
    fn tints_are_their_colours_with_white() {
        for (tints, white) in TINTS.iter().zip([0.28, 0.62]) {
            for (tint, colour) in tints.iter().zip(COLOURS) {
                for (found, full) in parts(tint).into_iter().zip(parts(colour)) {
                    let mixed = full * (1.0 - white) + 255.0 * white;
                    assert!((found - mixed).abs() <= 0.5 + 1e-9, "{tint} of {colour}: {found}, not {mixed}");
                }
            }
        }
    }

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
        let all: Vec<f64> =
            (0..=40).map(|step| lightness(&Shades::Rising.colour(f64::from(step) / 40.0))).collect();
        let mean = (all[40] - all[0]) / 40.0;
        assert!(all[0] < 20.0 && all[40] > 88.0, "from {} to {}", all[0], all[40]);
        for (step, pair) in all.windows(2).enumerate() {
            let rise = (pair[1] - pair[0]) / mean;
            assert!((0.6..1.4).contains(&rise), "step {step} rises by {rise} of the mean");
        }
    }

    #[test]
    fn the_ends_are_the_anchors_and_hold_beyond() {
        let of = |fractions: [f64; 2]| fractions.map(|fraction| Shades::Rising.colour(fraction));
        assert_eq!(of([0.0, -3.0]), ["#440154", "#440154"]);
        assert_eq!(of([1.0, 20.0]), ["#fde725", "#fde725"]);
    }

    #[test]
    fn colours_about_a_limit_are_palest_at_it_and_as_dark_on_either_side() {
        let at = |fraction: f64| lightness(&Shades::AboutLimit.colour(fraction));
        for step in 0..20 {
            let far = 0.5 - f64::from(step) / 40.0;
            assert!(at(0.5 - far) < at(0.5) && (at(0.5 - far) - at(0.5 + far)).abs() < 6.0, "{far}");
        }
    }

    fn of(names: &[&str]) -> Vec<usize> {
        of_names(&["const", "linear"], &names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn a_name_has_its_style_whatever_stands_beside_it() {
        let [alone, beside] = [of(&["mv8+2"]), of(&["const", "linear", "mv8+2"])];
        assert_eq!((beside[0], beside[1], beside[2]), (0, 1, alone[0]));
        assert!((2..8).contains(&alone[0]), "{alone:?}");
    }

    #[test]
    fn names_of_one_column_have_different_colours_while_there_are_any() {
        let names: Vec<String> = (10..22).map(|k| format!("own {k}")).collect();
        let styles = of(&names.iter().map(String::as_str).collect::<Vec<_>>());
        let mut first = styles[..6].to_vec();
        first.sort_unstable();
        assert_eq!(first, [2, 3, 4, 5, 6, 7]);
        let mut all = styles.clone();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 12, "{styles:?}");
    }
}
