//! A page as HTML: head, bar, title, answer, sections with charts, tables, footer, data and script. A gallery is several results
//! on one page.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::{Deserialize, Serialize};

use crate::answer::text::said;
use crate::chart::palette::style_sheet;
use crate::chart::{Drawn, Picture};
use crate::page::data::{Listed, Packed, data, one_in};
use crate::page::{Block, Grid, Page, Section};
use sagnac_base::table::Table;

/// Styles of pages in light and dark, on paper and on phones.
const STYLE: &str = include_str!("../../page/style.css");

/// Scripts that draw the charts and sort the tables. They share one scope, in this order.
const SCRIPT: [&str; 9] = [
    include_str!("../../page/elements.js"),
    include_str!("../../page/numbers.js"),
    include_str!("../../page/scale.js"),
    include_str!("../../page/plot.js"),
    include_str!("../../page/curves.js"),
    include_str!("../../page/contour.js"),
    include_str!("../../page/map.js"),
    include_str!("../../page/table.js"),
    include_str!("../../page/page.js"),
];

/// How charts are read.
const READING: &str = "Point at a chart or use the arrow keys to read values; click or press Enter to pin a reading. Drag to \
                       enlarge a part, and double-click to return to the whole. Names in the legend switch curves off and on.";

/// Most bytes of curves of a still picture, which is several points for each pixel of a screen.
const MAX_BYTES: usize = 120 << 10;

impl Page {
    /// The page with its settings in the words of `spell`. Equal pages give equal bytes on every machine.
    pub fn html(&self, spell: &dyn Fn(&str) -> String) -> String {
        let all: Vec<&Drawn> = self.charts().collect();
        let charts: Vec<&Drawn> = all.iter().copied().filter(|drawn| !drawn.picture.is_single()).collect();
        let tables: Vec<(&str, &Table)> = self
            .tables
            .iter()
            .filter(|(_, table)| table.rows() > 0)
            .map(|(file, table)| (*file, table))
            .collect();
        let Packed { text, tables, thinned } = data(&charts, &all, &tables);
        let sections: Vec<&Section> =
            self.sections.iter().filter(|section| section.blocks.iter().any(is_shown)).collect();
        let has_chart = |section: &&Section| section.blocks.iter().any(|block| block.chart().is_some());
        let last = sections.iter().rposition(has_chart);
        let said = |text: &str| said(&spell(text));
        let mut places = 0..;
        let told = [&*self.title, &*self.subtitle, &self.answer.headline];
        let notes: Vec<String> = self.notes.iter().map(|note| spell(note)).collect();
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                (head(&self.title))
                body {
                    a.skip href="#answer" { "To the answer" }
                    header {
                        div.bar {
                            span.brand { "sagnac " (env!("CARGO_PKG_VERSION")) }
                            nav {
                                @for section in &sections { a href=(format!("#{}", section.id)) { (section.heading) } }
                                a href="#tables" { "Tables" }
                            }
                            button #theme type="button" aria-pressed="false" title="Dark or light" { "◐" span.unseen { "Dark" } }
                        }
                        h1 { (self.title) }
                        @if !self.subtitle.is_empty() { p.question { (self.subtitle) } }
                    }
                    main {
                        (self.answer.card(&self.scope, &notes))
                        noscript {
                            style { "#theme, .reading { display: none }" }
                            p.note {
                                "Scripts are switched off here, so the charts are still pictures and the tables show their first rows. All \
                                 rows are in the files in the folder of results."
                            }
                        }
                        @for (at, section) in sections.iter().enumerate() {
                            section id=(section.id) {
                                h2 { (section.heading) }
                                @for block in section.blocks.iter().filter(|block| is_shown(block)) { (self::block(block, &mut places, &told, &said)) }
                            }
                            @if Some(at) == last {
                                @if thinned > 1 { p.note { "Curves show one point in " (thinned) "; files of the results folder have all points." } }
                                p.hint.reading { (READING) }
                            }
                        }
                        (listings(&tables))
                    }
                    footer {
                        "Made by sagnac " (env!("CARGO_PKG_VERSION")) ": Monte Carlo studies for laser gyroscopes. \
                         The page needs no network."
                    }
                    div #tip role="status" aria-live="polite" {}
                    script #data type="application/gzip+base64" { (PreEscaped(text)) }
                    script { (PreEscaped("\"use strict\";\n(() => {\n")) (PreEscaped(SCRIPT.concat())) (PreEscaped("})();\n")) }
                }
            }
        };
        page.into_string()
    }
}

/// Whether a page shows a block: a chart of a single point is in the answer.
fn is_shown(block: &Block) -> bool {
    block.chart().is_none_or(|drawn| !drawn.picture.is_single())
}

/// A block; `places` counts the charts, whose second lines are left out where the page has `told` them.
fn block(
    block: &Block,
    places: &mut std::ops::RangeFrom<usize>,
    told: &[&str],
    said: &dyn Fn(&str) -> Markup,
) -> Markup {
    html! {
        @match block {
            Block::Text(text) => { p { (said(text)) } }
            Block::Note(text) => { p.note { (said(text)) } }
            Block::Facts(facts) => {
                dl {
                    @for (name, lines) in facts {
                        dt { (name) }
                        dd { @for (at, line) in lines.iter().enumerate() { @if at > 0 { br; } (said(line)) } }
                    }
                }
            }
            Block::Grid(grid) => { (self::grid(grid)) }
            Block::More(title, grid) => { details { summary { (title) } (self::grid(grid)) } }
            Block::Options(table) => { (table.html()) }
            Block::Chart(drawn) => { (chart(places.next().unwrap_or(0), drawn, "chart", told)) }
            Block::Trace(drawn) => { (chart(places.next().unwrap_or(0), drawn, "chart trace", told)) }
            Block::Command(command) => { pre.command { code { (command) } } }
            // To read, and to save under its name.
            Block::File(name, text) => {
                details {
                    summary { (name) }
                    pre data-file=(name) { code { (text) } }
                }
            }
        }
    }
}

fn grid(grid: &Grid) -> Markup {
    html! {
        div.scroll.matrix tabindex="0" {
            table {
                thead { tr { @for (at, name) in grid.head.iter().enumerate() { th scope="col" .text[at == 0] { (name) } } } }
                tbody {
                    @for row in &grid.rows {
                        tr {
                            @for (at, cell) in row.iter().enumerate() {
                                td .text[at == 0] { (cell.text) @if !cell.below.is_empty() { small { (cell.below) } } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The head of a page.
pub(crate) fn head(title: &str) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta name="generator" content=(concat!("sagnac ", env!("CARGO_PKG_VERSION")));
            // Without this a browser would request an icon from a server.
            link rel="icon" href="data:,";
            title { (title) }
            style { (PreEscaped(STYLE)) (PreEscaped(style_sheet())) }
        }
    }
}

/// The place of chart `at` of the data, with a still picture of it that stays where no script draws it. The second line is left out
/// where the page has `said` it before; for a title that it has said, the heading is what the chart shows.
fn chart(at: usize, drawn: &Drawn, class: &str, said: &[&str]) -> Markup {
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
fn listings(tables: &[Listed]) -> Markup {
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

/// The picture as SVG. Its curves are thinned where they would take more than some hundred kilobytes.
pub(crate) fn still(picture: &Picture) -> String {
    let svg = picture.svg();
    match svg.len().div_ceil(MAX_BYTES) {
        1 => svg,
        step => one_in(step, picture).svg(),
    }
}

/// Results in a gallery, which commands other than `run` keep beside their page.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Card {
    /// Title.
    pub title: String,
    /// Question of a study, or what was analysed; may be empty.
    pub question: String,
    /// Answer as a sentence.
    pub headline: String,
    /// First chart as SVG, if there is one.
    pub picture: Option<String>,
    /// Name of the folder, which distinguishes results with the same title.
    #[serde(skip)]
    pub folder: String,
    /// Link to the page, relative to the gallery's folder.
    #[serde(skip)]
    pub report: String,
}

/// What tells a gallery from other files, the pages of results among them.
pub const MARKS: [&str; 2] = ["<meta name=\"generator\" content=\"sagnac ", "<main class=\"gallery\">"];

/// The page of several results, with a card for each that links to its page. `called` is what the cards are, in the singular
/// and the plural. Equal cards give equal bytes on every machine.
///
/// Nothing of a card becomes part of the page: texts are escaped, and a picture is an image, in which browsers run no script and
/// load nothing.
pub fn gallery(cards: &[Card], called: [&str; 2]) -> String {
    let count = match cards.len() {
        1 => format!("One {}", called[0]),
        count => format!("{count} {}", called[1]),
    };
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(&count))
            body {
                header {
                    div.bar { span.brand { "sagnac " (env!("CARGO_PKG_VERSION")) } }
                    h1 { (count) }
                }
                main.gallery {
                    @for card in cards {
                        article {
                            a href=(card.report) {
                                @if let Some(picture) = &card.picture {
                                    div.thumbnail { img alt="" src=(image(picture)); }
                                }
                                h2 { (card.title) }
                            }
                            @if !card.question.is_empty() { p.question { (card.question) } }
                            p.headline { (card.headline) }
                            p.hint { (card.folder) }
                        }
                    }
                }
            }
        }
    };
    page.into_string()
}

/// The address of a picture that is part of the page.
fn image(svg: &str) -> String {
    format!("data:image/svg+xml;base64,{}", BASE64_STANDARD.encode(svg))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_a_card_becomes_part_of_the_gallery() {
        let evil = "\"><script>alert(1)</script>".to_owned();
        let card = Card {
            title: evil.clone(),
            question: evil.clone(),
            headline: evil.clone(),
            picture: Some(format!("<svg onload='alert(1)'>{evil}</svg>")),
            folder: evil.clone(),
            report: evil,
        };
        let page = gallery(&[card], ["study", "studies"]);
        assert!(!page.contains("<script") && !page.contains("onload") && !page.contains("<svg"), "{page}");
    }

    #[test]
    fn a_card_is_read_as_it_was_written_without_its_place() {
        let card = Card { title: "Noise".to_owned(), picture: Some("<svg/>".to_owned()), ..Card::default() };
        let text = serde_json::to_string(&Card { folder: "x".to_owned(), ..card.clone() }).unwrap();
        assert_eq!(serde_json::from_str::<Card>(&text).unwrap(), card);
    }
}
