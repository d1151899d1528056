//! The answer as one input at a time goes over its range.

use crate::analysis::sensitivity::evaluate::Evaluator;
use crate::analysis::sensitivity::sobol::{Index, Indices};
use crate::analysis::sensitivity::{LEVELS, SensitivityError};
use sagnac_base::table::Unit;
use sagnac_engine::key::sensitivity::Uncertain;
use sagnac_engine::key::sweep::Swept;

/// The effect of one input.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// Name of the key.
    pub key: &'static str,
    /// Its label.
    pub label: &'static str,
    /// Unit of its values.
    pub unit: Unit,
    /// Sobol' indices.
    pub index: Index,
    /// Its nominal value.
    pub nominal: f64,
    /// The 5 % and 95 % quantiles of the input.
    pub range: [f64; 2],
    /// The answer at these two, with the other inputs at their nominal values.
    pub ends: [f64; 2],
    /// The least and the largest answer between these two.
    pub swing: [f64; 2],
}

/// Steps from the 5 % to the 95 % quantile of an input.
const STEPS: usize = 18;

/// Number of points at which all swings together are evaluated.
pub(crate) fn count(inputs: usize) -> u64 {
    (1 + inputs * (STEPS + 1)) as u64
}

/// The answer as each input goes over its range.
pub(crate) struct Swings {
    /// With all inputs at their nominal values.
    pub(crate) nominal: f64,
    /// Answers at equal steps of the level, for each input.
    inputs: Vec<Vec<f64>>,
}

/// The levels of an input at which the answer is evaluated.
fn levels() -> impl Iterator<Item = f64> {
    (0..=STEPS).map(|step| LEVELS[0] + (LEVELS[2] - LEVELS[0]) * step as f64 / STEPS as f64)
}

/// Evaluates the answer along each input.
///
/// # Errors
/// The errors of the evaluation.
pub(crate) fn swings(
    evaluator: &mut Evaluator,
    nominal: &[Swept],
    uncertain: &[Uncertain],
) -> Result<Swings, SensitivityError> {
    let along = |(place, input): (usize, &Uncertain)| {
        let at = |level: f64| {
            let mut point = nominal.to_vec();
            point[place] = input.at(level);
            point
        };
        levels().map(at).collect::<Vec<Vec<Swept>>>()
    };
    let moved = uncertain.iter().enumerate().flat_map(along);
    let points: Vec<Vec<Swept>> = std::iter::once(nominal.to_vec()).chain(moved).collect();
    let answers = evaluator.at(&points)?;
    let inputs = answers[1..].chunks_exact(STEPS + 1).map(<[f64]>::to_vec).collect();
    Ok(Swings { nominal: answers[0], inputs })
}

/// Each input with its indices and its swing.
pub(crate) fn joined(
    uncertain: &[Uncertain],
    nominal: &[Swept],
    found: &Indices,
    swings: Swings,
) -> Vec<Input> {
    let all = uncertain.iter().zip(nominal).zip(&found.inputs).zip(swings.inputs);
    let input = |(((input, nominal), index), along): (((&Uncertain, &Swept), &Index), Vec<f64>)| {
        let shown = |level: f64| input.at(level).cell().number().unwrap_or(f64::NAN);
        let (least, most) = along
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), y| (least.min(*y), most.max(*y)));
        Input {
            key: input.key.name,
            label: input.key.label,
            unit: input.at(0.5).unit(),
            index: *index,
            nominal: nominal.cell().number().unwrap_or(f64::NAN),
            range: [shown(LEVELS[0]), shown(LEVELS[2])],
            ends: [along[0], along[STEPS]],
            swing: [least, most],
        }
    };
    all.map(input).collect()
}
