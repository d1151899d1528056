//! The page of a study: `cargo bench --bench report`.

#[path = "../tests/program/report/fillers.rs"]
mod fillers;

use fillers::{cells, chart, column};
use sagnac::answer::Answer;
use sagnac::table::{Table, Unit};
use sagnac::view::chart::figure::Figure;
use sagnac::view::chart::picture::Picture;
use sagnac::view::picture::Drawn;
use sagnac::view::report::Report;
use sagnac::view::report::source::Source;

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
        let (figure, _) = Figure::from_table(&table, &chart("Errors")).unwrap();
        let drawn = Drawn { stem: "chart".to_owned(), picture: Picture::Curves(figure), note: None };
        let report = Report {
            title: "Errors",
            question: "How large are they?",
            answer: &Answer::default(),
            notes: &[],
            charts: &[drawn],
            tables: vec![(sagnac::chart::Source::Points, &table)],
            source: &Source {
                inputs: vec![],
                study: String::new(),
                kind: &sagnac::kinds::gap_fill::kind::GAP_FILL,
                sampled: Some((1, 1000)),
                stops: false,
                lacking: 0,
                points,
                counts_again: false,
                provenance: vec![],
                kernels: "gap_fill 2".to_owned(),
            },
            digest: "",
        };
        report.html()
    });
}
