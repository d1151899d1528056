//! Verdicts of charts with a limit on their curves.

use serde_json::{Map, Value, json};

use crate::chart::{Chart, Limit, Shows};
use crate::source::diagnose::StudyError;
use crate::study::Study;
use crate::table::{Column, Table};
use crate::view::chart::notes::ChartError;
use crate::view::chart::stack::Shown;
use crate::view::picture::{chart_stem, refused};
use crate::view::verdict::{Answer, Question, Window, verdict};

/// The verdict of one chart, or of several with the same content.
pub struct Verdict<'t> {
    /// Names of their files.
    charts: Vec<String>,
    /// Column that is judged.
    of: &'t Column,
    /// The limit.
    pub limit: Limit,
    /// Rows to which it applies, as columns with their values in files.
    rows: Vec<(&'t Column, String)>,
    /// The answer of each curve.
    pub answers: Vec<Answer<'t>>,
}

/// The verdicts of all charts of curves with a limit, equal ones once. A map shows by itself where the limit is
/// exceeded.
///
/// # Errors
/// The table lacks something that a chart requires.
pub fn verdicts<'t>(study: &Study, shown: &'t [Shown]) -> Result<Vec<Verdict<'t>>, StudyError> {
    let mut all: Vec<Verdict> = Vec::new();
    for (index, (chart, shown)) in study.charts.iter().zip(shown).enumerate() {
        let Some(limit) = chart.limit.filter(|_| matches!(chart.shows, Shows::Curves { .. })) else {
            continue;
        };
        let charts = vec![chart_stem(index, study.charts.len())];
        let found = of_chart(shown, chart, charts, limit).map_err(|error| refused(study, chart, &error))?;
        match all.iter_mut().find(|earlier| earlier.says() == found.says()) {
            Some(earlier) => earlier.charts.extend(found.charts),
            None => all.push(found),
        }
    }
    Ok(all)
}

fn of_chart<'t>(
    shown: &'t Shown,
    chart: &Chart,
    charts: Vec<String>,
    limit: Limit,
) -> Result<Verdict<'t>, ChartError> {
    let table: &Table = &shown.table;
    let rows = chart.filter();
    let question = Question {
        x: &chart.x.name,
        y: &shown.estimate,
        series: shown.series.iter().map(String::as_str).collect(),
        filter: rows.clone(),
        limit: limit.value,
    };
    let rows = rows.into_iter().map(|(column, value)| Ok((table.column(&column)?, value)));
    Ok(Verdict {
        charts,
        of: table.column(&shown.estimate)?,
        limit,
        rows: rows.collect::<Result<_, ChartError>>()?,
        answers: verdict(table, &question)?,
    })
}

impl Verdict<'_> {
    /// What it says, apart from the charts that show it.
    fn says(&self) -> impl PartialEq {
        (&self.of.name, &self.rows, &self.answers, self.limit)
    }

    /// A heading that says what is judged, with the remarks `besides`, and a sentence for each curve.
    pub fn text(&self, besides: &str) -> String {
        let sentences: String =
            self.sentences().into_iter().map(|sentence| format!("  {sentence}\n")).collect();
        format!("{}{besides}\n{sentences}", self.heading())
    }

    /// The judged column, and the charts that show it.
    pub fn heading(&self) -> String {
        let rows = self.rows.iter().map(|(column, value)| format!(", {}", column.valued(value)));
        format!("{}: {} against the limit{}", self.charts.join(", "), self.of.label, rows.collect::<String>())
    }

    /// A sentence for each curve.
    pub fn sentences(&self) -> Vec<String> {
        let limit = self.limit.text();
        self.answers.iter().map(|answer| answer.sentence(&limit)).collect()
    }

    /// Column, charts, limit, and for each curve its outcome and places, as JSON.
    pub fn json(&self) -> Value {
        let rows = self.rows.iter().map(|(column, value)| (column.header(), json!(value)));
        let answers = self.answers.iter().map(|answer| {
            let series = answer.series.iter().map(|(column, cell)| json!([column.header(), cell.text()]));
            let places = |places: &[(&Column, f64)]| -> Vec<Value> {
                places.iter().map(|(column, value)| json!([column.header(), value])).collect()
            };
            let window =
                |window: &Window| json!({ "from": places(&window.from), "until": places(&window.until) });
            json!({
                "series": series.collect::<Vec<_>>(),
                "outcome": answer.outcome,
                "at": places(&answer.at),
                "until": places(&answer.until),
                "again": answer.again.iter().map(window).collect::<Vec<_>>(),
                "first": places(&answer.first),
            })
        });
        let limit = format!("limit_{}", self.limit.unit.suffix);
        json!({
            "charts": self.charts,
            "of": self.of.header(),
            "where": rows.collect::<Map<_, _>>(),
            (limit.trim_end_matches('_')): self.limit.value,
            "series": answers.collect::<Vec<_>>(),
        })
    }
}
