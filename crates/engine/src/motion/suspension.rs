//! Reading of a suspension, given by name or by its modes.

use std::sync::Arc;

use crate::key::given::Given;
use crate::key::holds::{Holds, measure};
use crate::key::reading::Reading;
use crate::key::row::Key;
use crate::key::setting::{Swept, named as swept_name};
use sagnac_base::quantity::units::Dimension;
use sagnac_base::source::diagnose::{Fault, choices};
use sagnac_theory::suspension::{Mode, NAMES, Suspension};

/// Most modes of a suspension.
const MAX_MODES: usize = 16;

/// The gyros whose suspensions are known.
pub(crate) const GYROS: Holds = Holds::Name(&NAMES);
pub(crate) const MODE_FREQUENCIES: Holds = measure(&[Dimension::Frequency], 1e-3, 1e6, "1e-3 Hz to 1e6 Hz");
pub(crate) const QS: Holds = measure(&[Dimension::Ratio], 0.5, 1e4, "0.5 to 10000");
pub(crate) const RESPONSES: Holds =
    measure(&[Dimension::RatePerAcceleration], -1e9, 1e9, "-1e9 to 1e9 arcsec/s/g");

/// The keys of a table that describes a suspension.
pub(crate) struct SuspensionKeys {
    pub(crate) table: &'static Key,
    pub(crate) gyro: &'static Key,
    pub(crate) modes: &'static Key,
    /// The frequency, Q factor and response of each mode.
    pub(crate) mode: [&'static Key; 3],
}

impl SuspensionKeys {
    /// Reads the suspension; where only a sweep names suspensions, the first of them.
    pub(crate) fn read(&self, reading: &Reading) -> Result<Arc<Suspension>, Fault> {
        let (gyro, modes) = (reading.get(self.gyro), reading.get(self.modes));
        let swept = reading.sweep(self.gyro);
        if let (Some(modes), Some(_)) = (modes, swept) {
            let message = format!("{} conflicts with a sweep over {}", self.modes.name, self.gyro.name);
            return Err(modes.fault(message, "another suspension", "leave one of them out"));
        }
        let suspension = match (gyro, modes, swept.and_then(|sweep| sweep.values.first())) {
            (Some(gyro), None, _) => known(gyro)?,
            (None, Some(modes), _) => Suspension::new(self.read_modes(modes)?),
            (None, None, Some(Swept::Name(name))) => {
                Suspension::named(name).unwrap_or(Suspension::new(vec![]))
            }
            _ => {
                let message = format!("{} needs exactly one of gyro, modes", self.table.name);
                let help = format!("accepted: {}, or {}", self.gyro.example, self.modes.example);
                let span = reading.table.span_of(self.table).unwrap_or_default();
                return Err(Fault::new(span, message, "not exactly one", help));
            }
        };
        Ok(Arc::new(suspension))
    }

    /// States that all properties of a named suspension except its frequencies are assumed; `None` where modes are
    /// given.
    pub(crate) fn assumed(&self, reading: &Reading) -> Option<String> {
        let names: Vec<String> = match (reading.sweep(self.gyro), reading.get(self.gyro)) {
            (Some(sweep), _) => sweep.values.iter().map(Swept::to_string).collect(),
            (None, Some(gyro)) => vec![gyro.text().to_owned()],
            (None, None) => vec![],
        };
        (!names.is_empty()).then(|| {
            format!(
                "Q factors and responses of the suspension of {} are assumed: only the frequencies are published",
                names.join(" and ")
            )
        })
    }

    /// The suspension selected by a sweep.
    pub(crate) fn swept(&self, swept: &[(&'static str, Swept)]) -> Option<Arc<Suspension>> {
        Suspension::named(swept_name(swept, self.gyro)?).map(Arc::new)
    }

    fn read_modes(&self, modes: Given) -> Result<Vec<Mode>, Fault> {
        let items = modes.items();
        let count = items.len();
        if !(1..=MAX_MODES).contains(&count) {
            let message = format!("{} has {count} modes", self.modes.name);
            let label = if count == 0 { "no modes" } else { "too many modes" };
            return Err(modes.fault(message, label, format!("accepted: 1 to {MAX_MODES} modes")));
        }
        let mode = |table| {
            let value = |key| crate::key::table::Table::needed(&table, key)?.quantity().map(|q| q.value);
            let [frequency, q, response] = self.mode;
            Ok(Mode { frequency_hz: value(frequency)?, q: value(q)?, response: value(response)? })
        };
        items.iter().filter_map(Given::table).map(mode).collect()
    }
}

fn known(gyro: Given) -> Result<Suspension, Fault> {
    Suspension::named(gyro.text()).ok_or_else(|| {
        let message = format!("{}: there is no suspension {gyro}", gyro.key.name);
        let help = format!("{}; or give its modes", choices(gyro.text(), &NAMES));
        gyro.fault(message, "not one of the names", help)
    })
}
