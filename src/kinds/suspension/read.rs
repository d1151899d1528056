//! Reading a suspension: a name, or its modes.

use std::ops::Range;
use std::sync::Arc;

use toml::Spanned;

use crate::key::file::suspension::ModeTable;
use crate::key::scalar::Scalar;
use crate::key::setting::{Key, Swept};
use crate::key::sweep::Sweep;
use crate::quantity::units::Dimension;
use crate::source::diagnose::{Fault, choices};
use crate::theory::suspension::{Mode, NAMES, Suspension};

/// [`NAMES`] as a key lists them.
pub(crate) const GYROS: &str = "LGK-400, LGV-1";

/// Most modes of a suspension.
const MOST_MODES: usize = 16;

static MODE_FREQUENCY: Key = Key {
    name: "suspension.modes.frequency",
    label: "natural frequency",
    accepts: &[Dimension::Frequency],
    limits: (1e-3, 1e6, "1e-3 Hz to 1e6 Hz"),
};
static MODE_Q: Key = Key {
    name: "suspension.modes.q",
    label: "Q factor",
    accepts: &[Dimension::Ratio],
    limits: (0.5, 1e4, "0.5 to 10000"),
};
static MODE_RESPONSE: Key = Key {
    name: "suspension.modes.response",
    label: "response at resonance",
    accepts: &[Dimension::RatePerAcceleration],
    limits: (-1e9, 1e9, "-1e9 to 1e9 arcsec/s/g"),
};

/// The suspension that is written in a table at `span`; where only a sweep over the key `gyro_key` names one, its first.
pub(crate) fn read(
    gyro_key: &str,
    gyro: &Option<Spanned<Scalar>>,
    modes: &Option<Spanned<Vec<Spanned<ModeTable>>>>,
    span: Range<usize>,
    sweeps: &[Sweep],
) -> Result<Arc<Suspension>, Fault> {
    let table = gyro_key.trim_end_matches(".gyro");
    let swept = sweeps.iter().find(|sweep| sweep.key.name == gyro_key);
    if let (Some(modes), Some(_)) = (modes, swept) {
        let message = format!("{table}.modes stands beside a sweep over {gyro_key}");
        return Err(Fault::new(modes.span(), message, "another suspension", "leave one of them out"));
    }
    let suspension = match (gyro, modes, swept.and_then(|sweep| sweep.values.first())) {
        (Some(gyro), None, _) => named(gyro_key, gyro)?,
        (None, Some(modes), _) => Suspension::new(read_modes(table, modes)?),
        (None, None, Some(Swept::Name(name))) => Suspension::named(name).unwrap_or(Suspension::new(vec![])),
        _ => {
            let message = format!("{table} needs exactly one of gyro, modes");
            let help = "accepted: gyro = \"LGK-400\", or modes = [{ frequency = \"380 Hz\", q = 100, response = \
                        \"20000 arcsec/s/g\" }]";
            return Err(Fault::new(span, message, "not exactly one", help));
        }
    };
    Ok(Arc::new(suspension))
}

/// That what a suspension has besides its name's frequencies is assumed; `None` where its modes are written.
pub(crate) fn assumed(gyro_key: &str, gyro: &Option<Spanned<Scalar>>, sweeps: &[Sweep]) -> Option<String> {
    let swept = sweeps.iter().find(|sweep| sweep.key.name == gyro_key);
    let names: Vec<String> = match (swept, gyro) {
        (Some(sweep), _) => sweep.values.iter().map(Swept::to_string).collect(),
        (None, Some(gyro)) => match gyro.get_ref() {
            Scalar::Text(name) => vec![name.clone()],
            _ => vec![],
        },
        (None, None) => vec![],
    };
    (!names.is_empty()).then(|| {
        format!(
            "Q factors and responses of the suspension of {} are assumed: only the frequencies are published",
            names.join(" and ")
        )
    })
}

fn named(key: &str, gyro: &Spanned<Scalar>) -> Result<Suspension, Fault> {
    let name = if let Scalar::Text(name) = gyro.get_ref() { name } else { "" };
    Suspension::named(name).ok_or_else(|| {
        let message = format!("{key}: there is no suspension {}", gyro.get_ref());
        let help = format!("{}; or give its modes", choices(name, &NAMES));
        Fault::new(gyro.span(), message, "not one of the names", help)
    })
}

fn read_modes(table: &str, modes: &Spanned<Vec<Spanned<ModeTable>>>) -> Result<Vec<Mode>, Fault> {
    let count = modes.get_ref().len();
    if !(1..=MOST_MODES).contains(&count) {
        let message = format!("{table}.modes has {count} modes");
        let label = if count == 0 { "no mode" } else { "too many modes" };
        return Err(Fault::new(modes.span(), message, label, format!("accepted: 1 to {MOST_MODES} modes")));
    }
    let mode = |written: &Spanned<ModeTable>| {
        let ModeTable { frequency, q, response } = written.get_ref();
        Ok(Mode {
            frequency_hz: MODE_FREQUENCY.read_as(&format!("{table}.modes.frequency"), frequency)?.value,
            q: MODE_Q.read_as(&format!("{table}.modes.q"), q)?.value,
            response: MODE_RESPONSE.read_as(&format!("{table}.modes.response"), response)?.value,
        })
    };
    modes.get_ref().iter().map(mode).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_lists_all_suspensions_that_are_known() {
        assert_eq!(GYROS, NAMES.join(", "));
    }
}
