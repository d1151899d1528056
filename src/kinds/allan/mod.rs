//! Studies of Allan curves: the record, its noise, and what is estimated of it.

pub mod estimate;
pub mod kind;
pub mod lower;
pub mod notes;
pub mod point;
pub mod run;

pub use crate::kinds::allan::point::{Inputs, Point};

use crate::fit::choose::Terms;
use crate::fit::term::Term;
use crate::key::file::StudyFile;
use crate::key::setting::Key;
use crate::key::sweep::Sweep;
use crate::noise::read::WrittenNoise;
use crate::noise::{self, Noise};
use crate::source::diagnose::{Fault, Wrong};
use crate::source::place::Places;
use crate::source::text_file::Files;
use crate::study::needed;
use crate::theory::allan::estimator::Estimator;

/// What a study of Allan curves asks.
#[derive(Debug, Clone)]
pub struct Allan {
    /// Which differences, and how many of them.
    pub estimator: Estimator,
    /// The terms that are fitted to each record, if any.
    pub terms: Option<Terms>,
    /// All points, in order; without a sweep the one that is written.
    pub points: Vec<Point>,
    /// What is rounded and what the fit leaves out, each in a sentence.
    pub notes: Vec<String>,
}

/// Every key that a sweep may vary.
pub(crate) fn keys() -> Vec<&'static Key> {
    let record = crate::kinds::allan::point::SETTINGS.iter().map(|setting| &setting.key);
    record.chain(noise::SETTINGS.iter().map(|setting| &setting.key)).chain([&noise::FILE]).collect()
}

/// Reads what is of this kind in a file, and notes where it stands.
pub(crate) fn read(
    file: &StudyFile,
    sweeps: &[Sweep],
    files: &Files,
    places: &mut Places,
) -> Result<Allan, Wrong> {
    if let Some(precision) = &file.precision {
        let message = "precision is no key of a study of kind = \"allan\"";
        let help = "leave it out: trials says how many records are made";
        return Err(Fault::new(precision.span(), message, "not of this kind", help).into());
    }
    let record = needed(file.record.as_ref(), "record", file)?;
    let inputs = crate::kinds::allan::point::read(record.get_ref(), places)?;
    let WrittenNoise { noise, written } =
        noise::read(needed(file.noise.as_ref(), "noise", file)?, files, places)?;
    if let Some(allan) = &file.allan {
        places.add("allan", allan.span());
    }
    let estimate = crate::kinds::allan::estimate::read(file.allan.as_ref(), places)?;
    let of_file = |file| -> Result<Noise, Wrong> {
        let mut noise = noise::read_file(file, files)?;
        // Keys of the study hold beside any file.
        written.iter().for_each(|(setting, quantity)| (setting.set)(&mut noise, *quantity));
        Ok(noise)
    };
    let of_files = sweeps.iter().filter(|sweep| sweep.key.name == noise::FILE.name);
    let files =
        of_files.flat_map(|sweep| &sweep.files).map(of_file).collect::<Result<Vec<Noise>, Wrong>>()?;
    let base = crate::kinds::allan::point::Base {
        inputs: Inputs { noise, ..inputs },
        files,
        places,
        sweeps,
        estimate: &estimate,
    };
    base.check_sweeps(&file.sweep)?;
    base.check_switching()?;
    let points = base.points()?;
    let terms = estimate.terms.map(|terms| with_shapes(terms, &points));
    let notes = crate::kinds::allan::notes::of(terms.as_ref(), &points);
    Ok(Allan { estimator: estimate.estimator, terms, points, notes })
}

/// A fit that chooses its terms has Markov noise and a sine to choose from where the noise has them.
fn with_shapes(terms: Terms, points: &[Point]) -> Terms {
    let Terms::Auto(mut terms) = terms else { return terms };
    let noises = || points.iter().map(|point| &point.inputs.noise);
    terms.extend(noises().any(|noise| noise.markov.is_some()).then_some(Term::Markov));
    terms.extend(noises().any(|noise| noise.sine.is_some()).then_some(Term::Sine));
    Terms::Auto(terms)
}
