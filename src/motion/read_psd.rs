//! Reading a power spectral density.

use toml::Spanned;

use crate::key::file::motion::Ends;
use crate::key::scalar;
use crate::kinds::gap_fill::keys::FREQUENCY;
use crate::quantity::units::Dimension;
use crate::source::diagnose::Fault;
use crate::theory::psd::Psd;

/// A density, row by row.
pub(crate) fn read_psd(
    key: &str,
    written: &Spanned<Vec<Spanned<Ends>>>,
    dimension: Dimension,
) -> Result<Psd, Fault> {
    let (rows, span) = (written.get_ref(), written.span());
    let mut points: Vec<[f64; 2]> = Vec::new();
    for row in rows {
        let [frequency, density] = &row.get_ref()[..] else {
            let message = format!("a row of {key} has {} values", row.get_ref().len());
            return Err(Fault::new(row.span(), message, "not two", "write a frequency and a density"));
        };
        let nu = FREQUENCY.read_as(key, frequency)?;
        let value = scalar::quantity(key, density, &[dimension])?;
        if value.value <= 0.0 {
            let message = format!("{key} has a density of {value} at {nu}");
            let label = if value.value < 0.0 { "negative" } else { "zero" };
            let help = "accepted: densities above 0; outside the frequencies given there is no motion";
            return Err(Fault::new(density.span(), message, label, help));
        }
        if points.last().is_some_and(|last| last[0] >= nu.value) {
            let message = format!("{key} does not rise at {nu}");
            return Err(Fault::new(
                frequency.span(),
                message,
                "not above the one before",
                "sort the rows by frequency",
            ));
        }
        points.push([nu.value, value.value]);
    }
    if points.len() < 2 {
        let message = format!("{key} has {} rows", points.len());
        return Err(Fault::new(span, message, "too few", "give two rows or more: the ends of a line each"));
    }
    // What its own checks would find has been refused with its place.
    Psd::new(points)
        .map_err(|error| Fault::new(span, error.to_string(), "no spectrum", "sort the rows by frequency"))
}
