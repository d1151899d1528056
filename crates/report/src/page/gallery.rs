//! A gallery: several results on one page.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, html};
use serde::{Deserialize, Serialize};

use crate::page::html::head;

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
