//! The page of fillers for firmware.

use crate::analysis::firmware::{Candidate, Design, Firmware, Trade};
use crate::analysis::page::{chart, study_file, weights};
use crate::kinds::gap_fill::judged::{Judged, deviation};
use crate::quantity::number::significant;
use crate::study::Study;
use crate::view::chart::picture::Picture;
use crate::view::report::sections::{Block, Grid, Page, Section};

/// The page of fillers at a point of a study.
pub fn of_filler(study: &Study, firmware: &Firmware) -> Page {
    let ticks = if firmware.gap_ticks == 1 { "tick" } else { "ticks" };
    let place = firmware.place();
    let place = if place.is_empty() { place } else { format!(", at {place}") };
    let search = firmware.trade.as_ref().map_or(vec![], |trade| {
        vec![chart("trade", Picture::Curves(trade.figure())), Block::Grid(of_trade(trade))]
    });
    let fillers = std::iter::once(Block::Grid(of_designs(firmware)));
    let weights = firmware.designs.iter().flat_map(|design| weights::blocks(firmware, design));
    let header =
        vec![Block::File("sagnac_filler.h".to_owned(), firmware.header()), study_file(study, study.trials)];
    let trade = firmware.trade.as_ref().map(|trade| ("trade.csv", trade.table()));
    Page {
        title: firmware.title.clone(),
        scope: String::new(),
        subtitle: format!("Weights for a gap of {} lost {ticks}{place}", firmware.gap_ticks),
        answer: firmware.answer(),
        notes: vec![],
        sections: vec![
            Section::new("search", "Ticks before and after the gap", search),
            Section::new("fillers", "Fillers", fillers.chain(weights)),
            Section::new(
                "response",
                "Response to vibration",
                [chart("response", Picture::Curves(firmware.response()))],
            ),
            Section::new("source", "For the firmware", header),
        ],
        tables: trade.into_iter().chain([("weights.csv", firmware.weights())]).collect(),
    }
}

/// The fillers with the errors of their residuals.
fn of_designs(firmware: &Firmware) -> Grid {
    let size = if firmware.shift.is_none() { "99.73 %" } else { "rms" };
    let shifted = format!("{size} with {}, ″", deviation(firmware.shift));
    let head = ["filler", "ticks", "noise gain √Σw²", "rms residual, ″", &shifted];
    let of_shifted = |Judged { shifted, .. }: Judged| match firmware.shift {
        None => shifted.level,
        Some(_) => shifted.rms,
    };
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| significant(value, 4));
    let row = |design: &Design| {
        let rule = &design.interpolation;
        let ticks: Vec<String> = rule.ticks.iter().map(|tick| tick.to_string().replace('-', "−")).collect();
        [
            design.name.clone(),
            ticks.join(", "),
            significant(rule.whole().noise_gain(), 4),
            number(design.errors[0].rms),
            number(design.judged.map(of_shifted)),
        ]
    };
    Grid::new(head, firmware.designs.iter().map(row))
}

/// The best numbers of ticks before the gap for each number after it.
fn of_trade(trade: &Trade) -> Grid {
    let head = ["ticks after", "latency, ms", "ticks before", "rms, ″", "99.73 %, ″"];
    let row = |one: Candidate| {
        let Candidate { before, after, rms, level, .. } = one;
        let [latency, rms, level] =
            [1e3 * trade.latency_s(one), rms, level].map(|value| significant(value, 4));
        [after.to_string(), latency, before.to_string(), rms, level]
    };
    Grid::new(head, trade.rows().into_iter().map(row))
}
