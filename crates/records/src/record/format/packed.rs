//! Compressed data: whole files, messages, and the chunks of recordings.

use std::borrow::Cow;
use std::io::{self, Read};
#[cfg(feature = "ros")]
use std::io::{BufRead, BufReader};

use flate2::read::MultiGzDecoder;
#[cfg(feature = "ros")]
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
#[cfg(feature = "ros")]
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

use crate::record::format::check_unpacked;
#[cfg(feature = "ros")]
use crate::record::format::part;
use crate::record::malformed;

/// Most bytes that a file may unpack to: it is held in memory.
const MAX_FILE: u64 = 1 << 30;

/// Bytes unpacked between two looks at their number.
const BLOCK: u64 = 1 << 20;

/// Opens a reader of what is compressed.
type Unpacker = for<'a> fn(Box<dyn Read + 'a>) -> Box<dyn Read + 'a>;

/// A compression.
pub(crate) struct Packing {
    pub name: &'static str,
    /// The first bytes of what is compressed.
    begins: &'static [u8],
    open: Unpacker,
}

const PACKINGS: &[Packing] = &[
    Packing { name: "gzip", begins: b"\x1f\x8b", open: |packed| Box::new(MultiGzDecoder::new(packed)) },
    #[cfg(feature = "ros")]
    Packing {
        name: "bzip2",
        begins: b"BZh",
        open: |packed| Box::new(bzip2::read::MultiBzDecoder::new(packed)),
    },
    #[cfg(feature = "ros")]
    Packing { name: "zstd", begins: ZSTD, open: |packed| Box::new(Zstd::new(packed)) },
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
        let (mut reader, mut bytes) = ((self.open)(packed), Vec::new());
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
    (packing.open)(Box::new(bytes)).take(BLOCK).read_to_end(&mut message)?;
    Ok(message.into())
}

/// The contents of a chunk with `size` bytes, of at most `most`, whose compression has this name in its recording.
///
/// # Errors
/// The chunk is damaged or has another size, or its compression is not read.
#[cfg(feature = "ros")]
pub(crate) fn unpacked_chunk<'p>(
    compression: &str,
    packed: &'p [u8],
    size: u64,
    most: u64,
) -> io::Result<Cow<'p, [u8]>> {
    let mut reader: Box<dyn Read> = match compression {
        "" | "none" => Box::new(packed),
        "lz4" => Box::new(lz4_flex::frame::FrameDecoder::new(packed)),
        "bz2" => Box::new(bzip2::read::BzDecoder::new(packed)),
        "zstd" => Box::new(Zstd::new(packed)),
        other => return malformed(&format!("its chunks are compressed by `{other}`")),
    };
    if size > most {
        return malformed("a chunk is too long");
    }
    let bytes = part(&mut reader, size)?;
    // Checksums stand behind the bytes, and are compared where the data end.
    match bytes.len() as u64 == size && reader.read(&mut [0])? == 0 {
        true => Ok(bytes.into()),
        false => malformed("a chunk has another length than its header says"),
    }
}

/// A reader of all frames of zstd, one after another, that compares their checksums.
#[cfg(feature = "ros")]
struct Zstd<R> {
    packed: BufReader<R>,
    frame: FrameDecoder,
}

#[cfg(feature = "ros")]
impl<R: Read> Zstd<R> {
    fn new(packed: R) -> Zstd<R> {
        Zstd { packed: BufReader::new(packed), frame: FrameDecoder::new() }
    }

    /// Goes on to the next frame that holds data, if there is one.
    fn next_frame(&mut self) -> io::Result<bool> {
        while !self.packed.fill_buf()?.is_empty() {
            match self.frame.reset(&mut self.packed) {
                Ok(()) => return Ok(true),
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => {
                    io::copy(&mut self.packed.by_ref().take(length.into()), &mut io::sink())?;
                }
                Err(error) => return Err(io::Error::other(error)),
            }
        }
        Ok(false)
    }
}

#[cfg(feature = "ros")]
impl<R: Read> Read for Zstd<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = self.frame.read(bytes)?;
            if read > 0 || bytes.is_empty() {
                return Ok(read);
            }
            if !self.frame.is_finished() {
                let one = BlockDecodingStrategy::UptoBlocks(1);
                self.frame.decode_blocks(&mut self.packed, one).map_err(io::Error::other)?;
                continue;
            }
            let stated = self.frame.get_checksum_from_data();
            if stated.is_some() && stated != self.frame.get_calculated_checksum() {
                return malformed("a checksum does not match");
            }
            if !self.next_frame()? {
                return Ok(0);
            }
        }
    }
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
            // Two frames of `zstd` with checksums, and one between them that is to be skipped.
            let packed = include_bytes!("../../../../../tests/data/formats/table.csv.zst");
            assert_eq!(channel(packed, "gz").samples, expected);
            for at in [packed.len() - 1, packed.len() / 3] {
                let mut damaged = packed.to_vec();
                damaged[at] ^= 1;
                let said = refusal(&damaged, "gz");
                assert!(said.contains("cannot be unpacked from zstd"), "{said}");
            }
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
