//! Folders of results: which ones charts and pages can be made of, and what the answer on a page is.

use std::fs::{create_dir_all, write};

use crate::desk::{Desk, STUDY, replaced, with};

const SWEEP: &str = "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"20 Hz\"]\n";

const RELOCK: &str = "title = \"Relock\"\nkind = \"relock\"\n[gyro]\ntick = \"5 ms\"\n[relock]\nmiss = 0.06\nloop_time = \"12 ms\"\n\
                      bias_frequency = \"80 kHz\"\npulse_weight = \"2.6 arcsec\"\ncurvature = 40\n";

/// The first sentence of the page of a study.
fn headline(desk: &Desk) -> String {
    desk.done("run study.toml --device cpu --trials 5000");
    let page = desk.read("results/study/report.html");
    let (_, from) = page.split_once("class=\"headline\">").unwrap();
    from.split_once("</").unwrap().0.to_owned()
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
    desk.fails("chart compared", 2, &["compared holds output of `sagnac compare`"]);
    create_dir_all(desk.path("pooled")).unwrap();
    desk.write("pooled/batch.csv", "");
    desk.fails("chart pooled", 2, &["pooled holds output of `sagnac compare`"]);
    desk.fails("chart results/study --chart 2", 2, &["the study has no chart of its own"]);
    desk.fails(
        "chart results/study --kind heat-map --x frequency",
        2,
        &["the chart needs --y and --z", "the study sweeps motion.frequency", "rms_arcsec"],
    );
    assert!(desk.done("chart --help").stdout.contains("keeps the charts of the study"));
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
    assert!(
        said.contains("a_vs_b (sagnac compare), log (sagnac allan), runs/design (sagnac design)\n"),
        "{said}"
    );
    assert!(!said.contains("own"), "{said}");
    assert!(!desk.done("report results --quiet").stderr.contains("left out"));
    desk.fails(
        "report results/log",
        2,
        &["output of `sagnac allan` of an earlier version", "run the command again"],
    );
    desk.fails(
        "report results/own",
        2,
        &["neither results/own nor a folder in it has a resolved_study.toml or a card.json"],
    );
}

/// A log of two columns, and a study of whole runs.
fn desk_with_a_log() -> Desk {
    let desk = Desk::with(STUDY);
    desk.write("log.csv", &crate::logs::log());
    std::fs::copy(format!("{}/studies/design_point.toml", crate::ROOT), desk.path("runs.toml")).unwrap();
    desk
}

#[test]
fn a_gallery_joins_the_results_of_every_command() {
    let desk = desk_with_a_log();
    let read = "--data rate --bootstrap 0 --column gx,gz";
    desk.done("run study.toml --device cpu --trials 1000 --out all/study");
    desk.done("design runs.toml --device cpu --trials 64 --out all/study/design");
    desk.done("filler quadratic --gap-ticks 3 --out all/filler");
    let decides = format!("{}/studies/what_decides.toml", crate::ROOT);
    desk.done(&format!(
        "sensitivity {decides} --by theory_rms --samples 32 --device cpu --out all/what_decides"
    ));
    desk.done(&format!("allan log.csv {read} --out all/allan"));
    desk.done("compare log.csv log.csv --data rate --column gx,gz --out all/compare");
    desk.done("compare log.csv --data rate --column gx,gz --out all/batch");
    desk.done("model log.csv --data rate --column gx,gz --overbound --out all/model");
    let pages = ["allan", "batch", "compare", "filler", "model", "study", "study/design", "what_decides"];
    let said = desk.done("report all").stderr;
    for page in pages {
        assert!(said.contains(&format!("all/{page}/report.html\n")), "{page}: {said}");
    }
    let gallery = desk.read("all/gallery.html");
    assert!(gallery.contains("<h1>8 results</h1>"), "{gallery}");
    assert_eq!(gallery.matches("<img").count(), 8);
    for page in pages {
        let text = desk.read(&format!("all/{page}/report.html"));
        let (_, from) = text.split_once("class=\"headline\">").unwrap();
        // Without its marks, as the page shows settings as code.
        let headline = from.split_once("</").unwrap().0;
        assert!(gallery.contains(headline) || headline.contains("<code>"), "{page}: {headline}");
        assert!(gallery.contains(&format!("href=\"{page}/report.html\"")), "{page}");
        assert!(text.contains("<div class=\"still\"><svg"), "{page} has no still picture");
        let mut ids: Vec<&str> =
            text.split(" id=\"").skip(1).filter_map(|rest| Some(rest.split_once('"')?.0)).collect();
        let all = ids.len();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), all, "{page} has an id twice");
    }
    // The same results give the same bytes.
    desk.done("report all");
    assert_eq!(desk.read("all/gallery.html"), gallery);
    desk.done("filler quadratic --gap-ticks 3 --out again");
    assert_eq!(desk.read("again/report.html"), desk.read("all/filler/report.html"));
    desk.done("design runs.toml --device cpu --trials 64 --out again");
    assert_eq!(desk.read("again/report.html"), desk.read("all/study/design/report.html"));
}

#[test]
fn a_card_is_not_trusted() {
    let desk = Desk::with(STUDY);
    desk.done("filler quadratic --gap-ticks 3 --out all/a");
    desk.done("filler quadratic --gap-ticks 2 --out all/b");
    let evil = "<script>alert(1)</script>";
    desk.write(
        "all/a/card.json",
        &format!(r#"{{"title":"{evil}","question":"{evil}","headline":"{evil}","picture":"<svg>{evil}</svg>","report":"{evil}"}}"#),
    );
    desk.done("report all");
    let gallery = desk.read("all/gallery.html");
    assert!(!gallery.contains("<script") && gallery.contains("&lt;script&gt;"), "{gallery}");
    for text in ["{", "[1]", r#"{"title": 5}"#] {
        desk.write("all/a/card.json", text);
        desk.fails("report all", 2, &["all/a/card.json is no card of results", "run `sagnac filler` again"]);
    }
    desk.write("all/a/card.json", &" ".repeat(5 << 20));
    desk.fails("report all", 2, &["all/a/card.json has 5242880 bytes"]);
    std::fs::remove_file(desk.path("all/b/report.html")).unwrap();
    desk.fails("report all/b", 2, &["all/b/report.html is missing", "run `sagnac filler` again"]);
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
    #[cfg(unix)]
    for (link, to) in [("dangling", "nowhere"), ("loop", "loop")] {
        std::os::unix::fs::symlink(to, desk.path(link)).unwrap();
        let words = format!("{run} {link}");
        desk.fails(&words, 6, &["it is a link that leads nowhere", "name a folder with --out DIR"]);
    }
}

#[test]
fn the_answer_says_where_the_least_filler_is_none_that_firmware_has() {
    let fillers =
        |more: &str| replaced("[\"const\", \"quadratic\"]", &format!("[\"const\", \"quadratic\", {more}]"));
    let own = "{ kind = \"minimum-variance\", name = \"own\" }";
    let caveat = "designed for exactly this motion, which firmware does not know";
    let desk = Desk::with(&fillers(own));
    assert!(headline(&desk).starts_with("Quadratic: 99.73 % error "), "{}", headline(&desk));
    assert!(desk.read("results/study/report.html").contains(&format!("own: {caveat}")));
    let banded = "{ kind = \"minimum-variance\", name = \"own band\", band = [\"18 Hz\", \"22 Hz\"] }";
    let desk = Desk::with(&fillers(banded));
    assert!(headline(&desk).starts_with("own band: 99.73 % error "), "{}", headline(&desk));
    assert!(!desk.read("results/study/report.html").contains(caveat));
    // A limit, and a name that begins as the other does.
    let chart = format!("{SWEEP}[chart]\nx = \"frequency\"\ny = \"p99_73\"\nlimit = \"40 arcsec\"\n");
    let desk = Desk::with(&format!("{}{chart}", fillers(&format!("{own}, {banded}"))));
    assert!(headline(&desk).starts_with("own band "), "{}", headline(&desk));
    assert!(desk.read("results/study/report.html").contains(&format!("<dd>own: {caveat}</dd>")));
}

#[test]
fn the_answer_of_a_relock_is_what_is_left_of_all_ticks_and_its_columns_have_names_of_their_own() {
    let desk = Desk::with(RELOCK);
    let said = headline(&desk);
    assert!(said.contains(": rms angle left "), "{said}");
    let shown = desk.done("run study.toml --device cpu --trials 5000 --table").stdout;
    let heading: Vec<&str> = shown.lines().nth(1).unwrap().split_whitespace().collect();
    assert_eq!(heading, ["tick", "none", "frequency", "detuning"], "{shown}");
    assert_eq!(shown.lines().filter(|line| line.trim_start().starts_with("all ")).count(), 1, "{shown}");
    // A chart of one tick, and of one compensation.
    let chart = "[chart]\nx = \"tick_number\"\ny = \"rms\"\n";
    desk.write("study.toml", &format!("{RELOCK}{chart}where = {{ tick = \"3\" }}\n"));
    assert!(headline(&desk).contains(": rms angle left "), "{}", headline(&desk));
    desk.write("study.toml", &format!("{RELOCK}{chart}where = {{ compensation = \"none\" }}\n"));
    let said = headline(&desk);
    assert!(said.starts_with("Rms angle left ") || said.starts_with("rms angle left "), "{said}");
}

#[test]
fn the_answer_over_what_a_gyro_meets_is_the_filler_that_is_best_at_worst() {
    let chart = "[chart]\nx = \"frequency\"\ny = \"rms\"\nseries = [\"filler\"]\n";
    let desk = Desk::with(&with(&format!("{SWEEP}{chart}")));
    let said = headline(&desk);
    assert!(said.starts_with("Quadratic: rms error ") && said.ends_with(" at 20 Hz"), "{said}");
    desk.write("study.toml", &with(&format!("{SWEEP}{chart}limit = \"1000 arcsec\"\n")));
    let said = headline(&desk);
    assert!(said.starts_with("Quadratic meets the 1000″ limit: "), "{said}");
}

#[test]
fn a_filler_that_is_designed_for_the_band_of_the_motion_is_one_that_firmware_can_have() {
    let of = |motion: &str, design: &str| {
        let fillers = format!(
            "fillers = [\"const\", {{ kind = \"minimum-variance\", name = \"mv\", fit_ticks = [\"-3..0\", \"n+1..n+2\"]{design} }}]"
        );
        let study = STUDY.replace("fillers = [\"const\", \"quadratic\"]", &fillers);
        let desk = Desk::with(&study.replace("frequency = \"20 Hz\"", &format!("frequency = {motion}")));
        let said = headline(&desk);
        (said, desk.read("results/study/report.html").contains("mv: designed for exactly this motion"))
    };
    let band = "[\"18 Hz\", \"22 Hz\"]";
    let drawn = of(band, "");
    assert!(drawn.0.starts_with("mv: ") && !drawn.1, "{drawn:?}");
    assert_eq!(drawn, of(band, &format!(", band = {band}")));
    assert!(of("\"20 Hz\"", "").1);
}

/// Two gyros at rest, of files in a folder beside the study.
const GYROS: &str = "title = \"Two gyros\"\nkind = \"allan\"\ntrials = 64\n[record]\nsample = \"1 s\"\nlength = \"10 min\"\n[noise]\n\
                     [allan]\ntau = \"octave\"\n[[sweep]]\nkey = \"noise.file\"\nlist = [\"gyros/a.toml\", \"gyros/b.toml\"]\n";

/// A folder with that study and its files.
fn gyros(desk: &Desk, folder: &str, walk: &str) {
    std::fs::create_dir_all(desk.path(&format!("{folder}/gyros"))).unwrap();
    desk.write(&format!("{folder}/study.toml"), GYROS);
    desk.write(&format!("{folder}/gyros/a.toml"), &format!("angle_random_walk = \"{walk} deg/sqrt(h)\"\n"));
    desk.write(&format!("{folder}/gyros/b.toml"), "angle_random_walk = \"0.002 deg/sqrt(h)\"\n");
}

#[test]
fn a_folder_of_results_holds_the_files_of_its_study_and_can_be_moved() {
    let desk = Desk::with(STUDY);
    gyros(&desk, "there", "0.001");
    desk.done("run there/study.toml --device cpu --out there/results");
    std::fs::rename(desk.path("there/results"), desk.path("moved")).unwrap();
    std::fs::remove_dir_all(desk.path("there")).unwrap();
    let points = desk.read("moved/points.csv");
    assert_eq!(desk.names("moved/inputs"), ["a.toml", "b.toml"]);
    desk.done("check moved");
    desk.done("report moved");
    desk.done("chart moved --x tau --y adev --series noise.file");
    desk.done("run moved/resolved_study.toml --device cpu");
    desk.done("run moved/resolved_study.toml --device cpu --trials 64 --out again");
    assert_eq!((desk.read("moved/points.csv"), desk.read("again/points.csv")), (points.clone(), points));
    let here = desk.path("").display().to_string();
    for file in ["moved/report.html", "moved/resolved_study.toml", "again/report.html"] {
        assert!(!desk.read(file).contains(&*here), "{file} names the folder of this machine");
    }
    assert!(desk.read("moved/report.html").contains("inputs/b.toml"));
}

#[test]
fn folders_of_earlier_versions_name_files_by_their_whole_paths_and_are_read_too() {
    let desk = Desk::with(STUDY);
    gyros(&desk, "there", "0.001");
    desk.done("run there/study.toml --device cpu --out old");
    let points = desk.read("old/points.csv");
    let there = desk.path("there").display().to_string();
    let study = desk.read("old/resolved_study.toml").replace("inputs/", &format!("{there}/gyros/"));
    desk.write("old/resolved_study.toml", &study);
    std::fs::remove_dir_all(desk.path("old/inputs")).unwrap();
    std::fs::remove_file(desk.path("old/written_by_sagnac.jsonl")).unwrap();
    desk.done("chart old --x tau --y adev --series noise.file");
    desk.done("check old");
    desk.fails("report old", 6, &["sagnac check old --adopt"]);
    desk.done("check old --adopt");
    desk.done("report old");
    assert_eq!(desk.names("old/inputs"), ["a.toml", "b.toml"]);
    assert_eq!(desk.read("old/points.csv"), points);
}

#[test]
fn folders_of_other_commands_are_checked_by_their_lists() {
    let desk = Desk::with("");
    desk.write("noise.toml", "angle_random_walk = \"0.01 deg/sqrt(h)\"\n");
    desk.done("simulate noise.toml --rate 1Hz --length 20min --out record");
    desk.done("allan record/record_00000.csv --bootstrap 0 --out fit");
    desk.done("model noise.toml --from 1s --to 100s --out model");
    for (folder, command) in [("record", "simulate"), ("fit", "allan"), ("model", "model")] {
        let said = desk.done(&format!("check {folder}")).stdout;
        let intact = format!("files of `sagnac {command}` are as they were written");
        assert!(said.starts_with(&format!("{folder}: ")) && said.contains(&intact), "{said}");
    }
    let curve = desk.read("fit/curve.csv");
    desk.write("fit/curve.csv", &curve.replacen('1', "2", 1));
    desk.fails("check fit --quiet", 5, &["fit/curve.csv was changed since it was written"]);
    std::fs::remove_file(desk.path("record/record_00000.csv")).unwrap();
    desk.fails(
        "check record model --quiet",
        5,
        &["record/record_00000.csv was removed since it was written"],
    );
    std::fs::remove_file(desk.path("model/written_by_sagnac.jsonl")).unwrap();
    desk.fails("check model", 2, &["holds output of `sagnac model` of an earlier version", "--adopt"]);
}

#[test]
fn a_run_says_which_file_is_another_one_than_before() {
    let desk = Desk::with(STUDY);
    gyros(&desk, "one", "0.001");
    gyros(&desk, "other", "0.003");
    desk.done("run one/study.toml --device cpu --out out");
    let said = desk.done("run other/study.toml --device cpu --out out").stderr;
    assert!(said.contains("note: inputs/a.toml changed since the last run"), "{said}");
    assert!(!said.contains("inputs/b.toml"), "{said}");
}

#[test]
fn a_folder_in_a_bad_way_keeps_no_other_from_its_page() {
    let desk = Desk::with(&with(SWEEP));
    for folder in ["a", "b", "c"] {
        desk.done(&format!("run study.toml --device cpu --trials 1000 --out all/{folder}"));
        std::fs::remove_file(desk.path(&format!("all/{folder}/report.html"))).unwrap();
    }
    desk.write("all/b/resolved_study.toml", "title = 5");
    desk.fails("report all", 3, &["all/b/resolved_study.toml:1"]);
    for (file, is_there) in
        [("a/report.html", true), ("b/report.html", false), ("c/report.html", true), ("gallery.html", true)]
    {
        assert_eq!(desk.path(&format!("all/{file}")).exists(), is_there, "{file}");
    }
    desk.fails("report all/a/points.csv", 2, &["is a file, not a folder of results"]);
}

#[test]
fn shards_from_folders_of_their_own_merge_where_their_files_are_the_same() {
    let desk = Desk::with(STUDY);
    for (folder, walk) in [("one", "0.001"), ("two", "0.001"), ("other", "0.003")] {
        gyros(&desk, folder, walk);
    }
    desk.done("run one/study.toml --device cpu --out whole");
    desk.done("run one/study.toml --device cpu --shard 1/2 --out a");
    desk.done("run two/study.toml --device cpu --shard 2/2 --out b");
    desk.done("run other/study.toml --device cpu --shard 2/2 --out c");
    desk.done("merge a b --out merged");
    assert_eq!(desk.read("merged/points.csv"), desk.read("whole/points.csv"));
    assert_eq!(desk.names("merged/inputs"), ["a.toml", "b.toml"]);
    desk.fails(
        "merge a c --out none",
        2,
        &["c/inputs/a.toml is not what a/resolved_study.toml was run with"],
    );
    assert!(!desk.path("none").exists());
}
