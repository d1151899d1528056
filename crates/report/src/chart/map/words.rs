//! The words of the legend of a map, which pictures and pages share.

use serde::Serialize;

use crate::chart::map::{Cells, Map, Won, share};

/// The texts of a legend; those that do not apply are absent.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Words {
    /// By what the winners are found.
    pub judged: Option<String>,
    /// The winners, each with its style.
    pub entries: Vec<(usize, String)>,
    /// That no lead can be judged.
    pub unjudged: Option<&'static str>,
    /// How many leads are uncertain.
    pub close: Option<String>,
    /// The limit, with the cells within it or beyond it.
    pub limit: Option<String>,
    /// What blank cells are.
    pub blank: Option<&'static str>,
}

impl Map {
    /// The words of its legend.
    pub fn words(&self) -> Words {
        let mut words = Words {
            judged: None,
            entries: vec![],
            unjudged: None,
            close: None,
            limit: self.limit_words(),
            blank: (self.known() < self.columns.len() * self.rows.len()).then_some("blank: not known"),
        };
        if self.is_yes_or_no() {
            let values = self.values();
            let count = |wanted: f64| values.iter().flatten().filter(|value| **value == wanted).count();
            let entry = |name: &str, value: f64| format!("{name}: {}", share(count(value), self.known()));
            words.entries = vec![(1, entry("yes", 1.0)), (2, entry("no", 0.0))];
        }
        if let Cells::Winners { of, won, banded } = &self.cells {
            let won: Vec<Won> = won.iter().copied().flatten().collect();
            let count = |style: usize| won.iter().filter(|won| won.style == style).count();
            let entry = |style: usize, name: &str| format!("{name}: {}", share(count(style), won.len()));
            let close = won.iter().filter(|won| !won.certain).count();
            words.judged = Some(format!("with the least {}", self.z.label));
            words.entries = of.entries.iter().map(|of| (of.style, entry(of.style, &of.name))).collect();
            words.unjudged =
                (!banded).then_some("no 95 % bands are known here: any lead is shown as certain");
            words.close = (*banded && close > 0).then(|| {
                format!("fainter: the 95 % bands of the best two overlap: {}", share(close, won.len()))
            });
        }
        words
    }

    fn limit_words(&self) -> Option<String> {
        let (limit, within) = self.limit.as_ref().zip(self.within_limit())?;
        let (known, label) = (self.known(), unbroken(&limit.label));
        Some(match self.cells {
            Cells::Values(_) => {
                format!("{label}, {}", unbroken(&format!("within: {}", share(within, known))))
            }
            Cells::Winners { .. } => {
                format!("even the least is over the {label}: {}", share(known - within, known))
            }
        })
    }
}

/// A text that stays in one line.
fn unbroken(text: &str) -> String {
    text.replace(' ', "\u{a0}")
}
