//! The test vectors, and what the C header and the table of weights make of their inputs.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::{Command as Process, Stdio};

use super::fillers::{STUDY, rows, swept};
use crate::desk::Desk;

#[test]
fn test_vectors_hold_extremes_and_are_the_same_every_time() {
    let desk = Desk::with(STUDY);
    let words = "filler study.toml --test-vectors 200 --out";
    for folder in ["one", "two"] {
        desk.done(&format!("{words} {folder}"));
    }
    assert_eq!(desk.read("one/test_vectors.csv"), desk.read("two/test_vectors.csv"));
    assert_eq!(desk.read("one/sagnac_filler.h"), desk.read("two/sagnac_filler.h"));
    let rows = rows(&desk.path("one/test_vectors.csv"));
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

/// A folder with 3000 test vectors for each filler: of STUDY, and of the polynomials at two shorter gaps.
fn desks() -> Vec<Desk> {
    [(STUDY.to_owned(), ""), (swept(), "--at gap_ticks=1"), (swept(), "--at gap_ticks=2")]
        .into_iter()
        .map(|(text, at)| {
            let desk = Desk::with(&text);
            desk.done(&format!("filler study.toml --test-vectors 3000 --out out {at}"));
            desk
        })
        .collect()
}

const FILLERS: [&str; 6] = ["const", "linear", "quadratic", "mv8+2", "given", "both"];

#[test]
fn the_c_header_gives_the_test_vectors_bit_for_bit() {
    if Process::new("cc").arg("--version").output().is_err() {
        eprintln!(
            "no C compiler `cc`: the header is not compiled, weights.csv alone is compared with the vectors"
        );
        return;
    }
    for desk in desks() {
        let rows = rows(&desk.path("out/test_vectors.csv"));
        let header = desk.read("out/sagnac_filler.h");
        for filler in FILLERS {
            let own: Vec<_> = rows.iter().filter(|row| row["filler"] == filler).collect();
            if !own.is_empty() {
                compare(&desk.path("out"), &header, filler, &own);
            }
        }
    }
}

#[test]
fn the_rule_in_the_header_on_the_weights_of_the_table_gives_the_test_vectors() {
    for desk in desks() {
        let (weights, rows) = (rows(&desk.path("out/weights.csv")), rows(&desk.path("out/test_vectors.csv")));
        let gap_ticks = rows[0].keys().filter(|column| column.starts_with("I[")).count();
        for filler in FILLERS {
            for (error, letter) in [("extrapolation", 'E'), ("residual", 'I')] {
                let own: Vec<_> =
                    weights.iter().filter(|w| w["filler"] == filler && w["error"] == error).collect();
                for vector in rows.iter().filter(|row| row["filler"] == filler) {
                    let Some(first) = own.first() else {
                        assert_eq!(vector[&format!("sum_{letter}")], "", "{filler}");
                        continue;
                    };
                    let denominator: i128 = first["denominator"].parse().unwrap();
                    let (mut sum, mut filled) = (0_i128, 0_i128);
                    let mut add = |row: &str| {
                        for w in own.iter().filter(|w| w["row"] == row) {
                            let p: i128 = vector[&format!("P[{}]", w["tick"])].parse().unwrap();
                            sum += w["numerator"].parse::<i128>().unwrap() * p;
                        }
                        let rounded = (2 * sum + denominator).div_euclid(2 * denominator);
                        (rounded - std::mem::replace(&mut filled, rounded)).to_string()
                    };
                    if own.iter().any(|w| w["row"] == "1") {
                        for j in 1..=gap_ticks {
                            let value = add(&j.to_string());
                            assert_eq!(vector[&format!("{letter}[{j}]")], value, "{filler}: {vector:?}");
                        }
                    } else {
                        add("sum");
                    }
                    assert_eq!(vector[&format!("sum_{letter}")], filled.to_string(), "{filler}: {vector:?}");
                }
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
        .args(["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", &define, "main.c", "-o", "main"])
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
