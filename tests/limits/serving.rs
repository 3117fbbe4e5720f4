//! `view --serve` with slow clients, odd paths and large files.

use super::*;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::Duration;

struct Server {
    child: Child,
    port: u16,
    folder: tempfile::TempDir,
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended by itself, which its test has seen.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Server {
    fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("report.html"), "<p>the page</p>").unwrap();
        // A folder without manifest holds no whole result and is not served.
        std::fs::write(folder.path().join("manifest.json"), "{}").unwrap();
        std::fs::write(folder.path().join("two words.csv"), "1,2\n").unwrap();
        // A folder with a manifest is that of a job that has ended.
        std::fs::write(folder.path().join("manifest.json"), "{}").unwrap();
        // 600 MB that take no disk.
        std::fs::File::create(folder.path().join("large.npy")).unwrap().set_len(600_000_000).unwrap();
        let mut command = program();
        command.arg("view").arg(folder.path()).arg("--serve").stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let port = line.trim().trim_end_matches('/').rsplit(':').next().unwrap().parse().unwrap();
        Self { child, port, folder }
    }

    fn ask(&self, target: &str) -> TcpStream {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        write!(stream, "GET {target} HTTP/1.1\r\nHost: localhost:{}\r\n\r\n", self.port).unwrap();
        stream
    }

    fn answer(&self, target: &str) -> String {
        let mut text = String::new();
        self.ask(target).read_to_string(&mut text).unwrap();
        text
    }

    /// Largest memory held so far, kB.
    fn memory(&self) -> Option<u64> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
        line.trim().strip_suffix("kB")?.trim().parse().ok()
    }
}

#[test]
fn names_with_spaces_are_found_and_ways_out_of_the_folder_are_not() {
    let server = Server::start();
    let secret = server.folder.path().with_extension("secret");
    std::fs::write(&secret, "secret").unwrap();
    assert!(server.answer("/").ends_with("<p>the page</p>"));
    assert!(server.answer("/two%20words.csv").ends_with("1,2\n"));
    let name = secret.file_name().unwrap().to_string_lossy().into_owned();
    for way in ["/../", "/%2e%2e/", "/..%2f", "/%2e%2e%2f", "/./../", "/x/../../"] {
        let answer = server.answer(&format!("{way}{name}"));
        assert!(answer.starts_with("HTTP/1.1 404") && !answer.contains("secret\n"), "{way}: {answer}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, server.folder.path().join("link.csv")).unwrap();
        assert!(server.answer("/link.csv").starts_with("HTTP/1.1 404"));
    }
    std::fs::remove_file(secret).unwrap();
}

#[test]
#[cfg(target_os = "linux")]
fn ten_stalled_clients_of_a_large_file_take_no_memory_and_stop_nobody() {
    let server = Server::start();
    let before = server.memory().unwrap();
    let mut stalled: Vec<TcpStream> = (0..10).map(|_| server.ask("/large.npy")).collect();
    // Each has begun to receive, so that the server is at work on all of them.
    for stream in &mut stalled {
        stream.read_exact(&mut [0; 1000]).unwrap();
    }
    assert!(server.answer("/").ends_with("<p>the page</p>"));
    let after = server.memory().unwrap();
    assert!(after < before + 40_000, "{before} to {after} kB for ten times 600 MB");
    // Control: the file does come whole to one who takes it.
    let mut bytes = 0;
    let mut stream = server.ask("/large.npy");
    let mut piece = vec![0; 1 << 20];
    while let Ok(n @ 1..) = stream.read(&mut piece) {
        bytes += n;
    }
    assert!(bytes > 600_000_000, "{bytes} bytes");
}

#[test]
fn a_client_that_asks_too_slowly_is_let_go() {
    let server = Server::start();
    let mut stream = TcpStream::connect(("127.0.0.1", server.port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    // A byte now and then would keep a time limit for each read alive for ever.
    let mut ended = false;
    for _ in 0..30 {
        std::thread::sleep(Duration::from_millis(300));
        if stream.write_all(b"G").is_err() {
            ended = true;
            break;
        }
    }
    assert!(ended, "the server still listens after nine seconds");
    assert!(server.answer("/").ends_with("<p>the page</p>"));
}
