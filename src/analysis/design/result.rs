//! What a search for a design finds: candidates with their drift, the best one, and those that no other beats in all respects.

use crate::analysis::decision::{DecisionError, Sheet, decide_at, short};
use crate::analysis::design::candidates::{Constraints, Cost, keep};
use crate::analysis::design::optimum::{T_95, of_halves};
use crate::analysis::design::{Measure, PapersRule};
use sagnac_base::quantity::{Dimension, Quantity};
use sagnac_base::table::{Column, Unit};
use sagnac_engine::drift::INTERVAL;
use sagnac_engine::key::sweep::{Sweep, SweepValue};
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::study::Study;
use sagnac_report::answer::Reading;

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Value, in the unit of the measure.
    pub value: f64,
    /// 95 % interval; absent for too few runs.
    pub interval: Option<(f64, f64)>,
}

impl Found {
    /// A value without an interval.
    pub(crate) fn exact(value: f64) -> Found {
        Found { value, interval: None }
    }

    /// The ends of the interval.
    pub(crate) fn ends(self) -> [Option<f64>; 2] {
        self.interval.map_or([None; 2], |(low, high)| [Some(low), Some(high)])
    }
}

/// The result of the runs at one interval with one filler.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    /// Switching interval MT, s.
    pub interval_s: f64,
    /// Number of switches in a run.
    pub switches: u64,
    /// Drift, ″/s.
    pub drift: Found,
    /// Rms drift in closed form, ″/s; absent for the largest angle.
    pub closed_form: Option<f64>,
    /// Drift in each balanced half of the trials, and in its complement.
    pub(crate) halves: Vec<[f64; 2]>,
    /// Drift without its non-magnetic part, ″/s, by which the interval is chosen.
    pub switched: Found,
    /// Drift without its non-magnetic part in each of these halves.
    pub(crate) switched_halves: Vec<[f64; 2]>,
}

impl Tried {
    /// The interval in the unit in which answers show it.
    pub(crate) fn interval(&self) -> Reading {
        time("interval", self.interval_s)
    }
}

/// A time in the unit in which answers show it.
pub(crate) fn time(name: &str, time_s: f64) -> Reading {
    Reading::new(&Column { name: name.to_owned(), unit: Unit::S, ..Column::default() }, time_s, None)
}

/// The results of one filler, in the order of the intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Filler {
    /// Name; absent where the study gives the residual by its largest value.
    pub name: Option<String>,
    /// Latency and memory of the filler; absent where it has no name.
    pub cost: Option<Cost>,
    /// Rms residual of one switch, ″.
    pub residual_rms: f64,
    /// Approximate largest residual δP_max, ″: sines at their peaks plus three standard deviations of the rest.
    pub residual_max: f64,
    /// Results, by ascending interval.
    pub tried: Vec<Tried>,
    /// Index of the best interval.
    pub best: usize,
    /// Best interval, s, with the uncertainty from a law fitted near the minimum, which is absent where the minimum is
    /// at an end of the tried range.
    pub optimum: Found,
    /// The interval of the paper's rule, with its result.
    pub papers_rule: Option<PapersRule>,
}

impl Filler {
    /// Its name in tables.
    pub(crate) fn called(&self) -> &str {
        self.name.as_deref().unwrap_or("as given")
    }

    /// The result at the best interval.
    pub fn best(&self) -> &Tried {
        &self.tried[self.best]
    }

    /// Whether an interval shorter or longer than all that were tried may be better.
    pub fn is_at_edge(&self) -> bool {
        self.tried.len() > 1 && (self.best == 0 || self.best + 1 == self.tried.len())
    }
}

/// The results of one combination of the swept keys other than the interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// Name of each of these keys with its value, in the order of the sweeps; empty where none is swept.
    pub swept: Vec<(&'static str, SweepValue)>,
    /// Run time t, s.
    pub duration_s: f64,
    /// Non-magnetic drift, ″/s, which is part of the drift but not of the choice of an interval.
    pub non_magnetic: f64,
    /// Results by filler, in the order of the study, without those that break a constraint.
    pub fillers: Vec<Filler>,
    /// Index of the filler with the least drift.
    pub best: usize,
}

impl Variant {
    /// The filler with the least drift.
    pub fn best(&self) -> &Filler {
        &self.fillers[self.best]
    }

    /// The angle that a drift adds up to in the run time, ″.
    pub fn angle(&self, drift: f64) -> f64 {
        drift * self.duration_s
    }
}

/// The result of a design.
#[derive(Debug, Clone)]
pub struct Design {
    /// The study, with all fillers that were tried.
    pub study: Study,
    /// Minimized quantity.
    pub measure: Measure,
    /// What fillers had to meet.
    pub constraints: Constraints,
    /// Whether a search added fillers to the study.
    pub is_searched: bool,
    /// Number of runs for each filler and interval.
    pub trials: u64,
    /// Notes on the results, each a sentence.
    pub notes: Vec<String>,
    /// The results of each combination of swept keys, in the order of the sweeps; a single one where none is swept.
    pub variants: Vec<Variant>,
    /// Index of the variant with the least drift.
    pub best: usize,
}

impl Design {
    /// The swept keys other than the interval, in the order written.
    pub(crate) fn keys(&self) -> Vec<Sweep> {
        self.study.sweeps.iter().filter(|sweep| sweep.key.name != INTERVAL.name).cloned().collect()
    }

    /// The decision sheet of the study at the best interval and values of swept keys; see
    /// [`decide`](crate::analysis::decision::decide).
    ///
    /// # Errors
    /// The point cannot be represented, or no threads can be started.
    pub fn sheet(&self) -> Result<Option<Sheet>, DecisionError> {
        let interval = Quantity::new(self.best().best().interval_s, Dimension::Time);
        let keys = self.keys();
        let swept =
            keys.iter().zip(&self.variant().swept).map(|(sweep, (_, value))| (sweep.key, value.clone()));
        let point: Vec<_> = swept.chain([(&INTERVAL, SweepValue::Quantity(interval))]).collect();
        let judged = self.judged();
        let mut sheet = match judged.contains(&false) {
            false => decide_at(&self.study, &point)?,
            true => decide_at(&self.study.with_fillers(|all| keep(all, |place| judged[place]))?, &point)?,
        };
        // Each filler at its own best interval, and not at that of the best one.
        if let Some(sheet) = sheet.as_mut().filter(|sheet| self.trades() || sheet.options > 1) {
            sheet.options = self.fillers().count();
            sheet.option = self.named(self.variant(), self.best());
        }
        Ok(sheet)
    }

    /// Whether the decision is about each filler of the study: where there is more to choose than these, about the best one
    /// alone, else about all.
    fn judged(&self) -> Vec<bool> {
        let trades = self.trades();
        let kept = |name: &str| !trades || self.best().name.as_deref() == Some(name);
        let runs = self.study.asked::<SwitchedRun>();
        runs.iter().flat_map(|runs| runs.fillers()).map(|filler| kept(&filler.name)).collect()
    }

    /// The variant with the least drift.
    pub fn variant(&self) -> &Variant {
        &self.variants[self.best]
    }

    /// The filler with the least drift.
    pub fn best(&self) -> &Filler {
        self.variant().best()
    }

    /// The ratio of the drift of any runs to the least one, with its 95 % interval, from the same random numbers.
    pub fn times_best(&self, other: &Tried) -> Found {
        let best = self.best().best();
        let ratio = |k: usize| [0, 1].map(|half| other.halves[k][half] / best.halves[k][half]);
        let value = other.drift.value / best.drift.value;
        let half = T_95 * of_halves(&(0..best.halves.len()).map(ratio).collect::<Vec<_>>());
        Found { value, interval: Some((value - half, value + half)) }
    }

    /// Whether the drift of some runs does not differ significantly from the least one.
    pub fn is_as_good(&self, other: &Tried) -> bool {
        self.times_best(other).interval.is_none_or(|(low, _)| low <= 1.0)
    }

    /// Whether there is more to choose than the interval and the fillers of the study.
    pub fn trades(&self) -> bool {
        !self.variant().swept.is_empty() || self.constraints.are_given() || self.is_searched
    }

    /// The drift by which variants are compared: without its non-magnetic part, unless that differs between them.
    pub(crate) fn deciding(&self, tried: &Tried) -> f64 {
        deciding(&self.variants, tried)
    }
}

/// The drift by which some variants are compared.
pub(crate) fn deciding(variants: &[Variant], tried: &Tried) -> f64 {
    let alike = variants.iter().all(|variant| variant.non_magnetic == variants[0].non_magnetic);
    if alike { tried.switched.value } else { tried.drift.value }
}

/// All fillers of some variants.
pub(crate) fn fillers_of(variants: &[Variant]) -> impl Iterator<Item = (&Variant, &Filler)> {
    variants.iter().flat_map(|variant| variant.fillers.iter().map(move |filler| (variant, filler)))
}

impl Design {
    /// All fillers of all variants, each at its best interval.
    pub fn fillers(&self) -> impl Iterator<Item = (&Variant, &Filler)> {
        fillers_of(&self.variants)
    }

    /// The fillers that no other one beats: none has at most the same drift, latency and memory and less of one of them; none where
    /// the study has no fillers. They are in the order of latency, memory and drift.
    pub fn pareto(&self) -> Vec<(&Variant, &Filler)> {
        let merits = |filler: &Filler| {
            let Cost { latency_s, memory } = filler.cost?;
            Some([latency_s, memory.bytes() as f64, self.deciding(filler.best())])
        };
        let (merits, all): (Vec<[f64; 3]>, Vec<_>) =
            self.fillers().filter_map(|(variant, filler)| Some((merits(filler)?, (variant, filler)))).unzip();
        let mut front = undominated(&merits);
        front.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|place| merits[place]);
            a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
        });
        front.into_iter().map(|place| all[place]).collect()
    }

    /// Names a choice: its filler and the values of swept keys, such as `quadratic, time constant of the loop 3 ms`.
    pub(crate) fn named(&self, variant: &Variant, filler: &Filler) -> String {
        let value = |value: &SweepValue| {
            value.quantity().map_or_else(|| value.to_string(), |quantity| short(quantity, 6))
        };
        let keys = self.keys();
        let swept = keys.iter().zip(&variant.swept);
        let swept = swept.map(|(sweep, (_, swept))| format!("{} {}", sweep.key.label, value(swept)));
        filler.name.iter().cloned().chain(swept).collect::<Vec<_>>().join(", ")
    }
}

/// The places of the items of which no other one is at least as small in everything and smaller in something.
fn undominated(items: &[[f64; 3]]) -> Vec<usize> {
    let beats = |a: &[f64; 3], b: &[f64; 3]| a != b && a.iter().zip(b).all(|(a, b)| a <= b);
    (0..items.len()).filter(|&place| !items.iter().any(|other| beats(other, &items[place]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from 0 to 5 in a fixed order without a pattern.
    fn numbers() -> impl Iterator<Item = f64> {
        let mut state = 1_u64;
        std::iter::from_fn(move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            Some(((state >> 33) % 6) as f64)
        })
    }

    #[test]
    fn the_front_is_what_sorting_out_one_by_one_leaves() {
        let mut numbers = numbers();
        for count in 1..60 {
            let items: Vec<[f64; 3]> =
                (0..count).map(|_| [(); 3].map(|()| numbers.next().unwrap())).collect();
            // Strikes out, item by item, all that it beats.
            let mut left = vec![true; count];
            for a in &items {
                for (place, b) in items.iter().enumerate() {
                    let worse = (0..3).any(|k| b[k] > a[k]);
                    let better = (0..3).any(|k| b[k] < a[k]);
                    if worse && !better {
                        left[place] = false;
                    }
                }
            }
            let expected: Vec<usize> = (0..count).filter(|place| left[*place]).collect();
            assert_eq!(undominated(&items), expected, "{items:?}");
        }
    }
}
