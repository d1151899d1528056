//! The fit that produced the committed coefficients of polynomials.

/// The polynomial through `f` at the Chebyshev points of [0, 1], as `N` coefficients, that of x^0 first.
pub fn through_chebyshev_points<const N: usize>(f: impl Fn(f64) -> f64) -> [f64; N] {
    let x: [f64; N] = core::array::from_fn(|k| {
        0.5 - 0.5 * libm::cos((2 * k + 1) as f64 * core::f64::consts::PI / (2 * N) as f64)
    });
    let mut divided = x.map(f);
    for order in 1..N {
        for i in (order..N).rev() {
            divided[i] = (divided[i] - divided[i - 1]) / (x[i] - x[i - order]);
        }
    }
    let mut polynomial = [0.0; N];
    for i in (0..N).rev() {
        for k in (1..N).rev() {
            polynomial[k] = polynomial[k - 1] - polynomial[k] * x[i];
        }
        polynomial[0] = divided[i] - polynomial[0] * x[i];
    }
    polynomial
}
