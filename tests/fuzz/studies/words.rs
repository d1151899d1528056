//! What may stand in a study: its keys and names from the schema, and values likely and unlikely.

use std::sync::LazyLock;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use toml::{Table, Value};

/// Every key and every fixed name of the schema.
pub static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let schema = serde_json::from_str(&sagnac_engine::kinds::schema()).unwrap();
    let mut names = Vec::new();
    collect(&schema, &mut names);
    names.sort();
    names.dedup();
    names
});

fn collect(schema: &serde_json::Value, names: &mut Vec<String>) {
    match schema {
        serde_json::Value::Object(object) => {
            for (key, value) in object {
                match (key.as_str(), value) {
                    ("properties", serde_json::Value::Object(properties)) => {
                        names.extend(properties.keys().cloned())
                    }
                    ("const", serde_json::Value::String(name)) => names.push(name.clone()),
                    ("enum" | "examples", serde_json::Value::Array(values)) => {
                        names.extend(values.iter().filter_map(|value| value.as_str()).map(str::to_owned));
                    }
                    _ => {}
                }
                collect(value, names);
            }
        }
        serde_json::Value::Array(values) => values.iter().for_each(|value| collect(value, names)),
        _ => {}
    }
}

/// Texts that are names of nothing, or of a file that is no record.
const ODD: [&str; 20] = [
    "",
    " ",
    ".",
    "data",
    "data/base_vibration.csv",
    "data/gyros/LGV-1.toml",
    "data/gyros",
    "/dev/zero",
    "\0",
    "\u{feff}",
    "é",
    "″",
    "n+1",
    "n+999999999999",
    "-7..0",
    "0..-7",
    "-99999..99999",
    "5/2",
    "1/0",
    "100 %",
];

const NUMBERS: [&str; 26] = [
    "0",
    "-0",
    "1",
    "-1",
    "3",
    "0.5",
    "1e-3",
    "1e3",
    "1e6",
    "1e-6",
    "1e9",
    "1e-9",
    "1e15",
    "1e-15",
    "1e40",
    "1e-40",
    "1e300",
    "1e-300",
    "1e308",
    "1e-323",
    "1e309",
    "NaN",
    "inf",
    "−2",
    "1_0.0_1",
    "1e99999999999",
];

const UNITS: [&str; 38] = [
    "",
    "%",
    "s",
    "ms",
    "us",
    "ns",
    "min",
    "h",
    "Hz",
    "kHz",
    "1/s",
    "arcsec",
    "″",
    "arcmin",
    "deg",
    "rad",
    "arcsec/s",
    "deg/s",
    "deg/h",
    "rad/s",
    "deg/sqrt(h)",
    "deg/√h",
    "arcsec/sqrt(s)",
    "deg/h/sqrt(Hz)",
    "deg/s^2",
    "deg/h/h",
    "deg/h/sqrt(h)",
    "g",
    "g^2/Hz",
    "arcsec/s/g",
    "(deg/s)^2/Hz",
    "arcsec/pulse",
    "s^0",
    "s^99",
    "s^-2147483648",
    "((((((((((((((s))))))))))))))",
    "√√s",
    "/",
];

/// A number with a unit, sensible or not.
pub fn quantity() -> impl Strategy<Value = String> {
    let plain = (1_u32..10_000, -4_i32..5).prop_map(|(digits, power)| format!("{digits}e{power}"));
    let number = prop_oneof![2 => plain, 1 => select(&NUMBERS[..]).prop_map(str::to_owned)];
    (number, select(&UNITS[..])).prop_map(|(number, unit)| format!("{number} {unit}"))
}

/// Any value.
pub fn value() -> impl Strategy<Value = Value> {
    let text = prop_oneof![
        6 => quantity(),
        3 => select(NAMES.as_slice()),
        2 => select(&ODD[..]).prop_map(str::to_owned),
        1 => any::<String>(),
        1 => (select(&["a", "1", "_", " ", "é", "n+1..", "((", "a "][..]), 1_usize..300_000).prop_map(|(text, n)| text.repeat(n)),
    ];
    let whole = prop_oneof![
        4 => -3_i64..20,
        1 => select(&[i64::MIN, i64::MAX, 1 << 31, 1 << 32, 1 << 40, 1 << 53, 64, 65, 10_000, 1_000_000][..]),
        1 => any::<i64>(),
    ];
    let float = prop_oneof![
        2 => (-10_000_i32..10_000).prop_map(|thousandths| f64::from(thousandths) / 1000.0),
        1 => any::<f64>(),
        1 => select(&[f64::NAN, f64::INFINITY, -0.0, f64::MAX, f64::MIN_POSITIVE, 5e-324][..]),
    ];
    let leaf = prop_oneof![
        8 => text.prop_map(Value::String),
        3 => whole.prop_map(Value::Integer),
        2 => float.prop_map(Value::Float),
        1 => any::<bool>().prop_map(Value::Boolean),
        1 => Just("1979-05-27T07:32:00Z".parse().map(Value::Datetime).unwrap()),
    ];
    leaf.prop_recursive(3, 40, 6, |inner| {
        let entry = (select(NAMES.as_slice()), inner.clone());
        prop_oneof![
            2 => vec(inner, 0..6).prop_map(Value::Array),
            1 => vec(entry, 0..4).prop_map(|entries| Value::Table(entries.into_iter().collect::<Table>())),
        ]
    })
}
