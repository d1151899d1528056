//! Laws that a chart draws with the estimates.

use crate::key::holds::words;
use sagnac_base::table::{About, Role, Unit};

words! {
    /// A law of error, as published or corrected, drawn with curves.
    pub enum Law {
        /// Z(20): the first dropped Taylor term at an extremum of the rate, which is the error of one tick instead of
        /// the whole gap.
        TaylorExtremum = "taylor-extremum",
        /// Z(20): the same near a zero crossing of the rate, for linear and quadratic.
        TaylorZeroCrossing = "taylor-zero-crossing",
        /// Noise of const over the gap as published: A_n √n / 2, A_n = 3σ of one tick.
        NoiseAsPublished = "noise-as-published",
        /// Noise of const over the gap by Z(18): A_n n / 2 for a fit to four ticks.
        Noise = "noise",
        /// The paper's tables 1 and 2: the drift measured after a switch, and its remainder after the paper's
        /// compensations. Only for kind = "relock".
        ZeemanTables = "zeeman-tables",
        /// The class of strategic navigators, 0.02 nmi/h. Only for kind = "navigation".
        StrategicGrade = "strategic-grade",
        /// The class of navigators of aircraft, 1 nmi/h. Only for kind = "navigation".
        NavigationGrade = "navigation-grade",
        /// The class of tactical navigators, 10 nmi/h. Only for kind = "navigation".
        TacticalGrade = "tactical-grade",
        /// The mean squared error over the claimed variance (NEES) of a consistent filter, 1. Only for kind = "navigation" with
        /// a filter.
        ConsistentFilter = "consistent-filter",
    }
}

impl Law {
    /// The estimates to which it applies.
    pub(crate) fn subject(self) -> &'static str {
        match self {
            Law::ZeemanTables => "relock",
            Law::StrategicGrade | Law::NavigationGrade | Law::TacticalGrade => "navigation",
            Law::ConsistentFilter => "filters in navigation",
            _ => "gap fillers",
        }
    }

    /// Its column in the table. Z(20) holds for one tick while charts show the whole gap, and the noise is 3σ; each
    /// label says so.
    pub fn about(self) -> About {
        let unit = match self {
            Law::StrategicGrade | Law::NavigationGrade | Law::TacticalGrade => Unit::NMI,
            Law::ConsistentFilter => Unit::NONE,
            _ => Unit::ARCSEC,
        };
        let (name, label, meaning) = match self {
            Law::TaylorExtremum => (
                "reference_taylor_extremum",
                "Taylor term of one tick at an extremum, as published, Z(20)",
                "A reference curve of the chart, ″: the first Taylor term that the filler drops at an extremum of the rate, of a single tick as \
                 published in Z(20).",
            ),
            Law::TaylorZeroCrossing => (
                "reference_taylor_zero_crossing",
                "Taylor term of one tick at a zero crossing, as published, Z(20)",
                "A reference curve of the chart, ″: the first Taylor term that the filler drops near a zero crossing of the rate, of a single \
                 tick as published in Z(20).",
            ),
            Law::NoiseAsPublished => (
                "reference_noise_as_published",
                "3σ noise of const as published, growing as √n",
                "A reference curve of the chart, ″: 3 σ of the constant filler as published, which grows as √n with the lost ticks.",
            ),
            Law::Noise => (
                "reference_noise",
                "3σ noise of const by Z(18), growing as n",
                "A reference curve of the chart, ″: 3 σ of the constant filler by Z(18), which grows as n with the lost ticks.",
            ),
            Law::ZeemanTables => (
                "reference_zeeman_tables",
                "the paper's tables 1 and 2",
                "A reference curve of the chart, ″: tables 1 and 2 of the paper, measured and compensated.",
            ),
            Law::StrategicGrade => (
                "reference_strategic_grade",
                "strategic grade, 0.02 nmi/h",
                "A reference curve of the chart, nmi: 0.02 nmi for each hour, the class of strategic navigators.",
            ),
            Law::NavigationGrade => (
                "reference_navigation_grade",
                "navigation grade, 1 nmi/h",
                "A reference curve of the chart, nmi: 1 nmi for each hour, the class of navigators of aircraft.",
            ),
            Law::TacticalGrade => (
                "reference_tactical_grade",
                "tactical grade, 10 nmi/h",
                "A reference curve of the chart, nmi: 10 nmi for each hour, the class of tactical navigators.",
            ),
            Law::ConsistentFilter => (
                "reference_consistent_filter",
                "a consistent filter, 1",
                "A reference curve of the chart: 1, the mean squared error over the claimed variance of a consistent filter.",
            ),
        };
        About { unit, label, role: Role::Law, meaning, ..About::named(name) }
    }

    /// The name of its column in the table.
    pub fn column(self) -> &'static str {
        self.about().name
    }
}
