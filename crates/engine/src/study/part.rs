//! The parts of the error of a point, each of which can be switched off.

use std::sync::Arc;

use crate::key::common::Streams;
use crate::study::Study;
use crate::study::kind::Subject;

/// A part of the error of points `P`.
pub(crate) struct Part<P: 'static> {
    /// Its name in sentences and tables, such as `motion`.
    pub(crate) name: &'static str,
    /// Switches it off. A point that does not have the part stays as it is.
    pub(crate) off: fn(&mut P),
}

/// A subject with a point as it is, and without each of its parts.
pub struct Dissected {
    /// The names of the parts that the point has.
    pub(crate) parts: Vec<&'static str>,
    pub(crate) subject: Arc<dyn Subject>,
}

/// A point as it is, and without each of its parts in turn, with the names of those that it has.
pub(crate) fn points<P: Clone + PartialEq>(point: &P, parts: &[Part<P>]) -> (Vec<&'static str>, Vec<P>) {
    let without = |part: &Part<P>| {
        let mut without = point.clone();
        (part.off)(&mut without);
        (without != *point).then_some((part.name, without))
    };
    let (names, others): (Vec<&'static str>, Vec<P>) = parts.iter().filter_map(without).unzip();
    (names, std::iter::once(point.clone()).chain(others).collect())
}

impl Study {
    /// The study of a single one of its points, which comes first, followed by that point without each of its parts in
    /// turn; with the names of these parts. All share their random numbers. `None` where its kind has no parts.
    pub fn dissected(&self, point: usize) -> Option<(Vec<&'static str>, Study)> {
        let Dissected { parts, subject } = self.subject.dissected(point)?;
        let (streams, precision) = (Streams::Common, None);
        Some((parts, Study { subject, streams, precision, charts: vec![], ..self.clone() }))
    }
}
