//! Progress on stderr: a bar on a terminal, plain lines or nothing elsewhere.

use crate::output::note;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

/// The bar's positions for all of the work.
const WHOLE: u64 = 1000;

/// Named steps, each with its share of the work.
pub struct Steps {
    bar: Option<ProgressBar>,
    plain: bool,
    begun: Instant,
    /// Of steps that have ended, of the one that runs, and of all.
    done: f64,
    current: f64,
    total: f64,
    count: u64,
    what: String,
}

impl Steps {
    /// Work that takes minutes, as the sum of its steps' weights: shows plain lines where stderr is
    /// no terminal.
    pub fn long(total: f64) -> Self {
        Self::new(total, true)
    }

    /// Equal steps that take seconds: silent where stderr is no terminal.
    pub fn short(total: u64) -> Self {
        Self::new(total as f64, false)
    }

    fn new(total: f64, plain: bool) -> Self {
        let bar = stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:28} {percent:>3} %  {elapsed}  {msg}");
            ProgressBar::new(WHOLE).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        let begun = Instant::now();
        Self { bar, plain, begun, done: 0.0, current: 0.0, total, count: 0, what: String::new() }
    }

    /// The next step begins.
    pub fn next(&mut self, what: &str) {
        self.next_of_weight(what, 1.0);
    }

    /// The next step begins, of a known share of the work.
    pub fn next_of_weight(&mut self, what: &str, weight: f64) {
        self.done += self.current;
        self.current = weight;
        self.count += 1;
        what.clone_into(&mut self.what);
        self.show(0.0);
        if self.bar.is_none() && self.plain {
            let left = self.left(0.0).map(|left| format!(" ({left})")).unwrap_or_default();
            note(&format!("[{}] {what}{left}", self.count));
        }
    }

    /// How far the step that runs has come, 0 to 1.
    pub fn within(&self, fraction: f64) {
        self.show(fraction.clamp(0.0, 1.0));
    }

    fn show(&self, fraction: f64) {
        let Some(bar) = &self.bar else { return };
        bar.set_position((self.share(fraction) * WHOLE as f64) as u64);
        let left = self.left(fraction).map(|left| format!("  {left}")).unwrap_or_default();
        bar.set_message(format!("{}{left}", self.what));
        bar.tick();
    }

    fn share(&self, fraction: f64) -> f64 {
        ((self.done + self.current * fraction) / self.total).min(1.0)
    }

    fn left(&self, fraction: f64) -> Option<String> {
        if self.plain { time_left(self.begun.elapsed(), self.share(fraction)) } else { None }
    }
}

/// The time left in words, once enough has been done to tell.
fn time_left(elapsed: Duration, share: f64) -> Option<String> {
    if elapsed < Duration::from_secs(2) || share < 0.02 {
        return None;
    }
    let seconds = elapsed.as_secs_f64() * (1.0 - share) / share;
    Some(if seconds < 90.0 {
        format!("about {:.0} s left", (seconds / 5.0).ceil() * 5.0)
    } else {
        format!("about {:.0} min left", (seconds / 60.0).ceil())
    })
}

impl Drop for Steps {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_follows_from_the_share_done() {
        let after = |seconds, share| time_left(Duration::from_secs(seconds), share);
        assert_eq!(after(1, 0.5), None);
        assert_eq!(after(60, 0.0), None);
        assert_eq!(after(30, 0.5).as_deref(), Some("about 30 s left"));
        assert_eq!(after(60, 0.1).as_deref(), Some("about 9 min left"));
    }

    #[test]
    fn steps_share_the_work_by_weight() {
        let mut steps = Steps::long(4.0);
        steps.next("first");
        steps.next_of_weight("second", 2.0);
        assert!((steps.share(0.5) - 0.5).abs() < 1e-12);
        steps.next("third");
        assert!((steps.share(1.0) - 1.0).abs() < 1e-12);
    }
}
