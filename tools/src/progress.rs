//! Progress on stderr: a bar on a terminal, plain lines or nothing elsewhere.

use crate::output::note;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};

/// Named steps of a known number.
pub struct Steps {
    bar: Option<ProgressBar>,
    plain: bool,
    done: u64,
    total: u64,
}

impl Steps {
    /// Work that takes minutes: shows plain lines where stderr is no terminal.
    pub fn long(total: u64) -> Self {
        Self::new(total, true)
    }

    /// Work that takes seconds: silent where stderr is no terminal.
    pub fn short(total: u64) -> Self {
        Self::new(total, false)
    }

    fn new(total: u64, plain: bool) -> Self {
        let bar = stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:28} {pos}/{len}  {elapsed}  {msg}");
            ProgressBar::new(total).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        Self { bar, plain, done: 0, total }
    }

    /// The next step begins.
    pub fn next(&mut self, what: &str) {
        match &self.bar {
            Some(bar) => {
                bar.set_position(self.done);
                bar.set_message(what.to_owned());
                bar.tick();
            }
            None if self.plain => note(&format!("[{}/{}] {what}", self.done + 1, self.total)),
            None => {}
        }
        self.done += 1;
    }
}

impl Drop for Steps {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
