//! Every format of recorded data gives the same samples, with the same gap.

use std::path::Path;

use sagnac::record::log::Log;
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
    let request = Request { columns, timing, data: Some(data), units, temperature: None, hints };
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

/// A type of numbers as NumPy calls it, with the bytes of six numbers, lowest first, and these.
type Numbers = (&'static str, Vec<Vec<u8>>, Vec<f64>);

/// The numbers of tests/data/formats/types.h5: ends of the range, and some within.
fn types() -> Vec<Numbers> {
    macro_rules! integers {
        ($($name:literal $type:ident),*) => {
            vec![$({
                let numbers = [$type::MIN, $type::MAX, 0, 1, 77, $type::MIN + 1];
                ($name, numbers.iter().map(|x| x.to_le_bytes().to_vec()).collect(), numbers.iter().map(|x| *x as f64).collect())
            }),*]
        };
    }
    let mut all: Vec<Numbers> =
        integers!("i1" i8, "i2" i16, "i4" i32, "i8" i64, "u1" u8, "u2" u16, "u4" u32, "u8" u64);
    let numbers = [0.1, -1000.0, 65000.0, 2f64.powi(-14), 1.5, 7.0];
    let single = numbers.map(|x| x as f32);
    all.push(("f8", numbers.iter().map(|x| x.to_le_bytes().to_vec()).collect(), numbers.to_vec()));
    all.push((
        "f4",
        single.iter().map(|x| x.to_le_bytes().to_vec()).collect(),
        single.map(f64::from).to_vec(),
    ));
    // Half precision has eleven bits.
    let half = [0x2e66_u16, 0xe3d0, 0x7bef, 0x0400, 0x3e00, 0x4700];
    let values = vec![0.099_975_585_937_5, -1000.0, 64_992.0, 2f64.powi(-14), 1.5, 7.0];
    all.push(("f2", half.iter().map(|x| x.to_le_bytes().to_vec()).collect(), values));
    all
}

fn plain(path: &Path, columns: &[&str]) -> Result<Log, String> {
    let columns: Vec<String> = columns.iter().map(|&column| column.to_owned()).collect();
    let units = vec![Unit::parse("none", Data::Rate).unwrap()];
    let (timing, hints) = (Timing::Step(0.01), Hints::default());
    let request = Request { columns, timing, data: Some(Data::Rate), units, temperature: None, hints };
    Log::read(path, &request).map_err(|error| error.render(false, 200))
}

#[test]
fn every_type_of_numbers_is_read_to_the_bit_in_both_orders_of_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let types_in_hdf5 = TEXT.path().with_file_name("types.h5");
    // Types of MATLAB by their number.
    let of_matlab = [
        ("i1", 1),
        ("u1", 2),
        ("i2", 3),
        ("u2", 4),
        ("i4", 5),
        ("u4", 6),
        ("f4", 7),
        ("f8", 9),
        ("i8", 12),
        ("u8", 13),
    ];
    for (name, bytes, numbers) in types() {
        let check = |path: &Path, column: &str| {
            let log = plain(path, &[column]).unwrap_or_else(|error| panic!("{name}: {error}"));
            let found: Vec<u64> = log.channels[0].samples.iter().map(|x| x.to_bits()).collect();
            let wanted: Vec<u64> = numbers.iter().map(|x| x.to_bits()).collect();
            assert_eq!(
                found,
                wanted,
                "{name} in {}, {column}: {:?}",
                path.display(),
                log.channels[0].samples
            );
        };
        for big_endian in [false, true] {
            let ordered = |number: &Vec<u8>| {
                if big_endian { number.iter().rev().copied().collect() } else { number.clone() }
            };
            let data: Vec<u8> = bytes.iter().flat_map(ordered).collect();
            let order = if big_endian { "be" } else { "le" };
            for layout in ["whole", "chunks"] {
                check(&types_in_hdf5, &format!("{name}_{order}_{layout}"));
            }
            let sign = if big_endian { '>' } else { '<' };
            let header = format!("{{'descr': '{sign}{name}', 'fortran_order': False, 'shape': (6,), }}");
            let header = format!("{header:<117}\n");
            let path = folder.path().join("log.npy");
            let npy = [b"\x93NUMPY\x01\x00\x76\x00".to_vec(), header.into_bytes(), data.clone()].concat();
            std::fs::write(&path, npy).unwrap();
            check(&path, "1");
            let Some((_, kind)) = of_matlab.iter().find(|(known, _)| *known == name) else { continue };
            let word = |word: u32| if big_endian { word.to_be_bytes() } else { word.to_le_bytes() };
            let element = |kind: u32, data: &[u8]| {
                let mut bytes = [word(kind), word(data.len() as u32)].concat();
                bytes.extend(data);
                bytes.resize(bytes.len().next_multiple_of(8), 0);
                bytes
            };
            let size = [word(6), word(1)].concat();
            let parts = [
                element(6, &[word(6), word(0)].concat()),
                element(5, &size),
                element(1, b"gyro"),
                element(*kind, &data),
            ];
            let mut mat = vec![b' '; 124];
            mat.extend(if big_endian { [1, 0, b'M', b'I'] } else { [0, 1, b'I', b'M'] });
            mat.extend(element(14, &parts.concat()));
            let path = folder.path().join("log.mat");
            std::fs::write(&path, mat).unwrap();
            check(&path, "gyro");
        }
    }
}

#[test]
fn numbers_of_an_unusual_layout_are_refused_and_packed_ones_unpacked() {
    let path = |name: &str| TEXT.path().with_file_name(name);
    let refused = plain(&path("odd_types.h5"), &["bias"]).unwrap_err();
    for piece in ["`bias`", "`bits`", "unusual layout of bits"] {
        assert!(refused.contains(piece), "{refused}");
    }
    let log = plain(&path("packed.h5"), &["rate"]).unwrap();
    let found = &log.channels[0].samples;
    assert!(found[2].is_nan() && found[5].is_nan(), "{found:?}");
    assert_eq!([found[0], found[1], found[3], found[4]], [10.5, 9.0, 12.0, 12.5]);
}

#[test]
fn a_damaged_header_of_numpy_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.npy");
    let read = |header: &str| {
        let mut bytes =
            [b"\x93NUMPY\x01\x00\x76\x00".to_vec(), format!("{header:<117}\n").into_bytes()].concat();
        bytes.extend([0; 32]);
        std::fs::write(&path, bytes).unwrap();
        plain(&path, &["1"])
    };
    let sound = "{'descr': '<i8', 'fortran_order': False, 'shape': (4,), }";
    read(sound).unwrap();
    for (from, to) in [
        ("<i8", "\0i8"),
        ("<i8", "|i8"),
        ("False", "Fals\0"),
        (": False", "\u{7f}False"),
        ("order", "orden"),
        ("(4,)", "(4,"),
        ("'shape'", "'descr'"),
        (", }", ", 'x': 1}"),
        ("}", ""),
        ("{", ""),
        ("(4,)", "(4,2,1)"),
    ] {
        assert!(read(&sound.replace(from, to)).is_err(), "{from} as {to}");
    }
}

#[test]
fn files_that_unpack_to_far_more_than_recordings_do_are_refused() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("zeros.npz");
    let packed = |rows: usize| {
        let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
        archive.start_file("gyro.npy", zip::write::SimpleFileOptions::default()).unwrap();
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows},), }}");
        archive.write_all(b"\x93NUMPY\x01\x00\x76\x00").unwrap();
        archive.write_all(format!("{header:<117}\n").as_bytes()).unwrap();
        let zeros = vec![0; 8 << 10];
        (0..rows >> 10).for_each(|_| archive.write_all(&zeros).unwrap());
        archive.finish().unwrap();
    };
    packed(1 << 24);
    let refused = plain(&path, &["gyro"]).unwrap_err();
    assert!(refused.contains("unpack to more than 100 times as many"), "{refused}");
    packed(1 << 20);
    assert_eq!(plain(&path, &["gyro"]).unwrap().samples(), 1 << 20);
}
