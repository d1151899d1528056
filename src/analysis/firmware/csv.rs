//! `weights.csv`: every weight in a row of its own.

use std::io;

use crate::analysis::firmware::design::Firmware;

impl Firmware {
    /// Writes a line for each weight: of each lost tick, and of their sum. `row` is the lost tick, or `sum`; the weight is
    /// the quotient, with all digits of an f64.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_weights(&self, to: impl io::Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(to);
        writer.write_record(["filler", "error", "row", "tick", "numerator", "denominator", "weight"])?;
        for design in &self.designs {
            for (error, rule, _) in design.rules() {
                let mut rows = Vec::new();
                if rule.rows.len() == self.gap_ticks as usize {
                    let by_tick = (1..).zip(&rule.rows);
                    rows.extend(by_tick.map(|(j, row): (u32, _)| {
                        (j.to_string(), row.iter().map(|w| i64::from(*w)).collect::<Vec<_>>())
                    }));
                }
                rows.push(("sum".to_owned(), rule.whole().numerators));
                for (row, numerators) in rows {
                    for (tick, w) in rule.ticks.iter().zip(numerators) {
                        let weight = w as f64 / f64::from(rule.denominator);
                        writer.write_record([
                            &design.name,
                            error.name(),
                            &row,
                            &tick.to_string(),
                            &w.to_string(),
                            &rule.denominator.to_string(),
                            &weight.to_string(),
                        ])?;
                    }
                }
            }
        }
        writer.flush()
    }
}
