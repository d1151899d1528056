//! The committed schemas are those that the program prints. Python's tests hold the documents of every command against them.

use crate::desk::Desk;
use serde_json::Value;

#[test]
fn the_committed_schemas_are_those_that_the_program_prints() {
    let desk = Desk::with("");
    let names = ["run", "merge", "design", "sensitivity", "filler", "allan", "compare", "model", "bench"];
    for of in names {
        let file = if of == "bench" { "bench" } else { "document" };
        let committed =
            std::fs::read_to_string(format!("{}/schema/{file}.schema.json", crate::ROOT)).unwrap();
        let printed = desk.done(&format!("schema {of}")).stdout;
        assert_eq!(
            printed.trim_end(),
            committed.trim_end(),
            "`sagnac schema {of}` and schema/{file}.schema.json differ"
        );
    }
}

#[test]
fn a_merge_without_all_shares_says_in_its_verdict_and_document_what_is_missing() {
    let desk = Desk::with(&crate::desk::with(
        "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n[chart]\nx = \"frequency\"\n\
                                       y = \"rms\"\nseries = [\"filler\"]\nlimit = \"10 arcsec\"",
    ));
    desk.done("run study.toml --trials 4096 --device cpu --shard 1/2");
    let merge = "merge results/study/shard-1-of-2 --out results/study --trials 4096";
    let text = desk.sagnac(merge);
    assert_eq!(text.code, 4, "{}", text.stderr);
    assert!(text.stdout.contains("incomplete: 4096 trials missing"), "{}", text.stdout);
    let json = desk.sagnac(&format!("{merge} --json"));
    let document: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(document["provenance"]["missing_trials"], 4096);
}
