//! Outputs that are no plain files are written through, or refused with the reason.

use super::*;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::process::Stdio;

#[test]
fn devices_pipes_and_links_stay_what_they_are() {
    let room = Room::new();
    let export = |out: &'static str| ["export", ".", "--format", "inp", "--out", out];
    room.done(&export("plain.inp"));
    let expected = room.read("plain.inp");
    assert!(expected.len() > 1000);

    room.done(&export("/dev/null"));
    assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());

    assert!(Command::new("mkfifo").arg(room.path("pipe")).status().unwrap().success());
    let mut reader = Command::new("cat").arg(room.path("pipe")).stdout(Stdio::piped()).spawn().unwrap();
    let mut through = reader.stdout.take().unwrap();
    let taken = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut through, &mut bytes).map(|_| bytes)
    });
    room.done(&export("pipe"));
    assert!(reader.wait().unwrap().success());
    assert!(taken.join().unwrap().unwrap() == expected, "the pipe gives the bytes of the file");
    assert!(std::fs::metadata(room.path("pipe")).unwrap().file_type().is_fifo());

    room.write("elsewhere/target.inp", "old");
    symlink(room.path("elsewhere/target.inp"), room.path("link.inp")).unwrap();
    room.done(&export("link.inp"));
    assert!(std::fs::symlink_metadata(room.path("link.inp")).unwrap().is_symlink(), "the link stays");
    assert!(room.read("elsewhere/target.inp") == expected, "and leads to the new content");
    assert_eq!(room.files("elsewhere"), ["target.inp"], "nothing written aside is left");

    let stdout = room.run(&export("/dev/stdout"));
    assert!(stdout.stdout == expected, "{} bytes", stdout.stdout.len());
}

#[test]
fn what_cannot_be_written_through_is_refused_and_stays() {
    let room = Room::new();
    symlink(room.path("nowhere.inp"), room.path("lost.inp")).unwrap();
    let _socket = std::os::unix::net::UnixListener::bind(room.path("socket")).unwrap();
    for (out, reason) in [("lost.inp", "leads nowhere"), ("bed", "it is a folder"), ("socket", "neither a plain file")]
    {
        let output = room.run(&["export", ".", "--format", "inp", "--out", out]);
        assert_eq!(output.status.code(), Some(1), "{out}");
        assert!(said(&output).contains(out) && said(&output).contains(reason), "{out}: {}", said(&output));
    }
    assert!(std::fs::symlink_metadata(room.path("lost.inp")).unwrap().is_symlink());
    assert!(std::fs::metadata(room.path("socket")).unwrap().file_type().is_socket());
}
