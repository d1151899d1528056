//! What a design says: the recommendation in words, all that was tried as a table, both as JSON.

use crate::analysis::design::paper::PapersRule;
use crate::analysis::design::{Design, Filler, Found};
use crate::quantity::number::significant;
use crate::study::Study;
use crate::table::{Cell, Column, Table, Unit};
use crate::view::chart::figure::Figure;
use crate::view::chart::scale::Scale;
use crate::view::chart::spec::{ChartError, Spec};
use serde_json::{Value, json};

/// All that was tried: a row for each filler and interval.
pub fn table(found: &Design) -> Table {
    let column = |name: &str, label: &str, unit: Unit| Column {
        name: name.to_owned(),
        label: label.to_owned(),
        unit,
        ..Column::default()
    };
    let name = found.measure.name();
    let mut columns = [
        column("filler", "filler", Unit::NONE),
        column("interval", "switching interval", Unit::S),
        column("switches", "switches", Unit::NONE),
        Column { band: Some(vec![]), ..column(name, found.measure.label(), Unit::DEG_PER_H) },
        column(&format!("{name}_lo"), "lower end", Unit::DEG_PER_H),
        column(&format!("{name}_hi"), "upper end", Unit::DEG_PER_H),
        column("closed_form_rms", "rms drift (closed form)", Unit::DEG_PER_H),
    ];
    for filler in &found.fillers {
        for tried in &filler.tried {
            let Found { value, interval } = tried.drift;
            let cells = [
                Cell::Text(called(filler).to_owned()),
                Cell::Number(tried.interval_s),
                Cell::Integer(tried.switches as i64),
                Cell::Number(value),
                interval.map(|interval| interval.0).into(),
                interval.map(|interval| interval.1).into(),
                tried.closed_form.into(),
            ];
            for (column, cell) in columns.iter_mut().zip(cells) {
                column.cells.push(cell);
            }
            if let Some(band) = &mut columns[3].band {
                band.push(interval);
            }
        }
    }
    Table { columns: columns.into() }
}

/// As tables call the filler.
pub fn called(filler: &Filler) -> &str {
    filler.name.as_deref().unwrap_or("as given")
}

/// The 95 % interval of the best switching interval.
pub fn range(filler: &Filler) -> Option<(f64, f64)> {
    filler.optimum.lo_s.zip(filler.optimum.hi_s)
}

/// The recommendation in a line.
pub fn headline(found: &Design) -> String {
    let best = found.best();
    let interval = significant(best.best().interval_s, 4);
    let filler = best.name.as_ref().map_or(String::new(), |name| format!(" with the {name} filler"));
    format!(
        "Switch every {interval} s{filler}: {} {} °/h",
        found.measure.label(),
        significant(best.best().drift.value, 3)
    )
}

/// Drift over the interval, of each filler.
///
/// # Errors
/// Values that cannot be drawn.
pub fn figure(study: &Study, found: &Design, table: &Table) -> Result<Figure, ChartError> {
    let spec = Spec {
        title: study.title.clone(),
        subtitle: Some(headline(found)),
        x: "interval".to_owned(),
        y: found.measure.name().to_owned(),
        x_scale: Scale::Log,
        y_scale: Scale::Log,
        series: if found.fillers.len() > 1 { vec!["filler".to_owned()] } else { vec![] },
        apart: vec!["filler".to_owned()],
        filter: vec![],
        limit: None,
        laws: vec![],
        points: "Monte Carlo".to_owned(),
        bands: "95 % band".to_owned(),
    };
    Ok(Figure::from_table(table, &spec)?.0)
}

/// The recommendation in words, with what speaks for it.
pub fn recommendation(found: &Design) -> String {
    let best = found.best();
    let mut sentences = vec![format!("{}.", headline(found))];
    match range(best) {
        Some((lo, hi)) => sentences.push(format!(
            "The best interval lies between {} s and {} s (95 %).",
            significant(lo, 4),
            significant(hi, 4)
        )),
        None if best.is_at_edge() => sentences.push(
            "It is the shortest or longest that was tried: try others, by a sweep over switching.interval."
                .to_owned(),
        ),
        None => {}
    }
    let others = found.fillers.iter().enumerate().filter(|(place, _)| *place != found.best);
    let next = others.min_by(|a, b| a.1.best().drift.value.total_cmp(&b.1.best().drift.value));
    if let Some((_, next)) = next {
        let worse = found.worse_by(next);
        let (low, high) = worse.interval.unwrap_or((worse.value, worse.value));
        sentences.push(if low > 1.0 {
            format!(
                "The next filler, {}, leaves {} times as much at its own best interval of {} s ({} to {}).",
                called(next),
                significant(worse.value, 3),
                significant(next.best().interval_s, 4),
                significant(low, 3),
                significant(high, 3)
            )
        } else {
            format!("{} cannot be told from it by these runs.", called(next))
        });
    }
    if let Some(PapersRule { interval_s, bound, tried, residual_max }) = &best.papers_rule {
        let times = found.times_best(tried);
        let (low, high) = times.interval.unwrap_or((times.value, times.value));
        sentences.push(format!(
            "The paper's bound with δP_max = {} ″ has its minimum at {} s, where it allows {} °/h; switched every {} s the \
             gyro would drift by {} °/h, {} times as much as at best ({} to {}).",
            significant(*residual_max, 3),
            significant(*interval_s, 4),
            significant(*bound, 3),
            significant(tried.interval_s, 4),
            significant(tried.drift.value, 3),
            significant(times.value, 3),
            significant(low, 3),
            significant(high, 3)
        ));
    }
    if found.non_magnetic != 0.0 {
        sentences.push(format!(
            "The non-magnetic drift of {} °/h comes on top: no interval changes it.",
            significant(found.non_magnetic, 3)
        ));
    }
    sentences.join("\n")
}

/// The recommendation and all that was tried.
pub fn json(study: &Study, found: &Design) -> Value {
    let best = found.best();
    let drift = best.best().drift;
    let filler = |filler: &Filler| {
        let tried: Vec<Value> = filler
            .tried
            .iter()
            .map(|tried| {
                json!({
                    "interval_s": tried.interval_s,
                    "switches": tried.switches,
                    "drift": tried.drift.value,
                    "drift_lo": tried.drift.interval.map(|interval| interval.0),
                    "drift_hi": tried.drift.interval.map(|interval| interval.1),
                    "closed_form_rms": tried.closed_form,
                })
            })
            .collect();
        json!({
            "filler": filler.name,
            "residual_rms_arcsec": filler.residual_rms,
            "residual_max_arcsec": filler.residual_max,
            "interval_s": filler.best().interval_s,
            "interval_lo_s": filler.optimum.lo_s,
            "interval_hi_s": filler.optimum.hi_s,
            "drift": filler.best().drift.value,
            "drift_by_paper_rule": filler.papers_rule.as_ref().map(|rule| rule.tried.drift.value),
            "tried": tried,
        })
    };
    json!({
        "title": study.title,
        "estimate": found.measure.name(),
        "unit": "deg/h",
        "trials": found.trials,
        "seed": study.seed,
        "duration_s": found.duration_s,
        "interval_s": best.best().interval_s,
        "interval_lo_s": best.optimum.lo_s,
        "interval_hi_s": best.optimum.hi_s,
        "filler": best.name,
        "drift": drift.value,
        "drift_lo": drift.interval.map(|interval| interval.0),
        "drift_hi": drift.interval.map(|interval| interval.1),
        "drift_by_paper_rule": best.papers_rule.as_ref().map(|rule| rule.tried.drift.value),
        "interval_by_paper_rule_s": best.papers_rule.as_ref().map(|rule| rule.interval_s),
        "bound_by_paper_rule": best.papers_rule.as_ref().map(|rule| rule.bound),
        "non_magnetic_left_out": found.non_magnetic,
        "notes": found.notes,
        "fillers": found.fillers.iter().map(filler).collect::<Vec<_>>(),
    })
}
