//! The one reader of device bytes: nothing else in the decoders takes a report apart.

use super::Reject;

/// A report as it came, read with bounds. Little-endian, as all of HID is.
#[derive(Clone, Copy, Debug)]
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// `width` bits from bit `first` on (0 is the lowest bit of the first byte) as an unsigned number;
    /// `None` outside of the report or for more than 64 bits. No bits are the number 0.
    #[must_use]
    pub fn bits(self, first: usize, width: u32) -> Option<u64> {
        if width > u64::BITS {
            return None;
        }
        let shift = first % 8;
        let covering = (shift + width as usize).div_ceil(8);
        let start = first / 8;
        let bytes = self.0.get(start..start.checked_add(covering)?)?;
        // At most 7 + 64 bits are covered, so 9 of these 16 bytes.
        let mut wide = [0; 16];
        wide.get_mut(..covering)?.copy_from_slice(bytes);
        let mask = if width == u64::BITS { u64::MAX } else { (1 << width) - 1 };
        Some((u128::from_le_bytes(wide) >> shift) as u64 & mask)
    }

    /// As [`Self::bits`], in two's complement.
    #[must_use]
    pub fn signed_bits(self, first: usize, width: u32) -> Option<i64> {
        let value = self.bits(first, width)?;
        let unused = u64::BITS - width;
        Some(if unused == u64::BITS { 0 } else { ((value << unused) as i64) >> unused })
    }

    /// The number of type `N` at byte `at`.
    fn number<const N: usize>(self, at: usize) -> Result<[u8; N], Reject> {
        let end = at.saturating_add(N);
        let bytes = self.0.get(at..end).and_then(|bytes| bytes.try_into().ok());
        bytes.ok_or(Reject::Length { got: self.0.len(), expected: end })
    }

    /// The byte at `at`.
    ///
    /// # Errors
    /// [`Reject::Length`] where the report ends before; so with all of these.
    pub fn u8(self, at: usize) -> Result<u8, Reject> {
        self.number(at).map(u8::from_le_bytes)
    }

    /// The unsigned 16-bit number at byte `at`.
    ///
    /// # Errors
    /// [`Reject::Length`]
    pub fn u16(self, at: usize) -> Result<u16, Reject> {
        self.number(at).map(u16::from_le_bytes)
    }

    /// The signed 16-bit number at byte `at`.
    ///
    /// # Errors
    /// [`Reject::Length`]
    pub fn i16(self, at: usize) -> Result<i16, Reject> {
        self.number(at).map(i16::from_le_bytes)
    }

    /// The unsigned 32-bit number at byte `at`.
    ///
    /// # Errors
    /// [`Reject::Length`]
    pub fn u32(self, at: usize) -> Result<u32, Reject> {
        self.number(at).map(u32::from_le_bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_counted_from_the_lowest_of_the_first_byte() {
        let bytes = Bytes(&[0b1010_0101, 0xff, 0x00, 0x80]);
        assert_eq!(bytes.bits(0, 4), Some(0b0101));
        assert_eq!(bytes.bits(4, 8), Some(0b1111_1010));
        assert_eq!(bytes.bits(31, 1), Some(1));
        assert_eq!(bytes.bits(3, 0), Some(0));
        assert_eq!(bytes.signed_bits(4, 4), Some(-6));
        assert_eq!(bytes.signed_bits(16, 16), Some(-32768));
        assert_eq!(bytes.signed_bits(0, 0), Some(0));
    }

    #[test]
    fn a_full_word_may_lie_across_nine_bytes() {
        let bytes: Vec<u8> = (0x81..=0x89).collect();
        let expected = (0x0089_8887_8685_8483_8281_u128 >> 3) as u64;
        assert_eq!(Bytes(&bytes).bits(3, 64), Some(expected));
        assert_eq!(Bytes(&bytes).signed_bits(8, 64), Some(0x8988_8786_8584_8382_u64 as i64));
    }

    #[test]
    fn nothing_is_read_past_the_end() {
        let bytes = Bytes(&[1, 2]);
        assert_eq!(bytes.bits(9, 8), None);
        assert_eq!(bytes.bits(0, 65), None);
        assert_eq!(bytes.bits(usize::MAX, 64), None);
        assert_eq!(bytes.u16(0), Ok(0x201));
        assert_eq!(bytes.u16(1), Err(Reject::Length { got: 2, expected: 3 }));
        assert!(bytes.u32(usize::MAX).is_err());
    }
}
