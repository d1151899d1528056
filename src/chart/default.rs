//! The chart of a study that asks for none.

use crate::chart::file::{Scale, Source};
use crate::chart::rows::{ALL_TICKS, COMPENSATION, DT_NU, FILLER, Known, TAU, TICK, TICK_NUMBER};
use crate::chart::{Chart, Named, Shows, scale_over, usual_rows};
use crate::key::file::Kind;
use crate::key::sweep::Sweep;
use crate::kinds::gap_fill::keys::FREQUENCY;
use crate::kinds::switched_run::SwitchedRun;
use crate::study::Subject;
use crate::table::Cell;

/// The column that is looked at first in the results of a kind of study.
pub(crate) fn estimate(kind: Kind) -> &'static str {
    match kind {
        Kind::GapFill | Kind::Relock => "rms",
        Kind::Allan => "adev",
        Kind::SwitchedRun => "drift_q9973",
        Kind::DriftBudget => "bound",
        Kind::Suspension => "response",
    }
}

/// What suits the sweeps; nothing where no number is swept of closed forms, and of runs without fillers.
pub(crate) fn default_for(sweeps: &[Sweep], subject: &Subject) -> Option<Chart> {
    match subject {
        Subject::GapFill(_) => Some(of_fillers(sweeps, subject)),
        Subject::Allan(_) => Some(of_deviations(sweeps)),
        Subject::SwitchedRun(run) => of_runs(sweeps, run, subject),
        Subject::Relock(_) => Some(of_relock(sweeps, subject)),
        Subject::DriftBudget(_) => of_closed_forms(sweeps, subject, estimate(Kind::DriftBudget)),
        Subject::Suspension(_) => of_closed_forms(sweeps, subject, estimate(Kind::Suspension)),
    }
}

/// The Allan deviation over τ, a curve for each value of the first two swept keys.
fn of_deviations(sweeps: &[Sweep]) -> Chart {
    Chart {
        title: None,
        source: Source::Points,
        x: Named::default(TAU),
        y: Named::default(estimate(Kind::Allan)),
        beside: vec![],
        shows: Shows::Curves {
            series: sweeps.iter().take(2).map(|sweep| Named::default(sweep.key.name)).collect(),
            laws: vec![],
        },
        rows: sweeps.iter().skip(2).filter_map(at_first).collect(),
        limit: None,
        x_scale: Scale::Log,
        y_scale: Scale::Log,
    }
}

/// What each compensation leaves of all ticks over the first swept key; tick by tick where nothing is swept.
fn of_relock(sweeps: &[Sweep], subject: &Subject) -> Chart {
    let x = sweeps.first().map_or(TICK_NUMBER, |sweep| sweep.key.name);
    let series = std::iter::once(COMPENSATION).chain(sweeps.get(1).map(|sweep| sweep.key.name));
    let all = (Named::default(TICK), Cell::Text(ALL_TICKS.to_owned()));
    let fixed = sweeps.iter().skip(2).filter_map(at_first);
    Chart {
        title: None,
        source: Source::Points,
        x: Named::default(x),
        y: Named::default(estimate(Kind::Relock)),
        beside: vec![],
        shows: Shows::Curves { series: series.map(Named::default).collect(), laws: vec![] },
        rows: (!sweeps.is_empty()).then_some(all).into_iter().chain(fixed).collect(),
        limit: None,
        x_scale: if sweeps.is_empty() {
            Scale::Linear
        } else {
            scale_over(x, sweeps, &Known::of(subject, Source::Points))
        },
        y_scale: Scale::Log,
    }
}

/// The column `y` over the first swept key that is no name, a curve for each value of the next two.
fn of_closed_forms(sweeps: &[Sweep], subject: &Subject, y: &str) -> Option<Chart> {
    let x = sweeps.iter().find(|sweep| !sweep.key.is_name())?;
    let others: Vec<&Sweep> = sweeps.iter().filter(|sweep| sweep.key.name != x.key.name).collect();
    Some(Chart {
        title: None,
        source: Source::Points,
        x: Named::default(x.key.name),
        y: Named::default(y),
        beside: vec![],
        shows: Shows::Curves {
            series: others.iter().take(2).map(|sweep| Named::default(sweep.key.name)).collect(),
            laws: vec![],
        },
        rows: others.iter().skip(2).filter_map(|sweep| at_first(sweep)).collect(),
        limit: None,
        x_scale: scale_over(x.key.name, sweeps, &Known::of(subject, Source::Points)),
        y_scale: Scale::default(),
    })
}

/// A curve runs along one key: others stay at their first value.
fn at_first(sweep: &Sweep) -> Option<(Named, Cell)> {
    Some((Named::default(sweep.key.name), sweep.values.first()?.cell()))
}

/// The drift that 99.73 % of runs stay below over the first swept key that is no name, a curve for each filler and value
/// of the next.
fn of_runs(sweeps: &[Sweep], run: &SwitchedRun, subject: &Subject) -> Option<Chart> {
    let known = Known::of(subject, Source::Points);
    let Some(x) = sweeps.iter().find(|sweep| !sweep.key.is_name()) else {
        let has_fillers = !run.fillers().is_empty();
        return has_fillers.then(|| side_by_side(sweeps, &known, ["drift_rms", "drift_q9973"]));
    };
    let others = || sweeps.iter().filter(|sweep| sweep.key.name != x.key.name);
    let filler = (!run.fillers().is_empty()).then(|| Named::default(FILLER));
    let keys = others().map(|sweep| Named::default(sweep.key.name));
    let series: Vec<Named> = filler.into_iter().chain(keys).take(2).collect();
    let fixed = others().filter(|sweep| series.iter().all(|named| named.name != sweep.key.name));
    let rows = fixed.filter_map(at_first).chain(usual_rows(&known)).collect();
    Some(Chart {
        title: None,
        source: Source::Points,
        x: Named::default(x.key.name),
        y: Named::default(estimate(Kind::SwitchedRun)),
        beside: vec![],
        shows: Shows::Curves { series, laws: vec![] },
        rows,
        limit: None,
        x_scale: scale_over(x.key.name, sweeps, &known),
        y_scale: Scale::default(),
    })
}

/// Over Δt·ν if the frequency is swept, else over the first swept key that is no name, else side by side.
fn of_fillers(sweeps: &[Sweep], subject: &Subject) -> Chart {
    let mut names: Vec<&str> = sweeps.iter().map(|sweep| sweep.key.name).collect();
    let frequency = sweeps.iter().position(|sweep| sweep.key.name == FREQUENCY.name);
    let Some(swept) = frequency.or_else(|| sweeps.iter().position(|sweep| !sweep.key.is_name())) else {
        return side_by_side(sweeps, &Known::of(subject, Source::Points), ["rms", "q9973"]);
    };
    let name = names.remove(swept);
    let x = if frequency.is_some() { DT_NU } else { name };
    let series = std::iter::once(FILLER).chain(names.first().copied());
    let fixed = names
        .iter()
        .skip(1)
        .filter_map(|name| at_first(sweeps.iter().find(|sweep| sweep.key.name == *name)?));
    let known = Known::of(subject, Source::Points);
    Chart {
        title: None,
        source: Source::Points,
        x: Named::default(x),
        y: Named::default(estimate(Kind::GapFill)),
        beside: vec![],
        shows: Shows::Curves { series: series.map(Named::default).collect(), laws: vec![] },
        rows: fixed.chain(usual_rows(&known)).collect(),
        limit: None,
        x_scale: scale_over(x, sweeps, &known),
        y_scale: Scale::default(),
    }
}

/// The fillers side by side where no number is swept, by two estimates, for each value of the first name that is.
fn side_by_side(sweeps: &[Sweep], known: &Known, [first, second]: [&str; 2]) -> Chart {
    let mut names = sweeps.iter().map(|sweep| Named::default(sweep.key.name));
    Chart {
        title: None,
        source: Source::Points,
        x: Named::default(FILLER),
        y: Named::default(first),
        beside: vec![Named::default(second)],
        shows: Shows::Curves { series: names.next().into_iter().collect(), laws: vec![] },
        rows: sweeps.iter().skip(1).filter_map(at_first).chain(usual_rows(known)).collect(),
        limit: None,
        x_scale: Scale::Linear,
        y_scale: Scale::Log,
    }
}
