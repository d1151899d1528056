//! The interval of least drift between those that were tried, with its uncertainty.

use crate::analysis::design::{Found, Tried};
use crate::analysis::jackknife::{T_95, jackknife};
use crate::fit::nnls;

/// The law is fitted where the drift is at most this many times its minimum.
const FITTED: f64 = 1.6;

/// Fewest candidates for a fit of the four terms.
const FEWEST: usize = 6;

/// The minimum of the law of the drift without its non-magnetic part, with its scatter from a jackknife over parts of the trials, which all
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
    let parts = tried.first().map_or(0, |tried| tried.switched_replicates.len());
    let replicates: Option<Vec<f64>> =
        (0..parts).map(|k| Some(libm::log(least(&|tried| tried.switched_replicates[k])?))).collect();
    match (least(&|tried| tried.switched.value), replicates) {
        (Some(at), Some(replicates)) => {
            let factor = libm::exp(T_95 * jackknife(&replicates));
            Found { value: at, interval: Some((at / factor, at * factor)) }
        }
        _ => Found { value: tried.get(place).map_or(0.0, |tried| tried.interval_s), interval: None },
    }
}

/// The place of the least of some numbers, the first of equal ones.
pub(crate) fn least_of(values: &[f64]) -> usize {
    (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0)
}

/// The index of the interval to choose, and the range of the best one: the fitted optimum with its interval, extended
/// to all tried intervals whose drift does not differ significantly from the least. The law is only smooth, so a tried
/// interval that is better than it predicts takes precedence.
pub(crate) fn among(tried: &[Tried], fitted: Found) -> (usize, Found) {
    let drifts: Vec<f64> = tried.iter().map(|tried| tried.switched.value).collect();
    let least = least_of(&drifts);
    let is_as_good = |place: &usize| {
        let pairs = tried[*place].switched_replicates.iter().zip(&tried[least].switched_replicates);
        let apart: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
        drifts[*place] - drifts[least] <= T_95 * jackknife(&apart)
    };
    let good: Vec<usize> = (0..tried.len()).filter(|place| *place == least || is_as_good(place)).collect();
    let far = |place: &usize| libm::log(tried[*place].interval_s / fitted.value).abs();
    let best = good.iter().copied().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(least);
    let ends = good.iter().map(|place| tried[*place].interval_s);
    let at_end = good.first() == Some(&0) || good.last() == Some(&(tried.len() - 1));
    let extended =
        |(low, high): (f64, f64)| (ends.clone().fold(low, f64::min), ends.clone().fold(high, f64::max));
    let interval = fitted.interval.filter(|_| tried.len() > 1 && !at_end).map(extended);
    (best, Found { value: tried[best].interval_s, interval })
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
    if x.len() < FEWEST {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
