//! Weights of polynomials with none of the program's arithmetic.

/// The least-squares polynomial by Gram and Schmidt on the ticks.
pub fn polynomial(ticks: &[i32], order: i32, length: i32) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let places: Vec<f64> = ticks.iter().copied().chain(1..=length).map(f64::from).collect();
    let fitted = ticks.len();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for power in 0..=order {
        let mut own: Vec<f64> = places.iter().map(|x| x.powi(power)).collect();
        for other in &basis {
            let along = dot(&own[..fitted], &other[..fitted]);
            own.iter_mut().zip(other).for_each(|(own, other)| *own -= along * other);
        }
        let length = dot(&own[..fitted], &own[..fitted]).sqrt();
        own.iter_mut().for_each(|x| *x /= length);
        basis.push(own);
    }
    (0..fitted).map(|k| basis.iter().map(|q| q[k] * q[fitted..].iter().sum::<f64>()).sum()).collect()
}
