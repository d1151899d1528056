//! The result of a design as JSON.

use serde_json::{Value, json};

use crate::analysis::decision::Sheet;
use crate::analysis::design::report::ends;
use crate::analysis::design::report::trade::{limit, pareto_json};
use crate::analysis::design::{Design, Filler, LeftOut, Tried, Variant};
use crate::kinds::table::column_of;

/// The recommendation and all results.
pub fn json(found: &Design, sheet: Option<&Sheet>) -> Value {
    let (study, variant, best) = (&found.study, found.variant(), found.best());
    let (drift, rule) = (best.best().drift, best.papers_rule.as_ref());
    let [interval_lo_s, interval_hi_s] = ends(best.optimum);
    let [drift_lo, drift_hi] = ends(drift);
    let mut document = json!({
        "title": study.title,
        "answer": found.answer(sheet),
        "decision": sheet.map(Sheet::json),
        "estimate": found.measure.name(),
        "unit": "deg/h",
        "trials": found.trials,
        "seed": study.seed,
        "duration_s": variant.duration_s,
        "interval_s": best.best().interval_s,
        "interval_lo_s": interval_lo_s,
        "interval_hi_s": interval_hi_s,
        "filler": best.name,
        "drift": drift.value,
        "drift_lo": drift_lo,
        "drift_hi": drift_hi,
        "angle_arcsec": variant.angle(drift.value),
        "angle_lo_arcsec": drift_lo.map(|drift| variant.angle(drift)),
        "angle_hi_arcsec": drift_hi.map(|drift| variant.angle(drift)),
        "drift_by_paper_rule": rule.map(|rule| rule.tried.drift.value),
        "interval_by_paper_rule_s": rule.map(|rule| rule.interval_s),
        "bound_by_paper_rule": rule.map(|rule| rule.bound),
        "non_magnetic": variant.non_magnetic,
        "notes": found.notes,
        "fillers": variant.fillers.iter().map(|filler| of_filler(variant, filler)).collect::<Vec<_>>(),
    });
    if found.trades() {
        document["variants"] = found.variants.iter().map(|variant| of_variant(found, variant)).collect();
        document["pareto"] = pareto_json(found);
        document["constraints"] = json!({
            "latency_s": found.constraints.latency_s,
            "memory_bytes": found.constraints.memory_bytes,
            "limit_deg_per_h": limit(found, variant.duration_s),
            "left_out": found.left_out.iter().map(of_left_out).collect::<Vec<_>>(),
        });
    }
    document
}

/// A filler that breaks a constraint.
fn of_left_out(out: &LeftOut) -> Value {
    json!({ "filler": out.filler, "why": out.why, "variants": out.variants })
}

/// The values of swept keys, in the units of tables, by the headers of their columns.
pub(crate) fn swept(found: &Design, variant: &Variant) -> Value {
    let each = found.keys().into_iter().zip(&variant.swept);
    each.map(|(sweep, (_, value))| (column_of(&sweep).header(), json!(value.cell()))).collect()
}

/// A variant at its best interval with its best filler, and its fillers.
fn of_variant(found: &Design, variant: &Variant) -> Value {
    let (filler, best) = (variant.best(), variant.best().best());
    let [interval_lo_s, interval_hi_s] = ends(filler.optimum);
    let [drift_lo, drift_hi] = ends(best.drift);
    let times = found.times_best(best);
    let [times_lo, times_hi] = ends(times);
    json!({
        "swept": swept(found, variant),
        "duration_s": variant.duration_s,
        "non_magnetic": variant.non_magnetic,
        "filler": filler.name,
        "interval_s": best.interval_s,
        "interval_lo_s": interval_lo_s,
        "interval_hi_s": interval_hi_s,
        "drift": best.drift.value,
        "drift_lo": drift_lo,
        "drift_hi": drift_hi,
        "angle_arcsec": variant.angle(best.drift.value),
        "latency_s": filler.cost.map(|cost| cost.latency_s),
        "memory_bytes": filler.cost.map(|cost| cost.memory.bytes()),
        "times_least": times.value,
        "times_least_lo": times_lo,
        "times_least_hi": times_hi,
        "as_good": found.is_as_good(best),
        "fillers": variant.fillers.iter().map(|filler| of_filler(variant, filler)).collect::<Vec<_>>(),
    })
}

/// A filler with all intervals that were tried.
fn of_filler(variant: &Variant, filler: &Filler) -> Value {
    let tried = |tried: &Tried| {
        let [drift_lo, drift_hi] = ends(tried.drift);
        json!({
            "interval_s": tried.interval_s,
            "switches": tried.switches,
            "drift": tried.drift.value,
            "drift_lo": drift_lo,
            "drift_hi": drift_hi,
            "closed_form_rms": tried.closed_form,
            "angle_arcsec": variant.angle(tried.drift.value),
            "switched": tried.switched.value,
        })
    };
    let [interval_lo_s, interval_hi_s] = ends(filler.optimum);
    json!({
        "filler": filler.name,
        "residual_rms_arcsec": filler.residual_rms,
        "residual_max_arcsec": filler.residual_max,
        "interval_s": filler.best().interval_s,
        "interval_lo_s": interval_lo_s,
        "interval_hi_s": interval_hi_s,
        "drift": filler.best().drift.value,
        "drift_by_paper_rule": filler.papers_rule.as_ref().map(|rule| rule.tried.drift.value),
        "tried": filler.tried.iter().map(tried).collect::<Vec<_>>(),
    })
}
