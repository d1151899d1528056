//! NumPy arrays, with headers that are right, and others.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

const TYPES: [&str; 18] = [
    "<f8", ">f8", "<f4", ">f4", "|i1", "|u1", "<i2", ">i4", "<i8", "<u2", ">u4", "<u8", "=f8", "f8", "|V8",
    "<c16", "é", "",
];

const SIZES: [&str; 10] = [
    "0",
    "1",
    "-1",
    "3.5",
    "1L",
    "268435456",
    "268435457",
    "4294967296",
    "9223372036854775808",
    "18446744073709551615",
];

/// The bytes of an array.
pub fn array() -> impl Strategy<Value = Vec<u8>> {
    let version = prop_oneof![4 => 1_u8..4, 1 => any::<u8>()];
    let described = prop_oneof![3 => Just("<f8"), 2 => select(&TYPES[..])];
    let size = || prop_oneof![8 => (0_usize..70).prop_map(|size| size.to_string()), 1 => select(&SIZES[..]).prop_map(str::to_owned)];
    let columns = prop_oneof![2 => (1_usize..4).prop_map(|size| size.to_string()), 1 => size()];
    let shape = prop_oneof![
        3 => size().prop_map(|rows| format!("({rows},)")),
        4 => (size(), columns).prop_map(|(rows, columns)| format!("({rows}, {columns})")),
        1 => select(&["()", "(1, 2, 3)", "(,)", "3", "(", "(2)", "(((2,", "(2,,2)"][..]).prop_map(str::to_owned),
    ];
    let filling = prop_oneof![
        3 => 0_usize..4000,
        // Longer than is read, and than the bytes that say how long it is may tell.
        1 => select(&[65_400_usize, 65_536, 70_000][..]),
    ];
    let numbers = prop_oneof![
        3 => vec(select(&[0.0, 1.5, -2.0, 1e300, f64::NAN][..]), 0..200).prop_map(bytes_of),
        2 => (1_usize..5000).prop_map(|count| bytes_of((0..count).map(|i| i as f64 * 0.1).collect())),
        1 => vec(any::<u8>(), 0..600),
    ];
    (version, described, any::<bool>(), shape, filling, numbers).prop_map(
        |(version, described, is_fortran, shape, filling, numbers)| {
            let order = if is_fortran { "True" } else { "False" };
            let text = format!("{{'descr': '{described}', 'fortran_order': {order}, 'shape': {shape}, }}");
            let header = text + &" ".repeat(filling) + "\n";
            let mut bytes = b"\x93NUMPY".to_vec();
            bytes.extend([version, 0]);
            match version {
                1 => bytes.extend((header.len() as u16).to_le_bytes()),
                _ => bytes.extend((header.len() as u32).to_le_bytes()),
            }
            bytes.extend(header.into_bytes());
            bytes.extend(numbers);
            bytes
        },
    )
}

fn bytes_of(numbers: Vec<f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(f64::to_le_bytes).collect()
}
