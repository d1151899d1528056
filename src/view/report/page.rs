//! The page of one study.

use maud::{Markup, html};

use crate::chart;
use crate::quantity::number::significant;
use crate::store::Provenance;
use crate::table::Table;
use crate::view::picture::Drawn;
use crate::view::report::Report;
use crate::view::report::agreement::{Agreement, agreements, representation};
use crate::view::report::data::{Packed, data};
use crate::view::report::shell::{READING, Shell, chart, file, listings};
use crate::view::report::source::Source;

pub(crate) fn page(report: &Report) -> String {
    let points =
        report.tables.iter().find(|(source, _)| *source == chart::Source::Points).map(|(_, table)| *table);
    // The chart that the answer marks is first; a single point is in the answer.
    let all: Vec<&Drawn> = report.charts.iter().collect();
    let mut charts: Vec<&Drawn> = all.iter().copied().filter(|drawn| !drawn.picture.is_single()).collect();
    charts.sort_by_key(|drawn| !drawn.picture.is_marked());
    let tables: Vec<(&str, &Table)> =
        report.tables.iter().map(|(source, table)| (source.file(), *table)).collect();
    let Packed { text: packed, tables, thinned } = data(&charts, &all, &tables);
    let agreements = points.map(agreements).unwrap_or_default();
    let links = [
        (!charts.is_empty()).then_some(("charts", "Charts")),
        (!agreements.is_empty()).then_some(("closed-forms", "Closed forms")),
        Some(("tables", "Tables")),
        Some(("source", "How it was made")),
    ];
    let links: Vec<(&str, &str)> = links.into_iter().flatten().collect();
    let sections = html! {
        (study_charts(report, &charts, thinned))
        @if let Some(table) = points.filter(|_| !agreements.is_empty()) {
            (closed_forms(table, &agreements))
        }
        (listings(&tables))
        (source(report.source, points.map(|_| report.digest)))
    };
    let shell = Shell {
        title: report.title,
        question: report.question,
        style: "",
        links: &links,
        answer: report.answer.card(&scope(report.source), report.notes),
        sections,
        data: &packed,
    };
    shell.page()
}

/// The number of points with that of their trials.
fn scope(source: &Source) -> String {
    match source.sampled {
        Some((_, trials)) => format!("{} × {} trials", source.points, grouped(trials)),
        None => "closed form".to_owned(),
    }
}

fn study_charts(report: &Report, charts: &[&Drawn], thinned: usize) -> Markup {
    html! {
        @if !charts.is_empty() {
            section #charts {
                h2 { "Charts" }
                @if thinned > 1 {
                    p.note { "Curves show one point in " (thinned) "; the tables and chart.svg in the results folder have all points." }
                }
                @for (at, drawn) in charts.iter().enumerate() { (chart(at, drawn, "chart", &[report.title, report.question])) }
                p.hint.reading { (READING) }
            }
        }
    }
}

fn closed_forms(table: &Table, agreements: &[Agreement]) -> Markup {
    html! {
        section #closed-forms {
            h2 { "Closed forms" }
            p {
                "Where theory has a formula, every simulated value is compared with it. Sampling is the difference z from the formula for the \
                 integers that are sampled, in standard errors; representation is the relative difference of that formula from the one for \
                 the inputs."
            }
            @for agreement in agreements {
                p.agreement .off[!agreement.holds()] {
                    span.sign aria-hidden="true" { @if agreement.holds() { "✓" } @else { "!" } }
                    strong { "Sampling. " } (agreement.sentence(table))
                }
            }
            @if let Some((rows, largest)) = representation(table) {
                p.agreement {
                    span.sign aria-hidden="true" { "✓" }
                    strong { "Representation. " }
                    "At most " (significant(100.0 * largest, 2)) " % in " (rows) @if rows == 1 { " row" } @else { " rows" }
                    ", within the bound of rounding, beyond which a point is refused."
                }
            }
        }
    }
}

fn source(source: &Source, digest: Option<&str>) -> Markup {
    let trials = Provenance::trials_of(&source.provenance);
    html! {
        section #source {
            h2 { "How it was made" }
            dl {
                dt { "Study" } dd { (source.kind.name) ", " (source.points) " " (if source.points == 1 { "point" } else { "points" }) }
                @if let Some((seed, trials)) = source.sampled {
                    dt { "Seed" } dd { (seed) }
                    dt { "Trials at each point" }
                    dd {
                        @if source.stops { "at most " (grouped(trials)) ", fewer where a point reaches its precision earlier" } @else { (grouped(trials)) }
                        @if source.lacking > 0 { ", of which " (grouped(source.lacking)) " over all points are missing" }
                    }
                } @else {
                    dt { "Trials" } dd { "none: every value is a formula" }
                }
                @if trials > 0 {
                    dt { "Sampled" }
                    dd {
                        (grouped(trials)) " trials in all"
                        @if source.counts_again { ", counted once per separate launch" }
                        @for by in &source.provenance {
                            br; (by.device) ": " (grouped(by.trials)) " in " (significant(by.seconds, 3)) " s"
                            @if by.seconds > 0.0 { ", " (rate(by.trials as f64 / by.seconds)) " per second" }
                        }
                    }
                }
                dt { "Program" } dd { "sagnac " (env!("CARGO_PKG_VERSION")) @if !source.kernels.is_empty() { "; kernels " (source.kernels) } }
                @if let Some(digest) = digest {
                    dt { "SHA-256 of points.csv" } dd { code.digest { (digest) } }
                }
            }
            p {
                "The same study gives the same bits on any machine, device and number of threads. Save it as " code { "study.toml" }
                @if !source.inputs.is_empty() { ", the files that it names in a folder " code { "inputs" } " next to it," }
                " and run"
            }
            pre.command { code { "sagnac run study.toml --out again" } }
            @if source.lacking > 0 {
                p { "This samples all trials, so " code { "again/points.csv" } " will differ from the partial one, whose SHA-256 is given above." }
            } @else {
                p { "Then " code { "again/points.csv" } " has the SHA-256 given above." }
            }
            (file("study.toml", &source.study))
            @for input in &source.inputs {
                @match &input.text {
                    Some(text) => { (file(&input.name, text)) }
                    None => {
                        p {
                            code { (input.name) } " is in the results folder; its SHA-256 is " code.digest { (input.digest) }
                        }
                    }
                }
            }
        }
    }
}

/// A number per second.
fn rate(rate: f64) -> String {
    if rate < 1e6 { significant(rate, 3) } else { format!("{} million", significant(rate / 1e6, 3)) }
}

/// A count with separated thousands.
fn grouped(count: u64) -> String {
    let figures = count.to_string();
    let first = figures.len() % 3;
    let (head, tail) = figures.split_at(first);
    let groups = tail.as_bytes().chunks(3).map(|group| String::from_utf8_lossy(group).into_owned());
    let head = (!head.is_empty()).then(|| head.to_owned());
    head.into_iter().chain(groups).collect::<Vec<_>>().join("\u{202f}")
}

#[cfg(test)]
mod tests {
    use crate::view::report::page::grouped;

    #[test]
    fn counts_have_their_thousands_apart() {
        let shown = [7, 999, 1000, 72_000_000].map(|count| grouped(count).replace('\u{202f}', " "));
        assert_eq!(shown, ["7", "999", "1 000", "72 000 000"]);
    }
}
