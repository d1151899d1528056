//! An answer as the card that heads a page.

use maud::{Markup, html};

use crate::answer::reading::percent_of;
use crate::answer::{Answer, AnswerTable, Fact, Status};

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
                                        @if at == 0 { th.text scope="row" { (cell.text) } } @else { td { (cell.text) } }
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
