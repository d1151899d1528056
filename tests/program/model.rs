//! `sagnac model` as a user meets it: bounds that an independent sum of closed forms confirms, within bands, and what is refused.

use crate::desk::{Desk, number};
use crate::logs::{desk_with, noise};
use serde_json::Value;

const NOISE: &str = "angle_random_walk = \"0.0003 deg/sqrt(h)\"\nbias_instability = \"0.009 deg/h\"\n\
                     rate_random_walk = \"0.0108 deg/h/sqrt(h)\"\n";

/// Allan deviation of a document's model in °/h, by the closed forms of theory.
fn deviation(model: &Value, tau: f64) -> f64 {
    let get = |value: &Value, key: &str| value[key].as_f64().unwrap_or_else(|| panic!("{key} in {value}"));
    let n = 60.0 * get(model, "white_deg_per_rt_h");
    let k = get(model, "random_walk_deg_per_h_per_rt_h") / 60.0;
    let q = get(model, "quantization_arcsec");
    let markov = model["markov"].as_array().unwrap().iter().map(|state| {
        let (sigma, z) = (get(state, "sigma_deg_per_h"), tau / get(state, "correlation_time_s"));
        // The bracket loses digits below, where the state is a random walk of density 2σ²/T.
        if z < 1e-3 {
            return 2.0 * sigma * sigma * z / 3.0;
        }
        2.0 * sigma * sigma / z * (1.0 - (3.0 - 4.0 * (-z).exp() + (-2.0 * z).exp()) / (2.0 * z))
    });
    (3.0 * q * q / (tau * tau) + n * n / tau + k * k * tau / 3.0 + markov.sum::<f64>()).sqrt()
}

/// The curve of [`NOISE`], °/h.
fn curve(tau: f64) -> f64 {
    let (n, b, k) = (0.0003_f64 * 60.0, 0.009_f64, 0.0108_f64 / 60.0);
    (n * n / tau + 2.0 * std::f64::consts::LN_2 / std::f64::consts::PI * b * b + k * k * tau / 3.0).sqrt()
}

/// The model of the first column.
fn json(desk: &Desk, words: &str) -> Value {
    let mut document: Value = serde_json::from_str(&desk.done(&format!("{words} --json")).stdout).unwrap();
    document["model"]["columns"][0].take()
}

/// Rates at 1 Hz of sums of twelve numbers with a walk, whose curve falls and rises.
fn rates(count: usize) -> String {
    let numbers: Vec<f64> = noise(24 * count).collect();
    let mut walk = 0.0;
    let rate = |chunk: &[f64]| {
        walk += 0.01 * chunk[12..].iter().sum::<f64>();
        format!("{}\n", chunk[..12].iter().sum::<f64>() + walk)
    };
    numbers.chunks(24).map(rate).collect()
}

const READ: &str = "--data rate --unit deg/h --rate 1Hz";

#[test]
fn the_bound_of_a_noise_file_is_nowhere_below_its_curve_and_says_how_far_above_it_lies() {
    let desk = desk_with("noise.toml", NOISE);
    let model = json(&desk, "model noise.toml --from 1s --to 10000s --overbound");
    let ratios = (0..=800).map(|i| {
        let tau = 10_f64.powf(f64::from(i) / 200.0);
        deviation(&model, tau) / curve(tau)
    });
    let ratios: Vec<f64> = ratios.collect();
    let (least, most) =
        (ratios.iter().copied().fold(9.0, f64::min), ratios.iter().copied().fold(0.0, f64::max));
    assert!(least > 1.0 - 1e-5, "the model is at {least} of the curve");
    let excess = model["largest_excess"].as_f64().unwrap();
    assert!((most - 1.0 - excess).abs() < 1e-3, "{most} times, not 1 + {excess}");
    assert!(excess < 0.2, "{excess} is above the margin");
    // A larger margin needs fewer states, and a single bound without states is far above.
    let states = |more: &str| {
        let model = json(&desk, &format!("model noise.toml --from 1s --to 10000s --overbound {more}"));
        (model["markov"].as_array().unwrap().len(), model["largest_excess"].as_f64().unwrap())
    };
    let usual = model["markov"].as_array().unwrap().len();
    let (wide, narrow, none) = (states("--margin 60"), states("--margin 5"), states("--states 0"));
    assert!(wide.0 < usual && usual < narrow.0 && narrow.1 < excess, "{wide:?}, {usual}, {narrow:?}");
    assert!(none.0 == 0 && none.1 > wide.1, "{none:?}");
}

#[test]
fn quantization_is_measurement_noise_or_covered_by_white_noise() {
    let desk = desk_with("noise.toml", format!("{NOISE}quantization = \"0.5 arcsec\"\n"));
    let with = |more: &str| {
        json(&desk, &format!("model noise.toml --from 1s --to 1000s --overbound --filter-rate 10Hz {more}"))
    };
    let (apart, white) = (with(""), with("--quantization white"));
    let total = |tau: f64| (curve(tau).powi(2) + 0.75 / (tau * tau)).sqrt();
    for i in 0..=60 {
        let tau = 10_f64.powf(f64::from(i) / 20.0);
        for model in [&apart, &white] {
            assert!(
                deviation(model, tau) > total(tau) * (1.0 - 1e-5),
                "τ = {tau}: {}",
                deviation(model, tau)
            );
        }
    }
    let n = |model: &Value| model["white_deg_per_rt_h"].as_f64().unwrap();
    assert!(n(&apart) < 0.00045 && n(&white) > 4.0 * n(&apart), "{} and {}", n(&apart), n(&white));
    let radians = 0.5 * std::f64::consts::PI / 648_000.0;
    let reading = apart["discrete"]["R"].as_f64().unwrap();
    assert!((reading / (radians * radians) - 1.0).abs() < 1e-9, "{reading}");
    assert_eq!(white["discrete"]["R"], 0.0);
}

#[test]
fn intervals_of_a_noise_file_are_bounded_too() {
    let with = format!(
        "# 95 % interval of N: 0.0002 to 0.0005 deg/sqrt(h)\n# Not identified: Q at most 1 arcsec; R.\n{NOISE}"
    );
    let desk = desk_with("noise.toml", with);
    let ended = desk.done("model noise.toml --from 1s --to 1000s --overbound");
    assert!(ended.stderr.contains("did not identify Q and R"), "{}", ended.stderr);
    let model = json(&desk, "model noise.toml --from 1s --to 1000s --overbound");
    let upper = |tau: f64| {
        // The variance of N alone is uncertain.
        (curve(tau).powi(2) + 3600.0 * (0.0005_f64.powi(2) - 0.0003_f64.powi(2)) / tau).sqrt()
    };
    for tau in [1.0, 10.0, 100.0, 1000.0] {
        assert!(deviation(&model, tau) > upper(tau) * (1.0 - 1e-5), "τ = {tau}");
    }
}

#[test]
fn a_log_is_described_within_its_band_and_bounded_above_it() {
    let desk = desk_with("gyro.csv", rates(20_000));
    let points = |words: &str| {
        desk.done(&format!("model gyro.csv {READ} {words} --out found"));
        desk.table("found/model.csv")
    };
    for row in points("") {
        let [lower, model, upper] = ["lower", "model", "upper"].map(|name| number(&row, name));
        assert!(lower * (1.0 - 1e-6) <= model && model <= upper * (1.0 + 1e-6), "{row:?}");
    }
    let bound = points("--overbound");
    assert!(bound.len() > 25 && number(bound.last().unwrap(), "tau_s") > 1900.0, "{} rows", bound.len());
    for row in &bound {
        assert!(number(row, "model") >= number(row, "upper") * (1.0 - 1e-6), "{row:?}");
    }
    let repeat = points("--overbound=repeat");
    for (row, before) in repeat.iter().zip(&bound) {
        assert!(number(row, "bound") > 1.0 * number(before, "upper"), "{row:?}");
        assert!(number(row, "model") >= number(row, "bound") * (1.0 - 1e-6), "{row:?}");
    }
    for name in ["report.html", "card.json", "model.svg", "model.png", "model.csv"] {
        assert!(desk.path(&format!("found/{name}")).exists(), "{name} is missing");
    }
    let svg = desk.read("found/model.svg");
    for piece in
        ["Rate noise for a filter, bounded", "95 % intervals", "parts of the model", "band of another record"]
    {
        assert!(svg.contains(piece), "{piece} is missing in the chart");
    }
}

#[test]
fn the_answer_names_the_parts_of_the_model_and_how_near_it_comes() {
    let desk = desk_with("gyro.csv", rates(20_000));
    let ended = desk.done(&format!("model gyro.csv {READ} --overbound"));
    let pieces = [" the record to ", "white noise N", "°/√h", "Excess", "above the 95 % band", "Band"];
    for piece in pieces {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let model = json(&desk, &format!("model gyro.csv {READ} --overbound --filter-rate 4Hz"));
    let discrete = &model["discrete"];
    let states = discrete["states"].as_array().unwrap().len();
    assert_eq!(discrete["F"].as_array().unwrap().len(), states);
    assert_eq!(discrete["step_s"], 0.25);
    // The walk adds K²Δ to itself.
    if discrete["states"][1] == "walk" {
        let k = model["random_walk_deg_per_h_per_rt_h"].as_f64().unwrap() / 60.0 * std::f64::consts::PI
            / 648_000.0;
        let added = discrete["Q"][1][1].as_f64().unwrap();
        assert!((added / (0.25 * k * k) - 1.0).abs() < 1e-9, "{added}");
    }
}

/// White noise at 1 Hz with a Gauss–Markov state of 30 s.
fn correlated(count: usize) -> Vec<f64> {
    let numbers: Vec<f64> = noise(24 * count).collect();
    let mut state = 0.0;
    let rate = |chunk: &[f64]| {
        state = (-1.0_f64 / 30.0).exp() * state + 0.05 * chunk[12..].iter().sum::<f64>();
        chunk[..12].iter().sum::<f64>() + state
    };
    numbers.chunks(24).map(rate).collect()
}

/// A log at 1 Hz of these columns.
fn log_of(columns: &[(&str, Vec<f64>)]) -> String {
    let names: Vec<String> = columns.iter().map(|(name, _)| format!("{name} [deg/h]")).collect();
    let row = |i: usize| columns.iter().map(|(_, rates)| rates[i].to_string()).collect::<Vec<_>>().join(",");
    let rows: String = (0..columns[0].1.len()).map(|i| row(i) + "\n").collect();
    format!("{}\n{rows}", names.join(","))
}

/// White noise that repeats no number of [`correlated`].
fn white(count: usize) -> Vec<f64> {
    noise(60 * count)
        .skip(48 * count)
        .collect::<Vec<_>>()
        .chunks(12)
        .map(|chunk| chunk.iter().sum())
        .collect()
}

#[test]
fn a_description_says_how_far_below_or_above_the_farthest_column_it_lies() {
    let desk = desk_with("two.csv", log_of(&[("gx", white(4000)), ("gy", correlated(4000))]));
    let words = "model two.csv --rate 1Hz --column all --out two";
    let document: Value = serde_json::from_str(&desk.done(&format!("{words} --json")).stdout).unwrap();
    let rows = desk.table("two/model.csv");
    let farthest = document["model"]["columns"].as_array().unwrap().iter().map(|model| {
        let name = model["column"].as_str().unwrap();
        let own = rows.iter().filter(|row| row["column"] == name);
        let off: Vec<f64> = own.map(|row| number(row, "model") / number(row, "record") - 1.0).collect();
        let [least, most] = [f64::min, f64::max].map(|of| off.iter().copied().reduce(of).unwrap());
        let [excess, shortfall] =
            ["largest_excess", "largest_shortfall"].map(|key| model[key].as_f64().unwrap());
        assert!(
            (excess - most).abs() < 1e-6 && (shortfall + least).abs() < 1e-6,
            "{least} to {most}: {model:#}"
        );
        // What its number of states reaches is the same number.
        let tried = model["tried"].as_array().unwrap().last().unwrap();
        assert_eq!(tried["largest_excess"].as_f64(), Some(excess), "{tried}");
        (name, if excess > shortfall { excess } else { -shortfall })
    });
    let (name, off) = farthest.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap();
    let headline = document["answer"]["headline"].as_str().unwrap();
    let side = if off < 0.0 { "below" } else { "above" };
    assert!(headline.contains(&format!(" {name}, up to ")) && headline.ends_with(side), "{headline}: {off}");
    let value = document["answer"]["value"]["value"].as_f64().unwrap();
    assert!((value - 100.0 * off).abs() < 1e-6, "{value}, not {off}");
    let text = desk.done(words).stdout;
    assert!(!text.contains("events removed"), "nothing was removed:\n{text}");
}

#[test]
fn n_of_a_description_is_within_the_interval_of_the_coefficient() {
    let desk = desk_with("gyro.csv", log_of(&[("gx", correlated(4000))]));
    let found = json(&desk, "model gyro.csv --rate 1Hz")["white_deg_per_rt_h"].as_f64().unwrap();
    desk.done("allan gyro.csv --rate 1Hz --bootstrap 200 --out fit");
    let rows = desk.table("fit/coefficients.csv");
    let n = crate::desk::row(&rows, &[("coefficient", "N")]);
    assert!(number(n, "lower") <= found && found <= number(n, "upper"), "{found}: {n:?}");
}

#[test]
fn the_model_of_a_noise_file_is_said_to_be_of_its_curve() {
    let desk = desk_with("noise.toml", NOISE);
    let text = desk.done("model noise.toml --from 1s --to 1000s").stdout;
    assert!(text.contains(" the curve, up to ") && !text.contains("record"), "{text}");
}

#[test]
fn columns_without_a_model_leave_the_others_theirs() {
    let wave = white(4000).iter().enumerate().map(|(i, y)| y + 30.0 * (0.081 * i as f64).sin()).collect();
    let desk = desk_with("two.csv", log_of(&[("gx", white(4000)), ("gy", wave)]));
    let words = "model two.csv --rate 1Hz --remove-outliers --column";
    let ended = desk.done(&format!("{words} gx,gy"));
    for piece in [" gx, up to ", "no model", "gy: no model with up to 3 Markov states"] {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let document: Value = serde_json::from_str(&desk.done(&format!("{words} gx,gy --json")).stdout).unwrap();
    assert_eq!(document["model"]["columns"].as_array().unwrap().len(), 1);
    assert_eq!(document["model"]["without_model"][0]["column"], "gy");
    desk.fails(&format!("{words} gy"), 3, &["no model with up to 3 Markov states"]);
}

#[test]
fn what_cannot_be_modelled_is_refused_with_what_to_do() {
    let desk = desk_with("noise.toml", NOISE);
    desk.write("gyro.csv", &rates(2000));
    desk.write("still.csv", &"1.5\n".repeat(2000));
    desk.write("broken.toml", "angle_random_wlak = \"1 deg/sqrt(h)\"\n");
    desk.fails("model noise.toml --overbound", 2, &["no averaging times of its own", "--from 1s"]);
    desk.fails("model noise.toml --from 100s --to 1s --overbound", 2, &["has to be the shorter one"]);
    desk.fails("model noise.toml --from 1s --to 100s --overbound=repeat", 2, &["give the log"]);
    desk.fails(
        "model broken.toml --from 1s --to 100s --overbound",
        3,
        &["angle_random_wlak", "did you mean"],
    );
    desk.fails(
        "model absent.toml --from 1s --to 100s --overbound",
        3,
        &["cannot read the noise absent.toml"],
    );
    desk.fails(
        &format!("model gyro.csv {READ} --overbound --to 5000s"),
        3,
        &["reaches from τ = 1 s", "--to"],
    );
    desk.fails(&format!("model gyro.csv {READ} --overbound --from 0.1s"), 3, &["reaches from τ = 1 s"]);
    desk.fails(&format!("model still.csv {READ} --overbound"), 3, &["constant"]);
    desk.fails(
        "model gyro.csv --data rate --unit none --rate 1Hz --overbound",
        2,
        &["plain numbers", "give their unit"],
    );
    desk.fails(
        &format!("model gyro.csv {READ} --overbound --write kalibre"),
        2,
        &["`kalibre` is not known", "kf_gins"],
    );
    desk.fails(&format!("model gyro.csv {READ} --overbound --states 4"), 2, &["0 to 3"]);
    desk.fails(&format!("model gyro.csv {READ} --overbound=both"), 2, &["band", "repeat"]);
    // A curve that no sum of these parts has: a sine much above the rest.
    desk.write("sine.toml", "sine = { amplitude = \"1 deg/h\", frequency = \"0.1 Hz\" }\n");
    let words = "model sine.toml --from 1s --to 1000s --margin 1";
    desk.fails(words, 3, &["no model with up to 3 Markov states lies within the band", "--overbound"]);
    let bound = json(&desk, "model sine.toml --from 1s --to 1000s --overbound");
    assert!(bound["largest_excess"].as_f64().unwrap() > 0.0);
}
