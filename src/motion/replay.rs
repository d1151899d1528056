//! What follows from a recorded motion, computed once for all points that share the record, the tick and the gap.

use std::sync::{Arc, Weak};

use crate::motion::Profile;
use crate::motion::keys::{Design, Interpolation};
use crate::record::Record;
use crate::tally::id::Id;
use crate::theory::autocovariance::autocovariance;
use crate::theory::memo::Memo;

/// The ticks of a record that are replayed.
#[derive(Debug)]
pub(crate) struct Replay {
    /// Their angles, ″.
    pub(crate) angles: Vec<f64>,
    /// Identifies the angles by their bits.
    pub(crate) content: Id,
}

/// A record, recognised by its place in memory without being kept, with the tick, and how it is made of the samples.
struct Cut {
    record: Weak<Record>,
    tick_s: f64,
    interpolation: Interpolation,
    design: Design,
}

impl PartialEq for Cut {
    fn eq(&self, other: &Cut) -> bool {
        self.record.ptr_eq(&other.record)
            && self.tick_s.to_bits() == other.tick_s.to_bits()
            && (self.interpolation, self.design) == (other.interpolation, other.design)
    }
}

/// Replays have up to 32 MB each.
static REPLAYS: Memo<Cut, Arc<Replay>> = Memo::new(4);
/// Covariances by lag, of the number of lags that is the second part of the key.
static COVARIANCES: Memo<(Cut, usize), Arc<[f64]>> = Memo::new(64);
static VARIANCES: Memo<Cut, f64> = Memo::new(64);

impl Profile {
    fn cut(&self, tick_s: f64) -> Cut {
        let Profile { interpolation, design, .. } = *self;
        Cut { record: Arc::downgrade(&self.record), tick_s, interpolation, design }
    }

    /// The ticks that are replayed.
    pub(crate) fn replay(&self, tick_s: f64) -> Arc<Replay> {
        REPLAYS.get(self.cut(tick_s), || {
            let (_, before) = self.replayed(tick_s);
            let angles = self.tick_angles(tick_s).split_off(before);
            let words = angles.iter().map(|angle| angle.to_bits()).flat_map(|x| [x as u32, (x >> 32) as u32]);
            Arc::new(Replay { content: Id::of_words(words), angles })
        })
    }

    /// Covariance at so many lags of the ticks from which fillers are designed, ″².
    pub(crate) fn covariance(&self, tick_s: f64, lags: usize) -> Arc<[f64]> {
        let compute = || autocovariance(&self.design_ticks(tick_s), lags).into();
        COVARIANCES.get((self.cut(tick_s), lags), compute)
    }

    /// Variance of the angles of all ticks, ″².
    pub(crate) fn variance(&self, tick_s: f64) -> f64 {
        VARIANCES.get(self.cut(tick_s), || autocovariance(&self.tick_angles(tick_s), 1)[0])
    }
}
