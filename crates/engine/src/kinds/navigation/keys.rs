//! The keys of `[navigation]`, with their settings.

use crate::key::row::{Holds, keys, measure, words};
use crate::key::sweep::Setting;
use crate::kinds::navigation::point::Inputs;
use sagnac_base::quantity::units::Dimension;

words! {
    /// The task of a navigator.
    pub enum Solution {
        /// Attitude, velocity and position by three gyros along north, east and down, from the start on.
        Inertial = "inertial",
        /// The heading of a strapdown at rest, kept by the vertical gyro.
        Heading = "heading",
        /// The heading at rest that the east gyro finds from the rate of the Earth in the alignment.
        Gyrocompass = "gyrocompass",
    }
}

const DURATIONS: Holds = measure(&[Dimension::Time], 1.0, 1e7, "1 s to 1e7 s");
const SAMPLES: Holds = measure(&[Dimension::Time], 1e-4, 120.0, "0.1 ms to 120 s");
const LATITUDES: Holds = measure(&[Dimension::Bearing], -306_000.0, 306_000.0, "-85 deg to 85 deg");
const COURSES: Holds = measure(&[Dimension::Bearing], -1_296_000.0, 1_296_000.0, "-360 deg to 360 deg");
// 1000 m/s in g·s.
const SPEEDS: Holds = measure(&[Dimension::Speed], 0.0, 101.971_621_298, "0 to 1000 m/s");

keys! {
    /// The keys of the navigator.
    pub(crate) static KEYS;
    /// The navigator: its task, its times, its place on the Earth and its leg.
    pub NAVIGATION = "navigation", "", Fixed, Holds::Table, "[navigation]\nlatitude = \"60 deg\"\nduration = \"1 h\"";
    /// Task of the navigator; "inertial" if absent.
    pub SOLUTION = "navigation.solution", "", Fixed, Holds::Word(Solution::WORDS), r#"solution = "inertial""#;
    /// Time from the start to the end, for "inertial" and "heading": "1 h".
    pub DURATION = "navigation.duration", "time of navigation", Question, DURATIONS, r#"duration = "1 h""#;
    /// Time at rest before the start, for "inertial" and "gyrocompass", in which the east gyro finds the heading from the
    /// rate of the Earth. If absent, "inertial" starts without errors. "heading" may have it for its calibration.
    pub ALIGNMENT = "navigation.alignment", "time of alignment", Fixed, DURATIONS, r#"alignment = "10 min""#;
    /// Whether the mean rates of the other gyros in the alignment are taken as their biases and removed; false if absent.
    pub CALIBRATION = "navigation.calibration", "", Fixed, Holds::Flag, "calibration = true";
    /// Path of the noise model of a Kalman filter, relative to the folder of the study, for "heading": a document of
    /// `sagnac model --json` with one column. The filter finds the bias of the gyro in the alignment and predicts it from the
    /// start on; calibration is that of a filter that knows white noise only.
    pub FILTER = "navigation.filter", "filter", Fixed, Holds::File, r#"filter = "model.json""#;
    /// Latitude at the start, for "inertial" and "gyrocompass": "60 deg".
    pub LATITUDE = "navigation.latitude", "latitude", Question, LATITUDES, r#"latitude = "60 deg""#;
    /// Speed on a straight leg, for "inertial"; at rest if absent: "250 m/s".
    pub SPEED = "navigation.speed", "speed", Question, SPEEDS, r#"speed = "250 m/s""#;
    /// Course of the leg from north over east; north if absent: "90 deg".
    pub COURSE = "navigation.course", "course", Question, COURSES, r#"course = "90 deg""#;
    /// Time from one sample of the gyros to the next. If absent, it is chosen so that a record has more than 2000 samples
    /// and switches of modes fall on samples; the responses are averaged over each sample.
    pub SAMPLE = "navigation.sample", "sampling time", Question, SAMPLES, r#"sample = "1 s""#;
    /// Number of sets of coefficients that are drawn from the distributions of [[sensitivity]], each for an equal part of
    /// the trials, so that the errors contain the uncertainty of the coefficients; if absent, they have the values of the
    /// study.
    pub DRAWS = "navigation.draws", "", Fixed, Holds::Whole(2, 1000), "draws = 16";
}

/// The settings of these keys.
pub(crate) static SETTINGS: [Setting<Inputs>; 6] = [
    Setting::new(&DURATION, |inputs, time| inputs.duration_s = time.value),
    Setting::new(&ALIGNMENT, |inputs, time| inputs.alignment_s = time.value),
    Setting::new(&LATITUDE, |inputs, latitude| inputs.latitude_arcsec = latitude.value),
    Setting::new(&SPEED, |inputs, speed| inputs.speed_m_per_s = speed.shown()),
    Setting::new(&COURSE, |inputs, course| inputs.course_arcsec = course.value),
    Setting::new(&SAMPLE, |inputs, sample| inputs.sample_s = Some(sample.value)),
];
