//! The interval of least drift between those that were tried, and how well it is known.

use super::Tried;

/// Half the width of a 95 % interval in jackknife standard errors of 32 parts: Student's t with 31 degrees of freedom.
pub(super) const T_95: f64 = 2.039_513;

/// Candidates on either side of the least that a parabola is fitted to.
const BESIDE: usize = 4;

/// The interval of least drift, s, with its 95 % interval. Absent of a least that lies at an end of what was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optimum {
    pub interval_s: f64,
    pub lo_s: Option<f64>,
    pub hi_s: Option<f64>,
}

/// The vertex of a parabola through the logarithms of drift and interval round the least of them; by a jackknife over parts of
/// the trials, which all candidates share, how it scatters.
pub(super) fn of(tried: &[Tried]) -> Optimum {
    let all: Vec<f64> = tried.iter().map(|tried| tried.drift.value).collect();
    let least = (0..all.len()).min_by(|&a, &b| all[a].total_cmp(&all[b])).unwrap_or(0);
    let (from, to) = (least.saturating_sub(BESIDE), (least + BESIDE + 1).min(tried.len()));
    let x: Vec<f64> = tried[from..to].iter().map(|tried| libm::log(tried.interval_s)).collect();
    let vertex = |value: &dyn Fn(&Tried) -> f64| {
        let y: Vec<f64> = tried[from..to].iter().map(|tried| libm::log(value(tried))).collect();
        vertex(&x, &y)
    };
    let parts = tried.first().map_or(0, |tried| tried.replicates.len());
    let replicates: Option<Vec<f64>> = (0..parts).map(|k| vertex(&|tried| tried.replicates[k])).collect();
    match (vertex(&|tried| tried.drift.value), replicates) {
        (Some(at), Some(replicates)) => {
            let half = T_95 * jackknife(replicates);
            Optimum {
                interval_s: libm::exp(at),
                lo_s: Some(libm::exp(at - half)),
                hi_s: Some(libm::exp(at + half)),
            }
        }
        _ => Optimum {
            interval_s: tried.get(least).map_or(0.0, |tried| tried.interval_s),
            lo_s: None,
            hi_s: None,
        },
    }
}

/// The standard error that delete-one replicates show.
pub(super) fn jackknife(replicates: Vec<f64>) -> f64 {
    let n = replicates.len() as f64;
    let mean = replicates.iter().sum::<f64>() / n;
    let squares: f64 = replicates.iter().map(|x| (x - mean) * (x - mean)).sum();
    libm::sqrt((n - 1.0) / n * squares)
}

/// Where the least-squares parabola through some points is least, if it is so between the first and the last.
fn vertex(x: &[f64], y: &[f64]) -> Option<f64> {
    let n = x.len() as f64;
    let middle = x.iter().sum::<f64>() / n;
    let moment = |power: i32| x.iter().map(|x| (x - middle).powi(power)).sum::<f64>();
    let with = |power: i32| x.iter().zip(y).map(|(x, y)| (x - middle).powi(power) * y).sum::<f64>();
    let (s2, s3, s4) = (moment(2), moment(3), moment(4));
    let (t0, t1, t2) = (with(0), with(1), with(2));
    // Normal equations of y = a + b u + c u², whose sum over u is 0.
    let determinant = n * (s2 * s4 - s3 * s3) - s2 * s2 * s2;
    if x.len() < 3 || determinant.abs() < 1e-12 * n * s2 * s4 {
        return None;
    }
    let c = (n * (s2 * t2 - s3 * t1) - s2 * s2 * t0) / determinant;
    let b = (t1 - c * s3) / s2;
    let at = middle - b / (2.0 * c);
    let within = (x[0]..=x[x.len() - 1]).contains(&at);
    (c > 0.0 && within).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vertex_of_a_parabola_is_found_from_uneven_points() {
        let x = [0.0, 0.4, 1.0, 1.1, 2.5];
        let y = x.map(|x| 3.0 + 0.7 * (x - 1.3) * (x - 1.3));
        let found = vertex(&x, &y).unwrap();
        assert!((found - 1.3).abs() < 1e-12, "{found}");
        assert_eq!(vertex(&x, &x), None, "a line has none");
        assert_eq!(vertex(&x, &y.map(|y| -y)), None, "a hill has none");
        assert_eq!(vertex(&x[..2], &y[..2]), None, "two points have none");
    }

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        let values = [3.0, 5.0, 4.0, 8.0, 1.0];
        let sum: f64 = values.iter().sum();
        let replicates = values.iter().map(|x| (sum - x) / 4.0).collect();
        let variance: f64 = values.iter().map(|x| (x - sum / 5.0).powi(2)).sum::<f64>() / 4.0;
        assert!((jackknife(replicates) - (variance / 5.0).sqrt()).abs() < 1e-12);
    }
}
