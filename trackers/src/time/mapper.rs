//! From a device's clock to the host's, while samples come in.
//!
//! A sample arrives after it was taken, never before, by a delay that jitters upwards from its least
//! value. So the clocks' relation is the lower envelope of arrival against device time. Of each quarter
//! of a second the earliest arrival is kept, and of those the line under all of them that is nearest to
//! them on the whole: it is the edge of their lower convex hull over their mean time (the linear
//! programme of Moon, Skelly and Towsley, "Estimation and removal of clock skew from network delay
//! measurements", INFOCOM 1999).

use super::{SET_BACK_NS, clamp_i64};

/// Least length of a bin, device time. Longer: each bin's earliest arrival is nearer the envelope, and
/// changes of drift are followed more slowly.
const BIN_NS: i64 = 250_000_000;
/// Bins kept: 32 s of a source at 4 Hz or more. More: a steadier drift, and a longer memory of what is
/// no longer so.
const BINS: usize = 128;
/// Bins must span this much before a drift is read from them: over 2 s a jitter of 1 ms makes an error of
/// 5e-4, and the earliest arrivals of a bin jitter far less.
const DRIFT_SPAN_NS: f64 = 2e9;
/// The largest drift believed: twice what the worst oscillators show.
const MAX_DRIFT: f64 = 2e-3;
/// Steps of the device clock are told from jitter by this, the jitter of arrival being a few
/// milliseconds. Larger leaves steps unnoticed, smaller takes slow deliveries for steps.
const STEP_NS: f64 = 20e6;
/// Means of lateness ([`ClockMapper::residual_ns`]) added to [`STEP_NS`] where arrivals jitter more.
const STEP_RESIDUALS: f64 = 3.0;
/// By how much the drift may be wrong, once known: it widens [`STEP_NS`] over a silence.
const DRIFT_ERROR: f64 = 1e-4;
/// Samples that come late for so long, on the host clock, are a device clock that was set back and no
/// delay: a queue of late samples empties in far less.
const LATE_NS: i64 = 1_000_000_000;
/// Up to so much, arrivals at the start that were later than those after them are a slow start.
const SLOW_START_NS: f64 = 1e9;
/// Latest mapped times kept to place samples that come out of order.
const KNOTS: usize = 64;
/// One over the number of samples over which [`ClockMapper::residual_ns`] averages.
const RESIDUAL_RATE: f64 = 1.0 / 64.0;

/// A device time on the host clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mapped {
    /// Host time, ns.
    pub time_ns: i64,
    /// The device clock was set back or ahead, or the host clock back: the relation was begun anew with
    /// this sample, and times mapped from here on are not comparable with those before.
    pub jumped: bool,
}

/// Estimates offset and drift of a device clock against the host's.
///
/// Guaranteed, whatever comes in:
/// - a mapped time is never later than the arrival of its sample;
/// - from one jump ([`Mapped::jumped`]) to the next, a sample whose device time is the latest so far is
///   never mapped before one mapped earlier, and one out of order is mapped between its neighbours
///   among the latest 64, or not after them if it is older; equal device times are mapped equally;
/// - mapped times saturate at the ends of `i64` instead of wrapping, and no value is ever NaN;
/// - nothing is allocated.
///
/// What it cannot know is the least delay itself: mapped times are late by it, as is every clock that
/// is compared by messages in one direction.
#[derive(Clone, Debug)]
pub struct ClockMapper {
    /// Arrival less device time where the relation was begun; `y` below is relative to it.
    base_ns: i128,
    started: bool,
    line: Line,
    drift_known: bool,
    bins: Bins,
    knots: Knots,
    late: Option<Late>,
    first_received_ns: i64,
    residual_ns: f64,
}

/// `y` over device time.
#[derive(Clone, Copy, Debug, Default)]
struct Line {
    at_ns: i64,
    y_ns: f64,
    slope: f64,
}

impl Line {
    fn y(&self, device_ns: i64) -> f64 {
        self.y_ns + self.slope * difference(device_ns, self.at_ns)
    }
}

/// Samples that all come later than the line allows for.
#[derive(Clone, Copy, Debug)]
struct Late {
    since_ns: i64,
    samples: u32,
    /// The least late of them.
    device_ns: i64,
    received_ns: i64,
    excess_ns: f64,
}

impl Default for ClockMapper {
    fn default() -> Self {
        Self {
            base_ns: 0,
            started: false,
            line: Line::default(),
            drift_known: false,
            bins: Bins::default(),
            knots: Knots::default(),
            late: None,
            first_received_ns: 0,
            residual_ns: 0.0,
        }
    }
}

impl ClockMapper {
    /// Takes in a sample's device time and its arrival on the host clock, and maps the device time.
    pub fn observe(&mut self, device_ns: i64, received_ns: i64) -> Mapped {
        if !self.started {
            self.restart(device_ns, received_ns);
            return self.extend(device_ns, received_ns, false);
        }
        let Some(newest) = self.knots.newest() else {
            return self.extend(device_ns, received_ns, false);
        };
        if i128::from(device_ns) < i128::from(newest.device_ns) - i128::from(SET_BACK_NS)
            || received_ns < newest.time_ns
        {
            self.jump(device_ns, received_ns);
            return self.extend(device_ns, received_ns, true);
        }
        if device_ns <= newest.device_ns {
            return Mapped { time_ns: self.knots.place(device_ns).min(received_ns), jumped: false };
        }
        let y_ns = self.y(device_ns, received_ns);
        let excess_ns = y_ns - self.line.y(device_ns);
        let doubt = if self.drift_known { DRIFT_ERROR } else { MAX_DRIFT };
        let tolerance_ns =
            STEP_NS + STEP_RESIDUALS * self.residual_ns + doubt * difference(device_ns, newest.device_ns);
        if excess_ns < -tolerance_ns {
            let starting = received_ns.saturating_sub(self.first_received_ns) < LATE_NS;
            let jumped = !(starting && excess_ns > -SLOW_START_NS);
            if jumped {
                self.jump(device_ns, received_ns);
            } else {
                self.anchor(device_ns, received_ns);
            }
            return self.extend(device_ns, received_ns, jumped);
        }
        if excess_ns > tolerance_ns {
            if let Some(least) = self.stays_late(device_ns, received_ns, excess_ns) {
                self.jump(least.device_ns, least.received_ns);
                return self.extend(device_ns, received_ns, true);
            }
        } else {
            self.late = None;
            self.residual_ns += RESIDUAL_RATE * (excess_ns.max(0.0) - self.residual_ns);
        }
        if self.bins.add(device_ns, y_ns) {
            self.fit();
        }
        self.lower_to(device_ns, y_ns);
        self.extend(device_ns, received_ns, false)
    }

    /// Host time less device time at the latest sample, ns.
    #[must_use]
    pub fn offset_ns(&self) -> i64 {
        let device_ns = self.knots.newest().map_or(0, |knot| knot.device_ns);
        clamp_i64(self.base_ns + self.line.y(device_ns) as i128)
    }

    /// How much faster the host clock runs than the device's, in parts per million.
    #[must_use]
    pub fn drift_ppm(&self) -> f64 {
        self.line.slope * 1e6
    }

    /// How much later than the earliest possible samples arrive: the mean over about the latest 64, ns.
    #[must_use]
    pub fn residual_ns(&self) -> f64 {
        self.residual_ns
    }

    /// Arrival less device time, relative to the base.
    fn y(&self, device_ns: i64, received_ns: i64) -> f64 {
        (i128::from(received_ns) - i128::from(device_ns) - self.base_ns) as f64
    }

    fn restart(&mut self, device_ns: i64, received_ns: i64) {
        self.started = true;
        self.first_received_ns = received_ns;
        self.residual_ns = 0.0;
        self.anchor(device_ns, received_ns);
    }

    /// Begins anew after a step of a clock. The drift is the oscillator's and stays.
    fn jump(&mut self, device_ns: i64, received_ns: i64) {
        self.knots = Knots::default();
        self.restart(device_ns, received_ns);
    }

    /// Lets the line pass through one sample and forgets all others.
    fn anchor(&mut self, device_ns: i64, received_ns: i64) {
        self.base_ns = i128::from(received_ns) - i128::from(device_ns);
        self.line = Line { at_ns: device_ns, y_ns: 0.0, slope: self.line.slope };
        self.bins = Bins::default();
        self.bins.add(device_ns, 0.0);
        self.late = None;
    }

    /// Notes a late sample; the least late one if they have been so for too long.
    fn stays_late(&mut self, device_ns: i64, received_ns: i64, excess_ns: f64) -> Option<Late> {
        let this = Late { since_ns: received_ns, samples: 0, device_ns, received_ns, excess_ns };
        let late = self.late.get_or_insert(this);
        if excess_ns <= late.excess_ns {
            *late = Late { since_ns: late.since_ns, samples: late.samples, ..this };
        }
        late.samples = late.samples.saturating_add(1);
        let long = received_ns.saturating_sub(late.since_ns) >= LATE_NS && late.samples >= 3;
        long.then_some(*late)
    }

    /// A new line under all bins.
    fn fit(&mut self) {
        let Some(newest) = self.bins.newest() else { return };
        if let Some(line) = self.bins.line_below() {
            self.line = line;
            self.drift_known = true;
        } else {
            // Too short a time for a drift: as high as the known one allows.
            self.line = Line { at_ns: newest.device_ns, y_ns: newest.y_ns, ..self.line };
            for bin in self.bins.all() {
                let above_ns = self.line.y(bin.device_ns) - bin.y_ns;
                self.line.y_ns -= above_ns.max(0.0);
            }
        }
    }

    /// Nothing arrives before it was taken: no sample is below the line.
    fn lower_to(&mut self, device_ns: i64, y_ns: f64) {
        let above_ns = self.line.y(device_ns) - y_ns;
        self.line.y_ns -= above_ns.max(0.0);
    }

    /// Maps the latest device time so far.
    fn extend(&mut self, device_ns: i64, received_ns: i64, jumped: bool) -> Mapped {
        let host_ns = i128::from(device_ns) + self.base_ns + self.line.y(device_ns).floor() as i128;
        let least_ns = self.knots.newest().map_or(i64::MIN, |knot| knot.time_ns);
        let time_ns = clamp_i64(host_ns).max(least_ns).min(received_ns);
        self.knots.push(Knot { device_ns, time_ns });
        Mapped { time_ns, jumped }
    }
}

fn difference(later_ns: i64, earlier_ns: i64) -> f64 {
    (i128::from(later_ns) - i128::from(earlier_ns)) as f64
}

#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    device_ns: i64,
    y_ns: f64,
}

/// The earliest arrivals of the latest bins, by device time.
#[derive(Clone, Debug)]
struct Bins {
    bins: [Bin; BINS],
    len: usize,
    newest_start_ns: i64,
}

impl Default for Bins {
    fn default() -> Self {
        Self { bins: [Bin::default(); BINS], len: 0, newest_start_ns: 0 }
    }
}

impl Bins {
    fn all(&self) -> &[Bin] {
        &self.bins[..self.len]
    }

    fn newest(&self) -> Option<Bin> {
        self.all().last().copied()
    }

    /// Adds a sample later than all before; says whether it began a bin, which completes the one before.
    fn add(&mut self, device_ns: i64, y_ns: f64) -> bool {
        let this = Bin { device_ns, y_ns };
        let begins = self.len == 0 || device_ns.saturating_sub(self.newest_start_ns) >= BIN_NS;
        if begins {
            self.newest_start_ns = device_ns;
            if self.len == BINS {
                self.bins.rotate_left(1);
                self.len -= 1;
            }
            self.bins[self.len] = this;
            self.len += 1;
        } else if y_ns < self.bins[self.len - 1].y_ns {
            self.bins[self.len - 1] = this;
        }
        begins
    }

    /// The line under all bins that is nearest to them on the whole; `None` over too short a time.
    fn line_below(&self) -> Option<Line> {
        let bins = self.all();
        let (first, last) = (bins.first()?, bins.last()?);
        if difference(last.device_ns, first.device_ns) < DRIFT_SPAN_NS {
            return None;
        }
        let x = |bin: &Bin| difference(bin.device_ns, first.device_ns);
        let mean_x = bins.iter().map(x).sum::<f64>() / bins.len() as f64;
        let mut hull = [Bin::default(); BINS];
        let mut len = 0;
        for bin in bins {
            while len >= 2 && slope(&hull[len - 2], bin) <= slope(&hull[len - 2], &hull[len - 1]) {
                len -= 1;
            }
            hull[len] = *bin;
            len += 1;
        }
        let edge = hull[..len].windows(2).find(|edge| x(&edge[1]) >= mean_x)?;
        let slope = slope(&edge[0], &edge[1]).clamp(-MAX_DRIFT, MAX_DRIFT);
        let mut line = Line { at_ns: last.device_ns, y_ns: last.y_ns, slope };
        // A slope that was cut to the largest one needs lowering; the edge itself stays where it is.
        for bin in bins {
            line.y_ns -= (line.y(bin.device_ns) - bin.y_ns).max(0.0);
        }
        Some(line)
    }
}

/// Of two bins of different time; 0 rather than NaN where they are not.
fn slope(from: &Bin, to: &Bin) -> f64 {
    let run_ns = difference(to.device_ns, from.device_ns);
    if run_ns > 0.0 { (to.y_ns - from.y_ns) / run_ns } else { 0.0 }
}

#[derive(Clone, Copy, Debug, Default)]
struct Knot {
    device_ns: i64,
    time_ns: i64,
}

/// The latest mapped times, ascending in both clocks.
#[derive(Clone, Debug)]
struct Knots {
    ring: [Knot; KNOTS],
    len: usize,
    next: usize,
}

impl Default for Knots {
    fn default() -> Self {
        Self { ring: [Knot::default(); KNOTS], len: 0, next: 0 }
    }
}

impl Knots {
    fn newest(&self) -> Option<Knot> {
        (self.len > 0).then(|| self.back(0))
    }

    /// The one `back` before the newest; `back` below `len`.
    fn back(&self, back: usize) -> Knot {
        self.ring[(self.next + 2 * KNOTS - 1 - back) % KNOTS]
    }

    fn push(&mut self, knot: Knot) {
        self.ring[self.next] = knot;
        self.next = (self.next + 1) % KNOTS;
        self.len = (self.len + 1).min(KNOTS);
    }

    /// A device time not later than the newest: between its neighbours, or at the oldest.
    fn place(&self, device_ns: i64) -> i64 {
        let mut after = self.back(0);
        for knot in (0..self.len).map(|back| self.back(back)) {
            if knot.device_ns <= device_ns {
                let run = i128::from(after.device_ns) - i128::from(knot.device_ns);
                let rise = i128::from(after.time_ns) - i128::from(knot.time_ns);
                let step = i128::from(device_ns) - i128::from(knot.device_ns);
                let part = if run > 0 { multiplied(rise, step, run) } else { 0 };
                return clamp_i64(i128::from(knot.time_ns) + part);
            }
            after = knot;
        }
        // Older than all: not after the oldest.
        let before = i128::from(after.device_ns) - i128::from(device_ns);
        clamp_i64(i128::from(after.time_ns) - before)
    }
}

/// `rise * step / run` for `0 <= step <= run` and `rise >= 0`, each below 2^64: the product fits 128 bits
/// without a sign, and the result is no more than `rise`.
fn multiplied(rise: i128, step: i128, run: i128) -> i128 {
    (rise.unsigned_abs() * step.unsigned_abs() / run.unsigned_abs()) as i128
}

#[cfg(test)]
mod tests;
