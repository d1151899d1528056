//! Numerical means: Gauss–Legendre quadrature in panels, and a lattice rule, whose points fill a unit cube of any number of
//! dimensions evenly, for means over several drawn values. [`Memo`] keeps values that take long to compute and are needed
//! again with the same arguments, as at the points of a sweep.

use core::f64::consts::PI;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Sixteen points: positive nodes on (−1, 1) and their weights.
const NODES: [[f64; 2]; 8] = [
    [0.095_012_509_837_637_44, 0.189_450_610_455_068_5],
    [0.281_603_550_779_258_9, 0.182_603_415_044_923_6],
    [0.458_016_777_657_227_4, 0.169_156_519_395_002_54],
    [0.617_876_244_402_643_7, 0.149_595_988_816_576_73],
    [0.755_404_408_355_003, 0.124_628_971_255_533_87],
    [0.865_631_202_387_831_8, 0.095_158_511_682_492_78],
    [0.944_575_023_073_232_6, 0.062_253_523_938_647_89],
    [0.989_400_934_991_649_9, 0.027_152_459_411_754_095],
];

/// The points of the sixteen-point rule in each of `panels` equal parts of `low` … `high`, as pairs about the middle of
/// their part, each with the weight of both points.
///
/// The weights of a part add up to 1 over its 8 pairs, so the mean of f is half the weighted sum of f(below) +
/// f(above), divided by the number of parts. A part is exact for polynomials up to degree 31, and accurate to rounding
/// for a sine of one turn.
pub fn pairs(low: f64, high: f64, panels: f64) -> impl Iterator<Item = ([f64; 2], f64)> {
    let width = high - low;
    let half = 0.5 * width / panels;
    (0..panels as usize).flat_map(move |panel| {
        let middle = low + width * (panel as f64 + 0.5) / panels;
        NODES.into_iter().map(move |[node, weight]| ([middle - half * node, middle + half * node], weight))
    })
}

/// How many points an integral over a spectrum takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Sixteen points in each turn, from a table: for theoretical values.
    Panels,
    /// Two points in each turn and some more, computed: for what is sampled, whose work grows with the number of points.
    Sparse,
}

/// Most turns in a panel of the sparse rule, and the points for what is no sine.
const SPARSE_TURNS: f64 = 16.0;
const SPARSE_MORE: f64 = 24.0;

impl Rule {
    /// Calls `add` with places between `low` and `high` and a weight of each, which add up to the distance. The sum of
    /// weight · f is the integral of f to rounding, for an f that has at most so many turns.
    pub fn integrate(self, low: f64, high: f64, turns: f64, mut add: impl FnMut(f64, f64)) {
        let width = high - low;
        match self {
            Rule::Panels => {
                let panels = 1.0 + libm::ceil(turns);
                for (pair, weight) in pairs(low, high, panels) {
                    pair.into_iter().for_each(|place| add(place, 0.5 * weight * width / panels));
                }
            }
            Rule::Sparse => {
                let panels = libm::ceil(turns / SPARSE_TURNS).max(1.0);
                let nodes = gauss(SPARSE_MORE as usize + libm::ceil(2.0 * turns / panels) as usize);
                let half = 0.5 * width / panels;
                for panel in 0..panels as usize {
                    let middle = low + width * (panel as f64 + 0.5) / panels;
                    nodes.iter().for_each(|[node, weight]| add(middle + half * node, half * weight));
                }
            }
        }
    }
}

/// The nodes on (−1, 1) and weights of the rule of `count` points, by Newton's method on the Legendre polynomial.
fn gauss(count: usize) -> std::sync::Arc<[[f64; 2]]> {
    static KNOWN: Memo<usize, std::sync::Arc<[[f64; 2]]>> = Memo::new(64);
    let node = |k: usize| {
        let mut x = libm::cos(PI * (k as f64 + 0.75) / (count as f64 + 0.5));
        let mut slope = 1.0;
        // From this start the error squares with each step: 1e-3, 1e-6, 1e-12, rounding.
        for _ in 0..5 {
            let (mut p, mut before) = (x, 1.0);
            for degree in 2..=count {
                let d = degree as f64;
                (p, before) = (((2.0 * d - 1.0) * x * p - (d - 1.0) * before) / d, p);
            }
            slope = count as f64 * (before - x * p) / ((1.0 - x) * (1.0 + x));
            x -= p / slope;
        }
        [x, 2.0 / ((1.0 - x) * (1.0 + x) * slope * slope)]
    };
    KNOWN.get(count, || (0..count).map(node).collect())
}

/// The means of `count` functions between `low` and `high`; their values where the ends are equal. `f` writes the values
/// of all of them at one place.
pub fn means(low: f64, high: f64, panels: f64, count: usize, f: impl Fn(f64, &mut [f64])) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    if low == high {
        f(low, &mut sums);
        return sums;
    }
    let mut at = [vec![0.0; count], vec![0.0; count]];
    for (places, weight) in pairs(low, high, panels) {
        at.iter_mut().zip(places).for_each(|(values, place)| f(place, values));
        for ((sum, a), b) in sums.iter_mut().zip(&at[0]).zip(&at[1]) {
            *sum += weight * (a + b);
        }
    }
    sums.iter().map(|sum| 0.5 * sum / panels).collect()
}

/// Number of points.
pub const LATTICE_POINTS: u32 = 1 << 17;

/// The generator of the rule of Korobov with the least error in 2 to 6 dimensions, out of 500 tried, for functions with
/// square-integrable second mixed derivatives.
const LATTICE_GENERATOR: u32 = 81_053;

/// The coordinates of a point, each strictly between 0 and 1.
///
/// In one dimension they are the midpoints of equal parts. The mean of a smooth function over the points has an error of
/// about 1/N² for the N points; that of a rough one scatters as if they were independent.
pub fn lattice_point(index: u32) -> impl Iterator<Item = f64> {
    let mut multiple = index;
    core::iter::repeat_with(move || {
        let place = multiple % LATTICE_POINTS;
        multiple = multiple.wrapping_mul(LATTICE_GENERATOR);
        (f64::from(place) + 0.5) / f64::from(LATTICE_POINTS)
    })
}

/// The last few values of a function, with the arguments that give them. Those not used for longest are dropped first.
///
/// Threads that need the same value at the same time may each compute it. Values are never changed, so a value from
/// here has the bits that the function would return.
#[derive(Debug)]
pub struct Memo<K, V> {
    most: usize,
    known: Mutex<VecDeque<(K, V)>>,
}

impl<K: PartialEq, V: Clone> Memo<K, V> {
    /// Keeps at most `most` values.
    pub const fn new(most: usize) -> Memo<K, V> {
        Memo { most, known: Mutex::new(VecDeque::new()) }
    }

    /// The value at `key`, which is computed if it is not known. It takes time in proportion to the number of values.
    pub fn get(&self, key: K, compute: impl FnOnce() -> V) -> V {
        if let Some(value) = find(&mut self.known(), &key) {
            return value;
        }
        let value = compute();
        let mut known = self.known();
        if find(&mut known, &key).is_none() {
            if known.len() >= self.most {
                known.pop_front();
            }
            known.push_back((key, value.clone()));
        }
        value
    }

    fn known(&self) -> MutexGuard<'_, VecDeque<(K, V)>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The value at `key`, which becomes the last one used.
fn find<K: PartialEq, V: Clone>(known: &mut VecDeque<(K, V)>, key: &K) -> Option<V> {
    let place = known.iter().rposition(|(own, _)| own == key)?;
    let found = known.remove(place)?;
    let value = found.1.clone();
    known.push_back(found);
    Some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_rules_integrate_waves_and_powers_to_rounding() {
        for rule in [Rule::Panels, Rule::Sparse] {
            for turns in [0.0, 0.3, 1.0, 7.5, 16.0, 40.0, 131.0] {
                let k = core::f64::consts::TAU * turns / 3.0;
                let (mut wave, mut power, mut width) = (0.0, 0.0, 0.0);
                rule.integrate(2.0, 5.0, turns, |x, weight| {
                    wave += weight * libm::cos(k * x + 0.3);
                    power += weight * libm::pow(x, 7.5);
                    width += weight;
                });
                let exact = match k {
                    0.0 => 3.0 * libm::cos(0.3),
                    k => (libm::sin(5.0 * k + 0.3) - libm::sin(2.0 * k + 0.3)) / k,
                };
                assert!((wave - exact).abs() < 1e-13, "{rule:?}, {turns}: {wave}, not {exact}");
                let exact = (libm::pow(5.0, 8.5) - libm::pow(2.0, 8.5)) / 8.5;
                assert!((power / exact - 1.0).abs() < 1e-14, "{rule:?}, {turns}: {power}, not {exact}");
                assert!((width - 3.0).abs() < 1e-12, "{rule:?}, {turns}: {width}");
            }
        }
    }

    #[test]
    fn the_mean_of_a_polynomial_of_degree_31_and_of_a_turn_is_right_to_rounding() {
        let power = |x: f64, terms: &mut [f64]| terms[0] = libm::pow(x, 31.0) + libm::pow(x, 30.0);
        let power = means(-1.0, 1.0, 1.0, 1, power)[0];
        assert!((power - 1.0 / 31.0).abs() < 1e-15, "{power}");
        let turn = |x: f64, terms: &mut [f64]| terms[0] = 1.0 + libm::cos(core::f64::consts::TAU * x + 0.3);
        let turn = means(2.0, 5.0, 3.0, 1, turn)[0];
        assert!((turn - 1.0).abs() < 1e-14, "{turn}");
    }

    #[test]
    fn every_coordinate_takes_each_part_once() {
        for dimension in 0..24 {
            let mut taken = vec![false; LATTICE_POINTS as usize];
            for index in 0..LATTICE_POINTS {
                let x = lattice_point(index).nth(dimension).unwrap();
                taken[(x * f64::from(LATTICE_POINTS)) as usize] = true;
            }
            let missed = taken.iter().filter(|taken| !**taken).count();
            assert_eq!(missed, 0, "of dimension {dimension}");
        }
    }

    /// The mean of a product of functions of mean 1 is 1.
    #[test]
    fn the_mean_of_a_smooth_function_is_right_to_a_ten_millionth_up_to_four_dimensions() {
        for dimensions in 1..=4 {
            let of = |x: f64| 1.0 + 2.0 * (x * x - x + 1.0 / 6.0);
            let product = |index| lattice_point(index).take(dimensions).map(of).product::<f64>();
            let mean = (0..LATTICE_POINTS).map(product).sum::<f64>() / f64::from(LATTICE_POINTS);
            assert!((mean - 1.0).abs() < 1e-7, "{dimensions} dimensions: {mean}");
        }
    }

    #[test]
    fn a_value_is_computed_once_until_others_displace_it() {
        let memo = Memo::new(2);
        let mut computed = Vec::new();
        for key in [1, 2, 1, 3, 1, 2] {
            let value = memo.get(key, || {
                computed.push(key);
                10 * key
            });
            assert_eq!(value, 10 * key);
        }
        // 2 was used least recently when 3 came.
        assert_eq!(computed, [1, 2, 3, 2]);
    }
}
