//! What follows from a recorded motion, computed once for all points that share the record, the tick and the gap.

use std::sync::{Arc, Weak};

use crate::motion::Profile;
use crate::motion::keys::{Design, Interpolation};
use crate::tally::id::Id;
use sagnac_kernel::gap_fill::shape::MARGIN;
use sagnac_records::record::Record;
use sagnac_theory::cholesky::semidefinite;
use sagnac_theory::double::Double;
use sagnac_theory::memo::Memo;
use sagnac_theory::rows::{Rows, TickRows, ticks};

/// The ticks of a record that are replayed.
#[derive(Debug)]
pub(crate) struct Replay {
    /// Their angles, ″.
    pub(crate) angles: Vec<f64>,
    /// Identifies the angles by their bits.
    pub(crate) content: Id,
}

/// Means over all places of the gap in a record of the ticks round it, ″, and of their products, ″²; the first tick is that
/// farthest before the gap.
#[derive(Debug)]
pub(crate) struct WindowMeans {
    pub(crate) ticks: Vec<Double>,
    pub(crate) products: Vec<Vec<Double>>,
}

/// A record, recognized by its place in memory without being kept, with the tick, and how it is made of the samples.
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
/// Rows for a gap of some ticks with some ticks on either side.
static ROWS: Memo<(Cut, u32, usize), Arc<TickRows>> = Memo::new(64);
/// Means of what is replayed, for a gap of some ticks with some ticks on either side.
static MEANS: Memo<(Cut, u32, usize), Arc<WindowMeans>> = Memo::new(16);
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

    /// The ticks round a gap as rows, ″, whose products are means over all places of the gap, with `sides` ticks on either
    /// side, in the part from which fillers are designed. From them follow the weights of least squares over these
    /// places.
    ///
    /// The mean of all ticks is removed, which changes no filler that keeps a constant rate. A stationary estimate of the
    /// covariance by lag would leave several times the error where the motion is nearly predictable.
    pub(crate) fn tick_rows(&self, tick_s: f64, gap_ticks: u32, sides: usize) -> TickRows {
        let compute = || {
            let angles = self.design_ticks(tick_s);
            let mean = angles.iter().sum::<f64>() / angles.len().max(1) as f64;
            let swings: Vec<f64> = angles.iter().map(|angle| angle - mean).collect();
            let means = window_means(&swings, gap_ticks as usize + 2 * sides);
            let at = |tick: i32| (tick - 1 + sides as i32) as usize;
            let order: Vec<usize> = ticks(gap_ticks, sides).map(at).collect();
            let matrix: Vec<Vec<f64>> = order
                .iter()
                .map(|&i| order.iter().map(|&j| means.products[i][j].value()).collect())
                .collect();
            let mut rows = Rows::default();
            semidefinite(&matrix).iter().for_each(|row| rows.push(row, row.len(), &[]));
            TickRows::new(gap_ticks, rows).into()
        };
        ROWS.get((self.cut(tick_s), gap_ticks, sides), compute).as_ref().clone()
    }

    /// Means over the places that are replayed, with `sides` ticks on either side of the gap.
    pub(crate) fn window_means(&self, tick_s: f64, gap_ticks: u32, sides: usize) -> Arc<WindowMeans> {
        MEANS.get((self.cut(tick_s), gap_ticks, sides), || {
            let angles = &self.replay(tick_s).angles;
            // The places of trials leave the margin free, whatever fillers read.
            let unread = MARGIN - sides;
            window_means(&angles[unread..angles.len() - unread], gap_ticks as usize + 2 * sides).into()
        })
    }

    /// Variance of the angles of all ticks, ″².
    pub(crate) fn variance(&self, tick_s: f64) -> f64 {
        VARIANCES.get(self.cut(tick_s), || {
            let angles = self.tick_angles(tick_s);
            let count = angles.len().max(1) as f64;
            let mean = angles.iter().sum::<f64>() / count;
            angles.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count
        })
    }
}

/// Means over all windows of `width` ticks; 0 where there is none.
fn window_means(x: &[f64], width: usize) -> WindowMeans {
    let mut ticks = vec![Double::default(); width];
    let mut products = vec![vec![Double::default(); width]; width];
    let Some(windows) = (x.len() + 1).checked_sub(width).filter(|windows| *windows > 0) else {
        return WindowMeans { ticks, products };
    };
    for j in 0..width {
        let later = &x[j..j + windows];
        ticks[j] = later.iter().fold(Double::default(), |sum, x| sum + Double::from(*x));
        let pairs = x[..windows].iter().zip(later);
        products[0][j] = pairs.fold(Double::default(), |sum, (a, b)| sum + Double::product(*a, *b));
        // Along a diagonal each window leaves its first product and takes one more.
        for i in 1..width - j {
            products[i][i + j] = products[i - 1][i + j - 1] - Double::product(x[i - 1], x[i + j - 1])
                + Double::product(x[windows + i - 1], x[windows + i + j - 1]);
        }
    }
    let part = Double::from(1.0 / windows as f64);
    ticks.iter_mut().for_each(|sum| *sum = *sum * part);
    products.iter_mut().flatten().for_each(|sum| *sum = *sum * part);
    for (i, j) in (0..width).flat_map(|i| (0..i).map(move |j| (i, j))) {
        products[i][j] = products[j][i];
    }
    WindowMeans { ticks, products }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_means_over_all_windows() {
        let x: Vec<f64> = (0..40).map(|k| libm::sin(f64::from(k * k))).collect();
        let found = window_means(&x, 7);
        for (i, j) in (0..7).flat_map(|i| (0..7).map(move |j| (i, j))) {
            let expected = (0..34).map(|s| x[s + i] * x[s + j]).sum::<f64>() / 34.0;
            let found = found.products[i][j].value();
            assert!((found - expected).abs() < 1e-14, "{i}, {j}: {found}, not {expected}");
        }
        assert_eq!(window_means(&x[..6], 7).products[0][0], Double::default());
    }
}
