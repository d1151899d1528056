//! Lists of ticks for fits: numbers, `"n+1"`, ranges `"-7..0"`, where n is the length of the gap.

use sagnac_kernel::gap_fill::shape::MAX_SIDE;
use std::fmt;
use std::ops::Range;

use toml::Spanned;

use crate::key::given::Given;
use sagnac_base::source::diagnose::Fault;

/// Largest distance of a tick from the gap; a fit over farther ticks says nothing about the gap.
pub(crate) const FARTHEST: i64 = MAX_SIDE as i64;

/// Accepted entries of a list of ticks.
const ACCEPTED: &str =
    "accepted: whole numbers such as -1, texts such as \"n+1\", inclusive ranges such as \"-7..0\"";

/// One tick: `offset`, or `n + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tick {
    after_gap: bool,
    offset: i64,
}

impl Tick {
    fn parse(text: &str) -> Option<Tick> {
        let plain: String = text.replace('−', "-").split_whitespace().collect();
        let parse = |digits: &str| digits.parse::<i32>().ok().map(i64::from);
        match plain.strip_prefix('n') {
            Some("") => Some(Tick { after_gap: true, offset: 0 }),
            Some(offset) if offset.starts_with(['+', '-']) => {
                Some(Tick { after_gap: true, offset: parse(offset)? })
            }
            Some(_) => None,
            None => Some(Tick { after_gap: false, offset: parse(&plain)? }),
        }
    }

    /// The number of the tick at a gap of `n`.
    fn at(self, n: i64) -> i64 {
        if self.after_gap { n + self.offset } else { self.offset }
    }
}

/// Ticks after the gap after which a correction comes that reads these ticks: that of the last of them.
pub fn latency_ticks(fit_ticks: &[i32], gap_ticks: u32) -> u32 {
    fit_ticks.iter().map(|tick| tick - gap_ticks.cast_signed()).fold(0, i32::max).cast_unsigned()
}

/// The purpose of a list, which determines the allowed ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Purpose {
    Residual,
    Extrapolation,
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Purpose::Residual => "switching.fit_ticks",
            Purpose::Extrapolation => "switching.extrapolation_ticks",
        })
    }
}

/// The ticks to which a polynomial is fitted, before n is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TickList {
    pub(crate) purpose: Purpose,
    /// Place of the whole list; empty at 0 if the list is the default one.
    pub(crate) span: Range<usize>,
    /// First and last tick of each inclusive range.
    ranges: Vec<Spanned<(Tick, Tick)>>,
}

impl TickList {
    /// Reads the list as `written`, or takes the default of its `purpose`.
    pub(crate) fn read(purpose: Purpose, written: Option<Given>) -> Result<TickList, Fault> {
        let Some(written) = written else {
            return Ok(TickList::default_for(purpose));
        };
        let ranges = written.items().into_iter().map(|item| {
            let range = match item.integer() {
                Some(i) => Some(Tick { after_gap: false, offset: i }).map(|tick| (tick, tick)),
                None => match item.text().split_once("..") {
                    Some((from, to)) => Tick::parse(from).zip(Tick::parse(to)),
                    None => Tick::parse(item.text()).map(|tick| (tick, tick)),
                },
            };
            let fault = || item.fault(format!("{purpose}: {item} names no tick"), "not a tick", ACCEPTED);
            Ok(Spanned::new(item.span(), range.ok_or_else(fault)?))
        });
        Ok(TickList { purpose, span: written.span(), ranges: ranges.collect::<Result<_, Fault>>()? })
    }

    fn default_for(purpose: Purpose) -> TickList {
        let plain = |offset| Tick { after_gap: false, offset };
        let after = |offset| Tick { after_gap: true, offset };
        let ranges = match purpose {
            Purpose::Residual => vec![(plain(-1), plain(0)), (after(1), after(2))],
            Purpose::Extrapolation => vec![(plain(-3), plain(0))],
        };
        let ranges = ranges.into_iter().map(|range| Spanned::new(0..0, range)).collect();
        TickList { purpose, span: 0..0, ranges }
    }

    /// The ticks at a gap of `gap_ticks`, ascending.
    pub(crate) fn resolve(&self, gap_ticks: u32) -> Result<Vec<i32>, Fault> {
        let mut ticks = self.as_written(gap_ticks)?;
        ticks.sort_unstable();
        Ok(ticks)
    }

    /// The ticks in the order written, which must be ascending because given weights belong to them in that order.
    pub(crate) fn resolve_in_order(&self, gap_ticks: u32) -> Result<Vec<i32>, Fault> {
        let ticks = self.as_written(gap_ticks)?;
        if ticks.is_sorted() {
            return Ok(ticks);
        }
        let message = format!("{}: ticks {ticks:?} do not rise (at gap_ticks = {gap_ticks})", self.purpose);
        let help = "write ticks from the earliest to the latest, and each weight at the place of its tick";
        Err(Fault::new(self.span.clone(), message, "not in the order of time", help))
    }

    fn as_written(&self, gap_ticks: u32) -> Result<Vec<i32>, Fault> {
        let n = i64::from(gap_ticks);
        let mut ticks = Vec::new();
        for item in &self.ranges {
            let (from, to) = (item.get_ref().0.at(n), item.get_ref().1.at(n));
            let refuse = |what: String, label: &str, help: String| {
                let message = format!("{}: {what} (at gap_ticks = {n})", self.purpose);
                Err(Fault::new(item.span(), message, label, help))
            };
            if let Some(far) =
                [from, to].into_iter().find(|tick| !(1 - FARTHEST..=n + FARTHEST).contains(tick))
            {
                let help = format!("accepted: ticks {} … 0 and n+1 … n+{FARTHEST}", 1 - FARTHEST);
                let what = format!("tick {far} is more than {FARTHEST} ticks from the gap");
                return refuse(what, "too far from the gap", help);
            }
            if from > to {
                return refuse(
                    format!("the range {from}..{to} runs backwards"),
                    "an empty range",
                    format!("write {to}..{from}"),
                );
            }
            for tick in from..=to {
                if (1..=n).contains(&tick) {
                    let what = format!("tick {tick} lies inside the gap, which is ticks 1 … {n}");
                    let help =
                        "take ticks before the gap, 0 and down, or after it, \"n+1\" and up".to_owned();
                    return refuse(what, "inside the gap", help);
                }
                if self.purpose == Purpose::Extrapolation && tick > 0 {
                    let what = format!("tick {tick} comes after the gap, an extrapolation cannot know it");
                    return refuse(what, "after the gap", "accepted: ticks up to 0".to_owned());
                }
                // Bounded by FARTHEST on either side, so it fits.
                let tick = tick as i32;
                if ticks.contains(&tick) {
                    return refuse(
                        format!("tick {tick} is listed twice"),
                        "listed before",
                        "leave it out here".into(),
                    );
                }
                ticks.push(tick);
            }
        }
        Ok(ticks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filler::keys::FIT_TICKS;
    use crate::key::table::Table;

    fn list(purpose: Purpose, items: &str) -> Result<TickList, Fault> {
        let text = format!("fit_ticks = [{items}]");
        let root = toml::de::DeTable::parse(&text).unwrap();
        TickList::read(purpose, Table::root("switching", &root).get(&FIT_TICKS))
    }

    #[test]
    fn lists_follow_the_gap() {
        let written = list(Purpose::Residual, "'n+1..n + 2', -1, '−3', '0'").unwrap();
        assert_eq!(written.resolve(3).unwrap(), [-3, -1, 0, 4, 5]);
        assert_eq!(written.resolve(1).unwrap(), [-3, -1, 0, 2, 3]);
        assert_eq!(TickList::default_for(Purpose::Residual).resolve(2).unwrap(), [-1, 0, 3, 4]);
        assert_eq!(TickList::default_for(Purpose::Extrapolation).resolve(2).unwrap(), [-3, -2, -1, 0]);
    }

    #[test]
    fn lists_that_make_no_sense_are_refused() {
        let table = [
            ("'n'", "tick 3 lies inside the gap"),
            ("'-1..4'", "tick 1 lies inside the gap"),
            ("'0..-3'", "the range 0..-3 runs backwards"),
            ("'-64'", "tick -64 is more than 64 ticks"),
            ("'n+1..n+2000000000'", "more than 64 ticks"),
            ("-9223372036854775808", "more than 64 ticks"),
            ("9223372036854775807", "more than 64 ticks"),
        ];
        for (item, piece) in table {
            let fault = list(Purpose::Residual, item).unwrap().resolve(3).unwrap_err();
            assert!(format!("{fault:?}").contains(piece), "{fault:?}");
        }
        let twice = list(Purpose::Residual, "4, 'n+1'").unwrap();
        assert!(twice.resolve(2).is_ok());
        assert!(format!("{:?}", twice.resolve(3).unwrap_err()).contains("tick 4 is listed twice"));
        let turned = list(Purpose::Residual, "'n+1', 0").unwrap();
        assert!(format!("{:?}", turned.resolve_in_order(3).unwrap_err()).contains("[4, 0] do not rise"));
        let late = list(Purpose::Extrapolation, "'n+1'").unwrap();
        assert!(format!("{:?}", late.resolve(3).unwrap_err()).contains("comes after the gap"));
        for item in ["n1", "m+1", "1..2..3", "", "n+", "5 ms", "-7..=0"] {
            assert!(list(Purpose::Residual, &format!("'{item}'")).is_err(), "{item}");
        }
    }
}
