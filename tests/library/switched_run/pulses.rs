//! Residuals of switches with whole pulses, against the pulses that the gap-fill kernel counts.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use super::texts::{Numbers, numbers};
use crate::studies::parsed;

/// A record in a folder of its own: 20 s at 1 kHz of tones up to 20 Hz.
fn record() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "time [s],rate [arcsec/s]\n".to_owned();
    for k in 0..20_000 {
        let t = f64::from(k) / 1000.0;
        let tones = [(20.0, 3.1, 0.3), (15.0, 11.7, 1.9), (12.0, 19.3, 4.0)];
        let rate: f64 = tones.iter().map(|(a, nu, phase)| a * (TAU * nu * t + phase).sin()).sum();
        writeln!(text, "{t:.3},{rate:.6}").unwrap();
    }
    std::fs::write(folder.path().join("base.csv"), text).unwrap();
    folder
}

/// A gyro with pulses and its motion.
struct Case {
    noise_arcsec: f64,
    pulse_arcsec: f64,
    gap_ticks: u32,
    motion: &'static str,
}

const FILLERS: &str =
    "\"const\", \"quadratic\", { kind = \"minimum-variance\", fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"] }";

impl Case {
    /// The rows of a study of this kind, one for each filler.
    fn rows(&self, folder: &Path, kind: &str, trials: u32, switching: &str) -> Vec<Numbers> {
        let Case { noise_arcsec, pulse_arcsec, gap_ticks, motion } = self;
        let text = format!(
            "title = \"pulses\"\nkind = \"{kind}\"\ntrials = {trials}\nseed = 5\n[gyro]\ntick = \"5 ms\"\n\
             tick_noise = {{ std = \"{noise_arcsec} arcsec\" }}\nreadout_lsb = \"{pulse_arcsec} arcsec\"\n[motion]\n{motion}\n\
             [switching]\ngap_ticks = {gap_ticks}\nfillers = [{FILLERS}]\n{switching}"
        );
        numbers(&parsed(&folder.join("study.toml").display().to_string(), &text))
    }

    /// The residuals of a switch as the gap-fill kernel samples them.
    fn counted(&self, folder: &Path) -> Vec<Numbers> {
        self.rows(folder, "gap-fill", 400_000, "errors = [\"residual\"]\n")
    }

    /// The angles at the end of runs of 99 switches.
    fn ends(&self, folder: &Path, trials: u32) -> Vec<Numbers> {
        let run = "interval = \"10 s\"\n[run]\nduration = \"1000 s\"\nend = \"exact\"\n";
        let rows = self.rows(folder, "switched-run", trials, run);
        rows.into_iter().filter(|row| row.get("time") == Some(&1000.0)).collect()
    }
}

#[test]
fn the_residual_of_a_switch_with_whole_pulses_is_that_of_the_gap_fill_kernel() {
    let folder = record();
    let cases = [
        (0.05, 3.2, 3, "profile = { file = \"base.csv\" }"),
        (0.4, 3.2, 5, "profile = { file = \"base.csv\" }"),
        (
            0.01,
            0.3,
            1,
            "profile = { file = \"base.csv\", position = \"every\" }\n\
             rate = \"7 arcsec/s\"",
        ),
        (
            0.02,
            3.2,
            3,
            "amplitude = { uniform = [\"30 arcsec/s\", \"50 arcsec/s\"] }\n\
             frequency = \"20 Hz\"\n\
             phase = \"zero-crossing\"\n\
             rate = \"640 arcsec/s\"",
        ),
        (
            0.02,
            1.0,
            2,
            "amplitude = { uniform = [\"0 arcsec/s\", \"90 arcsec/s\"] }\n\
             frequency = \"20 Hz\"",
        ),
        (
            0.1,
            0.5,
            4,
            "amplitude = \"300 arcsec/s\"\n\
             frequency = [\"18 Hz\", \"22 Hz\"]",
        ),
        (
            0.03,
            1.0,
            3,
            "amplitude = \"100 arcsec/s\"\n\
             frequency = [\"10 Hz\", \"30 Hz\"]\n\
             phase = \"extremum\"\n\
             rate = \"33 arcsec/s\"",
        ),
        (
            0.03,
            1.0,
            1,
            "amplitude = { uniform = [\"50 arcsec/s\", \"100 arcsec/s\"] }\n\
             frequency = [\"10 Hz\", \"30 Hz\"]\n\
             phase = \"zero-crossing\"",
        ),
        (
            0.02,
            1.0,
            3,
            "[[motion.tones]]\n\
             amplitude = { uniform = [\"5 arcsec/s\", \"30 arcsec/s\"] }\n\
             frequency = \"11 Hz\"\n\
             phase = \"extremum\"\n\
             [[motion.tones]]\n\
             amplitude = \"20 arcsec/s\"\n\
             frequency = \"31 Hz\"",
        ),
        (
            0.02,
            2.0,
            2,
            "[[motion.tones]]\n\
             amplitude = { rayleigh = \"20 arcsec/s\" }\n\
             frequency = [\"9 Hz\", \"12 Hz\"]\n\
             [[motion.tones]]\n\
             amplitude = { uniform = [\"5 arcsec/s\", \"60 arcsec/s\"] }\n\
             frequency = \"31 Hz\"\n\
             [[motion.tones]]\n\
             amplitude = \"20 arcsec/s\"\n\
             frequency = \"1e-9 Hz\"\n\
             phase = \"extremum\"",
        ),
        (
            0.05,
            1.0,
            3,
            "amplitude = { rayleigh = \"60 arcsec/s\" }\n\
             frequency = \"20 Hz\"",
        ),
        (
            0.05,
            1.0,
            4,
            "gaussian = { rms = \"30 arcsec/s\", band = [\"15 Hz\", \"25 Hz\"] }\n\
             rate = \"33 arcsec/s\"",
        ),
        (
            0.05,
            1.0,
            2,
            "gaussian = { rms = \"5 arcsec/s\", band = [\"15 Hz\", \"25 Hz\"] }\n\
             amplitude = { uniform = [\"5 arcsec/s\", \"60 arcsec/s\"] }\n\
             frequency = \"11 Hz\"\n\
             acceleration = \"0.1 deg/s^2\"",
        ),
        (0.02, 3.2, 3, "rate = \"123 arcsec/s\""),
        (2.0, 3.2, 5, "rate = \"123 arcsec/s\""),
    ];
    for (noise_arcsec, pulse_arcsec, gap_ticks, motion) in cases {
        let case = Case { noise_arcsec, pulse_arcsec, gap_ticks, motion };
        let [runs, counted] = [case.ends(folder.path(), 1000), case.counted(folder.path())];
        assert_eq!((runs.len(), counted.len()), (3, 3), "{motion}");
        for (place, (run, counted)) in runs.iter().zip(&counted).enumerate() {
            let (found, expected, se) = (run["residual_rms"], counted["rms"], counted["rms_se"]);
            let off = (found - expected).abs();
            assert!(
                off < 4.5 * se + 5e-4 * expected,
                "filler {place}, gap of {gap_ticks}, {motion}: {found} ″, not {expected} ± {se} ″"
            );
        }
    }
}

/// Motions of less than a pulse beside a constant rate of one pulse per tick or none, whose fractions are the most correlated.
#[test]
fn the_angle_after_many_switches_is_that_of_as_many_counted_residuals() {
    let folder = record();
    let drawn = "amplitude = { uniform = [\"30 arcsec/s\", \"50 arcsec/s\"] }\nfrequency = \"20 Hz\"\n\
                 phase = \"zero-crossing\"\nrate = \"640 arcsec/s\"";
    for (noise_arcsec, motion) in [(0.02, drawn), (0.05, "profile = { file = \"base.csv\" }")] {
        let case = Case { noise_arcsec, pulse_arcsec: 3.2, gap_ticks: 3, motion };
        let [runs, counted] = [case.ends(folder.path(), 20_000), case.counted(folder.path())];
        assert_eq!((runs.len(), counted.len()), (3, 3), "{motion}");
        for (run, counted) in runs.iter().zip(&counted) {
            let (rms, mean, switches) = (counted["rms"], counted["mean"], run["switches"]);
            let expected = (switches * (rms * rms - mean * mean) + (switches * mean).powi(2)).sqrt();
            let se = run["rms_se"].hypot(counted["rms_se"] * expected / rms);
            let found = run["rms"];
            assert!((found - expected).abs() < 4.5 * se, "{motion}: {found} ″, not {expected} ± {se} ″");
        }
    }
}
