//! Parts in percent.

use toml::Spanned;

use crate::key::scalar::Scalar;
use crate::source::diagnose::Fault;

/// Reads `given`, the value of the key `name`, as a part; `help` says what is accepted.
pub(crate) fn percent(name: &str, given: &Spanned<Scalar>, help: &str) -> Result<f64, Fault> {
    let part = match given.get_ref() {
        Scalar::Text(text) => {
            text.trim().strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok())
        }
        _ => None,
    };
    let refuse = |message: String, label| Err(Fault::new(given.span(), message, label, help));
    match part {
        None => refuse(format!("{name}: {} is no part in percent", given.get_ref()), "not a part in percent"),
        Some(part) if !(1e-4..=50.0).contains(&part) => refuse(
            format!("{name} = {part} % is out of range, it must lie within 0.0001 % … 50 %"),
            "out of range",
        ),
        Some(part) => Ok(part / 100.0),
    }
}
