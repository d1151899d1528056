//! Minimum-variance fillers that a search adds to a study: a handful that are worth their latency and memory.

use crate::analysis::design::candidates::{Constraints, Cost};
use crate::analysis::design::{self, DesignError};
use crate::analysis::firmware::search::{Asked, Trade, entry, ticks_at};
use sagnac_base::quantity::{Dimension, parse, round_12};
use sagnac_engine::filler::read::Error;
use sagnac_engine::filler::{Fill, Filler, Method, Target};
use sagnac_engine::kinds::gap_fill::columns::SHIFT;
use sagnac_engine::kinds::gap_fill::inputs::Inputs;
use sagnac_engine::kinds::gap_fill::lower::fixed::{Rows, Statistics};
use sagnac_engine::kinds::switched_run::SwitchedRun;
use sagnac_engine::motion::Gaussian;
use sagnac_engine::study::Study;
use sagnac_theory::minimum_variance::Band;
use toml::Value;

/// Most fillers that are added for one motion.
const MAX_ADDED: usize = 6;

/// Factor by which the accepted excess of the residual grows until a handful of fillers remains.
const STEP: f64 = 1.1;

/// A note that no filler is added.
const NONE_ADDED: &str = "the search adds no filler: the noise is too small beside the motion to choose weights by, or no ticks meet the constraints";

/// A search for fillers.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Search {
    /// Band of the vibration for which they are designed; without it, that of the study's own motion with 5 % on either
    /// side.
    pub band: Option<Band>,
}

/// A band of frequencies such as `18 Hz,22 Hz`, or a single frequency.
///
/// # Errors
/// The text is not such a band; the message says what is accepted.
pub fn band(text: &str) -> Result<Band, String> {
    let (low, high) = text.split_once(',').unwrap_or((text, text));
    let frequency = |text: &str| {
        let quantity = parse(text.trim(), &[Dimension::Frequency]).map_err(|error| error.to_string())?;
        if quantity.value > 0.0 { Ok(quantity.value) } else { Err(format!("{quantity} is not above 0")) }
    };
    let band = Band { low_hz: frequency(low)?, high_hz: frequency(high)? };
    if band.low_hz > band.high_hz {
        return Err(
            "the band runs backwards\ngive the lower frequency first, as in \"18 Hz,22 Hz\"".to_owned()
        );
    }
    Ok(band)
}

/// A filler that a search may add, with its 99.73 % residual with frequencies shifted, ″, and its cost.
type Candidate = (Sought, f64, Cost);

/// The study with minimum-variance fillers added that are worth trying: of all numbers of ticks before and after the gap
/// that meet the constraints, those of which no other has about the same 99.73 % residual with no more latency and memory.
/// They are designed for the band of the search, or for that of the motion of each variant, widened by 5 % on either side:
/// firmware does not know a frequency exactly. For a motion that is no single tone or band, they are designed for the motion
/// itself, and where the study has a specification for that. Their residual is the largest one with all frequencies as given
/// and 5 % lower and higher, or with those of the specification within their tolerances. Where none is added,
/// the study gets a note.
///
/// # Errors
/// The study is of another kind, has no fillers, or does not accept the band.
pub(crate) fn with_searched(
    study: &Study,
    constraints: &Constraints,
    search: &Search,
) -> Result<Study, DesignError> {
    let band = search.band;
    let Some(runs) = study.asked::<SwitchedRun>() else {
        return Err(DesignError::Kind(study.kind().name));
    };
    let mut motions: Vec<&Inputs> = Vec::new();
    let variants = design::variants(runs);
    for (_, own) in &variants {
        let Some(fill) = &own.points[0].fill else { return Err(DesignError::NoFillers) };
        if let Some(band) = band.filter(|band| band.high_hz * fill.inputs.tick_s > 0.5) {
            return Err(DesignError::Band { high_hz: band.high_hz, tick_s: fill.inputs.tick_s });
        }
        if !motions.contains(&&fill.inputs) {
            motions.push(&fill.inputs);
        }
    }
    let mut added: Vec<Sought> = Vec::new();
    for inputs in &motions {
        let band = band.or_else(|| widened(inputs));
        for (sought, ..) in handful(candidates(inputs, constraints, band)) {
            let everywhere = motions.iter().all(|inputs| sought.is_determined(inputs));
            if everywhere && !added.contains(&sought) {
                added.push(sought);
            }
        }
    }
    added.sort_by_key(|sought| (sought.after, sought.before));
    if added.is_empty() {
        let mut study = study.clone();
        study.notes.push(NONE_ADDED.to_owned());
        return Ok(study);
    }
    let mut known: Vec<String> = runs.fillers().iter().map(|filler| filler.name.clone()).collect();
    let entries: Vec<Value> = added.into_iter().map(|sought| sought.entry(&mut known)).collect();
    Ok(study.with_fillers(|fillers| fillers.extend(entries))?)
}

/// The band of a motion that is a single tone or band, with [`SHIFT`] on either side; `None` for others, and where there is a
/// specification.
fn widened(inputs: &Inputs) -> Option<Band> {
    if inputs.specification.is_some() {
        return None;
    }
    let own = match (&inputs.motion.tones[..], &inputs.motion.gaussian, &inputs.motion.profile) {
        ([tone], None, None) => tone.band(),
        ([], Some(Gaussian::Band { band, .. }), None) => *band,
        _ => return None,
    };
    let low_hz = round_12(own.low_hz * (1.0 - SHIFT));
    let high_hz = round_12(own.high_hz * (1.0 + SHIFT));
    // Beyond the Nyquist frequency only the motion itself says what the ticks hold.
    (high_hz * inputs.tick_s <= 0.5).then_some(Band { low_hz, high_hz })
}

/// A filler that a search may add.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sought {
    before: u32,
    after: u32,
    band: Option<Band>,
}

impl Sought {
    /// The filler at a gap of `n` as the study will have it.
    fn at(self, inputs: &Inputs) -> (Filler, Fill) {
        let fit_ticks = ticks_at(inputs.gap_ticks, self.before, self.after);
        let own = ticks_at(inputs.gap_ticks, self.before, 0);
        let target = Target::new(self.band, inputs.specification.as_ref());
        let filler = Filler { name: String::new(), method: Method::MinimumVariance(target) };
        (filler, Fill { fit_ticks, extrapolation_ticks: Some(own) })
    }

    /// Whether a motion determines its weights.
    fn is_determined(self, inputs: &Inputs) -> bool {
        let (filler, fill) = self.at(inputs);
        Rows::new(&filler, Error::Residual, &fill.fit_ticks, &Statistics::new(inputs)).is_ok()
    }

    /// The filler as a study writes it, with a name that is not `known` yet.
    fn entry(self, known: &mut Vec<String>) -> Value {
        let Sought { before, after, band } = self;
        let mut name = format!("searched {before}+{after}");
        if let Some(Band { low_hz, high_hz }) = band.filter(|_| known.contains(&name)) {
            name += &format!(", {low_hz}-{high_hz} Hz");
        }
        while known.contains(&name) {
            name.push('*');
        }
        known.push(name.clone());
        let mut entry = entry(name, before, after);
        if let Some(Band { low_hz, high_hz }) = band {
            let ends = [low_hz, high_hz].map(|frequency_hz| Value::from(format!("{frequency_hz} Hz")));
            entry.insert("band".to_owned(), ends.to_vec().into());
        }
        entry.into()
    }
}

/// All candidates that meet the constraints.
fn candidates(inputs: &Inputs, constraints: &Constraints, band: Option<Band>) -> Vec<Candidate> {
    let asked = Asked { limit_arcsec: None, latency_s: constraints.latency_s };
    let trade = Trade::new(inputs, asked, band);
    let all = trade.into_iter().flat_map(|trade| trade.candidates);
    all.map(|one| {
        let sought = Sought { before: one.before, after: one.after, band };
        let (filler, fill) = sought.at(inputs);
        (sought, one.level, Cost::new(&filler, &fill, inputs))
    })
    .filter(|(.., cost)| constraints.meets(*cost))
    .collect()
}

/// Few candidates. For any other one of them, with no more latency and memory, has at most a multiple of its residual: the
/// least one, in steps of [`STEP`], for which that few suffice.
fn handful(mut all: Vec<Candidate>) -> Vec<Candidate> {
    let costs = |(.., cost): &Candidate| (cost.latency_s, cost.memory.bytes());
    all.sort_by(|a, b| {
        let ((late, large), (other_late, other_large)) = (costs(a), costs(b));
        late.total_cmp(&other_late).then(large.cmp(&other_large))
    });
    let mut factor = STEP;
    loop {
        let mut kept: Vec<Candidate> = Vec::new();
        for one in &all {
            let is_as_good = |known: &Candidate| {
                let ((late, large), (own_late, own_large)) = (costs(known), costs(one));
                late <= own_late && large <= own_large && known.1 <= factor * one.1
            };
            if !kept.iter().any(is_as_good) {
                kept.push(*one);
            }
        }
        if kept.len() <= MAX_ADDED {
            return kept;
        }
        factor *= STEP;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::firmware::fixed_point_filter::Memory;

    #[test]
    fn for_any_other_a_handful_has_a_residual_that_is_near_at_no_more_cost() {
        let candidate = |after: u32, before: u32| {
            // Falls with both numbers of ticks, 205 times in all.
            let level = 100.0 / (1.0 + f64::from(after * after) + 0.3 * f64::from(before));
            let memory = Memory { constants: u64::from(100 + before + after), state: 0 };
            let sought = Sought { before, after, band: None };
            (sought, level, Cost { latency_s: 0.005 * f64::from(after), memory })
        };
        let all: Vec<Candidate> =
            (0..=16).flat_map(|after| (1..=32).map(move |before| candidate(after, before))).collect();
        let kept = handful(all.clone());
        assert!((2..=MAX_ADDED).contains(&kept.len()), "{}", kept.len());
        let ratio = |(_, level, own): &Candidate| {
            let cheaper = kept.iter().filter(|(.., cost)| {
                cost.latency_s <= own.latency_s && cost.memory.bytes() <= own.memory.bytes()
            });
            cheaper.map(|(_, level, _)| *level).fold(f64::INFINITY, f64::min) / level
        };
        let worst = all.iter().map(ratio).fold(0.0, f64::max);
        // Six candidates cannot do better than the sixth root of 205, which is 2.4, and cover two kinds of costs.
        assert!((2.4..6.2).contains(&worst), "a candidate is left out although it leaves {worst} times less");
    }

    #[test]
    fn bands_are_read_with_their_ends_in_order() {
        assert_eq!(band("18 Hz, 22 Hz"), Ok(Band { low_hz: 18.0, high_hz: 22.0 }));
        assert_eq!(band("20 Hz"), Ok(Band { low_hz: 20.0, high_hz: 20.0 }));
        for (text, piece) in [("22 Hz,18 Hz", "backwards"), ("0 Hz", "not above 0"), ("20 s", "s"), ("", "")]
        {
            assert!(band(text).is_err_and(|why| why.contains(piece)), "{text}");
        }
    }
}
