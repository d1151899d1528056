//! Tallies as bytes: numbers with seven bits to a byte (LEB128), and histograms as alternating runs of empty and filled
//! bins.

use crate::store::Tally;
use sagnac_kernel::moments::Moments;
use sagnac_kernel::rows::Rows;

impl Tally for Moments {
    fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        put(&mut bytes, u128::from(self.count));
        put(&mut bytes, zigzag(self.sum));
        put(&mut bytes, self.square);
        put(&mut bytes, zigzag(self.least.into()));
        put(&mut bytes, zigzag(self.greatest.into()));
        let mut rest = &self.bins[..];
        while let Some(empty) = rest.iter().position(|&count| count > 0) {
            let filled = rest[empty..].iter().position(|&count| count == 0).unwrap_or(rest.len() - empty);
            put(&mut bytes, empty as u128);
            put(&mut bytes, filled as u128);
            rest[empty..empty + filled].iter().for_each(|&count| put(&mut bytes, u128::from(count)));
            rest = &rest[empty + filled..];
        }
        bytes
    }

    fn append(&mut self, next: Moments) {
        self.merge(&next);
    }

    fn decode(bytes: &[u8], trials: u64) -> Option<Moments> {
        let mut tally = Moments::empty(true);
        add(bytes, trials, &mut tally)?;
        Some(tally)
    }
}

impl Tally for Rows {
    fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        put(&mut bytes, self.width as u128);
        self.values.iter().for_each(|&value| put(&mut bytes, value));
        bytes
    }

    fn append(&mut self, next: Rows) {
        self.values.extend(next.values);
    }

    fn decode(bytes: &[u8], trials: u64) -> Option<Rows> {
        let mut rest = bytes;
        let width = usize::try_from(take(&mut rest)?).ok()?;
        // A number takes at least one byte, so no count of a damaged row requests more memory than there are bytes.
        let mut values =
            Vec::with_capacity(rest.len().min(width.checked_mul(usize::try_from(trials).ok()?)?));
        while !rest.is_empty() {
            values.push(take(&mut rest)?);
        }
        let rows = Rows { width, values };
        (width as u128 * u128::from(trials) == rows.values.len() as u128).then_some(rows)
    }
}

/// Adds the tally of `trials` trials that the bytes encode to `total`, which has a histogram. Returns `None` where the
/// bytes encode none; `total` is then invalid.
pub(crate) fn add(bytes: &[u8], trials: u64, total: &mut Moments) -> Option<()> {
    let mut rest = bytes;
    let part = Moments {
        count: take(&mut rest)?.try_into().ok().filter(|&count: &u64| count == trials)?,
        sum: unzigzag(take(&mut rest)?),
        square: take(&mut rest)?,
        least: unzigzag(take(&mut rest)?).try_into().ok()?,
        greatest: unzigzag(take(&mut rest)?).try_into().ok()?,
        bins: vec![],
    };
    total.merge(&part);
    let (mut bin, mut counted): (usize, u64) = (0, 0);
    while !rest.is_empty() {
        bin = bin.checked_add(usize::try_from(take(&mut rest)?).ok()?)?;
        let filled = usize::try_from(take(&mut rest)?).ok()?;
        for count in total.bins.get_mut(bin..bin.checked_add(filled)?)? {
            let more = take(&mut rest)?.try_into().ok()?;
            counted = counted.checked_add(more)?;
            *count = count.checked_add(more)?;
        }
        bin += filled;
    }
    (counted == trials).then_some(())
}

fn put(bytes: &mut Vec<u8>, mut number: u128) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

fn take(bytes: &mut &[u8]) -> Option<u128> {
    // Most numbers are small.
    if let Some((&byte, rest)) = bytes.split_first()
        && byte < 0x80
    {
        *bytes = rest;
        return Some(byte.into());
    }
    let (mut number, mut shift) = (0_u128, 0);
    loop {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        let part = u128::from(byte & 0x7f);
        if shift >= 128 || part.leading_zeros() < shift {
            return None;
        }
        number |= part << shift;
        if byte < 0x80 {
            return Some(number);
        }
        shift += 7;
    }
}

fn zigzag(number: i128) -> u128 {
    ((number << 1) ^ (number >> 127)) as u128
}

fn unzigzag(number: u128) -> i128 {
    (number >> 1) as i128 ^ -((number & 1) as i128)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sagnac_kernel::moments::BINS;

    #[test]
    fn a_tally_survives_its_bytes() {
        let mut tally = Moments::empty(true);
        tally.bins[3] = 1;
        tally.bins[BINS - 1] = u64::MAX - 1;
        tally.count = u64::MAX;
        for sum in [0, 1, -1, i128::MAX, i128::MIN] {
            (tally.sum, tally.square, tally.least, tally.greatest) = (sum, u128::MAX, i32::MIN, i32::MAX);
            assert_eq!(<Moments as Tally>::decode(&tally.encode(), tally.count).as_ref(), Some(&tally));
        }
    }

    #[test]
    fn rows_survive_their_bytes_and_are_refused_when_cut_or_of_other_trials() {
        let rows = Rows { width: 3, values: vec![0, 1, u128::MAX, 1 << 90, 127, 128] };
        let bytes = Tally::encode(&rows);
        assert_eq!(<Rows as Tally>::decode(&bytes, 2).as_ref(), Some(&rows));
        for length in 0..bytes.len() {
            assert_eq!(<Rows as Tally>::decode(&bytes[..length], 2), None, "cut to {length}");
        }
        assert_eq!(<Rows as Tally>::decode(&[&bytes[..], &[0]].concat(), 2), None);
        assert_eq!(<Rows as Tally>::decode(&bytes, 1), None);
        assert_eq!(<Rows as Tally>::decode(&bytes, u64::MAX), None);
    }

    #[test]
    fn cut_or_lengthened_bytes_are_refused() {
        let mut tally = Moments::empty(true);
        (tally.count, tally.bins[5]) = (300, 300);
        let bytes = tally.encode();
        let decoded = |bytes: &[u8]| <Moments as Tally>::decode(bytes, 300);
        for length in 0..bytes.len() {
            assert_eq!(decoded(&bytes[..length]), None, "cut to {length}");
        }
        assert_eq!(decoded(&[&bytes[..], &[0]].concat()), None);
        assert_eq!(decoded(&[0xff; 40]), None);
        assert_eq!(<Moments as Tally>::decode(&bytes, 299), None);
        assert_eq!(decoded(&bytes), Some(tally));
    }
}
