//! What happened to every sample and at every refresh, for tests, files and plots.

use super::run::{Frame, LatencyRun};
use super::session::{SessionGaze, azimuth_elevation_deg};
use super::timeline::Arrival;
use serde::Serialize;
use serde::ser::{SerializeSeq, Serializer};
use std::io::{self, Write};

/// The life of one sample that the tracker made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct SampleRow {
    /// Its index in the recording.
    pub sample: usize,
    /// It has a gaze that can be used.
    pub usable: bool,
    /// The middle of its exposure, ns: when the eye was like this.
    pub exposed_ns: i64,
    /// When the host had it, ns.
    pub available_ns: i64,
    /// When a picture's gaze was first taken from it, ns.
    pub latched_ns: Option<i64>,
    /// The middle of the light that first showed that picture, ns.
    pub displayed_ns: Option<i64>,
    /// When the host had the next sample with a gaze, ns.
    pub superseded_ns: Option<i64>,
}

/// One refresh as files have it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameRow {
    /// Refreshes since the first one of the session.
    pub refresh: u64,
    /// The picture shown.
    pub picture: u64,
    /// When its gaze was taken, ns.
    pub latch_ns: i64,
    /// The middle of the light, ns.
    pub display_ns: i64,
    /// The sample that the renderer had: index in the recording.
    pub sample: Option<usize>,
    /// Its age, ms.
    pub age_ms: Option<f64>,
    /// The newest sample had no gaze.
    pub over_loss: bool,
    /// What the renderer took the gaze to be: to the right, degrees.
    pub used_azimuth_deg: Option<f64>,
    /// Upwards, degrees.
    pub used_elevation_deg: Option<f64>,
    /// Where the eye looked: to the right, degrees.
    pub true_azimuth_deg: Option<f64>,
    /// Upwards, degrees.
    pub true_elevation_deg: Option<f64>,
    /// Between both, degrees.
    pub error_deg: Option<f64>,
    /// What the eye did.
    pub state: &'static str,
    /// Vision is suppressed.
    pub suppressed: bool,
    /// The frame counts for the outside share.
    pub counted: bool,
    /// The true gaze lay outside the radius.
    pub outside: bool,
}

impl From<&Frame> for FrameRow {
    fn from(frame: &Frame) -> Self {
        let [used, truth] =
            [frame.direction, frame.truth].map(|direction| direction.map(azimuth_elevation_deg));
        Self {
            refresh: frame.refresh,
            picture: frame.picture,
            latch_ns: frame.latch_ns,
            display_ns: frame.display_ns,
            sample: frame.sample,
            age_ms: frame.age_ns.map(|ns| ns as f64 * 1e-6),
            over_loss: frame.over_loss,
            used_azimuth_deg: used.map(|angles| angles[0]),
            used_elevation_deg: used.map(|angles| angles[1]),
            true_azimuth_deg: truth.map(|angles| angles[0]),
            true_elevation_deg: truth.map(|angles| angles[1]),
            error_deg: frame.error_deg,
            state: frame.state.name(),
            suppressed: frame.suppressed,
            counted: frame.counted,
            outside: frame.outside,
        }
    }
}

/// The ledger of a run. It holds nothing of its own: rows are made as they are asked for.
#[derive(Clone, Copy, Debug)]
pub struct Ledger<'a> {
    run: &'a LatencyRun,
    session: &'a SessionGaze,
}

impl LatencyRun {
    /// The ledger of this run over `session`, which must be the one that it was made of.
    #[must_use]
    pub fn ledger<'a>(&'a self, session: &'a SessionGaze) -> Ledger<'a> {
        Ledger { run: self, session }
    }
}

impl<'a> Ledger<'a> {
    /// One row for each refresh, in order.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = FrameRow> + use<'a> {
        self.run.frames.iter().map(FrameRow::from)
    }

    /// One row for each sample that the tracker made, in the order of arrival.
    #[must_use]
    pub fn samples(&self) -> SampleRows<'a> {
        SampleRows { run: self.run, session: self.session, arrival: 0, frame: 0, usable: 0 }
    }

    /// Writes the refreshes as CSV, one header line first; the columns are the fields of [`FrameRow`],
    /// with their units in the names. What is not known is empty; flags are 0 or 1.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_frames_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "refresh,picture,latch_ns,display_ns,sample,age_ms,over_loss,used_azimuth_deg,used_elevation_deg,\
             true_azimuth_deg,true_elevation_deg,error_deg,state,suppressed,counted,outside"
        )?;
        for row in self.frames() {
            let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.6}"));
            writeln!(
                out,
                "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                row.refresh,
                row.picture,
                row.latch_ns,
                row.display_ns,
                row.sample.map_or(String::new(), |sample| sample.to_string()),
                number(row.age_ms),
                u8::from(row.over_loss),
                number(row.used_azimuth_deg),
                number(row.used_elevation_deg),
                number(row.true_azimuth_deg),
                number(row.true_elevation_deg),
                number(row.error_deg),
                row.state,
                u8::from(row.suppressed),
                u8::from(row.counted),
                u8::from(row.outside),
            )?;
        }
        Ok(())
    }

    /// Writes the samples as CSV, one header line first; the columns are the fields of [`SampleRow`].
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_samples_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "sample,usable,exposed_ns,available_ns,latched_ns,displayed_ns,superseded_ns")?;
        for row in self.samples() {
            let time = |value: Option<i64>| value.map_or(String::new(), |value| value.to_string());
            writeln!(
                out,
                "{},{},{},{},{},{},{}",
                row.sample,
                u8::from(row.usable),
                row.exposed_ns,
                row.available_ns,
                time(row.latched_ns),
                time(row.displayed_ns),
                time(row.superseded_ns),
            )?;
        }
        Ok(())
    }

    /// Writes both as one JSON object: `frames` and `samples`, lists of rows with the names of
    /// [`FrameRow`] and [`SampleRow`]. Rows are written as they are made.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_json(&self, out: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer(out, self).map_err(io::Error::from)
    }
}

impl Serialize for Ledger<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut object = serializer.serialize_struct("Ledger", 2)?;
        object.serialize_field("frames", &Frames(*self))?;
        object.serialize_field("samples", &Samples(*self))?;
        object.end()
    }
}

struct Frames<'a>(Ledger<'a>);
struct Samples<'a>(Ledger<'a>);

impl Serialize for Frames<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.0.run.frames.len()))?;
        self.0.frames().try_for_each(|row| list.serialize_element(&row))?;
        list.end()
    }
}

impl Serialize for Samples<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.0.run.arrivals.len()))?;
        self.0.samples().try_for_each(|row| list.serialize_element(&row))?;
        list.end()
    }
}

/// The iterator of [`Ledger::samples`].
#[derive(Clone, Debug)]
pub struct SampleRows<'a> {
    run: &'a LatencyRun,
    session: &'a SessionGaze,
    arrival: usize,
    frame: usize,
    /// The first usable arrival after the row told last: searched once for all rows of a loss.
    usable: usize,
}

impl Iterator for SampleRows<'_> {
    type Item = SampleRow;

    fn next(&mut self) -> Option<SampleRow> {
        let Arrival { available_ns, time_ns, row, usable } = *self.run.arrivals.get(self.arrival)?;
        self.arrival += 1;
        let sample = self.session.recorded(row as usize);
        let frames = &self.run.frames;
        while frames.get(self.frame).is_some_and(|frame| frame.sample.is_none()) {
            self.frame += 1;
        }
        // Pictures take samples in the order of arrival.
        let first = frames.get(self.frame).filter(|frame| frame.sample == Some(sample));
        while frames.get(self.frame).is_some_and(|frame| frame.sample == Some(sample)) {
            self.frame += 1;
        }
        let arrivals = &self.run.arrivals;
        self.usable = self.usable.max(self.arrival);
        while arrivals.get(self.usable).is_some_and(|next| !next.usable) {
            self.usable += 1;
        }
        Some(SampleRow {
            sample,
            usable,
            exposed_ns: time_ns,
            available_ns,
            latched_ns: first.map(|frame| frame.latch_ns),
            displayed_ns: first.map(|frame| frame.display_ns),
            superseded_ns: arrivals.get(self.usable).map(|next| next.available_ns),
        })
    }
}
