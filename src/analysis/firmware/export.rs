//! Files for firmware: the C header of a filler, and its test vectors.

use std::fmt::Write as _;

use crate::analysis::firmware::{Design, Firmware, Rule};
use rand::rand_core::Rng;
use sagnac_base::quantity::number::significant;
use sagnac_base::table::{About, Cell, Column, Role, Table};
use sagnac_engine::kinds::gap_fill::columns::FILLER;
use sagnac_engine::tally::Id;
use sagnac_kernel::philox::Philox;

/// Name of the file of the header.
pub(crate) const HEADER: &str = "sagnac_filler.h";

/// Instructions in the header for using the tables.
const USE: &str = " * Use. P(k) is the whole number read at tick k, in any unit of angle; all results have the same unit, and are rounded
 *   to whole ones, which adds 0.29 units rms to what is left: where that counts let P be pulses times 16, say.
 *   1. when the gap opens     e = sagnac_fill(&f->extrapolation, p, E), p[i] = P(f->extrapolation.ticks[i])
 *                             deliver E[0] .. E[n - 1] in place of ticks 1 .. n
 *   2. when tick m has come   i = sagnac_fill(&f->interpolation, p, I), p[i] = P(f->interpolation.ticks[i]),
 *                             m being the last of these ticks
 *   3. with the next tick     subtract dP = sagnac_correction(e, i) = sum (E_j - I_j) from tick m + 1
 * A table with one row for a gap of several ticks knows their sum alone: E or I has then one number, the sum. A
 * filler without extrapolation has count = 0 there; take e as the sum of what was delivered.
 *
 * Arithmetic. With S_j the sum of w * P over the rows 1 .. j and D the denominator,
 *   R_j = floor((S_j + floor(D / 2)) / D),  E_j or I_j = R_j - R_(j-1),  R_0 = 0:
 * the running sum is rounded, halves towards +infinity, so that rounding does not add up over the gap. No sum or
 * difference leaves 64 bits while every |P| is at most `limit`. A table is exact where it says so; else its weights are
 * rounded to the nearest w / D with D a power of two, and their sum is kept: a constant rate is filled without error.
";

const FUNCTIONS: &str = "\
#include <stdint.h>

typedef struct {
    int32_t count;          /* ticks that are read */
    const int32_t *ticks;   /* their numbers, ascending */
    int32_t rows;           /* SAGNAC_GAP_TICKS, or 1: the sum alone */
    const int32_t *weights; /* numerators, row by row */
    int32_t denominator;
    int32_t limit;          /* largest |P| */
} sagnac_rule;

typedef struct {
    sagnac_rule extrapolation; /* E */
    sagnac_rule interpolation; /* I */
} sagnac_filler;

/* The whole number nearest to a / d, halves towards +infinity; d > 0. */
static inline int64_t sagnac_round(int64_t a, int64_t d)
{
    int64_t x = a + d / 2;
    return x / d - (x % d < 0 ? 1 : 0);
}

/* Computes values[0] .. values[rows - 1] from p[0] .. p[count - 1], and returns their sum. */
static inline int64_t sagnac_fill(const sagnac_rule *rule, const int32_t *p, int64_t *values)
{
    int64_t sum = 0, filled = 0;
    for (int32_t row = 0; row < rule->rows; row++) {
        const int32_t *w = rule->weights + row * rule->count;
        for (int32_t k = 0; k < rule->count; k++) {
            sum += (int64_t)w[k] * p[k];
        }
        int64_t rounded = sagnac_round(sum, rule->denominator);
        values[row] = rounded - filled;
        filled = rounded;
    }
    return filled;
}

/* What is subtracted from the tick after the last one read: the sum delivered less the sum interpolated. */
static inline int64_t sagnac_correction(int64_t extrapolated, int64_t interpolated)
{
    return extrapolated - interpolated;
}
";

impl Firmware {
    /// The header in C99: tables of 32-bit integers and the functions that use them, exactly as [`Rule::fill`] does.
    pub fn header(&self) -> String {
        let names = identifiers(self.designs.iter().map(|design| design.name.as_str()));
        let mut text = String::new();
        let (version, title, n) = (env!("CARGO_PKG_VERSION"), comment(&self.title), self.gap_ticks);
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "/* Weights of gap fillers, written by `sagnac filler` {version}.\n *\n * Study: {title}"
        );
        let place = self.place();
        if !place.is_empty() {
            let _ = writeln!(text, " * Point: {}", comment(&place));
        }
        let of = self.tick_s.map_or_else(String::new, |tick_s| format!(" of T = {tick_s} s"));
        let _ = writeln!(
            text,
            " * Gap:   n = {n}: ticks 1 .. n{of} are lost; tick j is the angle turned over ((j - 1) T, j T], and the\n *        \
             switch starts at the end of tick 0\n *\n * Fillers:"
        );
        for (design, name) in self.designs.iter().zip(&names) {
            let (filler, expected) = (comment(&design.name), self.expected(design));
            let _ = writeln!(text, " *   sagnac_{name}: {filler}, {}\n *     {expected}", design.method);
        }
        let _ = writeln!(
            text,
            " *\n{USE} */\n#ifndef SAGNAC_FILLER_H\n#define SAGNAC_FILLER_H\n\n{FUNCTIONS}\n#define SAGNAC_GAP_TICKS {n}"
        );
        for (design, name) in self.designs.iter().zip(&names) {
            text += &tables(design, name);
        }
        text += "\n#endif\n";
        text
    }
}

/// The tables of a filler.
fn tables(design: &Design, name: &str) -> String {
    let mut text = format!("\n/* {}: {} */\n", comment(&design.name), design.method);
    let mut rules = Vec::new();
    for (part, rule) in
        [("extrapolation", design.extrapolation.as_ref()), ("interpolation", Some(&design.interpolation))]
    {
        rules.push(match rule {
            Some(rule) => {
                let table = format!("sagnac_{name}_{part}");
                text += &table_of(&table, rule);
                let Rule { ticks, rows, denominator, .. } = rule;
                let (count, limit) = (ticks.len(), rule.largest_input());
                format!(
                    "{{ {count}, {table}_ticks, {}, &{table}[0][0], {denominator}, {limit} }}",
                    rows.len()
                )
            }
            None => "{ 0, 0, 0, 0, 1, 0 }".to_owned(),
        });
    }
    text + &format!("static const sagnac_filler sagnac_{name} = {{\n    {}\n}};\n", rules.join(",\n    "))
}

/// The ticks and the weights of a rule.
fn table_of(name: &str, rule: &Rule) -> String {
    let Rule { ticks, rows, denominator, exact } = rule;
    let list = |numbers: &[i32]| numbers.iter().map(i32::to_string).collect::<Vec<_>>().join(", ");
    let lines: Vec<String> = rows.iter().map(|row| format!("    {{ {} }}", list(row))).collect();
    let (count, row_count) = (ticks.len(), rows.len());
    let gain = significant(rule.whole().noise_gain(), 6);
    let how = if *exact { "exact" } else { "rounded" };
    format!(
        "static const int32_t {name}_ticks[{count}] = {{ {} }};\n\
         static const int32_t {name}[{row_count}][{count}] = {{ /* {how}, over {denominator}; noise gain of the sum {gain} */\n{}\n}};\n",
        list(ticks),
        lines.join(",\n")
    )
}

/// Names of fillers as unique parts of C identifiers: characters other than letters and digits become `_`, and a number
/// distinguishes equal results.
pub fn identifiers<'n>(names: impl Iterator<Item = &'n str>) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for name in names {
        let plain: String = name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' })
            .collect();
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let free = core::iter::once(plain.clone()).chain(numbered).find(|name| !taken(&found, name));
        found.extend(free);
    }
    found
}

/// Whether the identifier of a filler with this name would already exist in the header.
fn taken(found: &[String], name: &str) -> bool {
    const OWN: [&str; 4] = ["rule", "filler", "round", "fill"];
    const PARTS: [&str; 4] =
        ["_extrapolation", "_interpolation", "_extrapolation_ticks", "_interpolation_ticks"];
    let part_of =
        |long: &str, short: &str| long.strip_prefix(short).is_some_and(|rest| PARTS.contains(&rest));
    OWN.contains(&name)
        || name == "correction"
        || found.iter().any(|own| own == name || part_of(own, name) || part_of(name, own))
}

/// Text that can neither end a comment, nor begin one or a trigraph in it.
fn comment(text: &str) -> String {
    let one_line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    one_line.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").replace('\\', "/")
}

/// Inputs on all ticks that any of the fillers reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Vectors {
    /// Ticks, ascending.
    pub ticks: Vec<i32>,
    /// Vectors of inputs, one number for each tick.
    pub inputs: Vec<Vec<i32>>,
}

impl Firmware {
    /// `count` vectors, which depend only on the fillers and the seed: first 0, constants, alternating signs, ramps and
    /// the signs of the weights of each filler, up to the largest inputs that all fillers accept, then random ones of
    /// every magnitude.
    pub fn vectors(&self, count: usize) -> Vectors {
        let rules = || self.designs.iter().flat_map(Design::rules).map(|(_, rule, _)| rule);
        let mut ticks: Vec<i32> = rules().flat_map(|rule| rule.ticks.iter().copied()).collect();
        ticks.sort_unstable();
        ticks.dedup();
        let most = rules().map(Rule::largest_input).min().unwrap_or(i32::MAX);
        let alternate = |k: usize, size: i32| if k.is_multiple_of(2) { size } else { -size };
        let along = |value: &dyn Fn(usize) -> i32| (0..ticks.len()).map(value).collect::<Vec<i32>>();
        let mut inputs = vec![vec![0; ticks.len()]];
        for size in [1, -1, 1000, -1000, most, -most] {
            inputs.push(along(&|_| size));
            inputs.push(along(&|k| alternate(k, size)));
        }
        for slope in [1, -1] {
            inputs.push(ticks.iter().map(|tick| slope * tick).collect());
        }
        for rule in rules() {
            // The sum is largest where every input has the sign of its weight.
            let weights = rule.whole();
            let sign = |tick: i32| {
                let place = weights.ticks.iter().position(|own| *own == tick);
                place.map_or(0, |k| weights.numerators[k].signum() as i32)
            };
            for size in [1, most] {
                inputs.push(ticks.iter().map(|&tick| size * sign(tick)).collect());
            }
        }
        inputs.truncate(count);
        let mut words = Philox::new(Id::from_text(&format!("test vectors\nseed={}\n", self.seed)).key());
        let limit = i64::from(most);
        // A word loses between none and all but one of its bits, so that every magnitude occurs.
        let mut number = || {
            let (bits, shift) = (words.next_u32() as i32, words.next_u32() % 31);
            i64::from(bits >> shift).clamp(-limit, limit) as i32
        };
        while inputs.len() < count {
            inputs.push((0..ticks.len()).map(|_| number()).collect());
        }
        Vectors { ticks, inputs }
    }

    /// A table as CSV with a row for each filler and vector: the inputs `P[tick]`, then `E[j]` and `I[j]` for each lost tick, their
    /// sums and `dP`. Values that a filler does not have are blank.
    pub fn vectors_csv(&self, vectors: &Vectors) -> Vec<u8> {
        let lost = self.gap_ticks as usize;
        let rows: Vec<Row> = self
            .designs
            .iter()
            .flat_map(|design| vectors.inputs.iter().map(move |inputs| (design, inputs)))
            .map(|(design, inputs)| {
                let fill = |rule: &Rule| rule.fill(&vectors.read(rule, inputs));
                let delivered = design.extrapolation.as_ref().map(fill);
                Row { filler: &design.name, inputs, delivered, known: fill(&design.interpolation) }
            })
            .collect();
        let of = |about: About, cell: &dyn Fn(&Row) -> Cell| about.with(rows.iter().map(cell).collect());
        let at = |about: About, tick: &str, cell: &dyn Fn(&Row) -> Cell| {
            let name = about.name.replace('…', tick);
            Column { name, ..of(about, cell) }
        };
        // Rules that give only the sum over the gap have no values of single ticks.
        let single =
            |values: &[i64], j: usize| whole(values.get(j - 1).filter(|_| values.len() == lost).copied());
        let inputs = vectors.ticks.iter().enumerate();
        let [filler, input, delivered, known, sum_delivered, sum_known, correction] = COLUMNS;
        let mut columns = vec![of(filler, &|row| row.filler.into())];
        columns.extend(inputs.map(|(place, tick)| {
            at(input, &tick.to_string(), &|row| Cell::Integer(row.inputs[place].into()))
        }));
        columns.extend((1..=lost).map(|j| {
            at(delivered, &j.to_string(), &|row| single(row.delivered.as_deref().unwrap_or_default(), j))
        }));
        columns.extend((1..=lost).map(|j| at(known, &j.to_string(), &|row| single(&row.known, j))));
        columns.extend([
            of(sum_delivered, &|row| whole(row.delivered())),
            of(sum_known, &|row| Cell::Integer(row.known())),
            of(correction, &|row| whole(row.delivered().map(|sum| sum - row.known()))),
        ]);
        let mut csv = Vec::new();
        // Writing to memory cannot fail.
        let _ = Table { columns }.write_csv(&mut csv);
        csv
    }
}

/// A row before it becomes cells.
struct Row<'a> {
    filler: &'a str,
    inputs: &'a [i32],
    delivered: Option<Vec<i64>>,
    known: Vec<i64>,
}

impl Row<'_> {
    fn delivered(&self) -> Option<i64> {
        self.delivered.as_ref().map(|values| values.iter().sum())
    }

    fn known(&self) -> i64 {
        self.known.iter().sum()
    }
}

/// A number, or a blank where it is absent.
fn whole(value: Option<i64>) -> Cell {
    value.map_or(Cell::Blank, Cell::Integer)
}

const fn value(name: &'static str, meaning: &'static str) -> About {
    About { role: Role::Estimate, meaning, ..About::named(name) }
}

/// The columns in the order of the file.
#[rustfmt::skip]
pub(crate) const COLUMNS: [About; 7] = [
    About { role: Role::Key, meaning: FILLER, ..About::named("filler") },
    value("P[…]", "Input: the angle of this valid tick, a whole number of units."),
    value("E[…]", "Value delivered instead of this lost tick while the gap is open; blank where the filler has no extrapolation."),
    value("I[…]", "Value of the filler for this lost tick once the ticks after the gap are known."),
    value("sum_E", "Sum of all E."),
    value("sum_I", "Sum of all I."),
    value("dP", "ΔP, the correction once the gap is closed, as `sagnac_correction` of the C header gives it."),
];

impl Vectors {
    /// Selects the inputs on the ticks of a rule.
    fn read(&self, rule: &Rule, inputs: &[i32]) -> Vec<i32> {
        let of = |tick| self.ticks.iter().zip(inputs).find(|(own, _)| *own == tick).map(|(_, p)| *p);
        rule.ticks.iter().filter_map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_filler_has_an_identifier_of_its_own() {
        let names = ["mv8+2", "mv8 2", "MV8-2", "fill", "a", "a extrapolation", "Δ"];
        let found = identifiers(names.into_iter());
        assert_eq!(found, ["mv8_2", "mv8_2_2", "mv8_2_3", "fill_2", "a", "a_extrapolation_2", "_"]);
    }

    #[test]
    fn no_title_ends_the_comment() {
        assert_eq!(comment("a */ b\n/* c ??/ *//"), "a * / b / * c ? ?/ * //");
    }
}
