//! Reports of what is little, nothing or very much.

use sagnac::report::answer::Answer;
use sagnac::report::chart::Picture;
use sagnac::report::page::{Block, Page, Section};
use sagnac::table::Table;
use sagnac::view::Drawn;
use sagnac::view::from_table;
use sagnac_engine::chart::{Chart, Shows};
use serde_json::json;
use tempfile::TempDir;

use super::fillers::{chart, table};
use super::{PICTURE, is_silent, point_at, tip};
use crate::browser::Browser;

fn page(table: &Table) -> String {
    page_of(table, &chart("Edges"))
}

fn page_of(table: &Table, chart: &Chart) -> String {
    let (figure, notes) = from_table::figure(table, chart).unwrap();
    let drawn = Drawn { stem: "chart".to_owned(), picture: Picture::Curves(figure), note: notes.sentence() };
    let charts = Section { id: "charts", heading: "Charts", blocks: vec![Block::Chart(drawn)] };
    let page = Page {
        title: "Edges".to_owned(),
        subtitle: String::new(),
        scope: String::new(),
        answer: Answer::default(),
        notes: vec![],
        sections: vec![charts],
        tables: vec![("points.csv", table.clone())],
    };
    page.html(&str::to_owned)
}

/// Opens a page of a table; the folder holds it.
fn opened(browser: &Browser, table: &Table) -> TempDir {
    opened_as(browser, table, &chart("Edges"))
}

fn opened_as(browser: &Browser, table: &Table, chart: &Chart) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("report.html");
    std::fs::write(&path, page_of(table, chart)).unwrap();
    println!("{} rows: open after {} ms", table.rows(), browser.open(&path).as_millis());
    folder
}

#[test]
fn ten_thousand_points_make_a_page_that_can_be_sent() {
    let many = table(10_000, |point, filler| Some(1.0 + filler as f64 + libm::sin(point as f64)));
    let html = page(&many);
    assert!(html.len() < 1_500_000, "{} bytes", html.len());
    let Some(browser) = Browser::start() else { return };
    let _folder = opened(&browser, &many);
    point_at(&browser, PICTURE, (0.5, 0.5));
    assert_eq!(tip(&browser).unwrap().1.len(), 3);
    is_silent(&browser);
}

#[test]
fn one_point_is_drawn_with_its_interval() {
    let Some(browser) = Browser::start() else { return };
    let _folder = opened(&browser, &table(1, |_, filler| Some(3.0 + filler as f64)));
    point_at(&browser, PICTURE, (0.5, 0.5));
    let (at, lines) = tip(&browser).unwrap();
    assert_eq!(at, ["motion.frequency 1 Hz"]);
    assert_eq!(lines.len(), 3);
    assert!(lines.contains(&("linear".to_owned(), "4″ 95 % band: 3.96 … 4.04".to_owned())), "{lines:?}");
    is_silent(&browser);
}

#[test]
fn fillers_of_one_point_stand_side_by_side() {
    let Some(browser) = Browser::start() else { return };
    let shows = Shows::Curves { series: vec![], laws: vec![] };
    let chart = Chart { x: "filler".into(), shows, ..chart("Edges") };
    let _folder = opened_as(&browser, &table(1, |_, filler| Some(3.0 + filler as f64)), &chart);
    for (across, name, value) in [(0.3, "const", "3″"), (0.55, "linear", "4″"), (0.85, "quadratic", "5″")]
    {
        point_at(&browser, PICTURE, (across, 0.5));
        let (at, lines) = tip(&browser).unwrap();
        assert_eq!(at, [name]);
        assert!(lines.len() == 1 && lines[0].1.starts_with(value), "{lines:?}");
    }
    let buttons = browser
        .text("return [...document.querySelectorAll('.tools button')].map((b) => b.textContent).join(' ')");
    assert!(buttons.starts_with("y log") && !buttons.contains("x log"), "{buttons}");
    is_silent(&browser);
}

#[test]
fn zeros_are_shown_on_a_linear_axis_and_points_that_failed_not_at_all() {
    let Some(browser) = Browser::start() else { return };
    let _folder = opened(&browser, &table(5, |_, _| Some(0.0)));
    point_at(&browser, PICTURE, (0.5, 0.5));
    let (_, lines) = tip(&browser).unwrap();
    assert!(lines.iter().all(|(_, said)| said.starts_with("0″")), "{lines:?}");

    // The third of five points has no value: nothing to be read off, and empty cells.
    let _folder = opened(&browser, &table(5, |point, _| (point != 2).then_some(2.0 + point as f64)));
    point_at(&browser, PICTURE, (0.5, 0.5));
    let (at, _) = tip(&browser).unwrap();
    assert_ne!(at, ["motion.frequency 1.02 Hz"]);
    let cells = browser.ask("return [...document.querySelectorAll('.listing tbody tr')].slice(6, 9).map((r) => r.cells[2].textContent)", json!(null));
    assert_eq!(cells, json!(["", "", ""]));
    let _folder = opened(&browser, &table(3, |_, _| None));
    let said = browser.text(&format!("return document.querySelector(\"{PICTURE} .nothing\").textContent"));
    assert_eq!(said, "no value has a place on these axes");
    is_silent(&browser);
}
