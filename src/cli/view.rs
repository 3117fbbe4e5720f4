//! `stiffmap view`: the report page in the browser, from its file or served on this machine alone.

use super::{UsageError, streams};
use anyhow::{Context, Result};
use clap::Args;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use stiffmap::figures::report::PAGE_FILE;
use stiffmap::interrupt::Interrupt;

/// Bytes of a request's head that are read.
const LONGEST_HEAD: u64 = 16 << 10;
/// How long a client may take to send its request.
const PATIENCE: Duration = Duration::from_secs(5);

#[derive(Args, Debug)]
pub struct Arguments {
    /// Result folder of a run, or its report.html
    result: PathBuf,
    /// Serve the folder on 127.0.0.1 until Ctrl-C, and print the address
    #[arg(long)]
    serve: bool,
    /// Port for --serve; a free one without it
    #[arg(long, default_value_t = 0, value_name = "PORT", requires = "serve")]
    port: u16,
}

/// Opens the page, or serves it.
pub fn view(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    let given = &arguments.result;
    let page = if given.is_dir() { given.join(PAGE_FILE) } else { given.clone() };
    if !page.is_file() {
        let text =
            format!("{}: there is no {PAGE_FILE}; `stiffmap run` and `stiffmap figures` write it", given.display());
        return Err(UsageError(text).into());
    }
    let page = page.canonicalize().with_context(|| page.display().to_string())?;
    if arguments.serve {
        return serve(&page, arguments.port, interrupt);
    }
    streams::say(&format!("{}", page.display()));
    open(&page).with_context(|| format!("no browser was started; open {} in one", page.display()))
}

/// Hands a file to the desktop's opener.
fn open(page: &Path) -> Result<()> {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "windows") {
        ("cmd", &["/C", "start", ""])
    } else if cfg!(target_os = "macos") {
        ("open", &[])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let status = command.status().with_context(|| format!("cannot run {program}"))?;
    anyhow::ensure!(status.success(), "{program} ended with {status}");
    Ok(())
}

/// Serves the page's folder on the loopback address until the user asks to stop.
fn serve(page: &Path, port: u16, interrupt: &Interrupt) -> Result<()> {
    let folder = page.parent().context("the page stands in no folder")?.to_path_buf();
    let start = page.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(|| format!("--port {port}"))?;
    let port = listener.local_addr()?.port();
    listener.set_nonblocking(true)?;
    streams::print(&format!("http://127.0.0.1:{port}/\n"))?;
    while !interrupt.requested() {
        match listener.accept() {
            Ok((stream, _)) => {
                let (folder, start) = (folder.clone(), start.clone());
                std::thread::spawn(move || {
                    // A client that goes away is no concern of the others.
                    if let Err(error) = answer(stream, &folder, &start, port) {
                        tracing::debug!("{error}");
                    }
                });
            }
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {
                std::thread::sleep(Duration::from_millis(20))
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

fn answer(mut stream: TcpStream, folder: &Path, start: &str, port: u16) -> std::io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut reader = BufReader::new(stream.try_clone()?.take(LONGEST_HEAD));
    let mut request = String::new();
    reader.read_line(&mut request)?;
    let mut host = String::new();
    loop {
        let mut line = String::new();
        if reader.read_line(&mut line)? == 0 || line.trim().is_empty() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("host")
        {
            host = value.trim().to_ascii_lowercase();
        }
    }
    let mut words = request.split_whitespace();
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    // Another name for this machine would let a foreign page read the results.
    let known = [format!("127.0.0.1:{port}"), format!("localhost:{port}")].contains(&host);
    let (status, kind, body) = if !known {
        ("421 Misdirected Request", "text/plain", b"this server answers to 127.0.0.1 alone\n".to_vec())
    } else if !["GET", "HEAD"].contains(&method) {
        ("405 Method Not Allowed", "text/plain", b"GET or HEAD\n".to_vec())
    } else {
        match find(folder, start, target) {
            Some((path, bytes)) => ("200 OK", content_type(&path), bytes),
            None => ("404 Not Found", "text/plain", b"no such file\n".to_vec()),
        }
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    if method != "HEAD" {
        stream.write_all(&body)?;
    }
    stream.flush()
}

/// A file below the folder by the request's path; links that lead out of it are not followed.
fn find(folder: &Path, start: &str, target: &str) -> Option<(PathBuf, Vec<u8>)> {
    let path = target.split(['?', '#']).next().unwrap_or_default().trim_start_matches('/');
    let name = if path.is_empty() { start } else { path };
    let file = folder.join(name).canonicalize().ok()?;
    if !file.starts_with(folder) || !file.is_file() {
        return None;
    }
    let bytes = std::fs::read(&file).ok()?;
    Some((file, bytes))
}

fn content_type(path: &Path) -> &'static str {
    match path.extension().and_then(|e| e.to_str()).unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "json" => "application/json",
        "csv" => "text/csv; charset=utf-8",
        "png" => "image/png",
        "svg" => "image/svg+xml",
        _ => "application/octet-stream",
    }
}
