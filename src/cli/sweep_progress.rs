//! How far a sweep is, how fast, and how long it will take.

use super::streams;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Seconds between two lines where stderr is no terminal.
const EVERY: Duration = Duration::from_secs(5);

/// Progress over designs: a bar on a terminal, a line now and then otherwise.
pub struct Rate {
    bar: Option<ProgressBar>,
    quiet: bool,
    what: &'static str,
    positions: usize,
    total: u64,
    before: u64,
    done: u64,
    start: Instant,
    said: Instant,
}

impl Rate {
    /// Progress over `total` designs, of which `before` were there already.
    pub fn new(what: &'static str, total: u64, before: u64, positions: usize, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let template = "{prefix:<24} {bar:24} {pos}/{len} {msg}";
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr()).with_style(style);
            bar.with_prefix(what)
        });
        let now = Instant::now();
        Self { bar, quiet, what, positions, total, before, done: before, start: now, said: now }
    }

    /// One more design is done.
    pub fn step(&mut self) {
        self.done += 1;
        if let Some(bar) = &self.bar {
            bar.set_position(self.done);
            bar.set_message(self.words());
        } else if !self.quiet && self.said.elapsed() >= EVERY {
            self.said = Instant::now();
            streams::say(&format!("{:<24} {} of {}, {}", self.what, self.done, self.total, self.words()));
        }
    }

    fn words(&self) -> String {
        let left = (self.total - self.done.min(self.total)) as f64 / self.rate().max(f64::MIN_POSITIVE);
        let pairs = self.rate() * self.positions as f64;
        format!("{:.3} designs/s, {pairs:.0} (design, position) pairs/s, {} left", self.rate(), duration(left))
    }

    /// Designs of this run.
    pub fn designs(&self) -> u64 {
        self.done - self.before
    }

    /// Seconds so far.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Designs a second.
    pub fn rate(&self) -> f64 {
        self.designs() as f64 / self.seconds().max(1e-9)
    }

    /// Takes the bar away and says how it went.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        if !self.quiet {
            let pairs = self.rate() * self.positions as f64;
            streams::say(&format!("{:<24} {:7.2} s, {pairs:.0} (design, position) pairs/s", self.what, self.seconds()));
        }
    }
}

fn duration(seconds: f64) -> String {
    if seconds.is_nan() || seconds > 1e8 {
        return "unknown".to_owned();
    }
    let whole = seconds.ceil() as u64;
    match whole {
        0..120 => format!("{whole} s"),
        120..7200 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn times_are_said_in_words() {
        assert_eq!(duration(0.2), "1 s");
        assert_eq!(duration(125.0), "2 min 5 s");
        assert_eq!(duration(7300.0), "2 h 1 min");
        assert_eq!(duration(f64::INFINITY), "unknown");
    }
}
