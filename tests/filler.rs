//! `sagnac filler` as a user meets it: the weights of theory, the files, the C header against the test vectors.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Stdio};
use std::time::Duration;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

/// The paper's working point, with minimum variance and given weights beside the polynomials.
const STUDY: &str = r#"title = "Fillers /* of a \"gyro\" */ ??/"
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

const SWEEPS: &str = r#"
[[sweep]]
key = "motion.frequency"
list = ["20 Hz", "25 Hz"]
[[sweep]]
key = "switching.gap_ticks"
list = [1, 2, 3]
"#;

/// STUDY with the polynomials alone, which suit any gap, and sweeps.
fn swept() -> String {
    let (before, rest) = STUDY.split_once("fillers = [").unwrap();
    let after = rest.split_once("\n]").unwrap().1;
    format!("{before}fillers = [\"const\", \"linear\", \"quadratic\"]{after}{SWEEPS}")
}

struct Desk(TempDir);

struct Ended {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Desk {
    fn with(text: &str) -> Desk {
        let desk = Desk(TempDir::new().unwrap());
        std::fs::write(desk.path("study.toml"), text).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn sagnac(&self, words: &[&str]) -> Ended {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sagnac"));
        let output = command.current_dir(self.0.path()).args(words).timeout(Duration::from_secs(60)).output();
        let output = output.unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        assert!(!stderr.contains("panicked"), "{words:?}:\n{stderr}");
        Ended { code: output.status.code(), stdout, stderr }
    }

    fn done(&self, words: &[&str]) -> Ended {
        let ended = self.sagnac(words);
        assert_eq!(ended.code, Some(0), "{words:?}\n{}", ended.stderr);
        ended
    }

    fn fails(&self, words: &[&str], code: i32, pieces: &[&str]) {
        let ended = self.sagnac(words);
        assert_eq!(ended.code, Some(code), "{words:?}\n{}", ended.stderr);
        assert_eq!(ended.stdout, "", "{words:?}");
        let said = ended.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        for piece in pieces {
            assert!(said.contains(piece), "`{piece}` is missing after {words:?}:\n{}", ended.stderr);
        }
    }

    fn json(&self, words: &[&str]) -> Value {
        serde_json::from_str(&self.done(words).stdout).unwrap()
    }

    fn rows(&self, name: &str) -> Vec<BTreeMap<String, String>> {
        csv::Reader::from_path(self.path(name)).unwrap().deserialize().map(Result::unwrap).collect()
    }
}

/// The entry of a filler and an error in the JSON.
fn entry<'v>(json: &'v Value, filler: &str, error: &str) -> &'v Value {
    let named = |list: &'v Value, key: &str, name: &str| {
        let found = list.as_array().unwrap().iter().find(|entry| entry[key] == name);
        found.unwrap_or_else(|| panic!("no {name} in {list:#}"))
    };
    named(&named(&json["fillers"], "name", filler)["errors"], "error", error)
}

#[track_caller]
fn near(found: &Value, expected: &[f64], tolerance: f64) {
    let found: Vec<f64> = match found {
        Value::Array(list) => list.iter().map(|x| x.as_f64().unwrap()).collect(),
        number => vec![number.as_f64().unwrap()],
    };
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (x, y) in found.iter().zip(expected) {
        assert!((x - y).abs() <= tolerance, "{found:?}, not {expected:?}");
    }
}

#[test]
fn weights_gains_and_amplitudes_are_those_of_theory() {
    let desk = Desk::with(STUDY);
    let json = desk.json(&["filler", "study.toml", "--json"]);
    assert_eq!((&json["gap_ticks"], &json["tick_s"]), (&Value::from(3), &Value::from(0.005)));
    let quadratic = entry(&json, "quadratic", "residual");
    assert_eq!(quadratic["ticks"], serde_json::json!([-1, 0, 4, 5]));
    near(&quadratic["weights"], &[-1.0, 2.5, 2.5, -1.0], 0.0);
    near(&quadratic["noise_gain"], &[3.808], 5e-4);
    near(&quadratic["largest_gain"], &[7.0], 1e-12);
    near(&quadratic["amplitude_arcsec"], &[26.848], 5e-4);
    // The amplitude over the root of 2, and 1.6/3 ″ of noise 3.808 times.
    near(&quadratic["rms_arcsec"], &[19.0926], 2e-3);
    let extrapolation = entry(&json, "quadratic", "extrapolation");
    near(&extrapolation["weights"], &[6.35, -9.05, -6.95, 12.65], 1e-12);
    near(&extrapolation["noise_gain"], &[18.181], 5e-4);
    near(&extrapolation["amplitude_arcsec"], &[260.4], 0.05);
    let linear = entry(&json, "linear", "extrapolation");
    near(&linear["weights"], &[-2.4, -0.3, 1.8, 3.9], 1e-12);
    near(&entry(&json, "const", "residual")["amplitude_arcsec"], &[154.511], 5e-4);
    let best = entry(&json, "mv8+2", "residual");
    assert_eq!(best["ticks"].as_array().unwrap().len(), 10);
    assert_eq!(entry(&json, "given", "residual")["by_tick"], Value::Null);
}

#[test]
fn rows_by_tick_are_the_polynomial_at_each_lost_tick_and_sum_to_1() {
    let desk = Desk::with(STUDY);
    let json = desk.json(&["filler", "study.toml", "--json"]);
    // Numerators by hand: a line through ticks −3 … 0 has the value Σ (¼ + (j + 1.5)(k + 1.5)/5) P_k at tick j.
    let linear = entry(&json, "linear", "extrapolation");
    let denominator = linear["denominator"].as_f64().unwrap();
    for j in 1..=3 {
        let expected: Vec<f64> = (-3..=0)
            .map(|k| denominator * (0.25 + (f64::from(j) + 1.5) * (f64::from(k) + 1.5) / 5.0))
            .collect();
        near(&linear["by_tick"][j as usize - 1], &expected, 1e-9);
    }
    for filler in ["const", "linear", "quadratic", "mv8+2"] {
        for error in ["residual", "extrapolation"] {
            let entry = entry(&json, filler, error);
            for row in entry["by_tick"].as_array().unwrap() {
                let sum: i64 = row.as_array().unwrap().iter().map(|w| w.as_i64().unwrap()).sum();
                assert_eq!(Some(sum), entry["denominator"].as_i64(), "{filler}, {error}");
            }
        }
    }
}

#[test]
fn the_terminal_shows_exact_fractions_and_says_what_a_filler_does_not_give() {
    let desk = Desk::with(STUDY);
    let ended = desk.done(&["filler", "study.toml"]);
    for piece in [
        "n = 3 lost ticks of 5 ms",
        "sum  −1  5/2  5/2  −1",
        "127/20",
        "√Σw² = 3.8079",
        "√Σw² = 18.181",
        "amplitude 26.848 ″ at 20 Hz and 12000 ″/s, rms with noise 19.09",
        "× 2^24",
        "it gives the sum over the gap alone",
        "it has no extrapolation",
    ] {
        let said = ended.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
        let piece = piece.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains(&piece), "{piece} is missing:\n{}", ended.stdout);
    }
    assert!(ended.stderr.contains("results/study/filler"), "{}", ended.stderr);
    assert!(!ended.stderr.contains("point 1 of"), "{}", ended.stderr);
}

#[test]
fn the_point_of_a_study_with_sweeps_is_its_first_or_the_one_asked_for() {
    let desk = Desk::with(&swept());
    let first = desk.done(&["filler", "study.toml"]);
    let said = "point 1 of 6: motion.frequency = 20 Hz, switching.gap_ticks = 1";
    assert!(first.stderr.contains(said), "{}", first.stderr);
    for at in [["motion.frequency=25 Hz", "gap_ticks=2"], ["frequency=25", "switching.gap_ticks=2"]] {
        let json = desk.json(&["filler", "study.toml", "--at", at[0], "--at", at[1], "--json"]);
        assert_eq!(json["gap_ticks"], 2);
        assert_eq!(json["at"]["motion.frequency"], "25 Hz");
        near(&entry(&json, "quadratic", "residual")["weights"], &[-0.5, 1.5, 1.5, -0.5], 0.0);
    }
    let json = desk.json(&["filler", "study.toml", "--at", "gap_ticks=3", "--json"]);
    assert_eq!(json["at"]["motion.frequency"], "20 Hz");
    near(&entry(&json, "quadratic", "residual")["amplitude_arcsec"], &[26.848], 5e-4);
}

#[test]
fn mistakes_are_told_with_what_is_there_and_leave_nothing_behind() {
    let desk = Desk::with(&swept());
    let study = "study.toml";
    desk.fails(&["filler", study, "--filler", "cubic"], 2, &["cubic", "it has const, linear, quadratic"]);
    desk.fails(
        &["filler", study, "--at", "tick=5 ms"],
        2,
        &["does not sweep `tick`", "it sweeps motion.frequency, switching.gap_ticks"],
    );
    desk.fails(
        &["filler", study, "--at", "gap_ticks=4"],
        2,
        &["no point has switching.gap_ticks = 4", "there are 1, 2, 3"],
    );
    desk.fails(&["filler", study, "--at", "gap_ticks"], 2, &["give a key and a value"]);
    desk.fails(&["filler", "nowhere.toml"], 3, &["cannot read the study nowhere.toml"]);
    desk.fails(&["filler"], 2, &["<STUDY>"]);
    desk.fails(&["filler", study, "--gap-ticks", "3"], 2, &["cannot be used with"]);
    desk.fails(&["filler", "--gap-ticks", "3"], 2, &["--tick"]);
    desk.fails(
        &["filler", "--gap-ticks", "65", "--tick", "5 ms"],
        2,
        &["switching.gap_ticks = 65", "1 … 64"],
    );
    desk.fails(&["filler", "--gap-ticks", "3", "--tick", "5"], 2, &["unit is missing"]);
    let inside = ["filler", "--gap-ticks", "3", "--tick", "5 ms", "--fit-ticks", "-1,0,2,5"];
    desk.fails(&inside, 2, &["tick 2 lies inside the gap"]);
    desk.fails(&["filler", study, "--test-vectors", "0"], 2, &["--test-vectors"]);
    assert!(!desk.path("results").exists(), "something was left behind");
    std::fs::write(desk.path("file"), "").unwrap();
    desk.fails(&["filler", study, "--out", "file/folder"], 6, &["cannot write", "file/folder"]);
    let alone = Desk::with(STUDY);
    alone.fails(&["filler", study, "--at", "gap_ticks=3"], 2, &["the study has one point"]);
    alone.fails(&["filler", study, "--filler", "both", "--filler", "bth"], 2, &["--filler bth"]);
}

#[test]
fn a_point_that_cannot_be_sampled_has_weights_but_no_rms() {
    let desk = Desk::with(&STUDY.replace("1.6 arcsec", "1e-9 arcsec"));
    let words = ["filler", "study.toml", "--filler", "quadratic"];
    let ended = desk.done(&words);
    assert!(ended.stdout.contains("no rms: gyro.tick_noise"), "{}", ended.stdout);
    let json = desk.json(&[&words[..], &["--json"]].concat());
    assert_eq!(entry(&json, "quadratic", "residual")["rms_arcsec"], Value::Null);
}

#[test]
fn polynomials_need_no_study() {
    let desk = Desk::with(STUDY);
    let words = ["filler", "--gap-ticks", "3", "--tick", "5 ms", "--order", "quadratic", "--json"];
    let json = desk.json(&words);
    assert_eq!(json["fillers"].as_array().unwrap().len(), 1);
    near(&entry(&json, "quadratic", "extrapolation")["weights"], &[6.35, -9.05, -6.95, 12.65], 1e-12);
    assert!(desk.path("results/filler/sagnac_filler.h").exists());
    let more = ["--fit-ticks", "-3..0, n+1,n+2", "--extrapolation-ticks", "-1,0", "--order", "linear"];
    let json = desk.json(&[&words[..5], &more[..], &["--json"]].concat());
    let linear = entry(&json, "linear", "residual");
    assert_eq!(linear["ticks"], serde_json::json!([-3, -2, -1, 0, 4, 5]));
    // A line through two ticks: tick j is P₀ + j (P₀ − P₋₁), over three ticks −6 and 9.
    near(&entry(&json, "linear", "extrapolation")["weights"], &[-6.0, 9.0], 0.0);
}

#[test]
fn every_weight_has_a_row_in_weights_csv() {
    let desk = Desk::with(STUDY);
    desk.done(&["filler", "study.toml", "--out", "out"]);
    let rows = desk.rows("out/weights.csv");
    let of = |filler: &str, error: &str, row: &str| -> Vec<f64> {
        let wanted =
            |r: &&BTreeMap<String, String>| r["filler"] == filler && r["error"] == error && r["row"] == row;
        rows.iter().filter(wanted).map(|r| r["weight"].parse().unwrap()).collect()
    };
    assert_eq!(of("quadratic", "residual", "sum"), [-1.0, 2.5, 2.5, -1.0]);
    assert_eq!(of("const", "residual", "2"), [0.25; 4]);
    assert_eq!(of("mv8+2", "residual", "1").len(), 10);
    assert_eq!(of("given", "residual", "sum"), [-1.0, 2.5, 2.5, -1.0]);
    assert_eq!((of("given", "residual", "1").len(), of("given", "extrapolation", "sum").len()), (0, 0));
    for row in &rows {
        let [numerator, denominator, weight]: [f64; 3] =
            ["numerator", "denominator", "weight"].map(|column| row[column].parse().unwrap());
        assert_eq!(numerator / denominator, weight, "{row:?}");
    }
    assert!(desk.read("out/response.svg").contains("quadratic"));
    assert_eq!(&std::fs::read(desk.path("out/response.png")).unwrap()[1..4], b"PNG");
}

#[test]
fn test_vectors_hold_extremes_and_are_the_same_every_time() {
    let desk = Desk::with(STUDY);
    let words = ["filler", "study.toml", "--test-vectors", "200", "--out"];
    desk.done(&[&words[..], &["one"]].concat());
    desk.done(&[&words[..], &["two"]].concat());
    assert_eq!(desk.read("one/test_vectors.csv"), desk.read("two/test_vectors.csv"));
    assert_eq!(desk.read("one/sagnac_filler.h"), desk.read("two/sagnac_filler.h"));
    let rows = desk.rows("one/test_vectors.csv");
    assert_eq!(rows.len(), 200 * 6);
    let number = |row: &BTreeMap<String, String>, column: &str| row[column].parse::<i64>().unwrap();
    let inputs = |row: &BTreeMap<String, String>| -> Vec<i64> {
        row.iter().filter(|(column, _)| column.starts_with("P[")).map(|(_, x)| x.parse().unwrap()).collect()
    };
    let largest = rows.iter().flat_map(&inputs).max().unwrap();
    assert!(rows.iter().any(|row| inputs(row).iter().all(|x| *x == 0)));
    let mut constants = 0;
    for row in &rows {
        let all = inputs(row);
        if row["filler"] == "given" {
            assert_eq!((&*row["E[1]"], &*row["sum_E"], &*row["I[1]"], &*row["dP"]), ("", "", "", ""));
            assert!(!row["sum_I"].is_empty());
            continue;
        }
        assert_eq!(number(row, "dP"), number(row, "sum_E") - number(row, "sum_I"), "{row:?}");
        if all.iter().all(|x| *x == all[0]) {
            // Every filler is exact at a constant rate.
            assert_eq!((number(row, "dP"), number(row, "sum_I")), (0, 3 * all[0]), "{row:?}");
            constants += usize::from(all[0].abs() == largest);
        }
    }
    assert!(constants >= 2 && largest > 1 << 28, "{constants}, {largest}");
}

#[test]
fn the_c_header_gives_the_test_vectors_bit_for_bit() {
    if Process::new("cc").arg("--version").output().is_err() {
        eprintln!("skipped: there is no C compiler `cc` to compile the header with");
        return;
    }
    for (text, at) in
        [(STUDY.to_owned(), None), (swept(), Some("gap_ticks=1")), (swept(), Some("gap_ticks=2"))]
    {
        let desk = Desk::with(&text);
        let mut words = vec!["filler", "study.toml", "--test-vectors", "3000", "--out", "out"];
        words.extend(at.iter().flat_map(|at| ["--at", at]));
        desk.done(&words);
        let rows = desk.rows("out/test_vectors.csv");
        let header = desk.read("out/sagnac_filler.h");
        for filler in ["const", "quadratic", "mv8+2", "given", "both"] {
            let own: Vec<_> = rows.iter().filter(|row| row["filler"] == filler).collect();
            if !own.is_empty() {
                compare(&desk.path("out"), &header, filler, &own);
            }
        }
    }
}

/// A program that reads the ticks of a filler, before and around the gap, and prints all that the header computes.
const PROGRAM: &str = r#"
#include <inttypes.h>
#include <stdio.h>
#include "sagnac_filler.h"

static int read_all(const sagnac_rule *rule, int32_t *p)
{
    for (int32_t k = 0; k < rule->count; k++) {
        if (scanf("%" SCNd32, &p[k]) != 1) {
            return 0;
        }
    }
    return 1;
}

int main(void)
{
    const sagnac_filler *f = &FILLER;
    int32_t p[128], q[128];
    int64_t e[SAGNAC_GAP_TICKS], i[SAGNAC_GAP_TICKS];
    while (read_all(&f->interpolation, q) && read_all(&f->extrapolation, p)) {
        int64_t sum_e = sagnac_fill(&f->extrapolation, p, e);
        int64_t sum_i = sagnac_fill(&f->interpolation, q, i);
        for (int32_t j = 0; j < f->extrapolation.rows; j++) {
            printf("%" PRId64 " ", e[j]);
        }
        for (int32_t j = 0; j < f->interpolation.rows; j++) {
            printf("%" PRId64 " ", i[j]);
        }
        printf("%" PRId64 " %" PRId64 " %" PRId64 "\n", sum_e, sum_i, sagnac_correction(sum_e, sum_i));
    }
    return 0;
}
"#;

/// The numbers between the braces of a list of ticks in the header.
fn ticks(header: &str, filler: &str, part: &str) -> Vec<String> {
    let plain = filler.replace(['+', ' '], "_");
    let name = format!("sagnac_{plain}_{part}_ticks[");
    let Some((_, rest)) = header.split_once(&name) else { return vec![] };
    let list = rest.split_once("{ ").unwrap().1.split_once(" }").unwrap().0;
    list.split(", ").map(str::to_owned).collect()
}

fn compare(folder: &Path, header: &str, filler: &str, rows: &[&BTreeMap<String, String>]) {
    std::fs::write(folder.join("main.c"), PROGRAM).unwrap();
    let define = format!("-DFILLER=sagnac_{}", filler.replace('+', "_"));
    let compiled = Process::new("cc")
        .current_dir(folder)
        .args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", &define, "main.c", "-o", "main"])
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{filler}:\n{}", String::from_utf8_lossy(&compiled.stderr));
    let read = [ticks(header, filler, "interpolation"), ticks(header, filler, "extrapolation")].concat();
    let mut input = String::new();
    for row in rows {
        let values: Vec<&str> = read.iter().map(|tick| &*row[&format!("P[{tick}]")]).collect();
        input += &(values.join(" ") + "\n");
    }
    let mut child =
        Process::new(folder.join("main")).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    let found = String::from_utf8(output.stdout).unwrap();
    assert_eq!(found.lines().count(), rows.len(), "{filler}");
    for (line, row) in found.lines().zip(rows) {
        let numbered = |name: &str| -> Vec<String> {
            let by_tick: Vec<String> = (1..)
                .map_while(|j| row.get(&format!("{name}[{j}]")))
                .filter(|x| !x.is_empty())
                .cloned()
                .collect();
            let sum = row[&format!("sum_{name}")].clone();
            // A rule with one row has the sum in its place.
            if by_tick.is_empty() && !sum.is_empty() { vec![sum] } else { by_tick }
        };
        let or_0 = |text: &str| if text.is_empty() { "0".to_owned() } else { text.to_owned() };
        let (e, i) = (or_0(&row["sum_E"]), row["sum_I"].clone());
        let correction = e.parse::<i64>().unwrap() - i.parse::<i64>().unwrap();
        if !row["dP"].is_empty() {
            assert_eq!(row["dP"], correction.to_string());
        }
        let expected = [numbered("E"), numbered("I"), vec![e, i, correction.to_string()]].concat();
        assert_eq!(line.split_whitespace().collect::<Vec<_>>(), expected, "{filler}: {row:?}");
    }
}
