//! The search for the ticks of a minimum-variance filler: how many before and after the gap meet a limit.
//!
//! Each candidate reads the nearest ticks on either side. It is designed for the motion and judged on a shifted one: its
//! error is the level below which 99.73 % of residuals stay, with noise, at worst of the motion as given and with all
//! frequencies lower or higher by the shift, or with those of a specification within their tolerances. The level is that of the
//! distribution for a sine, also of random frequency, and for the line of a specification with the largest residual; all else
//! counts as normally distributed. A correction comes as many ticks after the gap as the filler reads there, which is its
//! latency.

use rayon::prelude::*;

use sagnac_base::quantity::number::significant;
use sagnac_base::table::column::{ColumnOf, columns_of};
use sagnac_base::table::{Cell, Role, Table, Unit};
use sagnac_engine::filler::{MINIMUM_VARIANCE, Target};
use sagnac_engine::key::sweep::Scale;
use sagnac_engine::kinds::gap_fill::columns::{Judge, Size, deviation, of_noise, shift};
use sagnac_engine::kinds::gap_fill::inputs::Inputs;
use sagnac_engine::kinds::gap_fill::lower::fixed::Statistics;
use sagnac_kernel::gap_fill::shape::MAX_SIDE;
use sagnac_report::chart::figure::{Axis, Figure, Grouping, Limit, Mark, Series, SeriesPoint, Shape};
use sagnac_theory::minimum_variance::{Band, TickRows, minimum_variance_weights};

/// Most ticks before the gap.
const MAX_BEFORE: u32 = 32;
/// Most ticks after the gap.
const MAX_AFTER: u32 = 16;
/// Excess over the least error up to which fewer ticks are preferred, where no limit is given.
const AS_GOOD: f64 = 1.05;
/// Numbers of ticks after the gap that the chart shows, beside the chosen one.
const SHOWN: [u32; 6] = [0, 1, 2, 4, 8, 16];

/// The requirements that a filler must meet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Asked {
    /// Largest 99.73 % residual, ″.
    pub limit_arcsec: Option<f64>,
    /// Longest time from the end of the gap to the correction, s; without it 16 ticks.
    pub latency_s: Option<f64>,
}

/// Numbers of ticks that a filler reads, with its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Ticks before the gap.
    pub before: u32,
    /// Ticks after the gap.
    pub after: u32,
    /// Rms residual on the motion as given, ″.
    pub own_rms: f64,
    /// Largest rms residual on the motion as given and on the shifted ones, ″.
    pub rms: f64,
    /// The part of the rms residual that comes from noise and whole pulses, ″.
    pub noise_rms: f64,
    /// Level below which 99.73 % of residuals stay on the motion as given, ″.
    pub own_level: f64,
    /// The largest such level on the motion as given and on the shifted ones, ″.
    pub level: f64,
}

/// A candidate with its latency, s.
type Row<'a> = (&'a Candidate, f64);

/// The columns of `trade.csv`.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<ColumnOf<Row<'a>>> {
    type Of<'a> = ColumnOf<Row<'a>>;
    vec![
        Of::new("after", Unit::NONE, "ticks after", |(one, _)| Cell::Integer(one.after.into()))
            .is(Role::Key, "Ticks after the gap that the filler reads."),
        Of::new("before", Unit::NONE, "ticks before", |(one, _)| Cell::Integer(one.before.into()))
            .is(Role::Key, "Ticks before the gap that the filler reads."),
        Of::new("latency", Unit::S, "latency", |(_, latency_s)| Cell::Number(*latency_s))
            .is(Role::Coordinate, "Time from the end of the gap to the correction, s."),
        Of::new("own_rms", Unit::ARCSEC, "rms residual as given", |(one, _)| Cell::Number(one.own_rms))
            .is(Role::Estimate, "Root mean square residual on the motion as given, with noise, ″."),
        Of::new("rms", Unit::ARCSEC, "rms residual", |(one, _)| Cell::Number(one.rms))
            .is(Role::Error, "The largest root mean square residual on the motion as given and with all frequencies 5 % lower or higher, or with \
                those of a specification within their tolerances, ″."),
        Of::new("own_p99_73", Unit::ARCSEC, "99.73 % residual as given", |(one, _)| Cell::Number(one.own_level))
            .is(Role::Estimate, "Level below which 99.73 % of residuals stay on the motion as given, with noise, ″."),
        Of::new("p99_73", Unit::ARCSEC, "99.73 % residual", |(one, _)| Cell::Number(one.level))
            .is(Role::Error, "The largest such level on the motion as given and with all frequencies 5 % lower or higher, or with those of a \
                specification within their tolerances, by which the ticks are chosen, ″."),
    ]
}

/// The candidates and the choice among them.
#[derive(Debug, Clone, PartialEq)]
pub struct Trade {
    /// What was asked.
    pub asked: Asked,
    /// Tick T, s.
    pub tick_s: f64,
    /// Relative change of all frequencies on which candidates are judged; `None` where a specification has tolerances.
    pub shift: Option<f64>,
    /// All candidates, by ticks after and then before the gap.
    pub candidates: Vec<Candidate>,
    /// The candidate of the fewest ticks after the gap, and then before it, that meets the limit. Without a limit, and
    /// where none meets it, that of the fewest ticks within 5 % of the least error.
    pub chosen: Candidate,
}

impl Trade {
    /// Searches the ticks for the motion and noise of a point, or for as much motion in a band; `None` if the motion
    /// determines no weights without more noise.
    pub fn new(inputs: &Inputs, asked: Asked, band: Option<Band>) -> Option<Trade> {
        let (n, tick_s) = (inputs.gap_ticks, inputs.tick_s);
        let most_after = asked.latency_s.map_or(MAX_AFTER, |latency_s| {
            // Times are rounded to 12 digits, which must not drop a tick.
            let ticks = libm::floor(latency_s / tick_s * (1.0 + 1e-11));
            ticks.clamp(0.0, f64::from(MAX_AFTER)) as u32
        });
        let judge = Judge::new(inputs, MAX_SIDE);
        let target = Target::new(band, inputs.specification.as_ref());
        let design: &TickRows = &Statistics::new(inputs).motion(&target, MAX_SIDE);
        let candidate = |(after, before): (u32, u32)| {
            let ticks = ticks_at(n, before, after);
            let weights = minimum_variance_weights(&ticks, n, design, &inputs.noise_covariance())?;
            let judged = judge.judge(&ticks, &weights);
            let noise_rms = of_noise(inputs, &ticks, &weights);
            let Size { rms: own_rms, level: own_level } = judged.own;
            let Size { rms, level } = judged.worst();
            Some(Candidate { before, after, own_rms, rms, noise_rms, own_level, level })
        };
        let sides = (0..=most_after).flat_map(|after| (1..=MAX_BEFORE).map(move |before| (after, before)));
        let sides: Vec<(u32, u32)> = sides.collect();
        let candidates: Vec<Candidate> = sides.into_par_iter().filter_map(candidate).collect();
        let least = candidates.iter().map(|candidate| candidate.level).min_by(f64::total_cmp)?;
        let met = candidates.iter().find(|one| asked.limit_arcsec.is_some_and(|limit| one.level <= limit));
        let as_good = candidates.iter().filter(|one| one.level <= AS_GOOD * least);
        let chosen = *met.or_else(|| as_good.min_by_key(|one| one.before + one.after))?;
        Some(Trade { asked, tick_s, shift: shift(inputs), candidates, chosen })
    }

    /// The fit ticks of the choice, as options take them.
    pub fn fit_ticks(&self) -> String {
        fit_ticks(self.chosen.before, self.chosen.after).join(",")
    }

    /// The filler of the choice as a study writes it, for the motion of the study.
    pub(crate) fn entry(&self) -> toml::Value {
        let Candidate { before, after, .. } = self.chosen;
        entry(format!("searched {before}+{after}"), before, after).into()
    }

    /// For each number of ticks after the gap the fewest before it that meet the limit; without a limit, and where none
    /// meets it, those of the least error.
    pub fn rows(&self) -> Vec<Candidate> {
        let each = self.candidates.chunk_by(|a, b| a.after == b.after);
        let row = |own: &[Candidate]| {
            let met = own.iter().find(|one| self.asked.limit_arcsec.is_some_and(|limit| one.level <= limit));
            met.or_else(|| own.iter().min_by(|a, b| a.level.total_cmp(&b.level))).copied()
        };
        each.filter_map(row).collect()
    }

    /// The error over the ticks before the gap, a curve for each number of ticks after it.
    pub fn figure(&self) -> Figure {
        let shown = |after: u32| SHOWN.contains(&after) || after == self.chosen.after;
        let each = self.candidates.chunk_by(|a, b| a.after == b.after).filter(|own| shown(own[0].after));
        let of = |(colour, own): (usize, &[Candidate])| {
            let point = |one: &Candidate| SeriesPoint::new(f64::from(one.before), one.level);
            Series::of_points(colour, own.iter().map(point).collect())
        };
        let name = |own: &[Candidate]| {
            format!("{} ({} ms)", own[0].after, significant(1e3 * self.latency_s(own[0]), 4))
        };
        let limit = self.asked.limit_arcsec;
        Figure {
            title: "Error and latency of a filler by the ticks that it reads".to_owned(),
            subtitle: Some(format!("worst case of {}", deviation(self.shift))),
            x: Axis { whole: true, scale: Scale::Linear, ..Axis::new("ticks before the gap", "") },
            y: Axis::new("99.73 % residual", "″"),
            colours: Grouping::new("ticks after (latency)", each.clone().map(name)),
            series: each.enumerate().map(of).collect(),
            limit: limit.map(|value| Limit { value, label: format!("limit {}″", significant(value, 6)) }),
            marks: vec![Mark {
                shape: Shape::Crossing,
                place: (f64::from(self.chosen.before), self.chosen.level),
                range: None,
                label: format!("{}+{}", self.chosen.before, self.chosen.after),
            }],
            ..Figure::default()
        }
    }

    /// Time from the end of the gap to the correction, s.
    pub fn latency_s(&self, candidate: Candidate) -> f64 {
        f64::from(candidate.after) * self.tick_s
    }

    /// All candidates as a table.
    pub fn table(&self) -> Table {
        let rows: Vec<Row> = self.candidates.iter().map(|one| (one, self.latency_s(*one))).collect();
        Table { columns: columns_of(&columns(), &rows) }
    }
}

/// The ticks before and after a gap as a study writes them.
fn fit_ticks(before: u32, after: u32) -> Vec<String> {
    let first = format!("{}..0", 1 - before.cast_signed());
    std::iter::once(first).chain((after > 0).then(|| format!("n+1..n+{after}"))).collect()
}

/// These ticks at a gap of `n` ticks.
pub(crate) fn ticks_at(n: u32, before: u32, after: u32) -> Vec<i32> {
    let after_gap = (n + 1..=n + after).map(u32::cast_signed);
    (1 - before.cast_signed()..=0).chain(after_gap).collect()
}

/// A filler of least variance as a study writes it, by the ticks before and after the gap that it reads.
pub(crate) fn entry(name: String, before: u32, after: u32) -> toml::Table {
    let fit_ticks: Vec<toml::Value> = fit_ticks(before, after).into_iter().map(Into::into).collect();
    let mut entry = toml::Table::new();
    entry.insert("kind".to_owned(), MINIMUM_VARIANCE.into());
    entry.insert("name".to_owned(), name.into());
    entry.insert("fit_ticks".to_owned(), fit_ticks.into());
    entry
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_engine::kinds::gap_fill::inputs::TickNoise;
    use sagnac_engine::motion::{Gaussian, Motion};

    /// Whether the choice meets the limit; `None` without one.
    fn is_met(trade: &Trade) -> Option<bool> {
        trade.asked.limit_arcsec.map(|limit| trade.chosen.level <= limit)
    }

    fn inputs() -> Inputs {
        let band = Band { low_hz: 18.0, high_hz: 22.0 };
        Inputs {
            tick_s: 0.005,
            tick_noise: TickNoise::Std(0.5),
            readout_lsb: 0.0,
            relock: vec![],
            motion: Motion { gaussian: Some(Gaussian::Band { rms: 8485.0, band }), ..Motion::default() },
            specification: None,
            gap_ticks: 3,
        }
    }

    #[test]
    fn the_choice_is_the_soonest_that_meets_the_limit_with_the_fewest_ticks() {
        let asked = Asked { limit_arcsec: Some(9.0), latency_s: Some(0.02) };
        let trade = Trade::new(&inputs(), asked, None).unwrap();
        let Candidate { before, after, level, .. } = trade.chosen;
        assert!(level <= 9.0 && is_met(&trade) == Some(true) && after <= 4, "{:?}", trade.chosen);
        for one in &trade.candidates {
            assert!(one.after <= 4 && one.rms >= one.own_rms && one.level >= one.own_level, "{one:?}");
            let sooner = (one.after, one.before) < (after, before);
            assert!(!sooner || one.level > 9.0, "{one:?} is sooner than {:?}", trade.chosen);
        }
        assert_eq!(trade.rows().len(), 5);
        assert_eq!(trade.fit_ticks(), format!("{}..0,n+1..n+{after}", 1 - before.cast_signed()));
    }

    #[test]
    fn levels_of_gaussian_motion_are_three_times_the_rms() {
        let trade = Trade::new(&inputs(), Asked::default(), None).unwrap();
        for one in &trade.candidates {
            assert!((one.level / one.rms - 2.999_977).abs() < 1e-5, "{one:?}");
        }
    }

    #[test]
    fn without_a_limit_and_beyond_it_few_ticks_come_near_to_the_least_error() {
        let of = |limit_arcsec| Trade::new(&inputs(), Asked { limit_arcsec, latency_s: None }, None).unwrap();
        let (free, strict) = (of(None), of(Some(1e-6)));
        assert_eq!((is_met(&free), is_met(&strict)), (None, Some(false)));
        assert_eq!(free.chosen, strict.chosen);
        let least = free.candidates.iter().map(|one| one.level).fold(f64::INFINITY, f64::min);
        assert!(free.chosen.level <= 1.05 * least);
    }

    #[test]
    fn for_many_motions_and_limits_no_candidate_beats_the_choice_and_its_rows() {
        for case in 0..10 {
            let mut inputs = inputs();
            let (low_hz, rms) = (5.0 + 8.0 * f64::from(case), libm::exp10(0.5 * f64::from(case % 9)));
            let band = Band { low_hz, high_hz: low_hz + f64::from(case % 4) };
            inputs.gap_ticks = 1 + case % 5;
            inputs.motion = Motion { gaussian: Some(Gaussian::Band { rms, band }), ..Motion::default() };
            let of = |limit_arcsec| {
                Trade::new(&inputs, Asked { limit_arcsec, latency_s: Some(0.02) }, None).unwrap()
            };
            let free = of(None);
            let levels = || free.candidates.iter().map(|one| one.level);
            let (least, most) = (levels().fold(f64::INFINITY, f64::min), levels().fold(0.0, f64::max));
            let limits = [0.9 * least, 1.01 * least, 1.2 * least, libm::sqrt(least * most), most];
            for limit in [None].into_iter().chain(limits.map(Some)) {
                let trade = of(limit);
                let meets = |one: &Candidate| limit.is_some_and(|limit| one.level <= limit);
                let chosen = trade.chosen;
                let is_better = |one: &&Candidate| match is_met(&trade) {
                    Some(true) => meets(one) && (one.after, one.before) < (chosen.after, chosen.before),
                    _ => {
                        let is_fewer = one.before + one.after < chosen.before + chosen.after;
                        meets(one) || (one.level <= AS_GOOD * least && is_fewer)
                    }
                };
                let better = trade.candidates.iter().find(is_better);
                assert_eq!(better, None, "case {case}, {limit:?} ″: better than {chosen:?}");
                for row in trade.rows() {
                    let is_better = |one: &&Candidate| {
                        one.after == row.after
                            && if meets(&row) {
                                meets(one) && one.before < row.before
                            } else {
                                one.level < row.level
                            }
                    };
                    let better = trade.candidates.iter().find(is_better);
                    assert_eq!(better, None, "case {case}, {limit:?} ″: better than {row:?}");
                }
            }
        }
    }
}
