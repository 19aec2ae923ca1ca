//! A session through a model, frame by frame.

use super::figures::{Figures, Sums};
use super::model::LatencyModel;
use super::session::{SessionGaze, angle_deg};
use super::stage::{MOST_STAGE_MS, Stage};
use super::suppression::{EyeWalk, Suppression};
use super::timeline::{Arrival, Clockwork, Picture, arrivals, check_length, stretches, tracker_ns};
use crate::error::{Error, Result};
use crate::estimate::EyeState;
use glam::DVec3;

/// Where the times come from at which the host gets the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArrivalTimes {
    /// From the model's stages up to the wake-up.
    #[default]
    Model,
    /// From the recording's own `received_ns`. The stages up to the wake-up are then one figure, told as
    /// `tracker_processing`.
    Recorded,
}

/// What a run is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSettings {
    /// Radius around the gaze within which the picture has its full quality, degrees. The default is 5:
    /// about the fovea with the ring around it in which acuity halves.
    pub radius_deg: f64,
    /// The share of the time in which the true gaze may lie outside, 0 to 1. The default is 0.02, in the
    /// middle of the 1 to 5 % that such budgets use. A smaller one asks for a larger radius.
    pub target_outside: f64,
    /// When the eye does not see well around a saccade.
    pub suppression: Suppression,
    /// Where arrival times come from.
    pub arrival: ArrivalTimes,
    /// The largest latency that the budget looks at, ms.
    pub sweep_to_ms: f64,
    /// How many latencies the budget looks at, 2 to 1000. More give a finer curve and take longer.
    pub sweep_points: usize,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self {
            radius_deg: 5.0,
            target_outside: 0.02,
            suppression: Suppression::default(),
            arrival: ArrivalTimes::Model,
            sweep_to_ms: 160.0,
            sweep_points: 33,
        }
    }
}

impl RunSettings {
    fn check(&self) -> Result<()> {
        let within = |name: &str, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::Setting(format!("{name} is {value}; it must be {low} to {high}")))
        };
        within("radius_deg", self.radius_deg, 0.0, 180.0)?;
        within("target_outside", self.target_outside, 0.0, 1.0)?;
        within("before_onset_ms", self.suppression.before_onset_ms, 0.0, MOST_STAGE_MS)?;
        within("after_end_ms", self.suppression.after_end_ms, 0.0, MOST_STAGE_MS)?;
        within("sweep_to_ms", self.sweep_to_ms, 1.0, 10.0 * MOST_STAGE_MS)?;
        within("sweep_points", self.sweep_points as f64, 2.0, 1000.0)
    }
}

/// A sample that has just arrived on the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrived {
    /// Its index in the recording, for what is not told here.
    pub index: usize,
    /// When the eye was like this, ns.
    pub time_ns: i64,
    /// When the host got it, ns.
    pub received_ns: i64,
    /// The gaze, of length 1; `None` where the sample has none.
    pub direction: Option<DVec3>,
}

/// What the renderer asks for one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// Now, ns: what arrived later is not known.
    pub latch_ns: i64,
    /// When the picture is expected to be displayed (the middle of its light), ns.
    pub display_ns: i64,
}

/// Answers where the renderer shall take the gaze to be: a filter, a predictor, an estimator.
pub trait GazeAnswer {
    /// Forgets everything: another run over the session begins.
    fn begin(&mut self);

    /// Takes a sample. Samples come in the order of arrival, all before the question that may use them.
    fn sample(&mut self, arrived: &Arrived);

    /// The direction to render for, of any length; `None` for none.
    fn direction_at(&mut self, question: &Question) -> Option<DVec3>;
}

/// One refresh of the display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Refreshes since the first one of the session.
    pub refresh: u64,
    /// The picture shown, counted from 0. The same one again where the next was late.
    pub picture: u64,
    /// When that picture's gaze was taken, ns.
    pub latch_ns: i64,
    /// When the renderer expected the picture's light, ns; before `display_ns` where it was late.
    pub expected_ns: i64,
    /// The middle of the refresh's light, ns.
    pub display_ns: i64,
    /// The newest sample with a gaze that the renderer had: index in the recording.
    pub sample: Option<usize>,
    /// From that sample (less the filter's delay) to the light, ns.
    pub age_ns: Option<i64>,
    /// The newest sample had no gaze, so an older one was used.
    pub over_loss: bool,
    /// What the renderer took the gaze to be, of length 1.
    pub direction: Option<DVec3>,
    /// Where the eye looked at `display_ns`; `None` where that is not known.
    pub truth: Option<DVec3>,
    /// The angle between both, degrees.
    pub error_deg: Option<f64>,
    /// What the eye did at `display_ns`.
    pub state: EyeState,
    /// The eye does not see well because of a saccade.
    pub suppressed: bool,
    /// The frame counts for the outside share: a fixation or pursuit, not suppressed, error known.
    pub counted: bool,
    /// The true gaze lay outside the radius of full quality.
    pub outside: bool,
}

/// What came out of a run.
#[derive(Clone, Debug)]
pub struct LatencyRun {
    /// The model used.
    pub model: LatencyModel,
    /// What was asked.
    pub settings: RunSettings,
    /// Every refresh, in order of time.
    pub frames: Vec<Frame>,
    /// Mean share of each stage in the age, ms, in the order of [`Stage::ALL`]; they add up to the mean
    /// age of the frames that are not over a loss: holding over a blink is no one's latency.
    pub stage_ms: [f64; Stage::ALL.len()],
    /// From an eye movement to its first light, ms: the mean over movements at any time. The age and half
    /// of the step to the next sample shown. `None` where no two samples were shown.
    pub eye_to_photon_ms: Option<f64>,
    /// How much younger the gaze is if taken when the GPU begins instead of when the CPU does, ms (mean).
    pub late_latch_gain_ms: f64,
    /// Samples per second that the tracker made of the session.
    pub tracker_rate_hz: f64,
    pub(super) arrivals: Vec<Arrival>,
    pub(super) seed: u64,
}

/// Runs a session through a model; the renderer holds the newest gaze that it has.
///
/// # Errors
/// [`Error::Setting`] for settings out of range, a session that is too long, and recorded arrival times
/// that do not exist.
pub fn run(
    session: &SessionGaze,
    model: &LatencyModel,
    settings: &RunSettings,
    seed: u64,
) -> Result<LatencyRun> {
    run_inner(session, model, settings, seed, None)
}

/// As [`run`], with the direction from `answer`. The model's filter delay is left out: a filter is part
/// of the answer.
///
/// # Errors
/// As [`run`].
pub fn run_with(
    session: &SessionGaze,
    model: &LatencyModel,
    settings: &RunSettings,
    seed: u64,
    answer: &mut dyn GazeAnswer,
) -> Result<LatencyRun> {
    answer.begin();
    run_inner(session, model, settings, seed, Some(answer))
}

fn run_inner(
    session: &SessionGaze,
    model: &LatencyModel,
    settings: &RunSettings,
    seed: u64,
    answer: Option<&mut dyn GazeAnswer>,
) -> Result<LatencyRun> {
    model.check()?;
    settings.check()?;
    let stretches = stretches(session);
    check_length(&stretches, model.frame_ns())?;
    let arrivals = arrivals(session, model, settings, seed)?;
    let mut runner = Runner {
        session,
        model,
        settings,
        seed,
        arrivals: &arrivals,
        asker: Asker { answer, newest: Follower::default() },
        early: Follower::default(),
        late: Follower::default(),
        eye: EyeWalk::new(session, &settings.suppression),
        sums: Sums::default(),
        frames: Vec::new(),
    };
    let mut clock = Clockwork::new(session, model, seed);
    for (start_ns, end_ns) in stretches {
        runner.stretch(&mut clock, start_ns, end_ns);
    }
    let Runner { sums, frames, .. } = runner;
    let span_s = session
        .times_ns()
        .first()
        .zip(session.times_ns().last())
        .map_or(0.0, |(first, last)| (i128::from(*last) - i128::from(*first)) as f64 * 1e-9);
    let thinned = arrivals.len() < session.len() && span_s > 0.0;
    Ok(LatencyRun {
        model: model.clone(),
        settings: settings.clone(),
        frames,
        stage_ms: sums.stage_ms(),
        eye_to_photon_ms: sums.eye_to_photon_ms(),
        late_latch_gain_ms: sums.late_latch_gain_ms(),
        tracker_rate_hz: if thinned { arrivals.len() as f64 / span_s } else { session.rate_hz() },
        arrivals,
        seed,
    })
}

/// Goes along the arrivals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Follower {
    next: usize,
    /// The newest with a gaze.
    pub usable: Option<Arrival>,
    /// The newest of all had none.
    pub over_loss: bool,
}

impl Follower {
    /// Takes all arrivals for which `known` holds.
    pub(super) fn advance(
        &mut self,
        arrivals: &[Arrival],
        known: impl Fn(&Arrival) -> bool,
        mut tell: impl FnMut(&Arrival),
    ) {
        while let Some(arrival) = arrivals.get(self.next).filter(|arrival| known(arrival)) {
            tell(arrival);
            self.over_loss = !arrival.usable;
            if arrival.usable {
                self.usable = Some(*arrival);
            }
            self.next += 1;
        }
    }
}

/// What an answer is told of an arrival.
pub(super) fn told(session: &SessionGaze, arrival: &Arrival, received_ns: i64) -> Arrived {
    let row = arrival.row as usize;
    Arrived {
        index: session.recorded(row),
        time_ns: arrival.time_ns,
        // A sweep may take more latency away than there is.
        received_ns: received_ns.max(arrival.time_ns),
        direction: session.direction(row),
    }
}

/// The direction that a renderer has which holds a sample, behind a filter of some delay.
pub(super) fn held(session: &SessionGaze, row: usize, filter_ns: i64) -> Option<DVec3> {
    if filter_ns == 0 {
        return session.direction(row);
    }
    let time_ns = session.times_ns().get(row)?.saturating_sub(filter_ns);
    session.measured_at(time_ns).or_else(|| session.direction(row))
}

/// The filter's delay for one picture, ns.
pub(super) fn filter_ns(model: &LatencyModel, seed: u64, picture: u64) -> i64 {
    model.stage(Stage::FilterDelay).delay.draw_ns(seed, Stage::FilterDelay, picture)
}

struct Asker<'a> {
    answer: Option<&'a mut dyn GazeAnswer>,
    newest: Follower,
}

/// A picture with the gaze that it was made for.
#[derive(Clone, Copy)]
struct Made {
    picture: Picture,
    sample: Option<Arrival>,
    over_loss: bool,
    direction: Option<DVec3>,
    filter_ns: i64,
}

struct Runner<'a, 'b> {
    session: &'a SessionGaze,
    model: &'a LatencyModel,
    settings: &'a RunSettings,
    seed: u64,
    arrivals: &'a [Arrival],
    asker: Asker<'b>,
    early: Follower,
    late: Follower,
    eye: EyeWalk<'a>,
    sums: Sums,
    frames: Vec<Frame>,
}

impl Runner<'_, '_> {
    fn stretch(&mut self, clock: &mut Clockwork<'_>, start_ns: i64, end_ns: i64) {
        clock.skip_to(start_ns);
        let mut next = clock.next_picture();
        let mut refresh = next.refresh;
        let mut current: Option<Made> = None;
        loop {
            let (display_ns, panel_ns) = clock.display_ns(refresh);
            if display_ns > end_ns {
                return;
            }
            while next.refresh <= refresh {
                current = Some(self.make(next));
                next = clock.next_picture();
            }
            if let Some(made) = &current {
                let frame = self.frame(made, refresh, display_ns);
                self.add(made, &frame, panel_ns);
                self.frames.push(frame);
            }
            refresh += 1;
        }
    }

    fn make(&mut self, picture: Picture) -> Made {
        let by = |latch_ns: i64| move |arrival: &Arrival| arrival.available_ns <= latch_ns;
        let Asker { answer, newest } = &mut self.asker;
        let session = self.session;
        newest.advance(self.arrivals, by(picture.latch_ns), |arrival| {
            if let Some(answer) = answer.as_deref_mut() {
                answer.sample(&told(session, arrival, arrival.available_ns));
            }
        });
        let sample = newest.usable;
        let (direction, filter_ns) = match answer.as_deref_mut() {
            Some(answer) => {
                let question = Question { latch_ns: picture.latch_ns, display_ns: picture.expected_ns };
                (answer.direction_at(&question).and_then(unit), 0)
            }
            None => {
                let filter_ns = filter_ns(self.model, self.seed, picture.number);
                (sample.and_then(|arrival| held(session, arrival.row as usize, filter_ns)), filter_ns)
            }
        };
        self.early.advance(self.arrivals, by(picture.early_latch_ns), |_| ());
        self.late.advance(self.arrivals, by(picture.late_latch_ns), |_| ());
        if let (Some(early), Some(late)) = (self.early.usable, self.late.usable) {
            self.sums.add_late_latch(late.time_ns.saturating_sub(early.time_ns));
        }
        Made { picture, sample, over_loss: self.asker.newest.over_loss, direction, filter_ns }
    }

    fn frame(&mut self, made: &Made, refresh: u64, display_ns: i64) -> Frame {
        let eye = self.eye.at(display_ns);
        let truth = self.session.true_from(eye.row_after, display_ns);
        let error_deg = truth.zip(made.direction).map(|(truth, direction)| angle_deg(truth, direction));
        let counted = eye.counts && error_deg.is_some();
        let sample_ns = made.sample.map(|arrival| arrival.time_ns);
        Frame {
            refresh,
            picture: made.picture.number,
            latch_ns: made.picture.latch_ns,
            expected_ns: made.picture.expected_ns,
            display_ns,
            sample: made.sample.map(|arrival| self.session.recorded(arrival.row as usize)),
            age_ns: sample_ns.map(|time| display_ns.saturating_sub(time).saturating_add(made.filter_ns)),
            over_loss: made.over_loss,
            direction: made.direction,
            truth,
            error_deg,
            state: eye.state,
            suppressed: eye.suppressed,
            counted,
            outside: error_deg.is_some_and(|error| error > self.settings.radius_deg),
        }
    }

    /// Adds the frame's age, stage by stage.
    fn add(&mut self, made: &Made, frame: &Frame, [scanout_ns, panel_ns]: [i64; 2]) {
        let Some(arrival) = made.sample.filter(|_| !made.over_loss) else {
            self.sums.interrupt();
            return;
        };
        let time_ns = arrival.time_ns;
        let Picture { latch_ns, gpu_start_ns, cpu_ns, gpu_ns, compositor_ns, .. } = made.picture;
        let mut parts = [0_i64; Stage::ALL.len()];
        let mut put = |stage: Stage, ns: i64| parts[stage as usize] = ns;
        let arriving_ns = arrival.available_ns.saturating_sub(time_ns);
        match self.settings.arrival {
            ArrivalTimes::Recorded => put(Stage::TrackerProcessing, arriving_ns),
            ArrivalTimes::Model => {
                let [exposure, readout, processing, polling, wakeup] =
                    tracker_ns(self.model, self.seed, arrival.row);
                put(Stage::Exposure, exposure);
                put(Stage::Readout, readout);
                put(Stage::TrackerProcessing, processing);
                put(Stage::Polling, polling);
                let queued = arriving_ns - (exposure + readout + processing + polling + wakeup);
                put(Stage::Wakeup, wakeup + queued);
            }
        }
        let until_gpu_ns = gpu_start_ns - latch_ns;
        let cpu_part_ns = if self.model.late_latch { 0 } else { cpu_ns };
        let lit_ns = frame.display_ns - scanout_ns - panel_ns;
        put(Stage::FilterDelay, made.filter_ns);
        put(Stage::SamplingWait, latch_ns.saturating_sub(arrival.available_ns));
        put(Stage::Cpu, cpu_part_ns);
        put(Stage::Gpu, gpu_ns);
        put(Stage::Compositor, compositor_ns);
        put(Stage::Pacing, until_gpu_ns - cpu_part_ns + lit_ns - (gpu_start_ns + gpu_ns + compositor_ns));
        put(Stage::Scanout, scanout_ns);
        put(Stage::Panel, panel_ns);
        self.sums.add(&parts, time_ns, frame.age_ns.unwrap_or(0));
    }
}

pub(super) fn unit(direction: DVec3) -> Option<DVec3> {
    direction.try_normalize().filter(|direction| direction.is_finite())
}

impl LatencyRun {
    /// Ages of all frames that have one, ms.
    #[must_use]
    pub fn age_ms(&self) -> Figures {
        Figures::of(self.frames.iter().filter_map(|frame| frame.age_ns).map(|ns| ns as f64 * 1e-6))
    }

    /// Errors of all frames in which both directions are known, degrees.
    #[must_use]
    pub fn error_deg(&self) -> Figures {
        Figures::of(self.frames.iter().filter_map(|frame| frame.error_deg))
    }

    /// Errors of the frames that count for [`Self::outside_fraction`], degrees.
    #[must_use]
    pub fn counted_error_deg(&self) -> Figures {
        Figures::of(self.counted().filter_map(|frame| frame.error_deg))
    }

    fn counted(&self) -> impl Iterator<Item = &Frame> {
        self.frames.iter().filter(|frame| frame.counted)
    }

    /// The share of the fixation and pursuit time, without what is suppressed, in which the true gaze lay
    /// outside the radius of full quality; `None` where there is no such time.
    #[must_use]
    pub fn outside_fraction(&self) -> Option<f64> {
        share(self.counted())
    }

    /// As [`Self::outside_fraction`], with what is suppressed.
    #[must_use]
    pub fn outside_fraction_unsuppressed(&self) -> Option<f64> {
        let all = self.frames.iter().all(|frame| frame.state == EyeState::Unknown);
        let rests = move |frame: &&Frame| all || super::suppression::rests(frame.state);
        share(self.frames.iter().filter(rests))
    }

    /// The share of all frames with a known error, whatever the eye did.
    #[must_use]
    pub fn outside_fraction_raw(&self) -> Option<f64> {
        share(self.frames.iter())
    }
}

fn share<'a>(frames: impl Iterator<Item = &'a Frame>) -> Option<f64> {
    let (mut count, mut outside) = (0_u64, 0_u64);
    for frame in frames.filter(|frame| frame.error_deg.is_some()) {
        count += 1;
        outside += u64::from(frame.outside);
    }
    (count > 0).then(|| outside as f64 / count as f64)
}
