//! The rows that `sagnac device verify` adds to the matrix of identity.

use std::process::Command;

use crate::desk::{Desk, PROGRAM};
use sagnac::kernel::width::Width;
use sagnac::verify::identity::HEADER;

/// The rows of a report without its header, as cells.
fn rows(report: &str) -> Vec<Vec<String>> {
    let rows = report.strip_prefix(HEADER).unwrap_or_else(|| panic!("{report}"));
    assert!(!rows.contains(HEADER), "{report}");
    rows.lines()
        .map(|row| row.split(" | ").map(|cell| cell.trim_matches(['|', ' ']).to_owned()).collect())
        .collect()
}

#[test]
fn a_report_has_a_row_for_each_device_and_grows_below_one_header() {
    let desk = Desk::with("");
    desk.done("device verify --device cpu --trials 64 --report report.md");
    let widths: Vec<&str> = Width::available().into_iter().map(Width::name).collect();
    let variants = |report: &str| rows(report).into_iter().map(|row| row[3].clone()).collect::<Vec<_>>();
    assert_eq!(variants(&desk.read("report.md")), widths);
    // All adapters of this machine, one of which a software rasterizer is at least.
    desk.done("device verify --trials 64 --report report.md");
    let all = rows(&desk.read("report.md"));
    let gpus: Vec<_> = all.iter().filter(|row| row[0] != "CPU").collect();
    assert_eq!(gpus.len(), crate::devices::adapters().len());
    assert_eq!(all.len(), 2 * widths.len() + gpus.len());
    for row in gpus {
        assert!(row[3].ends_with("-bit products, workgroup 64"), "{row:?}");
    }
    for row in &all {
        assert_eq!((row[6].as_str(), row[8].as_str(), &row[7]), ("64", "identical", &all[0][7]), "{row:?}");
    }
}

#[test]
fn a_report_that_cannot_be_written_ends_the_command_before_its_work() {
    let desk = Desk::with("");
    for path in ["missing/report.md", "."] {
        let ended = desk.sagnac(&format!("device verify --device cpu --report {path}"));
        assert_eq!(ended.code, 6, "{}", ended.stderr);
        assert!(ended.stderr.contains(&format!("error: cannot write {path}: ")), "{}", ended.stderr);
        assert_eq!(ended.stdout, "", "no kernel was verified");
    }
}

/// The table of docs/identity.md is of the current kernels, which this digest of less work shows.
#[test]
fn the_matrix_of_the_documents_is_that_of_the_current_kernels() {
    let desk = Desk::with("");
    desk.done("device verify --device cpu --trials 4096 --report report.md");
    let digest = rows(&desk.read("report.md")).remove(0).remove(7);
    let document = std::fs::read_to_string(format!("{}/docs/identity.md", crate::ROOT)).unwrap();
    assert!(
        document.contains(&format!("`{digest}` with `--trials 4096`")),
        "docs/identity.md is of other kernels: measure its rows again with `sagnac device verify --report FILE`, and name \
         the digest {digest} of 4096 trials"
    );
    let measured: Vec<_> = document.lines().filter(|line| line.contains("| identical |")).collect();
    // The portable CPU, AVX2 and llvmpipe; not every machine has AVX-512.
    assert!(measured.len() >= 3, "{measured:#?}");
    let digests: std::collections::BTreeSet<_> =
        measured.iter().map(|row| row.split(" | ").nth(7).unwrap()).collect();
    assert_eq!(digests.len(), 1, "identical rows have one digest");
}

#[test]
fn the_driver_that_a_variable_hides_is_missed() {
    if !cfg!(target_os = "linux") {
        return;
    }
    let bench = ["device", "bench", "--device", "gpu"];
    let output = Command::new(PROGRAM).args(bench).env("VK_DRIVER_FILES", "/gone.json").output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("no GPU was found") && stderr.contains("A GPU that is not used"), "{stderr}");
}

#[test]
fn a_former_option_leads_to_the_guide() {
    let listed = Desk::with("").done("device list --why");
    assert!(listed.stderr.contains("note: `--why` is gone"), "{}", listed.stderr);
    for adapter in crate::devices::adapters() {
        assert!(listed.stdout.contains(&*adapter.name()), "{}", listed.stdout);
    }
}
