//! The variants of a design in words and as a table.

use crate::analysis::decision::Sheet;
use crate::analysis::decision::choice::Next;
use crate::analysis::decision::words::short;
use crate::analysis::design::constraints::milliseconds;
use crate::analysis::design::report::{called, duration, four_digits, range, three_digits};
use crate::analysis::design::{Design, Filler, Variant};
use crate::key::setting::Swept;
use crate::view::report::sections::Grid;

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
pub(crate) fn shown(value: &Swept) -> String {
    value.quantity().map_or_else(|| value.to_string(), |quantity| short(quantity, 6))
}

/// The headings of latency and memory, where the design shows them.
pub(crate) fn cost_heads(found: &Design) -> Vec<String> {
    let is_shown = found.trades() && found.best().cost.is_some();
    let heads = ["latency, ms", "memory, bytes"].map(str::to_owned);
    heads.into_iter().filter(|_| is_shown).collect()
}

/// The cells of latency and memory, where the design shows them.
pub(crate) fn costs(found: &Design, filler: &Filler) -> Vec<String> {
    let cost = filler.cost.filter(|_| found.trades());
    let cells = cost.map(|cost| {
        let latency = milliseconds(cost.latency_s);
        [latency.trim_end_matches(" ms").to_owned(), cost.memory.bytes().to_string()]
    });
    cells.into_iter().flatten().collect()
}

/// The variants to read, each at its best interval with its best filler. `None` where no
/// key but the interval is swept.
pub(crate) fn by_variant(found: &Design) -> Option<Grid> {
    let keys = found.keys();
    if keys.is_empty() {
        return None;
    }
    let alike = found.variants.iter().all(|variant| variant.duration_s == found.variant().duration_s);
    let after = if alike { duration(found.variant().duration_s) } else { "the run".to_owned() };
    let label = found.measure.label();
    let own = [
        "filler",
        "best interval, s",
        "95 % interval, s",
        "switches",
        label,
        "95 % of it",
        "times the least",
    ];
    let mut heading: Vec<String> = keys.iter().map(|sweep| sweep.key.label.to_owned()).collect();
    heading.extend(own.map(str::to_owned));
    heading.insert(keys.len() + 6, format!("″ after {after}"));
    heading.extend(cost_heads(found));
    let line = |variant: &Variant| {
        let filler = variant.best();
        let best = filler.best();
        let interval = best.drift.interval.map_or_else(
            || "unknown".to_owned(),
            |(low, high)| format!("{} to {}", three_digits(low), three_digits(high)),
        );
        let times = three_digits(found.times_best(best).value);
        let as_good = !std::ptr::eq(filler, found.best()) && found.is_as_good(best);
        let mut line: Vec<String> = variant.swept.iter().map(|(_, value)| shown(value)).collect();
        line.extend([
            called(filler).to_owned(),
            four_digits(best.interval_s),
            range(filler),
            best.switches.to_string(),
            format!("{} °/h", three_digits(best.drift.value)),
            interval,
            three_digits(variant.angle(best.drift.value)),
            if as_good { format!("{times}, as good") } else { times },
        ]);
        line.extend(costs(found, filler));
        line
    };
    Some(Grid::new(heading, found.variants.iter().map(line)))
}
