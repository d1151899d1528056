//! Every format of recorded data gives the same samples, with the same gap.

use std::path::Path;

use sagnac::record::log::channel::Log;
use sagnac::record::log::measure::{Data, Unit};
use sagnac::record::log::read::{Hints, Request, Timing};

use crate::formats::{BINARIES, TEXT, bits};

#[test]
fn every_format_gives_the_bits_of_the_text() {
    let text = TEXT.read(&TEXT.path()).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
    assert_eq!((text.samples(), text.channels.len()), (43, 3));
    assert!((15..22).all(|row| text.channels[0].samples[row].is_nan()), "{text:?}");
    for sample in &BINARIES {
        let log = sample.read(&sample.path()).unwrap_or_else(|error| panic!("{}", error.render(false, 100)));
        assert_eq!(bits(&log), bits(&text), "{}", sample.file);
        assert!((log.step_s / 0.005 - 1.0).abs() < 1e-6, "{}: {} s", sample.file, log.step_s);
    }
}

/// The columns that a file of rates has.
fn read(path: &Path, timing: Timing, units: Vec<Unit>) -> Log {
    let (columns, data, hints) = (vec![], Data::Rate, Hints::default());
    let request = Request { columns, timing, data, units, temperature: None, hints };
    Log::read(path, &request).unwrap_or_else(|error| panic!("{}", error.render(false, 100)))
}

#[test]
fn attributes_of_hdf5_are_units() {
    let path = TEXT.path().with_file_name("imu.h5");
    let log = read(&path, Timing::Stamps { step_s: None, column: None, unit: None }, vec![]);
    assert_eq!(bits(&log), bits(&TEXT.read(&TEXT.path()).unwrap()));
    assert!(log.channels.iter().all(|channel| channel.unit_in_header.as_deref() == Some("rad/s")), "{log:?}");
}

/// An element of a MATLAB file, padded to eight bytes.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

#[test]
fn strings_and_tables_of_matlab_are_left_out_of_a_file() {
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let numbers = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    // An object has a system and a class in place of dimensions; its contents are in a matrix without a name.
    let matrix = |class: u32, size: [u32; 2], name: &str, data: Vec<u8>| {
        let header =
            [element(6, &words(&[class, 0])), element(5, &words(&size)), element(1, name.as_bytes())];
        element(14, &[header.concat(), data].concat())
    };
    let reference = matrix(13, [6, 1], "", element(6, &words(&[0xdd00_0000, 2, 1, 1, 1, 1])));
    let object = |name: &str| {
        let names = [name, "MCOS", "string"].map(|name| element(1, name.as_bytes())).concat();
        element(14, &[element(6, &words(&[17, 0])), names, reference.clone()].concat())
    };
    let mut file = vec![b' '; 124];
    file.extend([0, 1, b'I', b'M']);
    file.extend(object("note"));
    file.extend(matrix(6, [4, 1], "gz", element(9, &numbers(&[1.0, 2.5, -3.0, 4.0]))));
    file.extend(matrix(9, [8, 1], "", element(2, &[7; 8])));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mat");
    std::fs::write(&path, file).unwrap();
    let log = read(&path, Timing::Step(0.01), vec![Unit::parse("deg/h", Data::Rate).unwrap()]);
    assert_eq!(log.channels[0].samples, [1.0, 2.5, -3.0, 4.0]);
}
