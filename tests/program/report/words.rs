//! Pages and pictures say the same words.

use std::path::Path;

use crate::browser::Browser;
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

/// What the charts of a results folder say on its page but not on their pictures.
pub fn only_on_page(browser: &Browser, folder: &Path) -> Vec<String> {
    browser.open(&folder.join("report.html"));
    let script = "const texts = (host, of) => [...host.querySelectorAll(of)].map((text) => text.textContent); \
        return [...document.querySelectorAll('[data-chart]')].map((chart) => { \
          const plot = chart.querySelector('.plot > .beside'); \
          return [chart.id, ...texts(chart, 'figcaption h3'), ...texts(chart, 'figcaption .subtitle'), ...texts(plot, '.axes .title'), \
            ...texts(plot, '.legend h4, .legend span, .legend p:not(.entry)')] })";
    let charts: Vec<Vec<String>> = serde_json::from_value(browser.ask(script, json!(null))).unwrap();
    let title = browser.text("return document.querySelector('h1').textContent");
    let mut missing = Vec::new();
    for mut words in charts {
        let stem = words.remove(0);
        let svg = std::fs::read_to_string(folder.join(format!("{stem}.svg"))).unwrap();
        let drawn = texts(&svg);
        assert!(words.len() > 2, "{}: {words:?}", folder.display());
        // Where the page has the title already, a heading says what the chart shows.
        if drawn.contains(&plain(&title)) {
            words.remove(0);
        }
        let unsaid = words.iter().map(|word| plain(word)).filter(|word| !drawn.contains(word));
        missing.extend(unsaid.map(|word| format!("{stem}: `{word}`")));
        missing.extend(drawn.contains('…').then(|| format!("{stem} whole, which is cut: {drawn}")));
    }
    missing
}
