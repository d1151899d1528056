//! The page of fillers for firmware.

use crate::analysis::firmware::{Candidate, Firmware, Trade};
use crate::analysis::page::values::grid;
use crate::analysis::page::{chart, study_file, weights};
use crate::quantity::number::significant;
use crate::study::Study;
use crate::view::chart::picture::Picture;
use crate::view::report::sections::{Block, Cell, Grid, Page, Section};

/// The page of fillers at a point of a study.
pub fn of_filler(study: &Study, firmware: &Firmware) -> Page {
    let place = firmware.place();
    let place = if place.is_empty() { place } else { format!(", at {place}") };
    let section = |id, heading, blocks| Section { id, heading, blocks };
    let search = firmware.trade.as_ref().map_or(vec![], |trade| {
        vec![chart("trade", Picture::Curves(trade.figure())), Block::Grid(of_trade(trade))]
    });
    let fillers = firmware.fillers();
    let of_fillers = std::iter::once(Block::Grid(grid(&fillers, &["largest_input", "method"])));
    let weights = firmware.designs.iter().flat_map(|design| weights::blocks(firmware, design));
    let header = vec![Block::File("sagnac_filler.h", firmware.header()), study_file(study, study.trials)];
    let trade = firmware.trade.as_ref().map(|trade| ("trade.csv", trade.table()));
    Page {
        title: firmware.title.clone(),
        subtitle: format!("Weights for a gap of {}{place}", firmware.lost()),
        answer: firmware.answer(),
        notes: vec![],
        sections: vec![
            section("search", "Ticks before and after the gap", search),
            section("fillers", "Fillers", of_fillers.chain(weights).collect()),
            section(
                "response",
                "Response to vibration",
                vec![chart("response", Picture::Curves(firmware.response()))],
            ),
            section("source", "For the firmware", header),
        ],
        tables: trade
            .into_iter()
            .chain([("fillers.csv", fillers), ("weights.csv", firmware.weights())])
            .collect(),
    }
}

/// The best numbers of ticks before the gap for each number after it.
fn of_trade(trade: &Trade) -> Grid {
    let head = ["ticks after", "latency, ms", "ticks before", "rms, ″", "99.73 %, ″"];
    let row = |one: Candidate| {
        let Candidate { before, after, rms, level, .. } = one;
        let [latency, rms, level] =
            [1e3 * trade.latency_s(one), rms, level].map(|value| significant(value, 4));
        [after.to_string(), latency, before.to_string(), rms, level].map(Cell::from).into()
    };
    Grid { head: head.map(str::to_owned).into(), rows: trade.rows().into_iter().map(row).collect() }
}
