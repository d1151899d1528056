//! Test vectors: whole numbers on the ticks and what a filler makes of them, to verify an implementation bit by bit.

use std::io;

use rand::rand_core::Rng;

use crate::analysis::firmware::design::{Design, Firmware};
use crate::analysis::firmware::rule::Rule;
use crate::kernel::philox::Philox;
use crate::tally::id::Id;

/// Inputs on all ticks that any of the fillers reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Vectors {
    /// Ascending.
    pub ticks: Vec<i32>,
    /// One number for each tick.
    pub inputs: Vec<Vec<i32>>,
}

impl Firmware {
    /// As many vectors as asked for, the same for the same fillers and seed: first 0, constants, alternating signs, ramps
    /// and the signs of the weights of each filler, up to the largest inputs that all fillers take; then random ones of
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
            // No sum is larger than where every input has the sign of its weight.
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
        // A word loses from none to all but one of its bits, so that every magnitude comes up.
        let mut number = || {
            let (bits, shift) = (words.next_u32() as i32, words.next_u32() % 31);
            i64::from(bits >> shift).clamp(-limit, limit) as i32
        };
        while inputs.len() < count {
            inputs.push((0..ticks.len()).map(|_| number()).collect());
        }
        Vectors { ticks, inputs }
    }

    /// Writes a line for each filler and vector: the inputs `P[tick]`, then `E[j]` and `I[j]` for each lost tick, their sums
    /// and `dP`. What a filler does not have is blank.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_vectors(&self, vectors: &Vectors, to: impl io::Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(to);
        let mut header = vec!["filler".to_owned()];
        header.extend(vectors.ticks.iter().map(|tick| format!("P[{tick}]")));
        for name in ["E", "I"] {
            header.extend((1..=self.gap_ticks).map(|j| format!("{name}[{j}]")));
        }
        header.extend(["sum_E", "sum_I", "dP"].map(str::to_owned));
        writer.write_record(&header)?;
        for design in &self.designs {
            for inputs in &vectors.inputs {
                let mut line = vec![design.name.clone()];
                line.extend(inputs.iter().map(i32::to_string));
                let mut sums = Vec::new();
                for rule in [design.extrapolation.as_ref(), Some(&design.interpolation)] {
                    let read = |rule: &Rule| rule.fill(&vectors.read(rule, inputs));
                    let values = rule.map(read);
                    let value = |j: usize| {
                        values.as_ref().filter(|v| v.len() == self.gap_ticks as usize).map(|v| v[j])
                    };
                    line.extend((0..self.gap_ticks as usize).map(|j| text(value(j))));
                    sums.push(values.map(|values| values.iter().sum::<i64>()));
                }
                let correction = sums[0].zip(sums[1]).map(|(e, i)| e - i);
                line.extend([sums[0], sums[1], correction].map(text));
                writer.write_record(&line)?;
            }
        }
        writer.flush()
    }
}

impl Vectors {
    /// Of some inputs those on the ticks of a rule.
    fn read(&self, rule: &Rule, inputs: &[i32]) -> Vec<i32> {
        let of = |tick| self.ticks.iter().zip(inputs).find(|(own, _)| *own == tick).map(|(_, p)| *p);
        rule.ticks.iter().filter_map(of).collect()
    }
}

/// A number, or nothing where there is none.
fn text(value: Option<i64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}
