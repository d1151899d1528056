//! The regressors of the rate on temperature, slope and warm-up, and their effect.

use crate::analysis::temperature::search::Search;
use crate::analysis::temperature::smoothing::Averages;
use sagnac_engine::key::names;
use sagnac_records::allan::{Deviation, Unit};
use sagnac_records::fit::regression::{Estimate, Posterior};
use sagnac_theory::allan::Process;

/// Shortest time of a warm-up in blocks, and longest as a share of the record; a slower one is nearly a straight line.
const MIN_TIME: f64 = 1.0;
const MAX_TIME: f64 = 0.5;
/// Share of the logarithmic range of times of a warm-up that the next pass searches, unless so many times of this pass lie
/// within the 95 % interval, or the range is so narrow.
const NARROWER: f64 = 0.3;
const RESOLVED: usize = 5;
const NARROW: f64 = 1.0001;

/// The dependence that was found.
#[derive(Debug, Clone)]
pub struct Model {
    /// What was found of each effect, whether it is part of the model or was only tried.
    pub findings: Vec<Finding>,
    /// Rate at the reference temperature, °/h.
    pub offset: f64,
    /// The effects of the model with their coefficients.
    pub coefficients: Vec<(Effect, f64)>,
    /// Time of a warm-up of the model, s, with its 95 % interval where both ends were found.
    pub warm_up_s: Option<(f64, Option<[f64; 2]>)>,
    /// Probability of a residual at least as correlated, if the noise of the regression is that of the record.
    pub p_value: f64,
    /// Whether the intervals are the robust ones, because that probability is too low.
    pub is_robust: bool,
    pub(super) posterior: Posterior,
}

/// What was found of one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Effect.
    pub effect: Effect,
    /// Its coefficient, in the model or if it entered next; absent where it cannot be determined.
    pub estimate: Option<Estimate>,
    /// Whether it is part of the model.
    pub is_used: bool,
    /// How well it is known, in words.
    pub verdict: String,
}

/// The effects that may enter a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Effects {
    /// Temperature, and those of the others for which there is evidence.
    Auto,
    /// All of these.
    Given(Vec<Effect>),
}

impl Effects {
    /// Reads `auto`, or names of effects separated by commas.
    ///
    /// # Errors
    /// A name is unknown, or the square of the temperature is without the temperature itself.
    pub fn parse(text: &str) -> Result<Effects, String> {
        if text == "auto" {
            return Ok(Effects::Auto);
        }
        let named = |asked: &str| {
            let asked = asked.trim();
            let found = Effect::ALL.into_iter().find(|effect| effect.name().eq_ignore_ascii_case(asked));
            let known = || Effect::ALL.map(Effect::name).join(",");
            found.ok_or_else(|| format!("`{asked}` is not a term; accepted: auto, or some of {}", known()))
        };
        let named = text.split(',').map(named).collect::<Result<Vec<_>, _>>()?;
        // In the order of all of them, and each once.
        let effects: Vec<Effect> = Effect::ALL.into_iter().filter(|effect| named.contains(effect)).collect();
        if effects.contains(&Effect::Square) && !effects.contains(&Effect::Temperature) {
            return Err("T2 needs T beside it, because its zero is arbitrary; write as in T,T2".to_owned());
        }
        Ok(Effects::Given(effects))
    }

    /// The effects in question.
    pub fn candidates(&self) -> &[Effect] {
        match self {
            Effects::Auto => &Effect::ALL,
            Effects::Given(effects) => effects,
        }
    }
}

impl Model {
    /// Fits effects to the averages of a record; `fast` is the noise of the record at short times, white unless it is known.
    /// `Auto` includes temperature and chooses the others.
    ///
    /// # Errors
    /// A sentence that says why there is no model.
    pub fn new(averages: &Averages, asked: &Effects, fast: Option<&Process>) -> Result<Model, String> {
        let candidates = asked.candidates();
        let mut ends = [MIN_TIME * averages.step_s * averages.m as f64, MAX_TIME * averages.length_s()];
        loop {
            let search = Search::new(averages, candidates, ends, fast)?;
            let choices = search.choices();
            let is_allowed = |effects: &[Effect]| match asked {
                Effects::Given(_) => effects.len() == candidates.len(),
                Effects::Auto => effects.contains(&Effect::Temperature),
            };
            let allowed = choices.iter().filter(|choice| is_allowed(&choice.effects));
            let best = allowed.min_by(|a, b| a.score.total_cmp(&b.score));
            let best = best.filter(|best| best.score.is_finite()).ok_or_else(|| {
                "its terms cannot be told from each other in this record: leave out some of them".to_owned()
            })?;
            let is_resolved = search.near(best).len() >= RESOLVED || ends[1] < NARROW * ends[0];
            if !best.effects.contains(&Effect::WarmUp) || is_resolved {
                let best = match asked {
                    Effects::Auto => search.completed(best),
                    Effects::Given(_) => best.clone(),
                };
                return search.model(&best, &choices);
            }
            let narrowed = libm::pow(ends[1] / ends[0], 0.5 * NARROWER);
            ends = [search.time_s(best) / narrowed, search.time_s(best) * narrowed];
        }
    }

    /// What the temperature adds to the rate at the reference temperature, `from` K above it.
    pub fn at(&self, from: f64) -> Estimate {
        let weight = |(effect, _): &(Effect, f64)| match effect {
            Effect::Temperature => from,
            Effect::Square => from * from,
            _ => 0.0,
        };
        let weights: Vec<f64> = std::iter::once(0.0).chain(self.coefficients.iter().map(weight)).collect();
        self.posterior.sum(&weights)
    }
}

names! {
    /// A term of the model of a rate.
    pub enum Effect {
        /// In proportion to the temperature: T − T_ref, in K.
        Temperature = "T",
        /// In proportion to its square: (T − T_ref)², in K².
        Square = "T2",
        /// In proportion to its change: dT/dt, in K/min.
        Change = "dT",
        /// A decay since the start of the record: exp(−t/τ).
        WarmUp = "warm-up",
        /// A straight line of time, in days.
        Aging = "aging",
    }
}

impl Effect {
    /// Unit of the coefficient in files, for a curve in `unit`.
    pub fn unit(self, unit: Unit) -> String {
        let per = match self {
            Effect::Temperature => "/K",
            Effect::Square => "/K^2",
            Effect::Change => "/(K/min)",
            Effect::WarmUp => "",
            Effect::Aging => "/day",
        };
        match (unit.in_files(Deviation::Oadev), per) {
            ("", "") => String::new(),
            ("", per) => format!("1{per}"),
            (rate, per) => format!("{rate}{per}"),
        }
    }

    /// Its name in a sentence.
    pub fn title(self) -> &'static str {
        match self {
            Effect::Temperature => "the temperature",
            Effect::Square => "the square of the temperature",
            Effect::Change => "the change of the temperature",
            Effect::WarmUp => "a warm-up",
            Effect::Aging => "aging",
        }
    }
}
