//! The units of columns.

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
    /// The same number as in ″/s, for drift rates.
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
