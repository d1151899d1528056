//! Runs against the closed forms of their drift and residuals.

use sagnac::theory::drift::{Magnetic, switches};
use sagnac_engine::kinds::switched_run::lower::LoweredRun;
use sagnac_kernel::switched_run::trajectory;

use super::texts::{DRIFT, numbers, study};
use crate::studies::parsed;

const MAGNETIC: Magnetic = Magnetic { amplitude: 14.0, time_s: 3000.0, initial: 0.0 };

#[test]
fn runs_without_spreads_and_residuals_are_those_of_the_reference() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/drift_run.csv");
    for record in csv::Reader::from_path(path).unwrap().records() {
        let record = record.unwrap();
        let [t, interval, count, expected] = [0, 1, 2, 3].map(|at| record[at].parse::<f64>().unwrap());
        let study = study(
            1,
            DRIFT,
            &format!("interval = \"{interval} s\"\n"),
            &format!("duration = \"{t} s\"\nend = \"exact\"\n"),
            "",
        );
        let runs = study.asked::<sagnac_engine::kinds::switched_run::SwitchedRun>().unwrap();
        let lowered = LoweredRun::new(&runs.points[0], runs, 1, study.streams).unwrap();
        let filled = &lowered.fillers[0];
        let (launch, shape) = filled.trajectories();
        let angles = trajectory(&launch, shape, 0);
        assert_eq!(angles.len(), 2 * count as usize + 1, "{record:?}");
        let lsb = filled.estimates[0].unit_arcsec;
        let bound = (count + 1.0) * lsb;
        let end = f64::from(angles[angles.len() - 1]) * lsb;
        assert!((end - expected * t).abs() <= bound, "{record:?}: {end} ″, not {} ″", expected * t);
        for (place, angle) in angles.iter().enumerate() {
            let at = ((place / 2 + 1) as f64 * interval).min(t);
            let exact = 0.05 * at + MAGNETIC.signed_integral(interval, at);
            let angle = f64::from(*angle) * lsb;
            assert!((angle - exact).abs() <= lsb, "{record:?} at {at} s: {angle} ″, not {exact} ″");
        }
    }
}

/// Largest |z| of means and rms in the rows of a study, with how many there are.
fn deviations(study: &sagnac::study::Study) -> (f64, usize) {
    let mut all = Vec::new();
    for row in numbers(study) {
        all.extend(["z", "z_mean"].iter().filter_map(|name| row.get(*name)).map(|z| z.abs()));
    }
    (all.iter().fold(0.0, |most: f64, z| most.max(*z)), all.len())
}

#[test]
fn means_and_rms_agree_with_their_closed_forms_within_5_standard_errors() {
    let spreads = "magnetic_spread = \"1 arcsec/s\"\ninitial_magnetic = \"0.3 arcsec/s\"\n\
                   initial_magnetic_spread = \"0.1 arcsec/s\"\nnon_magnetic_spread = \"0.01 arcsec/s\"\n\
                   angle_random_walk = \"0.03 deg/sqrt(h)\"\n";
    let residual = "residual_max = \"10 arcsec\"\n";
    let times = "times = [\"1 s\", \"40 s\", \"100 s\", \"333 s\", \"599 s\", \"600 s\"]\n";
    let run = "duration = \"600 s\"\n";
    let interval = "interval = \"40 s\"\n";
    let warm_up = "warm_up_time_spread = \"20 %\"\nmagnetic_spread = \"1 arcsec/s\"\n";
    let cases: [(&str, String, String, String); 10] = [
        ("warm-up", warm_up.into(), interval.into(), format!("{run}{times}")),
        (
            "warm-up and random mode",
            format!("{warm_up}initial_magnetic = \"0.3 arcsec/s\"\n"),
            format!("{interval}first_mode = \"random\"\n"),
            format!("{run}{times}"),
        ),
        ("residuals", residual.into(), interval.into(), run.into()),
        ("spreads", spreads.into(), interval.into(), run.into()),
        ("times", format!("{spreads}{residual}"), interval.into(), format!("{run}{times}")),
        ("negative", residual.into(), format!("{interval}first_mode = \"negative\"\n"), run.into()),
        (
            "random mode",
            format!("{spreads}{residual}"),
            format!("{interval}first_mode = \"random\"\n"),
            format!("{run}{times}"),
        ),
        ("in phase", residual.into(), format!("{interval}timing = \"periodic\"\n"), run.into()),
        ("odd intervals", format!("{spreads}{residual}"), "interval = \"47 s\"\n".into(), run.into()),
        ("a long run", residual.into(), "interval = \"10 s\"\n".into(), "duration = \"10 h\"\n".into()),
    ];
    for (name, drift, switching, run) in cases {
        let trials = if name == "a long run" { 20_000 } else { 300_000 };
        for end in ["any", "exact"] {
            let run = format!("{run}end = \"{end}\"\n");
            let (largest, count) =
                deviations(&study(trials, &format!("{DRIFT}{drift}"), &switching, &run, ""));
            println!("{name}, {end} end: largest |z| of {count} is {largest:.2}");
            // Of each row with a closed form the rms and the mean, but where rounding is larger than their error.
            assert!(count >= 2 && largest < 5.0, "{name}, {end} end: |z| = {largest} of {count}");
        }
    }
}

/// The drift as a function of the interval has no sawtooth: from 30 to 50 s it bends smoothly in closed form, which the
/// samples follow within their errors. With exact ends it jumps between neighbouring intervals.
#[test]
fn a_sweep_of_the_interval_has_no_sawtooth_of_the_end() {
    let intervals: Vec<f64> = (0..41).map(|k| 30.0 + 0.5 * f64::from(k)).collect();
    let list = intervals.iter().map(|x| format!("\"{x} s\"")).collect::<Vec<_>>().join(", ");
    let swept = |end: &str| {
        let run = format!("duration = \"1 h\"\nend = \"{end}\"\n");
        let sweep = format!("[[sweep]]\nkey = \"switching.interval\"\nlist = [{list}]\n");
        let drift = format!("{DRIFT}residual_max = \"30 arcsec\"\n");
        let rows = numbers(&study(2000, &drift, "interval = \"40 s\"\n", &run, &sweep));
        rows.into_iter().filter(|row| row.contains_key("theory_drift_rms")).collect::<Vec<_>>()
    };
    // The largest second difference of neighbouring drifts, relative to the drift.
    let largest_kink = |rows: &[std::collections::BTreeMap<String, f64>]| {
        let drift: Vec<f64> = rows.iter().map(|row| row["theory_drift_rms"]).collect();
        let kinks = drift.windows(3).map(|three| ((three[0] - 2.0 * three[1] + three[2]) / three[1]).abs());
        kinks.fold(0.0, f64::max)
    };
    let (any, exact) = (swept("any"), swept("exact"));
    assert_eq!((any.len(), exact.len()), (41, 41));
    // A magnetic drift that grows within the cycle leaves a mean of some tenths of a second of arc besides Ω_nm.
    assert!(largest_kink(&any) < 0.005, "{}", largest_kink(&any));
    assert!(largest_kink(&exact) > 0.5, "{} with exact ends", largest_kink(&exact));
    for row in any {
        assert!(row["z"].abs() < 5.0 && row["z_mean"].abs() < 5.0, "{row:?}");
    }
}

/// The paper's gyro at 20.1 Hz with these keys of its switching.
fn filled(trials: u64, motion: &str, switching: &str) -> sagnac::study::Study {
    parsed("runs.toml", &filled_text(trials, motion, switching))
}

fn filled_text(trials: u64, motion: &str, switching: &str) -> String {
    format!(
        "title = \"runs\"\nkind = \"switched-run\"\ntrials = {trials}\n[gyro]\ntick = \"5 ms\"\n\
         tick_noise = {{ three_sigma = \"1.6 arcsec\" }}\n[motion]\n{motion}[switching]\ninterval = \"10 s\"\ngap_ticks = 3\n\
         fillers = [\"const\", \"quadratic\", {{ kind = \"minimum-variance\", fit_ticks = [\"-7..0\", \"n+1\", \"n+2\"] }}]\n\
         {switching}[run]\nduration = \"100 s\"\n"
    )
}

#[test]
fn residuals_of_fillers_add_up_as_their_closed_forms_say() {
    let tone = "amplitude = \"12000 arcsec/s\"\nfrequency = \"20.013 Hz\"\n";
    for (name, motion, switching) in [
        ("at random", tone.to_owned(), ""),
        ("periodic", tone.to_owned(), "timing = \"periodic\"\n"),
        ("at the extremum", format!("{tone}phase = \"extremum\"\n"), ""),
        (
            "Gaussian",
            "gaussian = { rms = \"8485 arcsec/s\", band = [\"18 Hz\", \"22 Hz\"] }\n".to_owned(),
            "",
        ),
        ("acceleration", format!("{tone}acceleration = \"10 deg/s^2\"\n"), ""),
    ] {
        let (largest, count) = deviations(&filled(200_000, &motion, switching));
        println!("{name}: largest |z| of {count} is {largest:.2}");
        assert!(count >= 6 && largest < 5.0, "{name}: |z| = {largest}");
    }
}

/// One switch alone, without drift: the run's error is the residual that the gap-fill kernel samples.
#[test]
fn the_residual_of_one_switch_is_that_of_the_gap_fill_kernel() {
    let gyro = "[gyro]\ntick = \"5 ms\"\ntick_noise = { three_sigma = \"1.6 arcsec\" }\nreadout_lsb = \"1 arcsec\"\n\
                relock = [\"2 arcsec\"]\n";
    let motions = [
        "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\n",
        "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\nphase = \"extremum\"\n",
        "tones = [{ amplitude = \"9000 arcsec/s\", frequency = \"11 Hz\" }, { amplitude = \"4000 arcsec/s\", frequency = \"31 Hz\" }]\n",
        "amplitude = { rayleigh = \"8000 arcsec/s\" }\nfrequency = \"20 Hz\"\nacceleration = \"10 deg/s^2\"\n",
        "amplitude = \"12000 arcsec/s\"\nfrequency = [\"18 Hz\", \"22 Hz\"]\n",
    ];
    for motion in motions {
        let with = |head: &str, switching: &str, run: &str| {
            let text = format!(
                "title = \"one switch\"\n{head}trials = 400_000\n{gyro}[motion]\n{motion}[switching]\n\
                 gap_ticks = 3\nfillers = [\"const\", \"quadratic\"]\n{switching}{run}"
            );
            numbers(&parsed("one.toml", &text))
        };
        let twenty = "[run]\nduration = \"20 s\"\nend = \"exact\"\n";
        let run = with("kind = \"switched-run\"\n", "interval = \"10 s\"\n", twenty);
        let gap = with("kind = \"gap-fill\"\n", "errors = [\"residual\"]\n", "");
        let ends = run.iter().filter(|row| row.get("time") == Some(&20.0));
        for (run, gap) in ends.zip(&gap) {
            // Delivered with the ticks, the relock is in the angle besides.
            let relock = 2.0;
            let (mean, rms) = (run["mean"] - relock, run["rms"]);
            let about_zero = (rms * rms - run["mean"] * run["mean"]).sqrt();
            let of_gap = (gap["rms"].powi(2) - gap["mean"].powi(2)).sqrt();
            let se = run["rms_se"].hypot(gap["rms_se"]) + of_gap * 2e-3;
            assert!((about_zero - of_gap).abs() < 5.0 * se, "{motion}: {about_zero} ″, not {of_gap} ″");
            let se = of_gap * (2.0_f64 / 4e5).sqrt();
            assert!((mean - gap["mean"]).abs() < 5.0 * se + 1e-4, "{motion}: {run:?} {gap:?}");
        }
    }
}

/// Neighbouring ticks share a fraction of a pulse, which counts most where a filler reads many of them and little else is left.
#[test]
fn fractions_of_a_pulse_telescope_where_the_motion_is_drawn() {
    let motions = [
        "amplitude = \"5 deg/s\"\nfrequency = [\"30 Hz\", \"40 Hz\"]\n",
        "amplitude = { rayleigh = \"5 deg/s\" }\nfrequency = [\"30 Hz\", \"40 Hz\"]\n",
        // Less than a pulse in a tick.
        "amplitude = \"0.03 deg/s\"\nfrequency = [\"30 Hz\", \"40 Hz\"]\n",
        "amplitude = { rayleigh = \"0.01 deg/s\" }\nfrequency = [\"30 Hz\", \"40 Hz\"]\n",
        "amplitude = { uniform = [\"0.02 deg/s\", \"0.2 deg/s\"] }\nfrequency = \"35 Hz\"\n",
        "amplitude = { uniform = [\"0.02 deg/s\", \"0.2 deg/s\"] }\nfrequency = [\"10 Hz\", \"40 Hz\"]\n",
    ];
    for motion in motions {
        let with = |head: &str, switching: &str, run: &str| {
            let text = format!(
                "title = \"pulses\"\n{head}trials = 200_000\n[gyro]\ntick = \"2 ms\"\ntick_noise = {{ std = \"0 arcsec\" }}\n\
                 readout_lsb = \"0.5 arcsec\"\n[motion]\n{motion}[switching]\ngap_ticks = 2\nfillers = [\"quadratic\", \
                 {{ kind = \"minimum-variance\", fit_ticks = [\"-7..0\", \"n+1..n+8\"], band = [\"30 Hz\", \"40 Hz\"] }}]\n\
                 {switching}{run}"
            );
            numbers(&parsed("pulses.toml", &text))
        };
        let twenty = "[run]\nduration = \"20 s\"\nend = \"exact\"\n";
        let run = with("kind = \"switched-run\"\n", "interval = \"10 s\"\n", twenty);
        let gap = with("kind = \"gap-fill\"\n", "errors = [\"residual\"]\n", "");
        let ends: Vec<_> = run.iter().filter(|row| row.get("time") == Some(&20.0)).collect();
        assert_eq!((ends.len(), gap.len()), (2, 2));
        for (run, gap) in ends.into_iter().zip(&gap) {
            let (of_run, of_gap) = (run["rms"], gap["rms"]);
            let se = run["rms_se"].hypot(gap["rms_se"]) + 2e-3 * of_gap;
            assert!((of_run - of_gap).abs() < 5.0 * se, "{motion}: {of_run} ″, not {of_gap} ″");
        }
    }
}

#[test]
fn the_numbers_of_the_theory_are_found() {
    // t, MT, true mean drift, standard deviation of theory.md's table, ″/s.
    for (t, interval, mean, deviation) in [
        (3600.0, 40.0, -0.0044, 0.0185),
        (3600.0, 100.0, -0.0859, 0.0116),
        (36000.0, 60.0, 0.0383, 0.0048),
        (36000.0, 300.0, -0.0083, 0.0021),
    ] {
        let rows = numbers(&study(
            50_000,
            &format!("{DRIFT}residual_max = \"10 arcsec\"\n"),
            &format!("interval = \"{interval} s\"\n"),
            &format!("duration = \"{t} s\"\nend = \"exact\"\n"),
            "",
        ));
        let end = &rows[0];
        assert_eq!(end["switches"], switches(interval, t));
        let found = end["drift_mean"];
        let sd = (end["drift_rms"].powi(2) - found * found).sqrt();
        assert!((found - mean).abs() < 0.000_3, "{t} s, {interval} s: mean {found}");
        assert!((sd - deviation).abs() < 0.000_1, "{t} s, {interval} s: deviation {sd}");
    }
}

/// A loop like that of the paper, which fakes some 17 ″ in four ticks.
const RELOCK: &str = "[relock]\nmiss = 0.05\nhalf_wave_error = 0.005\ndac_step = 0.002\nhysteresis = 0.004\nloop_time = \"12 ms\"\n\
                      bias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40\n";

#[test]
fn uncompensated_relocks_add_up_as_their_closed_form_says() {
    let tone = "amplitude = \"12000 arcsec/s\"\nfrequency = \"20.013 Hz\"\n";
    let text = |more: &str| {
        let study = filled_text(200_000, tone, "");
        parsed("runs.toml", &format!("{study}{RELOCK}{more}"))
    };
    let (largest, count) = deviations(&text(""));
    println!("relock: largest |z| of {count} is {largest:.2}");
    assert!(count >= 6 && largest < 5.0, "|z| = {largest}");
}

/// What is exact of the detuning takes the relock off again, up to its rounding: runs are as without it.
#[test]
fn an_exact_compensation_leaves_runs_as_they_are_without_relock() {
    let tone = "amplitude = \"12000 arcsec/s\"\nfrequency = \"20.013 Hz\"\n";
    let study = filled_text(100_000, tone, "");
    let with = |more: &str| numbers(&parsed("runs.toml", &format!("{study}{more}")));
    let (without, compensated) = (with(""), with(&format!("{RELOCK}compensation = \"detuning\"\n")));
    let uncompensated = with(RELOCK);
    for ((without, compensated), uncompensated) in without.iter().zip(&compensated).zip(&uncompensated) {
        let off = (compensated["rms"] - without["rms"]).abs();
        // Other draws, and the relock's own rounding at nine switches.
        assert!(
            off < 5.0 * without["rms_se"].hypot(compensated["rms_se"]) + 0.01,
            "{compensated:?}, not {without:?}"
        );
        assert!(uncompensated["rms"] > 10.0 * off, "{uncompensated:?}");
        assert!(!compensated.contains_key("theory_rms"), "a compensated relock has no closed form");
    }
}

/// A relock that is always the same adds its ticks, 35.1 ″, and what they do to the fillers by theory.md: 26.3 and 35.9 ″.
#[test]
fn a_relock_by_list_adds_its_ticks_and_what_they_do_to_the_filler() {
    let text = "title = \"runs\"\nkind = \"switched-run\"\ntrials = 1000\n[gyro]\ntick = \"5 ms\"\n\
                tick_noise = { std = \"0.1 arcsec\" }\nrelock = [\"20.3 arcsec\", \"14.8 arcsec\"]\n[motion]\nrate = \"0 deg/s\"\n\
                [switching]\ninterval = \"10 s\"\ngap_ticks = 3\nfillers = [\"const\", \"quadratic\"]\n[run]\n\
                duration = \"100 s\"\nend = \"exact\"\n";
    let rows = numbers(&parsed("runs.toml", text));
    for (row, through) in [(&rows[0], 26.325), (&rows[2], 35.95)] {
        let expected = 9.0 * (35.1 + through);
        let se = row["rms_se"];
        assert!((row["mean"] - expected).abs() < 5.0 * se + 1e-3, "{} ″, not {expected} ″", row["mean"]);
    }
}

/// The ticks of Z(11) and what they do to the fillers: gains 1 + w_i, with the weights of theory.md.
#[test]
fn a_relock_without_spreads_adds_the_ticks_of_its_closed_form_times_their_gains() {
    let loop_ = "[relock]\nmiss = 0.05\nloop_time = \"12 ms\"\nbias_frequency = \"80 kHz\"\n\
                 pulse_weight = \"2.6 arcsec\"\ncurvature = 40\n";
    let text = format!(
        "title = \"runs\"\nkind = \"switched-run\"\ntrials = 2000\n[gyro]\ntick = \"5 ms\"\n\
         tick_noise = {{ std = \"0.01 arcsec\" }}\n[motion]\nrate = \"0 deg/s\"\n[switching]\ninterval = \"10 s\"\n\
         gap_ticks = 3\nfillers = [\"const\", \"quadratic\"]\n[run]\nduration = \"100 s\"\nend = \"exact\"\n{loop_}"
    );
    let rows = numbers(&parsed("runs.toml", &text));
    let relock = sagnac::theory::relock::Relock {
        tick_s: 0.005,
        loop_s: 0.012,
        bias: 80_000.0 * 2.6,
        curvature: 40.0,
        miss: 0.05,
    };
    let angle = |tick: u32| relock.tick_s * relock.apparent_drift(tick);
    for (row, weights) in [(&rows[0], [0.75, 0.75]), (&rows[2], [2.5, -1.0])] {
        let through: f64 = weights.iter().zip(1..).map(|(weight, tick)| weight * angle(tick)).sum();
        let expected = 9.0 * ((1..=4).map(angle).sum::<f64>() + through);
        let bound = 5.0 * (0.01 * 3.808 * 3.0) / 2000.0_f64.sqrt() + 1e-4 * expected;
        assert!((row["mean"] - expected).abs() < bound, "{} ″, not {expected} ″", row["mean"]);
    }
}

/// The temperature curve has f0 wrong by the same part at all switches of a run: what that leaves adds up as their number.
#[test]
fn a_wrong_f0_adds_up_as_the_number_of_switches() {
    let rms = |duration: &str| {
        let text = format!(
            "title = \"runs\"\nkind = \"switched-run\"\ntrials = 4000\n[gyro]\ntick = \"5 ms\"\n\
             tick_noise = {{ std = \"0.01 arcsec\" }}\n[motion]\nrate = \"0 deg/s\"\n[switching]\ninterval = \"10 s\"\n\
             gap_ticks = 3\nfillers = [\"const\"]\n[run]\nduration = \"{duration}\"\nend = \"exact\"\n[relock]\nmiss = 0.05\n\
             loop_time = \"12 ms\"\nbias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40\n\
             temperature_error = \"1 %\"\ncompensation = \"detuning\"\n"
        );
        let row = numbers(&parsed("runs.toml", &text)).remove(0);
        assert!(row.contains_key("p99_73"), "{row:?}");
        row["rms"]
    };
    let (nine, ninety) = (rms("100 s"), rms("910 s"));
    assert!((ninety / nine - 10.0).abs() < 0.5, "{nine} ″ after 9 switches, {ninety} ″ after 90");
}

#[test]
fn another_number_of_relock_ticks_is_another_point() {
    let id = |ticks: u32| {
        let study = filled_text(1000, "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"\n", "");
        let study = parsed("runs.toml", &format!("{study}{RELOCK}ticks = {ticks}\n"));
        let runs = study.asked::<sagnac_engine::kinds::switched_run::SwitchedRun>().unwrap();
        LoweredRun::new(&runs.points[0], runs, 1, study.streams).unwrap().id
    };
    assert_ne!(id(4), id(8));
}
