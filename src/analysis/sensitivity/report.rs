//! The report of a sensitivity: answer, tables and charts.

use crate::analysis::design::Found;
use crate::analysis::sensitivity::sobol::{Index, Indices};
use crate::analysis::sensitivity::{LEVELS, Sensitivity};
use sagnac_base::quantity::number::with_unit;
use sagnac_base::table::column::columns_of;
use sagnac_base::table::{ColumnOf, Role, Table, Unit};
use sagnac_engine::key::sensitivity::Uncertain;
use sagnac_engine::key::sweep::{Scale, SweepValue};
use sagnac_engine::study::Study;
use sagnac_report::answer::reading::{begun, number, percent_of, range};
use sagnac_report::answer::{
    Alternative, Answer, AnswerCell, AnswerTable, Fact, Kind, Reading, Status, reading,
};
use sagnac_report::chart::figure::{
    Axis, Entry, Figure as Drawing, Grouping, Law, LawLine, Mark, Part, Parts, Series, SeriesPoint, Shape,
};

type Of<'a> = ColumnOf<&'a Input>;

/// The columns of `sensitivity.csv`. Those of the answer have its unit.
#[rustfmt::skip]
pub(crate) fn columns<'a>() -> Vec<Of<'a>> {
    vec![
        Of::new("input", Unit::NONE, "input", |input| input.key.into())
            .is(Role::Key, "Key of the uncertain input, as in `sensitivity.key`."),
        Of::new("unit", Unit::NONE, "unit", |input| input.unit.symbol.into())
            .is(Role::Note, "Unit of `from` and `to`; empty for pure numbers."),
        Of::new("from", Unit::NONE, "5 % quantile", |input| input.range[0].into())
            .is(Role::Coordinate, "5 % quantile of the input, in its unit."),
        Of::new("to", Unit::NONE, "95 % quantile", |input| input.range[1].into())
            .is(Role::Coordinate, "95 % quantile of the input, in its unit."),
        Of::new("first", Unit::NONE, "first-order index", |input| input.index.first.value.into())
            .is(Role::Estimate, "First-order Sobol' index: the part of the variance of the answer that the input explains alone.")
            .within(|input| input.index.first.interval),
        Of::new("first_lo", Unit::NONE, "lower end", |input| input.index.first.ends()[0].into())
            .is_of("first", Role::Lower, "Lower end of the 95 % interval of `first`."),
        Of::new("first_hi", Unit::NONE, "upper end", |input| input.index.first.ends()[1].into())
            .is_of("first", Role::Upper, "Upper end of the 95 % interval of `first`."),
        Of::new("total", Unit::NONE, "total index", |input| input.index.total.value.into())
            .is(Role::Estimate, "Total Sobol' index: the part of the variance of the answer that would remain if only this input were uncertain \
                and all others known, on average; it contains the interactions of the input.")
            .within(|input| input.index.total.interval),
        Of::new("total_lo", Unit::NONE, "lower end", |input| input.index.total.ends()[0].into())
            .is_of("total", Role::Lower, "Lower end of the 95 % interval of `total`."),
        Of::new("total_hi", Unit::NONE, "upper end", |input| input.index.total.ends()[1].into())
            .is_of("total", Role::Upper, "Upper end of the 95 % interval of `total`."),
        Of::new("at_from", Unit::NONE, "answer at from", |input| input.ends[0].into())
            .is(Role::Estimate, "The answer with the input at `from` and the others at their nominal values."),
        Of::new("at_to", Unit::NONE, "answer at to", |input| input.ends[1].into())
            .is(Role::Estimate, "The answer with the input at `to` and the others at their nominal values."),
        Of::new("least", Unit::NONE, "least answer", |input| input.swing[0].into())
            .is(Role::Estimate, "The least answer as the input goes from `from` to `to` with the others at their nominal values."),
        Of::new("greatest", Unit::NONE, "greatest answer", |input| input.swing[1].into())
            .is(Role::Estimate, "The greatest answer as the input goes from `from` to `to` with the others at their nominal values."),
    ]
}

/// The columns in the unit of the answer.
const OF_ANSWER: [&str; 4] = ["at_from", "at_to", "least", "greatest"];

/// The table of all inputs, by falling total index.
pub(crate) fn table(found: &Sensitivity) -> Table {
    let mut columns = columns_of(&columns(), &found.by_total());
    for column in columns.iter_mut().filter(|column| OF_ANSWER.contains(&column.name.as_str())) {
        column.unit = found.answer.unit;
    }
    Table { columns }
}

/// A row of `distribution.csv`: a name, its value and its unit.
pub(crate) type Number = (String, Found, &'static str);

/// The columns of `distribution.csv`.
#[rustfmt::skip]
pub(crate) fn distribution_columns() -> Vec<ColumnOf<Number>> {
    type Of = ColumnOf<Number>;
    vec![
        Of::new("quantity", Unit::NONE, "quantity", |(name, ..)| name.as_str().into())
            .is(Role::Key, "`nominal` for the answer with all inputs at their nominal values; `mean`, `sd` and quantiles of the answer; \
                `within_limit` for the part of answers within the limit of the study; `noise` for the part of the variance that is at most \
                due to sampling; `samples` and `evaluations` for their numbers."),
        Of::new("value", Unit::NONE, "value", |(_, found, _)| found.value.into())
            .is(Role::Estimate, "The number, in `unit`.")
            .within(|(_, found, _)| found.interval),
        Of::new("lower", Unit::NONE, "lower end", |(_, found, _)| found.ends()[0].into())
            .is_of("value", Role::Lower, "Lower end of the 95 % interval of `value`."),
        Of::new("upper", Unit::NONE, "upper end", |(_, found, _)| found.ends()[1].into())
            .is_of("value", Role::Upper, "Upper end of the 95 % interval of `value`."),
        Of::new("unit", Unit::NONE, "unit", |(.., unit)| (*unit).into())
            .is(Role::Note, "Unit of `value`; empty for parts and pure numbers."),
    ]
}

/// The distribution of the answer as a table.
pub(crate) fn distribution(found: &Sensitivity) -> Table {
    let quantiles = LEVELS.iter().zip(found.quantiles);
    let quantiles = quantiles.map(|(level, value)| (format!("quantile_{level}"), Found::exact(value)));
    let of_answer = [("nominal", Found::exact(found.nominal)), ("mean", found.mean), ("sd", found.sd)];
    let of_answer = of_answer.map(|(name, value)| (name.to_owned(), value)).into_iter().chain(quantiles);
    let within = found.within.map(|(_, part)| ("within_limit", part)).into_iter();
    let counts = [("samples", found.samples), ("evaluations", found.evaluations)];
    let counts = counts.map(|(name, count)| (name, Found::exact(count as f64)));
    let others = within.chain([("noise", Found::exact(found.noise))]).chain(counts);
    let others = others.map(|(name, value)| (name.to_owned(), value, ""));
    let of_answer = of_answer.map(|(name, value)| (name, value, found.answer.unit.symbol));
    Table { columns: columns_of(&distribution_columns(), &of_answer.chain(others).collect::<Vec<_>>()) }
}

/// How the answer was evaluated, in one line.
pub(crate) fn effort(found: &Sensitivity) -> String {
    let (evaluations, samples) = (found.evaluations, found.samples);
    match found.trials {
        None => format!("{evaluations} evaluations in closed form for {samples} samples"),
        Some(trials) => format!("{evaluations} evaluations of {trials} trials each for {samples} samples"),
    }
}

/// The tornado chart: a bar for each input from the least to the largest answer between its 5 % and its 95 % quantile, the longest on top.
pub(crate) fn figure(study: &Study, found: &Sensitivity) -> Drawing {
    /// Half the height of a bar, where inputs are 1 apart.
    const HALF: f64 = 0.3;
    let swing = |input: &&Input| input.swing[1] - input.swing[0];
    let mut inputs = found.by_total();
    inputs.sort_by(|a, b| swing(a).total_cmp(&swing(b)));
    let rows = || (1..).map(f64::from).zip(&inputs);
    let bar = |(row, input): (f64, &&Input)| {
        let [low, high] = input.swing;
        let corners = [(low, row - HALF), (high, row - HALF), (high, row + HALF), (low, row + HALF)];
        LawLine { colours: vec![0], points: corners.into() }
    };
    let ends = |style: usize| {
        let point = |(row, input): (f64, &&Input)| SeriesPoint::new(input.ends[style - 1], row);
        Series::of_points(style, rows().map(point).collect())
    };
    let unit = found.answer.unit.symbol;
    let label = |shape: Shape, place: (f64, f64)| Mark {
        shape,
        place,
        range: None,
        label: Reading::in_unit(&found.answer.name, place.0, unit, None).text(),
    };
    let top = inputs.len() as f64 + 0.5;
    Drawing {
        title: study.title.clone(),
        subtitle: Some(found.answer().headline),
        x: Axis { scale: Scale::Linear, ..Axis::new(&found.answer.label, unit) },
        y: Axis {
            scale: Scale::Linear,
            whole: true,
            names: inputs.iter().map(|input| input.label.to_owned()).collect(),
            ..Axis::new("uncertain input", "")
        },
        colours: Grouping {
            title: "the input".to_owned(),
            entries: [(1, "at 5 %"), (2, "at 95 %")]
                .map(|(style, name)| Entry { style, name: name.to_owned() })
                .into(),
        },
        laws: vec![Law {
            label: "5 % to 95 % of the input".to_owned(),
            lines: rows().map(bar).collect(),
            is_area: true,
        }],
        parts: Parts {
            title: String::new(),
            lines: vec![Part {
                label: "nominal".to_owned(),
                colour: 6,
                points: vec![(found.nominal, 0.5), (found.nominal, top)],
            }],
        },
        marks: rows()
            .flat_map(|(row, input)| {
                let [low, high] = input.swing;
                [label(Shape::Left, (low, row)), label(Shape::Right, (high, row))]
            })
            .collect(),
        series: vec![ends(1), ends(2)],
        chosen: found.rows.iter().map(|(column, value)| format!("{column} = {value}")).collect(),
        ..Drawing::default()
    }
}

/// A part of the variance in percent, which sampling may have left outside 0 to 100.
fn share(found: Found) -> Reading {
    let percent = |part: f64| libm::round(100.0 * part.clamp(0.0, 1.0));
    let ends = found.interval.map(|(low, high)| [percent(low), percent(high)]);
    Reading::in_unit("share", percent(found.value), "%", ends)
}

/// The ends of the interval of a share, in whole percent.
fn ends_of(share: &Reading) -> Option<String> {
    let [low, high] = share.interval?.map(number);
    (low != high).then(|| range(&low, &high))
}

impl Sensitivity {
    /// The answer. 95 % of answers count for the limit.
    pub fn answer(&self) -> Answer {
        let decisive = self.decisive();
        let value = share(decisive.index.total);
        let ends = ends_of(&value).map(|ends| format!(" ({ends} %)")).unwrap_or_default();
        let [_, _, most] = self.quantiles.map(f64::abs);
        Answer {
            kind: Kind::Estimate,
            status: match &self.within {
                None => Status::NoLimit,
                Some((limit, _)) if most <= limit.value => Status::Met,
                Some(_) => Status::NotMet,
            },
            headline: begun(&format!("{} drives {} of the variance{ends}", decisive.label, value.text())),
            value: Some(value),
            limit: self.within.as_ref().map(|(limit, _)| self.reading(limit.value, None)),
            table: self.table(),
            facts: self.facts(),
            checks: vec![],
        }
    }

    /// A value of the answer of the study.
    fn reading(&self, value: f64, ends: Option<(f64, f64)>) -> Reading {
        Reading::new(&self.answer, value, ends)
    }

    /// A row for each input, by falling total index.
    fn table(&self) -> AnswerTable {
        let row = |input: &&Input| -> Vec<AnswerCell> {
            let [from, to] = input.range.map(number);
            let index = |found: Found| {
                let reading = share(found);
                let ends = ends_of(&reading).map(|ends| format!(" ({ends})")).unwrap_or_default();
                AnswerCell::with_text(reading.text() + &ends, reading)
            };
            let [least, greatest] = input.swing.map(|value| self.reading(value, None));
            let swing = match least.unit == greatest.unit {
                true => reading::joined(&range(&number(least.value), &number(greatest.value)), &least.unit),
                false => format!("{} to {}", least.text(), greatest.text()),
            };
            vec![
                input.label.to_owned().into(),
                index(input.index.total),
                index(input.index.first),
                reading::joined(&range(&from, &to), input.unit.symbol).into(),
                swing.into(),
            ]
        };
        let inputs = self.by_total();
        let heads = ["input", "total S_T", "first-order S₁", "5 % to 95 %", &self.answer.label];
        AnswerTable { best: Some(0), ..AnswerTable::new(heads, inputs.iter().map(row)) }
    }

    fn facts(&self) -> Vec<Fact> {
        let [least, median, most] = self.quantiles;
        let mut facts = vec![
            Fact::value("Nominal", self.reading(self.nominal, None), ""),
            Fact::value("Median", self.reading(median, Some((least, most))), "5 % to 95 % of answers"),
        ];
        if let Some((_, part)) = &self.within {
            let part = Reading { interval: None, ..share(*part) };
            facts.push(Fact::value("Within the limit", part, "of answers"));
        }
        let unexplained = 1.0 - self.inputs.iter().map(|input| input.index.first.value).sum::<f64>();
        if percent_of(unexplained.max(0.0)) != percent_of(0.0) {
            facts.push(Fact::value("Interactions", share(Found::exact(unexplained)), "of the variance"));
        }
        facts.extend(self.most_effective());
        if !self.rows.is_empty() {
            let rows: Vec<String> =
                self.rows.iter().map(|(column, value)| format!("{column} = {value}")).collect();
            facts.push(Fact::caveat(format!("only rows with {}", rows.join(", "))));
        }
        facts
    }

    /// The input whose value between its 5 % and its 95 % quantile lowers the answer most.
    fn most_effective(&self) -> Option<Fact> {
        let ends = |input: &Input| [0, 1].map(|end| (input.range[end], input.ends[end].abs()));
        let lowest =
            |input: &Input| ends(input).into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        let input = self.inputs.iter().min_by(|a, b| lowest(a).1.total_cmp(&lowest(b).1))?;
        let (at, left) = lowest(input);
        let gain = 1.0 - left / self.nominal.abs();
        let shown = |value: f64| with_unit(value, 4, input.unit.symbol);
        let (key, label) = (input.key.to_owned(), input.label.to_owned());
        let change = Alternative { key, label, from: shown(input.nominal), to: shown(at) };
        (gain > 0.0).then_some(Fact::MostEffectiveChange { change, gain, interval: None })
    }
}

/// The effect of one input.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// Name of the key.
    pub key: &'static str,
    /// Its label.
    pub label: &'static str,
    /// Unit of its values.
    pub unit: Unit,
    /// Sobol' indices.
    pub index: Index,
    /// Its nominal value.
    pub nominal: f64,
    /// The 5 % and 95 % quantiles of the input.
    pub range: [f64; 2],
    /// The answer at these two, with the other inputs at their nominal values.
    pub ends: [f64; 2],
    /// The least and the largest answer between these two.
    pub swing: [f64; 2],
}

/// Steps from the 5 % to the 95 % quantile of an input.
const STEPS: usize = 18;

/// Number of points at which all swings together are evaluated.
pub(crate) fn count(inputs: usize) -> u64 {
    (1 + inputs * (STEPS + 1)) as u64
}

/// The answer as each input goes over its range.
pub(crate) struct Swings {
    /// With all inputs at their nominal values.
    pub(crate) nominal: f64,
    /// Answers at equal steps of the level, for each input.
    inputs: Vec<Vec<f64>>,
}

/// The levels of an input at which the answer is evaluated.
fn levels() -> impl Iterator<Item = f64> {
    (0..=STEPS).map(|step| LEVELS[0] + (LEVELS[2] - LEVELS[0]) * step as f64 / STEPS as f64)
}

/// The points of all swings: the nominal one, and then those along each input.
pub(crate) fn points_of_swings(nominal: &[SweepValue], uncertain: &[Uncertain]) -> Vec<Vec<SweepValue>> {
    let along = |(place, input): (usize, &Uncertain)| {
        let at = |level: f64| {
            let mut point = nominal.to_vec();
            point[place] = input.at(level);
            point
        };
        levels().map(at).collect::<Vec<Vec<SweepValue>>>()
    };
    let moved = uncertain.iter().enumerate().flat_map(along);
    std::iter::once(nominal.to_vec()).chain(moved).collect()
}

impl Swings {
    /// The swings from the answers at [their points](points_of_swings).
    pub(crate) fn new(answers: &[f64]) -> Swings {
        let inputs = answers[1..].chunks_exact(STEPS + 1).map(<[f64]>::to_vec).collect();
        Swings { nominal: answers[0], inputs }
    }
}

/// Each input with its indices and its swing.
pub(crate) fn joined(
    uncertain: &[Uncertain],
    nominal: &[SweepValue],
    found: &Indices,
    swings: Swings,
) -> Vec<Input> {
    let all = uncertain.iter().zip(nominal).zip(&found.inputs).zip(swings.inputs);
    let input = |(((input, nominal), index), along): (((&Uncertain, &SweepValue), &Index), Vec<f64>)| {
        let shown = |level: f64| input.at(level).cell().number().unwrap_or(f64::NAN);
        let (least, most) = along
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), y| (least.min(*y), most.max(*y)));
        Input {
            key: input.key.name,
            label: input.key.label,
            unit: input.at(0.5).unit(),
            index: *index,
            nominal: nominal.cell().number().unwrap_or(f64::NAN),
            range: [shown(LEVELS[0]), shown(LEVELS[2])],
            ends: [along[0], along[STEPS]],
            swing: [least, most],
        }
    };
    all.map(input).collect()
}
