//! The search among choices of effects.

use crate::analysis::temperature::smoothing::Averages;
use crate::analysis::temperature::{Effect, Finding, Model};
use sagnac_base::diagnostics::listed;
use sagnac_records::fit::regression::{Blocks, Posterior, Regression};
use sagnac_records::fit::selection::{PENALTY, PENALTY_OF_SHAPE, RIVAL};
use sagnac_theory::allan::{self, Part, Process, Term, flicker};

/// Times of a warm-up that are tried in one pass, and how many of them the noise is learnt beside.
const TIMES: usize = 24;
const LEARNT: usize = 6;
/// Probability of the residual below which the noise does not describe it. With so few blocks it is below 1e-3 in one of two hundred
/// records that are described.
const MIN_P: f64 = 1e-5;
/// Increase of χ² at the ends of a 95 % interval.
const WITHIN_95: f64 = 3.84;

/// A choice of effects, with the place of the time of a warm-up, and its lack of likelihood with penalties.
#[derive(Clone)]
pub(super) struct Choice {
    pub(super) effects: Vec<Effect>,
    time: usize,
    pub(super) score: f64,
}

impl Choice {
    /// The score with the same penalty for all effects: that of a search keeps a warm-up from entering, but is no evidence against
    /// it.
    fn fair(&self) -> f64 {
        self.score + if self.effects.contains(&Effect::WarmUp) { PENALTY - PENALTY_OF_SHAPE } else { 0.0 }
    }
}

/// A regression whose columns are the constant one, the effects without a time, and a warm-up of each time.
pub(super) struct Search {
    /// Effects without a time.
    effects: Vec<Effect>,
    times: Vec<f64>,
    regression: Regression,
    /// All columns that do not depend on each other, from which the noise is learnt.
    all: Posterior,
}

impl Search {
    /// The search among `candidates` with times of a warm-up between two ends, s.
    pub(super) fn new(
        averages: &Averages,
        candidates: &[Effect],
        [shortest, longest]: [f64; 2],
        fast: Option<&Process>,
    ) -> Result<Search, String> {
        let effects: Vec<Effect> =
            candidates.iter().copied().filter(|effect| *effect != Effect::WarmUp).collect();
        let time = |i: usize| shortest * libm::pow(longest / shortest, i as f64 / (TIMES - 1) as f64);
        let has_warm_up = candidates.contains(&Effect::WarmUp);
        let times: Vec<f64> = (0..if has_warm_up { TIMES } else { 0 }).map(time).collect();
        let constant = vec![1.0; averages.rates.len()];
        let columns: Vec<Vec<f64>> = std::iter::once(constant)
            .chain(effects.iter().map(|&effect| averages.column(effect, 1.0)))
            .chain(times.iter().map(|&time_s| averages.column(Effect::WarmUp, time_s)))
            .collect();
        let reach = averages.places.last().map_or(0, |last| last + 1);
        let means = |part: &Part| allan::block_covariance(part, averages.step_s, averages.m as u64, reach);
        let white = means(&Part::angle_random_walk(1.0));
        let slow = [Part::bias_instability(1.0, flicker::OCTAVES), Part::rate_random_walk(1.0)];
        let [flicker, walk] = slow.map(|part| means(&part));
        let regression = |fast: Vec<f64>| {
            Regression::new(Blocks {
                places: averages.places.clone(),
                shares: averages.shares.clone(),
                values: averages.rates.clone(),
                columns: columns.clone(),
                noises: [fast, flicker.clone(), walk.clone()],
            })
        };
        let of_record = fast.map(|process| of_fast(process, &means)).filter(|noise| noise[0] > 0.0);
        let regression = of_record.and_then(&regression).or_else(|| regression(white));
        let regression = regression.ok_or("the covariance of its noise is not positive definite")?;
        let mut chosen = vec![0];
        let learnt = (0..times.len()).step_by(TIMES / LEARNT).map(|i| 1 + effects.len() + i);
        for column in (1..=effects.len()).chain(learnt) {
            let more = [&chosen[..], &[column]].concat();
            if regression.posterior(&more).is_some() {
                chosen = more;
            }
        }
        let all = regression.posterior(&chosen).ok_or("it has too few blocks")?;
        Ok(Search { effects, times, regression, all })
    }

    /// The columns of some effects, in their order behind the constant one.
    fn columns(&self, effects: &[Effect], time: usize) -> Vec<usize> {
        let column = |effect: &Effect| {
            let plain = self.effects.iter().position(|other| other == effect);
            1 + plain.unwrap_or(self.effects.len() + time)
        };
        std::iter::once(0).chain(effects.iter().map(column)).collect()
    }

    fn score(&self, effects: &[Effect], time: usize) -> f64 {
        let penalty = |effect: &Effect| if *effect == Effect::WarmUp { PENALTY_OF_SHAPE } else { PENALTY };
        let penalties: f64 = effects.iter().map(penalty).sum();
        penalties + self.regression.lack(&self.columns(effects, time), &self.all)
    }

    /// A choice of effects with its best time.
    fn choice(&self, effects: Vec<Effect>) -> Choice {
        let times = if effects.contains(&Effect::WarmUp) { self.times.len() } else { 1 };
        let score = |time: usize| (self.score(&effects, time), time);
        let best = (0..times).map(score).min_by(|a, b| a.0.total_cmp(&b.0));
        let (score, time) = best.unwrap_or((f64::INFINITY, 0));
        Choice { effects, time, score }
    }

    /// All choices; a square enters only with the temperature itself.
    pub(super) fn choices(&self) -> Vec<Choice> {
        let warm_up = (!self.times.is_empty()).then_some(Effect::WarmUp);
        let candidates: Vec<Effect> = self.effects.iter().copied().chain(warm_up).collect();
        let subset = |mask: usize| {
            let chosen = candidates.iter().enumerate().filter(move |(i, _)| mask >> i & 1 == 1);
            chosen.map(|(_, effect)| *effect).collect::<Vec<_>>()
        };
        let is_sensible = |effects: &Vec<Effect>| {
            effects.contains(&Effect::Temperature) || !effects.contains(&Effect::Square)
        };
        let subsets = (0..1 << candidates.len()).map(subset).filter(is_sensible);
        subsets.map(|effects| self.choice(effects)).collect()
    }

    /// A choice with those effects besides whose intervals exclude 0, one after the other; no warm-up, which the choice of the
    /// best of many times would make significant by chance.
    pub(super) fn completed(&self, choice: &Choice) -> Choice {
        let with = |effect: &Effect| self.choice([&choice.effects[..], &[*effect]].concat());
        let is_identified = |more: &Choice| {
            let found = self.regression.posterior(&self.columns(&more.effects, more.time));
            found.is_some_and(|found| found.coefficient(more.effects.len()).is_identified())
        };
        let others = self.effects.iter().filter(|effect| !choice.effects.contains(effect));
        let more = others.map(with).filter(is_identified).min_by(|a, b| a.score.total_cmp(&b.score));
        more.map_or_else(|| choice.clone(), |more| self.completed(&more))
    }

    /// The time of the warm-up of a choice, s.
    pub(super) fn time_s(&self, choice: &Choice) -> f64 {
        self.times.get(choice.time).copied().unwrap_or(1.0)
    }

    /// The places of the times within the 95 % interval of the time of a warm-up.
    pub(super) fn near(&self, choice: &Choice) -> Vec<usize> {
        let is_near = |time: &usize| self.score(&choice.effects, *time) < choice.score + WITHIN_95;
        (0..self.times.len()).filter(is_near).collect()
    }

    /// The model of a choice among others.
    pub(super) fn model(&self, best: &Choice, choices: &[Choice]) -> Result<Model, String> {
        let columns = self.columns(&best.effects, best.time);
        let unsolved = || "its terms depend on each other".to_owned();
        let mixture = self.regression.posterior(&columns).ok_or_else(unsolved)?;
        let p_value = self.regression.p_value(&columns, &mixture).ok_or_else(unsolved)?;
        let is_robust = p_value < MIN_P;
        let distribution = |columns: &[usize]| {
            let mixture = self.regression.posterior(columns)?;
            if is_robust { self.regression.robust(columns, &mixture) } else { Some(mixture) }
        };
        let posterior = distribution(&columns).ok_or_else(unsolved)?;
        let means = posterior.means();
        let warm_up = (!self.times.is_empty()).then_some(Effect::WarmUp);
        let mut findings = Vec::new();
        for effect in self.effects.iter().copied().chain(warm_up) {
            let place = best.effects.iter().position(|other| *other == effect);
            let estimate = match place {
                Some(place) => Some(posterior.coefficient(1 + place)),
                None => {
                    let with = self.choice([&best.effects[..], &[effect]].concat());
                    let found = distribution(&self.columns(&with.effects, with.time));
                    found.map(|found| found.coefficient(1 + best.effects.len()))
                }
            };
            let others = rivals(effect, best, choices);
            let verdict = match (estimate, place) {
                _ if !others.is_empty() => format!("cannot be told from {}", listed(&others)),
                (None, _) => "cannot be told from the other terms".to_owned(),
                (Some(estimate), Some(_)) if estimate.is_identified() => "estimated".to_owned(),
                (_, Some(_)) => "not detected: the interval contains 0".to_owned(),
                (_, None) => "not needed".to_owned(),
            };
            findings.push(Finding { effect, estimate, is_used: place.is_some(), verdict });
        }
        let time = best.effects.contains(&Effect::WarmUp).then(|| {
            let near = self.near(best);
            let ends = [near.first(), near.last()].map(|i| i.copied().unwrap_or(best.time));
            let is_open = ends[0] == 0 || ends[1] + 1 == self.times.len();
            (self.time_s(best), (!is_open).then(|| ends.map(|i| self.times[i])))
        });
        let coefficients: Vec<(Effect, f64)> =
            best.effects.iter().copied().zip(means[1..].iter().copied()).collect();
        Ok(Model { findings, offset: means[0], coefficients, warm_up_s: time, p_value, is_robust, posterior })
    }
}

/// The effects from which `effect` cannot be told; empty where it can. The rival is the best choice that differs from `best` in
/// `effect` and is almost as good. If it lacks `effect`, these are the effects that it has instead, else those of `best` that it lacks.
fn rivals(effect: Effect, best: &Choice, choices: &[Choice]) -> Vec<&'static str> {
    let is_used = best.effects.contains(&effect);
    // An effect that the other choice hardly needs takes no other's place.
    let is_needed = |other: &&Choice| {
        let rest: Vec<Effect> = other.effects.iter().copied().filter(|x| *x != effect).collect();
        let without = choices.iter().find(|choice| choice.effects == rest);
        is_used || without.is_none_or(|without| without.fair() > other.fair() + RIVAL)
    };
    let rival = choices
        .iter()
        .filter(|other| other.effects.contains(&effect) != is_used)
        .filter(|other| other.fair() < best.fair() + RIVAL)
        .filter(is_needed)
        .min_by(|a, b| a.fair().total_cmp(&b.fair()));
    let Some(rival) = rival else { return vec![] };
    let (with, without) = if is_used { (rival, best) } else { (best, rival) };
    with.effects.iter().filter(|x| !without.effects.contains(x)).map(|x| x.title()).collect()
}

/// The covariance of blocks of the parts of a noise that are fast: white noise, quantization and the band limit.
fn of_fast(process: &Process, means: &dyn Fn(&Part) -> Vec<f64>) -> Vec<f64> {
    let is_fast =
        |part: &&Part| matches!(part.term, Term::AngleRandomWalk | Term::Quantization | Term::BandLimit);
    let parts = process.parts.iter().filter(is_fast).map(means);
    parts.reduce(|a, b| a.iter().zip(&b).map(|(a, b)| a + b).collect()).unwrap_or_else(|| vec![0.0])
}
