//! The Allan variance of sampled noise, in closed form: the theory of the Monte Carlo and the basis of the fit.
//!
//! The angles θ_k, in ″, at the times k·t0, k = 0 … N, are a record of N samples. At the averaging factor m and τ =
//! m·t0 an estimator takes the mean square of differences of angles over 2τ² or 6τ² ([`Difference`], [`Estimator`]).
//! Everything here refers to that sampled record instead of the continuous noise of A(4), from which it differs at
//! small m; see [`continuous`] for the latter. Definitions: IEEE Std 952-2020 and 647-2006, two-sided spectra of the
//! rate.
//!
//! Each [`Part`] of the angle is sampled as follows, where t0 is `sample_s`:
//!
//! | part | sampled as |
//! |---|---|
//! | quantization Q | independent errors of rms Q on all N + 1 angles, θ_0 too |
//! | angle random walk N | independent increments θ_k − θ_{k−1} of variance N²t0 |
//! | bias instability B | rate held over t0, a sum of [octave holds](holds) |
//! | rate random walk K | r_k = r_{k−1} + K√t0·g_k with independent normal g_k of variance 1, θ_k = θ_{k−1} + r_k·t0 |
//! | Markov noise q_c, T_c | r_k = a·r_{k−1} + σ√(1 − a²)·g_k, a = e^{−t0/T_c}, stationary, σ² = q_c²·T_c/2; θ_k = θ_{k−1} + r_k·t0 |
//! | sine Ω_0, f | rate Ω_0 sin(2πft + φ) of uniform φ, integrated exactly |
//! | rate ramp R | rate R·t; whether integrated exactly or held over t0 is the same in all differences |
//! | warm-up A, T | rate A·e^{−t/T} from t = 0, the start of the record, integrated exactly |
//!
//! A readout that counts whole pulses is not white: see [`quantizer`]. A gyro that switches modes adds a sawtooth and
//! jumps: see [`switching`]. LGV-1 by table 2 of A, 9 hours at 1 Hz:
//!
//! ```
//! use sagnac_theory::allan::gaussian::covariance;
//! use sagnac_theory::allan::switching::Jumps;
//! use sagnac_theory::allan::{Difference, Estimator, Part, Process, continuous, quantizer};
//!
//! let parts = vec![
//!     Part::quantization(0.11),
//!     Part::angle_random_walk(0.00048 * 60.0),
//!     Part::bias_instability(0.00164, 24),
//! ];
//! let gyro = Process { sample_s: 1.0, parts };
//! let at_100_s = gyro.expected(Estimator::OVERLAPPING, 32_400, 100).unwrap();
//! assert!((at_100_s.sqrt() - 0.0036).abs() < 5e-5);
//! let model: f64 = gyro.parts.iter().filter_map(|part| continuous::allan_variance(part, 100.0)).sum();
//! assert!((at_100_s / model - 1.0).abs() < 1e-3);
//!
//! // The uncertainty of one record: the scatter of σ² at 100 s.
//! let scatter = covariance(&gyro, Difference::Second, 32_400, &[100])[0][0].sqrt();
//! assert!((scatter / at_100_s - 0.0474).abs() < 5e-4);
//!
//! // A switch every 40 s that leaves 7.07 ″ is an angle random walk of 0.0186 °/√h.
//! let jumps = Jumps { interval: 40, variance: 50.0 };
//! assert!((jumps.angle_random_walk(1.0) / 60.0 - 0.0186).abs() < 5e-5);
//!
//! // At rest, whole pulses of 0.381 ″ are not white noise of q/√12: at 1 s they lack most of 6 q²/12.
//! let still = Process { sample_s: 1.0, parts: vec![Part::angle_random_walk(0.0288)] };
//! let pulses = quantizer::mean_square(0.381, 0.0, &still, Difference::Second, 1).unwrap();
//! assert!(pulses < 0.5 * 0.381 * 0.381);
//! ```

pub mod blocks;
pub mod continuous;
pub mod estimator;
pub mod exponential;
pub mod gaussian;
pub mod generalized;
pub mod holds;
pub mod markov;
pub mod part;
pub mod process;
pub mod quantizer;
pub mod spectrum;
pub mod steps;
pub mod switching;
pub mod terms;

pub use crate::allan::estimator::{Difference, Estimator, Stride};
pub use crate::allan::part::{FLAT_LEVEL, Part, Trend};
pub use crate::allan::process::Process;
pub use crate::allan::terms::Term;
