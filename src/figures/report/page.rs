//! The page's one file, put together from its pieces.

use super::{Database, ReportError};
use crate::export::{atomic, base64};
use crate::gpu::shader::{Kernel, Precision, Variant};
use std::path::Path;

/// Name of the page in a result folder.
pub const PAGE_FILE: &str = "report.html";
/// Name of the modal database in a result folder.
pub const DATABASE_FILE: &str = "modal_database.bin";

/// The page's own scripts, in the order in which they are read; the first six run in workers too.
const SCRIPTS: [&str; 16] = [
    include_str!("page/database.js"),
    include_str!("page/eigen.js"),
    include_str!("page/machine.js"),
    include_str!("page/exact.js"),
    include_str!("page/sum.js"),
    include_str!("page/worker.js"),
    include_str!("page/gpu.js"),
    include_str!("page/engine.js"),
    include_str!("page/colours.js"),
    include_str!("page/scene.js"),
    include_str!("page/surface.js"),
    include_str!("page/shapes.js"),
    include_str!("page/curves.js"),
    include_str!("page/tables.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
];
/// Scripts that a worker reads.
const IN_WORKERS: usize = 6;

/// The page as text.
///
/// `manifest` is the run's manifest as JSON.
pub fn page(database: &Database, manifest: &str) -> String {
    let bytes = database.bytes();
    let pieces = [
        ("{{title}}", escape(&database.header.machine)),
        ("{{style}}", include_str!("page/style.css").to_owned()),
        ("{{uplot.css}}", include_str!("../../../assets/web/uPlot.min.css").to_owned()),
        ("{{three.js}}", include_str!("../../../assets/web/three.bundle.min.js").to_owned()),
        ("{{uplot.js}}", include_str!("../../../assets/web/uPlot.iife.min.js").to_owned()),
        // The page asks for one pair at a time.
        ("{{modal_sum.wgsl}}", Variant::new(Kernel::ModalSum, Precision::F32, 1).source()),
        ("{{manifest}}", manifest.replace("</", "<\\/")),
        ("{{database}}", base64::encode(&bytes)),
        ("{{checksum}}", format!("{:08x}", checksum(&bytes))),
        ("{{worker.js}}", SCRIPTS[..IN_WORKERS].join("\n")),
        ("{{page.js}}", SCRIPTS[IN_WORKERS..].join("\n")),
    ];
    let mut rest = include_str!("page/index.html");
    let mut text = String::with_capacity(8 << 20);
    // One pass: what a piece holds is never searched.
    while let Some(start) = rest.find("{{") {
        let (before, from) = rest.split_at(start);
        text.push_str(before);
        let piece = pieces.iter().find(|(name, _)| from.starts_with(name));
        let (name, content) = piece.expect("the template names its pieces");
        text.push_str(content);
        rest = &from[name.len()..];
    }
    text + rest
}

/// Writes [`page`] to a file.
///
/// # Errors
/// [`ReportError::Export`].
pub fn write_page(path: &Path, database: &Database, manifest: &str) -> Result<(), ReportError> {
    Ok(atomic::write_bytes(path, page(database, manifest).as_bytes())?)
}

/// FNV-1a, by which the page knows that its database is whole: each step is a bijection, so one changed byte always
/// changes the sum.
fn checksum(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0x811c_9dc5, |sum, byte| (sum ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
