//! An answer as lines of text, and as the card that heads a page.

use maud::{Markup, html};

use crate::answer::reading::percent_of;
use crate::answer::{Answer, AnswerCell, AnswerTable, Fact, Status};
use sagnac_base::diagnostics::in_cell;

/// The mark of the row of the headline.
const BEST: &str = "▸ ";

/// Distances between columns, of which the first one is taken that fits.
const GAPS: [usize; 2] = [3, 2];

/// Width up to which a heading stays in one line.
const HEADING: usize = 14;

/// Width up to which the heading of the first column stays in one line.
const FIRST_HEADING: usize = 24;

impl Answer {
    /// The answer as lines: checks, headline, table, and facts with their labels in a column.
    pub fn text(&self, width: usize) -> String {
        let (text, facts) = (self.text_without_facts(width), self.text_of_facts(width));
        if facts.is_empty() { text } else { format!("{text}\n{facts}") }
    }

    /// Checks, headline and table as lines.
    pub fn text_without_facts(&self, width: usize) -> String {
        let checks = self
            .checks
            .iter()
            .map(|check| format!("{} {}", if check.holds() { "✓" } else { "!" }, check.text()));
        let chips = self.chips().into_iter().chain(checks).collect::<Vec<_>>().join(" · ");
        let mut text = format!("{}\n", wrapped(&chips, width).join("\n"));
        if !self.headline.is_empty() {
            text += &format!("\n{}\n", wrapped(&self.headline, width).join("\n"));
        }
        let table = self.table.text(width);
        if !table.is_empty() {
            text += &format!("\n{table}");
        }
        text
    }

    /// The facts as lines, with their labels in a column.
    pub fn text_of_facts(&self, width: usize) -> String {
        let facts: Vec<(&str, String)> = self.facts.iter().map(|fact| (fact.label(), fact.text())).collect();
        labelled(&facts, width)
    }
}

impl AnswerTable {
    /// The table in aligned columns, numbers flush right, with the names of columns that do not fit below.
    pub fn text(&self, width: usize) -> String {
        if self.columns.is_empty() {
            return String::new();
        }
        let columns: Vec<_> = self.columns.iter().map(|heading| in_cell(heading)).collect();
        let length = |text: &str| in_cell(text).chars().count();
        // A heading has as many lines as its words need beside the cells.
        let widths = |headings: [usize; 2]| -> Vec<usize> {
            let of_column = |column: usize| {
                let cells = self.rows.iter().filter_map(|row| {
                    let below = self.below(row, column).map_or(0, |below| length(&below));
                    Some(length(&row.get(column)?.text).max(below))
                });
                let words = words(&columns[column]);
                let words = words.iter().map(|word| length(word));
                let whole = length(&columns[column]).min(headings[usize::from(column > 0)]);
                cells.chain(words).chain([whole]).max().unwrap_or(0)
            };
            (0..self.columns.len()).map(of_column).collect()
        };
        let mut shown: Vec<usize> = (0..columns.len()).collect();
        let total = |shown: &[usize], widths: &[usize], gap: usize| {
            BEST.chars().count() + shown.iter().map(|&at| widths[at] + gap).sum::<usize>() - gap
        };
        // The first one that fits, or the narrowest.
        let layouts = [
            ([FIRST_HEADING, HEADING], GAPS[0]),
            ([FIRST_HEADING, 0], GAPS[0]),
            ([FIRST_HEADING, 0], GAPS[1]),
            ([HEADING, 0], GAPS[1]),
        ];
        let mut layouts = layouts.map(|(headings, gap)| (widths(headings), gap)).into_iter();
        let fits = |(widths, gap): &(Vec<usize>, usize)| total(&shown, widths, *gap) <= width;
        let narrowest = layouts.clone().next_back();
        let (widths, gap) = layouts.find(fits).or(narrowest).unwrap_or_default();
        while shown.len() > 2 && total(&shown, &widths, gap) > width {
            shown.remove(if self.are_places { shown.len() / 2 } else { shown.len() - 1 });
        }
        let broken: Vec<Vec<String>> = shown.iter().map(|&at| wrapped(&columns[at], widths[at])).collect();
        let height = broken.iter().map(Vec::len).max().unwrap_or(0);
        let heading = |line: usize| {
            let of = |lines: &Vec<String>| {
                (line + lines.len()).checked_sub(height).map_or_else(String::new, |at| lines[at].clone())
            };
            broken.iter().map(of).collect::<Vec<String>>()
        };
        let text_of = |row: &[AnswerCell], at: usize| {
            row.get(at).map_or_else(String::new, |cell| in_cell(&cell.text).into_owned())
        };
        let body = self.rows.iter().enumerate().flat_map(|(at, row)| {
            let is_best = self.best == Some(at);
            let below: Vec<Option<String>> = shown.iter().map(|&at| self.below(row, at)).collect();
            let has_below = below.iter().any(Option::is_some);
            let below =
                has_below.then(|| (false, below.into_iter().map(Option::unwrap_or_default).collect()));
            std::iter::once((is_best, shown.iter().map(|&at| text_of(row, at)).collect())).chain(below)
        });
        let cells: Vec<(bool, Vec<String>)> =
            (0..height).map(|line| (false, heading(line))).chain(body).collect();
        let line = |(is_best, row): &(bool, Vec<String>)| {
            let mark = if *is_best { BEST } else { "  " };
            let cells = row.iter().zip(shown.iter().map(|&at| widths[at])).enumerate().map(
                |(column, (cell, width))| match column {
                    0 => format!("{cell:<width$}"),
                    _ => format!("{:gap$}{cell:>width$}", ""),
                },
            );
            format!("{}\n", format!("{mark}{}", cells.collect::<String>()).trim_end())
        };
        let mut text: String =
            if self.rows.is_empty() { String::new() } else { cells.iter().map(line).collect() };
        if self.omitted > 0 {
            text += &format!("  … {} more\n", self.omitted);
        }
        let hidden: Vec<&str> =
            (0..columns.len()).filter(|at| !shown.contains(at)).map(|at| &*columns[at]).collect();
        // Of places, some are shown in any case.
        if !hidden.is_empty() && !self.are_places {
            let note = format!("not shown at this width: {}", hidden.join(", "));
            text.extend(wrapped(&note, width.saturating_sub(2)).iter().map(|line| format!("  {line}\n")));
        }
        text
    }
}

/// Labels with their texts beside them, in lines of at most a width.
pub(crate) fn labelled(rows: &[(&str, String)], width: usize) -> String {
    let labels = rows.iter().map(|(label, _)| label.chars().count()).max().unwrap_or(0);
    let indent = labels + 4;
    let line = |(label, text): &(&str, String)| {
        let lines = wrapped(text, width.saturating_sub(indent).max(20)).join(&format!("\n{:indent$}", ""));
        format!("  {label:<labels$}  {lines}\n")
    };
    rows.iter().map(line).collect()
}

/// The words of a text; a sign and a bar stay with the word before.
fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match words.last_mut() {
            Some(last) if word.starts_with(['%', '█', '▏', '▎', '▍', '▌', '▋', '▊', '▉', '(', '×']) =>
            {
                *last += &format!(" {word}");
            }
            _ => words.push(word.to_owned()),
        }
    }
    words
}

/// A text in lines of at most a width, broken between words.
pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![String::new()];
    for word in words(text) {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].chars().count() + 1 + word.chars().count() > width {
            lines.push(word);
        } else {
            if !lines[last].is_empty() {
                lines[last].push(' ');
            }
            lines[last].push_str(&word);
        }
    }
    lines
}

/// The class that colours a status.
fn class(status: Status) -> &'static str {
    match status {
        Status::Met => "met",
        Status::NotMet => "missed",
        Status::PartlyMet { .. } | Status::Inconclusive | Status::Incomplete { .. } => "open",
        Status::NoLimit => "",
    }
}

impl Answer {
    /// The card; `scope` is a chip beside the status and the limit, and may be empty. Of several notes all but the first are folded.
    pub fn card(&self, scope: &str, notes: &[String]) -> Markup {
        let chips = self.chips();
        html! {
            section #answer.card {
                p.chips {
                    @for (at, chip) in chips.iter().enumerate() { span.chip .(if at == 0 { class(self.status) } else { "" }) { (chip) } }
                    @if !scope.is_empty() { span.chip { (scope) } }
                }
                h2.headline { (self.headline) }
                div.sides { (self.table.html()) (facts(&self.facts)) }
                // Open where there is room for them before the first chart.
                details.more open {
                    summary { "Checks and notes" }
                    @for check in &self.checks {
                        p.check .off[!check.holds()] { span.sign aria-hidden="true" { (if check.holds() { "✓" } else { "!" }) } (check.text()) }
                    }
                    @if let Some((first, more)) = notes.split_first() {
                        p.note { (said(first)) }
                        @if !more.is_empty() {
                            details { summary { (more.len()) " more " (if more.len() == 1 { "note" } else { "notes" }) } @for note in more { p.note { (said(note)) } } }
                        }
                    }
                }
            }
        }
    }
}

impl AnswerTable {
    /// The table, its best row marked.
    pub fn html(&self) -> Markup {
        html! {
            @if !self.rows.is_empty() {
                div.scroll tabindex="0" {
                    table.options {
                        thead { tr { @for (at, heading) in self.columns.iter().enumerate() { th scope="col" .text[at == 0] { (heading) } } } }
                        tbody {
                            @for (row, cells) in self.rows.iter().enumerate() {
                                tr .best[self.best == Some(row)] {
                                    @for (at, cell) in cells.iter().enumerate() {
                                        @if at == 0 { th.text scope="row" { (cell.text) } } @else {
                                            td { (cell.text) @if let Some(below) = self.below(cells, at) { small { (below) } } }
                                        }
                                    }
                                }
                            }
                        }
                    }
                    @if self.omitted > 0 { p.note { "… " (self.omitted) " more" } }
                }
            }
        }
    }
}

fn facts(facts: &[Fact]) -> Markup {
    html! {
        @if !facts.is_empty() {
            details.more open {
                summary { "Facts" }
                dl.facts { @for fact in facts { dt { (fact.label()) } dd { (content(fact)) } } }
            }
        }
    }
}

/// The content of a fact, with drawn bars.
fn content(fact: &Fact) -> Markup {
    html! {
        @match fact {
            Fact::ErrorBudget { .. } => {
                @for part in fact.parts() {
                    span.part { (part.name) " " (percent_of(part.share).replace(' ', "\u{a0}")) i.share style=(format!("--share: {:.3}", part.share.clamp(0.0, 1.0))) {} }
                }
                @if let Some(remark) = fact.remark() { span.part { (remark) } }
            }
            _ => { (fact.text()) }
        }
    }
}

/// A text with what is in backticks as code.
pub fn said(text: &str) -> Markup {
    let is_paired = text.matches('`').count().is_multiple_of(2);
    html! {
        @if is_paired {
            @for (at, part) in text.split('`').enumerate() { @if at % 2 == 1 { code { (part) } } @else { (part) } }
        } @else { (text) }
    }
}
