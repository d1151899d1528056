//! The fillers as a JSON document.

use serde_json::{Value, json};

use crate::analysis::firmware::Firmware;

impl Firmware {
    /// All fillers as JSON.
    pub fn document(&self) -> Value {
        let fillers: Vec<Value> = self
            .designs
            .iter()
            .map(|design| {
                let errors: Vec<Value> = design
                    .rules()
                    .map(|(error, rule, closed)| {
                        let whole = rule.whole();
                        json!({
                            "error": error.name(),
                            "ticks": rule.ticks,
                            "denominator": rule.denominator,
                            "exact": rule.exact,
                            "by_tick": (rule.rows.len() == self.gap_ticks as usize).then_some(&rule.rows),
                            "numerators": whole.numerators,
                            "weights": whole.values().collect::<Vec<_>>(),
                            "noise_gain": whole.noise_gain(),
                            "largest_gain": whole.largest_gain(),
                            "largest_input": rule.largest_input(),
                            "amplitude_arcsec": closed.amplitude,
                            "rms_arcsec": closed.rms,
                        })
                    })
                    .collect();
                json!({ "name": design.name, "method": design.method, "errors": errors })
            })
            .collect();
        let at: serde_json::Map<String, Value> =
            self.at.iter().map(|(key, value)| ((*key).to_owned(), json!(value.to_string()))).collect();
        json!({
            "title": self.title,
            "at": at,
            "tick_s": self.tick_s,
            "gap_ticks": self.gap_ticks,
            "fillers": fillers,
            "no_rms_because": self.unsampled,
        })
    }
}
