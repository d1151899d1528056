//! Studies written as text, run on the processor, and the rows of their tables.
#![allow(dead_code, reason = "each test binary uses a part")]

use std::path::Path;

use sagnac::device::{Cpu, Device};
pub use sagnac::progress::Silent;
use sagnac::run::Plan;
use sagnac::store::Store;
use sagnac::study::Study;
use sagnac::table::{Cell, Table};
use sagnac::tally::Share;
use sagnac_engine::kinds::gap_fill::GapFill;
use sagnac_engine::kinds::gap_fill::inputs::Point;
use sagnac_engine::kinds::gap_fill::lower::Lowered;
use sagnac_kernel::width::Width;

/// The study of a text; `name` may hold a folder, where records are then looked for.
pub fn parsed(name: &str, text: &str) -> Study {
    Study::parse(name, text).unwrap_or_else(|error| panic!("{}", error.render(false, 100)))
}

/// What a gap-fill study asks.
pub fn gap_fill(study: &Study) -> &GapFill {
    study.asked::<sagnac_engine::kinds::gap_fill::GapFill>().unwrap()
}

/// A point of it, ready to be sampled.
pub fn lowered(study: &Study, point: &Point) -> Lowered {
    let GapFill { fillers, errors, .. } = gap_fill(study);
    Lowered::new(point, fillers, errors, study.seed, study.streams).unwrap()
}

fn committed() -> String {
    let path = Path::new(crate::ROOT).join("studies/error_vs_dtnu.toml");
    std::fs::read_to_string(path).unwrap()
}

/// The committed study with some of its text replaced; each piece must be there.
pub fn study(changes: &[(&str, &str)]) -> Study {
    let mut text = committed();
    for (from, to) in changes {
        assert!(text.contains(from), "`{from}` is not in the study");
        text = text.replace(from, to);
    }
    parsed("study.toml", &text)
}

pub const ALL_FREQUENCIES: &str = r#"log = { from = "2 Hz", to = "40 Hz", points = 24 }"#;
pub const AT_20_HZ: (&str, &str) = (ALL_FREQUENCIES, r#"list = ["20 Hz"]"#);

/// The paper's point at n = 3 alone.
pub fn papers_point(trials: &'static str) -> Vec<(&'static str, &'static str)> {
    vec![AT_20_HZ, ("list = [1, 2, 3]", "list = [3]"), ("1_000_000", trials)]
}

/// Runs a study in a folder.
pub fn run(study: &Study, folder: &Path) -> Table {
    let plan = Plan::new(study).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
    let mut store = Store::open(folder, &plan.identity()).unwrap();
    let mut device = Device::Cpu(Cpu::new(Width::widest(), 0).unwrap());
    plan.run(&mut store, &mut device, Share::WHOLE, &Silent).unwrap();
    plan.tables(&store, &Silent).unwrap().points
}

/// Runs a study in a folder of its own.
pub fn run_afresh(study: &Study) -> Table {
    run(study, tempfile::tempdir().unwrap().path())
}

/// One row by the names of its columns.
pub struct Row<'a> {
    table: &'a Table,
    index: usize,
}

impl Row<'_> {
    fn cell(&self, name: &str) -> &Cell {
        let column = self.table.columns.iter().find(|column| column.name == name);
        &column.unwrap_or_else(|| panic!("no column {name}")).cells[self.index]
    }

    /// A number; absent where the cell is blank.
    pub fn maybe(&self, name: &str) -> Option<f64> {
        self.cell(name).number()
    }

    pub fn number(&self, name: &str) -> f64 {
        self.maybe(name).unwrap_or_else(|| panic!("{name} is blank in {}", self.place()))
    }

    pub fn text(&self, name: &str) -> String {
        self.cell(name).text()
    }

    /// All of it, for messages.
    pub fn place(&self) -> String {
        let cells = self
            .table
            .columns
            .iter()
            .map(|column| format!("{} {}", column.name, column.cells[self.index].text()));
        cells.collect::<Vec<_>>().join(", ")
    }
}

pub fn rows(table: &Table) -> impl Iterator<Item = Row<'_>> {
    (0..table.columns[0].cells.len()).map(move |index| Row { table, index })
}
