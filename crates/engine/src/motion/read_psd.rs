//! Reading of a power spectral density.

use crate::key::given::Given;
use crate::key::holds::Holds;
use crate::motion::keys::FREQUENCIES;
use sagnac_base::source::diagnose::Fault;
use sagnac_theory::psd::Psd;

/// Reads a density row by row, each a frequency and a value that `densities` accepts.
pub(crate) fn read_psd(written: Given, densities: &Holds) -> Result<Psd, Fault> {
    let (rows, key) = (written.items(), written.key.name);
    let mut points: Vec<[f64; 2]> = Vec::new();
    for row in &rows {
        let [frequency, density] = row.items()[..] else { continue };
        let (nu, value) = (frequency.read(&FREQUENCIES)?, density.read(densities)?);
        if value.value <= 0.0 {
            let message = format!("{key} has a density of {value} at {nu}");
            let label = if value.value < 0.0 { "negative" } else { "zero" };
            let help = "accepted: densities above 0; outside the frequencies given there is no motion";
            return Err(density.fault(message, label, help));
        }
        if points.last().is_some_and(|last| last[0] >= nu.value) {
            let message = format!("{key} does not rise at {nu}");
            return Err(frequency.fault(message, "not above the one before", "sort the rows by frequency"));
        }
        points.push([nu.value, value.value]);
    }
    if points.len() < 2 {
        let message = format!("{key} has {} rows", points.len());
        return Err(written.fault(message, "too few", "give two rows or more: the ends of a line each"));
    }
    // Faults that `Psd::new` would find have already been refused with their place.
    Psd::new(points)
        .map_err(|error| written.fault(error.to_string(), "not a spectrum", "sort the rows by frequency"))
}
