//! Gauss–Legendre quadrature in panels.

use core::f64::consts::PI;

use crate::memo::Memo;

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
}
