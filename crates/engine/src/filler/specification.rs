//! The specification of a motion: lines and bands for which fillers are designed and on which they are judged, each with
//! its own tolerance, apart from the motion that is sampled.

use std::f64::consts::SQRT_2;

use crate::key::given::Given;
use crate::key::holds::Holds;
use crate::key::reading::Reading;
use crate::key::row::{Key, keys};
use crate::key::table::Table;
use crate::motion::keys::{AMPLITUDES, FREQUENCIES, Phase, RATES};
use crate::motion::read::band;
use crate::motion::{Amplitude, Frequency, Motion, Tone, Value};
use sagnac_base::quantity::units::{Dimension, round_12};
use sagnac_base::source::diagnose::Fault;
use sagnac_theory::minimum_variance::Band;

keys! {
    /// The keys of the specification.
    pub(crate) static KEYS;
    /// Motion for which minimum-variance fillers without a band are designed, and on which all fillers are judged: lines
    /// and bands, each with its own tolerance. The motion that is sampled is that of [motion].
    pub SPECIFICATION = "specification", "", Fixed, Holds::Table, "[specification]\nlines = [{ amplitude = \"90 arcsec\", frequency = \"345 Hz\", tolerance = \"0.1 %\" }]";
    /// Sines of random phase.
    LINES = "specification.lines", "", Fixed, Holds::List(&Holds::Table), r#"lines = [{ amplitude = "90 arcsec", frequency = "345 Hz", tolerance = "0.1 %" }]"#;
    /// Amplitude of the rate, "12000 arcsec/s", or of the angle, "90 arcsec".
    LINE_AMPLITUDE = "specification.lines.amplitude", "", Fixed, AMPLITUDES, r#"amplitude = "90 arcsec""#, required;
    /// Nominal frequency: "345 Hz".
    LINE_FREQUENCY = "specification.lines.frequency", "", Fixed, FREQUENCIES, r#"frequency = "345 Hz""#, required;
    /// Largest relative deviation of the frequency from its nominal value; none if absent.
    LINE_TOLERANCE = "specification.lines.tolerance", "", Fixed, Holds::Percent, r#"tolerance = "0.1 %""#;
    /// Gaussian motion, each with its power spread evenly over its band.
    BANDS = "specification.bands", "", Fixed, Holds::List(&Holds::Table), r#"bands = [{ rms = "1000 arcsec/s", band = ["30 Hz", "80 Hz"], tolerance = "5 %" }]"#;
    /// Standard deviation of the rate: "1000 arcsec/s".
    BAND_RMS = "specification.bands.rms", "", Fixed, RATES, r#"rms = "1000 arcsec/s""#, required;
    /// Nominal ends of the band: ["30 Hz", "80 Hz"].
    BAND_ENDS = "specification.bands.band", "", Fixed, Holds::Pair(&FREQUENCIES), r#"band = ["30 Hz", "80 Hz"]"#, required;
    /// Largest relative deviation of either end from its nominal value, each on its own; none if absent.
    BAND_TOLERANCE = "specification.bands.tolerance", "", Fixed, Holds::Percent, r#"tolerance = "5 %""#;
}

/// A specified motion, the sum of independent parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Specification {
    /// Its lines and bands.
    pub parts: Vec<Part>,
}

/// A line or a band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// The part at its nominal frequencies; that of a line is fixed, that of a band is spread over it.
    pub tone: Tone,
    /// Largest relative deviation of the frequency of a line, or of either end of a band.
    pub tolerance: f64,
}

/// Steps on either side in which the deviation of a line is tried. The residual of a filler that is designed for the
/// tolerance can be largest inside it.
const STEPS: i32 = 8;

impl Part {
    /// Whether it is a line.
    pub fn is_line(&self) -> bool {
        matches!(self.tone.frequency, Frequency::Fixed(_))
    }

    /// The part with the ends of its frequencies off by relative deviations.
    fn off(&self, [low, high]: [f64; 2]) -> Tone {
        let Band { low_hz, high_hz } = self.tone.band();
        let frequency =
            Frequency::Band(Band { low_hz: low_hz * (1.0 + low), high_hz: high_hz * (1.0 + high) });
        Tone { frequency, ..self.tone }
    }

    /// The part as it may be: at its nominal frequencies, which come first, and at others within the tolerance.
    pub fn possible(&self) -> Vec<Tone> {
        let most = self.tolerance;
        let ends: Vec<[f64; 2]> = match self.is_line() {
            _ if most == 0.0 => vec![],
            true => (-STEPS..=STEPS).map(|step| [most * f64::from(step) / f64::from(STEPS); 2]).collect(),
            false => [-most, 0.0, most].iter().flat_map(|&a| [-most, 0.0, most].map(|b| [a, b])).collect(),
        };
        std::iter::once(self.tone).chain(ends.into_iter().map(|ends| self.off(ends))).collect()
    }

    /// Its highest frequency within the tolerance, Hz.
    pub(crate) fn highest_hz(&self) -> f64 {
        self.off([self.tolerance; 2]).band().high_hz
    }
}

impl Specification {
    /// The motion for which fillers are designed: each part spread evenly over all its frequencies within the tolerance.
    pub fn motion(&self) -> Motion {
        let tones = self.parts.iter().map(|part| part.off([-part.tolerance, part.tolerance])).collect();
        Motion { tones, ..Motion::default() }
    }
}

/// Reads the specification, if there is one.
pub(crate) fn read(reading: &mut Reading) -> Result<Option<Specification>, Fault> {
    let Some(table) = reading.get(&SPECIFICATION) else { return Ok(None) };
    reading.note(&[&SPECIFICATION]);
    let parts = |key, part: fn(&Table) -> Result<Part, Fault>| {
        let list = reading.get(key).map_or(vec![], |list| list.items());
        list.iter().filter_map(Given::table).map(|table| part(&table)).collect::<Result<Vec<_>, _>>()
    };
    let parts = [parts(&LINES, line)?, parts(&BANDS, spread)?].concat();
    if parts.is_empty() {
        let help = format!("accepted: {}, or {}, or both", LINES.example, BANDS.example);
        return Err(table.fault("[specification] has no lines and no bands", "nothing here", help));
    }
    Ok(Some(Specification { parts }))
}

fn line(table: &Table) -> Result<Part, Fault> {
    let amplitude = table.needed(&LINE_AMPLITUDE)?.quantity()?;
    let tone = Tone {
        amplitude: Amplitude {
            of_angle: amplitude.dimension == Dimension::Angle,
            value: Value::Fixed(amplitude.value),
        },
        frequency: Frequency::Fixed(table.needed(&LINE_FREQUENCY)?.quantity()?.value),
        phase: Phase::Uniform,
    };
    Ok(Part { tone, tolerance: tolerance(table, &LINE_TOLERANCE)? })
}

fn spread(table: &Table) -> Result<Part, Fault> {
    let rms = table.needed(&BAND_RMS)?.quantity()?.value;
    let frequency = Frequency::Band(band(table.needed(&BAND_ENDS)?)?);
    // A sine has half its squared amplitude as mean square.
    let tone = Tone { frequency, ..Tone::of_rate(round_12(SQRT_2 * rms), 0.0) };
    let part = Part { tone, tolerance: tolerance(table, &BAND_TOLERANCE)? };
    let Band { low_hz, high_hz } = part.off([part.tolerance, -part.tolerance]).band();
    if low_hz > high_hz && part.tolerance > 0.0 {
        let message = format!("{}: the ends of the band may cross within their tolerance", BAND_ENDS.name);
        let help = "give a smaller tolerance, or a line instead of a narrow band";
        return Err(table.needed(&BAND_ENDS)?.fault(message, "too narrow", help));
    }
    Ok(part)
}

fn tolerance(table: &Table, key: &'static Key) -> Result<f64, Fault> {
    let help = format!("accepted: a percentage such as {}", key.example);
    table.get(key).map_or(Ok(0.0), |written| written.percent(&help))
}
