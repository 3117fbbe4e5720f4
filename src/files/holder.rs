//! The lock of a result folder as text: which job holds it, since when, and which files it has begun.
//!
//! Each job appends its line `job PID SECONDS HOST COMMAND`; each file that is begun appends `file NAME`. The last job is
//! the one that holds the folder. The lines of files outlive a killed job, so that the next one can remove them.

use super::aside::file_line;
use std::time::{SystemTime, UNIX_EPOCH};

/// The line of this process.
pub fn job_line(command: &str) -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host = host.split_whitespace().next().unwrap_or("-").to_owned();
    format!("job {} {seconds} {host} {}\n", std::process::id(), command.replace(['\n', '\r'], " "))
}

/// The job that holds a folder, in words.
pub fn holder(text: &str) -> String {
    let line = text.lines().rev().find_map(|line| line.strip_prefix("job "));
    let fields: Option<Vec<&str>> = line.map(|line| line.splitn(4, ' ').collect());
    match fields.as_deref() {
        Some([pid, seconds, host, command]) => {
            let since = seconds.parse().map_or_else(|_| (*seconds).to_owned(), date);
            let host = if *host == "-" { String::new() } else { format!(" on {host}") };
            format!("process {pid}{host}, `{command}`, since {since}")
        }
        _ => "another process".to_owned(),
    }
}

/// The files that jobs began and that no result of a finished job lists.
pub fn files(text: &str) -> Vec<String> {
    let mut names: Vec<String> =
        text.lines().filter_map(|line| line.strip_prefix("file ")).map(str::to_owned).collect();
    names.sort();
    names.dedup();
    names
}

/// The lines of files.
pub fn file_lines(names: &[String]) -> String {
    names.iter().map(|name| file_line(name)).collect()
}

/// Seconds since 1970 as a date and time, UTC.
fn date(seconds: u64) -> String {
    let (days, of_day) = (seconds / 86_400, seconds % 86_400);
    // Source: H. Hinnant, chrono-compatible low-level date algorithms; years begin in March.
    let shifted = days + 719_468;
    let era = shifted / 146_097;
    let of_era = shifted % 146_097;
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year + 400 * era + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02} {:02}:{:02}:{:02} UTC", of_day / 3600, of_day / 60 % 60, of_day % 60)
}

#[cfg(test)]
mod tests {
    use super::{date, files, holder};

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, expected) in [
            (0, "1970-01-01 00:00:00 UTC"),
            (951_782_399, "2000-02-28 23:59:59 UTC"),
            (951_782_400, "2000-02-29 00:00:00 UTC"),
            (1_709_251_199, "2024-02-29 23:59:59 UTC"),
            (4_107_542_400, "2100-03-01 00:00:00 UTC"),
        ] {
            assert_eq!(date(seconds), expected);
        }
    }

    #[test]
    fn the_last_job_holds_and_files_of_all_jobs_are_known() {
        let text = "job 7 0 - stiffmap run a\nfile b.csv\njob 8 60 desk stiffmap run x y\nfile b.csv\nfile a.csv\n";
        assert_eq!(holder(text), "process 8 on desk, `stiffmap run x y`, since 1970-01-01 00:01:00 UTC");
        assert_eq!(files(text), ["a.csv", "b.csv"]);
        assert_eq!(holder("job 7"), "another process");
    }
}
