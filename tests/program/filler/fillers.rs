//! The study that the fillers are of, and what the program says of them.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::desk::Desk;

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

/// The entry of a filler and an error in the JSON.
pub fn entry<'v>(json: &'v Value, filler: &str, error: &str) -> &'v Value {
    let named = |list: &'v Value, key: &str, name: &str| {
        let found = list.as_array().unwrap().iter().find(|entry| entry[key] == name);
        found.unwrap_or_else(|| panic!("no {name} in {list:#}"))
    };
    named(&named(&json["fillers"], "name", filler)["errors"], "error", error)
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
