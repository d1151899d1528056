//! A gallery: several studies on one page.

use maud::{DOCTYPE, PreEscaped, html};

use crate::view::chart::picture::Picture;
use crate::view::report::shell::head;

/// A study in a gallery.
#[derive(Debug, Clone, PartialEq)]
pub struct Card {
    /// Title of the study.
    pub title: String,
    /// Question of the study; may be empty.
    pub question: String,
    /// Answer as a sentence.
    pub headline: String,
    /// First chart, if it has one.
    pub picture: Option<Picture>,
    /// Name of its folder, which distinguishes studies with the same title.
    pub folder: String,
    /// Link to its report, relative to the gallery's folder.
    pub report: String,
}

/// The page of several studies, with a card for each that links to its report. Equal cards give equal bytes on every
/// machine.
pub fn gallery(cards: &[Card]) -> String {
    let count = match cards.len() {
        1 => "One study".to_owned(),
        count => format!("{count} studies"),
    };
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(&count, ""))
            body {
                header {
                    div.bar { span.brand { "sagnac " (env!("CARGO_PKG_VERSION")) } }
                    h1 { (count) }
                }
                main.gallery {
                    @for card in cards {
                        article {
                            a href=(card.report) {
                                @if let Some(picture) = &card.picture { div.thumbnail { (PreEscaped(picture.svg())) } }
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
