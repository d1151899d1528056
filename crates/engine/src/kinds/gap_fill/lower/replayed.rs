//! A recorded profile in units of angle, and its responses, which points with the same record, tick and unit share.

use std::sync::{Arc, Weak};

use crate::kinds::gap_fill::lower::fixed::FixedProfile;
use crate::kinds::gap_fill::lower::response::{Functional, Response};
use crate::motion::Replay;
use crate::tally::{Id, LEVEL};
use sagnac_kernel::gap_fill::shape::MARGIN;
use sagnac_theory::memo::Memo;

/// The angles of a replay in units, and the responses to them.
#[derive(Debug)]
pub(crate) struct Rounded {
    /// Angle since the start at the boundaries of ticks, LSB, wrapped.
    pub(crate) angles: Arc<[u32]>,
    /// Identifies the angles.
    pub(crate) content: Id,
    responses: Memo<Asked, Response>,
}

/// What a response depends on besides the angles.
#[derive(Debug, PartialEq)]
struct Asked {
    ticks: Vec<i32>,
    weights: Vec<i64>,
    scale: i64,
    gap: i32,
    positions: usize,
    constant: u64,
}

/// Most responses that are kept of one replay: those of a dozen fillers at as many gaps.
const MAX_RESPONSES: usize = 256;

/// Number of positions that are summed together, tick by tick, so that the compiler can use vector instructions.
const AT_ONCE: usize = 256;

/// The angles of a replay, which is recognized by its place in memory, in units of so many ″. They have up to 16 MB each.
static ROUNDED: Memo<Unit, Arc<Rounded>> = Memo::new(8);

/// A replay with a unit of angle.
struct Unit {
    replay: Weak<Replay>,
    lsb: u64,
}

impl PartialEq for Unit {
    fn eq(&self, other: &Unit) -> bool {
        self.replay.ptr_eq(&other.replay) && self.lsb == other.lsb
    }
}

impl PartialEq for Rounded {
    fn eq(&self, other: &Rounded) -> bool {
        self.content == other.content
    }
}

impl Rounded {
    /// The angles of a replay in units of `lsb_arcsec`.
    pub(crate) fn of(replay: &Arc<Replay>, lsb_arcsec: f64) -> Arc<Rounded> {
        let unit = Unit { replay: Arc::downgrade(replay), lsb: lsb_arcsec.to_bits() };
        ROUNDED.get(unit, || {
            let mut sum = 0.0;
            let ends = replay.angles.iter().map(|angle| {
                sum += angle;
                // Only differences are used, so the angle may wrap.
                libm::round(sum / lsb_arcsec) as i64 as u32
            });
            let angles: Arc<[u32]> = core::iter::once(0).chain(ends).collect();
            let content = Id::of_words(angles.iter().copied());
            Arc::new(Rounded { angles, content, responses: Memo::new(MAX_RESPONSES) })
        })
    }
}

impl FixedProfile {
    /// The angle from the start of the gap at one of the positions to the end of a tick, LSB, wrapped.
    pub(crate) fn angle(&self, position: usize, tick: i32) -> i32 {
        let start = position + MARGIN;
        let end = start.wrapping_add_signed(tick as isize);
        self.rounded.angles[end].wrapping_sub(self.rounded.angles[start]) as i32
    }

    /// The response, with a `constant` error beside the motion.
    pub(crate) fn response(&self, f: &Functional, constant: f64) -> Response {
        let asked = Asked {
            ticks: f.ticks.to_vec(),
            weights: f.weights.to_vec(),
            scale: f.scale,
            gap: f.gap,
            positions: self.positions,
            constant: constant.to_bits(),
        };
        self.rounded.responses.get(asked, || self.compute_response(f, constant))
    }

    fn compute_response(&self, f: &Functional, constant: f64) -> Response {
        let (mut sum, mut square, mut terms) = (0.0, 0.0, 0.0_f64);
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut sizes = Vec::with_capacity(self.positions);
        let mut filled = [[0.0_f64; 2]; AT_ONCE];
        for start in (0..self.positions).step_by(AT_ONCE) {
            let filled = &mut filled[..AT_ONCE.min(self.positions - start)];
            filled.fill([0.0; 2]);
            for (&tick, &w) in f.ticks.iter().zip(f.weights) {
                let ends = &self.rounded.angles[(start + MARGIN).wrapping_add_signed(tick as isize - 1)..];
                for (filled, ends) in filled.iter_mut().zip(ends.windows(2)) {
                    let x = w as f64 * f64::from(ends[1].wrapping_sub(ends[0]) as i32);
                    *filled = [filled[0] + x, filled[1] + x.abs()];
                }
            }
            for (place, [filled, size]) in filled.iter().enumerate() {
                let gap = f.scale as f64 * f64::from(self.angle(start + place, f.gap));
                let e = filled - gap;
                sum += e;
                square += e * e;
                (least, greatest) = (least.min(e), greatest.max(e));
                sizes.push((e + constant).abs());
                terms = terms.max(size + gap.abs());
            }
        }
        let count = self.positions as f64;
        let mean = sum / count;
        let rank = ((LEVEL * count) as usize).min(self.positions - 1);
        let level = *sizes.select_nth_unstable_by(rank, f64::total_cmp).1;
        Response {
            mean,
            variance: (square / count - mean * mean).max(0.0),
            bound: least.abs().max(greatest.abs()),
            largest: Some((least + constant).abs().max((greatest + constant).abs())),
            level: Some(level),
            terms,
            ..Response::default()
        }
    }
}
