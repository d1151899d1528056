//! The looks that tell curves apart.

/// Colours that differ for colour-blind readers and, in the first three, by lightness in greyscale (L* 29, 48, 69).
/// After Paul Tol's schemes and Okabe and Ito.
const COLOURS: [&str; 8] =
    ["#004488", "#c24a00", "#4fb9a8", "#aa3377", "#e0a100", "#5aaae0", "#444444", "#999933"];

/// Dash patterns, as `stroke-dasharray` has them.
const DASHES: [&str; 6] = ["", "7 3", "2 2.5", "9 3 2 3", "14 4", "9 3 2 3 2 3"];

/// Markers of about equal area, as corners in units of the radius; a circle where there are none.
const MARKERS: [&[(f64, f64)]; 6] = [
    &[],
    &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
    &[(0.0, -1.3), (1.2, 0.85), (-1.2, 0.85)],
    &[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)],
    &[(0.0, 1.3), (1.2, -0.85), (-1.2, -0.85)],
    &[(0.0, -1.15), (1.1, -0.35), (0.7, 0.95), (-0.7, 0.95), (-1.1, -0.35)],
];

/// Text and axes.
pub(super) const INK: &str = "#222222";
/// What is said beside the main thing.
pub(super) const MUTED: &str = "#5c5c5c";
/// Grid lines at the labelled ticks, and between them.
pub(super) const GRID: [&str; 2] = ["#d9dde1", "#eff1f3"];
/// The limit line.
pub(super) const LIMIT: &str = "#b3001b";

/// The colour of a style; they repeat.
pub(super) fn colour(style: usize) -> &'static str {
    COLOURS[style % COLOURS.len()]
}

/// The dash pattern of a style; they repeat.
pub(super) fn dash(style: usize) -> &'static str {
    DASHES[style % DASHES.len()]
}

/// The dash pattern of a style among those that are not solid; they repeat.
pub(super) fn broken(style: usize) -> &'static str {
    DASHES[1 + style % (DASHES.len() - 1)]
}

/// The corners of a style's marker; they repeat.
pub(super) fn marker(style: usize) -> &'static [(f64, f64)] {
    MARKERS[style % MARKERS.len()]
}
