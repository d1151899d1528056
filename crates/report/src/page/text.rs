//! A page as text for a terminal.

use crate::answer::text::{labelled, wrapped};
use crate::page::sections::{Block, Cell, Grid, Page, Section};
use sagnac_base::table::text::aligned;

/// Width of running text where no terminal has one.
const USUAL_WIDTH: usize = 80;

/// Most rows of a small table; of longer ones every second, third, … is shown.
const MAX_ROWS: usize = 48;

impl Page {
    /// The sections without their charts and files, within `limit` columns, with settings in the words of `spell`.
    pub fn text(&self, limit: Option<usize>, spell: &dyn Fn(&str) -> String) -> String {
        let sections = self.sections.iter().filter_map(|section| section.text(limit, spell));
        sections.collect::<Vec<_>>().join("\n")
    }
}

impl Section {
    fn text(&self, limit: Option<usize>, spell: &dyn Fn(&str) -> String) -> Option<String> {
        let blocks: Vec<String> = self.blocks.iter().filter_map(|block| block.text(limit, spell)).collect();
        (!blocks.is_empty()).then(|| format!("{}\n{}", self.heading, blocks.join("\n")))
    }
}

impl Block {
    fn text(&self, limit: Option<usize>, spell: &dyn Fn(&str) -> String) -> Option<String> {
        let width = limit.unwrap_or(USUAL_WIDTH);
        let indented = |text: &str| {
            wrapped(&spell(text), width.saturating_sub(2)).iter().map(|line| format!("  {line}\n")).collect()
        };
        match self {
            Block::Text(text) | Block::Note(text) => Some(indented(text)),
            Block::Facts(facts) => {
                let rows = facts.iter().flat_map(|(name, lines)| {
                    let names = std::iter::once(*name).chain(std::iter::repeat(""));
                    names.zip(lines.iter().map(|line| spell(line)))
                });
                Some(labelled(&rows.collect::<Vec<_>>(), width))
            }
            Block::Grid(grid) => Some(grid.text(limit)),
            Block::More(title, grid) => Some(format!("  {title}\n{}", grid.text(limit))),
            Block::Options(table) => Some(table.text(width)),
            Block::Command(command) => Some(format!("    {command}\n")),
            Block::Chart(_) | Block::Trace(_) | Block::File(..) => None,
        }
    }
}

impl Grid {
    fn text(&self, limit: Option<usize>) -> String {
        let step = self.rows.len().div_ceil(MAX_ROWS).max(1);
        let cell = |cell: &Cell| match &*cell.below {
            "" => cell.text.clone(),
            below => format!("{} ({below})", cell.text),
        };
        let rows = self.rows.iter().step_by(step).map(|row| row.iter().map(cell).collect());
        let text = aligned(&std::iter::once(self.head.clone()).chain(rows).collect::<Vec<_>>(), limit);
        if step == 1 { text } else { format!("{text}  one in {step} of {} rows\n", self.rows.len()) }
    }
}
