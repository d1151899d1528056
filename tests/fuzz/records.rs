//! Records and logs: whatever a file holds, it is refused in words, or gives samples that are numbers or missing.

mod arrays;
mod tables;

use proptest::prelude::*;
use proptest::sample::select;

use crate::campaign::{Target, fuzz};
use crate::cases::records::run;
use crate::edits;

const TARGET: Target = Target { name: "records", ending: "log", run };

/// What has a meaning in a table or in the header of an array.
const TOKENS: &[&str] = &[
    "\n",
    "\r\n",
    "\r",
    ",",
    ";",
    "\t",
    " ",
    "\"",
    "\"\"",
    "#",
    "%",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1e308",
    "-1e308",
    "5e-324",
    "-0",
    "0x1p3",
    "+",
    "\0",
    "\u{feff}",
    "µ",
    "″",
    "[deg/s]",
    "(ms)",
    "_deg_per_s",
    "time",
    "rate",
    "_",
    "a,",
    "1,5",
    "1.700000000e18",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }",
    "(18446744073709551615, 2)",
    "'|V8'",
    "-1",
    "True",
];

#[test]
fn records() {
    let corpus: Vec<Vec<u8>> = TARGET.corpus().into_iter().map(|(_, bytes)| bytes).collect();
    let file = prop_oneof![3 => tables::table(), 2 => arrays::array(), 2 => select(corpus)];
    let few = prop_oneof![1 => Just(vec![]).boxed(), 2 => edits::edits(4, TOKENS).boxed()];
    fuzz(
        &TARGET,
        (file, few).prop_map(|(mut bytes, edits)| {
            edits::apply(&mut bytes, &edits);
            bytes
        }),
    );
}
