//! A table as a CSV file.

use std::io;

use sha2::{Digest, Sha256};

use crate::table::{Cell, Table};

impl Table {
    /// Writes the table as CSV: a header, then the rows; blanks stay empty. A text that a spreadsheet would take for a
    /// formula, because it begins with `=`, `+`, `-`, `@`, a tab or a carriage return and is no number, has an apostrophe
    /// before it (OWASP, "CSV Injection"). Returns the SHA-256 of what was written, in hexadecimal digits.
    ///
    /// # Errors
    /// The errors of the writer.
    pub fn write_csv(&self, to: impl io::Write) -> io::Result<String> {
        let mut hashed = Hashed { to, hash: Sha256::new() };
        let mut writer = csv::Writer::from_writer(&mut hashed);
        writer.write_record(self.columns.iter().map(|column| guarded(column.header()))).map_err(of_file)?;
        let text = |cell: &Cell| match cell {
            Cell::Text(text) => guarded(text.clone()),
            cell => cell.text(),
        };
        let columns: Vec<_> = self.columns.iter().map(|column| column.cells.texts(text)).collect();
        for row in 0..self.rows() {
            for column in &columns {
                writer.write_field(&*column.at(row)).map_err(of_file)?;
            }
            writer.write_record(None::<&[u8]>).map_err(of_file)?;
        }
        writer.flush()?;
        drop(writer);
        Ok(hexadecimal(&hashed.hash.finalize()))
    }
}

/// A writer that hashes what it passes on.
struct Hashed<W> {
    to: W,
    hash: Sha256,
}

impl<W: io::Write> io::Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.to.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// The error of the file behind one of the CSV writer, which names a full disk.
pub fn of_file(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// A text of a file that no spreadsheet takes for a formula.
fn guarded(text: String) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.parse::<f64>().is_err();
    if is_formula { format!("'{text}") } else { text }
}

/// Bytes, in hexadecimal.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
