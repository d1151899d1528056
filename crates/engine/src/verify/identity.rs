//! The matrix of identity: which devices were compared, and with what outcome. docs/identity.md collects its rows.

use std::time::{SystemTime, UNIX_EPOCH};

use sha2::{Digest, Sha256};

use crate::device::Device;
use crate::verify::{Verdict, first_64_bits};
use sagnac_kernel::width::Width;

/// The first two lines of the matrix, as a table in Markdown.
pub const HEADER: &str = "\
| device | driver | backend | variant | system | sagnac | work per kernel | digest | result | date (UTC) |
|---|---|---|---|---|---|---|---|---|---|
";

/// The rows of all widths of this machine and of the GPUs among `devices`, which [`verify`](crate::verify::verify)
/// compared with `units` units of work per kernel, each with a line end.
pub fn rows(devices: &[Device], units: u64, verdicts: &[Verdict]) -> String {
    let system = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
    let version = env!("CARGO_PKG_VERSION");
    let date = date(SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() / 86400));
    let digest = digest(verdicts);
    let row = |name: &str, own: [String; 4]| {
        let own = own.map(|cell| cell.trim().replace('|', "/")).join(" | ");
        let result = result(name, verdicts);
        format!("| {own} | {system} | {version} | {units} | {digest:016x} | {result} | {date} |\n")
    };
    let widths = Width::available().into_iter().map(|width| {
        let none = || "–".to_owned();
        row(width.name(), ["CPU".to_owned(), none(), none(), width.name().to_owned()])
    });
    let gpus = devices.iter().filter_map(|device| match device {
        Device::Gpu(gpu) => Some(row(gpu.name(), gpu.identity())),
        _ => None,
    });
    widths.chain(gpus).collect()
}

/// First 64 bits of a SHA-256 over the digests of all kernels, which is the same on every machine.
fn digest(verdicts: &[Verdict]) -> u64 {
    let mut hasher = Sha256::new();
    verdicts.iter().for_each(|verdict| hasher.update(verdict.digest.to_le_bytes()));
    first_64_bits(hasher)
}

/// Whether the width or device of that name gave the bits of the reference, or in which kernels it did not.
fn result(name: &str, verdicts: &[Verdict]) -> String {
    // A difference is named by the device, and by the configuration where a kernel has several.
    let is_own = |difference: &String| {
        difference.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(" ("))
    };
    let differing = verdicts.iter().filter(|verdict| verdict.differences.iter().any(is_own));
    let kernels: Vec<&str> = differing.map(|verdict| verdict.kernel).collect();
    if kernels.is_empty() { "identical".to_owned() } else { format!("DIFFERENT: {}", kernels.join(", ")) }
}

/// The date of a day, counted from 1970-01-01, in the Gregorian calendar.
fn date(day: u64) -> String {
    let is_leap =
        |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let (mut year, mut month, mut day) = (1970, 0, day);
    loop {
        let february = if is_leap(year) { 29 } else { 28 };
        let length = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31][month];
        if day < length {
            return format!("{year}-{:02}-{:02}", month + 1, day + 1);
        }
        day -= length;
        month = (month + 1) % 12;
        year += u64::from(month == 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(kernel: &'static str, digest: u64, differences: &[&str]) -> Verdict {
        Verdict { kernel, digest, differences: differences.iter().map(|&name| name.to_owned()).collect() }
    }

    #[test]
    fn days_have_the_dates_of_the_calendar() {
        // As `date -u -d @$((day * 86400)) +%F` has them.
        let days = [(0, "1970-01-01"), (58, "1970-02-28"), (789, "1972-02-29"), (11016, "2000-02-29")];
        let later =
            [(11017, "2000-03-01"), (20088, "2024-12-31"), (20089, "2025-01-01"), (47541, "2100-03-01")];
        for (day, expected) in days.into_iter().chain(later) {
            assert_eq!(date(day), expected);
        }
    }

    #[test]
    fn a_row_names_the_kernels_in_which_its_device_differs_and_no_other() {
        let verdicts = [
            verdict("philox", 1, &["Some GPU (Vulkan)"]),
            verdict("normal", 2, &[]),
            verdict(
                "gap_fill",
                3,
                &["avx512 (paper)", "Some GPU (Vulkan) (paper)", "Some GPU (Vulkan) (profile)"],
            ),
        ];
        assert_eq!(result("Some GPU (Vulkan)", &verdicts), "DIFFERENT: philox, gap_fill");
        assert_eq!(result("avx512", &verdicts), "DIFFERENT: gap_fill");
        assert_eq!(result("portable", &verdicts), "identical");
        assert_eq!(result("Some GPU", &verdicts[1..2]), "identical");
    }

    #[test]
    fn a_row_has_the_cells_of_the_header() {
        let verdicts = [verdict("philox", 1, &[])];
        let rows = rows(&[], 64, &verdicts);
        let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
        let header = cells(HEADER.lines().next().unwrap());
        assert_eq!(rows.lines().count(), Width::available().len());
        for (row, width) in rows.lines().map(cells).zip(Width::available()) {
            assert_eq!(row.len(), header.len(), "{row:?}");
            let of = |name: &str| row[header.iter().position(|cell| cell == name).unwrap()].as_str();
            assert_eq!((of("device"), of("variant"), of("result")), ("CPU", width.name(), "identical"));
            // sha256 of the digest 1 in eight bytes, the least first.
            assert_eq!((of("work per kernel"), of("digest")), ("64", "7c9fa136d4413fa6"));
        }
    }

    #[test]
    fn the_digest_depends_on_every_kernel() {
        let both = [verdict("philox", 1, &[]), verdict("normal", 2, &[])];
        let other = [verdict("philox", 1, &[]), verdict("normal", 3, &[])];
        assert_ne!(digest(&both), digest(&other));
        assert_ne!(digest(&both), digest(&both[..1]));
    }
}
