//! The answers of pages, and what messages say to do next.

use crate::desk::{Desk, replaced, with};

const FREQUENCIES: &str =
    "[[sweep]]\nkey = \"motion.frequency\"\nlist = [\"5 Hz\", \"10 Hz\", \"20 Hz\", \"40 Hz\"]\n";

/// Two fillers, ten minutes, at intervals of which even numbers make the run.
const RUNS: &str = r#"title = "Two fillers"
kind = "switched-run"
trials = 2048
streams = "common"
[gyro]
tick = "5 ms"
tick_noise = { three_sigma = "1.6 arcsec" }
[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"
[drift]
magnetic = "14 arcsec/s"
warm_up_time = "3000 s"
[switching]
interval = "40 s"
gap_ticks = 1
fillers = ["const", "quadratic"]
[run]
duration = "10 min"
"#;

/// The answer of the page of a study.
fn headline(study: &str) -> String {
    let desk = Desk::with(study);
    desk.done("run study.toml --device cpu --trials 2000 --quiet");
    let page = desk.read("results/study/report.html");
    let answer = page.split("<p class=\"headline\">").nth(1).and_then(|rest| rest.split("</p>").next());
    answer.unwrap_or_else(|| panic!("no answer in\n{page}")).to_owned()
}

fn chart(lines: &str) -> String {
    format!("[[chart]]\n{lines}\n")
}

#[test]
fn an_interval_is_answered_by_the_best_one_before_the_limit() {
    let sweep =
        "[[sweep]]\nkey = \"switching.interval\"\nlist = [\"5 s\", \"10 s\", \"20 s\", \"30 s\", \"60 s\"]\n";
    let over = chart("x = \"interval\"\ny = \"drift_q9973\"\nseries = [\"filler\"]\nlimit = \"1 deg/h\"");
    let said = headline(&format!("{RUNS}{sweep}{over}"));
    assert!(
        said.starts_with("The least 99.73 % drift is ") && said.contains("quadratic, switching interval"),
        "{said}"
    );
    assert!(said.contains("1 °/h"), "what the limit says comes behind: {said}");
    // The length of a run is given, so that the best interval of each is the answer.
    let lengths = "[[sweep]]\nkey = \"run.duration\"\nlist = [\"10 min\", \"20 min\"]\n";
    let by_length = chart(
        "x = \"interval\"\ny = \"drift_q9973\"\nseries = [\"duration\"]\nwhere = { filler = \"const\" }",
    );
    let said = headline(&format!("{RUNS}{lengths}{sweep}{by_length}"));
    let places = said.strip_prefix("The 99.73 % drift is least at switching interval ");
    let [first, second] =
        ["(run time 600 s: ", "(run time 1200 s: "].map(|name| places.and_then(|said| said.find(name)));
    assert!(first.is_some() && first < second, "{said}");
    // Of fillers the better one is told with the interval, and that firmware cannot have it.
    let free = RUNS.replace("\"quadratic\"]", "{ kind = \"minimum-variance\", name = \"mv\" }]");
    let both = chart("x = \"interval\"\ny = \"drift_q9973\"\nseries = [\"filler\", \"duration\"]");
    let said = headline(&format!("{free}{lengths}{sweep}{both}"));
    assert!(said.contains(" s with mv") && said.contains(" (run time 1200 s: "), "{said}");
    assert!(
        said.ends_with(
            "Without a band mv is designed for exactly this motion, which firmware does not know."
        ),
        "{said}"
    );
    // Names side by side are judged each for itself.
    let beside =
        chart("x = \"filler\"\ny = \"drift_q9973\"\nwhere = { interval = \"20 s\" }\nlimit = \"0.3 deg/h\"");
    let said = headline(&format!("{RUNS}{sweep}{beside}{over}"));
    assert!(said.starts_with("1 of 2 curves stays within 0.3 °/h (quadratic, at most "), "{said}");
    assert!(said.contains("is nowhere within 0.3 °/h (const, at least "), "{said}");
    assert!(said.ends_with(" °/h). That is for switching interval 20 s."), "{said}");
}

#[test]
fn names_side_by_side_are_answered_by_what_their_chart_shows() {
    let one = headline(&with(""));
    assert!(one.starts_with("The least 99.73 % error is "), "{one}");
    let open = chart("x = \"filler\"\ny = \"rms\"\nwhere = { error = \"extrapolation\" }");
    let said = headline(&with(&open));
    assert!(said.starts_with("The least rms error is "), "{said}");
    let at_20_hz = chart("x = \"filler\"\ny = \"rms\"\nwhere = { frequency = \"20 Hz\" }");
    let said = headline(&with(&format!("{FREQUENCIES}{at_20_hz}")));
    assert!(said.starts_with("The least rms error is "), "{said}");
}

#[test]
fn several_values_at_one_name_are_refused() {
    let mixed = chart("x = \"filler\"\ny = \"rms\"");
    Desk::with(&with(&format!("{FREQUENCIES}{mixed}"))).fails(
        "run study.toml --device cpu",
        3,
        &["motion.frequency"],
    );
}

#[test]
fn a_chart_of_another_table_has_another_limit() {
    let allan = "title = \"a\"\nkind = \"allan\"\ntrials = 32\n[record]\nsample = \"1 s\"\nlength = \"30 min\"\n[noise]\n\
                 angle_random_walk = \"0.003 deg/sqrt(h)\"\n[allan]\nfit = [\"N\"]\n[[sweep]]\nkey = \"record.length\"\n\
                 list = [\"15 min\", \"30 min\"]\n[[chart]]\ntable = \"coefficients\"\nx = \"length\"\ny = \"relative_rmse\"\n\
                 where = { coefficient = \"N\" }\nlimit = \"10 %\"\n";
    let desk = Desk::with(allan);
    desk.done("run study.toml --device cpu --quiet");
    desk.done("chart results/study --table points --x tau --y adev --series length");
    desk.done("chart results/study --limit 5%");
}

#[test]
fn the_command_that_puts_shares_together_can_be_pasted() {
    let said = |desk: &Desk, words: &str| {
        let ended = desk.done(&format!("run {words} --device cpu --trials 1024"));
        ended.stderr.lines().last().unwrap_or_default().to_owned()
    };
    let desk = Desk::with(&with(""));
    let first = said(&desk, "study.toml --shard 1/2");
    assert!(first.ends_with("sagnac merge results/study/shard-*-of-2 --out results/study"), "{first}");
    said(&desk, "study.toml --shard 2/2");
    desk.done("merge results/study/shard-1-of-2 results/study/shard-2-of-2 --out results/study");
    let here = said(&desk, "study.toml --shard 1/2 --out shard-1-of-2");
    assert!(here.ends_with("sagnac merge shard-*-of-2 --out whole"), "{here}");
    let elsewhere = said(&desk, "study.toml --shard 1/2 --out mine");
    assert!(elsewhere.contains("sagnac merge SHARE… --out DIR"), "{elsewhere}");
}

#[test]
fn folders_of_folders_negative_numbers_and_terms_are_understood() {
    let desk = Desk::with(&replaced("[gyro]", "trials = 1000\n[gyro]"));
    desk.done("run study.toml --device cpu --quiet");
    desk.fails("check results", 2, &["results holds folders of results", "give one of them: results/study"]);
    desk.fails("run study.toml --trials -5", 2, &["not a whole number: write a whole number"]);
    desk.write("g.csv", "0\n");
    for (given, message) in [
        ("--rate -5Hz", "--rate -5Hz: the rate is not positive"),
        ("--rate -.5Hz", "--rate -.5Hz: the rate is not positive"),
        ("--skip -5s", "a time before the start of the file"),
    ] {
        desk.fails(&format!("allan g.csv --data rate {given}"), 2, &[message]);
    }
    for (word, meaning) in
        [("N", "angle random walk"), ("arw", "angle random walk"), ("lsb", "one pulse"), ("shard", "merge")]
    {
        let said = desk.done(&format!("explain {word}")).stdout;
        assert!(said.contains("(term)") && said.contains(meaning), "{said}");
    }
    // A word comes before keys that only end so.
    assert!(desk.done("explain residual").stdout.starts_with("residual (word of a study file)"));
}
