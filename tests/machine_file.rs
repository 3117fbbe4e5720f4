//! The machine file: what is read, and what is refused.
use std::path::Path;
#[test]
fn bundled() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/vertical_mill");
    let m = stiffmap::machine::read_machine(&folder)
        .map_err(|e| e.to_string())
        .unwrap();
    println!("{m:#?}");
}
