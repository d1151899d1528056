//! The interval of least drift between those that were tried, with its uncertainty, and standard errors from parts of the trials: each
//! of them left out in turn, or balanced halves of them.

use crate::analysis::design::{Found, Tried};
use sagnac_records::fit::nnls;

/// The law is fitted where the drift is at most this many times its minimum.
const FITTED: f64 = 1.6;

/// Fewest candidates for a fit of the four terms.
const MIN_CANDIDATES: usize = 6;

/// The minimum of the law of the drift without its non-magnetic part, with its scatter over balanced halves of the trials, which all
/// candidates share.
///
/// The square of a level of the drift is approximately (a MT + k √(b/MT + c))²: the uncancelled magnetic drift grows
/// with MT, the contribution of the switches falls as 1/√MT, and the rest does not depend on it. It is therefore fitted
/// as a non-negative sum of MT², √MT, 1 and 1/MT.
///
/// Without such a minimum it is the tried interval of least drift, without an uncertainty.
pub(crate) fn of(tried: &[Tried]) -> Found {
    let all: Vec<f64> = tried.iter().map(|tried| tried.switched.value).collect();
    let place = least_of(&all);
    let fitted: Vec<&Tried> =
        tried.iter().filter(|tried| tried.switched.value <= FITTED * all[place]).collect();
    let x: Vec<f64> = fitted.iter().map(|tried| tried.interval_s).collect();
    let least = |value: &dyn Fn(&Tried) -> f64| {
        let y: Vec<f64> = fitted.iter().map(|tried| value(tried)).collect();
        least(&x, &y)
    };
    let pairs = tried.first().map_or(0, |tried| tried.switched_halves.len());
    let of_half = |k: usize, half: usize| Some(libm::log(least(&|tried| tried.switched_halves[k][half])?));
    let halves: Option<Vec<[f64; 2]>> = (0..pairs).map(|k| Some([of_half(k, 0)?, of_half(k, 1)?])).collect();
    match (least(&|tried| tried.switched.value), halves) {
        (Some(at), Some(halves)) => {
            let factor = libm::exp(T_95 * of_halves(&halves));
            Found { value: at, interval: Some((at / factor, at * factor)) }
        }
        _ => Found { value: tried.get(place).map_or(0.0, |tried| tried.interval_s), interval: None },
    }
}

/// The place of the least of some numbers, the first of equal ones.
pub(crate) fn least_of(values: &[f64]) -> usize {
    (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0)
}

/// The index of the interval to choose, and the range of the best one: of the tried intervals whose drift does not differ
/// significantly from the least, the one nearest to the fitted optimum, with the interval of that, which is extended to the
/// chosen one. The law is only smooth, so a tried interval that is better than it predicts takes precedence.
pub(crate) fn among(tried: &[Tried], fitted: Found) -> (usize, Found) {
    let drifts: Vec<f64> = tried.iter().map(|tried| tried.switched.value).collect();
    let least = least_of(&drifts);
    let is_as_good = |place: &usize| {
        let pairs = tried[*place].switched_halves.iter().zip(&tried[least].switched_halves);
        let apart: Vec<[f64; 2]> = pairs.map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).collect();
        drifts[*place] - drifts[least] <= T_95 * of_halves(&apart)
    };
    let good: Vec<usize> = (0..tried.len()).filter(|place| *place == least || is_as_good(place)).collect();
    let far = |place: &usize| libm::log(tried[*place].interval_s / fitted.value).abs();
    let best = good.iter().copied().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(least);
    let (at, at_end) = (tried[best].interval_s, best == 0 || best + 1 == tried.len());
    let extended = |(low, high): (f64, f64)| (low.min(at), high.max(at));
    (best, Found { value: at, interval: fitted.interval.filter(|_| !at_end).map(extended) })
}

/// Terms of the squared drift at an interval relative to the middle one.
fn terms(u: f64) -> [f64; 4] {
    [u * u, libm::sqrt(u), 1.0, 1.0 / u]
}

/// Steps between the first and the last interval in the search for the minimum.
const STEPS: usize = 2000;

/// The minimum of the law fitted to these drifts, if it is not at either end.
fn least(x: &[f64], y: &[f64]) -> Option<f64> {
    let (first, last) = (*x.first()?, *x.last()?);
    if x.len() < MIN_CANDIDATES {
        return None;
    }
    let middle = libm::sqrt(first * last);
    // Each weighted by its own square, which makes all equally accurate.
    let column = |term: usize| -> Vec<f64> {
        x.iter().zip(y).map(|(x, y)| terms(x / middle)[term] / (y * y)).collect()
    };
    let found = nnls(&[0, 1, 2, 3].map(column), &vec![1.0; x.len()]);
    let law = |at: f64| terms(at / middle).iter().zip(&found).map(|(term, a)| term * a).sum::<f64>();
    let at = |k: usize| first * libm::exp(libm::log(last / first) * k as f64 / STEPS as f64);
    let place = (0..=STEPS).min_by(|&a, &b| law(at(a)).total_cmp(&law(at(b))))?;
    (place > 0 && place < STEPS).then(|| at(place))
}

/// Number of parts of the trials.
pub(crate) const PARTS: u64 = 32;

/// Half the width of a 95 % interval in jackknife standard errors of all parts: Student's t with 31 degrees of freedom.
pub(crate) const T_95: f64 = 2.039_513;

/// The standard error from delete-one replicates.
pub(crate) fn jackknife(replicates: &[f64]) -> f64 {
    let n = replicates.len() as f64;
    let mean = replicates.iter().sum::<f64>() / n;
    let squares: f64 = replicates.iter().map(|x| (x - mean) * (x - mean)).sum();
    libm::sqrt((n - 1.0) / n * squares)
}

/// The parts in each of the balanced halves of all parts, by the rows of a Hadamard matrix, and those in its complement:
/// 31 pairs, in which any two parts are in the same half as often as not.
pub(crate) fn halves() -> impl Iterator<Item = [Vec<usize>; 2]> {
    let is_in = |half: u64, part: u64| (half & part).count_ones().is_multiple_of(2);
    (1..PARTS).map(move |half| {
        let (one, other): (Vec<u64>, Vec<u64>) = (0..PARTS).partition(|part| is_in(half, *part));
        [one, other].map(|parts| parts.into_iter().map(|part| part as usize).collect())
    })
}

/// The standard error from an estimate in each of the [`halves`] and in its complement. Halves differ by as much as the
/// estimate itself scatters, so that it holds for levels found in bins and for minima, of which the small differences without
/// one part tell the scatter badly (McCarthy, *Review of the International Statistical Institute* 37, 1969, 239).
pub(crate) fn of_halves(pairs: &[[f64; 2]]) -> f64 {
    let squares: f64 = pairs.iter().map(|[a, b]| 0.25 * (a - b) * (a - b)).sum();
    libm::sqrt(squares / pairs.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_kernel::moments::{level, level_edge};

    /// The 99.73 % level of errors that are counted in bins as those of runs are.
    fn level_of(counts: &[u32]) -> f64 {
        let rank = 0.9973 * f64::from(counts.iter().sum::<u32>());
        let mut below = 0.0;
        for (bin, &count) in (0..).zip(counts) {
            if count > 0 && below + f64::from(count) >= rank {
                let (low, high) = (level_edge(bin) as f64, level_edge(bin + 1) as f64);
                return low + (high - low) * (rank - below) / f64::from(count);
            }
            below += f64::from(count);
        }
        unreachable!("the rank is below the count")
    }

    /// Normally distributed numbers from a generator of its own.
    struct Normals(u64);

    impl Normals {
        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 * (0.5_f64).powi(53) + 1e-17
        }

        fn next(&mut self) -> f64 {
            let (u, v) = (self.uniform(), self.uniform());
            (-2.0 * u.ln()).sqrt() * (core::f64::consts::TAU * v).cos()
        }
    }

    /// Runs whose errors are a MT u + √(b/MT) v with normal u, which all intervals share, and v, which they share in part.
    /// The best interval is 1.
    fn simulated(trials: u64, seed: u64) -> Vec<Tried> {
        const BINS: usize = 1 << 12;
        let intervals: Vec<f64> = (0..12).map(|k| 0.4 * 1.19_f64.powi(k)).collect();
        let mut counts = vec![vec![vec![0_u32; BINS]; PARTS as usize]; intervals.len()];
        let mut normals = Normals(seed);
        for trial in 0..trials {
            let (u, shared) = (normals.next(), normals.next());
            for (of_interval, x) in counts.iter_mut().zip(&intervals) {
                let v = 0.6_f64.sqrt() * shared + 0.4_f64.sqrt() * normals.next();
                let error = 1e5 * (x * u + (2.0 / x).sqrt() * v).abs();
                of_interval[(trial * PARTS / trials) as usize][level(error as u32) as usize] += 1;
            }
        }
        let of = |(interval_s, parts): (f64, &Vec<Vec<u32>>)| {
            let sum = |of: &[usize]| -> f64 {
                level_of(
                    &(0..BINS).map(|bin| of.iter().map(|&part| parts[part][bin]).sum()).collect::<Vec<_>>(),
                )
            };
            let drift = Found { value: sum(&(0..PARTS as usize).collect::<Vec<_>>()), interval: None };
            let halves: Vec<[f64; 2]> = halves().map(|half| half.each_ref().map(|half| sum(half))).collect();
            let (switched, switched_halves) = (drift, halves.clone());
            Tried { interval_s, switches: 1, drift, closed_form: None, halves, switched, switched_halves }
        };
        intervals.iter().copied().zip(&counts).map(of).collect()
    }

    #[test]
    fn intervals_of_the_best_interval_cover_it_and_are_half_as_wide_with_four_times_the_runs() {
        const SEEDS: u64 = 48;
        let widths = [4096, 16384].map(|trials| {
            let mut widths = vec![];
            let mut covered = 0;
            for seed in 0..SEEDS {
                let tried = simulated(trials, 1000 * seed + trials);
                let (low, high) = among(&tried, of(&tried)).1.interval.expect("a minimum between the ends");
                let (low, high) = of(&tried).interval.map_or((low, high), |fitted| fitted);
                widths.push((high / low).ln());
                covered += u64::from(low <= 1.0 && 1.0 <= high);
            }
            widths.sort_by(f64::total_cmp);
            let part = covered as f64 / SEEDS as f64;
            // Three standard errors of 95 % of so many seeds.
            let error = (0.95 * 0.05 / SEEDS as f64).sqrt();
            assert!((part - 0.95).abs() < 3.0 * error, "{trials}: {part} of the intervals cover it");
            let [narrow, middle, wide] = [2, SEEDS as usize / 2, SEEDS as usize - 3].map(|at| widths[at]);
            assert!(middle < 2.0 * narrow && wide < 2.0 * middle, "{trials}: {narrow} {middle} {wide}");
            middle
        });
        let ratio = widths[0] / widths[1];
        assert!((1.5..2.7).contains(&ratio), "{widths:?}: half as wide with four times the runs");
    }

    #[test]
    fn the_least_of_a_law_is_found_from_few_points() {
        // a MT and √(b/MT): MT³ = b/2a².
        let law = |x: f64| (4.0 * x * x + 27.0 / x).sqrt();
        let exact = (27.0_f64 / 8.0).cbrt();
        let x: Vec<f64> = (0..8).map(|k| 0.6 * 1.25_f64.powi(k)).collect();
        let y: Vec<f64> = x.iter().map(|x| law(*x)).collect();
        let found = least(&x, &y).unwrap();
        assert!((found / exact - 1.0).abs() < 2e-3, "{found}, not {exact}");
        assert_eq!(least(&x[5..], &y[5..]), None, "too few");
        let rising: Vec<f64> = x.iter().map(|x| x * 3.0).collect();
        assert_eq!(least(&x, &rising), None, "at the end");
    }

    #[test]
    fn for_random_laws_no_interval_between_those_tried_is_better_than_the_one_found() {
        let mut uniform = Normals(46);
        let mut found = 0;
        for case in 0..200 {
            let mut power = |low: f64, high: f64| libm::exp10(low + (high - low) * uniform.uniform());
            let [scale, a, b, c, d] =
                [power(-1.0, 4.0), power(-1.0, 1.0), power(-3.0, 0.0), power(-3.0, 0.0), power(-1.0, 1.0)];
            let law = |x: f64| {
                let u = x / scale;
                libm::sqrt(a * u * u + b * libm::sqrt(u) + c + d / u)
            };
            let x: Vec<f64> = (0..9).map(|k| scale * 0.3 * 1.35_f64.powi(k)).collect();
            let y: Vec<f64> = x.iter().map(|x| law(*x)).collect();
            let Some(best) = least(&x, &y) else { continue };
            found += 1;
            let lowest = (0..=10_000)
                .map(|k| law(x[0] * libm::exp(libm::log(x[8] / x[0]) * f64::from(k) / 1e4)))
                .fold(f64::INFINITY, f64::min);
            assert!(law(best) <= lowest * (1.0 + 1e-5), "case {case}: {} at {best}, but {lowest}", law(best));
        }
        assert!(found > 100, "{found} of 200 laws have a minimum between the ends");
    }

    #[test]
    fn balanced_halves_give_the_standard_error_of_a_mean() {
        let values: Vec<f64> = (0..PARTS).map(|k| (k * k % 37) as f64).collect();
        let mean =
            |parts: &Vec<usize>| parts.iter().map(|&part| values[part]).sum::<f64>() / parts.len() as f64;
        let pairs: Vec<[f64; 2]> = halves().map(|half| half.each_ref().map(mean)).collect();
        let all = values.iter().sum::<f64>() / PARTS as f64;
        let squares: f64 = values.iter().map(|x| (x - all).powi(2)).sum();
        let exact = (squares / (PARTS * (PARTS - 1)) as f64).sqrt();
        assert!((of_halves(&pairs) / exact - 1.0).abs() < 1e-12, "{} {exact}", of_halves(&pairs));
    }

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        let values = [3.0, 5.0, 4.0, 8.0, 1.0];
        let sum: f64 = values.iter().sum();
        let replicates: Vec<f64> = values.iter().map(|x| (sum - x) / 4.0).collect();
        let variance: f64 = values.iter().map(|x| (x - sum / 5.0).powi(2)).sum::<f64>() / 4.0;
        assert!((jackknife(&replicates) - (variance / 5.0).sqrt()).abs() < 1e-12);
    }
}
