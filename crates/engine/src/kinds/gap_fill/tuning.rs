//! What a filler without a band is designed for.

use crate::filler::{Filler, Method, Target};
use crate::kinds::gap_fill::GapFill;
use crate::motion::Frequency;
use crate::motion::keys::{FREQUENCY_HIGH, FREQUENCY_LOW};
use crate::study::Study;

/// The ends of the band from which a frequency is drawn.
const BAND: [&str; 2] = [FREQUENCY_LOW.name, FREQUENCY_HIGH.name];

/// Tables whose keys enter the design of a filler of least variance.
const DESIGN: [&str; 3] = ["motion.", "gyro.", "noise."];

/// What minimum-variance fillers without a band are designed for, so that firmware cannot have them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tuning {
    /// The very motion of each point, of which there are several.
    Points,
    /// One motion, whose frequency is fixed to the last digit.
    Frequency,
}

/// The fillers of a study that are designed without a band, and for what; `None` where there are none, or where they are
/// designed for the band from which the motion is drawn.
pub fn tuned<'a>(study: &Study, fill: &'a GapFill) -> Option<(Tuning, Vec<&'a str>)> {
    let is_bandless = |filler: &&Filler| filler.method == Method::MinimumVariance(Target::Own);
    let names: Vec<&str> =
        fill.fillers.iter().filter(is_bandless).map(|filler| filler.name.as_str()).collect();
    let tones = &fill.inputs.motion.tones;
    let is_fixed = tones.iter().any(|tone| matches!(tone.frequency, Frequency::Fixed(_)));
    // A band that is swept is known to the designer, who designs for each.
    let is_band = |key: &str| !is_fixed && !tones.is_empty() && BAND.contains(&key);
    let of_design = |key: &str| DESIGN.iter().any(|table| key.starts_with(table)) && !is_band(key);
    let varies = study.sweeps.iter().any(|sweep| sweep.values.len() > 1 && of_design(sweep.key.name));
    let tuning = match (varies, is_fixed) {
        (true, _) => Tuning::Points,
        (false, true) => Tuning::Frequency,
        (false, false) => return None,
    };
    (!names.is_empty()).then_some((tuning, names))
}
