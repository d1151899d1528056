//! Shaders and their Rust twins have the same functions in the same order, and the registry lists every file of both.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use sagnac_kernel::PARTS;

/// Marks, in its comment, a function that the other side lacks; the longer mark covers all functions from there on.
const ONLY: &str = "// Only here";
const ONLY_FROM_HERE: &str = "// Only here to the end";

/// A function of a source text.
struct Function {
    name: String,
    /// Whether the other side must have it too.
    shared: bool,
    /// Whether it takes or returns lanes: always in a shader, in Rust where the type of a word is a parameter.
    of_lanes: bool,
    has_body: bool,
}

/// The functions of a text before its tests, in order, each name once.
fn functions(text: &str) -> Vec<Function> {
    let mut found: Vec<Function> = Vec::new();
    let (mut marked, mut to_the_end, mut generic) = (false, false, false);
    let text = text.split("#[cfg(test)]").next().unwrap();
    for (at, line) in text.lines().enumerate() {
        let line_start = line.trim_start();
        if line.starts_with("impl") || line.starts_with('}') {
            generic = line.contains("W: Word");
        }
        to_the_end |= line_start.starts_with(ONLY_FROM_HERE);
        marked |= line_start.starts_with(ONLY);
        let words = line_start.trim_start_matches("pub").trim_start_matches("(crate)").trim_start();
        let Some(rest) = words.trim_start_matches("const ").trim_start_matches("unsafe ").strip_prefix("fn ")
        else {
            let above = ["//", "#[", "@"].iter().any(|start| line_start.starts_with(start));
            marked &= above;
            continue;
        };
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let signature = text.lines().skip(at).take_while(|line| !line.trim_end().ends_with(['{', ';', '}']));
        let end = text.lines().skip(at).find(|line| line.trim_end().ends_with(['{', ';', '}'])).unwrap();
        let signature: String = signature.chain([end]).collect();
        let has_word = signature.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == "W");
        if found.iter().all(|function| function.name != name) {
            let shared = !marked && !to_the_end;
            let has_body = !end.trim_end().ends_with(';');
            found.push(Function { name, shared, of_lanes: has_word || generic, has_body });
        }
        marked = false;
    }
    found
}

fn rust_of(stem: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let file = folder.join(format!("{stem}.rs"));
    fs::read_to_string(if file.is_file() { file } else { folder.join(stem).join("mod.rs") }).unwrap()
}

#[test]
fn twins_have_the_same_functions_in_the_same_order() {
    for part in PARTS {
        let (shader, rust) = (functions(part.wgsl), functions(&rust_of(part.stem)));
        let names: Vec<&str> = shader.iter().filter(|f| f.shared).map(|f| f.name.as_str()).collect();
        let stem = part.stem;
        let mut twins = rust.iter().map(|f| f.name.as_str());
        for name in &names {
            let found = twins.any(|twin| twin == *name);
            assert!(
                found,
                "`{name}` of shaders/{stem}.wgsl is not a function of crates/kernel/src/{stem} in this order"
            );
        }
        for twin in rust.iter().filter(|f| f.shared && f.of_lanes && f.has_body) {
            let name = twin.name.as_str();
            assert!(
                names.contains(&name),
                "`{name}` of crates/kernel/src/{stem} is not in shaders/{stem}.wgsl: rename, or mark it `{ONLY}: why`"
            );
        }
    }
}

#[test]
fn every_file_is_registered() {
    let registered: HashSet<&str> = PARTS.iter().map(|part| part.stem).collect();
    let stems = |folder: &str| -> Vec<String> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        entries.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
    };
    for stem in stems("../../shaders") {
        assert!(
            registered.contains(stem.as_str()),
            "shaders/{stem}.wgsl is not in `twins!` of crates/kernel/src/lib.rs"
        );
    }
    let root = rust_of("lib");
    for stem in stems("src").iter().filter(|stem| *stem != "lib" && !registered.contains(stem.as_str())) {
        assert!(
            root.contains(&format!("mod {stem};")),
            "crates/kernel/src/{stem} is neither a twin nor a module"
        );
        assert!(!rust_of(stem).contains("Twin of `shaders"), "crates/kernel/src/{stem} is not in `twins!`");
    }
}

/// A constant declared by hand on both sides could come to differ.
#[test]
fn no_constant_is_typed_twice() {
    let declared = |text: &str| -> HashSet<String> {
        let after =
            |line: &str| line.trim().trim_start_matches("pub ").strip_prefix("const ").map(str::to_owned);
        let name =
            |rest: String| rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap().to_owned();
        text.lines().filter_map(after).map(name).collect()
    };
    for part in PARTS {
        let twice: Vec<String> =
            declared(part.wgsl).intersection(&declared(&rust_of(part.stem))).cloned().collect();
        assert!(twice.is_empty(), "{}: generate {twice:?} into the shader with `constants!`", part.stem);
    }
}
