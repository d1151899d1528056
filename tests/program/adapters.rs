//! What is remembered of an adapter from start to start.

use std::path::{Path, PathBuf};

use crate::desk::{Desk, SHIPPED};

#[test]
fn an_adapter_that_passed_its_self_test_is_remembered() {
    let desk = Desk::with(SHIPPED);
    let cache = desk.path("cache");
    // Where the cache is on Linux, and where it is on macOS.
    let variables = [("XDG_CACHE_HOME", cache.to_str().unwrap()), ("HOME", cache.to_str().unwrap())];
    let runs = |folder: &str| {
        let ended = desk.sagnac_with(
            &format!("run study.toml --quiet --trials 500 --device gpu --out {folder}"),
            &variables,
        );
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        desk.read(&format!("{folder}/points.csv"))
    };
    let table = runs("first");
    let file = file_of_adapter(&cache);
    let kept = std::fs::read_to_string(&file).unwrap();
    let (believed, other) = match kept.contains("int64 = true") {
        true => ("int64 = true", "int64 = false"),
        false => ("int64 = false", "int64 = true"),
    };
    assert!(kept.contains("adapter = ") && kept.contains(believed), "{kept}");
    // What it says is believed and stays as it is; any other content is replaced.
    let slower = kept.replace(believed, "int64 = false");
    std::fs::write(&file, &slower).unwrap();
    assert_eq!(runs("believed"), table);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), slower);
    std::fs::write(&file, "int64 = ?").unwrap();
    assert_eq!(runs("again"), table);
    let again = std::fs::read_to_string(&file).unwrap();
    // The speed is measured again.
    let known =
        |text: &str| text.lines().filter(|line| !line.contains("steps_per_second")).collect::<String>();
    let is_like = |text: &str| known(&again) == known(text);
    assert!(is_like(&kept) || is_like(&kept.replace(believed, other)), "{again}");
}

#[test]
fn a_start_without_a_cache_folder_tests_the_adapter() {
    let desk = Desk::with(SHIPPED);
    desk.write("file", "");
    let file = desk.path("file");
    let variables = [("XDG_CACHE_HOME", file.to_str().unwrap()), ("HOME", file.to_str().unwrap())];
    let ended = desk.sagnac_with("run study.toml --quiet --trials 500 --device gpu", &variables);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert_eq!(desk.read("file"), "");
}

/// The file of the only adapter, in the cache folder of Linux or of macOS.
fn file_of_adapter(home: &Path) -> PathBuf {
    let folders = ["sagnac/adapters", "Library/Caches/sagnac/adapters"].map(|folder| home.join(folder));
    let folder = folders.iter().find(|folder| folder.is_dir()).expect("a folder of adapters");
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}
