//! What the program says of the limit and of the best filler, in the terminal, in charts and in JSON.

use crate::desk::{Desk, STUDY, refused, replaced, swept_chart, with};

const AMPLITUDES: &str = "[[sweep]]\nkey = \"motion.amplitude\"\n\
                          log = { from = \"100 arcsec/s\", to = \"20000 arcsec/s\", points = 5 }\n";
const GAPS: &str = "[[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2, 3]\n";

fn chart(y: &str, more: &str) -> String {
    format!("[[chart]]\nx = \"amplitude\"\ny = \"{y}\"\nlimit = \"10 arcsec\"\n{more}\n")
}

/// What is said of a study with this end, and its JSON.
fn said(end: &str) -> (String, serde_json::Value) {
    let desk = Desk::with(&with(end));
    let text = desk.done("run study.toml --device cpu --trials 5000 --verbose --table").stdout;
    let json = desk.done("run study.toml --device cpu --trials 5000 --json").stdout;
    (text, serde_json::from_str(&json).unwrap())
}

/// The lines under a heading.
fn under<'s>(said: &'s str, heading: &str) -> Vec<&'s str> {
    let lines = said.lines().skip_while(|line| !line.starts_with(heading)).skip(1);
    lines.take_while(|line| line.starts_with("  ")).map(str::trim).collect()
}

#[test]
fn each_verdict_names_its_chart_its_error_and_its_rows_and_equal_ones_are_printed_once() {
    let open = "where = { error = \"extrapolation\" }";
    let charts = [
        chart("p99_73", ""),
        chart("p99_73", open),
        chart("p99_73", "title = \"The same\"\ny_scale = \"linear\""),
        chart("rms", "where = { filler = \"const\" }"),
    ];
    let (text, json) = said(&format!("{AMPLITUDES}{}", charts.concat()));
    let headings: Vec<&str> = text.lines().filter(|line| line.contains("against the limit")).collect();
    assert_eq!(
        headings,
        [
            "chart-1, chart-3: 99.73 % error against the limit, error = residual",
            "chart-2: 99.73 % error against the limit, error = extrapolation",
            "chart-4: rms error against the limit, filler = const, error = residual"
        ],
        "{text}"
    );
    let verdicts = json["verdicts"].as_array().unwrap();
    assert_eq!(verdicts.len(), 3);
    assert_eq!(verdicts[0]["charts"], serde_json::json!(["chart-1", "chart-3"]));
    assert_eq!(verdicts[1]["where"], serde_json::json!({ "error": "extrapolation" }));
    assert_eq!(
        (verdicts[1]["of"].as_str(), verdicts[1]["limit_arcsec"].as_f64()),
        (Some("p99_73_arcsec"), Some(10.0))
    );
    assert_eq!(verdicts[2]["of"].as_str(), Some("rms_arcsec"));
    assert_eq!(verdicts[2]["series"].as_array().unwrap().len(), 1, "of const alone");
}

#[test]
fn the_verdict_is_about_what_the_chart_draws() {
    let (text, json) = said(&format!("{AMPLITUDES}{}{}", chart("p99_73", ""), chart("theory_max", "")));
    let at = |verdict: usize| json["verdicts"][verdict]["series"][0]["at"][0][1].as_f64().unwrap();
    // Without noise the largest error of const is 156 ″ at 12000 ″/s, and grows with the amplitude.
    assert!((at(1) / (12000.0 * 10.0 / 154.6) - 1.0).abs() < 0.02, "{}\n{text}", at(1));
    assert!(at(0) < 0.95 * at(1), "the 99.73 % error has noise besides: {}, {}", at(0), at(1));
}

#[test]
fn sentences_have_labels_units_and_numbers_without_exponents() {
    let chart = chart("p99_73", "").replace("10 arcsec", "200 arcsec");
    let (text, _) = said(&format!("{AMPLITUDES}{chart}"));
    let lines = under(&text, "chart: 99.73 % error");
    assert!(lines[0].starts_with("const: rises above 200 arcsec at vibration amplitude 15"), "{text}");
    assert!(lines[0].ends_with("00 arcsec/s"), "{text}");
    let within = "quadratic: within 200 arcsec up to the last point, vibration amplitude 20000 arcsec/s";
    assert_eq!(lines[1], within, "{text}");
    assert!(text.contains("vibration amplitude, ″/s") && !text.contains("e3"), "{text}");
}

#[test]
fn a_count_is_told_as_the_last_one_within() {
    let quiet = replaced("12000 arcsec/s", "1000 arcsec/s");
    let desk = Desk::with(&format!(
        "{quiet}{GAPS}[chart]\nx = \"gap_ticks\"\ny = \"p99_73\"\nlimit = \"10 arcsec\"\n"
    ));
    let text = desk.done("run study.toml --device cpu --trials 5000 --verbose").stdout;
    let lines = under(&text, "chart: 99.73 % error");
    assert_eq!(lines[0], "const: within 10 arcsec up to lost ticks n = 2, Δt·ν = 0.15", "{text}");
}

#[test]
fn a_curve_through_rows_that_belong_on_several_is_refused_with_what_tells_them_apart() {
    refused(
        &swept_chart("x = \"frequency\"\ny = \"rms\""),
        "20:5",
        &[
            "one curve, that of filler = const, runs through rows that differ in motion.amplitude (10, 12000)",
            "where = { amplitude = \"10 arcsec/s\" }, or name amplitude in `series` too",
        ],
    );
    refused(
        &swept_chart("x = \"dt_nu\"\ny = \"p99_73\"\nseries = [\"amplitude\"]\nlimit = \"10 arcsec\""),
        "21:11",
        &["differ in filler (const, quadratic)", "where = { filler = \"const\" }"],
    );
    // Δt·ν differs from row to row, and the curve would still be a saw.
    let gaps = format!("[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"7 Hz\"]\n{GAPS}");
    refused(
        &with(&format!("{gaps}[chart]\nx = \"dt_nu\"\ny = \"rms\"")),
        "20:5",
        &["differ in switching.gap_ticks (1, 2)", "where = { gap_ticks = 1 }"],
    );
    let full = swept_chart("x = \"dt_nu\"\ny = \"rms\"\nseries = [\"filler\", \"error\"]");
    refused(&full, "21:21", &["filler = const, error = residual", "or make a chart for each"]);
    let charts = "x = \"frequency\"\ny = \"rms\"\nseries = [\"filler\", \"amplitude\"]";
    Desk::with(&swept_chart(charts)).done("run study.toml --device cpu --trials 100");
}

#[test]
fn curves_say_which_rows_they_are_about() {
    let desk = Desk::with(&with(&format!(
        "{GAPS}[chart]\nx = \"gap_ticks\"\ny = \"rms\"\nwhere = {{ error = \"extrapolation\" }}"
    )));
    desk.done("run study.toml --device cpu --trials 100");
    let svg = desk.read("results/study/chart.svg");
    for piece in ["error = extrapolation", ">lost ticks n<", ">1<", ">2<", ">3<"] {
        assert!(svg.contains(piece), "{piece} is missing in\n{svg}");
    }
    assert!(!svg.contains(">1.5<"), "a tick between counts:\n{svg}");
}

#[test]
fn several_studies_are_printed_with_a_blank_line_between_them() {
    let desk = Desk::with(STUDY);
    desk.write("other.toml", &replaced("A study", "Another"));
    let text = desk.done("run study.toml other.toml --device cpu --trials 1000").stdout;
    assert!(text.starts_with("A study · 1 point") && text.contains("\n\nAnother · 1 point"), "{text}");
}

#[test]
fn a_name_may_keep_more_than_its_last_part_and_a_dotted_key_stands_in_quotes() {
    let study = replaced(
        "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"",
        "gaussian = { rms = \"1000 arcsec/s\", band = [\"1 Hz\", \"60 Hz\"] }",
    );
    let sweep = "[[sweep]]\nkey = \"motion.gaussian.rms\"\nlist = [\"500 arcsec/s\", \"1000 arcsec/s\"]\n";
    for rows in ["", "where = { \"gaussian.rms\" = \"500 arcsec/s\" }"] {
        let desk = Desk::with(&format!("{study}{sweep}[chart]\nx = \"gaussian.rms\"\ny = \"rms\"\n{rows}\n"));
        desk.done("run study.toml --device cpu --trials 100");
    }
}
