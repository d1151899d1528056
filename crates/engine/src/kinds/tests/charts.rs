//! Kinds of charts, and laws: required keys, and reports of faults.

use crate::chart::{Chart, Law, Shows};
use crate::filler::Filler;
use crate::filler::read::Error;
use crate::key::sweep::Scale;
use crate::kinds::tests::{parsed, refused, with};

/// A study over frequency and gap ticks, with a chart of these lines from line 19 on.
fn chart(lines: &str) -> String {
    with(&format!(
        "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n[[sweep]]\n\
         key = \"switching.gap_ticks\"\nlist = [1, 2]\n[chart]\n{lines}\n"
    ))
}

fn only_chart(lines: &str) -> Chart {
    parsed(&chart(lines)).charts.remove(0)
}

const AXES: &str = "x = \"frequency\"\ny = \"gap_ticks\"\n";

#[test]
fn a_chart_is_curves_unless_it_says_otherwise() {
    for kind in ["", "kind = \"curves\"\n"] {
        let chart = only_chart(&format!("{kind}x = \"dt_nu\"\ny = \"rms\""));
        assert_eq!((chart.estimate().name.as_str(), chart.series()[0].name.as_str()), ("rms", "filler"));
        assert!(chart.references().is_empty());
    }
}

#[test]
fn a_map_shows_z_over_x_and_y_on_a_logarithmic_scale_unless_another_is_named() {
    let heat = |more: &str| only_chart(&format!("kind = \"heat-map\"\n{AXES}z = \"p99_73\"\n{more}"));
    let scale = |chart: &Chart| match &chart.shows {
        Shows::HeatMap { z_scale, .. } => Some(*z_scale),
        _ => None,
    };
    assert_eq!(heat("").estimate().name, "p99_73");
    assert_eq!(scale(&heat("")), Some(Scale::Log));
    assert_eq!(scale(&heat("z_scale = \"linear\"")), Some(Scale::Linear));
}

#[test]
fn fillers_compete_in_a_winner_map_unless_of_names_something_else() {
    let winners = |of: &str| only_chart(&format!("kind = \"winner-map\"\n{AXES}z = \"rms\"\n{of}"));
    assert_eq!(winners("").series()[0].name, "filler");
    assert_eq!(winners("").rows.len(), 1, "only residuals");
    assert_eq!(winners("of = \"error\"").rows, []);
    let gap = only_chart(
        "kind = \"winner-map\"\nx = \"frequency\"\ny = \"dt_nu\"\nz = \"rms\"\nof = \"gap_ticks\"",
    );
    assert_eq!(gap.series()[0].name, "switching.gap_ticks");
}

#[test]
fn an_axis_over_a_linear_sweep_is_linear_unless_another_scale_is_named() {
    let over = |sweep: &str, chart: &str| {
        let sweep = format!("[[sweep]]\nkey = \"motion.frequency\"\n{sweep}\n");
        let chart = parsed(&with(&format!("{sweep}{chart}"))).charts.remove(0);
        (chart.x_scale, chart.y_scale)
    };
    let [linear, log] =
        ["linear", "log"].map(|kind| format!("{kind} = {{ from = \"1 Hz\", to = \"9 Hz\", points = 3 }}"));
    for x in ["frequency", "motion.frequency_hz", "dt_nu"] {
        let chart = format!("[chart]\nx = \"{x}\"\ny = \"rms\"");
        assert_eq!(over(&linear, &chart), (Scale::Linear, Scale::Log), "{x}");
        assert_eq!(over(&log, &chart), (Scale::Log, Scale::Log), "{x}");
        assert_eq!(over(&linear, &format!("{chart}\nx_scale = \"log\"")).0, Scale::Log, "{x}");
    }
    assert_eq!(over(&linear, "").0, Scale::Linear, "the chart that is supplied");
    assert_eq!(over(&linear, "[chart]\nx = \"max\"\ny = \"frequency\""), (Scale::Log, Scale::Linear));
    let rates = "[[sweep]]\nkey = \"motion.rate\"\nlist = [\"0 deg/s\", \"1 deg/s\"]\n[chart]\nx = \"rate\"\ny = \"rms\"";
    assert_eq!(parsed(&with(rates)).charts[0].x_scale, Scale::Linear, "0 has no place on a logarithmic axis");
}

#[test]
fn an_axis_over_a_column_with_a_sign_is_linear_unless_another_scale_is_named() {
    let of = |y: &str| {
        let text = format!(
            "title = \"t\"\nkind = \"lock-in\"\n[gyro]\nscale_factor = \"2 arcsec/pulse\"\n[lock_in]\n\
             threshold = \"100 arcsec/s\"\n[dither]\nfrequency = \"400 Hz\"\nrate = \"4000 arcsec/s\"\n[record]\n\
             length = \"1 s\"\n[[sweep]]\nkey = \"input.rate\"\nlist = [\"1 arcsec/s\", \"2 arcsec/s\"]\n\
             [chart]\nx = \"input.rate\"\ny = \"{y}\"\n"
        );
        [parsed(&text), parsed(&format!("{text}y_scale = \"log\"\n"))].map(|study| study.charts[0].y_scale)
    };
    for y in ["mean_rate", "rate_error", "locked", "zone", "zone_centre_arcsec_per_s"] {
        assert_eq!(of(y), [Scale::Linear, Scale::Log], "{y}");
    }
    assert_eq!(of("angle_random_walk"), [Scale::Log, Scale::Log]);
}

#[test]
fn keys_of_another_kind_are_refused() {
    let heat = format!("kind = \"heat-map\"\n{AXES}z = \"rms\"\n");
    refused(
        &chart("kind = \"heatmap\""),
        &["a.toml:19:8", "unknown value \"heatmap\"", "did you mean `heat-map`?"],
    );
    refused(
        &chart(&format!("kind = \"heat-map\"\n{AXES}")),
        &["a.toml:19:8", "kind = \"heat-map\" needs z", "z = \"p99_73\""],
    );
    refused(
        &chart(&format!("{AXES}z = \"rms\"")),
        &["a.toml:21:5", "chart.z is not a key of a chart of kind = \"curves\"", "kind = \"winner-map\""],
    );
    refused(&chart(&format!("{AXES}of = \"filler\"")), &["a.toml:21:6", "chart.of", "kind = \"winner-map\""]);
    refused(&chart(&format!("{AXES}z_scale = \"log\"")), &["a.toml:21:11", "chart.z_scale"]);
    refused(&chart(&format!("{heat}series = [\"filler\"]")), &["a.toml:23:10", "chart.series", "\"curves\""]);
    refused(
        &chart(&format!("{heat}references = []")),
        &["a.toml:23:14", "chart.references", "kind = \"heat-map\""],
    );
    refused(&chart(&format!("{heat}of = \"error\"")), &["a.toml:23:6", "chart.of", "\"winner-map\""]);
    refused(&chart(&format!("{heat}z_scale = \"cubic\"")), &["a.toml:23:11", "\"cubic\"", "log, linear"]);
    refused(&chart(&format!("{AXES}z = 5")), &["a.toml:21:5", "`chart.z` is the number 5", "z = \"p99_73\""]);
}

#[test]
fn maps_span_what_is_swept_and_compare_what_rows_are_told_apart_by() {
    let map = |x: &str, y: &str, more: &str| {
        chart(&format!("kind = \"winner-map\"\nx = \"{x}\"\ny = \"{y}\"\nz = \"rms\"\n{more}"))
    };
    refused(
        &map("rms", "gap_ticks", ""),
        &["a.toml:20:5", "a map cannot have as its x `rms`", "neither swept nor dt_nu", "motion.frequency"],
    );
    refused(&map("frequency", "filler", ""), &["a.toml:21:5", "a map cannot have as its y `filler`"]);
    refused(
        &map("frequency", "gap_ticks", "of = \"rms\""),
        &["a.toml:23:6", "a winner map cannot compare by `rms`", "filler, error"],
    );
    refused(
        &map("frequency", "gap_ticks", "where = { filler = \"const\" }"),
        &["a.toml:23:11", "leaves one filler only", "name another column as `of`"],
    );
}

#[test]
fn laws_are_read_once_each_and_follow_what_is_swept() {
    let laws = |x: &str, laws: &str| chart(&format!("x = \"{x}\"\ny = \"rms\"\nlaws = [{laws}]"));
    let study = parsed(&laws("dt_nu", "\"noise\", \"taylor-extremum\""));
    assert_eq!(study.laws(), [Law::Noise, Law::TaylorExtremum]);
    assert_eq!(parsed(&laws("max", "")).laws(), []);
    refused(
        &laws("dt_nu", "\"taylor\""),
        &["a.toml:21:9", "unknown value \"taylor\"", "taylor-zero-crossing", "noise-as-published"],
    );
    refused(
        &laws("dt_nu", "\"noise\", \"noise\""),
        &["a.toml:21:18", "chart.references lists \"noise\" twice"],
    );
    refused(
        &laws("max", "\"noise\""),
        &[
            "a.toml:19:5",
            "reference curves cannot be drawn over `max`",
            "neither swept nor dt_nu",
            "motion.frequency",
        ],
    );
}

#[test]
fn laws_have_values_for_the_fillers_they_speak_of_only() {
    let study = parsed(crate::kinds::tests::BASE);
    let point = &crate::kinds::tests::points(&study)[0];
    let rounded = |law: Law, filler: &Filler| {
        let value = law.arcsec(&point.inputs, filler, Error::Residual, 4);
        value.map(|arcsec| (arcsec * 1000.0).round() / 1000.0)
    };
    let all = |law: Law| Filler::polynomials().iter().map(|filler| rounded(law, filler)).collect::<Vec<_>>();
    // Δt·ν = 0.2 at n = 3, A_Ω T = 60 ″, σ = 1 ″.
    assert_eq!(all(Law::TaylorExtremum), [Some(47.374), Some(47.374), Some(6.234)]);
    assert_eq!(all(Law::TaylorZeroCrossing), [None, Some(19.844), Some(19.844)]);
    assert_eq!(all(Law::NoiseAsPublished), [Some(2.598), None, None]);
    assert_eq!(all(Law::Noise), [Some(4.5), None, None]);
    let of = |law: Law| law.arcsec(&point.inputs, &Filler::polynomial(0), Error::Residual, 3);
    assert_eq!(of(Law::NoiseAsPublished), None, "the published law is about four ticks");
    assert!(of(Law::Noise).is_some_and(|noise| (noise - 9.0 / libm::sqrt(3.0)).abs() < 1e-12));
}
