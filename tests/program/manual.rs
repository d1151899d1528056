//! The documents of the repository: their links, their size, and the commands in them with what these print.
//!
//! A line of a block `sh` that starts with `sagnac` is run in a folder of the document's own, in which the shipped studies and some logs
//! lie, and has to end with exit code 0. A block `text` after it is what the last command prints; a line `…` stands for any lines. A
//! comment before a block may say what else the test does with it, which readers do not see:
//!
//! - `<!-- test: file NAME -->` writes the block into a file, and `<!-- test: append NAME -->` appends it,
//! - `<!-- test: with WORDS -->` gives each command of the block further words, for less work,
//! - `<!-- test: skip -->` runs nothing of the block.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use crate::desk::{Desk, PROGRAM};
use crate::noise::{chamber, units};

/// Most words of all documents for users.
const MAX_WORDS: usize = 30_000;
/// Most lines of the README.
const MAX_LINES: usize = 100;
/// Most words of a how-to without what commands print, about a screen.
const MAX_OF_A_HOW_TO: usize = 450;

fn root() -> &'static Path {
    Path::new(crate::ROOT)
}

/// The Markdown files below a folder, and those of the root itself, by their names from the root.
fn documents() -> Vec<String> {
    let mut names: Vec<String> =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "python/README.md"]
            .map(str::to_owned)
            .into();
    let mut folders = vec!["docs".to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let name = format!("{folder}/{}", entry.file_name().into_string().unwrap());
            match entry.file_type().unwrap().is_dir() {
                true => folders.push(name),
                false if name.ends_with(".md") => names.push(name),
                false => {}
            }
        }
    }
    names.sort();
    names
}

/// The documents for users.
fn of_users() -> Vec<String> {
    let is_ours = |name: &String| *name == "README.md" || name.starts_with("docs/");
    documents().into_iter().filter(|name| is_ours(name) && !name.starts_with("docs/dev/")).collect()
}

fn text_of(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap()
}

/// A fenced block of a document.
struct Block {
    language: String,
    /// What a comment before it asks of the test.
    asked: Option<String>,
    text: String,
    /// Its first line in the document, from 0.
    from: usize,
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = vec![];
    let mut asked = None;
    let mut is_open = false;
    for (at, line) in text.lines().enumerate() {
        if let Some(language) = line.strip_prefix("```") {
            if !is_open {
                let (language, asked) = (language.to_owned(), asked.take());
                blocks.push(Block { language, asked, text: String::new(), from: at + 1 });
            }
            is_open = !is_open;
        } else if is_open {
            blocks.last_mut().unwrap().text += &format!("{line}\n");
        } else if let Some(words) = line.strip_prefix("<!-- test: ") {
            asked = Some(words.trim_end_matches(" -->").to_owned());
        }
    }
    assert!(!is_open, "a block is not closed");
    blocks
}

/// The lines of a document outside its blocks.
fn prose(text: &str) -> Vec<&str> {
    let mut is_open = false;
    let mut lines = vec![];
    for line in text.lines() {
        match line.starts_with("```") {
            true => is_open = !is_open,
            false if !is_open => lines.push(line),
            false => {}
        }
    }
    lines
}

/// The anchors of the headings of a document, as GitHub makes them.
fn anchors(text: &str) -> Vec<String> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let headings = prose(text).into_iter().filter(|line| line.starts_with('#'));
    let headings = headings.map(|line| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let anchor: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let count = seen.entry(anchor.clone()).or_default();
        *count += 1;
        if *count == 1 { anchor } else { format!("{anchor}-{}", *count - 1) }
    });
    headings.collect()
}

/// The targets of links and pictures of a document, outside its blocks.
fn targets(text: &str) -> Vec<String> {
    let mut found = vec![];
    for line in prose(text) {
        let is_label = |label: &str| label.starts_with('[') && !label.contains(' ');
        if let Some((_, target)) = line.split_once("]: ").filter(|(label, _)| is_label(label)) {
            found.push(target.trim().to_owned());
        }
        for piece in line.split("](").skip(1) {
            found.push(piece.split(')').next().unwrap().to_owned());
        }
        for piece in line.split("src=\"").skip(1) {
            found.push(piece.split('"').next().unwrap().to_owned());
        }
    }
    found.retain(|target| !target.contains("://") && !target.starts_with("mailto:"));
    found
}

/// A path without `..`.
fn resolved(path: &Path) -> PathBuf {
    let mut parts = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(parts.pop()),
            Component::CurDir => {}
            part => parts.push(part),
        }
    }
    parts
}

#[test]
fn every_link_and_picture_of_the_documents_exists_and_every_anchor_is_a_heading() {
    let mut broken: Vec<String> = vec![];
    for name in documents() {
        let folder = Path::new(&name).parent().unwrap();
        for target in targets(&text_of(&name)) {
            let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let file = if path.is_empty() { PathBuf::from(&name) } else { resolved(&folder.join(path)) };
            let is_there = root().join(&file).exists();
            let has_anchor = || {
                let is_markdown = file.extension().is_some_and(|end| end == "md");
                !is_markdown || anchors(&text_of(file.to_str().unwrap())).contains(&anchor.to_owned())
            };
            if !is_there || (!anchor.is_empty() && !has_anchor()) {
                broken.push(format!("{name}: {target}"));
            }
        }
    }
    assert!(broken.is_empty(), "links without a target:\n{}", broken.join("\n"));
}

#[test]
fn the_documents_for_users_are_short() {
    let words: Vec<(String, usize)> = of_users()
        .into_iter()
        .map(|name| (name.clone(), text_of(&name).split_whitespace().count()))
        .collect();
    let all: usize = words.iter().map(|(_, words)| words).sum();
    for (name, words) in &words {
        println!("{words:6} {name}");
    }
    println!("{all:6} in all");
    assert!(all <= MAX_WORDS, "{all} words in documents for users, at most {MAX_WORDS}: {words:?}");
    let lines = text_of("README.md").lines().count();
    assert!(lines <= MAX_LINES, "the README has {lines} lines, at most {MAX_LINES}");
    let how_tos: Vec<_> = words.iter().filter(|(name, _)| name.starts_with("docs/howto/")).collect();
    assert_eq!(how_tos.len(), 9, "{how_tos:?}");
    for (name, all) in how_tos {
        let printed = blocks(&text_of(name)).into_iter().filter(|block| block.language == "text");
        let words = all - printed.map(|block| block.text.split_whitespace().count()).sum::<usize>();
        assert!(words <= MAX_OF_A_HOW_TO, "{name} has {words} words, at most {MAX_OF_A_HOW_TO}");
    }
}

/// The shipped studies and the logs that the documents name.
fn prepared() -> Desk {
    let desk = Desk::with("");
    let mut folders = vec![PathBuf::from("studies")];
    while let Some(folder) = folders.pop() {
        std::fs::create_dir_all(desk.path(folder.to_str().unwrap())).unwrap();
        for entry in std::fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let name = folder.join(entry.file_name());
            match entry.file_type().unwrap().is_dir() {
                true => folders.push(name),
                false => drop(std::fs::copy(entry.path(), desk.path(name.to_str().unwrap())).unwrap()),
            }
        }
    }
    std::fs::copy(root().join("tests/data/formats/imu.mcap"), desk.path("imu.mcap")).unwrap();
    desk.write("units.csv", &units());
    desk.write("chamber.csv", &chamber());
    desk
}

/// The commands of a block that are run: those of sagnac, and what prepares files for them.
fn commands(text: &str) -> Vec<String> {
    let lines = text.replace("\\\n", " ");
    let lines = lines.lines().map(|line| line.replace("cargo run --release --locked -- ", "sagnac "));
    lines
        .filter(|line| ["sagnac ", "cp ", "head ", "tail "].iter().any(|word| line.starts_with(word)))
        .collect()
}

/// A command with further words, on the processor, before its comment.
fn made(command: &str, more: &str) -> String {
    let (words, _) = command.split_once(" #").unwrap_or((command, ""));
    if !words.starts_with("sagnac ") {
        return words.to_owned();
    }
    let samples =
        ["run", "design", "sensitivity"].iter().any(|name| words.starts_with(&format!("sagnac {name} ")));
    let device = if samples && !words.contains("--device") { " --device cpu" } else { "" };
    format!("{}{device} {more}", words.trim_end())
}

/// Whether lines are the expected ones, of which `…` stands for any.
fn fits(expected: &[&str], found: &[&str]) -> bool {
    match expected.split_first() {
        None => found.is_empty(),
        Some((&"…", rest)) => (0..=found.len()).any(|skipped| fits(rest, &found[skipped..])),
        Some((first, rest)) => {
            found.first().is_some_and(|line| line.trim_end() == first.trim_end()) && fits(rest, &found[1..])
        }
    }
}

/// Runs the commands of a document. Returns what is wrong, and the document with what they print at present.
fn run(name: &str) -> (Vec<String>, String) {
    let text = text_of(name);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let (mut wrong, mut edits) = (vec![], vec![]);
    let desk = prepared();
    let folder = Path::new(PROGRAM).parent().unwrap();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path =
        std::env::join_paths(std::iter::once(folder.to_path_buf()).chain(std::env::split_paths(&others)));
    let path = path.unwrap();
    let mut printed: Option<String> = None;
    for block in blocks(&text) {
        let asked = block.asked.as_deref().unwrap_or_default();
        let (verb, words) = asked.split_once(' ').unwrap_or((asked, ""));
        match (&*block.language, verb) {
            (_, "file") => desk.write(words, &block.text),
            (_, "append") => desk.write(words, &(desk.read(words) + "\n" + &block.text)),
            ("sh", "skip") => printed = None,
            ("sh", _) => {
                printed = None;
                for command in commands(&block.text) {
                    let made = made(&command, if verb == "with" { words } else { "" });
                    let mut shell = Command::new("sh");
                    shell.args(["-c", &made]).env("PATH", &path).env("COLUMNS", "80");
                    shell.env("HOME", desk.path("")).current_dir(desk.path(""));
                    let output = shell.output().unwrap();
                    if !output.status.success() {
                        let said = String::from_utf8_lossy(&output.stderr).into_owned();
                        wrong.push(format!(
                            "{name}:{}: `{made}` ended with {}:\n{said}",
                            block.from, output.status
                        ));
                    }
                    printed = Some(String::from_utf8(output.stdout).unwrap());
                }
            }
            ("text", "skip") => {}
            ("text", _) => {
                let Some(printed) = printed.take() else { continue };
                let printed = printed.trim_matches('\n');
                let expected: Vec<&str> = block.text.lines().collect();
                if !fits(&expected, &printed.lines().collect::<Vec<_>>()) {
                    wrong.push(format!("{name}:{}: the command prints\n{printed}\n", block.from));
                    if !expected.contains(&"…") {
                        edits.push((block.from, expected.len(), printed.to_owned()));
                    }
                }
            }
            _ => {}
        }
    }
    for (from, count, printed) in edits.into_iter().rev() {
        lines.splice(from..from + count, printed.lines().map(|line| line.trim_end().to_owned()));
    }
    (wrong, lines.join("\n") + "\n")
}

#[test]
fn every_command_of_the_documents_ends_well_and_prints_what_they_show() {
    let names: Vec<String> = of_users();
    let ran: Vec<(Vec<String>, String)> = std::thread::scope(|scope| {
        let tasks: Vec<_> = names.iter().map(|name| scope.spawn(|| run(name))).collect();
        tasks.into_iter().map(|task| task.join().unwrap()).collect()
    });
    let mut wrong = vec![];
    for (name, (faults, present)) in names.iter().zip(ran) {
        if !faults.is_empty() {
            std::fs::write(root().join(format!("{name}.new")), present).unwrap();
        }
        wrong.extend(faults);
    }
    assert!(
        wrong.is_empty(),
        "{}\nReview each NAME.md.new, which has what is printed at present, then accept it with `mv NAME.md.new NAME.md`.",
        wrong.join("\n")
    );
}
