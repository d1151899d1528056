//! Files and messages that are compressed as a whole.

use std::borrow::Cow;
use std::io::{self, Read};

use flate2::read::MultiGzDecoder;

use crate::record::format::check_unpacked;
use crate::record::malformed;

/// Most bytes that a file may unpack to: it is held in memory.
const MAX_FILE: u64 = 1 << 30;

/// Bytes unpacked between two looks at their number.
const BLOCK: u64 = 1 << 20;

/// Opens a reader of what is compressed.
type Unpacker = for<'a> fn(Box<dyn Read + 'a>) -> io::Result<Box<dyn Read + 'a>>;

/// A compression.
pub(crate) struct Packing {
    pub name: &'static str,
    /// The first bytes of what is compressed.
    begins: &'static [u8],
    open: Unpacker,
}

const PACKINGS: &[Packing] = &[
    Packing { name: "gzip", begins: b"\x1f\x8b", open: |packed| Ok(Box::new(MultiGzDecoder::new(packed))) },
    #[cfg(feature = "ros")]
    Packing {
        name: "bzip2",
        begins: b"BZh",
        open: |packed| Ok(Box::new(bzip2::read::MultiBzDecoder::new(packed))),
    },
    #[cfg(feature = "ros")]
    Packing { name: "zstd", begins: ZSTD, open: |packed| Ok(Box::new(zstd::Decoder::new(packed)?)) },
];

impl Packing {
    /// The compression of a file that begins so, if it has one that is read.
    pub(crate) fn new(head: &[u8]) -> Option<&'static Packing> {
        let is_so = |packing: &&Packing| {
            // A text may begin with the letters of bzip2, behind which is the size of its blocks.
            let is_size = |byte: &u8| (b'1'..=b'9').contains(byte);
            head.starts_with(packing.begins)
                && (packing.name != "bzip2" || head.get(packing.begins.len()).is_some_and(is_size))
        };
        PACKINGS.iter().find(is_so)
    }

    /// All bytes in a file of `stored` bytes.
    ///
    /// # Errors
    /// The file is damaged, or holds far more than recordings do.
    pub(crate) fn unpack(&self, packed: Box<dyn Read + '_>, stored: Option<u64>) -> io::Result<Vec<u8>> {
        let (mut reader, mut bytes) = ((self.open)(packed)?, Vec::new());
        while Read::take(&mut reader, BLOCK).read_to_end(&mut bytes)? > 0 {
            let length = bytes.len() as u64;
            check_unpacked(length, stored)?;
            if length > MAX_FILE {
                return malformed(&format!("it holds more than {} MiB: unpack it before", MAX_FILE >> 20));
            }
        }
        Ok(bytes)
    }
}

/// The first bytes of what zstd has compressed.
const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";

/// A message of ROS 2 as it was before a recorder compressed it, if it was: none of CDR begins like zstd.
///
/// # Errors
/// It is damaged, or this build lacks zstd.
pub(crate) fn message(bytes: &[u8]) -> io::Result<Cow<'_, [u8]>> {
    if !bytes.starts_with(ZSTD) {
        return Ok(bytes.into());
    }
    let Some(packing) = Packing::new(ZSTD) else {
        return malformed("its messages are compressed by zstd, which this build does not read");
    };
    let mut message = Vec::new();
    (packing.open)(Box::new(bytes))?.take(BLOCK).read_to_end(&mut message)?;
    Ok(message.into())
}

#[cfg(test)]
mod tests {
    use crate::record::format::tests::{channel, refusal};
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut packed = flate2::write::GzEncoder::new(vec![], flate2::Compression::fast());
        packed.write_all(bytes).unwrap();
        packed.finish().unwrap()
    }

    #[test]
    fn files_of_every_format_may_be_compressed() {
        let text: String = (0..50).map(|i| format!("{i},{}\n", i % 7)).collect();
        let text = format!("time [ms],gz [dps]\n{text}");
        let expected: Vec<f64> = (0..50).map(|i| f64::from(i % 7)).collect();
        let parts = [gzip(&text.as_bytes()[..100]), gzip(&text.as_bytes()[100..])].concat();
        for packed in [gzip(text.as_bytes()), parts] {
            assert_eq!(channel(&packed, "gz").samples, expected);
        }
        let bag = include_bytes!("../../../../../tests/data/formats/imu.db3");
        let [packed, plain] = [&gzip(bag), &bag[..]].map(|bytes| channel(bytes, "/imu/data.gx").samples);
        assert!(
            plain.iter().zip(&packed).all(|(a, b)| a.to_bits() == b.to_bits()) && packed.len() == plain.len()
        );
        #[cfg(feature = "ros")]
        {
            let mut packed = bzip2::write::BzEncoder::new(vec![], bzip2::Compression::fast());
            packed.write_all(text.as_bytes()).unwrap();
            assert_eq!(channel(&packed.finish().unwrap(), "gz").samples, expected);
            let packed = zstd::encode_all(text.as_bytes(), 0).unwrap();
            assert_eq!(channel(&packed, "gz").samples, expected);
        }
    }

    #[test]
    fn damaged_and_huge_files_are_refused() {
        let text = b"time [ms],gz [dps]\n".to_vec();
        let packed = gzip(&[text, b"1,2\n".repeat(100)].concat());
        let mut other = packed.clone();
        let end = other.len() - 6;
        other[end] ^= 1;
        let huge = gzip(&vec![b'1'; 80 << 20]);
        for (bytes, piece) in
            [(&packed[..packed.len() - 9], "ends too early"), (&other, "gzip"), (&huge, "100 times as many")]
        {
            let said = refusal(bytes, "gz");
            assert!(said.contains("cannot be unpacked from gzip") && said.contains(piece), "{said}");
        }
    }
}
