//! Dimensions, units and quantities: numbers with units as engineers write them, stored in ″ and s. [`Unit`] is the unit of a
//! column, and [`UnitError`] says why a text is no quantity.

pub mod expression;
pub mod number;
#[cfg(test)]
mod tests;

use std::fmt;

use crate::quantity::expression::{Exponents, NAUTICAL_MILE, STANDARD_GRAVITY, Size};
use crate::quantity::number::{joined, significant};

/// The properties of a dimension.
struct Row {
    exponents: Exponents,
    name: &'static str,
    /// Accepted units and one example, for sentences.
    units: &'static str,
    example: &'static str,
    unit: Unit,
}

/// Declares the dimensions: powers in halves of ″, s, g and, where there are any, pulses, name, accepted units, one example, and the unit of tables.
macro_rules! dimensions {
    ($($(#[$doc:meta])* $Dimension:ident: [$angle:literal, $time:literal, $g:literal $(, $pulse:literal)?], $name:literal, $units:literal,
        $example:literal, $unit:ident;)+) => {
        /// The physical dimension of a value.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Dimension {
            $($(#[$doc])* $Dimension,)+
        }

        impl Dimension {
            const ALL: [Dimension; [$($name),+].len()] = [$(Dimension::$Dimension),+];

            fn row(self) -> Row {
                match self {
                    $(Dimension::$Dimension => Row {
                        exponents: Exponents([$angle, $time, $g, 0 $(+ $pulse)?]),
                        name: $name,
                        units: $units,
                        example: $example,
                        unit: Unit::$unit,
                    },)+
                }
            }
        }
    };
}

dimensions! {
    /// A whole number, without unit.
    Count: [0, 0, 0], "a whole number", "", "3", NONE;
    /// A ratio: a number, or a text in percent.
    Ratio: [0, 0, 0], "a ratio", "", r#"0.05 or "5 %""#, NONE;
    /// A time, in s.
    Time: [0, 2, 0], "a time", "s, ms, µs (us), min, h", r#""5 ms""#, S;
    /// A frequency, in Hz.
    Frequency: [0, -2, 0], "a frequency", "Hz, kHz, 1/s", r#""20 Hz""#, HZ;
    /// An angle, in ″.
    Angle: [2, 0, 0], "an angle", "arcsec (″), arcmin (′), deg (°), rad, mrad, µrad (urad)", r#""1.6 arcsec""#, ARCSEC;
    /// An angular rate, in ″/s.
    Rate: [2, -2, 0], "an angular rate", "arcsec/s, deg/s, deg/h, rad/s", r#""12000 arcsec/s""#, ARCSEC_PER_S;
    /// An angular rate as small as the noise and drift of a gyro at rest, in ″/s.
    DriftRate: [2, -2, 0], "an angular rate", "deg/h, arcsec/s, deg/s, rad/s", r#""0.002 deg/h""#, DEG_PER_H;
    /// Angle over the square root of time, in ″/√s; also a rate over the square root of frequency, two-sided: 1 °/h/√Hz
    /// = 1/60 °/√h.
    AngleRandomWalk: [2, -1, 0], "an angle random walk",
        "deg/sqrt(h), deg/√h, arcsec/sqrt(s), deg/h/sqrt(Hz)", r#""0.003 deg/sqrt(h)""#, DEG_PER_SQRT_H;
    /// An angle random walk of short records, in ″/√s.
    ShortAngleRandomWalk: [2, -1, 0], "an angle random walk",
        "arcsec/sqrt(s), deg/sqrt(h), deg/√h, deg/h/sqrt(Hz)", r#""0.17 arcsec/sqrt(s)""#, ARCSEC_PER_RT_S;
    /// An angular acceleration, in ″/s².
    AngularAcceleration: [2, -4, 0], "an angular acceleration",
        "arcsec/s^2, deg/s^2, rad/s^2, deg/h/h", r#""100 deg/s^2""#, ARCSEC_PER_S2;
    /// Rate over the square root of time.
    RateRandomWalk: [2, -3, 0], "a rate random walk",
        "deg/h/sqrt(h), deg/h/√h, arcsec/s/sqrt(s)", r#""0.001 deg/h/sqrt(h)""#, DEG_PER_H_PER_SQRT_H;
    /// Power spectral density of a rate, one-sided.
    RateDensity: [4, -2, 0], "a density of the rate",
        "(arcsec/s)^2/Hz, (deg/s)^2/Hz, (rad/s)^2/Hz", r#""0.1 (deg/s)^2/Hz""#, ARCSEC2_PER_S2_PER_HZ;
    /// A linear acceleration, in g.
    Acceleration: [0, 0, 2], "an acceleration", "g, mg, µg (ug), m/s^2", r#""1 g""#, G;
    /// A velocity, in g·s.
    Velocity: [0, 2, 2], "a velocity", "m/s, mm/s, ft/s, g·s", r#""0.1 mm/s""#, G_S;
    /// A length, in g·s².
    Length: [0, 4, 2], "a length", "m, cm, mm, ft", r#""1 m""#, G_S2;
    /// The speed of a vehicle, in g·s.
    Speed: [0, 2, 2], "a speed", "m/s, km/h, kn", r#""250 m/s""#, M_PER_S;
    /// A distance over the Earth, in g·s².
    Distance: [0, 4, 2], "a distance", "nmi, km, m", r#""1 nmi""#, NMI;
    /// A latitude or a course, in ″.
    Bearing: [2, 0, 0], "an angle on the Earth", "deg (°), arcmin (′), arcsec (″), rad", r#""60 deg""#, DEG;
    /// Power spectral density of an acceleration, one-sided.
    AccelerationDensity: [0, 2, 4], "a density of the acceleration", "g^2/Hz", r#""0.01 g^2/Hz""#, G2_PER_HZ;
    /// Rate per linear acceleration, of a suspension.
    RatePerAcceleration: [2, -2, -2], "a rate per acceleration",
        "arcsec/s/g, deg/s/g, rad/s/g", r#""20000 arcsec/s/g""#, ARCSEC_PER_S_PER_G;
    /// Angle of a pulse, of the output of a gyro.
    ScaleFactor: [2, 0, 0, -2], "a scale factor", "arcsec/pulse, deg/pulse, µrad/pulse", r#""2 arcsec/pulse""#, ARCSEC_PER_PULSE;
}

impl Dimension {
    /// Name for sentences, such as `an angle`.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Accepted units for sentences, such as `s, ms, …`; empty for a number without a unit.
    pub fn units(self) -> &'static str {
        self.row().units
    }

    /// The unit in which tables show values of this dimension: that of data sheets for noise.
    pub fn unit(self) -> Unit {
        self.row().unit
    }

    /// The size of one base unit in the unit of tables.
    fn base_shown(self) -> f64 {
        match self {
            // 1 ″/√s is 1/60 °/√h, 1 ″/s^1.5 is 60 °/h/√h; ″/s and °/h are the same.
            Dimension::AngleRandomWalk => 1.0 / 60.0,
            Dimension::RateRandomWalk => 60.0,
            Dimension::Speed => STANDARD_GRAVITY,
            Dimension::Distance => STANDARD_GRAVITY / NAUTICAL_MILE,
            Dimension::Bearing => 1.0 / 3600.0,
            _ => 1.0,
        }
    }
}

/// Help that lists the accepted units for `dimensions`.
pub fn accepted(dimensions: &[Dimension]) -> String {
    let each = dimensions.iter().map(|dimension| {
        let Row { name, units, example, .. } = dimension.row();
        let within = if units.is_empty() { "" } else { " in " };
        format!("{name}{within}{units}, for example {example}")
    });
    format!("accepted: {}", each.collect::<Vec<_>>().join("; or "))
}

/// A value in base units: ″, s, their combinations, or a plain count.
#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    /// The value, rounded to 12 significant digits, so that values that share an identity have the same bits.
    pub value: f64,
    /// The dimension, which determines the base unit.
    pub dimension: Dimension,
    /// The unit in which it is written; `None` for that of tables.
    pub written: Option<Written>,
}

impl PartialEq for Quantity {
    /// Whether the values are equal, in whichever units they are written.
    fn eq(&self, other: &Quantity) -> bool {
        (self.value, self.dimension) == (other.value, other.dimension)
    }
}

impl Quantity {
    /// A value in base units, rounded to twelve digits.
    pub fn new(value: f64, dimension: Dimension) -> Quantity {
        Quantity { value: round_12(value), dimension, written: None }
    }

    /// A ratio written in percent.
    pub fn percent(percent: f64) -> Quantity {
        let written = Some(Written { factor: 100.0, symbol: "%" });
        Quantity { written, ..Quantity::new(percent / 100.0, Dimension::Ratio) }
    }

    /// Another value in the same units.
    pub fn with(self, value: f64) -> Quantity {
        Quantity { value: round_12(value), ..self }
    }

    /// The value in the unit in which people read it.
    pub fn read(self) -> f64 {
        self.written.map_or(self.shown(), |written| written.of(self.shown()))
    }

    /// The value in the unit of tables.
    pub fn shown(self) -> f64 {
        self.value * self.dimension.base_shown()
    }
}

impl fmt::Display for Quantity {
    /// Writes the value with its unit, such as `20 Hz`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let symbol = self.written.map_or(self.dimension.unit().symbol, |written| written.symbol);
        f.write_str(&joined(&significant(self.read(), 12), symbol))
    }
}

/// Rounds to 12 significant decimal digits through text, which is exact and the same everywhere. −0 becomes 0.
pub fn round_12(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x) + 0.0
}

impl Written {
    /// A number of the unit of tables in this unit. It has 11 digits, because 12 were kept of that number.
    pub fn of(self, x: f64) -> f64 {
        if self.factor == 1.0 {
            return x;
        }
        format!("{:.10e}", x * self.factor).parse().unwrap_or(x) + 0.0
    }
}

/// Reads `"<number> <unit>"` as a quantity of one of the `wanted` dimensions.
///
/// The number may hold `_`, an exponent and the Unicode minus.
///
/// # Errors
/// A missing number, a missing or unknown unit, another dimension, or a value that is not finite.
/// # Example
/// ```
/// use sagnac_base::quantity::{Dimension, parse};
///
/// assert_eq!(parse("5 ms", &[Dimension::Time])?.value, 0.005);
/// // Rates are in ″/s, and 1 °/h is 1 ″/s; an angle random walk of 1 °/√h is 60 ″/√s.
/// assert_eq!(parse("15.041 deg/h", &[Dimension::DriftRate])?.value, 15.041);
/// assert_eq!(parse("0.003 deg/sqrt(h)", &[Dimension::AngleRandomWalk])?.value, 0.18);
/// assert!(parse("5", &[Dimension::Time]).is_err());
/// # Ok::<(), sagnac_base::quantity::UnitError>(())
/// ```
pub fn parse(text: &str, wanted: &[Dimension]) -> Result<Quantity, UnitError> {
    let (number, unit) = number_and_unit(text)?;
    let (factor, dimension) = unit_of(unit, text.trim(), wanted)?;
    let symbol = expression::symbol(unit, Size { factor, exponents: dimension.row().exponents });
    // Angle random walks are read in °/√h, times by their size.
    let written = symbol.map(|symbol| Written { factor: 1.0 / (factor * dimension.base_shown()), symbol });
    Ok(Quantity { written, ..Quantity::new(finite(number * factor, text)?, dimension) })
}

/// Reads `"<number> <unit>"` as a multiple of the first of some `units` that measures the same; returns it with the place
/// of that unit.
///
/// # Errors
/// It fails where [`parse`] does.
///
/// # Example
/// ```
/// use sagnac_base::quantity::parse_in;
///
/// assert_eq!(parse_in("3 arcmin/√h", &["deg/sqrt(h)", "m/s/sqrt(h)"])?, (0.05, 0));
/// assert_eq!(parse_in("2 mm/s/sqrt(h)", &["deg/sqrt(h)", "m/s/sqrt(h)"])?, (0.002, 1));
/// # Ok::<(), sagnac_base::quantity::UnitError>(())
/// ```
pub fn parse_in(text: &str, units: &[&str]) -> Result<(f64, usize), UnitError> {
    let (number, unit) = number_and_unit(text)?;
    let size = expression::parse(unit)?;
    for (place, own) in units.iter().enumerate() {
        let own = expression::parse(own)?;
        if own.exponents == size.exponents {
            return Ok((round_12(finite(number * (size.factor / own.factor), text)?), place));
        }
    }
    Err(UnitError::Dimension { text: text.trim().to_owned(), found: named(size.exponents) })
}

/// The number at the start of a text, and the unit behind it.
fn number_and_unit(text: &str) -> Result<(f64, &str), UnitError> {
    let text = text.trim();
    let (number, unit) = text.split_at(number_length(text));
    if let Some(instead) = without_comma(number, unit) {
        return Err(UnitError::Comma { text: text.to_owned(), instead });
    }
    let unit = unit.trim();
    let digits = number.replace('_', "").replace('−', "-");
    let number: f64 = digits.parse().map_err(|_| UnitError::NoNumber(text.to_owned()))?;
    if unit.is_empty() { Err(UnitError::BareNumber(text.to_owned())) } else { Ok((number, unit)) }
}

fn finite(value: f64, text: &str) -> Result<f64, UnitError> {
    if value.is_finite() { Ok(value) } else { Err(UnitError::NotFinite(text.trim().to_owned())) }
}

/// Reads a unit alone. Returns its size in base units, and the one of the `wanted` dimensions that it measures.
///
/// # Errors
/// The unit is unknown, or has another dimension.
pub fn parse_unit(unit: &str, wanted: &[Dimension]) -> Result<(f64, Dimension), UnitError> {
    unit_of(unit, unit, wanted)
}

/// Reads the unit of `text`, which an error about the dimension quotes.
fn unit_of(unit: &str, text: &str, wanted: &[Dimension]) -> Result<(f64, Dimension), UnitError> {
    let size = expression::parse(unit)?;
    let of_size = |dimension: &Dimension| dimension.row().exponents == size.exponents;
    if let Some(dimension) = wanted.iter().copied().find(of_size) {
        return Ok((size.factor, dimension));
    }
    Err(UnitError::Dimension { text: text.to_owned(), found: named(size.exponents) })
}

/// What has these powers of base units, for sentences.
fn named(exponents: Exponents) -> String {
    let mut known = Dimension::ALL.into_iter().filter(|known| !known.units().is_empty());
    let known = known.find(|known| known.row().exponents == exponents);
    known.map_or_else(|| format!("a quantity in {exponents}"), |dimension| dimension.name().to_owned())
}

/// Possible meanings of a number with a comma: decimals, or thousands where three digits follow.
fn without_comma(number: &str, rest: &str) -> Option<String> {
    let behind = rest.strip_prefix(',').filter(|behind| behind.starts_with(|c: char| c.is_ascii_digit()))?;
    let digits = behind.bytes().take_while(u8::is_ascii_digit).count();
    let decimals = (!behind[digits..].starts_with(['.', ','])).then(|| format!("\"{number}.{behind}\""));
    // Numbers with a thousands separator do not begin with a zero.
    let leads = !number.trim_start_matches(['+', '-', '−']).starts_with('0');
    let thousands = (digits == 3 && leads).then(|| format!("\"{number}{}\"", behind.replace(',', "")));
    let readings: Vec<String> = decimals.into_iter().chain(thousands).collect();
    (!readings.is_empty()).then(|| readings.join(" or "))
}

/// Length in bytes of the number at the start: sign, digits, fraction and exponent.
fn number_length(text: &str) -> usize {
    let skip = |at: usize, keep: &dyn Fn(char) -> bool, most: usize| {
        let kept = text[at..].chars().take(most).take_while(|c| keep(*c));
        at + kept.map(char::len_utf8).sum::<usize>()
    };
    let sign = |c: char| matches!(c, '+' | '-' | '−');
    let digit = |c: char| c.is_ascii_digit() || c == '_';
    let whole = skip(skip(0, &sign, 1), &digit, usize::MAX);
    let point = skip(whole, &|c| c == '.', 1);
    let mantissa = if point > whole { skip(point, &digit, usize::MAX) } else { whole };
    let letter = skip(mantissa, &|c| matches!(c, 'e' | 'E'), 1);
    let exponent_digits = skip(letter, &sign, 1);
    let exponent = skip(exponent_digits, &digit, usize::MAX);
    if letter > mantissa && exponent > exponent_digits { exponent } else { mantissa }
}

/// The unit of the numbers in a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Unit {
    /// Suffix of a column's name in files, such as `arcsec` or `hz`; empty for a pure number.
    pub suffix: &'static str,
    /// Symbol on an axis and in sentences, such as `″` or `Hz`.
    pub symbol: &'static str,
}

/// The unit in which a quantity is written, and in which people read it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Written {
    /// Its number in one unit of tables.
    pub factor: f64,
    /// Symbol, such as `°/s`.
    pub symbol: &'static str,
}

impl Unit {
    /// The unit of counts, ratios and names.
    pub const NONE: Unit = Unit { suffix: "", symbol: "" };
    /// Angles.
    pub const ARCSEC: Unit = Unit { suffix: "arcsec", symbol: "″" };
    /// Rates.
    pub const ARCSEC_PER_S: Unit = Unit { suffix: "arcsec_per_s", symbol: "″/s" };
    /// Angular accelerations; rate ramps.
    pub const ARCSEC_PER_S2: Unit = Unit { suffix: "arcsec_per_s2", symbol: "″/s²" };
    /// Angle random walk N.
    pub const DEG_PER_SQRT_H: Unit = Unit { suffix: "deg_per_sqrt_h", symbol: "°/√h" };
    /// Angle random walk in the units of short records.
    pub const ARCSEC_PER_RT_S: Unit = Unit { suffix: "arcsec_per_rt_s", symbol: "″/√s" };
    /// Scale factors.
    pub const ARCSEC_PER_PULSE: Unit = Unit { suffix: "arcsec_per_pulse", symbol: "″/pulse" };
    /// Rate random walk K.
    pub const DEG_PER_H_PER_SQRT_H: Unit = Unit { suffix: "deg_per_h_per_sqrt_h", symbol: "°/h/√h" };
    /// Unit of drift rates; 1 °/h is 1 ″/s.
    pub const DEG_PER_H: Unit = Unit { suffix: "deg_per_h", symbol: "°/h" };
    /// Allan variances.
    pub const DEG2_PER_H2: Unit = Unit { suffix: "deg2_per_h2", symbol: "(°/h)²" };
    /// Densities of rate, one-sided.
    pub const ARCSEC2_PER_S2_PER_HZ: Unit = Unit { suffix: "arcsec2_per_s2_per_hz", symbol: "(″/s)²/Hz" };
    /// Response of a suspension.
    pub const ARCSEC_PER_S_PER_G: Unit = Unit { suffix: "arcsec_per_s_per_g", symbol: "″/s/g" };
    /// Accelerations.
    pub const G: Unit = Unit { suffix: "g", symbol: "g" };
    /// Velocities, as the integral of an acceleration.
    pub const G_S: Unit = Unit { suffix: "g_s", symbol: "g·s" };
    /// Lengths, as the second integral of an acceleration.
    pub const G_S2: Unit = Unit { suffix: "g_s2", symbol: "g·s²" };
    /// Speeds of vehicles, and errors of them.
    pub const M_PER_S: Unit = Unit { suffix: "m_per_s", symbol: "m/s" };
    /// Distances over the Earth, and errors of positions.
    pub const NMI: Unit = Unit { suffix: "nmi", symbol: "nmi" };
    /// Growth of the error of a position.
    pub const NMI_PER_H: Unit = Unit { suffix: "nmi_per_h", symbol: "nmi/h" };
    /// Tilts.
    pub const MICRORAD: Unit = Unit { suffix: "urad", symbol: "µrad" };
    /// Densities of acceleration, one-sided.
    pub const G2_PER_HZ: Unit = Unit { suffix: "g2_per_hz", symbol: "g²/Hz" };
    /// Phases.
    pub const DEG: Unit = Unit { suffix: "deg", symbol: "°" };
    /// Frequencies.
    pub const HZ: Unit = Unit { suffix: "hz", symbol: "Hz" };
    /// Times.
    pub const S: Unit = Unit { suffix: "s", symbol: "s" };

    /// All units in which a header may end.
    pub const ALL: [Unit; 20] = [
        Unit::ARCSEC,
        Unit::ARCSEC_PER_S,
        Unit::ARCSEC_PER_S2,
        Unit::DEG_PER_SQRT_H,
        Unit::ARCSEC_PER_RT_S,
        Unit::ARCSEC_PER_PULSE,
        Unit::DEG_PER_H_PER_SQRT_H,
        Unit::DEG_PER_H,
        Unit::DEG2_PER_H2,
        Unit::ARCSEC2_PER_S2_PER_HZ,
        Unit::ARCSEC_PER_S_PER_G,
        Unit::G,
        Unit::G2_PER_HZ,
        Unit::M_PER_S,
        Unit::NMI,
        Unit::NMI_PER_H,
        Unit::MICRORAD,
        Unit::DEG,
        Unit::HZ,
        Unit::S,
    ];
}

/// The names that a header may have without its unit; there may be several, because the suffix of one unit may be the
/// end of another.
pub fn bare(header: &str) -> impl Iterator<Item = &str> {
    Unit::ALL.iter().filter_map(move |unit| header.strip_suffix(unit.suffix)?.strip_suffix('_'))
}

/// Why a text is not the expected quantity. Each variant begins with the text or unit as written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// The text is a number without a unit: `"5"`.
    #[error("\"{0}\" is a bare number, its unit is missing")]
    BareNumber(String),
    /// The text does not begin with a number: `"fast"`.
    #[error("\"{0}\" does not begin with a number")]
    NoNumber(String),
    /// The number has a comma: `"5,0 deg/s"`.
    #[error(
        "\"{text}\" has a comma in its number: write decimals with a point and thousands without a sign, as in {instead}"
    )]
    Comma {
        /// Text as written.
        text: String,
        /// The possible meanings, as they should be written.
        instead: String,
    },
    /// The number is too large, or not a number.
    #[error("\"{0}\" is not a finite number")]
    NotFinite(String),
    /// A word is not a unit: `"5 lightyear"`.
    #[error("`{0}` is not a known unit")]
    Unknown(String),
    /// Signs are out of place: `"5 deg//h"`.
    #[error("`{0}` cannot be read as a unit")]
    Malformed(String),
    /// The quantity has another dimension than the key takes.
    #[error("\"{text}\" is {found}")]
    Dimension {
        /// Text as written.
        text: String,
        /// Dimension found, such as "an angle".
        found: String,
    },
}

impl UnitError {
    /// A description short enough to fit under a caret.
    pub fn label(&self) -> &str {
        match self {
            UnitError::BareNumber(_) => "a bare number",
            UnitError::Dimension { found, .. } => found,
            UnitError::Unknown(_) | UnitError::Malformed(_) => "no such unit",
            UnitError::NoNumber(_) | UnitError::NotFinite(_) => "not a number with a unit",
            UnitError::Comma { .. } => "a comma in a number",
        }
    }
}
