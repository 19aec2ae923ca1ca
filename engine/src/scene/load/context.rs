//! What every part of loading shares: the document, the limits and the warnings.

use std::collections::HashSet;
use std::fmt::Display;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use super::document::Document;

/// What went wrong, without the file's name, which [`super::load`] adds.
pub type Outcome<T> = Result<T, String>;

/// Decoded geometry and textures together may take this many bytes.
pub const MAX_DECODED_BYTES: u64 = 2 << 30;

/// Work that grows faster than the file, such as morph targets times vertices, may take this many
/// steps: seconds, where a hostile file could ask for years.
const MAX_STEPS: u64 = 1 << 28;

/// Warnings that are kept, the line that counts the others included.
const MAX_WARNINGS: usize = 20;

/// Different warnings that are told apart; a hostile file could make millions.
const MAX_DISTINCT_WARNINGS: usize = 10_000;

/// The state of one load. Everything is shared, so that images can be decoded in parallel.
pub struct Context<'a> {
    /// The file.
    pub document: &'a Document,
    bytes_left: AtomicU64,
    steps_left: AtomicU64,
    warnings: Mutex<Warnings>,
}

#[derive(Default)]
struct Warnings {
    lines: Vec<String>,
    seen: HashSet<String>,
    left_out: usize,
}

impl<'a> Context<'a> {
    /// Starts with the whole of each limit.
    pub fn new(document: &'a Document) -> Self {
        Self {
            document,
            bytes_left: AtomicU64::new(MAX_DECODED_BYTES),
            steps_left: AtomicU64::new(MAX_STEPS),
            warnings: Mutex::default(),
        }
    }

    /// Takes `count` times `size` bytes from the limit before they are allocated.
    pub fn charge(&self, count: usize, size: usize, what: impl Display) -> Outcome<()> {
        let bytes = (count as u64).saturating_mul(size as u64);
        take(&self.bytes_left, bytes).map_err(|()| {
            let limit = MAX_DECODED_BYTES >> 30;
            format!("{what} takes the file beyond {limit} GiB of decoded geometry and textures")
        })
    }

    /// Gives bytes back that were needed for a while only.
    pub fn refund(&self, count: usize, size: usize) {
        let bytes = (count as u64).saturating_mul(size as u64);
        self.bytes_left.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Bytes that can still be charged.
    pub fn bytes_left(&self) -> u64 {
        self.bytes_left.load(Ordering::Relaxed)
    }

    /// Takes `steps` from the limit of work.
    pub fn work(&self, steps: u64, what: impl Display) -> Outcome<()> {
        take(&self.steps_left, steps).map_err(|()| format!("{what} asks for an unreasonable amount of work"))
    }

    /// Notes what was ignored or mended; the same line twice is noted once.
    pub fn warn(&self, line: impl Display) {
        // A panic elsewhere leaves the list whole: each change to it is one push.
        let mut warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        let line = line.to_string();
        if warnings.seen.contains(&line) {
            return;
        }
        if warnings.lines.len() < MAX_WARNINGS {
            warnings.lines.push(line.clone());
        } else {
            warnings.left_out += 1;
        }
        if warnings.seen.len() < MAX_DISTINCT_WARNINGS {
            warnings.seen.insert(line);
        }
    }

    /// The warnings so far, the last one "and N more" where there were too many.
    pub fn into_warnings(self) -> Vec<String> {
        let mut warnings = self.warnings.into_inner().unwrap_or_else(PoisonError::into_inner);
        if warnings.left_out > 0 && warnings.lines.pop().is_some() {
            warnings.lines.push(format!("and {} more", warnings.left_out + 1));
        }
        warnings.lines
    }
}

fn take(left: &AtomicU64, amount: u64) -> Result<(), ()> {
    left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(amount))
        .map(|_| ())
        .map_err(|_| ())
}

/// How messages call the `index`th thing of a kind, such as `mesh 3 "Chair"`.
pub fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        // A name is the file's, so it may hold anything and be of any length.
        Some(name) if !name.is_empty() => {
            let short: String = name.chars().take(60).flat_map(char::escape_debug).collect();
            format!("{kind} {index} \"{short}\"")
        }
        _ => format!("{kind} {index}"),
    }
}

/// A thing's own name, or else `kind index`.
pub fn name_or(name: Option<&str>, kind: &str, index: usize) -> String {
    match name {
        Some(name) if !name.is_empty() => name.to_owned(),
        _ => format!("{kind} {index}"),
    }
}

/// `items[index]`, or what `user` asked for in vain.
pub fn get<'a, T>(items: &'a [T], kind: &str, index: usize, user: impl Display) -> Outcome<&'a T> {
    items.get(index).ok_or_else(|| format!("{user} names {kind} {index}, but the file has {}", items.len()))
}
