//! Laws that a chart draws beside the estimates.

use crate::key::holds::words;
use crate::table::{About, Role, Unit};

words! {
    /// A law of error, as published or put right, drawn beside curves.
    pub enum Law {
        /// Z(20): first dropped Taylor term at an extremum of the rate; the error of one tick, not of the whole gap.
        TaylorExtremum = "taylor-extremum",
        /// Z(20): the same near a zero crossing of the rate, for linear and quadratic.
        TaylorZeroCrossing = "taylor-zero-crossing",
        /// Noise of const over the gap as published: A_n √n / 2, A_n = 3σ of one tick.
        NoiseAsPublished = "noise-as-published",
        /// Noise of const over the gap by Z(18): A_n n / 2 for a fit to four ticks.
        Noise = "noise",
        /// The paper's tables 1 and 2: what was measured after a switch, and what the paper's compensations leave of it. Of
        /// kind = "relock".
        ZeemanTables = "zeeman-tables",
    }
}

impl Law {
    /// The estimates that it is about.
    pub(crate) fn subject(self) -> &'static str {
        match self {
            Law::ZeemanTables => "relock",
            _ => "gap fillers",
        }
    }

    /// Its column in the table.
    pub(crate) fn about(self) -> About {
        let meaning = match self {
            Law::TaylorExtremum => {
                "A law of the chart, ″: the first Taylor term that the filler drops at an extremum of the rate, of a single tick as \
                 published in Z(20)."
            }
            Law::TaylorZeroCrossing => {
                "A law of the chart, ″: the first Taylor term that the filler drops near a zero crossing of the rate, of a single \
                 tick as published in Z(20)."
            }
            Law::NoiseAsPublished => {
                "A law of the chart, ″: 3 σ of the constant filler as published, which grows as √n with the lost ticks."
            }
            Law::Noise => {
                "A law of the chart, ″: 3 σ of the constant filler as it should be by Z(18), which grows as n with the lost ticks."
            }
            Law::ZeemanTables => {
                "A law of the chart, ″: tables 1 and 2 of the paper, measured and compensated."
            }
        };
        let (name, label) = (self.column(), self.label());
        About { unit: Unit::ARCSEC, label, role: Role::Law, meaning, ..About::named(name) }
    }

    /// The name of its column in the table.
    pub fn column(self) -> &'static str {
        match self {
            Law::TaylorExtremum => "law_taylor_extremum",
            Law::TaylorZeroCrossing => "law_taylor_zero_crossing",
            Law::NoiseAsPublished => "law_noise_as_published",
            Law::Noise => "law_noise",
            Law::ZeemanTables => "law_zeeman_tables",
        }
    }

    /// For people. Z(20) is about one tick, the charts about the whole gap, and the noise is 3σ: each label says so.
    pub fn label(self) -> &'static str {
        match self {
            Law::TaylorExtremum => "Taylor term of one tick at an extremum, as published, Z(20)",
            Law::TaylorZeroCrossing => "Taylor term of one tick at a zero crossing, as published, Z(20)",
            Law::NoiseAsPublished => "3σ noise of const as published, growing as √n",
            Law::Noise => "3σ noise of const by Z(18), growing as n",
            Law::ZeemanTables => "the paper's tables 1 and 2",
        }
    }
}
