//! The unit of angle of a point, which depends on its physical inputs only and not on the fillers.

use std::sync::Arc;

use crate::key::row::{Refusal, shown};
use crate::kinds::gap_fill::lower::fixed::{Fixed, SIGMA_UNITS};
use crate::kinds::gap_fill::lower::physical::Physical;
use crate::kinds::gap_fill::lower::response::Functional;
use sagnac_base::quantity::number::significant;
use sagnac_kernel::moments::LIMIT;
use sagnac_kernel::normal::REACH;
use sagnac_theory::gap::{Weights, polynomial_weights};
use sagnac_theory::memo::Memo;

/// Fewest units of 2^−4 LSB of σ, which is then rounded by at most 1 %.
const MIN_SIGMA: f64 = 50.0;

/// Units of 2^−4 LSB of σ from which on its rounding, by 0.1 %, is far below what trials resolve. Where there are fewer, a
/// finer unit is taken as far as ticks and their words allow it, and larger errors are shifted.
const ENOUGH_SIGMA: f64 = 500.0;

/// Bound of the angle over the gap with all that is added to it, LSB, for which every word fits.
const MAX_ANGLE: f64 = (1_u32 << 27) as f64;

/// Fewest LSB of the peak angle of a tick, whose words are then rounded by less than 0.1 %. Motion without noise has
/// more, even where the longest gap leaves the least room.
const MIN_MOTION: f64 = 128.0;

/// Headroom kept for fillers other than the three polynomials on their default ticks.
const RESERVE: f64 = 4.0;

/// log2 of the finest unit of 2^−24 ″ and of the coarsest of 2^24 ″.
const FINEST: i32 = 24;

/// Ticks on either side that the default fillers reach.
pub(crate) const DEFAULT_SIDES: usize = 4;

/// The weights of the three polynomials on their default ticks. They take long to compute, and points share them.
fn polynomials(gap_ticks: u32) -> Arc<[Weights]> {
    static KNOWN: Memo<u32, Arc<[Weights]>> = Memo::new(64);
    let n = gap_ticks as i32;
    let on_ticks = move |order| {
        let ticks = [[-1, 0, n + 1, n + 2], [-3, -2, -1, 0]].into_iter();
        // Four ticks always determine a quadratic.
        ticks.filter_map(move |ticks| polynomial_weights(&ticks, order, gap_ticks))
    };
    KNOWN.get(gap_ticks, || (0..3).flat_map(on_ticks).collect())
}

/// The unit of angle, ″, at which the worst error of the three polynomials on their default ticks leaves a factor
/// [`RESERVE`] to the limit. It is a power of two, or with whole pulses a pulse divided by a power of two.
///
/// # Errors
/// Noise, motion or pulses have too few units.
pub(crate) fn lsb(physical: &Physical) -> Result<f64, Refusal> {
    let sizes = physical.tick_sizes();
    let whole = sizes.iter().map(|(_, size)| size).sum::<f64>()
        + physical.constant_size()
        + REACH * physical.sigma_arcsec
        + physical.readout_lsb;
    let n = physical.gap_ticks as i32;
    let mut worst = f64::from(n + 1) * whole;
    if whole > 0.0 {
        // A provisional unit, in which all words certainly fit.
        let provisional = worst / libm::exp2(26.0);
        let fixed = Fixed::new(physical, provisional, DEFAULT_SIDES);
        for Weights { ticks, numerators: weights, denominator: scale } in
            polynomials(physical.gap_ticks).iter()
        {
            let functional = Functional { ticks, weights, scale: *scale, gap: n };
            let noise = (REACH * physical.sigma_arcsec + physical.readout_lsb) * functional.gain();
            worst = worst.max(fixed.response(&functional).bound * provisional + noise);
        }
    }
    let mut bits = libm::floor(libm::log2(LIMIT as f64 / (RESERVE * worst)));
    let sigma_units = physical.sigma_arcsec * SIGMA_UNITS;
    if sigma_units > 0.0 && sigma_units * libm::exp2(bits) < ENOUGH_SIGMA {
        let wanted = libm::ceil(libm::log2(ENOUGH_SIGMA / sigma_units));
        let most = libm::floor(libm::log2(MAX_ANGLE / (f64::from(n + 1) * whole)));
        bits = wanted.min(most).max(bits);
    }
    let mut lsb = libm::exp2(-bits.clamp(-f64::from(FINEST), f64::from(FINEST)));
    if physical.readout_lsb > 0.0 {
        let steps = libm::floor(libm::log2(physical.readout_lsb / lsb));
        if steps < 0.0 {
            let (readout_lsb, unit_arcsec) = (physical.readout_lsb, lsb);
            let found = format!(
                "a pulse of {}″ is less than a unit of {}″ of the 32-bit arithmetic that this motion leaves",
                shown(readout_lsb),
                significant(unit_arcsec, 3)
            );
            let help = "leave readout_lsb out: pulses as fine as this have no effect";
            return Err(Refusal::new("gyro.readout_lsb", found, help));
        }
        lsb = physical.readout_lsb / libm::exp2(steps.min(f64::from(FINEST)));
    }
    let finest = lsb <= libm::exp2(-f64::from(FINEST));
    let lost = match finest {
        true => "are too few units of 2^-24″, the finest unit of angle".to_owned(),
        false => format!(
            "are lost beside motion and noise of up to {}″ per tick in 32-bit arithmetic",
            shown(whole)
        ),
    };
    let sigma_arcsec = physical.sigma_arcsec;
    if sigma_arcsec > 0.0 && libm::round(sigma_arcsec / lsb * SIGMA_UNITS) < MIN_SIGMA {
        let found = format!("{}″ of noise per tick {lost}", shown(sigma_arcsec));
        return Err(Refusal::new("gyro.tick_noise", found, "make the noise larger, or 0"));
    }
    for (key, tick_arcsec) in sizes {
        if tick_arcsec > 0.0 && tick_arcsec / lsb < MIN_MOTION {
            let help = match finest {
                true => "make the motion larger, or 0",
                false => "make the motion larger, or 0; or the noise smaller, or the gap shorter",
            };
            let found = format!("{}″ of motion per tick {lost}", shown(tick_arcsec));
            return Err(Refusal::new(key, found, help));
        }
    }
    Ok(lsb)
}
