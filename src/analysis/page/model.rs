//! The page of a model for a filter.

use crate::analysis::log::events;
use crate::analysis::model::discrete;
use crate::analysis::model::report::notes;
use crate::analysis::model::target::Target;
use crate::analysis::model::{Analysis, Column, report, tables};
use crate::analysis::page::{chart, grid_where, shown, texts};
use sagnac_base::quantity::number::significant;
use sagnac_base::table::{Table, titled};
use sagnac_records::allan::Deviation;
use sagnac_report::chart::Picture;
use sagnac_report::page::{Block, Cell, Grid, Page, Section};

/// The page of the models of a log or a noise.toml, with the texts of files for tools by their names.
pub fn of_model(analysis: &Analysis, texts: &[(&'static str, String)]) -> Page {
    let charts = report::figures(analysis).into_iter();
    let charts = charts.map(|(stem, figure)| chart(&stem, Picture::Curves(figure)));
    let columns = || analysis.columns.iter();
    let table = tables::table(analysis);
    let curves: Vec<Block> = charts.chain(columns().map(|column| curve(&table, column))).collect();
    let coefficients = columns().map(|column| Block::Grid(coefficients(column)));
    let at_rate = columns().flat_map(|column| matrices(analysis, column));
    let files = texts.iter().map(|(name, text)| Block::File((*name).to_owned(), text.clone()));
    Page {
        title: format!(
            "Noise model of {}",
            analysis.source.path.file_name().unwrap_or_default().to_string_lossy()
        ),
        scope: String::new(),
        subtitle: format!("What does a filter need to know of this noise? {}", analysis.source.heading),
        answer: analysis.answer(),
        notes: notes(analysis),
        sections: vec![
            shown("What this record shows", &analysis.events()),
            Section::new("curve", "Curve and model", curves),
            Section::new("coefficients", "Coefficients", coefficients),
            Section::new("discrete", "At the rate of the filter", at_rate),
            Section::new("files", "Files for tools", files),
        ],
        tables: vec![("model.csv", table), ("events.csv", events::table_of(&analysis.events()))],
    }
}

/// The numbers of a column in the units that people use.
fn coefficients(column: &Column) -> Grid {
    let rows = tables::figures(column)
        .into_iter()
        .filter(|figure| figure.value > 0.0)
        .map(|figure| [figure.name, significant(figure.value, 5), figure.unit.to_owned()].map(Cell::from));
    let symbol = column.target.unit.symbol(Deviation::Oadev);
    let state = column.found.model.markov.iter().map(|state| {
        let time = format!("correlation time {} s", significant(state.time_s, 5));
        ["Markov state".into(), Cell { text: significant(state.sigma, 5), below: time }, symbol.into()]
    });
    Grid::new([&column.target.name, "value", "unit"], rows.chain(state))
}

/// The curve of a column beside that of its model, in the table of all columns.
fn curve(table: &Table, column: &Column) -> Block {
    let Target { name, unit, .. } = &column.target;
    let names = texts(table, "column");
    let title = format!("{name}: {}", titled("Allan deviation", unit.symbol(Deviation::Oadev)));
    Block::More(title, grid_where(table, &["column", "unit"], |row| names[row] == *name))
}

/// F and Q of a column.
fn matrices(analysis: &Analysis, column: &Column) -> Vec<Block> {
    let Some(filter_hz) = analysis.filter_hz() else { return vec![] };
    let [_, longest_s] = column.target.taus();
    let found = discrete(&column.found.model, column.target.unit, 1.0 / filter_hz, longest_s);
    let matrix = |name: &str, rows: &[Vec<f64>]| {
        let head = std::iter::once(name).chain(found.names.iter().map(String::as_str));
        let row = |(name, row): (&String, &Vec<f64>)| {
            std::iter::once(name.clone()).chain(row.iter().map(|x| significant(*x, 6))).collect::<Vec<_>>()
        };
        Block::Grid(Grid::new(head, found.names.iter().zip(rows).map(row)))
    };
    let said = format!(
        "{}: steps of {} s, in SI units. The initial variance of the random walk is what it accumulates over the longest τ; add the square of \
         the turn-on bias, which a record does not show.",
        column.target.name,
        significant(found.step_s, 6)
    );
    let variances = |all: Vec<String>| {
        found.names.iter().cloned().zip(all).map(|(name, x)| format!("{name}: {x}")).collect()
    };
    let stationary =
        found.stationary.iter().map(|x| x.map_or_else(|| "none".to_owned(), |x| significant(x, 6)));
    let initial = found.initial.iter().map(|x| significant(*x, 6));
    let facts = Block::Facts(vec![
        ("Measurement noise R of the angle", vec![significant(found.reading, 6)]),
        ("Variance of a rate sample", vec![significant(found.rate, 6)]),
        ("Stationary variance", variances(stationary.collect())),
        ("Initial variance", variances(initial.collect())),
    ]);
    vec![Block::Text(said), matrix("F", &found.transition), matrix("Q", &found.added), facts]
}
