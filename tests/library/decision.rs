//! Decision sheets: error budgets add up, and a lever does what the sheet says.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sagnac::analysis::decision::{Sheet, decide};
use sagnac::progress::Silent;
use sagnac::run::{Plan, Tables};
use sagnac::store::Store;
use sagnac::study::Study;
use sagnac::tally::Share;
use sagnac::verify::select;
use sagnac_base::quantity::Quantity;

fn tables(study: &Study) -> Tables {
    let plan = Plan::new(study).unwrap();
    let mut store = Store::in_memory(&plan.identity());
    let mut device = select("cpu", 2).unwrap().device;
    plan.run(&mut store, &mut device, Share::WHOLE, &Silent).unwrap();
    plan.tables(&store, &Silent).unwrap()
}

fn decided(text: &str) -> Sheet {
    let study =
        Study::parse("random.toml", text).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
    decide(&study, &tables(&study), &Silent).unwrap().unwrap()
}

/// A study with another value of a key.
fn with(text: &str, key: &str, to: Quantity) -> String {
    let name = key.rsplit('.').next().unwrap();
    let place = format!(" {name} = ");
    let start = text.find(&place).unwrap_or_else(|| panic!("{key} is not in\n{text}")) + place.len();
    let length = text[start..].find([' ', '\n'].as_slice()).unwrap();
    let value = match &text[start..=start] {
        "\"" => (2 + text[start + 1..].find('"').unwrap(), format!("\"{to}\"")),
        _ => (length, to.to_string()),
    };
    format!("{}{}{}", &text[..start], value.1, &text[start + value.0..])
}

/// A number between two others, evenly distributed in its logarithm.
fn between(rng: &mut StdRng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(rng.random::<f64>())
}

/// A run whose parts are independent and have the mean 0: a magnetic drift of random sign, a spread of the non-magnetic
/// one, a random walk, and the motion and noise behind the fillers.
fn run(rng: &mut StdRng) -> String {
    let [magnetic, spread, walk, noise, amplitude] =
        [(1.0, 10.0), (0.001, 0.05), (0.001, 0.02), (0.1, 1.0), (100.0, 3000.0)]
            .map(|(low, high)| between(rng, low, high));
    format!(
        r#"
        title = "Random run"
        kind = "switched-run"
        trials = 30_000
        seed = {seed}
        [drift]
        magnetic = "{magnetic} arcsec/s"
        warm_up_time = "3000 s"
        non_magnetic_spread = "{spread} arcsec/s"
        angle_random_walk = "{walk} deg/sqrt(h)"
        [gyro]
        tick = "5 ms"
        tick_noise = {{ std = "{noise} arcsec" }}
        [motion]
        amplitude = "{amplitude} arcsec/s"
        frequency = "7 Hz"
        [switching]
        interval = "30 s"
        first_mode = "random"
        gap_ticks = 2
        fillers = ["quadratic"]
        [run]
        duration = "15 min"
        "#,
        seed = rng.random_range(1..1000),
    )
}

/// A switch in motion and noise, with a constant angle of the relock.
fn switch(rng: &mut StdRng) -> String {
    let [noise, amplitude, frequency] =
        [(0.3, 2.0), (500.0, 10_000.0), (3.0, 30.0)].map(|(low, high)| between(rng, low, high));
    let relock = 2.0 * noise;
    format!(
        r#"
        title = "Random switch"
        kind = "gap-fill"
        trials = 100_000
        seed = {seed}
        [gyro]
        tick = "5 ms"
        tick_noise = {{ std = "{noise} arcsec" }}
        relock = ["{relock} arcsec"]
        [motion]
        amplitude = "{amplitude} arcsec/s"
        frequency = "{frequency} Hz"
        [switching]
        gap_ticks = 3
        fillers = ["const"]
        errors = ["residual"]
        "#,
        seed = rng.random_range(1..1000),
    )
}

#[test]
fn the_shares_of_independent_parts_add_up_to_one() {
    let mut rng = StdRng::seed_from_u64(23);
    for number in 0..20 {
        let text = if number % 2 == 0 { run(&mut rng) } else { switch(&mut rng) };
        let budget = decided(&text).budget;
        assert!(budget.len() >= 3, "{budget:?}");
        let sum: f64 = budget.iter().map(|part| part.share.value).sum();
        let variance: f64 = budget
            .iter()
            .filter_map(|part| part.share.interval)
            .map(|(low, high)| ((high - low) / (2.0 * 2.131_45)).powi(2))
            .sum();
        // Closed forms are exact for the rounded inputs, which are not the same without a part.
        let error = variance.sqrt().max(3e-5);
        assert!((sum - 1.0).abs() <= 3.0 * error, "study {number}: {sum} with {error}: {budget:?}\n{text}");
    }
}

#[test]
fn the_lever_applied_gains_and_meets_the_limit_as_said() {
    let mut rng = StdRng::seed_from_u64(7);
    for number in 0..6 {
        let text = if number % 2 == 0 { run(&mut rng) } else { switch(&mut rng) };
        let free = decided(&text);
        let limit = 0.8 * free.value.value;
        let text = format!("limit = \"{limit} {}\"\n{text}", free.unit.symbol.replace("°/h", "deg/h"));
        let sheet = decided(&text);
        assert_eq!(sheet.is_met(), Some(false));
        let lever = sheet.lever.unwrap_or_else(|| panic!("no lever in\n{text}"));
        let value = |to: Quantity| decided(&with(&text, lever.change.key, to)).value.value;
        let gain = 1.0 - value(lever.change.to) / sheet.value.value;
        let (low, high) = lever.gain.interval.unwrap_or((lever.gain.value, lever.gain.value));
        let spare = 0.01 + (high - low);
        assert!((low - spare..=high + spare).contains(&gain), "{gain} against {:?}\n{text}", lever.gain);
        for change in lever.meets.iter().filter(|change| change.key == lever.change.key) {
            let left = value(change.to) / limit;
            assert!((0.93..=1.03).contains(&left), "{left} of the limit at {}\n{text}", change.to);
        }
    }
}
