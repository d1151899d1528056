//! The variants of a design in words.

use crate::analysis::decision::Sheet;
use crate::analysis::decision::choice::Next;
use crate::analysis::decision::words::short;
use crate::analysis::design::{Design, Filler, Variant};
use crate::key::setting::Swept;

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
    let mut all: Vec<(&Variant, &Filler)> = Vec::new();
    for variant in &found.variants {
        all.extend(variant.fillers.iter().map(|filler| (variant, filler)));
    }
    all.retain(|(_, filler)| !std::ptr::eq(*filler, found.best()));
    let drift = |filler: &Filler| found.deciding(filler.best());
    all.sort_by(|a, b| drift(a.1).total_cmp(&drift(b.1)));
    sheet.options = 1 + all.len();
    sheet.option = named(found, found.variant(), found.best());
    let name = |(variant, filler): &(&Variant, &Filler)| named(found, variant, filler);
    let (good, worse): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|(_, filler)| found.is_as_good(filler.best()));
    sheet.equal = good.iter().map(name).collect();
    // Another estimate than the minimized one has values that the design does not know.
    let next = worse.first().filter(|_| sheet.label == found.measure.label());
    sheet.next = next.map(|next| Next {
        option: name(next),
        value: next.1.best().drift.value,
        met: sheet.met[0],
        is_alike: false,
    });
}

/// A value with its unit.
fn shown(value: &Swept) -> String {
    value.quantity().map_or_else(|| value.to_string(), |quantity| short(quantity, 6))
}
