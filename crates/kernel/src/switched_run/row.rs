//! Rows of the table: the same in all lanes, or one for each.

use crate::word::Word;

/// A row of the table.
pub(super) trait Row<W> {
    /// The word at `place` of the row.
    fn word(&self, place: usize) -> W;
}

/// A row that is the same in all lanes.
pub(super) struct Same<'a>(pub(super) &'a [u32]);

impl<W: Word> Row<W> for Same<'_> {
    #[inline(always)]
    fn word(&self, place: usize) -> W {
        W::splat(self.0[place])
    }
}

/// A row for each lane: the rows of all ends, and where each lane's own starts.
pub(super) struct OfEnd<'a, W>(pub(super) &'a [u32], pub(super) W);

impl<W: Word> Row<W> for OfEnd<'_, W> {
    #[inline(always)]
    fn word(&self, place: usize) -> W {
        // SAFETY: `Shape::table_words` counts a row for each of the `ENDS` numbers of `END_BITS` bits, no place lies beyond
        // a row, and `SwitchedRun::new` refuses shorter tables.
        unsafe { W::gather(self.0, self.1 + W::splat(place as u32)) }
    }
}
