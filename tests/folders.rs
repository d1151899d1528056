//! Folders of results: which ones charts and pages can be made of, and what the answer on a page is.

mod desk;

use std::fs::{create_dir_all, write};

use desk::{Desk, STUDY, replaced, with};

const SWEEP: &str = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n";

const RELOCK: &str = "title = \"Relock\"\nkind = \"relock\"\n[gyro]\ntick = \"5 ms\"\n[relock]\nmiss = 0.06\nloop_time = \"12 ms\"\n\
                      bias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40\n";

/// The first sentence of the page of a study.
fn headline(desk: &Desk) -> String {
    desk.done("run study.toml --device cpu --trials 5000");
    let page = desk.read("results/study/report.html");
    let (_, from) = page.split_once("<p class=\"headline\">").unwrap();
    from.split_once("</p>").unwrap().0.to_owned()
}

#[test]
fn a_chart_of_no_results_is_refused_with_what_there_is() {
    let desk = Desk::with(&with(SWEEP));
    desk.done("run study.toml --device cpu --trials 1000");
    desk.fails("chart nowhere", 2, &["there is no folder nowhere", "`sagnac run` wrote"]);
    desk.fails("chart study.toml", 2, &["study.toml is a file, not a folder of results"]);
    desk.fails("chart results", 2, &["holds folders of results", "give one of them: results/study"]);
    create_dir_all(desk.path("compared")).unwrap();
    desk.fails("chart compared", 2, &["compared has no resolved_study.toml"]);
    write(desk.path("compared/compare.csv"), "").unwrap();
    desk.fails("chart compared", 2, &["compared holds what `sagnac compare` wrote"]);
    desk.fails("chart results/study --chart 2", 2, &["the study has no chart of its own"]);
    desk.fails(
        "chart results/study --kind heat-map --x frequency",
        2,
        &["the chart needs --y and --z", "the study sweeps motion.frequency", "rms_arcsec"],
    );
    assert!(desk.done("chart --help").stdout.contains("report.html, keeps the charts of the study"));
}

#[test]
fn a_gallery_says_which_folders_it_leaves_out() {
    let desk = Desk::with(STUDY);
    desk.done("run study.toml --device cpu --trials 1000");
    assert!(!desk.done("report results").stderr.contains("left out"));
    for (folder, file) in
        [("log", "curve.csv"), ("a_vs_b", "compare.csv"), ("runs/design", "design.json"), ("own", "x")]
    {
        create_dir_all(desk.path(&format!("results/{folder}"))).unwrap();
        write(desk.path(&format!("results/{folder}/{file}")), "").unwrap();
    }
    let said = desk.done("report results").stderr;
    assert!(said.contains("a_vs_b (sagnac compare), log (sagnac allan), runs (sagnac design)\n"), "{said}");
    assert!(!said.contains("own"), "{said}");
    assert!(!desk.done("report results --quiet").stderr.contains("left out"));
}

#[test]
fn a_results_folder_that_is_a_file_is_said_to_be_one() {
    let desk = Desk::with(STUDY);
    let run = "run study.toml --device cpu --trials 1000 --out";
    desk.fails(
        &format!("{run} study.toml"),
        6,
        &["study.toml: it is a file", "name a folder with --out DIR"],
    );
    desk.fails(&format!("{run} study.toml/deep"), 6, &["a part of its path is a file"]);
}

#[test]
fn the_answer_says_where_the_least_filler_is_none_that_firmware_has() {
    let fillers =
        |more: &str| replaced("[\"const\", \"quadratic\"]", &format!("[\"const\", \"quadratic\", {more}]"));
    let own = "{ kind = \"minimum-variance\", name = \"own\" }";
    let said = headline(&Desk::with(&fillers(own)));
    assert!(
        said.contains(": own. That filler is designed for the very motion of each point; of weights"),
        "{said}"
    );
    assert!(said.contains("the least is ") && said.contains(": quadratic (error = residual)."), "{said}");
    let banded = "{ kind = \"minimum-variance\", name = \"own band\", band = [\"18 Hz\", \"22 Hz\"] }";
    let said = headline(&Desk::with(&fillers(banded)));
    assert!(said.contains(": own band (error = residual).") && !said.contains("designed"), "{said}");
    // A verdict, in which one name begins as the other does.
    let chart = format!("{SWEEP}[chart]\nx = \"frequency\"\ny = \"q9973\"\nlimit = \"40 arcsec\"\n");
    let said = headline(&Desk::with(&format!("{}{chart}", fillers(&format!("{own}, {banded}")))));
    assert!(
        said.ends_with(
            "Without a band own is designed for the very motion of each point, which firmware does not know."
        ),
        "{said}"
    );
}

#[test]
fn the_answer_of_a_relock_is_what_is_left_of_all_ticks_and_its_columns_have_names_of_their_own() {
    let desk = Desk::with(RELOCK);
    let said = headline(&desk);
    assert!(
        said.starts_with("All ticks together, rms angle left: ") && said.contains(" ″ (frequency), "),
        "{said}"
    );
    let shown = desk.done("run study.toml --device cpu --trials 5000").stdout;
    let heading: Vec<&str> = shown.lines().nth(3).unwrap().split_whitespace().collect();
    assert_eq!(heading, ["tick", "none", "frequency", "detuning"], "{shown}");
    assert_eq!(shown.lines().filter(|line| line.trim_start().starts_with("all ")).count(), 1, "{shown}");
}
