//! The study that the fillers are of, and what the program says of them.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::desk::{Desk, rows_of};

/// The paper's working point, with minimum variance and given weights beside the polynomials.
pub const STUDY: &str = r#"title = "Fillers /* of a \"gyro\" */ ??/"
kind = "gap-fill"
[gyro]
tick = "5 ms"
tick_noise = { three_sigma = "1.6 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[switching]
gap_ticks = 3
fillers = [
  "const", "linear", "quadratic",
  { kind = "minimum-variance", name = "mv8+2", band = ["18 Hz", "22 Hz"], fit_ticks = ["-7..0", "n+1", "n+2"] },
  { kind = "weights", name = "given", weights = [-1, "5/2", "5/2", -1] },
  { kind = "weights", name = "both", weights = ["3/4", "3/4", "3/4", "3/4"], extrapolation_weights = [0, 0, 0, 3] },
]
"#;

pub const SWEEPS: &str = r#"
[[sweep]]
key = "motion.frequency"
list = ["20 Hz", "25 Hz"]
[[sweep]]
key = "switching.gap_ticks"
list = [1, 2, 3]
"#;

/// STUDY with the polynomials alone, which suit any gap, and sweeps.
pub fn swept() -> String {
    let (before, rest) = STUDY.split_once("fillers = [").unwrap();
    let after = rest.split_once("\n]").unwrap().1;
    format!("{before}fillers = [\"const\", \"linear\", \"quadratic\"]{after}{SWEEPS}")
}

/// What `sagnac filler` prints as JSON for these words.
pub fn tables(desk: &Desk, words: &str) -> Value {
    serde_json::from_str(&desk.done(&format!("filler {words} --json")).stdout).unwrap()
}

/// The rows of a table.
pub fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

/// The names of the fillers in a document.
pub fn names(json: &Value) -> Vec<&str> {
    let residuals = rows_of(json, "fillers").iter().filter(|row| row["error"] == "residual");
    residuals.map(|row| row["filler"].as_str().unwrap()).collect()
}

/// What a document says of a filler and an error: its row, with `ticks`, `numerators` and `weights` of the whole gap, their
/// `denominator`, and the numerators `by_tick`, which are null where it has those of the sum alone.
pub fn entry(json: &Value, filler: &str, error: &str) -> Value {
    let own = |table: &str| -> Vec<&Value> {
        let is_own = |row: &&Value| row["filler"] == filler && row["error"] == error;
        rows_of(json, table).iter().filter(is_own).collect()
    };
    let mut entry = (*own("fillers").first().unwrap_or_else(|| panic!("no {filler} in {json:#}"))).clone();
    let weights = own("weights");
    let of = |row: &str| -> Vec<&Value> { weights.iter().copied().filter(|w| w["row"] == row).collect() };
    let column = |row: &str, name: &str| of(row).iter().map(|w| w[name].clone()).collect::<Value>();
    let sum = of("sum");
    let weight = |w: &&Value| w["numerator"].as_f64().unwrap() / w["denominator"].as_f64().unwrap();
    entry["ticks"] = column("sum", "tick");
    entry["numerators"] = column("sum", "numerator");
    entry["denominator"] = sum[0]["denominator"].clone();
    entry["weights"] = sum.iter().map(weight).collect();
    let by_tick = (1..).map(|j: u32| column(&j.to_string(), "numerator"));
    let by_tick: Vec<Value> =
        by_tick.take_while(|row| row.as_array().is_some_and(|row| !row.is_empty())).collect();
    entry["by_tick"] = if by_tick.is_empty() { Value::Null } else { by_tick.into() };
    entry
}

/// The candidate of a search whose ticks the first filler reads.
pub fn chosen(json: &Value) -> &Value {
    let ticks = entry(json, names(json)[0], "residual")["ticks"].take();
    let (before, after): (Vec<i64>, Vec<i64>) =
        ticks.as_array().unwrap().iter().map(|tick| tick.as_i64().unwrap()).partition(|tick| *tick <= 0);
    let is_it = |row: &&Value| row["before"] == before.len() && row["after"] == after.len();
    rows_of(json, "trade").iter().find(is_it).unwrap()
}

#[track_caller]
pub fn near(found: &Value, expected: &[f64], tolerance: f64) {
    let found: Vec<f64> = match found {
        Value::Array(list) => list.iter().map(|x| x.as_f64().unwrap()).collect(),
        number => vec![number.as_f64().unwrap()],
    };
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (x, y) in found.iter().zip(expected) {
        assert!((x - y).abs() <= tolerance, "{found:?}, not {expected:?}");
    }
}
