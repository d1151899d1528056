//! Bad relock studies: each is refused with its place, what was found, what is accepted, and exit code 3.

use crate::desk::refused;

const STUDY: &str = r#"title = "Relock"
kind = "relock"
[gyro]
tick = "5 ms"
[relock]
initial_detuning = 0.05
half_wave_error = 0.002
loop_time = "12 ms"
bias_frequency = "80 kHz"
pulse_weight = "2.6 arcsec"
curvature = 40
adc_noise = 0.0002
"#;

fn replaced(from: &str, to: &str) -> String {
    assert!(STUDY.contains(from), "`{from}` is not in the study");
    STUDY.replacen(from, to, 1)
}

#[test]
fn spreads_below_0_and_values_out_of_range_are_refused() {
    refused(
        &replaced("half_wave_error = 0.002", "half_wave_error = -0.002"),
        "7:19",
        &["relock.half_wave_error = -0.002", "negative", "accepted: 0 to 1"],
    );
    refused(&replaced("adc_noise = 0.0002", "adc_noise = -1"), "12:13", &["relock.adc_noise", "negative"]);
    refused(&replaced("0.05", "1.5"), "6:20", &["relock.initial_detuning = 1.5", "too large", "-1 to 1"]);
    refused(&replaced("0.05", "\"5 ms\""), "6:20", &["is not a ratio", "0.05 or \"5 %\""]);
    refused(&replaced("\"12 ms\"", "12"), "8:13", &["a bare number", "accepted: a time"]);
    refused(&format!("{STUDY}ticks = 9\n"), "13:9", &["relock.ticks = 9", "1 … 8"]);
    refused(&format!("{STUDY}temperature_error = \"7 %\"\n"), "13:21", &["out of range", "0 % to 5 %"]);
    refused(&format!("{STUDY}first_half = \"up\"\n"), "13:14", &["unknown value \"up\"", "negative"]);
    refused(&replaced("curvature", "curvatur"), "11:1", &["did you mean `curvature`?"]);
}

#[test]
fn loops_and_biases_that_make_no_sense_are_refused() {
    refused(
        &replaced("12 ms", "2 s"),
        "8:13",
        &["relock.loop_time = 2 s does not settle", "up to 100 ticks"],
    );
    refused(&replaced("12 ms", "10 us"), "8:13", &["is over within the first tick", "20th of a tick"]);
    refused(&replaced("80 kHz", "300 Hz"), "9:18", &["0.75 counts in half a tick", "count_step"]);
    refused(&replaced("80 kHz", "900000 kHz"), "9:18", &["too many"]);
    refused(&replaced("curvature = 40", "curvature = 400"), "11:13", &["leaves no bias", "χ·Δλ² = "]);
    refused(&replaced("adc_noise = 0.0002", "adc_noise = 1e-11"), "12:13", &["is lost beside", "or 0"]);
    refused(
        &replaced("0.05\nhalf_wave_error = 0.002", "0"),
        "6:20",
        &["nothing to relock", "give an initial detuning"],
    );
}

#[test]
fn what_belongs_to_other_kinds_is_refused() {
    refused(
        &replaced("tick = \"5 ms\"", "tick = \"5 ms\"\nreadout_lsb = \"3 arcsec\""),
        "5:15",
        &["gyro.readout_lsb is not a key", "kind = \"gap-fill\""],
    );
    refused(
        &format!("{STUDY}[record]\nsample = \"1 s\"\nlength = \"1 h\""),
        "13:1",
        &["[record] is not a table", "kind = \"allan\""],
    );
    refused(&format!("precision = \"1 %\"\n{STUDY}"), "1:13", &["precision is not a key", "leave it out"]);
    refused(
        "title = \"t\"\nkind = \"relock\"\n[gyro]\ntick = \"5 ms\"",
        "2:8",
        &["needs the table [relock]", "loop_time"],
    );
    refused(
        &format!("{STUDY}[[sweep]]\nkey = \"relock.ticks\"\nlist = [1, 2]"),
        "14:7",
        &["relock.ticks holds for the whole study", "relock.adc_noise"],
    );
    let chart = |more: &str| format!("{STUDY}[chart]\nx = \"tick_number\"\ny = \"rms\"\n{more}");
    refused(&chart("references = [\"noise\"]"), "16:15", &["\"noise\" is a reference curve of gap fillers"]);
    refused(&chart("where = { tick = \"5\" }"), "16:18", &["no row has tick = \"5\"", "all"]);
    refused(&chart("where = { compensation = \"both\" }"), "16:26", &["no row has compensation", "detuning"]);
}
