//! The decision of a study that asks which coefficients records show: the part of records that show each, instead of an error.

use crate::analysis::decision::DecisionError;
use crate::analysis::decision::evaluate::Evaluator;
use crate::analysis::decision::words::short;
use crate::device::Device;
use crate::key::setting::Swept;
use crate::kinds::allan::columns::is_absent;
use crate::kinds::allan::keys::LENGTH;
use crate::progress::Silent;
use crate::quantity::list::listed;
use crate::quantity::number::{percent, significant};
use crate::quantity::units::Quantity;
use crate::run::{Plan, Tables};
use crate::store::Store;
use crate::study::Study;
use crate::table::{Role, Table};
use crate::tally::share::Share;
use crate::view::chart::stack::Shown;
use crate::view::report::curves::Curves;
use crate::view::report::sentences::names;

/// Most records for the lever, which needs no figures beyond the second.
const MOST_RECORDS: u64 = 200;

/// The part of records from which on a coefficient counts as shown.
const HALF: f64 = 0.5;

/// A coefficient with its rows by the abscissa.
type Curve = (String, Vec<usize>);

/// The five sentences; `None` where no chart shows such a part, or a limit judges something else.
pub(crate) fn sentences(
    study: &Study,
    tables: &Tables,
    evaluator: &mut Evaluator,
) -> Result<Option<[String; 5]>, DecisionError> {
    let is_part =
        |column: &str, table: &Table| table.column(column).is_ok_and(|it| it.role == Role::Fraction);
    let mut charts =
        study.charts.iter().filter(|chart| is_part(&chart.estimate().name, tables.of(chart.source)));
    let is_judged = study.requirement.is_some() || study.charts.iter().any(|chart| chart.limit.is_some());
    let Some(chart) = charts.next().filter(|_| !is_judged) else { return Ok(None) };
    let Ok(shown) = Shown::of(tables.of(chart.source), chart) else { return Ok(None) };
    let table: &Table = &shown.table;
    let (x, y) = (table.column(&chart.x.name)?, table.column(&shown.estimate)?);
    let by = shown.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let curves = Curves::of(x, y, &table.rows_where(&chart.filter())?, &by);
    let at = |row: usize| x.valued(&significant(x.value(row), 3));
    let part = |row: usize| y.value(row);
    let ends = |rows: &[usize], is_least: bool| {
        let order = |a: &&usize, b: &&usize| part(**a).total_cmp(&part(**b));
        *if is_least { rows.iter().min_by(order) } else { rows.iter().max_by(order) }.unwrap_or(&0)
    };
    let name =
        |curve: &Curve| if curve.0.is_empty() { "the coefficient".to_owned() } else { curve.0.clone() };
    let (mut always, mut never, mut passes): (Vec<&Curve>, Vec<&Curve>, Vec<(&Curve, usize)>) =
        Default::default();
    for curve in curves.curves.iter().filter(|curve| !curve.1.is_empty()) {
        match curve.1.windows(2).find(|pair| (part(pair[0]) < HALF) != (part(pair[1]) < HALF)) {
            Some(pair) => passes.push((curve, pair[1])),
            None if is_absent(table, &curve.1) => {}
            None if part(curve.1[0]) < HALF => never.push(curve),
            None => always.push(curve),
        }
    }
    let all = |curves: &[&Curve]| listed(&curves.iter().map(|curve| name(curve)).collect::<Vec<_>>());
    let least_sure = always.iter().map(|curve| (*curve, ends(&curve.1, true)));
    let least_sure = least_sure.min_by(|a, b| part(a.1).total_cmp(&part(b.1)));
    let margin = match (passes.first(), least_sure) {
        (Some((curve, _)), _) => {
            let row = ends(&curve.1, false);
            format!(
                "{} is shown by up to {} of the records, at {}.",
                name(curve),
                percent(part(row)),
                at(row)
            )
        }
        (None, Some((curve, row))) => format!(
            "Of those shown everywhere, {} is the least sure: {} of the records show it at {}.",
            name(curve),
            percent(part(row)),
            at(row)
        ),
        (None, None) => "Nothing is shown by half of the records.".to_owned(),
    };
    let nearest = never.iter().map(|curve| (*curve, ends(&curve.1, false)));
    let nearest = nearest.max_by(|a, b| part(a.1).total_cmp(&part(b.1)));
    let limits = match nearest {
        Some((curve, row)) => format!(
            "Other noise covers {}: of these {} is nearest to being shown, by {} of the records at {}.",
            all(&never),
            name(curve),
            percent(part(row)),
            at(row)
        ),
        None => "Every coefficient is shown by half of the records somewhere in the study.".to_owned(),
    };
    let before = |(curve, row): &(&Curve, usize)| {
        let place = curve.1.iter().position(|one| one == row).unwrap_or(0);
        (curve.0.clone(), curve.1[place.saturating_sub(usize::from(part(*row) >= HALF))])
    };
    let asked = passes.first().map(before).or(nearest.map(|(curve, row)| (curve.0.clone(), row)));
    let lever = match asked {
        Some((curve, row)) => longer(study, table, &chart.x.name, [&shown.estimate, &curve], row, &shown.series, evaluator)?
            .map(|(from, to, found)| {
                format!(
                    "Length of the record ({}): of {} instead of {}, {} of the records show {} at {}, instead of {}.",
                    LENGTH.name,
                    short(to),
                    short(from),
                    percent(found),
                    if curve.is_empty() { "the coefficient" } else { &curve },
                    at(row),
                    percent(part(row))
                )
            }),
        None => None,
    };
    Ok(Some([
        format!("None is given. {}", curves.half(|rows| is_absent(table, rows)).unwrap_or_default())
            .trim_end()
            .to_owned(),
        "The study compares no options, only what records of one gyro show.".to_owned(),
        margin,
        limits,
        lever.unwrap_or_else(|| "A longer record was not tried.".to_owned()),
    ]))
}

/// The part of records of twice the length that show a coefficient at the swept value of a row, with both lengths.
fn longer(
    study: &Study,
    table: &Table,
    abscissa: &str,
    [estimate, curve]: [&str; 2],
    row: usize,
    series: &[String],
    evaluator: &mut Evaluator,
) -> Result<Option<(Quantity, Quantity, f64)>, DecisionError> {
    let written = study.values.iter().find(|(key, _)| std::ptr::eq(*key, &LENGTH));
    let sweep =
        study.sweeps.iter().find(|sweep| sweep.key.name == table.column(abscissa).map_or("", |x| &x.name));
    let Some((&(_, from), sweep)) = written.zip(sweep) else { return Ok(None) };
    let cell = &table.column(sweep.key.name)?.cells[row];
    let Some(value) = sweep.values.iter().find(|value| value.cell() == *cell) else { return Ok(None) };
    if study.sweeps.iter().any(|other| !std::ptr::eq(other.key, sweep.key)) {
        return Ok(None);
    }
    let to = Quantity { value: 2.0 * from.value, ..from };
    let mut study = study.at_points(&[sweep.key, &LENGTH], &[vec![value.clone(), Swept::Quantity(to)]])?;
    study.trials = study.trials.min(MOST_RECORDS);
    evaluator.expect(1);
    let plan = Plan::new(&study)?;
    let mut store = Store::in_memory(&plan.identity());
    let device: &mut Device = evaluator.device;
    plan.run(&mut store, device, Share::WHOLE, &Silent)?;
    let Some(found) = plan.tables(&store, &Silent)?.coefficients else { return Ok(None) };
    let by = series.iter().map(|name| found.column(name)).collect::<Result<Vec<_>, _>>()?;
    let row = (0..found.rows()).find(|&row| names(&by, row) == curve);
    let value = row.map(|row| found.column(estimate).map(|column| column.cells[row].number())).transpose()?;
    Ok(value.flatten().map(|value| (from, to, value)))
}
