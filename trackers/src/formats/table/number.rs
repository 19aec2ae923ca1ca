//! Numbers and times as recorders write them.

use super::super::rows::ns_of;

/// What a field says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Field {
    /// A finite number.
    Number(f64),
    /// Nothing: empty, `nan` in any spelling, an infinity, a lone dot.
    Missing,
    /// Something that is no number.
    Text,
}

/// Spellings of "no value" besides those that parse as not finite; lower case, without a sign.
const MISSING: &[&[u8]] = &[
    b"",
    b".",
    b"nan(ind)",
    b"nan(snan)",
    b"1.#ind",
    b"1.#inf",
    b"1.#qnan",
    b"null",
    b"none",
    b"n/a",
    b"na",
];

/// The longest number with a decimal comma; doubles need 24 characters.
const LONGEST: usize = 40;

/// Reads a field; a single comma without a dot is a decimal comma.
pub fn field_of(bytes: &[u8]) -> Field {
    let bytes = bytes.trim_ascii();
    if let Ok(value) = fast_float2::parse::<f64, _>(bytes) {
        return if value.is_finite() { Field::Number(value) } else { Field::Missing };
    }
    let unsigned = bytes.strip_prefix(b"-").or(bytes.strip_prefix(b"+")).unwrap_or(bytes);
    if MISSING.iter().any(|missing| unsigned.eq_ignore_ascii_case(missing)) {
        return Field::Missing;
    }
    with_decimal_comma(bytes).map_or(Field::Text, Field::Number)
}

fn with_decimal_comma(bytes: &[u8]) -> Option<f64> {
    let comma = bytes.iter().position(|byte| *byte == b',')?;
    let mut copy = [0; LONGEST];
    let copy = copy.get_mut(..bytes.len())?;
    copy.copy_from_slice(bytes);
    *copy.get_mut(comma)? = b'.';
    let value: f64 = fast_float2::parse(&*copy).ok()?;
    value.is_finite().then_some(value)
}

/// `true` and `false` of any case as 1 and 0; otherwise as [`field_of`].
pub fn flag_of(bytes: &[u8]) -> Field {
    let bytes = bytes.trim_ascii();
    if bytes.eq_ignore_ascii_case(b"true") {
        Field::Number(1.0)
    } else if bytes.eq_ignore_ascii_case(b"false") {
        Field::Number(0.0)
    } else {
        field_of(bytes)
    }
}

/// The number before the decimal point shifted out of it, and how many digits stand behind it. Up to 24
/// digits, so that times a unit it fits into 128 bits.
fn decimal(bytes: &[u8]) -> Option<(i128, u32)> {
    let (digits, negative) = match bytes.strip_prefix(b"-") {
        Some(rest) => (rest, true),
        None => (bytes.strip_prefix(b"+").unwrap_or(bytes), false),
    };
    if digits.is_empty() || digits.len() > 25 {
        return None;
    }
    let (mut value, mut behind, mut point) = (0i128, 0, false);
    for byte in digits {
        match byte {
            b'0'..=b'9' => {
                value = value * 10 + i128::from(byte - b'0');
                behind += u32::from(point);
            }
            b'.' | b',' if !point => point = true,
            _ => return None,
        }
    }
    (digits.len() > usize::from(point)).then_some((if negative { -value } else { value }, behind))
}

/// A time in ns from a field in units of `unit_ns`; to the ns where the unit is a whole number of them,
/// which a double would not be for clocks that count from 1970. `None` where the field is no time or
/// beyond 64 bits.
pub fn time_ns(bytes: &[u8], unit_ns: f64) -> Option<i64> {
    let bytes = bytes.trim_ascii();
    if unit_ns.fract() == 0.0
        && unit_ns <= 1e12
        && let Some((value, behind)) = decimal(bytes)
    {
        let scale = 10i128.checked_pow(behind)?;
        let scaled = value.checked_mul(unit_ns as i128)?;
        return i64::try_from((scaled + scaled.signum() * (scale / 2)) / scale).ok();
    }
    match field_of(bytes) {
        Field::Number(value) => ns_of(value, unit_ns * 1e-9),
        Field::Missing | Field::Text => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_every_spelling() {
        for (text, value) in [
            ("1.5", 1.5),
            (" -2e3 ", -2000.0),
            ("+7", 7.0),
            ("0,25", 0.25),
            ("-12,5", -12.5),
            ("1,5e2", 150.0),
        ] {
            assert_eq!(field_of(text.as_bytes()), Field::Number(value), "{text}");
        }
        for text in [
            "",
            " ",
            ".",
            "-",
            "nan",
            "NaN",
            "-nan(ind)",
            "-NaN",
            "inf",
            "-Infinity",
            "-1.#IND",
            "null",
            "1e999",
        ] {
            assert_eq!(field_of(text.as_bytes()), Field::Missing, "{text:?}");
        }
        for text in ["left", "1.234,5", "1,2,3", "12px", "0x10", "(1, 2)", "True", "1.2.3"] {
            assert_eq!(field_of(text.as_bytes()), Field::Text, "{text}");
        }
        assert_eq!(field_of(&[b'1'; 5000]), Field::Missing, "beyond any double");
        assert_eq!(field_of([b"0,".as_slice(), &[b'1'; 5000]].concat().as_slice()), Field::Text);
        assert_eq!(flag_of(b"TRUE"), Field::Number(1.0));
        assert_eq!(flag_of(b" false"), Field::Number(0.0));
    }

    #[test]
    fn times_are_exact_to_the_nanosecond() {
        assert_eq!(time_ns(b"1629390345036471431", 1.0), Some(1_629_390_345_036_471_431));
        assert_eq!(time_ns(b"0.01111111", 1e9), Some(11_111_110));
        assert_eq!(time_ns(b"-1512415845", 1e6), Some(-1_512_415_845_000_000));
        assert_eq!(time_ns(b"3,9699", 1e6), Some(3_969_900));
        assert_eq!(time_ns(b"0.0000000005", 1e9), Some(1), "half a nanosecond up");
        assert_eq!(time_ns(b"-0.0000000005", 1e9), Some(-1));
        assert_eq!(time_ns(b"1.5e3", 1e6), Some(1_500_000_000));
        assert_eq!(time_ns(b"4", 1e9 / 3.0), Some(1_333_333_333));
        assert_eq!(time_ns(b"9223372036854775807", 1.0), Some(i64::MAX));
        for text in ["9223372036854775808", "nan", "", ".", "-", "1e300", "99999999999999999999999999", "1;2"]
        {
            assert_eq!(time_ns(text.as_bytes(), 1.0), None, "{text:?}");
        }
    }
}
