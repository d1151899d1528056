//! Which point and which fillers: of a study, or of options alone.

use serde_json::Value;

use super::fillers::{STUDY, SWEEPS, chosen, entry, names, near, swept, tables};
use crate::desk::{Desk, fact_of, number, row, rows_of, unwrapped};
use sagnac_base::quantity::number::significant;

#[test]
fn the_point_of_a_study_with_sweeps_is_the_one_asked_for_or_the_first_of_those_with_its_weights() {
    let desk = Desk::with(&swept());
    for at in ["--at motion.frequency=25Hz --at gap_ticks=2", "--at frequency=25 --at switching.gap_ticks=2"]
    {
        let json = tables(&desk, &format!("study.toml {at}"));
        let question = json["question"].as_str().unwrap();
        assert!(question.contains("gap of 2 lost ticks of 5 ms"), "{question}");
        assert!(question.contains("vibration frequency 25 Hz"), "{question}");
        near(&entry(&json, "quadratic", "residual")["weights"], &[-0.5, 1.5, 1.5, -0.5], 0.0);
    }
    let json = tables(&desk, "study.toml --at gap_ticks=3");
    assert!(json["question"].as_str().unwrap().contains("vibration frequency 20 Hz"), "{json:#}");
    near(&entry(&json, "quadratic", "residual")["amplitude_arcsec"], &[26.848], 5e-4);
    let shown = desk.done("filler study.toml --at gap_ticks=3").stdout;
    assert!(unwrapped(&shown).contains("vibration frequency 20 Hz is the first of its 2 values"), "{shown}");
    assert!(desk.read("results/study/filler/sagnac_filler.h").contains("Point: vibration frequency 20 Hz"));
}

#[test]
fn a_point_is_asked_for_where_weights_differ_and_by_the_keys_that_matter() {
    let desk = Desk::with(&swept());
    desk.fails("filler study.toml", 2, &["weights differ", "--at", "switching.gap_ticks = 1, 2, 3"]);
    let said = desk.sagnac("filler study.toml").stderr;
    assert!(!said.contains("frequency"), "{said}");
    // Designed from the study's own motion a filler depends on its frequency, and a band is one for all.
    let own = |more: &str| {
        let filler = format!(r#"{{ kind = "minimum-variance"{more} }}"#);
        let (before, after) = SWEEPS.split_once("[[sweep]]\nkey = \"switching").unwrap();
        assert!(after.contains("gap_ticks"));
        let text = STUDY.split_once("fillers = [").unwrap().0;
        Desk::with(&format!("{text}fillers = [{filler}]{before}"))
    };
    own("").fails("filler study.toml", 2, &["weights differ", "motion.frequency = 20 Hz, 25 Hz"]);
    own("").done("filler study.toml --at frequency=25Hz");
    let pieces =
        ["no point has motion.frequency = 21 Hz; the values are 20 Hz, 25 Hz", "add the value to the sweep"];
    own("").fails("filler study.toml --at frequency=21Hz", 2, &pieces);
    let banded = own(r#", band = ["18 Hz", "22 Hz"]"#);
    banded.done("filler study.toml");
    let pieces = ["the same at every motion.frequency: leave --at frequency=21Hz out"];
    banded.fails("filler study.toml --at frequency=21Hz", 2, &pieces);
}

#[test]
fn a_filler_is_chosen_by_its_name() {
    let desk = Desk::with(STUDY);
    let json = tables(&desk, "study.toml --filler mv8+2 --filler const");
    assert_eq!(names(&json), ["const", "mv8+2"]);
    let header = desk.read("results/study/filler/sagnac_filler.h");
    assert!(header.contains("sagnac_mv8_2 = {") && !header.contains("sagnac_linear"), "{header}");
}

#[test]
fn mistakes_are_told_with_what_is_there_and_leave_nothing_behind() {
    let desk = Desk::with(&swept());
    desk.fails("filler study.toml --filler cubic", 2, &["cubic", "it has const, linear, quadratic"]);
    let unswept = ["does not sweep `tick`", "it sweeps motion.frequency, switching.gap_ticks"];
    desk.fails("filler study.toml --at tick=5ms", 2, &unswept);
    let missed = ["no point has switching.gap_ticks = 4", "the values are 1, 2, 3"];
    desk.fails("filler study.toml --at gap_ticks=4", 2, &missed);
    desk.fails("filler study.toml --at gap_ticks", 2, &["give a key and a value"]);
    desk.fails("filler nowhere.toml", 3, &["cannot read the study nowhere.toml"]);
    desk.fails("filler", 2, &["<STUDY|FILLER>"]);
    desk.fails("filler study.toml study.toml", 2, &["is not a filler", "one study file", "minimum-variance"]);
    desk.fails("filler study.toml --gap-ticks 3", 2, &["--gap-ticks describes a filler without a study"]);
    desk.fails("filler study.toml --test-vectors 0", 2, &["--test-vectors"]);
    std::fs::write(desk.path("file"), "").unwrap();
    let file = "filler study.toml --at gap_ticks=3 --out file/folder";
    desk.fails(file, 6, &["cannot use the results folder", "file/folder"]);
    let invalid = STUDY.replace("gap_ticks = 3", "gap_ticks = 0");
    Desk::with(&invalid).fails("filler study.toml", 3, &["switching.gap_ticks", "study.toml:"]);
    let alone = Desk::with(STUDY);
    alone.fails("filler study.toml --at gap_ticks=3", 2, &["the study has only one point"]);
    alone.fails("filler study.toml --filler both --filler bth", 2, &["--filler bth"]);
    for desk in [desk, alone] {
        assert!(!desk.path("results").exists(), "something was left behind");
    }
}

#[test]
fn polynomials_need_no_study_and_no_tick() {
    let desk = Desk::with(STUDY);
    let json = tables(&desk, "quadratic --gap-ticks 3");
    assert_eq!(names(&json).len(), 1);
    assert!(json["question"].as_str().unwrap().ends_with("Weights for a gap of 3 lost ticks"));
    near(&entry(&json, "quadratic", "extrapolation")["weights"], &[6.35, -9.05, -6.95, 12.65], 1e-12);
    assert!(!desk.read("results/quadratic/filler/sagnac_filler.h").contains("T = "));
    assert!(desk.read("results/quadratic/filler/response.svg").contains("cycles per tick"));
    let of_5_ms = "linear const --gap-ticks 3 --tick 5ms --noise 1arcsec";
    let ticks = "--fit-ticks -3..0,n+1,n+2 --extrapolation-ticks=-1,0";
    let json = tables(&desk, &format!("{of_5_ms} {ticks}"));
    assert!(json["question"].as_str().unwrap().ends_with("Weights for a gap of 3 lost ticks of 5 ms"));
    let linear = entry(&json, "linear", "residual");
    assert_eq!(linear["ticks"], serde_json::json!([-3, -2, -1, 0, 4, 5]));
    // A line through two ticks: tick j is P₀ + j (P₀ − P₋₁), over three ticks −6 and 9.
    near(&entry(&json, "linear", "extrapolation")["weights"], &[-6.0, 9.0], 0.0);
    near(&entry(&json, "linear", "extrapolation")["rms_arcsec"], &[117_f64.sqrt()], 2e-3);
    assert!(desk.path("results/linear+const/filler/sagnac_filler.h").exists());
}

#[test]
fn minimum_variance_from_options_is_that_of_the_study_that_says_the_same() {
    let desk = Desk::with(STUDY);
    let said = tables(&desk, "study.toml");
    let said = entry(&said, "mv8+2", "residual");
    let words = "minimum-variance --gap-ticks 3 --fit-ticks=-7..0,n+1,n+2 --tick 5ms";
    let more = "--amplitude 12000arcsec/s --noise 0.5333333333333333arcsec";
    let of = |band: &str| tables(&desk, &format!("{words} {more} --band {band}"));
    let json = of("18Hz,22Hz");
    assert_eq!(entry(&json, "minimum-variance", "residual")["numerators"], said["numerators"]);
    // The table of theory: 8 + 2 ticks for 18–22 Hz, and for 20 Hz alone.
    near(&entry(&json, "minimum-variance", "residual")["rms_arcsec"], &[2.16], 5e-3);
    near(&entry(&of("20Hz"), "minimum-variance", "residual")["rms_arcsec"], &[1.13], 5e-3);
}

/// The 99.73 % level of the chosen ticks with four digits.
fn level_of(chosen: &Value) -> String {
    significant(chosen["p99_73_arcsec"].as_f64().unwrap(), 4)
}

#[test]
fn a_search_finds_the_ticks_for_a_limit_and_a_latency_and_shows_the_trade() {
    let desk = Desk::with(STUDY);
    let words = "minimum-variance --gap-ticks 3 --tick 5ms --band 18Hz,22Hz --amplitude 12000arcsec/s --noise 0.5arcsec";
    let found = tables(&desk, &format!("{words} --limit residual=8arcsec --latency 20ms"));
    let chosen = chosen(&found);
    assert_eq!(fact_of(&found, "caveat")["text"], "at worst with all frequencies up to 5 % lower or higher");
    let [before, after] = ["before", "after"].map(|key| chosen[key].as_i64().unwrap());
    let ticks: Vec<i64> = (1 - before..=0).chain(4..=3 + after).collect();
    let residual = entry(&found, "minimum-variance", "residual");
    assert_eq!(residual["ticks"], serde_json::json!(ticks));
    // What the search computes is the closed form of what it writes, and the judgement of the filler.
    near(&chosen["own_rms_arcsec"], &[residual["rms_arcsec"].as_f64().unwrap()], 1e-3);
    near(&chosen["rms_arcsec"], &[residual["shifted_rms_arcsec"].as_f64().unwrap()], 1e-6);
    assert!(chosen["p99_73_arcsec"].as_f64().unwrap() <= 8.0 && after <= 4, "{chosen:#}");
    let answer = &found["answer"];
    assert_eq!(answer["status"]["is"], "met");
    assert_eq!(answer["value"]["value"], chosen["p99_73_arcsec"]);
    assert!(answer["headline"].as_str().unwrap().ends_with("″ meets the 8″ limit, f ±5 %"), "{answer:#}");
    let folder = "results/minimum-variance/filler";
    // The chart's numbers are in the table, and the headline has the error that the limit is checked against.
    let trade = desk.table(&format!("{folder}/trade.csv"));
    let own = row(&trade, &[("before", &before.to_string()), ("after", &after.to_string())]);
    let level = level_of(chosen);
    assert_eq!(significant(number(own, "p99_73_arcsec"), 4), level);
    assert_eq!(trade.len(), rows_of(&found, "trade").len());
    let answer = found["answer"]["headline"].as_str().unwrap();
    assert_eq!(answer, format!("{before}+{after} ticks: {}″ meets the 8″ limit, f ±5 %", &level[..4]));
    assert!(desk.read(&format!("{folder}/report.html")).contains(answer));
    assert!(desk.read(&format!("{folder}/trade.svg")).contains("ticks before the gap"));
    let shown = desk.done(&format!("filler {words} --limit residual=0.001arcsec")).stdout;
    assert!(shown.contains("ticks before + after") && shown.contains("misses the 0.001″ limit"), "{shown}");
    // Without a search, the chart of an earlier one goes.
    desk.done(&format!("filler {words}"));
    for file in ["trade.svg", "trade.csv"] {
        assert!(!desk.path(&format!("{folder}/{file}")).exists(), "{file}");
    }
}

#[test]
fn the_level_of_a_search_is_that_of_sampled_errors() {
    let desk = Desk::with(STUDY);
    let words = "minimum-variance --gap-ticks 3 --tick 5ms --amplitude 12000arcsec/s --noise 0.5arcsec";
    for (band, frequency) in [("18Hz,22Hz", r#"["18 Hz", "22 Hz"]"#), ("20Hz", r#""20 Hz""#)] {
        let found = tables(&desk, &format!("{words} --band {band} --limit residual=8arcsec"));
        let chosen = chosen(&found);
        let ticks = entry(&found, "minimum-variance", "residual")["ticks"].take();
        let ticks: Vec<String> = ticks.as_array().unwrap().iter().map(|tick| format!("\"{tick}\"")).collect();
        let study = format!(
            "title = \"x\"\nkind = \"gap-fill\"\ntrials = 400000\n[gyro]\ntick = \"5 ms\"\ntick_noise = {{ std = \"0.5 arcsec\" }}\n\
             [motion]\namplitude = \"12000 arcsec/s\"\nfrequency = {frequency}\n[switching]\ngap_ticks = 3\n\
             errors = [\"residual\"]\nfillers = [{{ kind = \"minimum-variance\", fit_ticks = [{}] }}]\n",
            ticks.join(", ")
        );
        desk.write("sampled.toml", &study);
        desk.done("run sampled.toml --device cpu");
        let points = desk.table("results/sampled/points.csv");
        let [low, high] = ["p99_73_lo_arcsec", "p99_73_hi_arcsec"].map(|end| number(&points[0], end));
        let level = chosen["own_p99_73_arcsec"].as_f64().unwrap();
        // Half of the 95 % interval more, for one in 10,000.
        let room = 0.5 * (high - low);
        assert!((low - room..=high + room).contains(&level), "{band}: {level}, sampled {low} to {high}");
    }
}

#[test]
fn a_search_of_a_study_takes_its_recorded_motion_and_agrees_with_a_run_of_what_it_finds() {
    let rate = |i: u32| {
        let t = f64::from(i) * 1e-3;
        format!("{i}, {}\n", 2.0 * (110.0 * t).sin() + 1.5 * (67.0 * t + 0.3 * (5.0 * t).sin()).sin())
    };
    let record: String = (0..8000).map(rate).collect();
    let desk = Desk::with("");
    desk.write("base.csv", &format!("time [ms], rate [deg/s]\n{record}"));
    let study = |fillers: &str| {
        format!(
            "title = \"x\"\nkind = \"gap-fill\"\ntrials = 40000\n[gyro]\ntick = \"5 ms\"\ntick_noise = {{ std = \"0.5 arcsec\" }}\n\
             [motion]\nprofile = {{ file = \"base.csv\", position = \"every\" }}\n[switching]\ngap_ticks = 2\n\
             errors = [\"residual\"]\nfillers = [{fillers}]\n"
        )
    };
    desk.write("study.toml", &study("\"const\", \"quadratic\""));
    let found = tables(&desk, "study.toml --latency 20ms");
    let chosen = chosen(&found);
    let after = chosen["after"].as_i64().unwrap();
    assert!(after <= 4, "{chosen:#}");
    let name = format!("searched {}+{after}", chosen["before"]);
    let residual = entry(&found, &name, "residual");
    let ticks = residual["ticks"].as_array().unwrap().iter().map(|tick| format!("\"{tick}\""));
    let ticks = ticks.collect::<Vec<_>>().join(", ");
    desk.write("found.toml", &study(&format!("{{ kind = \"minimum-variance\", fit_ticks = [{ticks}] }}")));
    desk.done("run found.toml --device cpu");
    let points = desk.table("results/found/points.csv");
    let (rms, error) = (number(&points[0], "rms_arcsec"), number(&points[0], "rms_se_arcsec"));
    let exact = residual["rms_arcsec"].as_f64().unwrap();
    assert!((rms - exact).abs() < 5.0 * error, "{rms} ± {error}, {exact} by the search");
    desk.fails("filler study.toml --latency 20ms --filler const", 2, &["leave --filler out"]);
}

#[test]
fn a_header_on_whole_pulses_is_told_with_what_its_rounding_adds() {
    let pulses = STUDY.replace("[motion]", "readout_lsb = \"1.2 arcsec\"\n[motion]");
    assert!(pulses.contains("readout_lsb"), "{pulses}");
    let desk = Desk::with(&pulses);
    let shown = desk.full("filler study.toml --filler quadratic").stdout;
    let told = shown.split("given whole pulses, leaves ").nth(1).expect(&shown);
    let exported: f64 = told.split_once('″').unwrap().0.parse().unwrap();
    let json = tables(&desk, "study.toml --filler quadratic");
    let rms = entry(&json, "quadratic", "residual")["rms_arcsec"].as_f64().unwrap();
    // Rounding to one pulse has at most 1/√8 of it as rms, with two equally likely remainders; five digits are shown.
    let most = rms.hypot(1.2 / 8_f64.sqrt());
    assert!(exported > rms && exported < most * (1.0 + 1e-4), "{exported} of {rms}, at most {most}");
}

#[test]
fn a_filler_for_the_very_motion_is_told_with_its_error_beside_it() {
    let own = STUDY.replace("name = \"mv8+2\", band = [\"18 Hz\", \"22 Hz\"]", "name = \"mv8+2\"");
    let header = |text: &str| {
        let desk = Desk::with(text);
        desk.done("filler study.toml --filler mv8+2");
        desk.read("results/study/filler/sagnac_filler.h")
    };
    let own = header(&own);
    assert!(own.contains("at 99.73 %, with all frequencies up to 5 % lower or higher"), "{own}");
    let banded = header(STUDY);
    assert!(
        banded.contains("latency 2 ticks (10 ms); residual ") && !banded.contains("lower or higher"),
        "{banded}"
    );
}

#[test]
fn mistakes_in_options_are_told_in_terms_of_options() {
    let desk = Desk::with(STUDY);
    for (words, pieces) in [
        ("quadratic", &["--gap-ticks is missing", "--gap-ticks 3"][..]),
        ("quadratic --gap-ticks 65", &["--gap-ticks = 65", "1 … 64"]),
        ("quadratic --gap-ticks 3 --tick 5", &["--tick", "unit is missing"]),
        ("quadratic --gap-ticks 3 --noise 1Hz", &["--noise", "1Hz"]),
        ("quadratic --gap-ticks 3 --fit-ticks -1,0,2,5", &["--fit-ticks: tick 2 lies inside the gap"]),
        ("quadratic --gap-ticks 3 --fit-ticks -1,0", &["needs 3 ticks, --fit-ticks has 2"]),
        ("quadratic quadratic --gap-ticks 3", &["quadratic", "twice"]),
        ("cubic --gap-ticks 3", &["`cubic` is not a filler", "const, linear, quadratic, minimum-variance"]),
        ("const --gap-ticks 3 --at gap_ticks=3", &["--at", "none is given"]),
        ("minimum-variance --gap-ticks 3", &["--tick is missing"]),
        ("minimum-variance --gap-ticks 3 --tick 5ms --noise 1arcsec", &["--band is missing", "18 Hz,22 Hz"]),
        (
            "minimum-variance --gap-ticks 3 --tick 5ms --noise 1arcsec --amplitude 1deg/s --band 22Hz,18Hz",
            &["runs from 22 Hz down to 18 Hz"],
        ),
        ("quadratic --gap-ticks 3 --tick 5ms --limit residual=1arcsec", &["--band"]),
        (
            "quadratic --gap-ticks 3 --tick 5ms --amplitude 1deg/s --band 20Hz --limit residual=1arcsec",
            &["--limit searches the ticks of one filler, `minimum-variance`, not of `quadratic`"],
        ),
        (
            "minimum-variance --gap-ticks 3 --tick 5ms --noise 1arcsec --amplitude 1deg/s --band 20Hz --latency 1arcsec",
            &["--latency = 1arcsec", "an angle"],
        ),
    ] {
        desk.fails(&format!("filler {words}"), 2, pieces);
    }
    assert!(!desk.path("results").exists(), "something was left behind");
}
