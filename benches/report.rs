//! The page of a study: `cargo bench --bench report`.

#[path = "../tests/program/report/fillers.rs"]
mod fillers;

use fillers::{cells, chart, column};
use sagnac::report::answer::Answer;
use sagnac::report::chart::Picture;
use sagnac::report::page::{Block, Page, Section};
use sagnac::table::{Table, Unit};
use sagnac::view::Drawn;
use sagnac::view::from_table;

fn main() {
    divan::main();
}

/// `points` points of three fillers over the frequency, with intervals and closed forms.
fn table(points: usize) -> Table {
    let error = |point: usize, filler: usize| Some(1.0 + filler as f64 + libm::sin(point as f64));
    let mut table = fillers::table(points, error);
    let z = cells(points, |point, filler| Some(libm::sin((point + filler) as f64)));
    table.columns.push(column("theory_rms", Unit::ARCSEC, cells(points, error)));
    table.columns.push(column("z", Unit::NONE, z));
    table
}

/// The text of the page from the table.
#[divan::bench(args = [72, 1000, 10_000])]
fn page(bencher: divan::Bencher, points: usize) {
    let table = table(points);
    bencher.bench_local(|| {
        let (figure, _) = from_table::figure(&table, &chart("Errors")).unwrap();
        let drawn = Drawn { stem: "chart".to_owned(), picture: Picture::Curves(figure), note: None };
        let charts = Section { id: "charts", heading: "Charts", blocks: vec![Block::Chart(drawn)] };
        let page = Page {
            title: "Errors".to_owned(),
            subtitle: "How large are they?".to_owned(),
            scope: String::new(),
            answer: Answer::default(),
            notes: vec![],
            sections: vec![charts],
            tables: vec![("points.csv", table.clone())],
        };
        page.html(&str::to_owned)
    });
}
