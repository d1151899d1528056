//! Notes attached to the results of a comparison.

use crate::analysis::compare::NEAREST;
use crate::analysis::compare::logs::{Analysis, Side};
use sagnac_base::quantity::number::significant;
use sagnac_records::events::Event;
use sagnac_records::record::log::measure::Data;

/// All notes on the results.
pub fn notes(analysis: &Analysis) -> Vec<String> {
    let mut notes: Vec<String> = analysis.sides.iter().flat_map(|side| of_side(side, analysis)).collect();
    let common = &analysis.comparison.common;
    if common.farthest > 0.0 {
        notes.push(format!(
            "the averaging times of the records are up to {} % apart; those of {} are shown",
            significant(100.0 * common.farthest, 2),
            analysis.labels()[0]
        ));
    }
    if common.left_out > 0 {
        notes.push(format!(
            "{} averaging times are omitted, because the other record has none within {} %",
            common.left_out,
            significant(100.0 * NEAREST, 2)
        ));
    }
    if let Err(why) = &analysis.rows {
        notes.push(format!("no coefficients: {why}"));
    }
    notes
}

fn of_side(side: &Side, analysis: &Analysis) -> Vec<String> {
    let mut notes: Vec<String> = side.reading.iter().map(|note| format!("{}: {note}", side.label)).collect();
    if let Some(unit) = &side.overruled {
        notes.push(format!("{}: the header says {unit}, but the given unit was used", side.label));
    }
    if side.missing > 0 {
        notes.push(format!(
            "{}: {} of {} samples are missing; terms that touch a gap are left out, and intervals of coefficients count \
             gaps by the number of their samples only",
            side.label, side.missing, side.samples
        ));
    }
    let count = side.outliers.samples.len();
    if count > 0 {
        let of = if side.data == Data::Angle { " among the increments" } else { "" };
        let named = if count == 1 { "outlier" } else { "outliers" };
        let are_in_events =
            side.outliers.samples.iter().all(|&sample| Event::is_in(&side.events.list, sample));
        let fate = match analysis.treatment().outliers_removed {
            true => "treated as gaps",
            false if are_in_events => "left out with their events",
            false => "kept; `remove_outliers = true` treats them as gaps",
        };
        notes.push(format!("{}: {count} {named}{of}: {fate}", side.label));
    }
    notes
}
