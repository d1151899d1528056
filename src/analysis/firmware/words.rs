//! Fillers in words.

use crate::analysis::firmware::{Design, Firmware, Trade};
use crate::kinds::gap_fill::judged::{Judged, Size, deviation};
use crate::quantity::number::significant;

impl Firmware {
    /// The answer in one sentence: what the chosen ticks leave, or which filler leaves least. The error is that on motion for which
    /// the filler was not designed, where it is known.
    pub fn headline(&self) -> String {
        if let Some(trade) = &self.trade {
            return trade.headline();
        }
        let known = self.ranked();
        match known[..] {
            [] => self.gains(),
            [(only, rms)] => format!("{} leaves {}.", only.name, only.error(rms, self.shift)),
            [(best, rms), (next, next_rms), ..] => format!(
                "Of {} fillers {} leaves least: {}. Next is {} with {}.",
                known.len(),
                best.name,
                best.error(rms, self.shift),
                next.name,
                next.error(next_rms, self.shift)
            ),
        }
    }

    /// The fillers with the residual by which they compare, ″, the least first: the 99.73 % level on a specification, else the
    /// rms, as far as it is known.
    pub(crate) fn ranked(&self) -> Vec<(&Design, f64)> {
        let size = |design: &Design| match self.shift {
            None => design.judged.map(|judged| judged.worst().level),
            Some(_) => design.robust_rms(),
        };
        let mut known: Vec<(&Design, f64)> =
            self.designs.iter().filter_map(|design| Some((design, size(design)?))).collect();
        known.sort_by(|a, b| a.1.total_cmp(&b.1));
        known
    }

    /// When the correction of a filler comes, and the residual to expect, in ASCII.
    pub fn expected(&self, design: &Design) -> String {
        let ticks = design.latency_ticks;
        let plural = if ticks == 1 { "" } else { "s" };
        let latency_ms = self.tick_s.map(|tick_s| significant(1e3 * tick_s * f64::from(ticks), 4));
        let latency_ms = latency_ms.map_or_else(String::new, |latency_ms| format!(" ({latency_ms} ms)"));
        let number = |value: f64| significant(value, 5);
        let residual = match (design.judged.map(Judged::worst), design.errors[0].rms) {
            (Some(Size { rms, level }), _) => format!(
                "; residual {} arcsec rms, {} arcsec at 99.73 %, with {}",
                number(rms),
                number(level),
                deviation(self.shift)
            ),
            (None, Some(rms)) if rms > 0.0 => format!("; residual {} arcsec rms", number(rms)),
            _ => String::new(),
        };
        format!("latency {ticks} tick{plural}{latency_ms}{residual}")
    }

    /// The noise gains, where neither motion nor noise is known.
    fn gains(&self) -> String {
        let gain = |design: &Design| {
            format!("{} {}", design.name, significant(design.interpolation.whole().noise_gain(), 4))
        };
        let gains: Vec<String> = self.designs.iter().map(gain).collect();
        let ticks = if self.gap_ticks == 1 { "tick" } else { "ticks" };
        format!(
            "Over {} lost {ticks} the noise of a tick is multiplied by √Σw²: {}.",
            self.gap_ticks,
            gains.join(", ")
        )
    }
}

impl Design {
    /// The rms residual, ″: with shifted frequencies where the filler is designed for the very motion of the point.
    pub fn robust_rms(&self) -> Option<f64> {
        self.judged.map(|judged| judged.worst().rms).or(self.errors[0].rms).filter(|rms| *rms > 0.0)
    }

    fn error(&self, size: f64, shift: Option<f64>) -> String {
        let number = |size: f64| significant(size, 4);
        match (self.judged, shift) {
            (Some(Judged { own, .. }), None) => {
                format!(
                    "{} arcsec at 99.73 % with {} ({} arcsec as given)",
                    number(size),
                    deviation(shift),
                    number(own.level)
                )
            }
            (Some(Judged { own, .. }), Some(_)) => {
                format!(
                    "{} arcsec rms with {} ({} arcsec as given)",
                    number(size),
                    deviation(shift),
                    number(own.rms)
                )
            }
            (None, _) => format!("{} arcsec rms", number(size)),
        }
    }
}

impl Trade {
    fn headline(&self) -> String {
        let chosen = self.chosen;
        let (level, latency_ms) =
            (significant(chosen.level, 4), significant(1e3 * self.latency_s(chosen), 4));
        let limit = self.asked.limit_arcsec.map_or_else(String::new, |limit| significant(limit, 6));
        let met = match self.meets() {
            None => String::new(),
            Some(true) => format!(", within the limit of {limit} arcsec"),
            Some(false) => format!("; no ticks within the latency meet the limit of {limit} arcsec"),
        };
        format!(
            "{} ticks before the gap and {} after it ({latency_ms} ms) leave 99.73 % of residuals below {level} arcsec with {}{met}.",
            chosen.before,
            chosen.after,
            deviation(self.shift)
        )
    }
}
