//! Fillers for a specification: bands and lines, each with its own tolerance, apart from the motion that is sampled.

use super::fillers::{chosen, entry, near, tables};
use crate::desk::{Desk, number, row, rows_of};

/// A band of 30 to 80 Hz and a dither at 345 Hz, above half the tick rate, with the sampled motion `line` and `band`.
fn study(line: &str, band: &str, fillers: &str) -> String {
    format!(
        r#"title = "A band and a dither"
kind = "gap-fill"
trials = 400_000
[gyro]
tick = "2 ms"
tick_noise = {{ std = "0.2 arcsec" }}
[motion]
amplitude = "90 arcsec"
frequency = "{line}"
gaussian = {{ rms = "1000 arcsec/s", band = [{band}] }}
[specification]
lines = [{{ amplitude = "90 arcsec", frequency = "345 Hz", tolerance = "0.1 %" }}]
bands = [{{ rms = "1000 arcsec/s", band = ["30 Hz", "80 Hz"], tolerance = "5 %" }}]
[switching]
gap_ticks = 3
errors = ["residual"]
fillers = [{fillers}]
"#
    )
}

const NOMINAL: [&str; 2] = ["345 Hz", "\"30 Hz\", \"80 Hz\""];
const DESIGNED: &str =
    r#""const", { kind = "minimum-variance", name = "mv16+8", fit_ticks = ["-15..0", "n+1..n+8"] }"#;

#[test]
fn a_filler_for_a_band_and_a_dither_keeps_a_limit_within_their_tolerances() {
    let [line, band] = NOMINAL;
    let desk = Desk::with(&study(line, band, "\"const\""));
    let found = tables(&desk, "study.toml --limit residual=4arcsec");
    let search = chosen(&found);
    let chosen = |key: &str| search[key].as_f64().unwrap();
    assert_eq!(found["answer"]["status"]["is"], "met");
    assert_eq!(found["answer"]["table"]["columns"][3], "rms, within tolerance");
    assert!(
        chosen("p99_73_arcsec") <= 4.0 && chosen("own_p99_73_arcsec") < chosen("p99_73_arcsec"),
        "{search:#}"
    );
    let filler = &rows_of(&found, "fillers")[0];
    // That of the weights in whole numbers.
    near(&filler["shifted_p99_73_arcsec"], &[chosen("p99_73_arcsec")], 1e-4);
    assert_eq!(filler["latency_ticks"], search["after"]);
    // The closed form of what is sampled is that on the specification as given.
    let name = filler["filler"].as_str().unwrap();
    near(&entry(&found, name, "residual")["rms_arcsec"], &[chosen("own_rms_arcsec")], 1e-4);
    let header = desk.read("results/study/filler/sagnac_filler.h");
    assert!(header.contains(" as specified with its tolerances, and 0.2″ rms of noise"), "{header}");
    let expected =
        format!(" *     latency {} ticks ({} ms); residual ", chosen("after"), 2.0 * chosen("after"));
    let told = header.split(&expected).nth(1).expect(&header);
    assert!(
        told.lines().next().unwrap().ends_with("at 99.73 %, with all frequencies within their tolerances")
    );
}

/// The numbers for 16 + 8 ticks are those of `benches/filler_numpy.py`.
#[test]
fn a_run_has_the_residual_as_specified_and_no_sampled_one_within_the_tolerances_exceeds_it() {
    let mut rows = Vec::new();
    for (line, band) in [
        ("345 Hz", NOMINAL[1]),
        ("345.345 Hz", "\"28.5 Hz\", \"84 Hz\""),
        ("344.655 Hz", "\"31.5 Hz\", \"84 Hz\""),
    ] {
        let desk = Desk::with(&study(line, band, DESIGNED));
        desk.done("run study.toml --device cpu");
        let points = desk.table("results/study/points.csv");
        let own = row(&points, &[("filler", "mv16+8")]);
        assert!((number(own, "latency_s") - 0.016).abs() < 1e-12);
        let [rms, level] = ["specified_rms_arcsec", "specified_p99_73_arcsec"].map(|name| number(own, name));
        assert!(
            (rms / 0.766993224 - 1.0).abs() < 1e-5 && (level / 2.30042686 - 1.0).abs() < 1e-5,
            "{rms} {level}"
        );
        let [sampled, error] = ["rms_arcsec", "rms_se_arcsec"].map(|name| number(own, name));
        assert!(sampled < rms + 4.0 * error, "{line}: {sampled} ± {error}, {rms} as specified");
        assert!(number(own, "p99_73_lo_arcsec") < level, "{line}");
        rows.push((sampled - number(own, "theory_rms_arcsec")) / error);
        let other = row(&points, &[("filler", "const")]);
        assert!(
            (number(other, "latency_s") - 0.004).abs() < 1e-12
                && number(other, "specified_p99_73_arcsec") > 10.0
        );
    }
    assert!(rows.iter().all(|z| z.abs() < 4.0), "{rows:?}");
}

/// The motion that is sampled has no dither, so that it says nothing of what the specified one does to a parabola.
#[test]
fn a_run_decides_by_the_specification_whatever_is_sampled_and_drawn() {
    let [line, band] = NOMINAL;
    let fillers = r#""quadratic", { kind = "minimum-variance", name = "mv", fit_ticks = ["-18..0"] }"#;
    let text = study(line, band, fillers).replace("amplitude = \"90 arcsec\"\nfrequency = \"345 Hz\"\n", "");
    let text = text.replace("gap_ticks = 3", "gap_ticks = 2").replace("400_000", "20_000");
    let sampled =
        "[[sweep]]\nkey = \"gyro.tick\"\nlist = [\"2 ms\"]\n[[chart]]\nx = \"filler\"\ny = \"p99_73\"\n";
    let own = "limit = \"4 arcsec\"\n";
    for (limit, of_chart, charts, headline) in [
        ("4 arcsec", "", "", "mv misses the 4″ limit: 4.5″"),
        ("5 arcsec", "", "", "mv meets the 5″ limit: 4.5″"),
        ("4 arcsec", "", sampled, "mv misses the 4″ limit: 4.5″"),
        ("", own, sampled, "mv: 99.73 % error as specified 4.5″"),
    ] {
        let head = if limit.is_empty() { String::new() } else { format!("limit = \"{limit}\"\n") };
        let desk = Desk::with(&format!("{head}{text}{charts}{of_chart}"));
        let shown = desk.done("run study.toml --device cpu --quiet").stdout;
        assert_eq!(shown.trim_end(), headline, "{limit} {of_chart}");
    }
}

#[test]
fn the_limit_of_a_study_is_that_of_its_fillers_unless_another_one_is_asked_for() {
    let [line, band] = NOMINAL;
    let fillers = r#"{ kind = "minimum-variance", name = "mv", fit_ticks = ["-18..0"] }"#;
    let text = study(line, band, fillers).replace("gap_ticks = 3", "gap_ticks = 2");
    let desk = Desk::with(&format!("limit = \"4 arcsec\"\n{text}"));
    for (options, told, limit) in [
        ("", "mv: 4.5″ misses the 4″ limit, within tolerance", 4.0),
        ("--latency 4ms", "+0 ticks: 3.98″ meets the 4″ limit, within tolerance", 4.0),
        ("--limit residual=5arcsec", "meets the 5″ limit", 5.0),
    ] {
        let found = tables(&desk, &format!("study.toml {options}"));
        let headline = found["answer"]["headline"].as_str().unwrap();
        assert!(headline.contains(told), "{options}: {headline}");
        assert_eq!(found["answer"]["limit"]["value"], limit, "{options}");
        assert_eq!(found["tables"].get("trade").is_some(), !options.is_empty(), "{options}");
    }
    let (before, rest) = text.split_once("[specification]").unwrap();
    let own =
        format!("limit = \"4 arcsec\"\n{before}[switching]{}", rest.split_once("[switching]").unwrap().1);
    let own = own.replace("\"mv\"", "\"mv\", band = [\"30 Hz\", \"80 Hz\"]");
    let of_any_phase = tables(&Desk::with(&own), "study.toml");
    assert_eq!(of_any_phase["answer"]["status"]["is"], "not_met");
    // The level of a fixed phase has no closed form.
    let fixed = own.replace("[motion]\n", "[motion]\nphase = \"extremum\"\n");
    let found = tables(&Desk::with(&fixed), "study.toml");
    let facts = found["answer"]["facts"].as_array().unwrap();
    let caveat = facts.iter().find(|fact| fact["fact"] == "caveat").unwrap();
    assert_eq!(caveat["text"], "the limit is on the 99.73 % residual, which `sagnac run` samples");
    assert_eq!(found["answer"]["status"]["is"], "inconclusive");
}

/// A motion that no filler of the specification knows, read in pulses.
#[test]
fn whatever_moves_a_filler_is_given_with_its_errors_on_the_specification() {
    let [line, band] = NOMINAL;
    let text = study(line, band, DESIGNED).replace("[motion]", "readout_lsb = \"1 arcsec\"\n[motion]");
    let other = text.replace(
        "amplitude = \"90 arcsec\"\nfrequency = \"345 Hz\"",
        "amplitude = \"12000 arcsec/s\"\nfrequency = \"20 Hz\"",
    );
    assert_ne!(text, other);
    let of = |text: &str| {
        let desk = Desk::with(text);
        desk.done("filler study.toml");
        let files = ["sagnac_filler.h", "response.svg", "weights.csv"];
        files.map(|file| desk.read(&format!("results/study/filler/{file}")))
    };
    let (found, expected) = (of(&other), of(&text));
    assert_eq!(found, expected);
    let [header, chart, _] = found;
    for piece in ["line, 345 Hz", "band, 30 to 80 Hz"] {
        assert!(chart.contains(piece), "no `{piece}` in {chart}");
    }
    assert!(!chart.contains("the motion"), "{chart}");
    assert!(header.contains("″ at 99.73 %, with all frequencies"), "{header}");
}

#[test]
fn the_study_of_the_how_to_finds_what_it_says() {
    let page = include_str!("../../../docs/howto/pick-a-filler.md");
    let (study, rest) = page
        .split("```toml\n")
        .find(|text| text.starts_with("title = \"A filler for a band and a dither\""))
        .and_then(|text| text.split_once("```\n"))
        .expect("the how-to has the study");
    let command = rest.split_once("`sagnac ").and_then(|(_, rest)| rest.split_once('`')).unwrap().0;
    let told = rest.trim_start().split("\n\n").next().unwrap().replace('\n', " ");
    let found = tables(&Desk::with(study), "study.toml --latency 32ms");
    let search = chosen(&found);
    let chosen = |key: &str| search[key].as_f64().unwrap();
    let [before, after, level] = ["before", "after", "p99_73_arcsec"].map(chosen);
    assert_eq!(command, "filler mine.toml --latency \"32 ms\"");
    for piece in [
        format!("finds {before} ticks before the gap and {after} after it: {} ms after", 2.0 * after),
        format!("below {level:.3}″"),
    ] {
        assert!(told.contains(&piece), "no `{piece}` in `{told}`");
    }
}

#[test]
fn without_a_specification_a_table_has_no_columns_of_it() {
    let text = study(NOMINAL[0], NOMINAL[1], DESIGNED);
    let (before, rest) = text.split_once("[specification]").unwrap();
    let desk = Desk::with(&format!("{before}[switching]{}", rest.split_once("[switching]").unwrap().1));
    desk.done("run study.toml --device cpu --trials 1000");
    let head = desk.read("results/study/points.csv").lines().next().unwrap().to_owned();
    assert!(!head.contains("specified") && !head.contains("latency"), "{head}");
}

#[test]
fn specifications_that_make_no_sense_are_refused() {
    let text = study(NOMINAL[0], NOMINAL[1], DESIGNED);
    let (before, rest) = text.split_once("[specification]\n").unwrap();
    let after = rest.split_once("[switching]").unwrap().1;
    for (specification, pieces) in [
        ("", &["[specification] has no lines and no bands", "accepted: lines = ["][..]),
        ("lines = []", &["no lines and no bands"]),
        ("lines = [{ frequency = \"345 Hz\" }]", &["specification.lines.amplitude", "missing"]),
        (
            "lines = [{ amplitude = \"90 arcsec\", frequency = [\"1 Hz\", \"2 Hz\"] }]",
            &["specification.lines.frequency"],
        ),
        (
            "lines = [{ amplitude = \"90 arcsec\", frequency = \"345 Hz\", tolerance = 0.001 }]",
            &["specification.lines.tolerance", "not a percentage", "\"0.1 %\""],
        ),
        (
            "lines = [{ amplitude = \"90 arcsec\", frequency = \"345 Hz\", tolerance = \"60 %\" }]",
            &["specification.lines.tolerance = 60 % is out of range"],
        ),
        (
            "lines = [{ amplitude = \"90 arcsec\", frequency = \"4999 Hz\", tolerance = \"0.1 %\" }]",
            &["specification = 5003.999 Hz is too fast for a tick rate of 500 Hz", "5000 Hz here"],
        ),
        (
            "bands = [{ rms = \"1 deg/s\", band = [\"80 Hz\", \"30 Hz\"] }]",
            &["specification.bands.band runs from 80 Hz down to 30 Hz"],
        ),
        (
            "bands = [{ rms = \"1 deg/s\", band = [\"30 Hz\", \"31 Hz\"], tolerance = \"5 %\" }]",
            &["the ends of the band may cross within their tolerance", "a line instead"],
        ),
    ] {
        let desk = Desk::with(&format!("{before}[specification]\n{specification}\n[switching]{after}"));
        desk.fails("filler study.toml", 3, pieces);
    }
}
