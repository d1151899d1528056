//! The pages of analyses: that of a log, which `sagnac allan` writes, of two which are compared, of a batch, of a
//! model for filters, of a design, of fillers and of a sensitivity.
//!
//! ```text
//! Temperature ─ of_temperature ──┐
//! Dynamic ─ of_dynamic ──────────┴▶ Sections ─┐
//! Log, Analysis with its spectra ─────────────┴ of_log ─▶ Page
//! two Logs, their comparison ──────────── of_comparison ─▶ Page
//! Lot, Design, Firmware ─── of_lot, of_design, of_filler ─▶ Page
//! models for filters ─────────────────────────── of_model ─▶ Page
//! Sensitivity ────────────────────────── of_sensitivity ─▶ Page
//! ```

mod coefficients;
mod comparison;
mod curves;
mod design;
mod filler;
mod further;
mod longer;
mod lot;
mod model;
mod record;
mod sensitivity;
mod spectrum;
mod trace;
mod values;
mod weights;

pub use crate::analysis::page::comparison::of_comparison;
pub use crate::analysis::page::design::of_design;
pub use crate::analysis::page::filler::of_filler;
pub use crate::analysis::page::further::{of_dynamic, of_navigators, of_temperature};
pub use crate::analysis::page::lot::of_lot;
pub use crate::analysis::page::model::of_model;
pub use crate::analysis::page::sensitivity::of_sensitivity;

use crate::analysis::log::{self, events, figures, noise_file, notes};
use crate::analysis::page::values::range;
use crate::analysis::spectrum::{Analysis, NoSpectrum, notes as spectrum_notes, tables};
use crate::answer::Answer;
use crate::record::log::channel::Log;
use crate::study::Study;
use crate::view::chart::figure::Figure;
use crate::view::chart::picture::Picture;
use crate::view::picture::Drawn;
use crate::view::report::sections::{Block, Cell, Grid, Page, Section};

/// The page of a log from its analysis and its answer. If it has no spectra, `without` says why.
pub fn of_log(log: &Log, analysis: &Analysis, answer: Answer, without: Option<&NoSpectrum>) -> Page {
    let noise = &analysis.noise;
    let file = noise.path.file_name().unwrap_or(noise.path.as_os_str()).to_string_lossy();
    let has_spectra = !analysis.spectra.is_empty();
    let of_spectra = has_spectra.then(|| {
        [("lines.csv", tables::lines(analysis)), ("white_noise.csv", tables::white_noise(analysis))]
    });
    let of_noise = [
        ("coefficients.csv", log::tables::coefficients(noise)),
        ("curve.csv", log::tables::table(noise)),
        ("events.csv", events::table(noise)),
        ("records.csv", tables::records(analysis)),
    ];
    let sections = [
        deviations(noise),
        coefficients::section(noise),
        spectrum::section(analysis, without),
        shown("What this record shows", &events::rows(noise)),
        record::section(log, noise),
    ];
    Page {
        title: format!("Noise of {file}"),
        subtitle: format!("{}; {}", notes::heading(noise), noise.treatment.summary()),
        answer,
        notes: spectrum_notes::notes(analysis).into_iter().chain(noise_file::notes(noise)).collect(),
        sections: sections.into(),
        tables: of_noise.into_iter().chain(of_spectra.into_iter().flatten()).collect(),
    }
}

/// The section on what records show besides noise.
fn shown(heading: &'static str, rows: &[events::Row]) -> Section {
    let head = events::HEADING.map(str::to_owned).into();
    let rows = events::list(rows).into_iter().map(|line| line.into_iter().map(Cell::from).collect());
    let grid = Grid { head, rows: rows.collect() };
    let blocks = if grid.rows.is_empty() { vec![] } else { vec![Block::Grid(grid)] };
    Section { id: "events", heading, blocks }
}

/// The section on the curves, with the range of the fit if there is a single column.
fn deviations(noise: &log::Analysis) -> Section {
    let fit = match &noise.columns[..] {
        [column] => column.noise().map(|noise| &noise.fit).filter(|fit| fit.is_described()),
        _ => None,
    };
    let of_figure = |(stem, mut figure): (String, Figure)| {
        if let Some(fit) = fit {
            figure.lines = format!("{}, {}", figure.lines, range(fit));
        }
        chart(&stem, Picture::Curves(figure))
    };
    let residuals = figures::residuals(noise).map(|figure| chart("residuals", Picture::Curves(figure)));
    let mut blocks: Vec<Block> = figures::figures(noise).into_iter().map(of_figure).collect();
    // Right below the curve.
    if let Some(residuals) = residuals {
        blocks.insert(blocks.len().min(1), residuals);
    }
    blocks.extend(curves::tables(noise));
    Section { id: "deviations", heading: "Deviations", blocks }
}

/// The text of a study, with this number of trials.
fn study_file(study: &Study, trials: u64) -> Block {
    Block::File("study.toml", study.resolved(trials))
}

fn chart(stem: &str, picture: Picture) -> Block {
    Block::Chart(Drawn { stem: stem.to_owned(), picture, note: None })
}
