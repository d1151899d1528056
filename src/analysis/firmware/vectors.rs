//! Test vectors: integers on the ticks with the resulting output of a filler, to verify an implementation bit by bit.

use std::io;

use rand::rand_core::Rng;

use crate::analysis::firmware::{Design, Firmware, Rule};
use sagnac_base::table::{About, Cell, Column, Role, Table};
use sagnac_engine::kinds::gap_fill::columns::FILLER;
use sagnac_engine::tally::Id;
use sagnac_kernel::philox::Philox;

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
        let mut words = Philox::new(Id::of(&format!("test vectors\nseed={}\n", self.seed)).key());
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

    /// Writes a line for each filler and vector: the inputs `P[tick]`, then `E[j]` and `I[j]` for each lost tick, their
    /// sums and `dP`. Values that a filler does not have are blank.
    ///
    /// # Errors
    /// The errors of the writer.
    pub fn write_vectors(&self, vectors: &Vectors, to: impl io::Write) -> io::Result<()> {
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
        Table { columns }.write_csv(to).map(drop)
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
