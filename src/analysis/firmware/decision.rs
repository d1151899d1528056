//! The decision to which fillers at a point lead.

use crate::analysis::decision::Lines;
use crate::analysis::firmware::{Candidate, Design, Firmware, Trade};
use crate::quantity::number::{percent, significant};

impl Firmware {
    /// The decision: that of the search where there is one, else which filler leaves least. `None` where no motion and no
    /// noise is given that determines an error.
    pub fn decision(&self) -> Option<Lines> {
        match &self.trade {
            Some(trade) => Some(trade.decision()),
            None => self.of_designs(),
        }
    }

    fn of_designs(&self) -> Option<Lines> {
        let known = self.ranked();
        let &(best, size) = known.first()?;
        let rms = best.robust_rms()?;
        let level = best.judged.map(|judged| judged.worst().level);
        let (met, requirement, margin) = match (self.limit_arcsec, level) {
            (Some(limit), Some(level)) => held(level, limit),
            (Some(limit), None) => {
                let requirement = format!(
                    "Not decided here: {} limits the 99.73 % residual, which `sagnac run` samples; the rms residual is {}.",
                    arcsec(limit),
                    arcsec(rms)
                );
                (None, requirement, "It is unknown without that residual.".to_owned())
            }
            (None, _) => {
                let told = match self.shift {
                    None => format!("None is given; 99.73 % of residuals are below {}.", arcsec(size)),
                    Some(_) => format!("None is given; the rms residual is {}.", arcsec(size)),
                };
                (None, told, above(size, &known))
            }
        };
        let option = match known.get(1) {
            Some((next, value)) => {
                format!(
                    "{}, of {} fillers; next is {} with {}.",
                    best.name,
                    known.len(),
                    next.name,
                    arcsec(*value)
                )
            }
            None => format!("{}; there is only one filler with a known error.", best.name),
        };
        let sentences = [
            requirement,
            option,
            margin,
            limits(rms, best.noise_rms),
            "Not searched; --limit or --latency searches the ticks of a minimum-variance filler.".to_owned(),
        ];
        Some(Lines { met, sentences })
    }
}

impl Trade {
    fn decision(&self) -> Lines {
        let chosen = self.chosen;
        let (met, requirement, margin) = match self.asked.limit_arcsec {
            Some(limit) => held(chosen.level, limit),
            None => {
                let requirement =
                    format!("None is given; 99.73 % of residuals are below {}.", arcsec(chosen.level));
                (None, requirement, "Without a limit there is none.".to_owned())
            }
        };
        let sentences = [
            requirement,
            format!("{}, of {} choices of ticks.", self.told(chosen), self.candidates.len()),
            margin,
            limits(chosen.rms, chosen.noise_rms),
            self.lever(),
        ];
        Lines { met, sentences }
    }

    /// What other ticks would gain.
    fn lever(&self) -> String {
        let least = self.candidates.iter().min_by(|a, b| a.level.total_cmp(&b.level));
        match least.filter(|least| least.level < self.chosen.level) {
            Some(&least) => {
                format!("Ticks that are read: {} leave {}, the least.", self.told(least), arcsec(least.level))
            }
            None => "No other ticks within the latency leave less.".to_owned(),
        }
    }

    fn told(&self, one: Candidate) -> String {
        let latency_ms = significant(1e3 * self.latency_s(one), 4);
        format!("{} ticks before the gap and {} after it ({latency_ms} ms)", one.before, one.after)
    }
}

/// Whether a 99.73 % residual is within a limit, ″, as a sentence too, with the margin.
fn held(level: f64, limit: f64) -> (Option<bool>, String, String) {
    let is_met = level <= limit;
    let (begin, side) = if is_met { ("Met", "within") } else { ("Not met", "above") };
    let requirement =
        format!("{begin}: 99.73 % of residuals are below {}, {side} {}.", arcsec(level), arcsec(limit));
    let margin = match level / limit {
        part if is_met => format!("{} of the limit is left.", percent(1.0 - part)),
        part => format!("The level is {} times the limit.", significant(part, 3)),
    };
    (Some(is_met), requirement, margin)
}

/// How far the next filler is above the best.
fn above(best: f64, known: &[(&Design, f64)]) -> String {
    match known.get(1) {
        Some((_, next)) => format!("The next filler is {} above the best.", percent(next / best - 1.0)),
        None => "Without a limit there is none.".to_owned(),
    }
}

/// The shares of motion and noise in the mean square, which are independent.
fn limits(rms: f64, noise_rms: f64) -> String {
    let part = (noise_rms / rms).min(1.0);
    let noise = part * part;
    let mut parts = [("motion", 1.0 - noise), ("noise of ticks and readout", noise)];
    parts.sort_by(|a, b| b.1.total_cmp(&a.1));
    let [(first, most), (second, least)] = parts;
    format!("The {first} is {} of the mean square, the {second} {}.", percent(most), percent(least))
}

fn arcsec(value: f64) -> String {
    format!("{} arcsec", significant(value, 4))
}
