//! Minimum-variance fillers on motion for which they were not designed.
//!
//! A filler that is designed for the motion of its study looks better there than in a gyro, whose motion is never known
//! exactly. Of a recorded motion, fillers are judged on the half from which they were not designed. Any other motion is
//! played slower and faster by [`SHIFT`]: all its frequencies change, and the rms of its rate stays. Where a study has a
//! specification, all its fillers are judged on that instead, with each frequency off by its own tolerance.

use crate::filler::read::Error;
use crate::filler::{Fill, Filler, Method, Part, Target};
use crate::kinds::gap_fill::inputs::Inputs;
use crate::kinds::gap_fill::lower::weights::{Rows, Statistics};
use crate::kinds::gap_fill::played::Played;
use crate::kinds::gap_fill::point::Point;
use crate::motion::keys::{DESIGN, Design, Phase};
use crate::motion::{Gaussian, Motion, Tone};
use crate::tally::LEVEL;
use sagnac_base::quantity::number::significant;
use sagnac_theory::level::of_sine;
use sagnac_theory::minimum_variance::Band;
use sagnac_theory::rows::{TickRows, sides};

/// Relative change of all frequencies of a motion, down and up.
pub const SHIFT: f64 = 0.05;

/// The size of a residual with noise, ″.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Its rms.
    pub rms: f64,
    /// The level below which 99.73 % of its magnitudes stay.
    pub level: f64,
}

impl Size {
    /// The larger of each number.
    pub fn max(self, other: Size) -> Size {
        Size { rms: self.rms.max(other.rms), level: self.level.max(other.level) }
    }
}

/// The residual of a filler on the motion as given and on what it may be instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// That on the motion as given.
    pub own: Size,
    /// The largest with frequencies off by [`SHIFT`], or within the tolerances of a specification.
    pub shifted: Size,
}

impl Judged {
    /// Judges a filler that is designed for the motion of `inputs`, or any filler where there is a specification; `None` for
    /// other fillers, for recorded motion, for a motion at rest or of a fixed phase, and where the weights are not determined.
    pub fn of(inputs: &Inputs, filler: &Filler, fill: &Fill) -> Option<Judged> {
        if inputs.specification.is_none() && !is_for(&filler.method, &inputs.motion) {
            return None;
        }
        let ticks = &fill.fit_ticks;
        let rows = Rows::of(filler, Error::Residual, ticks, &Statistics::of(inputs)).ok()??;
        Judged::of_weights(inputs, ticks, &rows.values().pop()?)
    }

    /// Judges some weights; `None` without a specification for recorded motion and a motion at rest or of a fixed phase.
    pub fn of_weights(inputs: &Inputs, ticks: &[i32], weights: &[f64]) -> Option<Judged> {
        let motion = &inputs.motion;
        let is_drawn = motion.tones.iter().all(|tone| tone.phase == Phase::Uniform);
        let swings = !motion.tones.is_empty() || motion.gaussian.is_some();
        let has_level = inputs.specification.is_some() || motion.profile.is_none() && is_drawn && swings;
        has_level.then(|| Judge::new(inputs, sides(ticks, inputs.gap_ticks)).judge(ticks, weights))
    }

    /// The largest residual on the motion as given and with frequencies off.
    pub fn worst(self) -> Size {
        self.own.max(self.shifted)
    }
}

/// The relative change of all frequencies where fillers are judged; `None` where a specification has tolerances.
pub fn shift(inputs: &Inputs) -> Option<f64> {
    inputs.specification.is_none().then_some(SHIFT)
}

/// How far frequencies are off, after `with`.
pub fn deviation(shift: Option<f64>) -> String {
    match shift {
        Some(shift) => format!("all frequencies up to {} % lower or higher", 100.0 * shift),
        None => "all frequencies within their tolerances".to_owned(),
    }
}

/// The motions on which weights are judged: as given first, and as they may be instead.
pub struct Judge<'a> {
    inputs: &'a Inputs,
    motions: Motions<'a>,
}

enum Motions<'a> {
    /// The motion of the point, as it is, slower and faster.
    Played(Box<[Played<'a>; 3]>),
    /// The parts of the specification, each as it may be, and whether it is a line.
    Specified(Vec<(Vec<TickRows>, bool)>),
}

impl<'a> Judge<'a> {
    /// The motions of `inputs`, with `sides` ticks on either side of the gap.
    pub fn new(inputs: &'a Inputs, sides: usize) -> Judge<'a> {
        let rows = |tone| Motion::of_tone(tone).tick_rows(inputs.tick_s, inputs.gap_ticks, sides);
        let part = |part: &Part| (part.possible().into_iter().map(rows).collect(), part.is_line());
        let motions = match &inputs.specification {
            Some(specification) => Motions::Specified(specification.parts.iter().map(part).collect()),
            None => {
                let played = |speed| Played::new(inputs, speed, sides);
                Motions::Played(Box::new([1.0, 1.0 - SHIFT, 1.0 + SHIFT].map(played)))
            }
        };
        Judge { inputs, motions }
    }

    /// The residual that some weights leave.
    pub fn judge(&self, ticks: &[i32], weights: &[f64]) -> Judged {
        match &self.motions {
            Motions::Played(motions) => {
                let [own, slower, faster] = motions.each_ref().map(|motion| motion.errors(ticks, weights));
                Judged { own, shifted: slower.max(faster) }
            }
            Motions::Specified(parts) => {
                let noise = of_noise(self.inputs, ticks, weights);
                let variances = |(rows, is_line): &(Vec<TickRows>, bool)| {
                    let variance =
                        |rows: &TickRows| rows.error_variance(ticks, weights, self.inputs.gap_ticks);
                    (rows.iter().map(variance).collect::<Vec<_>>(), *is_line)
                };
                let parts: Vec<(Vec<f64>, bool)> = parts.iter().map(variances).collect();
                let size = |of_part: fn(&[f64]) -> f64| {
                    sum(noise, parts.iter().map(|(variances, is_line)| (of_part(variances), *is_line)))
                };
                let own = size(|variances| variances[0]);
                Judged { own, shifted: size(|variances| variances.iter().copied().fold(0.0, f64::max)) }
            }
        }
    }
}

/// The size of noise and of independent parts, each with its variance and whether it is a sine. The largest sine has the
/// distribution of a sine, and all else counts as normally distributed.
fn sum(noise_rms: f64, parts: impl Iterator<Item = (f64, bool)> + Clone) -> Size {
    let all = noise_rms * noise_rms + parts.clone().map(|(variance, _)| variance).sum::<f64>();
    let sine = parts.filter(|(_, is_line)| *is_line).map(|(variance, _)| variance).fold(0.0, f64::max);
    // A sine of uniform phase has half its squared amplitude as variance.
    let level = of_sine(&[(libm::sqrt(2.0 * sine), 1.0)], libm::sqrt((all - sine).max(0.0)), LEVEL);
    Size { rms: libm::sqrt(all), level }
}

/// The ticks of the motion played faster by a factor, ″, with `sides` ticks on either side of the gap.
pub(crate) fn played(inputs: &Inputs, speed: f64, sides: usize) -> TickRows {
    // A tick of the faster motion is a longer one of the slower motion, whose angles are as much larger.
    inputs.motion.tick_rows(inputs.tick_s * speed, inputs.gap_ticks, sides).scaled(1.0 / speed)
}

/// The rms residual that some weights leave of the noise and pulses of `inputs` alone, ″.
pub fn of_noise(inputs: &Inputs, ticks: &[i32], weights: &[f64]) -> f64 {
    rms(inputs, ticks, weights, &TickRows::default())
}

/// The rms residual that some weights leave of a motion, with the noise and pulses of `inputs`, ″.
pub(crate) fn rms(inputs: &Inputs, ticks: &[i32], weights: &[f64], motion: &TickRows) -> f64 {
    let noise = inputs.noise_covariance();
    let pairs = || ticks.iter().zip(weights);
    let shared = |(&a, u): (&i32, &f64)| {
        let of = |(&b, v): (&i32, &f64)| u * v * noise.get(a.abs_diff(b) as usize).copied().unwrap_or(0.0);
        pairs().map(of).sum::<f64>()
    };
    let motion = motion.error_variance(ticks, weights, inputs.gap_ticks);
    // Differences of equal numbers may come out below 0.
    libm::sqrt((motion + pairs().map(shared).sum::<f64>()).max(0.0))
}

/// Whether a filler is designed for this very motion.
fn is_for(method: &Method, motion: &Motion) -> bool {
    let band = match method {
        Method::MinimumVariance(Target::Own) => return true,
        Method::MinimumVariance(Target::Band(band)) => band,
        Method::MinimumVariance(Target::Specification(_)) | Method::Closed(_) | Method::Weights { .. } => {
            return false;
        }
    };
    let of_gaussian = match &motion.gaussian {
        None => vec![],
        Some(Gaussian::Band { band, .. }) => vec![*band],
        Some(Gaussian::Psd(_) | Gaussian::Vibration { .. }) => return false,
    };
    let bands: Vec<Band> = motion.tones.iter().map(Tone::band).chain(of_gaussian).collect();
    bands.iter().all(|own| own == band)
}

/// A note on the fillers that are judged on what they were designed from, or on the rest of a record; of a specification
/// the table says it.
pub(crate) fn note(points: &[Point], fillers: &[Filler]) -> Option<String> {
    let point = Point::hardest(points).filter(|point| point.inputs.specification.is_none())?;
    let designed = fillers.iter().filter(|filler| filler.method == Method::MinimumVariance(Target::Own));
    let names: Vec<&str> = designed.map(|filler| filler.name.as_str()).collect();
    if let Some(profile) = &point.inputs.motion.profile {
        let (names, file) = (names.join(", "), &profile.file);
        return match profile.design {
            _ if names.is_empty() => None,
            Design::FirstHalf => Some(format!(
                "designed from the first half of {file}: {names}; all fillers are judged on its second half, unless {} = \"{}\"",
                DESIGN.name,
                Design::Whole.name()
            )),
            Design::Whole => Some(format!(
                "designed from the whole of {file}, on which it is judged too: {names}; another record will show a larger error"
            )),
        };
    }
    let number = |rms: f64| significant(rms, 3);
    let judged: Vec<String> = fillers
        .iter()
        .zip(point.fills.iter())
        .filter_map(|(filler, fill)| Some((filler, Judged::of(&point.inputs, filler, fill)?)))
        .map(|(filler, Judged { own, shifted })| {
            format!("{} {}″ and {}″", filler.name, number(own.rms), number(shifted.rms))
        })
        .collect();
    (!judged.is_empty()).then(|| {
        format!(
            "minimum-variance fillers designed for the motion on which they are judged, with the rms residual of \
             vibration and noise there, and if all frequencies are {} % lower or higher: {}{}",
            100.0 * SHIFT,
            judged.join(", "),
            point.place()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::gap_fill::GapFill;
    use crate::study::Study;
    use sagnac_theory::rows::dot;

    fn study(frequency: &str, more: &str) -> Study {
        let text = format!(
            "title = \"t\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"5 ms\"\ntick_noise = {{ three_sigma = \"1.6 arcsec\" }}\n\
             [motion]\namplitude = \"12000 arcsec/s\"\nfrequency = {frequency}\n[switching]\ngap_ticks = 3\nfillers = [\"const\", \
             {{ kind = \"minimum-variance\", name = \"mv\", fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"]{more} }}]\n"
        );
        Study::parse("a.toml", &text).unwrap()
    }

    #[test]
    fn a_filler_tuned_to_20_hz_is_judged_at_19_and_21() {
        let study = study("\"20 Hz\"", "");
        let asked = study.asked::<GapFill>().unwrap();
        let point = &asked.points[0];
        let judged = |filler: usize| Judged::of(&point.inputs, &asked.fillers[filler], &point.fills[filler]);
        assert_eq!(judged(0), None);
        let Judged { own, shifted } = judged(1).unwrap();
        let (own_rms, shifted_rms) = (own.rms, shifted.rms);
        // 1.13 ″ at 20 Hz and 21.6 ″ at 19 Hz, as in the tests of the weights; 21 Hz is worse or as bad.
        assert!((own_rms - 1.133).abs() < 2e-3, "{own_rms}");
        assert!(shifted_rms > 21.5 && shifted_rms < 30.0, "{shifted_rms}");
        assert!(
            study.notes.iter().any(|note| note.contains("5 % lower or higher: mv 1.13″ and 2")),
            "{:?}",
            study.notes
        );
    }

    #[test]
    fn a_filler_for_a_wider_band_than_the_motion_is_not_designed_for_it() {
        let of = |frequency: &str, more: &str| {
            let study = study(frequency, more);
            study.notes.iter().any(|note| note.contains("designed for the motion on which they are judged"))
        };
        let band = ", band = [\"18 Hz\", \"22 Hz\"]";
        assert!(!of("\"20 Hz\"", band) && of("[\"18 Hz\", \"22 Hz\"]", band));
    }

    /// The specifications of `benches/filler_numpy.py`, which integrates over their spectra by brute force.
    #[test]
    fn fillers_for_a_specification_leave_what_an_integral_over_its_spectrum_has() {
        let problem = "bands = [{ rms = \"1000 arcsec/s\", band = [\"30 Hz\", \"80 Hz\"], tolerance = \"5 %\" }]\n\
                       lines = [{ amplitude = \"90 arcsec\", frequency = \"345 Hz\", tolerance = \"0.1 %\" }]";
        let several = "bands = [{ rms = \"3000 arcsec/s\", band = [\"5 Hz\", \"20 Hz\"], tolerance = \"10 %\" },\n\
                       { rms = \"500 arcsec/s\", band = [\"60 Hz\", \"90 Hz\"], tolerance = \"2 %\" }]\n\
                       lines = [{ amplitude = \"200000 arcsec/s\", frequency = \"345 Hz\", tolerance = \"0.1 %\" },\n\
                       { amplitude = \"5000 arcsec/s\", frequency = \"140 Hz\", tolerance = \"1 %\" }]";
        let exact = "bands = [{ rms = \"1000 arcsec/s\", band = [\"30 Hz\", \"40 Hz\"] }]\n\
                     lines = [{ amplitude = \"4000 arcsec/s\", frequency = \"120 Hz\" }]";
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/gap_specification.csv");
        let mut rows = 0;
        for record in csv::Reader::from_path(path).unwrap().records().map(Result::unwrap) {
            let specification = match &record[0] {
                "problem" => problem,
                "several" => several,
                _ => exact,
            };
            let whole = |field: usize| record[field].parse::<i32>().unwrap();
            let text = format!(
                "title = \"t\"\nkind = \"gap-fill\"\n[gyro]\ntick = \"2 ms\"\ntick_noise = {{ std = \"0.2 arcsec\" }}\n\
                 [motion]\nrate = \"0 deg/s\"\n[specification]\n{specification}\n[switching]\ngap_ticks = {}\nfillers = [\n\
                 {{ kind = \"minimum-variance\", fit_ticks = [\"{}..0\", \"n+1..n+{}\"] }}]\n",
                whole(1),
                1 - whole(2),
                whole(3)
            );
            let study = Study::parse("a.toml", &text).unwrap();
            let asked = study.asked::<GapFill>().unwrap();
            let point = &asked.points[0];
            let judged = Judged::of(&point.inputs, &asked.fillers[0], &point.fills[0]).unwrap();
            let found = [judged.own.rms, judged.own.level, judged.worst().rms, judged.worst().level];
            for (field, found) in (4..).zip(found) {
                let expected: f64 = record[field].parse().unwrap();
                // Weights are rounded to 2^−24, which changes what is left of the dither by up to 4e-6.
                assert!((found / expected - 1.0).abs() < 1e-5, "{record:?}: {found}, not {expected}");
            }
            rows += 1;
        }
        assert_eq!(rows, 6);
    }

    #[test]
    fn a_motion_played_faster_is_that_of_a_higher_frequency() {
        let at = |frequency: &str| study(frequency, "").asked::<GapFill>().unwrap().points[0].inputs.clone();
        let (slow, fast) = (at("\"20 Hz\""), at("\"21 Hz\""));
        let [played, own] = [played(&slow, 1.05, 8), fast.motion.tick_rows(0.005, fast.gap_ticks, 8)];
        for tick in -7..=8 {
            let covariance = |rows: &TickRows| dot(rows.tick(1), rows.tick(tick));
            let (found, expected) = (covariance(&played), covariance(&own));
            assert!(
                (found - expected).abs() < 1e-9 * dot(own.tick(1), own.tick(1)),
                "{tick}: {found}, not {expected}"
            );
        }
    }
}
