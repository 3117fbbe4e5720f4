//! What a signal handler does to the files being written; alone in its process, since it removes
//! the temporaries of all writers.

use std::io::Write;

use stiffmap::export::atomic;

#[test]
fn an_interrupted_write_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file.txt");
    let result = atomic::write_atomic(&file, |w| {
        w.write_all(&[b'x'; 1 << 20]).map_err(atomic::io(&file, "write"))?;
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "the temporary");
        atomic::remove_temporaries().unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        Ok(())
    });
    assert!(result.is_err(), "the rename must notice");
    assert!(!file.exists());
}
