//! XDF, the format of LabRecorder: streams of the lab streaming layer, interleaved in chunks. Read is the
//! first stream of gaze that has samples; its channels are matched by what its header says of them.
//!
//! The format is that of the XDF specification 1.0: a length in 1, 4 or 8 bytes, a tag of 2 bytes,
//! content; little-endian. A damaged part is skipped up to the next boundary chunk.

mod channels;
mod clock;
#[cfg(test)]
mod tests;

use super::rows::{Extras, Rejects, ns_of};
use super::{Format, Input, ReadOptions};
use crate::error::{Error, Result};
use crate::recording::{Recording, RecordingInfo};
use crate::sample::GazeSample;
use channels::{Channel, Layout};
use clock::Clock;

/// The format.
pub const FORMAT: Format = Format { name: "xdf", matches, read };

const MAGIC: &[u8] = b"XDF:";
/// What a boundary chunk holds, so that a reader finds it in a damaged file.
const BOUNDARY: [u8; 16] =
    [0x43, 0xA5, 0x46, 0xDC, 0xCB, 0xF5, 0x41, 0x0F, 0xB3, 0x0E, 0xD5, 0x46, 0x73, 0x83, 0xCB, 0xE4];
/// The most streams of a file; recordings have tens.
const MAX_STREAMS: usize = 256;
/// The most channels of a stream; one of gaze has tens.
const MAX_CHANNELS: usize = 4096;

/// How a stream's values are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Values {
    Float32,
    Double64,
    Int8,
    Int16,
    Int32,
    Int64,
    Text,
}

/// A stream: what its header says, and where its samples are.
#[derive(Debug)]
struct Stream<'a> {
    id: u32,
    name: String,
    kind: String,
    channels: Vec<Channel>,
    values: Values,
    rate_hz: f64,
    /// Bodies of its sample chunks.
    samples: Vec<&'a [u8]>,
    clock: Clock,
}

fn matches(input: &Input, _: &str) -> bool {
    input.bytes.starts_with(MAGIC)
}

/// Cuts off the front; `None` where there is less.
fn take<'a>(bytes: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (front, rest) = bytes.split_at_checked(count)?;
    *bytes = rest;
    Some(front)
}

/// Little-endian, of at most 8 bytes.
fn unsigned(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte))
}

fn take_double(bytes: &mut &[u8]) -> Option<f64> {
    Some(f64::from_bits(unsigned(take(bytes, 8)?)))
}

/// A length in as many bytes as its first byte says.
fn take_length(bytes: &mut &[u8]) -> Option<usize> {
    match take(bytes, 1)? {
        [size @ (1 | 4 | 8)] => usize::try_from(unsigned(take(bytes, usize::from(*size))?)).ok(),
        _ => None,
    }
}

/// The tag and body of the chunk at the front; `None` where there is no whole one.
fn take_chunk<'a>(bytes: &mut &'a [u8]) -> Option<(u64, &'a [u8])> {
    let length = take_length(bytes)?;
    let mut chunk = take(bytes, length)?;
    Some((unsigned(take(&mut chunk, 2)?), chunk))
}

impl Values {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "float32" => Self::Float32,
            "double64" | "float64" => Self::Double64,
            "int8" => Self::Int8,
            "int16" => Self::Int16,
            "int32" => Self::Int32,
            "int64" => Self::Int64,
            "string" => Self::Text,
            _ => return None,
        })
    }

    /// Takes one value. Text is passed over and gives NaN.
    fn take(self, bytes: &mut &[u8]) -> Option<f64> {
        let signed = |bytes: &mut &[u8], size: usize| {
            let unused_bits = 64 - 8 * size as u32;
            Some(((unsigned(take(bytes, size)?) << unused_bits) as i64 >> unused_bits) as f64)
        };
        match self {
            Self::Float32 => Some(f64::from(f32::from_bits(unsigned(take(bytes, 4)?) as u32))),
            Self::Double64 => take_double(bytes),
            Self::Int8 => signed(bytes, 1),
            Self::Int16 => signed(bytes, 2),
            Self::Int32 => signed(bytes, 4),
            Self::Int64 => signed(bytes, 8),
            Self::Text => {
                let length = take_length(bytes)?;
                take(bytes, length).map(|_| f64::NAN)
            }
        }
    }
}

impl<'a> Stream<'a> {
    /// From the XML of a header chunk; `None` where it lacks what is needed.
    fn of(id: u32, xml: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(xml).ok()?;
        let document = roxmltree::Document::parse(text.trim_matches(['\0', ' ', '\n', '\r'])).ok()?;
        let info = document.root_element();
        let text_of = |name: &str| channels::text_of(info, name).unwrap_or_default().to_owned();
        let count: usize = text_of("channel_count").parse().ok().filter(|count| *count <= MAX_CHANNELS)?;
        let rate_hz: f64 = text_of("nominal_srate").parse().unwrap_or(0.0);
        Some(Self {
            id,
            name: text_of("name"),
            kind: text_of("type"),
            channels: channels::channels_of(info, count),
            values: Values::of(&text_of("channel_format"))?,
            rate_hz: if rate_hz.is_finite() { rate_hz.max(0.0) } else { 0.0 },
            samples: Vec::new(),
            clock: Clock::default(),
        })
    }

    fn is_gaze(&self) -> bool {
        let kind: String =
            self.kind.to_lowercase().chars().filter(|letter| letter.is_alphanumeric()).collect();
        ["gaze", "eyetracking", "eyetracker", "eyegaze"].contains(&kind.as_str())
    }

    /// Tells each sample with its time on the stream's own clock, s: its stamp, or the time before it
    /// and one step of the nominal rate. NaN before the first stamp. Returns the number of chunks that
    /// break off.
    fn for_each(&self, mut tell: impl FnMut(f64, &[f64])) -> u64 {
        let step_s = if self.rate_hz > 0.0 { 1.0 / self.rate_hz } else { 0.0 };
        let mut time_s = f64::NAN;
        let mut values = Vec::with_capacity(self.channels.len());
        let mut broken = 0;
        for chunk in &self.samples {
            let mut rest = *chunk;
            let mut chunk_samples = || -> Option<()> {
                for _ in 0..take_length(&mut rest)? {
                    time_s = match take(&mut rest, 1)? {
                        [0] => time_s + step_s,
                        [8] => take_double(&mut rest)?,
                        _ => return None,
                    };
                    values.clear();
                    for _ in &self.channels {
                        values.push(self.values.take(&mut rest)?);
                    }
                    tell(time_s, &values);
                }
                Some(())
            };
            broken += u64::from(chunk_samples().is_none());
        }
        broken
    }
}

/// All streams of a file, and how many parts of it are damaged.
fn streams_of(bytes: &[u8]) -> (Vec<Stream<'_>>, u64) {
    let mut streams: Vec<Stream> = Vec::new();
    let mut damaged = 0;
    let mut rest = bytes.strip_prefix(MAGIC).unwrap_or(bytes);
    while !rest.is_empty() {
        let mut after = rest;
        if let Some((tag, body)) = take_chunk(&mut after) {
            damaged += u64::from(use_chunk(&mut streams, tag, body).is_none());
            rest = after;
        } else {
            damaged += 1;
            let boundary = rest.windows(BOUNDARY.len()).position(|window| window == BOUNDARY);
            rest = boundary.and_then(|at| rest.get(at + BOUNDARY.len()..)).unwrap_or_default();
        }
    }
    (streams, damaged)
}

/// `None` for a chunk that is damaged inside. Samples of a stream without header are passed over.
fn use_chunk<'a>(streams: &mut Vec<Stream<'a>>, tag: u64, mut body: &'a [u8]) -> Option<()> {
    if !(2..=4).contains(&tag) {
        return Some(());
    }
    let id = unsigned(take(&mut body, 4)?) as u32;
    let full = streams.len() >= MAX_STREAMS;
    let known = streams.iter_mut().find(|stream| stream.id == id);
    match (tag, known) {
        (2, None) if !full => streams.push(Stream::of(id, body)?),
        (3, Some(stream)) => stream.samples.push(body),
        (4, Some(stream)) => stream.clock.add(take_double(&mut body)?, take_double(&mut body)?),
        _ => {}
    }
    Some(())
}

/// What a person wants to know of a stream.
fn described(stream: &Stream) -> String {
    format!("{} ({}, {} channels)", stream.name, stream.kind, stream.channels.len())
}

fn read(input: &Input, options: &ReadOptions) -> Result<Recording> {
    let (streams, damaged) = streams_of(&input.bytes);
    let gaze = |stream: &&Stream| stream.is_gaze() && stream.values != Values::Text;
    let filled = streams.iter().filter(gaze).find(|stream| !stream.samples.is_empty());
    let Some(stream) = filled.or_else(|| streams.iter().find(gaze)) else {
        let held: Vec<_> = streams.iter().take(32).map(described).collect();
        let held = if held.is_empty() { "nothing".to_owned() } else { held.join(", ") };
        let cause = format!("holds no numeric stream of type Gaze or Eyetracking; it holds: {held}");
        return Err(Error::file(&input.path, cause));
    };
    let mut layout = Layout::new(&stream.channels, options);
    stream.for_each(|_, values| layout.look(values));
    let mut recording = Recording::new(RecordingInfo {
        device: stream.name.clone(),
        space: layout.space(),
        nominal_rate_hz: (stream.rate_hz > 0.0).then_some(stream.rate_hz),
        screen: options.screen,
        device_clock: "seconds of the machine that sent the stream".into(),
        notes: layout.notes(),
        ..RecordingInfo::default()
    });
    for other in streams.iter().filter(|other| other.id != stream.id).take(32) {
        recording.info.notes.push(format!("not read: stream {}", described(other)));
    }
    let sync = stream.clock.fitted();
    let mut extras = Extras::new(stream.channels.iter().map(|channel| channel.label.as_str()));
    let (mut rejects, mut row) = (Rejects::default(), 0u64);
    let broken = stream.for_each(|time_s, values| {
        row += 1;
        let unit_s = options.time_unit_s.unwrap_or(1.0);
        let device_time_ns = ns_of(time_s, unit_s);
        let Some(time_ns) = ns_of(sync.local_s(time_s), unit_s) else {
            rejects.add(format_args!("sample {row}"), "its time is no number or beyond 64 bits of ns");
            return;
        };
        let mut sample = GazeSample { device_time_ns, ..GazeSample::at(time_ns) };
        layout.fill(&mut sample, values);
        layout.keep(&mut extras, recording.len(), values);
        recording.push(&sample);
    });
    extras.finish(&mut recording);
    rejects.report(&mut recording, "samples have no time");
    recording.skip_any(broken, "chunks of samples break off inside; what came before was read");
    recording.skip_any(damaged, "parts of the file are damaged or cut off");
    Ok(recording)
}
