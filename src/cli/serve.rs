//! `stiffmap view --serve`: the files of one folder over HTTP, to this machine alone.
//!
//! A browser needs little of a server: GET and HEAD of files. Files are sent in pieces as the client takes them, so
//! a map of gigabytes costs the memory of one piece; a client that neither asks nor takes is let go. Only the
//! loopback address is bound, and only the names of this machine are answered to, or a page of another site could
//! read the results through a name that it points here.

use super::streams;
use anyhow::{Context, Result};
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use stiffmap::interrupt::Interrupt;

/// Bytes of a request's head that are read.
const LONGEST_HEAD: u64 = 16 << 10;
/// How long a client may take to send its request.
const TO_ASK: Duration = Duration::from_secs(5);
/// How long a client may take nothing of what is sent.
const TO_TAKE: Duration = Duration::from_secs(20);
/// Bytes of a file that are in memory at a time.
const PIECE: usize = 64 << 10;
/// Clients at a time; a browser opens six connections.
const MOST_CLIENTS: usize = 64;

/// Serves a page's folder on the loopback address until the user asks to stop.
pub fn serve(page: &Path, port: u16, interrupt: &Interrupt) -> Result<()> {
    let folder = page.parent().context("the page stands in no folder")?.to_path_buf();
    let start = page.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(|| format!("--port {port}"))?;
    let port = listener.local_addr()?.port();
    listener.set_nonblocking(true)?;
    streams::print(&format!("http://127.0.0.1:{port}/\n"))?;
    let site = Arc::new(Site { folder, start, port });
    let wait = || std::thread::sleep(Duration::from_millis(20));
    while !interrupt.requested() {
        // Each client holds the site while it is served.
        if Arc::strong_count(&site) > MOST_CLIENTS {
            wait();
            continue;
        }
        match listener.accept() {
            Ok((stream, _)) => {
                let site = site.clone();
                let client = move || {
                    // A client that goes away is no concern of the others.
                    if let Err(error) = site.answer(stream) {
                        tracing::debug!("{error}");
                    }
                };
                // Without a thread for it the client is let go, and may ask again.
                if let Err(error) = std::thread::Builder::new().spawn(client) {
                    tracing::debug!("{error}");
                }
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => wait(),
            // The client left before it was met, or all files that a process may have are open.
            Err(error) => {
                tracing::debug!("{error}");
                wait();
            }
        }
    }
    Ok(())
}

/// What is served.
struct Site {
    /// The folder, without links.
    folder: PathBuf,
    /// The file under `/`.
    start: String,
    port: u16,
}

/// What a client is told.
enum Reply {
    File(PathBuf, File),
    Text(&'static str, &'static str),
}

/// A stream that is read until a moment, whatever the pace of what comes.
struct Until<'a>(&'a TcpStream, Instant);

impl Read for Until<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let left = self.1.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        self.0.set_read_timeout(Some(left))?;
        self.0.read(bytes)
    }
}

impl Site {
    fn answer(&self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_nonblocking(false)?;
        stream.set_write_timeout(Some(TO_TAKE))?;
        let (method, reply) = self.reply(&stream)?;
        let (status, kind, length) = match &reply {
            Reply::File(path, file) => ("200 OK", content_type(path), file.metadata()?.len()),
            Reply::Text(status, text) => (*status, "text/plain", text.len() as u64),
        };
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nCache-Control: no-store\r\n\
             X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n"
        );
        stream.write_all(head.as_bytes())?;
        if method == "HEAD" {
            return Ok(());
        }
        match reply {
            Reply::Text(_, text) => stream.write_all(text.as_bytes()),
            Reply::File(_, file) => send(file, length, &mut stream),
        }
    }

    /// Reads a request: its method, and what it gets.
    fn reply(&self, stream: &TcpStream) -> std::io::Result<(String, Reply)> {
        let mut reader = BufReader::new(Until(stream, Instant::now() + TO_ASK).take(LONGEST_HEAD));
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
        let known = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)].contains(&host);
        let reply = if !known {
            Reply::Text("421 Misdirected Request", "this server answers to 127.0.0.1 alone\n")
        } else if !["GET", "HEAD"].contains(&method) {
            Reply::Text("405 Method Not Allowed", "GET or HEAD\n")
        } else {
            let opened = self.find(target).and_then(|path| Some((File::open(&path).ok()?, path)));
            let none = Reply::Text("404 Not Found", "no such file\n");
            opened.map_or(none, |(file, path)| Reply::File(path, file))
        };
        Ok((method.to_owned(), reply))
    }

    /// A file below the folder by the request's path; links that lead out of it are not followed.
    fn find(&self, target: &str) -> Option<PathBuf> {
        let path = decoded(target.split(['?', '#']).next()?)?;
        let path = path.trim_start_matches('/');
        let name = Path::new(if path.is_empty() { &*self.start } else { path });
        if name.components().any(|part| !matches!(part, Component::Normal(_))) {
            return None;
        }
        let file = self.folder.join(name).canonicalize().ok()?;
        (file.starts_with(&self.folder) && file.is_file()).then_some(file)
    }
}

/// Sends the first `length` bytes of a file, piece by piece.
fn send(file: File, length: u64, stream: &mut TcpStream) -> std::io::Result<()> {
    let mut file = file.take(length);
    let mut piece = vec![0; PIECE];
    loop {
        match file.read(&mut piece)? {
            0 => return stream.flush(),
            n => stream.write_all(&piece[..n])?,
        }
    }
}

/// A request's path with `%20` and its like as the characters that they stand for; `None` for what is no text.
fn decoded(path: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        rest = after;
        if first != b'%' {
            bytes.push(first);
            continue;
        }
        let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
        if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return None;
        }
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        rest = &rest[2..];
    }
    String::from_utf8(bytes).ok().filter(|text| !text.contains(['\0', '\\']))
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

#[cfg(test)]
mod tests {
    use super::decoded;

    #[test]
    fn per_cent_signs_stand_for_characters() {
        for (path, text) in [("/a%20b.csv", "/a b.csv"), ("/%C3%BC", "/ü"), ("/%2e%2E/x", "/../x"), ("", "")] {
            assert_eq!(decoded(path).as_deref(), Some(text), "{path}");
        }
        for path in ["/%", "/%2", "/%+1", "/%zz", "/%ff", "/a%00b", "/a%5Cb"] {
            assert_eq!(decoded(path), None, "{path}");
        }
    }
}
