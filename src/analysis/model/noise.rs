//! The curve of a noise.toml: that of its coefficients, with the band of their intervals.

use std::path::Path;

use crate::analysis::log::noise_file::{Intervals, intervals_of};
use crate::analysis::model::target::{Point, Source, Target};
use crate::analysis::model::{Asked, ModelError};
use sagnac_base::quantity::list::listed;
use sagnac_base::quantity::number::significant;
use sagnac_engine::noise::Noise;
use sagnac_records::allan::Unit;
use sagnac_theory::allan::{Part, Term, continuous};

/// Points of the curve per decade of τ.
const PER_DECADE: f64 = 40.0;

/// A part of the noise with the ends of the interval of its coefficient, in parts of it.
struct Known {
    part: Part,
    ends: [f64; 2],
}

impl Known {
    /// The Allan variance with its ends. A sine beyond its first zero is taken at its crests.
    fn at(&self, tau_s: f64) -> [f64; 3] {
        let turns = self.part.shape * tau_s;
        let variance = match self.part.term {
            Term::Sine if turns > 0.5 => {
                let crest = self.part.size / (core::f64::consts::PI * turns);
                crest * crest
            }
            _ => continuous::allan_variance(&self.part, tau_s).unwrap_or(0.0),
        };
        let [low, high] = self.ends.map(|end| variance * end * end);
        [low, variance, high]
    }
}

/// The curve of the noise.toml at `path` between the requested times.
///
/// # Errors
/// The file cannot be read, or is no noise; or the times are not given.
pub fn of_file(path: &Path, asked: &Asked) -> Result<(Source, Target), ModelError> {
    let (noise, text) = Noise::read(path)?;
    of_noise(&noise, &text, path, asked)
}

/// The curve of the text of a noise.toml, which is called `name`.
///
/// # Errors
/// The text is no noise, or the times are not given.
pub fn of_text(name: &str, text: &str, asked: &Asked) -> Result<(Source, Target), ModelError> {
    of_noise(&Noise::parse(name, text)?, text, Path::new(name), asked)
}

/// The curve of noise; `text` is that of the file, for its intervals.
///
/// Upper and lower ends are those of independent coefficients: the distances of their variances from the value, added as squares.
///
/// # Errors
/// The times are not given.
fn of_noise(noise: &Noise, text: &str, path: &Path, asked: &Asked) -> Result<(Source, Target), ModelError> {
    let (Some(from_s), Some(to_s)) = (asked.from_s, asked.to_s) else { return Err(ModelError::NoTimes) };
    if from_s >= to_s || from_s <= 0.0 {
        return Err(ModelError::Order { from_s, to_s });
    }
    let Intervals { known: ends, unknown } = intervals_of(text);
    let mut parts = noise.process(1.0, 1 << 20).parts;
    let lsb = noise.readout_lsb / libm::sqrt(12.0);
    parts.extend((lsb > 0.0).then(|| Part::quantization(lsb)));
    let residual = noise.switching.map_or(0.0, |switching| switching.residual_density());
    parts.extend((residual > 0.0).then(|| Part::angle_random_walk(libm::sqrt(residual))));
    let is_warm_up = |part: &Part| continuous::allan_variance(part, from_s).is_none();
    let left_out = parts.iter().any(is_warm_up);
    parts.retain(|part| !is_warm_up(part));
    let known: Vec<Known> = parts
        .into_iter()
        .map(|part| {
            let [size, _] = noise.of(part.term);
            let of = ends.iter().find(|(term, _)| *term == part.term && size != 0.0);
            let ends = of.map_or([1.0; 2], |(_, ends)| ends.map(|end| end / size.abs()));
            Known { part, ends: [ends[0].min(1.0), ends[1].max(1.0)] }
        })
        .collect();
    let count = libm::ceil(PER_DECADE * libm::log10(to_s / from_s)).max(1.0);
    let points = (0..=count as u32).map(|i| {
        let tau_s = from_s * libm::pow(to_s / from_s, f64::from(i) / count);
        point(&known, tau_s)
    });
    let quantized = known.iter().filter(|known| known.part.term == Term::Quantization);
    let square = |end: f64| end * end;
    let quantization = quantized.fold([0.0; 2], |[value, upper], known| {
        let size = known.part.size;
        [value + square(size), upper + square(size * known.ends[1])]
    });
    let has_band = known.iter().any(|known| known.ends != [1.0; 2]);
    let target = Target {
        name: "noise".to_owned(),
        unit: Unit::Angular,
        points: points.collect(),
        quantization: (quantization[0] > 0.0).then(|| quantization.map(libm::sqrt)),
        white: 0.0,
        step_s: None,
        length_s: None,
        has_band,
        events: vec![],
    };
    let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let heading = format!(
        "{file}: the curve of its coefficients{}",
        if has_band { " and their intervals" } else { "" }
    );
    let notes = notes(noise, left_out, &unknown, residual);
    Ok((Source { path: path.to_owned(), heading, rate_hz: None, notes }, target))
}

fn point(known: &[Known], tau_s: f64) -> Point {
    let all: Vec<[f64; 3]> = known.iter().map(|known| known.at(tau_s)).collect();
    let value: f64 = all.iter().map(|[_, value, _]| value).sum();
    let away =
        |end: usize| -> f64 { all.iter().map(|ends| (ends[end] - ends[1]) * (ends[end] - ends[1])).sum() };
    let (lower, upper) = ((value - libm::sqrt(away(0))).max(0.0), value + libm::sqrt(away(2)));
    let [value, lower, upper] = [value, lower, upper].map(libm::sqrt);
    Point { tau_s, value, lower, upper, edf: None }
}

fn notes(noise: &Noise, left_out: bool, unknown: &[&'static str], residual: f64) -> Vec<String> {
    let rate = significant(libm::sqrt(residual) / 60.0, 3);
    let has_sawtooth = noise
        .switching
        .is_some_and(|switching| switching.magnetic != 0.0 || switching.initial_magnetic != 0.0);
    [
        left_out.then(|| "the warm-up is left out: it is no noise, and a filter has to estimate it or to wait".to_owned()),
        has_sawtooth
            .then(|| "the drift that switches alternate is left out: it is no noise, and it returns to 0 with every pair of switches".to_owned()),
        (residual > 0.0).then(|| format!("the residuals of switches are taken as white noise of {rate} °/√h")),
        (!unknown.is_empty()).then(|| {
            format!(
                "the record behind the file did not identify {}; a bound does not cover them beyond the τ of that record, for which the log has to \
                 be given",
                listed(unknown)
            )
        }),
    ]
    .into_iter()
    .flatten()
    .collect()
}
