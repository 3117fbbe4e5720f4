//! Progress on stderr: bars on a terminal, plain lines otherwise.

use super::streams;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::Instant;

/// Times the stages of a run and shows how far it is.
pub struct Progress {
    terminal: bool,
    quiet: bool,
    seconds: Vec<(String, f64)>,
}

impl Progress {
    /// Progress on stderr, or none.
    pub fn new(quiet: bool) -> Self {
        Self { terminal: std::io::stderr().is_terminal(), quiet, seconds: Vec::new() }
    }

    /// Runs a stage of `steps` steps (0 for a stage without), giving it a function to report each.
    pub fn stage<T, E>(
        &mut self,
        name: &str,
        steps: usize,
        work: impl FnOnce(&(dyn Fn() + Sync)) -> Result<T, E>,
    ) -> Result<T, E> {
        let start = Instant::now();
        let bar = if self.terminal && !self.quiet {
            let template = if steps > 0 {
                "{prefix:<24} {bar:32} {pos}/{len} {elapsed}"
            } else {
                "{prefix:<24} {spinner} {elapsed}"
            };
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr())
                .with_style(style)
                .with_prefix(name.to_string());
            bar.enable_steady_tick(std::time::Duration::from_millis(100));
            bar
        } else {
            ProgressBar::hidden()
        };
        let result = work(&|| bar.inc(1));
        bar.finish_and_clear();
        let seconds = start.elapsed().as_secs_f64();
        if result.is_ok() {
            if !self.quiet {
                streams::say(&format!("{name:<24} {seconds:7.2} s"));
            }
            self.seconds.push((name.to_string(), seconds));
        }
        result
    }

    /// Says something beside the stages.
    pub fn say(&self, text: &str) {
        if !self.quiet {
            streams::say(text);
        }
    }

    /// Says warnings before a long computation; they stand in summary and manifest again.
    pub fn warn(&self, warnings: &[String]) {
        warnings.iter().for_each(|warning| self.say(&format!("warning: {warning}")));
    }

    /// Wall seconds of each stage so far.
    pub fn seconds(&self) -> &[(String, f64)] {
        &self.seconds
    }
}
