//! Numbers as text, without loss.

use std::io::Write;

/// What stands for no value.
pub const NONE: &[u8] = b"n/a";

/// Writes whole nanoseconds as seconds with nine decimals.
pub fn write_seconds(text: &mut Vec<u8>, time_ns: i64) {
    if time_ns < 0 {
        text.push(b'-');
    }
    let size = time_ns.unsigned_abs();
    let (seconds, rest) = (size / 1_000_000_000, size % 1_000_000_000);
    // Writing to a vector cannot fail.
    let _ = write!(text, "{seconds}.{rest:09}");
}

/// Writes the shortest text that reads back to the same bits; NaN is no value.
pub fn write_value(text: &mut Vec<u8>, value: f64) {
    // Above 2^53 integers are no longer exact; negative zero has a sign to keep.
    const WHOLE: f64 = 9_007_199_254_740_992.0;
    if value.is_nan() {
        text.extend_from_slice(NONE);
    } else if value.fract() == 0.0 && value.abs() < WHOLE && !(value == 0.0 && value.is_sign_negative()) {
        let _ = write!(text, "{}", value as i64);
    } else {
        let _ = write!(text, "{value:?}");
    }
}

/// A number at the start of a field, and where it ends. Text that stands for no value is NaN.
pub fn value(bytes: &[u8]) -> Option<(f64, usize)> {
    match fast_float2::parse_partial::<f64, _>(bytes) {
        Ok((value, end)) => Some((value, end)),
        Err(_) => {
            let end =
                bytes.iter().position(|byte| matches!(byte, b'\t' | b'\r' | b'\n')).unwrap_or(bytes.len());
            let word = &bytes[..end];
            let none = word.is_empty()
                || word == NONE
                || word.eq_ignore_ascii_case(b"n/a")
                || word.eq_ignore_ascii_case(b"nan")
                || word.eq_ignore_ascii_case(b"null")
                || word.starts_with(b"-nan");
            none.then_some((f64::NAN, end))
        }
    }
}

/// A time at the start of a field, of which one unit is `10^power` ns, and where it ends; without loss
/// where it is decimal, and rounded to whole ns. `None` where it is no number or beyond `i64`.
pub fn time_ns(bytes: &[u8], power: u32) -> Option<(i64, usize)> {
    let negative = bytes.first() == Some(&b'-');
    let mut at = usize::from(negative || bytes.first() == Some(&b'+'));
    let start = at;
    let mut size = 0u64;
    while let Some(digit) = bytes.get(at).filter(|byte| byte.is_ascii_digit()) {
        size = size.checked_mul(10)?.checked_add(u64::from(digit - b'0'))?;
        at += 1;
    }
    let mut digits = at - start;
    let mut decimals = 0;
    let mut round_up = false;
    if bytes.get(at) == Some(&b'.') {
        at += 1;
        while let Some(digit) = bytes.get(at).filter(|byte| byte.is_ascii_digit()) {
            if decimals < power {
                size = size.checked_mul(10)?.checked_add(u64::from(digit - b'0'))?;
                decimals += 1;
            } else if decimals == power {
                round_up = *digit >= b'5';
                decimals += 1;
            }
            at += 1;
            digits += 1;
        }
    }
    if digits == 0 || matches!(bytes.get(at), Some(b'e' | b'E')) {
        let (value, end) = fast_float2::parse_partial::<f64, _>(bytes).ok()?;
        let ns = value * 10f64.powi(power as i32);
        return (ns.abs() < i64::MAX as f64).then_some((ns.round() as i64, end));
    }
    size = size.checked_mul(10u64.pow(power.saturating_sub(decimals)))?.checked_add(u64::from(round_up))?;
    let time_ns = if negative { 0i64.checked_sub_unsigned(size) } else { i64::try_from(size).ok() }?;
    Some((time_ns, at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn times_read_without_loss() {
        let ns = |text: &str, power| time_ns(text.as_bytes(), power);
        assert_eq!(ns("1234.567890123\tx", 9), Some((1_234_567_890_123, 14)));
        assert_eq!(ns("-0.5", 9), Some((-500_000_000, 4)));
        assert_eq!(ns("7", 9), Some((7_000_000_000, 1)));
        assert_eq!(ns("7.25", 6), Some((7_250_000, 4)));
        assert_eq!(ns("0.0000000015", 9), Some((2, 12)));
        assert_eq!(ns("0.00000000149", 9), Some((1, 13)));
        assert_eq!(ns("1.5e3", 9), Some((1_500_000_000_000, 5)));
        assert_eq!(ns(".5", 9), Some((500_000_000, 2)));
        assert_eq!(ns("-9223372036.854775808", 9), Some((i64::MIN, 21)));
        for bad in
            ["", "n/a", "-", ".", "9223372036.854775808", "99999999999999999999", "1e300", "nan", "inf"]
        {
            assert_eq!(ns(bad, 9), None, "{bad}");
        }
    }

    #[test]
    fn words_for_nothing_are_no_value() {
        for none in ["n/a", "NaN", "nan", "", "N/A", "-nan(ind)"] {
            assert!(
                value(format!("{none}\t1").as_bytes()).is_some_and(|(value, _)| value.is_nan()),
                "{none}"
            );
        }
        assert_eq!(value(b"word"), None);
        assert_eq!(value(b"-1.5\t2"), Some((-1.5, 4)));
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(time: i64, bits: u64) {
            let mut text = Vec::new();
            write_seconds(&mut text, time);
            prop_assert_eq!(time_ns(&text, 9), Some((time, text.len())));
            let number = f64::from_bits(bits);
            text.clear();
            write_value(&mut text, number);
            let (read, end) = value(&text).expect("a value");
            prop_assert_eq!(end, text.len());
            prop_assert!(read.to_bits() == bits || (read.is_nan() && number.is_nan()));
        }

        #[test]
        fn no_text_panics(bytes in prop::collection::vec(any::<u8>(), 0..40), power in 0u32..12) {
            let _ = (value(&bytes), time_ns(&bytes, power));
        }
    }
}
