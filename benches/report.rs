//! The page of a study: `cargo bench --bench report`.

use sagnac::chart::Picture;
use sagnac::chart::{Figure, Scale, Spec};
use sagnac::picture::Drawn;
use sagnac::report::{Answer, Report, Source};
use sagnac::table::{Cell, Column, Table, Unit};

fn main() {
    divan::main();
}

/// So many points of three fillers over the frequency, with intervals and closed forms.
fn table(points: usize) -> Table {
    let rows = || (0..points).flat_map(|point| (0..3).map(move |filler| (point as f64, filler)));
    let numbers =
        |of: fn(f64, usize) -> f64| rows().map(|(point, filler)| Cell::Number(of(point, filler))).collect();
    let error = |point: f64, filler: usize| 1.0 + filler as f64 + libm::sin(point);
    let column = |name: &str, unit, cells| Column {
        name: name.to_owned(),
        label: name.to_owned(),
        unit,
        cells,
        band: None,
    };
    let names = ["const", "linear", "quadratic"];
    let mut rms = column("rms", Unit::ARCSEC, numbers(error));
    rms.band = Some(
        rows()
            .map(|(point, filler)| Some((0.99 * error(point, filler), 1.01 * error(point, filler))))
            .collect(),
    );
    Table {
        columns: vec![
            column("motion.frequency", Unit::HZ, numbers(|point, _| 1.0 + 0.01 * point)),
            column("filler", Unit::NONE, rows().map(|row| Cell::Text(names[row.1].to_owned())).collect()),
            column("trials", Unit::NONE, rows().map(|_| Cell::Integer(1000)).collect()),
            rms,
            column("oracle_rms", Unit::ARCSEC, numbers(error)),
            column("z", Unit::NONE, numbers(|point, filler| libm::sin(point + filler as f64))),
        ],
    }
}

fn spec() -> Spec {
    Spec {
        title: "Errors".to_owned(),
        subtitle: None,
        x: "frequency".to_owned(),
        y: "rms".to_owned(),
        x_scale: Scale::Log,
        y_scale: Scale::Log,
        series: vec!["filler".to_owned()],
        apart: vec![],
        filter: vec![],
        limit: Some((10.0, Unit::ARCSEC)),
        laws: vec![],
        points: "Monte Carlo".to_owned(),
        bands: "95 % band".to_owned(),
    }
}

/// From the table to the text of the page.
#[divan::bench(args = [72, 1000, 10_000])]
fn page(bencher: divan::Bencher, points: usize) {
    let table = table(points);
    bencher.bench_local(|| {
        let (figure, _) = Figure::from_table(&table, &spec()).unwrap();
        let drawn = Drawn { stem: "chart".to_owned(), picture: Picture::Curves(figure), note: None };
        let report = Report {
            title: "Errors",
            question: "How large are they?",
            answer: Answer::default(),
            notes: &[],
            charts: &[drawn],
            tables: vec![("points.csv", &table)],
            source: Source {
                inputs: vec![],
                study: String::new(),
                kind: "gap-fill".to_owned(),
                sampled: Some((1, 1000)),
                stops: false,
                lacking: 0,
                points,
                provenance: vec![],
                kernels: "gap_fill 2".to_owned(),
            },
        };
        report.html()
    });
}
