//! What the rate may depend on.

use sagnac_engine::key::names;
use sagnac_records::allan::{Deviation, Unit};

names! {
    /// A term of the model of a rate.
    pub enum Effect {
        /// In proportion to the temperature: T − T_ref, in K.
        Temperature = "T",
        /// In proportion to its square: (T − T_ref)², in K².
        Square = "T2",
        /// In proportion to its change: dT/dt, in K/min.
        Change = "dT",
        /// A decay since the start of the record: exp(−t/τ).
        WarmUp = "warm-up",
        /// A straight line of time, in days.
        Aging = "aging",
    }
}

impl Effect {
    /// Unit of the coefficient in files, and for the user, for a curve in `unit`.
    pub fn unit(self, unit: Unit) -> [String; 2] {
        let per = match self {
            Effect::Temperature => ["/K", "/K"],
            Effect::Square => ["/K^2", "/K²"],
            Effect::Change => ["/(K/min)", "/(K/min)"],
            Effect::WarmUp => ["", ""],
            Effect::Aging => ["/day", "/day"],
        };
        let of = |rate: &str, per: &str| match (rate, per) {
            ("", "") => String::new(),
            ("", per) => format!("1{per}"),
            _ => format!("{rate}{per}"),
        };
        let deviation = Deviation::Oadev;
        [of(unit.in_files(deviation), per[0]), of(unit.symbol(deviation), per[1])]
    }

    /// Its name in a sentence.
    pub fn title(self) -> &'static str {
        match self {
            Effect::Temperature => "the temperature",
            Effect::Square => "the square of the temperature",
            Effect::Change => "the change of the temperature",
            Effect::WarmUp => "a warm-up",
            Effect::Aging => "aging",
        }
    }
}
