//! Reports in a real browser: what is read off them is what points.csv has.

mod edges;
mod fillers;
mod results;
pub mod words;

use std::collections::BTreeSet;

use crate::browser::{Browser, key};
use results::{Results, shown};
use serde_json::json;

/// The picture of the first chart.
const PICTURE: &str = "[data-chart='0'] .drawing svg";

/// What stands beside the place that is read off: where that is, and for each curve its name and what is said of it.
type Tip = (Vec<String>, Vec<(String, String)>);

fn tip(browser: &Browser) -> Option<Tip> {
    let script = "const t = document.getElementById('tip'); if (t.className !== 'shown') return null; \
        const lines = [...t.querySelectorAll('tr')].map((row) => [...row.cells].slice(-2).map((cell) => cell.textContent)); \
        return [[...t.querySelectorAll('p.at')].map((p) => p.textContent), lines]";
    let told = browser.ask(script, json!(null));
    (!told.is_null()).then(|| serde_json::from_value(told).unwrap())
}

/// Points at a place of an element, in parts of its width and height.
fn point_at(browser: &Browser, selector: &str, (across, down): (f64, f64)) {
    let [left, top, width, height] = browser.place(selector);
    browser.mouse(&[(left + across * width, top + down * height)], false);
}

fn labels(browser: &Browser) -> Vec<String> {
    let script = format!(
        "return [...document.querySelectorAll(\"{PICTURE} .axes text\")].map((text) => text.textContent)"
    );
    serde_json::from_value(browser.ask(&script, json!(null))).unwrap()
}

/// The page is silent, and asks no network for anything.
fn is_silent(browser: &Browser) {
    assert_eq!(browser.console(), Vec::<String>::new(), "the console");
    assert_eq!(browser.number("return performance.getEntriesByType('resource').length"), 0.0, "resources");
}

/// Reads values off along a chart and holds them against the table: the number after `= ` or before the unit is the x that `x` has in
/// points.csv, and `names` are the columns whose values name a curve.
fn reads_as_in_the_table(
    browser: &Browser,
    results: &Results,
    (x, (estimate, unit)): (&str, (&str, &str)),
    names: &[&str],
    filter: &[(&str, &str)],
) -> usize {
    let y = format!("{estimate}_{unit}");
    let mut read = BTreeSet::new();
    for step in 0..24 {
        point_at(browser, PICTURE, (0.12 + 0.035 * f64::from(step), 0.3 + 0.02 * f64::from(step % 12)));
        let Some((at, lines)) = tip(browser) else { continue };
        // `averaging time τ 10 s`, `Δt·ν = 0.02 (vibration frequency 4 Hz)`
        let words: Vec<&str> = at[0].split(" (").next().unwrap().split(' ').collect();
        let number = words.iter().rev().find(|word| word.starts_with(|c: char| c.is_ascii_digit())).unwrap();
        for (name, said) in lines {
            // A curve that stands for several is named `const = linear`.
            let values: Vec<&str> = name.split(", ").map(|name| name.split(" = ").next().unwrap()).collect();
            let named: Vec<(&str, &str)> = names.iter().copied().zip(values).collect();
            let whole: Vec<(&str, &str)> = filter.iter().copied().chain(named).collect();
            let row = results.row(&[(x, number)], &whole);
            let row = row.unwrap_or_else(|| panic!("no single row has {x} = {number} and {whole:?}"));
            let value = said.split([' ', '″']).next().unwrap();
            assert_eq!(value, row.shown(&y), "{name} at {number}: {said}");
            // `95 % band: 14.25 … 14.313`
            let [low, high] = ["lo", "hi"].map(|end| row.shown(&format!("{estimate}_{end}_{unit}")));
            assert!(
                said.contains(&format!(": {low} … {high}")),
                "{name} at {number}: {said}, not {low} … {high}"
            );
            read.insert((name, (*number).to_owned()));
        }
    }
    read.len()
}

#[test]
fn what_is_read_off_switched_enlarged_and_sorted_is_what_the_table_has() {
    let Some(browser) = Browser::start() else { return };
    let results = Results::new("error_vs_dtnu", 20_000);
    browser.open(&results.page());
    let axes = ("dt_nu", ("p99_73", "arcsec"));
    let names = ["filler", "switching.gap_ticks"];
    let read = reads_as_in_the_table(&browser, &results, axes, &names, &[("error", "residual")]);
    assert!(read > 20, "only {read} values were read off");

    // A curve that is switched off is neither drawn nor read.
    let markers =
        || browser.number(&format!("return document.querySelectorAll(\"{PICTURE} .marker\").length"));
    let before = markers();
    let quadratic = "[data-chart='0'] .legend .group:first-child button:last-of-type";
    browser.click(quadratic);
    assert_eq!(markers(), before / 2.0);
    point_at(&browser, PICTURE, (0.5, 0.5));
    let (_, lines) = tip(&browser).unwrap();
    assert!(!lines.is_empty() && lines.iter().all(|(name, _)| !name.contains("quadratic")), "{lines:?}");
    browser.click(quadratic);
    assert_eq!(markers(), before);

    // A part, and all again.
    let whole = labels(&browser);
    let [left, top, width, height] = browser.place(PICTURE);
    let at = |across: f64, down: f64| (left + across * width, top + down * height);
    browser.mouse(&[at(0.4, 0.7), at(0.5, 0.5), at(0.6, 0.4)], true);
    let part = labels(&browser);
    assert_ne!(part, whole, "nothing was enlarged");
    let read = reads_as_in_the_table(&browser, &results, axes, &names, &[("error", "residual")]);
    assert!(read > 3, "only {read} values were read off what is enlarged");
    browser.click_at(at(0.5, 0.5), 2);
    assert_eq!(labels(&browser), whole);

    // Even steps instead of decades.
    browser.click("[data-chart='0'] .tools button:nth-child(2)");
    let linear = labels(&browser);
    assert!(linear.contains(&"50".to_owned()) && linear.contains(&"150".to_owned()), "{linear:?}");
    browser.click("[data-chart='0'] .tools button:nth-child(2)");

    // The keyboard reads as the mouse does; what is in view already is not scrolled, which would end the reading.
    browser.place(PICTURE);
    browser.press(PICTURE, key::RIGHT);
    let (first, _) = tip(&browser).unwrap();
    browser.press(PICTURE, key::RIGHT);
    let (second, lines) = tip(&browser).unwrap();
    let of_curve = [("error", "residual"), ("filler", "const"), ("switching.gap_ticks", "1")];
    let [xs, hertz] = ["dt_nu", "motion.frequency_hz"].map(|name| results.column(name, &of_curve));
    let place =
        |at: usize| format!("Δt·ν = {} (vibration frequency {} Hz)", shown(xs[at], 5), shown(hertz[at], 5));
    assert_eq!([&first[0], &second[0]], [&place(0), &place(1)]);
    browser.press(PICTURE, key::DOWN);
    assert_ne!(tip(&browser).unwrap().1[0].0, lines[0].0, "the next curve");

    sorts(&browser, &results);
    is_silent(&browser);
}

/// Sorted by a column and narrowed to a filler, the table has what points.csv has.
fn sorts(browser: &Browser, results: &Results) {
    let header = ".listing th button[data-header='rms_arcsec']";
    let first = "const headers = [...document.querySelectorAll('.listing thead button')].map((b) => b.dataset.header); \
        return document.querySelector('.listing tbody tr').cells[headers.indexOf('rms_arcsec')].title";
    let mut values: Vec<f64> =
        results.column("rms_arcsec", &[]).iter().map(|cell| cell.parse().unwrap()).collect();
    values.sort_by(f64::total_cmp);
    browser.click(header);
    assert_eq!(browser.text(first).parse(), Ok(values[0]));
    browser.press(header, key::ENTER);
    assert_eq!(browser.text(first).parse(), Ok(values[values.len() - 1]));
    let said = || browser.text("return document.querySelector('.listing .said').textContent");
    assert_eq!(said(), format!("25 of {} rows", values.len()));
    browser.press(".listing label:nth-of-type(3) select", "quadratic");
    let count = results.column("filler", &[("filler", "quadratic")]).len();
    assert_eq!(said(), format!("25 of {count} rows"));
}

#[test]
fn a_map_tells_its_cells_and_the_slices_through_them() {
    let Some(browser) = Browser::start() else { return };
    let results = Results::new("filler_map", 2000);
    browser.open(&results.page());
    for (across, down) in [(0.3, 0.3), (0.5, 0.7), (0.8, 0.2), (0.9, 0.8)] {
        let [left, top, width, height] = browser.place(PICTURE);
        browser.click_at((left + across * width, top + down * height), 1);
        let (at, lines) = tip(&browser).unwrap();
        let value = |text: &str| text.rsplit(" = ").next().unwrap().to_owned();
        let (x, y) = (value(&at[0]), value(&at[1]));
        assert_eq!(lines.len(), 2, "const = linear, and quadratic");
        for (name, said) in &lines {
            let filler = name.split(" = ").next().unwrap();
            let filter = [("filler", filler), ("error", "residual")];
            let row = results.row(&[("dt_nu", &x), ("amplitude_noise", &y)], &filter).unwrap();
            let [level, low, high] =
                ["p99_73_arcsec", "p99_73_lo_arcsec", "p99_73_hi_arcsec"].map(|name| row.shown(name));
            assert_eq!(*said, format!("{level}″ 95 %: {low} … {high}"), "{name} at {x}, {y}");
        }
        let slices = browser.ask(
            "return [...document.querySelectorAll(\"[data-chart='0'] .slice h4\")].map((h) => h.textContent)",
            json!(null),
        );
        assert_eq!(slices, json!([at[1], at[0]]), "the slice along x is at this y, and the other way round");
    }
    // The colours of the heat map, with powers of ten and evenly.
    let colours = "return [...document.querySelectorAll(\"[data-chart='1'] .drawing .cells path\")].map((p) => p.getAttribute('fill')).join()";
    let before = browser.text(colours);
    browser.click("[data-chart='1'] .tools button:nth-child(3)");
    assert_ne!(browser.text(colours), before);
    is_silent(&browser);
}

#[test]
fn reports_of_records_and_runs_read_as_their_tables_do() {
    let Some(browser) = Browser::start() else { return };
    for (study, trials, axes, names, filter) in [
        ("lgk400_vs_lgv1", 64, ("tau_s", ("adev", "deg_per_h")), ["noise.file"], None),
        (
            "drift_vs_interval",
            4096,
            ("switching.interval_s", ("drift_p99_73", "deg_per_h")),
            ["run.duration_s"],
            Some(("angle", "end")),
        ),
    ] {
        let results = Results::new(study, trials);
        browser.open(&results.page());
        let filter: Vec<(&str, &str)> = filter.into_iter().collect();
        let read = reads_as_in_the_table(&browser, &results, axes, &names, &filter);
        assert!(read > 20, "{study}: only {read} values were read off");
        is_silent(&browser);
    }
}

#[test]
fn pages_suit_the_dark_phones_and_paper() {
    let Some(browser) = Browser::start() else { return };
    let results = Results::new("error_vs_dtnu", 2000);
    let paper = || browser.text("return getComputedStyle(document.body).backgroundColor");
    browser.open(&results.page());
    assert_eq!(paper(), "rgb(255, 255, 255)");
    browser.click("#theme");
    assert_eq!(paper(), "rgb(20, 23, 26)");
    browser.click("#theme");
    // The choice is kept, until there is none.
    browser.open(&results.page());
    assert_eq!(paper(), "rgb(255, 255, 255)");
    browser.text("localStorage.clear(); return ''");
    let features = json!([{ "name": "prefers-color-scheme", "value": "dark" }]);
    browser.chromium("Emulation.setEmulatedMedia", &json!({ "features": features }));
    browser.open(&results.page());
    assert_eq!(paper(), "rgb(20, 23, 26)");

    // On paper it is light again, without what cannot be pressed there.
    browser.chromium("Emulation.setEmulatedMedia", &json!({ "media": "print", "features": features }));
    assert_eq!(browser.text("return getComputedStyle(document.querySelector('.tools')).display"), "none");
    assert_eq!(browser.text("return getComputedStyle(document.documentElement).colorScheme"), "light");
    let printed = browser.chromium("Page.printToPDF", &json!({ "printBackground": true }));
    assert!(printed["data"].as_str().unwrap().starts_with("JVBERi0"), "no PDF");
    browser.chromium("Emulation.setEmulatedMedia", &json!({ "media": "", "features": [] }));

    let phone = json!({ "width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": true });
    browser.chromium("Emulation.setDeviceMetricsOverride", &phone);
    browser.open(&results.page());
    assert_eq!(browser.number("return document.documentElement.scrollWidth"), 390.0, "nothing sticks out");
    let small =
        "return Math.min(...[...document.querySelectorAll('.tools button')].map((b) => b.offsetHeight))";
    assert!(browser.number(small) >= 30.0, "buttons can be touched");
    is_silent(&browser);
    for results in [results, Results::new("which_filler", 64), Results::new("quantizer", 64)] {
        browser.open(&results.page());
        let top = browser
            .number("return document.querySelector('[data-chart]').getBoundingClientRect().top + scrollY");
        assert!(top < 500.0, "the first chart of {} begins at {top} px", results.page().display());
    }
}

#[test]
fn axes_on_phones_have_three_labels_that_are_spread_and_not_cut() {
    let Some(browser) = Browser::start() else { return };
    let phone = json!({ "width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": true });
    browser.chromium("Emulation.setDeviceMetricsOverride", &phone);
    for study in ["best_filler", "optimal_interval", "relock_tables", "suspension", "my_gyro"] {
        let results = Results::new(study, 64);
        browser.open(&results.page());
        // For each axis of each chart: the number of labels, the widest gap as a part of the axis, and what is cut off.
        let script = "return [...document.querySelectorAll('.drawing > svg')].flatMap((svg) => {
            const box = svg.getBoundingClientRect();
            const frame = svg.querySelector('clipPath rect').getBBox();
            const texts = [...svg.querySelectorAll('.axes text:not(.title)')].map((text) => text.getBBox());
            const x = texts.filter((text) => text.y > frame.y + frame.height - 4);
            const y = texts.filter((text) => text.y <= frame.y + frame.height - 4);
            const gap = (places) => Math.max(...places.sort((a, b) => a - b).map((place, at) => place - (at ? places[at - 1] : 0)), 1 - places.at(-1));
            const xs = x.map((text) => (text.x + text.width / 2 - frame.x) / frame.width);
            const ys = y.map((text) => (text.y + text.height / 2 - frame.y) / frame.height);
            const cut = Math.max(0, ...x.map((text) => text.x + text.width - svg.viewBox.baseVal.width));
            return [[xs.length, gap(xs), cut], [ys.length, gap(ys), 0]];
        })";
        let axes: Vec<[f64; 3]> = serde_json::from_value(browser.ask(script, json!(null))).unwrap();
        assert!(!axes.is_empty(), "{study}");
        for [labels, gap, cut] in axes {
            assert!(
                labels >= 3.0 && gap <= 0.65 && cut <= 0.5,
                "{study}: {labels} labels, {gap} apart, {cut} px cut"
            );
        }
    }
}

#[test]
fn without_scripts_every_chart_is_a_still_picture_that_fits() {
    let Some(browser) = Browser::start() else { return };
    let results = Results::new("filler_map", 64);
    browser.chromium("Emulation.setScriptExecutionDisabled", &json!({ "value": true }));
    browser.begin(&results.page());
    let shown = |of: &str| {
        let script = "return [...document.querySelectorAll(arguments[0])].map((each) => each.getBoundingClientRect().width)";
        serde_json::from_value::<Vec<f64>>(browser.ask(script, json!(of))).unwrap()
    };
    let pictures = shown(".still > svg");
    assert!(pictures.len() == 2 && pictures.iter().all(|width| *width > 600.0), "{pictures:?}");
    for gone in ["#theme", ".reading", "figcaption"] {
        assert!(shown(gone).iter().all(|width| *width == 0.0), "{gone} is shown");
    }
    // Tables have their first rows, with the values of the file.
    let rows = shown("#tables tbody tr");
    assert!(rows.len() == 25 && rows.iter().all(|width| *width > 300.0), "{rows:?}");
    let said = browser.text("return document.querySelector('#tables .said').textContent");
    assert!(said.starts_with("25 of "), "{said}");
    // On paper the pictures are as wide as the page, and nothing of them is cut.
    browser.chromium("Emulation.setEmulatedMedia", &json!({ "media": "print" }));
    let script =
        "return [...document.querySelectorAll('.still')].map((each) => each.scrollWidth - each.clientWidth)";
    assert_eq!(browser.ask(script, json!(null)), json!([0, 0]));
}
