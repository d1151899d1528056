//! A page of sections, such as that of a log.

use maud::{Markup, html};

use crate::answer::card::said;
use crate::answer::{Answer, AnswerTable};
use crate::table::Table;
use crate::view::picture::Drawn;
use crate::view::report::data::{Packed, data};
use crate::view::report::gallery::Card;
use crate::view::report::shell::{READING, Shell, chart, file, listings};
use crate::view::report::still::still;

/// Styles that only such pages need.
const STYLE: &str = include_str!("../../../assets/report/sections.css");

/// A page with an answer, sections and tables, such as that of a log. Its texts may contain settings such as `force = true` in backticks, which
/// the front end spells as its options.
#[derive(Debug)]
pub struct Page {
    /// Title.
    pub title: String,
    /// A line below the title.
    pub subtitle: String,
    /// The answer.
    pub answer: Answer,
    /// Notes attached to the results.
    pub notes: Vec<String>,
    /// Sections in their order; those without blocks are left out.
    pub sections: Vec<Section>,
    /// Tables with the names of their files. Of a large table the page shows a part and says which, and none without rows.
    pub tables: Vec<(&'static str, Table)>,
}

/// A section of a page.
#[derive(Debug)]
pub struct Section {
    /// Its id in links.
    pub id: &'static str,
    /// Its heading, which the bar shows too.
    pub heading: &'static str,
    /// Its content from top to bottom.
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Debug)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A remark in smaller letters.
    Note(String),
    /// Names, each with one or more lines.
    Facts(Vec<(&'static str, Vec<String>)>),
    /// A small table to read.
    Grid(Grid),
    /// A small table that a page shows on demand, below its title.
    More(String, Grid),
    /// The table of an answer beside that of the page.
    Options(AnswerTable),
    /// A chart.
    Chart(Drawn),
    /// A chart of so many points that none has a marker.
    Trace(Drawn),
    /// A file by its name, with its text.
    File(&'static str, String),
}

/// A small table to read: the first cell of each row names it.
#[derive(Debug)]
pub struct Grid {
    /// Headings of the columns.
    pub head: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell of a [`Grid`].
#[derive(Debug, Clone, Default)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// A smaller text below it; may be empty.
    pub below: String,
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell { text, below: String::new() }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        text.to_owned().into()
    }
}

impl Page {
    /// The page with its settings in the words of `spell`. Equal pages give equal bytes on every machine.
    pub fn html(&self, spell: &dyn Fn(&str) -> String) -> String {
        let sections: Vec<&Section> =
            self.sections.iter().filter(|section| !section.blocks.is_empty()).collect();
        let charts: Vec<&Drawn> = self.charts().collect();
        let tables: Vec<(&str, &Table)> = self
            .tables
            .iter()
            .filter(|(_, table)| table.rows() > 0)
            .map(|(file, table)| (*file, table))
            .collect();
        let Packed { text, tables, thinned } = data(&charts, &charts, &tables);
        let links: Vec<(&str, &str)> = sections
            .iter()
            .map(|section| (section.id, section.heading))
            .chain([("tables", "Tables")])
            .collect();
        let said = |text: &str| said(&spell(text));
        let mut places = 0..;
        let told = [&*self.title, &*self.subtitle, &self.answer.headline];
        let body = html! {
            @if thinned > 1 { p.note { "Curves show one point in " (thinned) "." } }
            @for section in sections {
                section id=(section.id) {
                    h2 { (section.heading) }
                    @for block in &section.blocks { (self::block(block, &mut places, &told, &said)) }
                }
            }
            @if !charts.is_empty() { p.hint.reading { (READING) } }
            (listings(&tables))
        };
        let notes: Vec<String> = self.notes.iter().map(|note| spell(note)).collect();
        let answer = self.answer.card("", &notes);
        let shell = Shell {
            title: &self.title,
            question: &self.subtitle,
            style: STYLE,
            links: &links,
            answer,
            sections: body,
            data: &text,
        };
        shell.page()
    }
}

impl Page {
    /// The charts of all sections, in their order.
    pub fn charts(&self) -> impl Iterator<Item = &Drawn> {
        self.sections.iter().flat_map(|section| &section.blocks).filter_map(drawn)
    }

    /// The charts of results, which are files too.
    pub fn figures(&self) -> impl Iterator<Item = &Drawn> {
        let blocks = self.sections.iter().flat_map(|section| &section.blocks);
        blocks.filter_map(|block| if let Block::Chart(drawn) = block { Some(drawn) } else { None })
    }

    /// The card of the page in galleries, with its settings in the words of `spell`.
    pub fn card(&self, spell: &dyn Fn(&str) -> String) -> Card {
        // Rather a chart of results than a record.
        let first = self.figures().next().or_else(|| self.charts().next());
        let [title, question, headline] =
            [&self.title, &self.subtitle, &self.answer.headline].map(|text| spell(text));
        Card {
            title,
            question,
            headline,
            picture: first.map(|drawn| still(&drawn.picture)),
            ..Card::default()
        }
    }
}

fn drawn(block: &Block) -> Option<&Drawn> {
    match block {
        Block::Chart(drawn) | Block::Trace(drawn) => Some(drawn),
        _ => None,
    }
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
            Block::File(name, text) => { (file(name, text)) }
            Block::Trace(drawn) => { (chart(places.next().unwrap_or(0), drawn, "chart trace", told)) }
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
