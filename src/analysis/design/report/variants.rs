//! The variants of a design in words.

use crate::analysis::decision::{Sheet, short};
use crate::analysis::design::{Design, Filler, Variant};
use sagnac_engine::key::sweep::Swept;

/// Each value of a variant with the label of its key, such as `time constant of the loop 3 ms`.
pub(crate) fn told(found: &Design, variant: &Variant) -> Vec<String> {
    let each = found.keys().into_iter().zip(&variant.swept);
    each.map(|(sweep, (_, value))| format!("{} {}", sweep.key.label, shown(value))).collect()
}

/// Names a choice: its filler and the values of swept keys.
pub(crate) fn named(found: &Design, variant: &Variant, filler: &Filler) -> String {
    filler.name.iter().cloned().chain(told(found, variant)).collect::<Vec<_>>().join(", ")
}

/// Makes the options of a decision sheet those of the design: each filler with each combination of swept values.
pub(crate) fn name_in(sheet: &mut Sheet, found: &Design) {
    sheet.options = found.variants.iter().map(|variant| variant.fillers.len()).sum();
    sheet.option = named(found, found.variant(), found.best());
}

/// A value with its unit.
fn shown(value: &Swept) -> String {
    value.quantity().map_or_else(|| value.to_string(), |quantity| short(quantity, 6))
}
