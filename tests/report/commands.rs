//! `stiffmap figures` and `stiffmap view` on a result folder.

use crate::{folder, mill};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_stiffmap"))
}

fn copy(names: &[&str], to: &Path) {
    for name in names {
        std::fs::copy(mill().join(name), to.join(name)).unwrap();
    }
}

#[test]
fn figures_draws_the_same_pictures_and_page_from_the_folder_alone() {
    let again = folder("again");
    copy(&["modal_database.bin", "manifest.json"], &again);
    let run = program().arg("figures").arg(&again).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let names: Vec<_> = std::fs::read_dir(mill().join("figures")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 18, "nine pictures, PNG and SVG: {names:?}");
    for name in &names {
        let read = |folder: &Path| std::fs::read(folder.join("figures").join(name)).unwrap();
        assert!(read(mill()) == read(&again), "{name:?} differs");
    }
    for name in ["surface_xx.vts", "surface_zz.vts"] {
        let read = |folder: &Path| std::fs::read(folder.join(name)).unwrap();
        // The map of a device differs by rounding; its header and size do not.
        assert_eq!(read(mill()).len(), read(&again).len(), "{name}");
    }
    let page = std::fs::read_to_string(again.join("report.html")).unwrap();
    assert!(page.contains("id=\"database\"") && page.ends_with("</html>\n"));
    let other = program().arg("figures").arg(&again).arg("--logarithmic").output().unwrap();
    assert!(other.status.success());
    let read = |folder: &Path| std::fs::read(folder.join("figures/frf_xx_amplitude.png")).unwrap();
    assert!(read(mill()) != read(&again), "control: other heights, another picture");
}

#[test]
fn a_folder_without_a_database_or_with_a_broken_one_is_refused() {
    let empty = folder("empty");
    for command in ["figures", "view"] {
        let run = program().arg(command).arg(&empty).output().unwrap();
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(2), "{said}");
        assert!(said.contains("stiffmap run") && said.contains(empty.to_str().unwrap()), "{said}");
    }
    let bytes = std::fs::read(mill().join("modal_database.bin")).unwrap();
    std::fs::copy(mill().join("manifest.json"), empty.join("manifest.json")).unwrap();
    for (broken, reason) in
        [(&bytes[1..], "first bytes"), (&bytes[..1000], "damaged"), (&bytes[..bytes.len() / 4], "damaged")]
    {
        std::fs::write(empty.join("modal_database.bin"), broken).unwrap();
        let run = program().arg("figures").arg(&empty).output().unwrap();
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(2), "{said}");
        assert!(said.contains("modal_database.bin") && said.contains(reason), "{reason}: {said}");
    }
    assert!(!empty.join("figures").exists() && !empty.join("report.html").exists());
}

/// The status line and the length of the body of a request.
fn ask(port: u16, request: &str) -> (String, usize) {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let split = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
    let head = String::from_utf8_lossy(&answer[..split]).into_owned();
    (head.lines().next().unwrap().to_string(), answer.len() - split - 4)
}

#[test]
fn view_serves_the_folder_on_the_loopback_address_alone() {
    let mut server = program().arg("view").arg(mill()).arg("--serve").stdout(Stdio::piped()).spawn().unwrap();
    let mut said = String::new();
    let mut out = std::io::BufReader::new(server.stdout.take().unwrap());
    std::io::BufRead::read_line(&mut out, &mut said).unwrap();
    let port: u16 = said.trim().strip_prefix("http://127.0.0.1:").unwrap().trim_end_matches('/').parse().unwrap();
    let get = |path: &str| ask(port, &format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"));
    let size = |name: &str| std::fs::metadata(mill().join(name)).unwrap().len() as usize;
    assert_eq!(get("/"), ("HTTP/1.1 200 OK".into(), size("report.html")));
    assert_eq!(get("/manifest.json?x=1").1, size("manifest.json"));
    assert!(get("/figures/eigenfrequencies.svg").0.contains("200"));
    for outside in ["/../../../Cargo.toml", "//etc/passwd", "/figures/../../mill/../../../Cargo.toml", "/nothing"] {
        assert!(get(outside).0.contains("404"), "{outside}");
    }
    assert!(ask(port, "POST / HTTP/1.1\r\nHost: localhost:1\r\n\r\n").0.contains("421"));
    assert!(ask(port, &format!("GET / HTTP/1.1\r\nHost: evil.example:{port}\r\n\r\n")).0.contains("421"));
    assert!(ask(port, &format!("DELETE / HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n")).0.contains("405"));
    let head = ask(port, &format!("HEAD / HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n"));
    assert!(head.0.contains("200") && head.1 == 0);
    // Nothing listens on this machine's other addresses.
    assert!(TcpStream::connect(("127.0.0.2", port)).is_err());
    server.kill().unwrap();
    server.wait().unwrap();
}
