//! The angle random walk that lock-in leaves in a dithered gyro, `[noise.lock_in]`.

use crate::key::places::Places;
use crate::noise::keys::FILE;
use sagnac_base::quantity::number::significant;
use sagnac_base::source::diagnose::Fault;
use sagnac_theory::lock_in::{self, MIN_SPREAD, Premise, dither_rate};

/// °/√h of 1 ″/√s.
const DEG_PER_SQRT_H: f64 = 1.0 / 60.0;
/// Least amplitude of the dither, in radians of the beat phase, for which the closed form is taken at all.
const MIN_AMPLITUDE: f64 = 1.0;

/// A gyro whose lock-in becomes angle random walk, as its dither is randomized.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LockIn {
    /// Lock-in threshold Ω_L, ″/s.
    pub threshold: f64,
    /// Scale factor q, ″ per pulse.
    pub scale_factor: f64,
    /// Amplitude of the dither: of its rate, ″/s, or of its angle, ″.
    pub dither_amplitude: f64,
    /// Whether the amplitude is that of the angle.
    pub of_angle: bool,
    /// Dither frequency, Hz.
    pub dither_hz: f64,
}

impl LockIn {
    /// The gyro with the amplitude of its dither as a rate.
    pub fn gyro(&self) -> lock_in::LockIn {
        lock_in::LockIn {
            threshold: self.threshold,
            scale_factor: self.scale_factor,
            dither_rate: match self.of_angle {
                true => dither_rate(self.dither_amplitude, self.dither_hz),
                false => self.dither_amplitude,
            },
            dither_frequency: self.dither_hz,
        }
    }

    /// Refuses a dither that leaves the gyro locked, or that is too small for the closed form to mean anything.
    pub(crate) fn check(&self, places: &Places) -> Result<(), Fault> {
        let gyro = self.gyro();
        let [threshold, rate, theta] =
            [gyro.threshold, gyro.dither_rate, gyro.amplitude()].map(|value| significant(value, 3));
        if gyro.threshold >= gyro.dither_rate {
            let message = format!(
                "noise.lock_in.threshold = {} ″/s is not below the dither rate of {rate} arcsec/s",
                significant(gyro.threshold, 6)
            );
            let help =
                format!("the gyro would stay locked; give a dither_amplitude far above {threshold} arcsec/s");
            let names = ["noise.lock_in.threshold", "noise.lock_in", FILE.name, "noise"];
            return places.refuse(&names, message, "locked", help);
        }
        if gyro.amplitude() < MIN_AMPLITUDE {
            let message = format!("noise.lock_in: the dither turns the beat phase by only {theta} rad");
            let help = "the closed form of N needs 1 rad or more, dither rate / (frequency · scale factor); raise \
                        dither_amplitude, or sample the gyro in a study of kind = \"lock-in\"";
            let names = ["noise.lock_in.dither_amplitude", "noise.lock_in", FILE.name, "noise"];
            return places.refuse(&names, message, "too small", help);
        }
        Ok(())
    }
}

/// A note on the angle random walk by lock-in of some gyros, each at its input rate in ″/s, with the limits of the closed
/// form; `None` for no gyro.
pub(crate) fn note(gyros: impl Iterator<Item = (LockIn, f64)>) -> Option<String> {
    let (mut walks, mut spreads, mut failing) = (vec![], vec![], Vec::<Premise>::new());
    for (lock_in, rate) in gyros {
        let gyro = lock_in.gyro();
        walks.push(DEG_PER_SQRT_H * gyro.angle_random_walk());
        spreads.push(100.0 * MIN_SPREAD / gyro.amplitude());
        // The studies do not say how their dither is randomized: the note states what is presumed.
        for premise in gyro.failing_premises(f64::INFINITY, rate) {
            if !failing.contains(&premise) {
                failing.push(premise);
            }
        }
    }
    let least = walks.iter().copied().reduce(f64::min)?;
    let most = walks.iter().copied().fold(least, f64::max);
    let spread = spreads.into_iter().fold(0.0, f64::max);
    let [least, most, spread] = [least, most, spread].map(|value| significant(value, 3));
    let walk = if least == most { most } else { format!("{least} to {most}") };
    let limits: String =
        failing.iter().map(|premise| format!("; it is inaccurate here: {}", premise.failure())).collect();
    Some(format!(
        "noise.lock_in adds an angle random walk of {walk} °/√h in quadrature, by the closed form for a randomized dither, \
         whose amplitude varies by at least {spread} % from half-cycle to half-cycle{limits}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use sagnac_theory::allan::Term;

    /// A gyro that is dithered by 100 °/s.
    const BY_RATE: LockIn = LockIn {
        threshold: 180.0,
        scale_factor: 2.0,
        dither_amplitude: 360_000.0,
        of_angle: false,
        dither_hz: 400.0,
    };

    #[test]
    fn an_amplitude_of_the_angle_is_the_same_dither_as_that_of_its_rate() {
        let by_angle = LockIn {
            dither_amplitude: 360_000.0 / (std::f64::consts::TAU * 400.0),
            of_angle: true,
            ..BY_RATE
        };
        let walks = [BY_RATE, by_angle].map(|lock_in| lock_in.gyro().angle_random_walk());
        assert!((walks[0] - 0.16926).abs() < 1e-5, "{walks:?}");
        assert!((walks[1] / walks[0] - 1.0).abs() < 1e-14, "{walks:?}");
    }

    #[test]
    fn lock_in_adds_to_the_angle_random_walk_in_quadrature() {
        let walk = |noise: &Noise| noise.of(Term::AngleRandomWalk)[0];
        let mut noise = Noise { lock_in: Some(BY_RATE), ..Noise::default() };
        let alone = walk(&noise);
        assert!(
            noise.has(Term::AngleRandomWalk)
                && noise.canonical() == format!("angle_random_walk={alone:.11e}\n")
        );
        noise.set(Term::AngleRandomWalk, 0, 0.2);
        assert!((walk(&noise) - libm::hypot(0.2, alone)).abs() < 1e-12, "{} and {alone}", walk(&noise));
        assert_eq!(noise.given(Term::AngleRandomWalk)[0], 0.2);
        assert_eq!(walk(&noise.without(Term::AngleRandomWalk)), alone);
        noise.lock_in = None;
        assert_eq!(walk(&noise), 0.2);
    }

    #[test]
    fn the_note_has_the_range_of_n_and_the_limits_that_fail() {
        assert_eq!(note(std::iter::empty()), None);
        let half = LockIn { threshold: 90.0, ..BY_RATE };
        let both = note([(BY_RATE, 0.0), (half, 0.0)].into_iter()).unwrap_or_default();
        assert!(
            both.contains("of 0.00141 to 0.00282 °/√h in quadrature") && both.contains("0.667 %"),
            "{both}"
        );
        assert!(!both.contains("inaccurate"), "{both}");
        let fast = note([(BY_RATE, 40_000.0)].into_iter()).unwrap_or_default();
        assert!(fast.contains("inaccurate here: the input rate is above a tenth"), "{fast}");
    }
}
