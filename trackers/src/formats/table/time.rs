//! Units of time and relations of clocks.

use super::{Col, ReadOptions, Row, Table};
use crate::error::{Error, Result};

/// .NET counts 100 ns from the year 1; so many of them are before 1970.
pub(in super::super) const UNIX_FROM_NET_TICKS: i64 = 621_355_968_000_000_000;

/// Samples a second that an eye tracker has: from a slow webcam to twice the fastest research device.
const RATES_HZ: std::ops::Range<f64> = 8.0..4500.0;
/// Rows looked at to guess a unit.
const ROWS_FOR_GUESS: usize = 1000;

/// The ns of a unit by its name.
fn named(unit: &str) -> Option<f64> {
    match unit {
        "s" | "sec" | "second" | "seconds" => Some(1e9),
        "ms" | "msec" | "millisecond" | "milliseconds" => Some(1e6),
        "us" | "µs" | "μs" | "usec" | "microsecond" | "microseconds" | "micro-seconds" => Some(1e3),
        "100ns" => Some(100.0),
        "ns" | "nanosecond" | "nanoseconds" => Some(1.0),
        _ => None,
    }
}

/// The unit that the options ask for, in ns.
fn asked(options: &ReadOptions) -> Result<Option<f64>> {
    let Some(unit_s) = options.time_unit_s else { return Ok(None) };
    if !(unit_s > 0.0 && unit_s.is_finite()) {
        return Err(Error::Setting(format!("a time unit of {unit_s} s is none; it must be above 0")));
    }
    let unit_ns = unit_s * 1e9;
    // 1e-6 s is not quite 1000 ns in doubles, but is meant to be.
    let whole = unit_ns.round();
    Ok(Some(if whole >= 1.0 && (unit_ns - whole).abs() < 1e-6 { whole } else { unit_ns }))
}

/// The ns in one unit of a time column: as the options ask, else as its name says, else as documented.
///
/// # Errors
/// [`Error::Setting`] for a unit that is none.
pub(in super::super) fn unit_ns(
    table: &Table,
    column: Col,
    options: &ReadOptions,
    documented_ns: f64,
) -> Result<f64> {
    Ok(asked(options)?.or_else(|| named(table.unit(column))).unwrap_or(documented_ns))
}

/// As [`unit_ns`], where the format does not fix the unit: it is then the one of s, ms, us and ns in which
/// the median step is that of an eye tracker, and `likely_ns` if there is none.
///
/// # Errors
/// [`Error::Setting`] for a unit that is none.
pub(in super::super) fn guess_unit_ns(
    table: &mut Table,
    column: Col,
    options: &ReadOptions,
    likely_ns: f64,
    counts: impl Fn(&Row) -> bool,
) -> Result<f64> {
    if let Some(unit_ns) = asked(options)?.or_else(|| named(table.unit(column))) {
        return Ok(unit_ns);
    }
    let (mut steps, mut last, mut rows) = (Vec::new(), f64::NAN, 0);
    table.for_rows(|row| {
        if counts(row) {
            let time = row.number(column);
            let step = time - last;
            if step > 0.0 {
                steps.push(step);
            }
            last = time;
        }
        rows += 1;
        rows < ROWS_FOR_GUESS
    });
    steps.sort_by(f64::total_cmp);
    let rate_hz = |unit_ns: f64| steps.get(steps.len() / 2).map_or(f64::NAN, |step| 1e9 / (step * unit_ns));
    let units = [("s", 1e9), ("ms", 1e6), ("us", 1e3), ("ns", 1.0)];
    let fits = units.into_iter().find(|(_, unit_ns)| RATES_HZ.contains(&rate_hz(*unit_ns)));
    let name =
        |unit_ns: f64| units.iter().find(|unit| unit.1 == unit_ns).map_or("the usual unit", |unit| unit.0);
    table.notes.push(match fits {
        Some((unit, unit_ns)) => {
            let rate_hz = rate_hz(unit_ns);
            format!("the unit of time was taken to be {unit}, which makes {rate_hz:.0} samples a second")
        }
        None => format!("no unit of time makes a plausible rate; {} was taken", name(likely_ns)),
    });
    Ok(fits.map_or(likely_ns, |fit| fit.1))
}

/// The host time at which a device clock read 0, from the sample that came with the least delay: so no
/// sample is put later than its arrival, and the steps of the device clock are kept. `None` without a
/// row that has both.
pub(in super::super) fn least_offset_ns(
    table: &Table,
    mut clocks: impl FnMut(&Row) -> Option<(i64, i64)>,
) -> Option<i64> {
    let mut least: Option<i64> = None;
    table.for_rows(|row| {
        if let Some((device_ns, host_ns)) = clocks(row)
            && let Some(start_ns) = host_ns.checked_sub(device_ns)
        {
            least = Some(least.map_or(start_ns, |least| least.min(start_ns)));
        }
        true
    });
    least
}
