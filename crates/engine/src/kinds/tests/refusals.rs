//! Studies that make no sense, and how their faults are reported.

use std::path::Path;

use crate::kinds::tests::{BASE, refused, replaced, with};
use crate::study::Study;

#[test]
fn text_that_is_no_study_is_pointed_at() {
    refused(&replaced("\"20 Hz\"", "20 Hz"), &["a.toml:8:", "not valid TOML", "stand in quotes"]);
    refused(
        &replaced("frequency", "freqency"),
        &["a.toml:8:1", "unknown key `freqency`", "did you mean `frequency`?"],
    );
    refused(&replaced("[gyro]", "[giro]"), &["a.toml:3:", "unknown key `giro`", "did you mean `gyro`?"]);
    refused(
        &replaced("frequency = \"20 Hz\"\n", ""),
        &["a.toml:7:13", "motion.frequency is missing", "frequency = \"20 Hz\""],
    );
    refused(&replaced("title = \"A study\"\n", ""), &["a.toml:1:1", "the key `title` is missing"]);
    refused("", &["the key `title` is missing"]);
    refused(&replaced("\"A study\"", "5"), &["a.toml:1:9", "`title` is the number 5", "a text in quotes"]);
    refused(&replaced("gap-fill", "gapfill"), &["a.toml:2:8", "unknown value \"gapfill\"", "gap-fill"]);
    refused(
        &replaced("\"quadratic\"", "\"cubic\""),
        &["a.toml:11:21", "\"cubic\"", "const, linear, quadratic"],
    );
    refused(&replaced("\"5 ms\"", "[5]"), &["a.toml:4:8", "`gyro.tick` is a list", "\"5 ms\""]);
    refused(&with("[chart]\nx = \"dt_nu\"\ny = \"rms\"\nsize = 3\n"), &["a.toml:15:1", "unknown key `size`"]);
    refused(
        &with("[[sweep]]\nkey = \"motion.frequency\"\nlog = [1]\n"),
        &["a.toml:14:7", "`sweep.log` is a list", "must be a table", "points = 24"],
    );
    refused(&with("chart = 5\n"), &["a.toml:12:1", "unknown key `chart`"]);
    refused(
        &format!("chart = 5\n{BASE}"),
        &["a.toml:1:9", "must be a table, or a list of tables in brackets"],
    );
}

#[test]
fn wrong_values_are_named_with_what_is_accepted() {
    let hz = ["a.toml:8:13", "a bare number", "accepted: a frequency in Hz, kHz, 1/s, for example \"20 Hz\""];
    refused(&replaced("\"20 Hz\"", "20"), &hz);
    refused(&replaced("\"20 Hz\"", "\"20\""), &hz);
    refused(&replaced("\"20 Hz\"", "nan"), &hz);
    refused(&replaced("20 Hz", "NaN Hz"), &["a.toml:8:13", "does not begin with a number"]);
    refused(&replaced("20 Hz", "1e999 Hz"), &["a.toml:8:13", "is not a finite number"]);
    refused(&replaced("20 Hz", "20 deg"), &["motion.frequency: \"20 deg\" is an angle", "Hz, kHz, 1/s"]);
    refused(&replaced("20 Hz", "20 hz"), &["a.toml:8:13", "`hz` is not a known unit", "Hz, kHz, 1/s"]);
    refused(&replaced("\"20 Hz\"", "true"), &["a.toml:8:13", "true or false"]);
    refused(&replaced("20 Hz", "-20 Hz"), &["a.toml:8:13", "motion.frequency = -20 Hz", "negative"]);
    refused(&replaced("20 Hz", "0 Hz"), &["a.toml:8:13", "too small", "accepted: 1e-9 Hz"]);
    refused(&replaced("20 Hz", "2001 Hz"), &["a.toml:8:13", "tick rate of 200 Hz", "2000 Hz here"]);
    refused(&replaced("5 ms", "0.1 µs"), &["a.toml:4:8", "gyro.tick = 1e-7 s", "1 µs to 1000 s"]);
    refused(&replaced("5 ms", "5"), &["a.toml:4:8", "accepted: a time in s, ms", "\"5 ms\""]);
    refused(&replaced("12000", "-1"), &["a.toml:7:13", "negative", "arcsec/s"]);
    refused(&replaced("12000 arcsec/s", "1e9 arcsec"), &["a.toml:7:13", "1.257e11 arcsec/s at 20 Hz"]);
    refused(&replaced("std = \"1 arcsec\"", ""), &["a.toml:5:14", "exactly one of std, three_sigma"]);
    refused(&replaced("std = \"1", "three_sigma = \"1 ″\", std = \"1"), &["a.toml:5:14", "exactly one"]);
    refused(&replaced("1 arcsec\"", "1e7 arcsec\""), &["a.toml:5:22", "too large", "0 to 1e6 arcsec"]);
    refused(
        &replaced("std = \"1 arcsec\"", "angle_random_walk = \"1e9 ″/√s\""),
        &["a.toml:5:36", "7.071e7 arcsec per tick"],
    );
    refused(&replaced("gap_ticks = 3", "gap_ticks = 65"), &["a.toml:10:13", "within 1 … 64", "too large"]);
    refused(&replaced("gap_ticks = 3", "gap_ticks = \"3\""), &["a.toml:10:13", "a text", "whole number"]);
    refused(&replaced("gap_ticks = 3", "gap_ticks = 2.5"), &["a.toml:10:13", "not a whole number"]);
    refused(&replaced("gap_ticks = 3", "gap_ticks = 1e2"), &["a.toml:10:13", "within 1 … 64"]);
    refused(&format!("trials = 0\n{BASE}"), &["a.toml:1:10", "trials = 0", "1 … 1099511627776"]);
    refused(&format!("seed = 9223372036854775808\n{BASE}"), &["a.toml:1:8", "is too large"]);
    refused(&format!("seed = 99999999999999999999\n{BASE}"), &["a.toml:1:8", "too large"]);
    refused(&replaced("\"5 ms\"", "2026-01-01"), &["a.toml:4:8", "`gyro.tick` is a date"]);
    refused(&format!("seed = -1\n{BASE}"), &["a.toml:1:8", "seed = -1", "too small"]);
    refused(&replaced("[\"const\", \"quadratic\"]", "[]"), &["a.toml:11:11", "empty", "const, linear"]);
    refused(&replaced("\"quadratic\"", "\"const\""), &["a.toml:11:21", "twice"]);
    let chart = |line: &str| with(&format!("[chart]\nx = \"dt_nu\"\ny = \"rms\"\n{line}\n"));
    refused(&chart("series = [\"a\", \"b\", \"c\"]"), &["a.toml:15:10", "names 3 columns"]);
    refused(&chart("limit = 10"), &["a.toml:15:9", "chart.limit", "accepted: an angle"]);
    for limit in ["0 arcsec", "-1 arcsec"] {
        let pieces = [&format!("chart.limit = {}", limit.replace(" arcsec", "″")), "not above 0"];
        refused(&chart(&format!("limit = \"{limit}\"")), &["a.toml:15:9", pieces[0], pieces[1]]);
    }
}

#[test]
fn fits_that_make_no_sense_are_refused() {
    let ticks = |line: &str| with(&format!("{line}\n"));
    refused(
        &ticks("fit_ticks = [-1, 0, 2]"),
        &["a.toml:12:21", "tick 2 lies inside the gap", "gap_ticks = 3"],
    );
    refused(
        &ticks("fit_ticks = [-1, 0]"),
        &["a.toml:12:13", "quadratic needs 3 ticks, switching.fit_ticks has 2", "leave out"],
    );
    refused(&ticks("extrapolation_ticks = []"), &["a.toml:12:23", "const needs 1 tick, "]);
    refused(&ticks("extrapolation_ticks = [\"n+1\"]"), &["a.toml:12:24", "after the gap", "ticks up to 0"]);
    refused(&ticks("fit_ticks = [0.5]"), &["a.toml:12:14", "names no tick", "\"n+1\""]);
    refused(
        &ticks("fit_ticks = [-1, 0, 3, 4]\n[[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2, 3]"),
        &["a.toml:12:21", "tick 3 lies inside the gap", "at gap_ticks = 3"],
    );
}

#[test]
fn sweeps_that_make_no_sense_are_refused() {
    let sweep = |key: &str, values: &str| with(&format!("[[sweep]]\nkey = \"{key}\"\n{values}\n"));
    let frequency = |values: &str| sweep("motion.frequency", values);
    refused(&frequency("list = []"), &["a.toml:14:8", "the sweep over motion.frequency is empty"]);
    refused(&frequency(""), &["a.toml:13:7", "exactly one of list, linear, log"]);
    refused(&frequency("list = [\"1 Hz\", 2]"), &["a.toml:14:17", "a bare number", "Hz, kHz"]);
    refused(&frequency("list = [\"1 Hz\", \"1000 mHz\"]"), &["a.toml:14:17", "`mHz` is not a known unit"]);
    refused(&frequency("list = [\"1000 Hz\", \"1 kHz\"]"), &["a.toml:14:20", "takes 1 kHz twice"]);
    refused(
        &frequency("list = [\"1 Hz\", \"3 kHz\"]"),
        &["a.toml:14:8", "too fast for a tick rate of 200 Hz"],
    );
    let log = |from: &str, points: &str| {
        frequency(&format!("log = {{ from = \"{from}\", to = \"4 Hz\", points = {points} }}"))
    };
    refused(&log("0 Hz", "3"), &["a.toml:14:16", "too small"]);
    refused(&log("1 Hz", "0"), &["a.toml:14:46", "points = 0", "1 … 10000"]);
    refused(&log("1 Hz", "1"), &["a.toml:14:46", "points = 1 does not fit the ends 1 Hz and 4 Hz"]);
    refused(&log("4 Hz", "2"), &["a.toml:14:46", "equal ends need points = 1"]);
    refused(&log("3.99999999999 Hz", "9"), &["a.toml:14:7", "the same value twice"]);
    let amplitude = |values: &str| sweep("motion.amplitude", values);
    refused(
        &amplitude("list = [\"1 arcsec/s\", \"1 arcsec\"]"),
        &["a.toml:14:23", "mixes an angular rate and an angle"],
    );
    refused(
        &amplitude("log = { from = \"0 ″\", to = \"1 ″\", points = 2 }"),
        &["a.toml:14:16", "cannot contain 0″", "linear"],
    );
    let gap = "linear = { from = 1, to = 4, points = 3 }";
    refused(
        &sweep("switching.gap_ticks", gap),
        &["a.toml:14:10", "whole numbers only, this sweep gives 2.5"],
    );
    refused(&sweep("switching.gap_ticks", "list = [1, 65]"), &["a.toml:14:12", "within 1 … 64"]);
    refused(
        &sweep("motion.phase", "list = [\"uniform\"]"),
        &["a.toml:13:7", "motion.phase is text", "gyro.tick, "],
    );
    refused(&sweep("switching.fillers", "list = [1]"), &["switching.fillers is a list and cannot be swept"]);
    refused(&sweep("motion.freqency", "list = [1]"), &["a.toml:13:7", "did you mean `motion.frequency`?"]);
    refused(&sweep("frequency", "list = [1]"), &["did you mean `motion.frequency`?"]);
    let twice = "list = [\"1 ″\"]\n[[sweep]]\nkey = \"gyro.tick_noise.three_sigma\"\nlist = [\"1 ″\"]";
    refused(
        &sweep("gyro.tick_noise.std", twice),
        &["a.toml:16:7", "gyro.tick_noise.three_sigma is swept although gyro.tick_noise.std is already"],
    );
    let many = "linear = { from = \"1 Hz\", to = \"2 Hz\", points = 10000 }\n[[sweep]]\n\
                key = \"switching.gap_ticks\"\nlinear = { from = 1, to = 11, points = 11 }";
    refused(&frequency(many), &["a.toml:17:10", "multiply to 110000 points, more than 100000"]);
}

#[test]
fn a_file_that_is_not_there_is_told() {
    let error = Study::read(Path::new("/nowhere/a.toml")).unwrap_err();
    assert!(error.to_string().contains("/nowhere/a.toml"), "{error}");
}
