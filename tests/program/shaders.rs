//! The files of the example `shaders`: the description lists them, and a browser finds the described results.

use std::collections::BTreeSet;

use sagnac_kernel::KERNELS;
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::desk::Desk;

#[path = "../../examples/shaders/files.rs"]
mod files;

/// A folder with the shaders, and their description.
fn written() -> (Desk, Value) {
    let desk = Desk::with("");
    files::files().iter().for_each(|(name, text)| desk.write(name, text));
    let description = serde_json::from_str(&desk.read("shaders.json")).unwrap();
    (desk, description)
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("no list: {value}"))
}

/// The names of the shaders.
fn names(description: &Value) -> Vec<String> {
    list(&description["shaders"]).iter().map(|shader| shader["name"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn every_file_that_the_description_lists_is_written_and_declares_its_buffers() {
    let (desk, description) = written();
    let mut files = BTreeSet::from(["check.html", "shaders.json", "study.toml"].map(str::to_owned));
    for shader in list(&description["shaders"]) {
        let name = shader["name"].as_str().unwrap();
        for (variant, has_64_bits) in [("u32", false), ("u64", true)] {
            let file = shader["wgsl"][variant].as_str().unwrap();
            let text = desk.read(file);
            let is_wide = |word: &str| ["u64", "i64"].contains(&word);
            let words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
            assert_eq!(words.into_iter().any(is_wide), has_64_bits, "64-bit integers in {file}");
            for buffer in list(&shader["buffers"]) {
                let (binding, name) = (&buffer["binding"], buffer["name"].as_str().unwrap());
                let declared = text.lines().any(|line| {
                    line.starts_with(&format!("@group(0) @binding({binding}) var<")) && line.contains(name)
                });
                assert!(declared, "{file} declares no buffer {name} at {binding}");
            }
            assert_eq!(
                text.matches("@binding(").count(),
                list(&shader["buffers"]).len(),
                "buffers of {file}"
            );
            let size = &shader["workgroup_size"];
            assert!(text.contains(&format!("const WORKGROUP: u32 = {size}u;")), "workgroups of {file}");
            files.insert(file.to_owned());
        }
        for buffer in list(&shader["buffers"]) {
            for words in ["words", "expected"].into_iter().filter_map(|key| buffer.get(key)) {
                assert_eq!(buffer["length"], list(words).len(), "{} of {name}", buffer["name"]);
            }
        }
        let has_results = list(&shader["buffers"]).iter().any(|buffer| buffer.get("expected").is_some());
        assert!(has_results, "{name} has no results");
        let dispatches = list(&shader["dispatches"]).len();
        assert!(dispatches >= if name.starts_with("allan") { 3 } else { 1 }, "{dispatches} of {name}");
    }
    assert_eq!(desk.names("."), Vec::from_iter(files));
    let names = names(&description);
    assert_eq!(BTreeSet::from_iter(&names).len(), names.len(), "a name is there twice: {names:?}");
    for kernel in KERNELS {
        let of_kernel = |name: &String| name.split(['-', '.']).next() == Some(kernel.name);
        let loads = sagnac::verify::loads(kernel).len().max(1);
        assert_eq!(names.iter().filter(|name| of_kernel(name)).count(), loads, "{}", kernel.name);
    }
}

/// The rows of the page: name and result of each shader.
fn rows(browser: &Browser) -> Vec<(String, String)> {
    let script = "return [...document.querySelectorAll('tbody tr')].map((row) => [row.cells[0].textContent, row.cells[2].textContent])";
    serde_json::from_value(browser.ask(script, json!(null))).unwrap()
}

/// A browser whose WebGPU runs on the processor.
fn browser() -> Option<Browser> {
    Browser::start_with(&["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"])
}

/// Browsers that share the shaders, which take minutes to compile on the processor.
const BROWSERS: usize = 2;

/// The shaders of a part give the described results in a browser.
fn show(part: usize) {
    let Some(browser) = browser() else { return };
    let (desk, description) = written();
    browser.begin(&desk.path(&format!("check.html#{part}/{BROWSERS}")));
    let names: Vec<String> = names(&description).into_iter().skip(part).step_by(BROWSERS).collect();
    for shown in 1..=names.len() {
        browser.wait(&format!("return document.querySelectorAll('tbody tr').length >= {shown}"));
    }
    let expected: Vec<_> = names.into_iter().map(|name| (name, "identical".to_owned())).collect();
    assert_eq!(rows(&browser), expected);
    assert_eq!(browser.console(), Vec::<String>::new(), "the console");
}

#[test]
fn half_of_the_shaders_give_the_described_results_in_a_browser() {
    show(0);
}

#[test]
fn the_other_half_of_the_shaders_give_the_described_results_in_a_browser() {
    show(1);
}

#[test]
fn a_wrong_bit_and_an_invalid_shader_are_shown_as_different() {
    let Some(browser) = browser() else { return };
    let (desk, description) = written();
    let page = desk.read("check.html");
    let (start, rest) = page.split_once("id=\"description\">").unwrap();
    let (data, end) = rest.split_once("</script>").unwrap();
    let mut data: Value = serde_json::from_str(data).unwrap();
    let shader = list(&description["shaders"])[0].clone();
    let results =
        list(&shader["buffers"]).iter().position(|buffer| buffer.get("expected").is_some()).unwrap();
    let right = shader["buffers"][results]["expected"][5].as_u64().unwrap();
    let mut wrong = shader.clone();
    wrong["buffers"][results]["expected"][5] = (right ^ 1).into();
    let mut invalid = shader.clone();
    invalid["wgsl"]["u32"] = "invalid".into();
    data["texts"]["invalid"] = "fn main( {".into();
    data["shaders"] = json!([wrong, invalid, shader]);
    desk.write("wrong.html", &format!("{start}id=\"description\">{data}</script>{end}"));
    browser.open(&desk.path("wrong.html"));
    let rows = rows(&browser);
    let at = shader["buffers"][results]["name"].as_str().unwrap();
    assert_eq!(rows[0].1, format!("DIFFERENT: {at}[5] is {right} instead of {}", right ^ 1));
    assert!(rows[1].1.starts_with("DIFFERENT: "), "{}", rows[1].1);
    assert_eq!(rows[2].1, "identical");
    assert_eq!(
        browser.text("return document.getElementById('summary').textContent"),
        "1 of 3 shaders give the expected words."
    );
}
