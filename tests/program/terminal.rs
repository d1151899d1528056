//! What people see: plots, colour, progress, studies to begin with, explanations, completions, manual pages.

use std::process::Command;

use crate::desk::{Desk, PROGRAM};
use sagnac::run::Plan;
use sagnac::study::Study;
use sagnac_engine::kinds::{KINDS, explained_keys};

const UTF8: (&str, &str) = ("LC_ALL", "C.UTF-8");

fn swept() -> Desk {
    Desk::with(&crate::desk::with(
        "[[sweep]]\nkey = \"motion.frequency\"\nlog = { from = \"2 Hz\", to = \"40 Hz\", points = 6 }\n[chart]\nx = \"frequency\"\n\
         y = \"rms\"\nseries = [\"filler\"]\nlimit = \"10 arcsec\"",
    ))
}

const RUN: &str = "run study.toml --trials 256 --device cpu";

#[test]
fn a_plot_has_axes_with_units_ticks_the_limit_and_a_legend_within_eighty_columns() {
    let desk = swept();
    let ended = desk.sagnac_with(&format!("{RUN} --plot"), &[UTF8]);
    for piece in
        ["rms error, ″", "vibration frequency, Hz", "● const", "■ quadratic", "limit 10″", "────────", "⠤"]
    {
        assert!(ended.stdout.contains(piece), "{piece} is missing in\n{}", ended.stdout);
    }
    let widest = ended.stdout.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(widest <= 80, "{widest} columns\n{}", ended.stdout);
    assert!(!ended.stdout.contains('\u{1b}') && !ended.stderr.contains(['\u{1b}', '\r']), "{}", ended.stderr);
    assert!(!desk.sagnac_with(RUN, &[UTF8]).stdout.contains('⠤'), "nobody asked for a plot");
}

#[test]
fn a_plot_is_plain_ascii_without_a_locale_of_utf_8_and_on_a_dumb_terminal() {
    let desk = swept();
    for variables in [[("LC_ALL", "C"), ("TERM", "xterm")], [UTF8, ("TERM", "dumb")]] {
        let text = desk.sagnac_with(&format!("{RUN} --plot"), &variables).stdout;
        let plot = text.split("\n\n").next().unwrap();
        assert!(plot.is_ascii() && plot.contains("arcsec") && plot.contains("o const"), "{plot}");
    }
}

#[test]
fn colour_is_as_asked_for_in_plots_in_diagnostics_and_in_usage() {
    let desk = swept();
    desk.write("bad.toml", "title = 5\n");
    let coloured = |words: &str, variables: &[(&str, &str)]| {
        let ended = desk.sagnac_with(words, variables);
        format!("{}{}", ended.stdout, ended.stderr).contains('\u{1b}')
    };
    let plot = format!("{RUN} --plot");
    for words in [plot.as_str(), "run bad.toml", "run"] {
        assert!(!coloured(words, &[UTF8]), "{words}: a pipe has no colours");
        assert!(coloured(&format!("{words} --color always"), &[UTF8, ("NO_COLOR", "1")]), "{words}: always");
        assert!(!coloured(&format!("{words} --color never"), &[UTF8]), "{words}: never");
    }
}

#[test]
fn progress_is_lines_without_a_terminal_and_nothing_where_none_is_asked_for() {
    let desk = swept();
    let bare = |how: &str| {
        desk.done(&format!("run study.toml --trials 256 --device cpu --out {how} --progress {how}")).stderr
    };
    for how in ["auto", "bar", "plain"] {
        let said = bare(how);
        assert!(said.contains("0 of ") && !said.contains(['\r', '\u{1b}']), "{how}: {said:?}");
    }
    assert!(!bare("none").contains("0 of "));
}

#[test]
fn every_kind_has_a_study_to_begin_with_that_runs_and_a_file_that_is_there_stays() {
    for kind in KINDS.map(|kind| kind.name) {
        let desk = Desk::with("mine");
        let said = desk.done(&format!("new {kind}")).stdout;
        assert!(said.contains(&format!("sagnac run {kind}.toml")), "{said}");
        let study = Study::read(&desk.path(&format!("{kind}.toml"))).unwrap();
        assert_eq!(study.kind().name, kind);
        desk.done(&format!("run {kind}.toml --trials 64 --device cpu --plot"));
        desk.fails(&format!("new {kind} study.toml"), 2, &["study.toml already exists", "name another file"]);
        assert_eq!(desk.read("study.toml"), "mine");
    }
}

/// The study with one of its optional lines made a line of it: behind `# or:` in place of the line above that has the same key.
fn with_option(text: &str, line: &str) -> String {
    let (alternative, new) = match line.strip_prefix("# or: ") {
        Some(new) => (true, new),
        None => (false, line.strip_prefix("# ").unwrap()),
    };
    let key = format!("{} =", new.split(" =").next().unwrap());
    let kept = text.lines().filter(|known| !(alternative && known.starts_with(&key)));
    kept.map(|known| if known == line { new } else { known }).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_optional_line_of_a_study_to_begin_with_is_valid() {
    for kind in KINDS.map(|kind| kind.name) {
        let desk = Desk::with("");
        desk.done(&format!("new {kind} new.toml"));
        let text = desk.read("new.toml");
        let is_key = |line: &&str| {
            let bare = line.strip_prefix("# or: ").or(line.strip_prefix("# ")).unwrap_or_default();
            let key = bare.split(" = ").next().unwrap_or_default();
            bare.contains(" = ") && key.chars().all(|c| c.is_ascii_lowercase() || c == '_')
        };
        let optional: Vec<&str> = text.lines().filter(is_key).collect();
        assert!(!optional.is_empty() || kind == "suspension", "{kind} has none");
        for line in optional {
            let changed = with_option(&text, line);
            let study = Study::parse(kind, &changed)
                .unwrap_or_else(|error| panic!("{kind}: {line}\n{}", error.render(false, 100)));
            Plan::new(&study).unwrap_or_else(|error| panic!("{kind}: {line}\n{}", error.render(false, 100)));
        }
    }
}

#[test]
fn keys_columns_and_exit_codes_are_explained_and_near_names_are_offered() {
    let desk = Desk::with("");
    let says = |what: &str, pieces: &[&str]| {
        let text = desk.done(&format!("explain {what}")).stdout;
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        for piece in pieces {
            assert!(flat.contains(piece), "{piece} is missing in the explanation of {what}:\n{text}");
        }
    };
    says(
        "motion.amplitude",
        &["arcsec/s, deg/s", "Range: 0 to 1e9", "amplitude = \"12000 arcsec/s\"", "gap-fill"],
    );
    says("motion.phase", &["\"zero-crossing\"", "gap-fill, switched-run"]);
    says("readout_lsb", &["gyro.readout_lsb", "noise.readout_lsb"]);
    says("p99_73_arcsec", &["99.73 % of errors stay below", "points.csv of kind = \"gap-fill\""]);
    says("tau_s", &["Averaging time", "curve.csv of `sagnac allan`"]);
    says("motion.frequency_hz", &["vibration frequency"]);
    for kind in KINDS.map(|kind| kind.name) {
        says(kind, &[&*format!("{kind} (kind of study)"), "points.csv", &*format!("sagnac new {kind}")]);
    }
    says("GAP_FILL", &["gap-fill (kind of study)"]);
    says("in-gap", &["Largest error of the angle while the gap is open", "switching.errors"]);
    says("minimum_variance", &["least error variance", "switching.fillers.kind"]);
    says("switching.fillers", &["\"linear\": A straight line", "fit_ticks, extrapolation_ticks, band"]);
    says(
        "Gyro.Tick-Noise",
        &["gyro.tick_noise (key of a study file)", "As a table it has the keys std, three_sigma"],
    );
    says("p99_73-hi", &["Upper end of the 95 % interval"]);
    for code in ["0", "1", "2", "3", "4", "5", "6", "130", "143"] {
        says(code, &[&format!("exit code {code}: ")]);
    }
    // Every word of the glossary is found, each by each of its names.
    for line in include_str!("../../docs/explain/glossary.md").lines() {
        let Some((names, meaning)) = line.strip_prefix("- **").and_then(|line| line.split_once("**: "))
        else {
            continue;
        };
        for name in names.split(", ") {
            desk.done(&format!("explain {}", name.trim_matches('`')));
        }
        if names == "overbound" {
            says("overbound", &["overbound (term)", meaning]);
        }
    }
    says("Gauss-Markov state", &["exponentially correlated noise"]);
    desk.fails("explain motion.amplitud", 2, &["did you mean `motion.amplitude`"]);
    desk.fails("explain 7", 2, &["there is no exit code 7", "130"]);
    desk.fails("explain xqzw", 2, &["`sagnac explain` lists all"]);
    let all = desk.done("explain").stdout;
    for key in explained_keys() {
        let last = key.rsplit('.').next().unwrap();
        assert!(all.contains(last), "{key} is not listed");
    }
}

#[test]
fn bash_accepts_the_completions_and_every_shell_has_some() {
    let desk = Desk::with("");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = desk.done(&format!("completions {shell}")).stdout;
        assert!(script.contains("time-limit"), "{shell}");
        desk.write(shell, &script);
    }
    match Command::new("bash")
        .args(["-c", "source ./bash && complete -p sagnac"])
        .current_dir(desk.path("."))
        .output()
    {
        Err(_) => eprintln!("skipped: there is no bash"),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stdout);
            assert!(
                output.status.success() && said.contains("-F _sagnac"),
                "{said}{}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
    }
}

#[test]
fn every_command_has_a_manual_page_that_renders() {
    let desk = Desk::with("");
    desk.done("man pages");
    let help = Command::new(PROGRAM).arg("--help").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let commands = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| !line.is_empty());
    let commands = commands.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    for command in commands.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help") {
        let page = desk.read(&format!("pages/sagnac-{command}.1"));
        assert!(page.contains(".SH SYNOPSIS"), "{page}");
    }
    let groff = Command::new("groff")
        .args(["-man", "-Tascii", "-P-cbou", "-ww", "pages/sagnac.1"])
        .current_dir(desk.path("."))
        .output();
    match groff {
        Err(_) => eprintln!("skipped: there is no groff"),
        Ok(output) => {
            let (text, said) =
                (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
            assert!(output.status.success() && text.contains("SUBCOMMANDS"), "{said}{text}");
        }
    }
}
