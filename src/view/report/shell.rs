//! What every page has: head, bar, title, charts and tables, footer, data and script.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::view::chart::palette::style_sheet;
use crate::view::picture::Drawn;
use crate::view::report::data::Listed;
use crate::view::report::still::still;

/// Styles of pages in light and dark, on paper and on phones.
const STYLE: &str = include_str!("../../../assets/report/style.css");

/// Scripts that draw the charts and sort the tables. They share one scope, in this order.
const SCRIPT: [&str; 9] = [
    include_str!("../../../assets/report/elements.js"),
    include_str!("../../../assets/report/numbers.js"),
    include_str!("../../../assets/report/scale.js"),
    include_str!("../../../assets/report/plot.js"),
    include_str!("../../../assets/report/curves.js"),
    include_str!("../../../assets/report/contour.js"),
    include_str!("../../../assets/report/map.js"),
    include_str!("../../../assets/report/table.js"),
    include_str!("../../../assets/report/page.js"),
];

/// The parts of a page that are its own.
pub(crate) struct Shell<'a> {
    pub(crate) title: &'a str,
    /// A line below the title; may be empty.
    pub(crate) question: &'a str,
    /// Styles besides those of every page.
    pub(crate) style: &'a str,
    /// The ids of sections and their names in the bar.
    pub(crate) links: &'a [(&'a str, &'a str)],
    pub(crate) answer: Markup,
    /// The sections below the answer.
    pub(crate) sections: Markup,
    /// The packed data of charts and tables.
    pub(crate) data: &'a str,
}

impl Shell<'_> {
    /// The page as text.
    pub(crate) fn page(&self) -> String {
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                (head(self.title, self.style))
                body {
                    a.skip href="#answer" { "To the answer" }
                    header {
                        div.bar {
                            span.brand { "sagnac " (env!("CARGO_PKG_VERSION")) }
                            nav {
                                @for (id, name) in self.links { a href=(format!("#{id}")) { (name) } }
                            }
                            button #theme type="button" aria-pressed="false" title="Dark or light" { "◐" span.unseen { "Dark" } }
                        }
                        h1 { (self.title) }
                        @if !self.question.is_empty() { p.question { (self.question) } }
                    }
                    main {
                        (self.answer)
                        noscript {
                            style { "#theme, .reading { display: none }" }
                            p.note {
                                "Scripts are switched off here, so the charts are still pictures and the tables show their first rows. All \
                                 rows are in the files in the folder of results."
                            }
                        }
                        (self.sections)
                    }
                    footer {
                        "Made by sagnac " (env!("CARGO_PKG_VERSION")) ": Monte Carlo studies for laser gyroscopes. \
                         The page needs no network."
                    }
                    div #tip role="status" aria-live="polite" {}
                    script #data type="application/gzip+base64" { (PreEscaped(self.data)) }
                    script { (PreEscaped("\"use strict\";\n(() => {\n")) (PreEscaped(SCRIPT.concat())) (PreEscaped("})();\n")) }
                }
            }
        };
        page.into_string()
    }
}

/// The head of a page with some styles of its own.
pub(crate) fn head(title: &str, style: &str) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta name="generator" content=(concat!("sagnac ", env!("CARGO_PKG_VERSION")));
            // Without this a browser would request an icon from a server.
            link rel="icon" href="data:,";
            title { (title) }
            style { (PreEscaped(STYLE)) (PreEscaped(style_sheet())) (PreEscaped(style)) }
        }
    }
}

/// How charts are read.
pub(crate) const READING: &str = "Point at a chart or use the arrow keys to read values; click or press Enter to pin a reading. Drag to \
                                  enlarge a part, and double-click to return to the whole. Names in the legend switch curves off and on.";

/// The place of chart `at` of the data, with a still picture of it that stays where no script draws it. The second line is left out
/// where the page has `said` it before; for a title that it has said, the heading is what the chart shows.
pub(crate) fn chart(at: usize, drawn: &Drawn, class: &str, said: &[&str]) -> Markup {
    let subtitle = drawn.picture.subtitle().filter(|subtitle| !said.contains(subtitle));
    let title = drawn.picture.title();
    let title = if said.contains(&title) { drawn.picture.contents() } else { title.to_owned() };
    // Apart from the sections, which may have the same names.
    let id =
        if drawn.stem.starts_with("chart") { drawn.stem.clone() } else { format!("chart-{}", drawn.stem) };
    html! {
        figure id=(id) class=(class) data-chart=(at) {
            figcaption {
                h3 { a href=(format!("#{id}")) { (title) } }
                @if let Some(subtitle) = subtitle { p.subtitle { (subtitle) } }
            }
            div.plot { div.still { (PreEscaped(still(&drawn.picture))) } }
            @if let Some(note) = &drawn.note { p.note { (note) } }
        }
    }
}

/// The places of all tables.
pub(crate) fn listings(tables: &[Listed]) -> Markup {
    html! {
        section #tables {
            h2 { "Tables" }
            @for (at, table) in tables.iter().enumerate() {
                div.table data-table=(at) {
                    h3 { (table.file) }
                    @if let Some(sentence) = table.left_out() { p.note { (sentence) } }
                    // Stays where no script makes a table to sort of it.
                    div.listing {
                        p.hint.said { (table.counted()) }
                        div.scroll tabindex="0" role="region" aria-label=(table.file) {
                            table {
                                thead {
                                    tr { @for (title, class) in table.headings() { th class=[class] scope="col" { span { (title) } } } }
                                }
                                tbody {
                                    @for row in table.first_rows() {
                                        tr { @for (cell, class) in row { td class=[class] { (cell) } } }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A file to read, and to save under its name.
pub(crate) fn file(name: &str, text: &str) -> Markup {
    html! {
        details {
            summary { (name) }
            pre data-file=(name) { code { (text) } }
        }
    }
}
