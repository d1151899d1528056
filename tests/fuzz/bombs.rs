//! Files that promise or unpack to far more than they hold: each is refused, or read, within seconds and a part of 1 GiB.

use std::io::{Cursor, Write};
use std::time::Duration;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use sagnac::study::Study;
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::cases::records::run;
use crate::limits::{Taken, within};

/// Most bytes and time of a file. The time is that of the whole program, to which the making of other cases adds.
const MAX_BYTES: usize = 1 << 29;
const MAX_TIME: Duration = Duration::from_secs(5);

/// The header of a .npy file of this shape.
fn npy(shape: &str) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}");
    [b"\x93NUMPY\x01\x00\x76\x00".to_vec(), format!("{header:<117}\n").into_bytes()].concat()
}

/// An archive of members of `copies` MiB of zeros each behind a header.
fn npz(members: usize, copies: usize) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(vec![]));
    for member in 0..members {
        archive.start_file(format!("g{member}.npy"), SimpleFileOptions::default()).unwrap();
        archive.write_all(&npy(&format!("{},", (copies << 20) / 8))).unwrap();
        (0..copies).for_each(|_| archive.write_all(&vec![0; 1 << 20]).unwrap());
    }
    archive.finish().unwrap().into_inner()
}

/// A field of four or eight bytes of the last record with this signature, set to `value`.
fn with_field(mut archive: Vec<u8>, signature: &[u8; 4], at: usize, value: &[u8]) -> Vec<u8> {
    let record = archive.windows(4).rposition(|four| four == signature).unwrap();
    archive[record + at..][..value.len()].copy_from_slice(value);
    archive
}

/// A MATLAB file of version 5 with a column of that many bytes, of which `zeros` MiB follow.
fn mat(bytes: u32, zeros: usize) -> Vec<u8> {
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let head = words(&[6, 8, 6, 0, 5, 8, bytes / 8, 1, 1, 4]);
    let size = (head.len() as u32 + 16).wrapping_add(bytes);
    let mut packed = ZlibEncoder::new(vec![], Compression::best());
    for part in [words(&[14, size]), head, b"gyro\0\0\0\0".to_vec(), words(&[9, bytes])] {
        packed.write_all(&part).unwrap();
    }
    (0..zeros).for_each(|_| packed.write_all(&vec![0; 1 << 20]).unwrap());
    let packed = packed.finish().unwrap();
    let text = format!("{:<124}", "MATLAB 5.0 MAT-file").into_bytes();
    [text, vec![0, 1, b'I', b'M'], words(&[15, packed.len() as u32]), packed].concat()
}

/// Bytes with their length before them.
fn counted(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

/// An MCAP file with a chunk that promises `size` bytes.
fn mcap(size: u64, compression: &str, data: &[u8]) -> Vec<u8> {
    let record =
        |op: u8, body: Vec<u8>| [vec![op], (body.len() as u64).to_le_bytes().to_vec(), body].concat();
    let times = [0; 16].to_vec();
    let chunk = [
        times,
        size.to_le_bytes().to_vec(),
        vec![0; 4],
        counted(compression.as_bytes()),
        (data.len() as u64).to_le_bytes().to_vec(),
        data.to_vec(),
    ];
    [b"\x89MCAP0\r\n".to_vec(), record(1, vec![0; 8]), record(6, chunk.concat())].concat()
}

/// A bag with a chunk that promises `size` bytes.
fn bag(size: u32, compression: &[u8], data: &[u8]) -> Vec<u8> {
    let field = |name: &[u8], value: &[u8]| counted(&[name, b"=", value].concat());
    let header = [
        field(b"op", &[3]),
        field(b"chunk_count", &1_u32.to_le_bytes()),
        field(b"conn_count", &0_u32.to_le_bytes()),
        field(b"index_pos", &1_u64.to_le_bytes()),
    ];
    let chunk = [field(b"op", &[5]), field(b"compression", compression), field(b"size", &size.to_le_bytes())];
    let [header, chunk] = [header.concat(), chunk.concat()].map(|header| counted(&header));
    [b"#ROSBAG V2.0\n".to_vec(), header, counted(&[]), chunk, counted(data)].concat()
}

/// Zeros packed by lz4.
fn lz4(mib: usize) -> Vec<u8> {
    let mut packed = lz4_flex::frame::FrameEncoder::new(vec![]);
    (0..mib).for_each(|_| packed.write_all(&vec![0; 1 << 20]).unwrap());
    packed.finish().unwrap()
}

#[test]
fn logs_that_unpack_to_far_more_than_they_hold_take_neither_the_memory_nor_the_time() {
    let committed = |name: &str| {
        let path = format!("{}/tests/data/bombs/{name}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read(path).unwrap()
    };
    let many = npz(5000, 0);
    let overlapping = {
        let one = npz(1, 64);
        let start = one.windows(4).rposition(|four| four == b"PK\x01\x02").unwrap();
        let end = one.windows(4).rposition(|four| four == b"PK\x05\x06").unwrap();
        let count = [500_u16.to_le_bytes(); 2].concat();
        let size = ((end - start) as u32 * 500).to_le_bytes();
        let entries = one[start..end].repeat(500);
        let last =
            [b"PK\x05\x06\0\0\0\0", &count[..], &size, &(start as u32).to_le_bytes(), &[0; 2]].concat();
        [&one[..start], &entries, &last].concat()
    };
    let bombs: [(&str, Vec<u8>); 20] = [
        ("npy of 8 TB", [npy("1000000000000,"), vec![0; 64]].concat()),
        ("npy of 4·10⁹ columns", [npy("2, 4000000000"), vec![0; 64]].concat()),
        ("npz of 512 MiB of zeros", npz(1, 512)),
        ("npz in an npz", npz(1, 64)),
        ("npz of 5000 members", many),
        ("npz whose members overlap", overlapping),
        ("npz of a false size", with_field(npz(1, 1), b"PK\x01\x02", 24, &[0xf0, 0xff, 0xff, 0xff])),
        ("npz of a false packed size", with_field(npz(1, 1), b"PK\x01\x02", 20, &[0xf0, 0xff, 0xff, 0x7f])),
        ("npz of a false count", with_field(npz(1, 1), b"PK\x05\x06", 8, &[0xff; 4])),
        ("hdf5 without the chunks that it promises", committed("unallocated.h5")),
        ("hdf5 of MATLAB 7.3 without its chunks", committed("unallocated_v73.mat")),
        ("mat of 256 MiB of zeros", mat(1 << 28, 256)),
        ("mat of a false size", mat(0xffff_fff8, 1)),
        ("mcap of a false size", mcap(1 << 60, "", &[0; 64])),
        ("mcap of lz4 that promises too little", mcap(16, "lz4", &lz4(64))),
        ("mcap of lz4 that promises too much", mcap((1 << 27) - 1, "lz4", &lz4(1)[..40])),
        ("bag of lz4 that promises too little", bag(16, b"lz4", &lz4(128))),
        ("bag of lz4 that promises too much", bag(0xffff_fff0, b"lz4", &lz4(1))),
        ("csv of a million columns", b"1,".repeat(1 << 20)),
        ("csv of one quotation", [b"\"".to_vec(), b"1,".repeat(1 << 24)].concat()),
    ];
    for (what, bytes) in bombs {
        let kept = std::env::temp_dir().join("bomb");
        let (outcomes, taken) = within(&bytes[..bytes.len().min(1 << 16)], kept, || run(&bytes));
        let Taken { time, bytes: held } = taken;
        println!("{what}: {} bytes, {time:?}, {} MiB", bytes.len(), held >> 20);
        let longest = MAX_TIME * outcomes.len() as u32;
        assert!(time < longest && held < MAX_BYTES, "{what}: {time:?}, {} MiB", held >> 20);
    }
}

#[test]
fn studies_of_a_file_of_the_largest_size_take_less_than_the_memory() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("study.toml");
    let start = "title = \"t\"\nkind = \"gap-fill\"\n";
    for (what, text) in [
        ("a wide list", format!("{start}x = [{}]\n", "1,".repeat(2_000_000))),
        ("a deep key", format!("{start}{}a = 1\n", "a.".repeat(2_000_000))),
        ("a deep list", format!("{start}x = {}", "[".repeat(4_000_000))),
        ("many tables", (0..400_000).map(|number| format!("[a{number}]\n")).collect()),
        ("a long title", format!("title = \"{}\"\nkind = \"gap-fill\"\n", "x".repeat(4_000_000))),
        ("a long name", format!("{start}{} = 1\n", "x".repeat(4_000_000))),
    ] {
        std::fs::write(&path, &text).unwrap();
        let kept = std::env::temp_dir().join("bomb.toml");
        let (study, Taken { time, bytes }) = within(what.as_bytes(), kept, || Study::read(&path));
        println!("{what}: {time:?}, {} MiB", bytes >> 20);
        let said = study.unwrap_err().render(false, 100);
        assert!(said.len() < 4000, "{what}: {}", &said[..4000]);
        assert!(time < MAX_TIME && bytes < MAX_BYTES, "{what}: {time:?}, {} MiB", bytes >> 20);
    }
}
