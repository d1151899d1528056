//! Writing a log as CSV.

use std::io;
use std::iter::once;

use crate::record::log::channel::Log;
use sagnac_base::table::file::of_file;

impl Log {
    /// Writes the channels as CSV that [`Log::read`] reads back with their kind of data alone: the times from the first sample on,
    /// each name with its unit, and an empty cell where a sample is missing.
    ///
    /// Samples keep all their digits. Times are rounded, so that the sampling step that they give may differ in its last digit.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_csv(&self, to: impl io::Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(to);
        let names = self.channels.iter().map(|channel| format!("{} [{}]", channel.name, channel.unit.text));
        writer.write_record(once("time_s".to_owned()).chain(names)).map_err(of_file)?;
        for i in 0..self.samples() {
            let samples = self.channels.iter().map(|channel| channel.samples[i]);
            let numbers = once(i as f64 * self.step_s).chain(samples);
            let cells =
                numbers.map(|number| if number.is_nan() { String::new() } else { number.to_string() });
            writer.write_record(cells).map_err(of_file)?;
        }
        writer.flush()
    }
}
