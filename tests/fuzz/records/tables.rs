//! Tables of text, as loggers and people write them.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

const DELIMITERS: [&str; 7] = [",", ";", "\t", " ", ", ", "   ", ",\t"];
const LINE_ENDS: [&str; 4] = ["\n", "\r\n", "\r", "\n\n"];

/// What may stand before everything.
const STARTS: [&str; 8] = [
    "",
    "\u{feff}",
    "# made by a logger\n",
    "% t gz\n",
    "\n\n",
    "#\n# time [s], gz [deg/s]\n",
    "; a\r\n",
    "\"\n\"\n",
];

const TIMES: [&str; 10] = [
    "time [s]",
    "time [ms]",
    "time_ns",
    "t (h)",
    "time",
    "Time [us]",
    "time [deg]",
    "time [s^0]",
    "time []",
    "\"time [s]\"",
];

const RATES: [&str; 14] = [
    "rate [deg/s]",
    "rate (°/h)",
    "rate_deg_per_s",
    "rate_x",
    "rate",
    "gz [deg/s]",
    "gz_rad/s",
    "gx [arcsec]",
    "gz",
    "gz [pulses]",
    "",
    "rate [deg/s^99]",
    "\"a,b\"",
    "temp é",
];

const CELLS: [&str; 22] = [
    "",
    "nan",
    "NaN",
    "inf",
    "-Infinity",
    "1e308",
    "-1e308",
    "1.7976931348623157e308",
    "5e-324",
    "1e999",
    "-0",
    "abc",
    "1,5",
    "\"1\"",
    "\"",
    "1 2",
    "0x10",
    "+1.",
    ".5",
    "1_000",
    "é",
    "\0",
];

#[derive(Debug, Clone)]
struct Shape {
    delimiter: &'static str,
    line_end: &'static str,
    start: &'static str,
    header: Option<(&'static str, Vec<&'static str>)>,
    /// Besides the time.
    columns: usize,
    rows: usize,
    is_timed: bool,
    ends_with_delimiter: bool,
}

/// Times of rows: evenly spaced but for some scatter, and longer steps behind some rows.
#[derive(Debug, Clone)]
struct Clock {
    first: f64,
    step: f64,
    scatter: f64,
    gaps: Vec<(Index, f64)>,
}

/// The bytes of a table.
pub fn table() -> impl Strategy<Value = Vec<u8>> {
    (shape(), clock(), scale(), vec((any::<Index>(), any::<Index>(), select(&CELLS[..])), 0..3))
        .prop_map(|(shape, clock, scale, odd)| written(&shape, &clock, scale, &odd))
}

fn shape() -> impl Strategy<Value = Shape> {
    let usual =
        |usual: &'static str, all: &'static [&'static str]| prop_oneof![2 => Just(usual), 1 => select(all)];
    let names = (usual("time [s]", &TIMES), vec(usual("rate [deg/s]", &RATES), 0..4));
    let rows = prop_oneof![80 => 0_usize..80, 20 => 80_usize..3000, 1 => 100_000_usize..300_000];
    (
        usual(",", &DELIMITERS),
        usual("\n", &LINE_ENDS),
        usual("", &STARTS),
        proptest::option::of(names),
        0_usize..4,
        rows,
        any::<bool>(),
        proptest::bool::weighted(0.1),
    )
        .prop_map(
            |(delimiter, line_end, start, header, columns, rows, is_timed, ends_with_delimiter)| {
                // As many columns as names, where there are names.
                let columns = header.as_ref().map_or(columns, |(_, names)| names.len());
                Shape { delimiter, line_end, start, header, columns, rows, is_timed, ends_with_delimiter }
            },
        )
}

fn clock() -> impl Strategy<Value = Clock> {
    let first = prop_oneof![4 => Just(0.0), 1 => select(&[1.7e18, -5.0, 1e300, -1e308, 1e-310, 1e9][..])];
    let step = prop_oneof![4 => select(&[1.0, 10.0, 0.002, 2.5e6][..]), 1 => select(&[1e-300, 5e-324, 1e306, 0.0, -1.0][..])];
    let scatter = prop_oneof![3 => Just(0.0), 2 => 0.0..0.01, 1 => 0.0..0.3];
    let gap = prop_oneof![4 => (1_u32..6).prop_map(f64::from), 1 => select(&[0.5, 1e3, 4e9, 1e300][..])];
    (first, step, scatter, vec((any::<Index>(), gap), 0..3)).prop_map(|(first, step, scatter, gaps)| Clock {
        first,
        step,
        scatter,
        gaps,
    })
}

/// Of the values.
fn scale() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.01..100.0, 1 => select(&[0.0, 1e-320, 1e300, 1e307][..])]
}

fn written(shape: &Shape, clock: &Clock, scale: f64, odd: &[(Index, Index, &str)]) -> Vec<u8> {
    let Shape { delimiter, line_end, columns, rows, is_timed, .. } = *shape;
    let mut text = shape.start.to_owned();
    let mut add = |cells: &[&str]| {
        text += &cells.join(delimiter);
        text += if shape.ends_with_delimiter { delimiter } else { "" };
        text += line_end;
    };
    if let Some((time, names)) = &shape.header {
        let time = is_timed.then_some(*time);
        add(&time.into_iter().chain(names.iter().copied()).collect::<Vec<_>>());
    }
    let mut random = 1_u64;
    let mut scattered = move || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f64 / f64::from(1 << 23) - 1.0
    };
    let mut steps = 0.0;
    for row in 0..rows {
        let time = clock.first + clock.step * (steps + clock.scatter * scattered());
        let numbers = is_timed.then_some(time).into_iter().chain((0..columns).map(|_| scale * scattered()));
        let mut cells: Vec<String> = numbers.map(|number| format!("{number:e}")).collect();
        for (_, column, cell) in odd.iter().filter(|(at, ..)| at.index(rows) == row) {
            let column = column.index(cells.len() + 1);
            match cells.get_mut(column) {
                Some(old) => *old = (*cell).to_owned(),
                None => cells.push((*cell).to_owned()),
            }
        }
        add(&cells.iter().map(String::as_str).collect::<Vec<_>>());
        let gaps = clock.gaps.iter().filter(|(at, _)| at.index(rows) == row);
        steps += 1.0 + gaps.map(|(_, gap)| gap).sum::<f64>();
    }
    text.into_bytes()
}
