//! The order of the library's folders: each imports only from folders below it, so there is no circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The modules of crates below the library.
const BELOW: [&str; 12] = [
    "allan", "answer", "events", "fit", "kernel", "progress", "quantity", "record", "source", "spectrum",
    "table", "theory",
];

/// The top-level modules of `src/`, lowest first.
const ORDER: &[&str] = &[
    "key",
    "chart",
    "tally",
    "device",
    "store",
    "noise",
    "motion",
    "filler",
    "drift",
    "sampling",
    "study",
    "kinds",
    "run",
    "verify",
    "view",
    "analysis",
    "described",
];

/// `(from, to)` with every place that imports so.
type Imports = BTreeMap<(String, String), Vec<String>>;

#[test]
fn every_folder_imports_only_from_folders_below_it() {
    let imports = imports();
    let rank = |folder: &str| ORDER.iter().position(|known| *known == folder);
    let mut wrong = String::new();
    for ((from, to), places) in &imports {
        let (Some(above), Some(below)) = (rank(from), rank(to)) else {
            let missing = if rank(from).is_none() { from } else { to };
            writeln!(wrong, "src/{missing} has no place in ORDER: {}", places.join(", ")).unwrap();
            continue;
        };
        if below > above {
            writeln!(
                wrong,
                "`{from}` stands below `{to}` and must not import it: {}\n  help: move what is needed down to `{from}` or \
                 below, or hand it in from above",
                places.join(", ")
            )
            .unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}The order, lowest first: {}", ORDER.join(", "));
}

#[test]
fn every_folder_has_a_place_in_the_order() {
    let modules: BTreeSet<_> = std::fs::read_dir(sources())
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
        .filter(|name| name != "lib")
        .collect();
    let known: BTreeSet<_> = ORDER.iter().map(|name| (*name).to_owned()).collect();
    assert_eq!(modules, known, "src/ on the left, ORDER on the right");
}

fn sources() -> PathBuf {
    Path::new(crate::ROOT).join("src")
}

fn imports() -> Imports {
    let mut imports = Imports::new();
    add_folder(&sources(), &mut imports);
    imports
}

fn add_folder(folder: &Path, imports: &mut Imports) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_test = path.file_stem().is_some_and(|stem| stem == "tests");
        if path.is_dir() && !is_test {
            add_folder(&path, imports);
        } else if path.extension().is_some_and(|end| end == "rs") && !is_test {
            add_file(&path, imports);
        }
    }
}

fn add_file(path: &Path, imports: &mut Imports) {
    let below = path.strip_prefix(sources()).unwrap().with_extension("");
    let mut module: Vec<_> = below.iter().map(|part| part.to_str().unwrap()).collect();
    if module == ["lib"] {
        return;
    }
    if module.last() == Some(&"mod") {
        module.pop();
    }
    let text = std::fs::read_to_string(path).unwrap();
    for (line, code) in product(&text) {
        // From within a module, `crate` is as many `super` up as the module is deep.
        for root in ["crate::".to_owned(), "super::".repeat(module.len())] {
            for (at, _) in code.match_indices(&root) {
                if code[..at].ends_with(|before: char| before.is_alphanumeric() || "_:".contains(before)) {
                    continue;
                }
                for name in names(&code[at + root.len()..]) {
                    if name != module[0] && !BELOW.contains(&name) {
                        let place = format!("src/{}.rs:{line}", below.display());
                        imports.entry((module[0].to_owned(), name.to_owned())).or_default().push(place);
                    }
                }
            }
        }
    }
}

/// The first names of a path that follows `crate::`: one, or all of a group in braces.
fn names(rest: &str) -> Vec<&str> {
    let word = |text: &str| text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let Some(group) = rest.strip_prefix('{') else { return vec![&rest[..word(rest)]] };
    let (mut depth, mut begins, mut found) = (0, true, Vec::new());
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => begins = true,
            c if begins && (c.is_alphabetic() || c == '_') => {
                found.push(&group[at..at + word(&group[at..])]);
                begins = false;
            }
            _ => {}
        }
    }
    found
}

/// Statements without comments and without what is compiled only for tests; each with the line where it begins. A `use` over
/// several lines is one statement.
fn product(text: &str) -> Vec<(usize, String)> {
    let mut statements: Vec<(usize, String)> = Vec::new();
    let mut lines = text.lines().enumerate().map(|(index, line)| (index + 1, line));
    let mut open = false;
    while let Some((number, line)) = lines.next() {
        if line.trim() == "#[cfg(test)]" {
            let indent = &line[..line.len() - line.trim_start().len()];
            let closing = [format!("{indent}}}"), format!("{indent}}};")];
            // The item ends where it is closed with the indentation that it began with: rustfmt holds that.
            for (_, line) in lines.by_ref() {
                let first = line.starts_with(indent) && !line[indent.len()..].starts_with([' ', '#']);
                if closing.iter().any(|end| end == line) || first && line.ends_with(';') {
                    break;
                }
            }
            continue;
        }
        let code = line.split("//").next().unwrap_or_default().trim();
        match statements.last_mut().filter(|_| open) {
            Some((_, statement)) => statement.push_str(code),
            None => statements.push((number, code.to_owned())),
        }
        let (_, statement) = statements.last().unwrap();
        let declared = statement
            .strip_prefix("pub")
            .map_or(&**statement, |rest| rest.trim_start_matches("(crate)").trim_start());
        open = declared.starts_with("use ") && !statement.contains(';');
    }
    statements
}

#[test]
fn imports_are_read_from_code_alone() {
    let text = "//! [`crate::view`]\nuse crate::key::Key;\nuse crate::{\n    run::{Plan, keep},\n    table::Table, // crate::b\n};\n\
                #[cfg(test)]\nuse crate::c::C;\n    #[cfg(test)]\n    fn f() {\n        crate::d::g();\n    }\nlet x = crate::store::X;\n";
    let found: Vec<_> = product(text)
        .iter()
        .filter_map(|(line, code)| code.split_once("crate::").map(|(_, rest)| (*line, names(rest).join(" "))))
        .collect();
    assert_eq!(found, [(2, "key".into()), (3, "run table".into()), (13, "store".into())]);
}
