//! What `sagnac device verify` says, beside the matrix of identity.

use std::process::Command;

use crate::desk::{Desk, PROGRAM};

#[test]
fn all_adapters_of_this_machine_are_compared_and_the_digest_is_that_of_the_processor() {
    let desk = Desk::with("");
    let digest = |words: &str| {
        let ended = desk.done(&format!("device verify --trials 64{words}"));
        let adapters = crate::devices::adapters();
        let are_said = adapters.iter().all(|adapter| ended.stderr.contains(&*adapter.name()));
        assert_eq!(are_said, words.is_empty() || adapters.is_empty(), "{}", ended.stderr);
        ended.stdout.lines().last().unwrap().to_owned()
    };
    assert_eq!(digest(""), digest(" --device cpu"));
    desk.fails("device verify --report identity.md", 2, &["--report is gone", "sagnac device list"]);
}

/// The table of docs/dev/verified-devices.md is of the current kernels, which this digest of less work shows.
#[test]
fn the_matrix_of_the_documents_is_that_of_the_current_kernels() {
    let desk = Desk::with("");
    let printed = desk.done("device verify --device cpu --trials 4096").stdout;
    let digest = printed.trim_end().rsplit(' ').next().unwrap();
    let document = std::fs::read_to_string(format!("{}/docs/dev/verified-devices.md", crate::ROOT)).unwrap();
    assert!(
        document.contains(&format!("`{digest}` with `--trials 4096`")),
        "docs/dev/verified-devices.md is of other kernels: measure its rows again with `sagnac device verify`, and name the digest \
         {digest} of 4096 trials"
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
