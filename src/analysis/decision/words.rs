//! Quantities of decisions as text.

use sagnac_base::quantity::number::significant;
use sagnac_base::quantity::units::{Dimension, Quantity};

/// A quantity with this many digits; a time below a tenth of a second in milliseconds.
pub(crate) fn short(quantity: Quantity, digits: usize) -> String {
    // In the unit that is shown.
    let shown = quantity.read();
    let part = significant(shown, digits).parse().map_or(1.0, |rounded: f64| rounded / shown);
    let value = if shown == 0.0 { 0.0 } else { quantity.value * part };
    match quantity.dimension {
        Dimension::Time if value.abs() < 0.1 => format!("{} ms", significant(1000.0 * value, digits)),
        _ => Quantity { value, ..quantity }.to_string(),
    }
}
