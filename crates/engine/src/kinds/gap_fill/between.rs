//! How much the interpolation of a recorded motion between its samples matters for the errors at a switch.

use crate::filler::read::Error;
use crate::filler::{Fill, Filler};
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::judged::of_noise;
use crate::kinds::gap_fill::lower::physical::MAX_PROFILE_TICKS;
use crate::kinds::gap_fill::lower::weights::{Rows, Statistics};
use crate::kinds::gap_fill::point::Point;
use crate::motion::keys::{INTERPOLATION, Interpolation};
use crate::motion::{Motion, Profile};
use sagnac_base::quantity::number::significant;
use sagnac_kernel::gap_fill::shape::MARGIN;

/// Difference of two rms errors that is reported.
const REPORTED: f64 = 0.01;

/// Reports the filler whose rms residual, with noise and whole pulses, differs most if the record is interpolated in the
/// other way; `None` where no difference exceeds 1 %. Evaluated at the hardest point, over all places on which fillers are
/// judged, with fillers that are designed from the record as it is interpolated: what the table of such a study has.
pub(crate) fn note<'a>(points: &[Point], fillers: &'a [Filler]) -> Option<String> {
    let point = Point::hardest(points)?;
    let inputs = &point.inputs;
    let profile = inputs.motion.profile.as_ref()?;
    let n = inputs.gap_ticks as usize;
    let (count, before) = profile.replayed(inputs.tick_s);
    // Lowering refuses other records.
    if count < 2 * MARGIN + n || count + before > MAX_PROFILE_TICKS {
        return None;
    }
    let other = match profile.interpolation {
        Interpolation::BandLimited => Interpolation::Linear,
        Interpolation::Linear => Interpolation::BandLimited,
    };
    let both = [profile.interpolation, other].map(|interpolation| {
        let profile = Profile { interpolation, ..profile.clone() };
        let angles = profile.tick_angles(inputs.tick_s);
        let motion = Motion { profile: Some(profile), ..inputs.motion.clone() };
        (angles, Inputs { motion, ..inputs.clone() })
    });
    let statistics = both.each_ref().map(|(_, inputs)| Statistics::of(inputs));
    let of_filler = |(filler, fill): (&'a Filler, &Fill)| {
        let ticks = &fill.fit_ticks;
        let rms = |which: usize| {
            let rows = Rows::of(filler, Error::Residual, ticks, &statistics[which]).ok()??;
            let weights = rows.values().pop()?;
            Some(residual_rms(
                &both[which].0[before..],
                ticks,
                &weights,
                n,
                of_noise(inputs, ticks, &weights),
            ))
        };
        let (own, other) = (rms(0)?, rms(1)?);
        (own > 0.0).then(|| (filler.name.as_str(), own, other / own - 1.0))
    };
    let all = fillers.iter().zip(point.fills.iter()).filter_map(of_filler);
    let (filler, own, change) = all.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
    (change.abs() > REPORTED).then(|| {
        format!(
            "between its samples, the rate of {} is taken as {}: with {} = \"{}\" the residual of {} would be {} instead of {}″ rms, {} % \
             {}{}",
            profile.file,
            profile.interpolation.name(),
            INTERPOLATION.name,
            other.name(),
            filler,
            significant(own * (1.0 + change), 3),
            significant(own, 3),
            significant(100.0 * change.abs(), 2),
            if change > 0.0 { "more" } else { "less" },
            point.place()
        )
    })
}

/// The rms over all places of a gap of n in a record of the error that some weights leave, which noise alone makes as large
/// as `of_noise`.
fn residual_rms(angles: &[f64], ticks: &[i32], weights: &[f64], n: usize, of_noise: f64) -> f64 {
    let places = MARGIN..angles.len() + 1 - MARGIN - n;
    let count = places.len() as f64;
    let square = |start: usize| {
        let lost: f64 = angles[start..start + n].iter().sum();
        let read = |&tick: &i32| angles[(start - 1).wrapping_add_signed(tick as isize)];
        let filled: f64 = ticks.iter().zip(weights).map(|(tick, w)| w * read(tick)).sum();
        (filled - lost) * (filled - lost)
    };
    let motion = places.map(square).sum::<f64>() / count;
    libm::hypot(libm::sqrt(motion), of_noise)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;
    use crate::study::Study;
    use sagnac_records::record::Record;
    use sagnac_theory::gap::{polynomial_weights, sine_response, tick_amplitude};

    #[test]
    fn a_recorded_sine_leaves_the_closed_form_up_to_four_fifths_of_half_its_sampling_rate() {
        let (step_s, n, ticks) = (0.001, 3, [-1, 0, 4, 5]);
        let quadratic = polynomial_weights(&ticks, 2, n).unwrap();
        let weights: Vec<f64> = quadratic.values().collect();
        for part in [0.05, 0.21, 0.4, 0.6, 0.8] {
            let nu = part * 0.5 / step_s;
            let rate = |i: i32| 12000.0 * libm::sin(2.0 * PI * nu * f64::from(i) * step_s);
            let record = Record { step_s, rates: (0..60_000).map(rate).collect() };
            for tick_s in [0.000503, 0.001, 0.00137, 0.00253] {
                let (a, b) = sine_response(&quadratic, n, nu * tick_s);
                let largest = 12000.0 * tick_amplitude(tick_s, nu * tick_s) * libm::hypot(a, b);
                let exact = largest.abs() / core::f64::consts::SQRT_2;
                let rms = |angles: Vec<f64>| residual_rms(&angles, &ticks, &weights, n as usize, 0.0);
                let found = rms(record.band_limited_tick_angles(tick_s));
                // What the window leaves of a tick, on all ticks alike, and a part of a turn among all places.
                let tolerance = 2e-5 * 12000.0 * tick_s * (3.0 + quadratic.largest_gain()) + 1e-3 * exact;
                assert!((found - exact).abs() < tolerance, "{part}, {tick_s} s: {found}, not {exact}");
                // Straight lines lose sinc² of the sine, and gain its images.
                let lines = rms(record.tick_angles(tick_s));
                assert!(part < 0.3 || (lines / exact - 1.0).abs() > 0.02, "{part}, {tick_s} s: {lines}");
            }
        }
    }

    /// The notes of a study of a record of a sine at a part of half the sampling rate, with ticks of a sample.
    fn notes(part: f64, profile: &str, fillers: &str) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        let rate = |i: u32| format!("{i}, {}\n", 3.0 * libm::sin(PI * part * f64::from(i)));
        let rows: String = (0..2000).map(rate).collect();
        std::fs::write(folder.path().join("base.csv"), format!("time [ms], rate [deg/s]\n{rows}")).unwrap();
        let text = format!(
            "title = \"t\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"1 ms\"\ntick_noise = {{ std = \"0.01 arcsec\" }}\n\
             [motion]\nprofile = {{ file = \"base.csv\"{profile} }}\n[switching]\ngap_ticks = 4\nfillers = [{fillers}]\n"
        );
        Study::parse(&folder.path().join("study.toml").display().to_string(), &text).unwrap().notes
    }

    #[test]
    fn a_difference_above_one_percent_is_said_with_both_numbers() {
        // sinc² of a tenth of the sampling rate is 0.968.
        let said = notes(0.2, "", "\"const\"");
        assert!(said.len() == 1 && said[0].contains("base.csv is taken as band-limited"), "{said:?}");
        assert!(
            said[0].contains("motion.profile.interpolation = \"linear\"") && said[0].contains(" % less"),
            "{said:?}"
        );
        let linear = notes(0.2, ", interpolation = \"linear\"", "\"const\"");
        assert!(linear.len() == 1 && linear[0].contains(" % more"), "{linear:?}");
        assert!(notes(0.05, "", "\"const\"").is_empty());
    }

    #[test]
    fn the_part_from_which_a_filler_is_designed_is_said() {
        let mv = "\"const\", { kind = \"minimum-variance\", name = \"mv\" }";
        let halves = notes(0.05, "", mv);
        assert!(
            halves[0].starts_with("designed from the first half of base.csv: mv; all fillers are judged"),
            "{halves:?}"
        );
        let whole = notes(0.05, ", design = \"whole\"", mv);
        assert!(
            whole[0].starts_with("designed from the whole of base.csv, on which it is judged too: mv"),
            "{whole:?}"
        );
        let banded = "{ kind = \"minimum-variance\", band = [\"20 Hz\", \"30 Hz\"] }";
        assert!(notes(0.05, "", banded).is_empty());
    }
}
