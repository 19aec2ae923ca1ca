//! Figures as text.

/// Where there is no figure.
pub const NONE: &str = "–";

/// To three digits; [`NONE`] for what is not finite.
pub fn figure(value: f64) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    // Rounded first: 0.9996 to three digits has as many decimals as 1.
    let size = format!("{:.2e}", value.abs()).parse::<f64>().unwrap_or(0.0);
    if size == 0.0 {
        "0".to_owned()
    } else if size < 1e-4 {
        format!("{value:.1e}")
    } else {
        let decimals = (2.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:.decimals$}")
    }
}

/// `0.40 to 0.43`.
pub fn between([low, high]: [f64; 2]) -> String {
    format!("{} to {}", figure(low), figure(high))
}

/// The number at an axis: without what rounding left of it.
pub fn tick(value: f64) -> String {
    let value = format!("{value:.3e}").parse::<f64>().unwrap_or(value);
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:e}") } else { value.to_string() }
}

/// Bytes in units of 1024.
pub fn bytes(count: u64) -> String {
    const MIB: f64 = 1024.0 * 1024.0;
    format!("{} MiB", figure(count as f64 / MIB))
}

/// A probability, never rounded up, in per cent; a line does not break in it.
pub fn per_cent(probability: f64) -> String {
    format!("{}\u{a0}%", (probability * 100.0 + 1e-9).floor())
}

/// Cut to so many characters, with an ellipsis where something is left out.
pub fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.41234, "0.412"),
            (12.345, "12.3"),
            (1234.5, "1234"),
            (0.00123, "0.00123"),
            (0.9996, "1.00"),
            (0.000_012_3, "1.2e-5"),
            (-0.5, "-0.500"),
            (f64::NAN, NONE),
            (f64::INFINITY, NONE),
        ] {
            assert_eq!(figure(value), text);
        }
        assert_eq!((tick(3.0 * 0.2), tick(2e-5), tick(0.0)), ("0.6".into(), "2e-5".into(), "0".into()));
    }

    #[test]
    fn confidence_is_never_rounded_up() {
        assert_eq!(
            (per_cent(0.96875), per_cent(0.5), per_cent(0.95)),
            ("96\u{a0}%".into(), "50\u{a0}%".into(), "95\u{a0}%".into())
        );
        assert_eq!((cut("abcdef", 4), cut("abcd", 4)), ("abc…".into(), "abcd".into()));
    }
}
