//! Which rows the curves of a chart are about.

use crate::desk::{Desk, STUDY, refused, replaced, swept_chart, with};

const GAPS: &str = "[[sweep]]\nkey = \"switching.gap_ticks\"\nlist = [1, 2, 3]\n";

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
