//! What `--json` prints is what the schemas say, and the schemas printed are those that are committed.

use crate::desk::Desk;
use serde_json::Value;

fn shipped(name: &str) -> String {
    format!("{}/{name}", crate::ROOT)
}

/// The committed schema of a document, which has to be the one that the program prints.
fn schema(of: &str) -> Value {
    let name = if ["bench", "devices"].contains(&of) { of } else { "document" };
    let committed = std::fs::read_to_string(shipped(&format!("schema/{name}.schema.json"))).unwrap();
    let printed = Desk::with("").done(&format!("schema {of}")).stdout;
    assert_eq!(
        printed.trim_end(),
        committed.trim_end(),
        "`sagnac schema {of}` and schema/{name}.schema.json differ"
    );
    serde_json::from_str(&committed).unwrap()
}

/// Holds a document against a schema.
fn check(schema: &Value, document: &str, what: &str) {
    let document: Value = serde_json::from_str(document).unwrap_or_else(|error| panic!("{what}: {error}"));
    let validator = jsonschema::validator_for(schema).unwrap();
    let faults: Vec<String> = validator
        .iter_errors(&document)
        .take(5)
        .map(|error| format!("{} at {}", error, error.instance_path()))
        .collect();
    assert!(faults.is_empty(), "{what} is not what its schema says:\n{}", faults.join("\n"));
}

const FEW: &str = "--trials 64 --device cpu --json";

#[test]
fn results_of_every_kind_of_study_are_what_the_schema_says() {
    let run = schema("run");
    schema("merge");
    let desk = Desk::with("");
    let studies = [
        "error_vs_dtnu",
        "record_length",
        "relock_tables",
        "optimal_interval",
        "suspension",
        "drift_vs_interval",
    ];
    for name in studies {
        let ended = desk.done(&format!("run {} {FEW}", shipped(&format!("studies/{name}.toml"))));
        check(&run, &ended.stdout, name);
    }
    let several =
        format!("{} {}", shipped("studies/suspension.toml"), shipped("studies/optimal_interval.toml"));
    check(&run, &desk.done(&format!("run {several} {FEW}")).stdout, "several studies");
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
    check(&schema("merge"), &json.stdout, "an incomplete merge");
    let document: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(document["provenance"]["missing_trials"], 4096);
}

#[test]
fn design_sensitivity_filler_allan_compare_lot_and_model_print_what_their_schemas_say() {
    let desk = Desk::with("");
    let design = format!("design {} {FEW}", shipped("studies/design_point.toml"));
    check(&schema("design"), &desk.done(&design).stdout, "design");
    let search = format!("{design} --search --latency 20ms");
    check(&schema("design"), &desk.done(&search).stdout, "design with a search");
    for more in ["--by theory_rms --samples 32", "--samples 32 --trials 64"] {
        let decides = shipped("studies/what_decides.toml");
        let words = format!("sensitivity {decides} --device cpu --json --out s {more}");
        check(&schema("sensitivity"), &desk.done(&words).stdout, more);
    }
    for words in ["filler quadratic const --gap-ticks 3 --json", "filler study.toml --json"] {
        desk.write("study.toml", crate::desk::STUDY);
        check(&schema("filler"), &desk.done(words).stdout, words);
    }
    let log = shipped("studies/data/gyro_at_rest.csv");
    let read = "--data rate --rate 1Hz --json";
    let deviations = "--deviation oadev,tdev,hdev --remove-outliers --detrend linear --skip 60s";
    let allan = schema("allan");
    for more in [
        "--bootstrap 0",
        "--fit none --no-psd --bootstrap 0",
        "--segment 600s --segment-detrend linear --bootstrap 0",
        &format!("{deviations} --bootstrap 0"),
        "--bootstrap 200",
        "--bootstrap 0 --dynamic 30min",
        "--bootstrap 0 --navigate 1h",
        "--bootstrap 0 --limit N=0.001deg/sqrt(h) --limit B=0.1deg/h --limit floor=1deg/sqrt(h)",
    ] {
        check(&allan, &desk.done(&format!("allan {log} {read} {more}")).stdout, more);
    }
    let row = |i: u32| format!("{},{}\n", i * 37 % 101, 20.0 + 5.0 * (0.05 * f64::from(i)).sin());
    desk.write("warm.csv", &format!("gz [deg/h],temp [degC]\n{}", (0..400).map(row).collect::<String>()));
    let warm = desk.done(&format!("allan warm.csv {read} --column gz --temperature temp --bootstrap 0"));
    check(&allan, &warm.stdout, "temperature");
    check(&schema("compare"), &desk.done(&format!("compare {log} {log} {read}")).stdout, "compare");
    desk.write("g.csv", &std::fs::read_to_string(&log).unwrap().replacen("9.8947", "9.9947", 1));
    let held = format!("compare {log} g.csv {read} --limit N=1.1 --limit sine=2 --fit Q,N,sine");
    check(&schema("compare"), &desk.done(&held).stdout, "compare with limits");
    check(
        &schema("compare"),
        &desk.done(&format!("compare {log} {log} {read} --fit none")).stdout,
        "compare without a fit",
    );
    desk.write("two.csv", &crate::logs::log());
    for more in ["", "--fit none", "--limit in_run_bias_stability=1deg/s"] {
        let words = format!("compare two.csv --data rate --column gx,gz --json {more}");
        check(&schema("compare"), &desk.done(&words).stdout, &words);
    }
    let model = schema("model");
    for more in
        ["--overbound", "--overbound=repeat --write all", "--overbound --quantization white --states 1"]
    {
        check(&model, &desk.done(&format!("model {log} {read} {more}")).stdout, more);
    }
    desk.write("noise.toml", "angle_random_walk = \"0.003 deg/sqrt(h)\"\n");
    check(&model, &desk.done("model noise.toml --from 1s --to 100s --json").stdout, "a noise.toml");
    let two = desk.done("model two.csv --data rate --column gx,gz --overbound --json");
    check(&model, &two.stdout, "two columns");
    schema("bench");
}

#[test]
fn a_document_that_lacks_or_adds_a_key_is_not_what_the_schema_says() {
    let desk = Desk::with("");
    let text = desk.done("filler quadratic --gap-ticks 3 --json").stdout;
    let validator = jsonschema::validator_for(&schema("filler")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    assert!(validator.is_valid(&document));
    assert_eq!(document["schema"], 2);
    for place in ["", "/tables/weights/0"] {
        let mut more = document.clone();
        more.pointer_mut(place).unwrap()["more"] = 1.into();
        assert!(!validator.is_valid(&more), "a key of `{place}` that is not described passes");
    }
    for key in ["schema", "title", "question", "answer", "notes", "tables"] {
        let mut less = document.clone();
        less.as_object_mut().unwrap().remove(key);
        assert!(!validator.is_valid(&less), "a document without {key} passes");
    }
}
