//! Checks of `[noise.switching]`.

use crate::key::places::Places;
use crate::key::sweep::Sweep;
use crate::noise::Noise;
use crate::noise::keys::{FILE, INITIAL_MAGNETIC, MAGNETIC, RESIDUAL, RESIDUAL_NOISE, SWITCHING_WARM_UP};
use sagnac_base::source::diagnose::Fault;

/// The keys of what switches leave in a record.
static LEFT_BY_SWITCHES: [&str; 4] =
    [MAGNETIC.name, INITIAL_MAGNETIC.name, RESIDUAL.name, RESIDUAL_NOISE.name];

/// Refuses switches without effect in any of the `noises` of a study, and a warm-up without a drift.
///
/// # Errors
/// The first such noise.
pub(crate) fn check(noises: &[Noise], places: &Places, sweeps: &[Sweep]) -> Result<(), Fault> {
    let is_swept = |names: &[&str]| sweeps.iter().any(|sweep| names.contains(&sweep.key.name));
    let refuse =
        |names: &[&str], message, label, help| Err(Fault::new(places.written(names), message, label, help));
    for switching in noises.iter().filter_map(|noise| noise.switching) {
        if switching.is_nothing() && !is_swept(&LEFT_BY_SWITCHES) {
            let message = "[noise.switching] has switches without effect";
            let help = "give magnetic = \"14 arcsec/s\", initial_magnetic, residual = \"10 arcsec\" or \
                        residual_noise, not 0; or leave the table out";
            let names = ["noise.switching", FILE.name, "noise"];
            return refuse(&names, message, "no drift and no residual", help);
        }
        let warms_up = switching.warm_up_s.is_some() || is_swept(&[SWITCHING_WARM_UP.name]);
        if warms_up && switching.magnetic == 0.0 && !is_swept(&[MAGNETIC.name]) {
            let message = "noise.switching.warm_up_time is given without magnetic";
            let help = "give magnetic = \"14 arcsec/s\", or leave warm_up_time out: initial_magnetic is there at once";
            let names = [SWITCHING_WARM_UP.name, FILE.name, "noise"];
            return refuse(&names, message, "nothing warms up", help);
        }
    }
    Ok(())
}
