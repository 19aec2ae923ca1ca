//! The estimator as a renderer of a run would have it.

use super::run::{Arrived, GazeAnswer, Question};
use crate::estimator::{Estimator, EstimatorSettings};
use crate::recording::Recording;
use crate::sample::{EyeSample, GazeSample};
use glam::DVec3;

/// An [`Estimator`] that gets the samples of a recording as they arrive, and is asked for the display
/// time of every picture.
#[derive(Debug)]
pub struct EstimatorAnswer<'a> {
    recording: &'a Recording,
    estimator: Estimator,
    settings: EstimatorSettings,
}

impl<'a> EstimatorAnswer<'a> {
    /// An estimator with nothing seen yet. The recording must be the one of the session of the run: what
    /// the session does not hold of a sample (eyes, confidence, openness, head) is taken from it.
    #[must_use]
    pub fn new(settings: EstimatorSettings, recording: &'a Recording) -> Self {
        Self { recording, estimator: Estimator::new(settings), settings }
    }

    /// The estimator, for what else it knows: how sure it is, and what the eye does.
    #[must_use]
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }
}

impl GazeAnswer for EstimatorAnswer<'_> {
    fn begin(&mut self) {
        self.estimator = Estimator::new(self.settings);
    }

    fn sample(&mut self, arrived: &Arrived) {
        let told = self.recording.get(arrived.index).unwrap_or_default();
        let mut sample = GazeSample { time_ns: arrived.time_ns, received_ns: arrived.received_ns, ..told };
        // The session makes directions of points where the display is known.
        if sample.gaze_direction().is_none() && arrived.direction.is_some() {
            sample.combined = EyeSample { valid: true, direction: arrived.direction, ..sample.combined };
        }
        self.estimator.push(&sample);
    }

    fn direction_at(&mut self, question: &Question) -> Option<DVec3> {
        self.estimator.estimate_at(question.display_ns).map(|estimate| estimate.direction_view)
    }
}
