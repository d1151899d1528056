//! Maps of a quantity over two swept ones, with a cell for each pair of their values.
//!
//! A heat map shows a value by colour, a winner map the series with the least value.
//!
//! [`winners`] finds the series with the least value in each cell. `Words` is the text of the legend, which pictures and pages
//! share.

pub(crate) mod svg;

use serde::Serialize;

use crate::chart::figure::{Axis, Entry, Grouping, Limit, merge_entries, names_of, near};

/// A map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Map {
    /// Title, in bold.
    pub title: String,
    /// A second, smaller line.
    pub subtitle: Option<String>,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The quantity that is shown or compared.
    pub z: Axis,
    /// The values of x with a column of cells, ascending, which the axis can show.
    pub columns: Vec<f64>,
    /// The values of y with a row of cells, ascending, which the axis can show.
    pub rows: Vec<f64>,
    /// The cells.
    pub cells: Cells,
    /// Values of the cells: those of a heat map, or those of all competitors of a winner map.
    pub layers: Vec<Layer>,
    /// Limit against which z is judged.
    pub limit: Option<Limit>,
    /// Rows selected from the table for the legend, such as `filler = const`.
    pub chosen: Vec<String>,
}

/// The cells of a map row by row, from the least y: the cell of a column and a row has the index row · columns +
/// column. Cells without a known value stay blank.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cells {
    /// Values by colour, where the scale of z can show them.
    Values(Vec<Option<f64>>),
    /// The entries with the least value.
    Winners {
        /// Competitors, and joint entries for cells with several winners.
        of: Grouping,
        /// Winners.
        won: Vec<Option<Won>>,
        /// Whether the values have uncertainties, so that a lead can be judged.
        banded: bool,
    },
}

/// The values of all cells, in the order of [`Cells`], with their intervals.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Layer {
    /// [`Entry::style`](crate::chart::figure::Entry::style) of the competitor; 0 for a heat map.
    pub style: usize,
    /// Name of the competitor; empty for a heat map.
    pub name: String,
    /// Values in the unit of z; `None` where unknown.
    pub values: Vec<Option<Estimate>>,
}

/// A value with the lower and upper end of its 95 % interval.
pub type Estimate = (f64, Option<(f64, f64)>);

/// The winner of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Won {
    /// [`Entry::style`](crate::chart::figure::Entry::style) of the winner.
    pub style: usize,
    /// Its value.
    pub value: f64,
    /// Whether its interval ends below that of the next competitor. Unknown intervals count as having zero width.
    pub certain: bool,
}

impl Map {
    /// The value of each cell: the one shown, or that of the winner.
    fn values(&self) -> Vec<Option<f64>> {
        match &self.cells {
            Cells::Values(values) => values.clone(),
            Cells::Winners { won, .. } => won.iter().map(|won| won.map(|won| won.value)).collect(),
        }
    }

    /// Whether its values are only no and yes, as 0 and 1, and both occur.
    pub fn is_yes_or_no(&self) -> bool {
        let Cells::Values(values) = &self.cells else { return false };
        let known = || values.iter().flatten();
        known().all(|value| [0.0, 1.0].contains(value))
            && known().any(|value| *value == 0.0)
            && known().any(|value| *value == 1.0)
    }

    /// Number of cells with a value.
    pub fn known(&self) -> usize {
        self.values().iter().flatten().count()
    }

    /// Number of cells with a value within the limit; `None` without a limit.
    pub fn within_limit(&self) -> Option<usize> {
        let limit = self.limit.as_ref()?.value;
        Some(self.values().into_iter().flatten().filter(|value| *value <= limit).count())
    }
}

/// A fraction of all cells in percent, which is never rounded to all or none.
pub fn share(part: usize, cells: usize) -> String {
    let percent = 100.0 * part as f64 / cells.max(1) as f64;
    let shown = match percent {
        0.0 => return "no cells".to_owned(),
        _ if part == cells => return "all cells".to_owned(),
        p if p < 0.1 => "< 0.1".to_owned(),
        p if p < 9.95 => format!("{p:.1}"),
        p if p > 99.5 => "> 99.5".to_owned(),
        p => format!("{p:.0}"),
    };
    format!("{shown} % of cells")
}

/// Finds the winner of each cell in which every entry has a value: the entry with the least one.
///
/// Entries that agree in all cells become one, named `const = linear`; the names of such entries are returned. Several
/// winners of single cells, which no merging of their entries explains, get an entry of their own. Values are equal if
/// they agree to the nine digits that files show.
pub fn winners(
    entries: &mut Vec<Entry>,
    values: &[Vec<Option<Estimate>>],
) -> (Vec<Option<Won>>, Vec<String>) {
    let styles = entries.len();
    let merged = merge_entries(entries, |a, b| same_series(&values[a.style], &values[b.style]));
    let merged = names_of(entries, &merged);
    let cells = values.first().map_or(0, Vec::len);
    let mut ties: Vec<Entry> = vec![];
    let won = (0..cells).map(|cell| {
        // Merged entries stand for others, so all of them must have a value.
        let here: Vec<Estimate> = values.iter().map(|series| series[cell]).collect::<Option<_>>()?;
        let value = here.iter().map(|estimate| estimate.0).fold(f64::INFINITY, f64::min);
        let (first, others): (Vec<&Entry>, Vec<&Entry>) =
            entries.iter().partition(|entry| near(here[entry.style].0, value));
        let style = match first[..] {
            [] => return None,
            [only] => only.style,
            _ => tie(&mut ties, styles, &first),
        };
        // Equal winners share their interval, whatever its width.
        let top = first.iter().filter_map(|entry| here[entry.style].1).map(|band| band.1);
        let top = top.fold(f64::NEG_INFINITY, f64::max);
        let certain = others.iter().filter_map(|entry| here[entry.style].1).all(|(low, _)| top < low);
        Some(Won { style, value, certain })
    });
    let won = won.collect();
    entries.extend(ties);
    (won, merged)
}

/// The style of an entry for several winners, which is created if it does not exist yet.
fn tie(ties: &mut Vec<Entry>, styles: usize, winners: &[&Entry]) -> usize {
    let names: Vec<&str> = winners.iter().map(|entry| entry.name.as_str()).collect();
    let name = names.join(" = ");
    let place = ties.iter().position(|entry| entry.name == name).unwrap_or_else(|| {
        ties.push(Entry { style: styles + ties.len(), name });
        ties.len() - 1
    });
    ties[place].style
}

/// Series without values are not compared.
fn same_series(a: &[Option<Estimate>], b: &[Option<Estimate>]) -> bool {
    let alike = |(a, b): (&Option<Estimate>, &Option<Estimate>)| match (a, b) {
        (Some(a), Some(b)) => near(a.0, b.0),
        (a, b) => a.is_none() && b.is_none(),
    };
    a.iter().any(Option::is_some) && a.iter().zip(b).all(alike)
}

/// The texts of a legend; those that do not apply are absent.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Words {
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
    pub(crate) fn words(&self) -> Words {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_never_rounded_to_all_or_none() {
        let shown: Vec<String> = [(0, 9), (1, 5000), (1, 300), (1, 3), (299, 300), (9, 9), (0, 0)]
            .map(|(part, cells)| share(part, cells))
            .into();
        assert_eq!(
            shown,
            [
                "no cells",
                "< 0.1 % of cells",
                "0.3 % of cells",
                "33 % of cells",
                "> 99.5 % of cells",
                "all cells",
                "no cells"
            ]
        );
    }

    fn entries(names: &[&str]) -> Vec<Entry> {
        names.iter().enumerate().map(|(style, name)| Entry { style, name: (*name).to_owned() }).collect()
    }

    fn exact(values: &[f64]) -> Vec<Option<Estimate>> {
        values.iter().map(|&value| Some((value, None))).collect()
    }

    fn styles(won: &[Option<Won>]) -> Vec<Option<usize>> {
        won.iter().map(|won| won.map(|won| won.style)).collect()
    }

    #[test]
    fn the_least_value_wins_and_series_that_agree_everywhere_win_as_one() {
        let mut names = entries(&["const", "linear", "quadratic"]);
        let values = [exact(&[1.0, 5.0]), exact(&[1.0, 5.0 + 1e-12]), exact(&[2.0, 3.0])];
        let (won, merged) = winners(&mut names, &values);
        assert_eq!(styles(&won), [Some(0), Some(2)]);
        assert_eq!(merged, ["const = linear"]);
        assert_eq!(names.iter().map(|entry| entry.style).collect::<Vec<_>>(), [0, 2]);
    }

    #[test]
    fn equal_values_in_single_cells_are_no_win_of_either() {
        let mut names = entries(&["const", "linear", "quadratic"]);
        let values = [exact(&[1.0, 1.0, 4.0]), exact(&[1.0, 2.0, 4.0]), exact(&[3.0, 3.0, 4.0])];
        let (won, merged) = winners(&mut names, &values);
        assert_eq!(styles(&won), [Some(3), Some(0), Some(4)]);
        assert!(merged.is_empty());
        let ties: Vec<&str> = names[3..].iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(ties, ["const = linear", "const = linear = quadratic"]);
    }

    #[test]
    fn a_cell_has_no_winner_while_a_value_is_missing() {
        let mut names = entries(&["const", "quadratic"]);
        let values = [exact(&[1.0, 1.0]), vec![None, Some((2.0, None))]];
        assert_eq!(styles(&winners(&mut names, &values).0), [None, Some(0)]);
    }

    #[test]
    fn a_lead_is_certain_where_the_bands_are_apart() {
        let mut names = entries(&["const", "quadratic"]);
        let with = |value: f64, low: f64, high: f64| Some((value, Some((low, high))));
        let values = [
            vec![with(1.0, 0.9, 1.1), with(1.0, 0.9, 1.3), with(1.0, 0.9, 1.3)],
            vec![with(1.5, 1.2, 1.8), with(1.5, 1.2, 1.8), Some((1.5, None))],
        ];
        let (won, _) = winners(&mut names, &values);
        let certain: Vec<bool> = won.iter().flatten().map(|won| won.certain).collect();
        assert_eq!(certain, [true, false, true]);
    }
}
