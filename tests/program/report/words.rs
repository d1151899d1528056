//! Pages and pictures of all shipped studies: they say the same words.

use std::path::Path;

use crate::browser::Browser;
use crate::report::results::Results;
use serde_json::json;

/// All texts of an SVG picture, in its order.
fn texts(svg: &str) -> String {
    let document = roxmltree::Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    plain(&texts.filter_map(|node| node.text()).collect::<Vec<_>>().join(" "))
}

/// With usual spaces, single ones.
fn plain(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn pages_and_pictures_have_the_same_titles_axes_legends_and_subtitles() {
    let Some(browser) = Browser::start() else { return };
    let studies = std::fs::read_dir(Path::new(crate::ROOT).join("studies")).unwrap();
    let mut names: Vec<String> = studies
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    let mut missing = Vec::new();
    for name in names {
        let results = Results::new(&name, 64);
        browser.open(&results.page());
        let script = "const texts = (host, of) => [...host.querySelectorAll(of)].map((text) => text.textContent); \
            return [...document.querySelectorAll('[data-chart]')].map((chart) => { \
              const plot = chart.querySelector('.plot > .beside'); \
              return [chart.id, ...texts(chart, 'figcaption h3'), ...texts(chart, 'figcaption .subtitle'), ...texts(plot, '.axes .title'), \
                ...texts(plot, '.legend h4, .legend span, .legend p:not(.entry)')] })";
        let charts: Vec<Vec<String>> = serde_json::from_value(browser.ask(script, json!(null))).unwrap();
        let title = browser.text("return document.querySelector('h1').textContent");
        for mut words in charts {
            let stem = words.remove(0);
            let svg = std::fs::read_to_string(results.folder().join(format!("{stem}.svg"))).unwrap();
            let drawn = texts(&svg);
            assert!(words.len() > 2, "{name}: {words:?}");
            // Where the page has the title already, a heading says what the chart shows.
            if drawn.contains(&plain(&title)) {
                words.remove(0);
            }
            let unsaid = words.iter().map(|word| plain(word)).filter(|word| !drawn.contains(word));
            missing.extend(unsaid.map(|word| format!("{name} {stem}: `{word}`")));
            missing
                .extend(drawn.contains('…').then(|| format!("{name} {stem} whole, which is cut: {drawn}")));
        }
    }
    assert!(missing.is_empty(), "only pages say\n{}", missing.join("\n"));
}
