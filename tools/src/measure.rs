//! Comparing two variants' GPU times in one run.
//!
//! Variants are measured alternately, because clocks and other load drift over minutes: the ratio
//! within a pair is far steadier than the ratio of two separate series.

use crate::failure::Failure;
use macula::stats::FrameStats;
use serde::Serialize;
use std::time::{Duration, Instant};

/// The median; the mean of the middle two for an even number. `None` of nothing.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        count if count % 2 == 1 => Some(sorted[middle]),
        _ => Some((sorted[middle - 1] + sorted[middle]) / 2.0),
    }
}

/// Frames of two variants; the i-th of one was measured beside the i-th of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairs<T> {
    /// Of the first variant.
    pub first: Vec<T>,
    /// Of the second variant.
    pub second: Vec<T>,
}

/// How many pairs are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairCount {
    /// So many.
    Fixed(u32),
    /// An odd number, so that the median is one of them: as many as fit a time, within bounds.
    Within {
        /// The time.
        budget: Duration,
        /// At least so many, from 1.
        least: u32,
        /// At most so many.
        most: u32,
    },
}

impl PairCount {
    /// How many there are in all, after the first took `first`.
    fn after(self, first: Duration) -> u32 {
        match self {
            Self::Fixed(count) => count,
            Self::Within { budget, least, most } => {
                let fit = budget.as_secs_f64() / first.as_secs_f64().max(1e-6);
                ((fit as u32).clamp(least, most) - 1) | 1
            }
        }
    }
}

/// Measures pairs; in every other pair the second variant goes first, so that neither always
/// profits from what the other left in the caches.
///
/// # Errors
/// The first one of `measure`, whose argument is `true` for the second variant.
pub fn measure_pairs<T, E>(
    count: PairCount,
    mut measure: impl FnMut(bool) -> Result<T, E>,
    progress: impl FnMut(f64),
) -> Result<Pairs<T>, E> {
    let mut frames = measure_rounds(count, 2, |variant| measure(variant == 1), progress)?;
    let second = frames.pop().unwrap_or_default();
    let first = frames.pop().unwrap_or_default();
    Ok(Pairs { first, second })
}

/// Measures several variants in turn, each round in the reverse order of the one before: the frames of each
/// variant, of which the i-th ones were measured in one round.
///
/// # Errors
/// The first one of `measure`, whose argument is the variant.
pub fn measure_rounds<T, E>(
    count: PairCount,
    variants: usize,
    mut measure: impl FnMut(usize) -> Result<T, E>,
    mut progress: impl FnMut(f64),
) -> Result<Vec<Vec<T>>, E> {
    let mut frames: Vec<_> = (0..variants).map(|_| Vec::new()).collect();
    let begun = Instant::now();
    let mut wanted = 1;
    let mut done = 0;
    while done < wanted {
        for place in 0..variants {
            let variant = if done % 2 == 0 { place } else { variants - 1 - place };
            frames[variant].push(measure(variant)?);
        }
        if done == 0 {
            wanted = count.after(begun.elapsed());
        }
        done += 1;
        progress(f64::from(done) / f64::from(wanted));
    }
    Ok(frames)
}

/// How many times faster the second variant is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speedup {
    /// Median of the pairs' ratios.
    pub median: f64,
    /// The least ratio of any pair.
    pub least: f64,
    /// The greatest ratio of any pair.
    pub greatest: f64,
}

/// Ratios of paired times, first over second; `None` where there is no pair with times above 0.
pub fn speedup(first_ms: &[f64], second_ms: &[f64]) -> Option<Speedup> {
    let ratios = first_ms
        .iter()
        .zip(second_ms)
        .filter(|&(&first, &second)| first > 0.0 && second > 0.0)
        .map(|(first, second)| first / second)
        .collect::<Vec<_>>();
    let median = median(&ratios)?;
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = ratios.iter().copied().fold(0.0, f64::max);
    Some(Speedup { median, least, greatest })
}

/// One pass's time over several frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassMedian {
    /// The pass.
    pub name: &'static str,
    /// Median over the frames, milliseconds.
    pub gpu_ms: f64,
}

/// Each pass's median over the frames, in the last frame's order; without the passes that only look.
pub fn pass_medians(frames: &[FrameStats]) -> Vec<PassMedian> {
    let Some(last) = frames.last() else { return Vec::new() };
    let times_of = |name: &str| {
        let passes = frames.iter().flat_map(|frame| &frame.passes);
        passes.filter(|pass| pass.name == name).map(|pass| pass.gpu_ms).collect::<Vec<_>>()
    };
    let own = last.passes.iter().filter(|pass| !pass.diagnostic);
    own.map(|pass| PassMedian {
        name: pass.name,
        gpu_ms: median(&times_of(pass.name)).unwrap_or(pass.gpu_ms),
    })
    .collect()
}

/// The frames' whole GPU times.
pub fn gpu_times(frames: &[FrameStats]) -> Vec<f64> {
    frames.iter().map(|frame| frame.gpu_ms).collect()
}

/// The time of a pass that must be there.
///
/// # Errors
/// Where the frame has no pass of this name: a renamed pass must not count as one that costs nothing.
pub fn time_of(passes: &[PassMedian], name: &str) -> Result<f64, Failure> {
    let found = passes.iter().find(|pass| pass.name == name);
    found.map(|pass| pass.gpu_ms).ok_or_else(|| {
        let names = passes.iter().map(|pass| pass.name).collect::<Vec<_>>().join(", ");
        Failure::environment(format!("the frame has no pass `{name}`, only {names}; please report this"))
    })
}

/// What checking has found that must not be there, in words.
pub fn findings(non_finite: Option<u64>, holes: Option<u64>, messages: Option<u64>) -> Vec<String> {
    let more_than_none = |count: Option<u64>| count.filter(|count| *count > 0);
    let told = [
        more_than_none(non_finite)
            .map(|count| format!("{count} values in the frame's buffers are NaN or infinite")),
        more_than_none(holes).map(|count| format!("{count} pixels were reached by no sample")),
        more_than_none(messages)
            .map(|count| format!("the validation layer sent {count} messages; please report them")),
    ];
    told.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use macula::stats::PassTime;

    #[test]
    fn median_of_odd_even_and_none() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&[]), None);
    }

    #[test]
    fn pairs_alternate_and_every_other_one_is_swapped() {
        let mut order = String::new();
        let mut shares = Vec::new();
        let measure = |second| {
            order.push(if second { 'B' } else { 'A' });
            Ok::<_, ()>(second)
        };
        let pairs = measure_pairs(PairCount::Fixed(3), measure, |share| shares.push(share));
        assert_eq!((shares.len(), shares.last()), (3, Some(&1.0)));
        assert_eq!(order, "ABBAAB");
        assert_eq!(pairs, Ok(Pairs { first: vec![false; 3], second: vec![true; 3] }));
    }

    #[test]
    fn slow_pairs_are_few_but_not_too_few() {
        let count = PairCount::Within { budget: Duration::from_secs(60), least: 3, most: 9 };
        let of_millis = |millis| count.after(Duration::from_millis(millis));
        assert_eq!([0, 100, 10_000, 30_000].map(of_millis), [9, 9, 5, 3]);
    }

    #[test]
    fn passes_are_looked_up_by_name() {
        let passes = [PassMedian { name: "inverse", gpu_ms: 2.0 }];
        assert!(matches!(time_of(&passes, "inverse"), Ok(2.0)));
        let Err(failure) = time_of(&passes, "inverze") else { panic!("a missing pass has a time") };
        assert!(failure.line().is_some_and(|line| line.contains("`inverze`")), "{failure:?}");
    }

    #[test]
    fn a_failing_measurement_ends_the_series() {
        let mut calls = 0;
        let measure = |_| {
            calls += 1;
            if calls == 3 { Err("lost") } else { Ok(()) }
        };
        let result = measure_pairs(PairCount::Fixed(5), measure, |_| ());
        assert_eq!((result, calls), (Err("lost"), 3));
    }

    #[test]
    fn speedup_is_the_median_of_ratios_not_the_ratio_of_medians() {
        // Ratios 2, 10, 3; the medians' ratio would be 4 / 2 = 2.
        let of = speedup(&[2.0, 20.0, 4.5], &[1.0, 2.0, 1.5]);
        assert_eq!(of, Some(Speedup { median: 3.0, least: 2.0, greatest: 10.0 }));
        assert_eq!(speedup(&[1.0], &[0.0]), None);
        assert_eq!(speedup(&[], &[]), None);
    }

    #[test]
    fn pass_medians_leave_out_diagnostic_passes() {
        let frame = |shade: f64| FrameStats {
            passes: vec![
                PassTime { name: "shade", gpu_ms: shade, diagnostic: false },
                PassTime { name: "check", gpu_ms: 9.0, diagnostic: true },
            ],
            gpu_ms: shade,
            ..FrameStats::default()
        };
        let medians = pass_medians(&[frame(1.0), frame(5.0), frame(2.0)]);
        assert_eq!(medians, [PassMedian { name: "shade", gpu_ms: 2.0 }]);
    }
}
