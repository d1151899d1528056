//! A folder of its own for each test, and what `sagnac filler` leaves there.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

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

/// A folder with a study, to run the program in.
pub struct Desk(TempDir);

/// What a run left.
pub struct Ended {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Desk {
    pub fn with(text: &str) -> Desk {
        let desk = Desk(TempDir::new().unwrap());
        std::fs::write(desk.path("study.toml"), text).unwrap();
        desk
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn sagnac(&self, words: &[&str]) -> Ended {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sagnac"));
        let output = command.current_dir(self.0.path()).args(words).timeout(Duration::from_secs(60)).output();
        let output = output.unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        assert!(!stderr.contains("panicked"), "{words:?}:\n{stderr}");
        Ended { code: output.status.code(), stdout, stderr }
    }

    pub fn done(&self, words: &[&str]) -> Ended {
        let ended = self.sagnac(words);
        assert_eq!(ended.code, Some(0), "{words:?}\n{}", ended.stderr);
        ended
    }

    pub fn fails(&self, words: &[&str], code: i32, pieces: &[&str]) {
        let ended = self.sagnac(words);
        assert_eq!(ended.code, Some(code), "{words:?}\n{}", ended.stderr);
        assert_eq!(ended.stdout, "", "{words:?}");
        let said = ended.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        for piece in pieces {
            assert!(said.contains(piece), "`{piece}` is missing after {words:?}:\n{}", ended.stderr);
        }
    }

    pub fn json(&self, words: &[&str]) -> Value {
        serde_json::from_str(&self.done(words).stdout).unwrap()
    }

    pub fn rows(&self, name: &str) -> Vec<BTreeMap<String, String>> {
        csv::Reader::from_path(self.path(name)).unwrap().deserialize().map(Result::unwrap).collect()
    }
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
