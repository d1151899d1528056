//! Notes on motion that is easily mistaken for something else.

use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::point::Point;
use crate::motion::{Gaussian, Tone};
use sagnac_base::quantity::number::significant;

/// Largest plausible rate of a gyro: 1000 °/s, in ″/s.
const PLAUSIBLE_RATE: f64 = 3.6e6;

/// Notes on the motion of the points, each once and as a sentence; `written` gives the number of written tones.
pub(crate) fn of_motion(written: &Inputs, points: &[Point]) -> Vec<String> {
    let written = written.motion.tones.len();
    aliased(written, points).into_iter().chain(fast(written, points)).collect()
}

/// Notes that a tone or Gaussian motion appears at another frequency in the ticks. Vibration through a suspension has its own
/// key for that.
fn aliased(written: usize, points: &[Point]) -> Option<String> {
    let highest = |point: &Point| {
        let tones = point.inputs.motion.tones.iter().take(written);
        let gaussian = point.inputs.motion.gaussian.as_ref().and_then(Gaussian::highest_hz);
        tones.map(|tone| tone.band().high_hz).chain(gaussian).fold(0.0, f64::max)
    };
    let periods = |point: &Point| highest(point) * point.inputs.tick_s;
    let most = points.iter().max_by(|a, b| periods(a).total_cmp(&periods(b)))?;
    (periods(most) > 0.5).then(|| {
        format!(
            "vibration of {} Hz is above half the tick rate, {} Hz: it appears in the ticks at a lower frequency, as it does in those of a \
             gyro",
            significant(highest(most), 4),
            significant(0.5 / most.inputs.tick_s, 4)
        )
    })
}

/// Notes that an amplitude of the angle gives an implausible rate.
fn fast(written: usize, points: &[Point]) -> Option<String> {
    let rate = |tone: &Tone| tone.amplitude.value.scale() * tone.rate_factor(tone.band().high_hz);
    let tones = points.iter().flat_map(|point| point.inputs.motion.tones.iter().take(written));
    let most = tones.filter(|tone| tone.amplitude.of_angle).max_by(|a, b| rate(a).total_cmp(&rate(b)))?;
    (rate(most) > PLAUSIBLE_RATE).then(|| {
        format!(
            "an angle of {}° at {} Hz is a rate of {} °/s at its peak; an amplitude of the rate is written as in \"5 deg/s\"",
            significant(most.amplitude.value.scale() / 3600.0, 4),
            significant(most.band().high_hz, 4),
            significant(rate(most) / 3600.0, 3)
        )
    })
}

#[cfg(test)]
mod tests {
    use crate::study::Study;

    fn notes(amplitude: &str, motion: &str, sweep: &str) -> Vec<String> {
        let text = format!(
            "title = \"t\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"5 ms\"\ntick_noise = {{ std = \"1 arcsec\" }}\n[motion]\n\
             amplitude = \"{amplitude}\"\n{motion}\n[switching]\ngap_ticks = 3\nfillers = [\"const\"]\n{sweep}"
        );
        Study::parse("a.toml", &text).unwrap().notes
    }

    #[test]
    fn vibration_above_half_the_tick_rate_is_said_to_be_aliased() {
        let aliased = |motion: &str, sweep: &str| notes("12000 arcsec/s", motion, sweep);
        assert!(aliased("frequency = \"100 Hz\"", "").is_empty());
        let said = aliased("frequency = \"150 Hz\"", "");
        assert!(
            said.len() == 1 && said[0].starts_with("vibration of 150 Hz is above half the tick rate, 100 Hz")
        );
        let sweep = "[[sweep]]\nkey = \"gyro.tick\"\nlist = [\"5 ms\", \"20 ms\"]\n";
        let swept = aliased("frequency = \"30 Hz\"", sweep);
        assert!(
            swept.len() == 1 && swept[0].contains("30 Hz is above half the tick rate, 25 Hz"),
            "{swept:?}"
        );
    }

    #[test]
    fn an_angle_that_would_be_a_wild_rate_is_told() {
        let fast = |amplitude: &str| notes(amplitude, "frequency = \"35 Hz\"", "");
        assert!(fast("82 arcsec").is_empty() && fast("2000 deg/s").is_empty());
        let said = fast("5 deg");
        assert!(
            said.len() == 1 && said[0].starts_with("an angle of 5° at 35 Hz is a rate of 1100 °/s"),
            "{said:?}"
        );
    }
}
