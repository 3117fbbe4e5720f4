//! The house's order: what may use what, how long a file may be, and that every shader is tested.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The way of the data; a module uses only what stands before it.
const ORDER: [&str; 21] = [
    "interrupt",
    "files",
    "resources",
    "machine",
    "linalg",
    "matrix",
    "mesh",
    "element",
    "solid",
    "plausible",
    "reduction",
    "coupling",
    "modal",
    "state_space",
    "frf",
    "gpu",
    "response",
    "sweep",
    "export",
    "figures",
    "pipeline",
];
const LONGEST: usize = 400;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files below a folder that end so, relative to the repository.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { walk(&path, found) } else { found.push(path) }
        }
    }
    let mut found = Vec::new();
    walk(&root().join(folder), &mut found);
    found.retain(|f| f.extension().is_some_and(|e| e == extension));
    found.sort();
    assert!(!found.is_empty(), "no .{extension} file below {folder}");
    found.iter().map(|f| f.strip_prefix(root()).unwrap().to_path_buf()).collect()
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(root().join(file)).unwrap()
}

/// The module of the library that a source file belongs to: `src/frf/grid.rs` to `frf`.
fn module(file: &Path) -> String {
    let first = file.components().nth(1).unwrap().as_os_str();
    Path::new(first).file_stem().unwrap().to_string_lossy().into_owned()
}

/// A source's lines without their comments.
fn code(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or(line));
    lines.collect::<Vec<_>>().join("\n")
}

/// Modules that a source names by `crate::`, one by one or in braces.
fn used(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let name = |s: &str| s.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    for rest in code(text).split("crate::").skip(1) {
        if let Some(list) = rest.strip_prefix('{') {
            let mut depth = 1;
            let mut start = 0;
            for (i, c) in list.char_indices() {
                match c {
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    _ => {}
                }
                if (c == ',' && depth == 1) || depth == 0 {
                    found.insert(name(&list[start..i]));
                    start = i + 1;
                }
                if depth == 0 {
                    break;
                }
            }
        } else {
            found.insert(name(rest));
        }
    }
    found.remove("");
    found
}

/// Why a source of a module may not use what it uses.
fn violations(module: &str, text: &str) -> Vec<String> {
    let place = |name: &str| ORDER.iter().position(|m| *m == name);
    let own = place(module);
    let wrong = |name: &String| match (place(name), own) {
        (Some(other), Some(own)) if other > own => Some(format!("{module} uses {name}, which stands below it")),
        _ => None,
    };
    used(text).iter().filter_map(wrong).collect()
}

fn library() -> Vec<PathBuf> {
    let outside = ["lib", "main", "cli"];
    files("src", "rs").into_iter().filter(|f| !outside.contains(&&*module(f))).collect()
}

#[test]
fn a_module_uses_only_what_stands_above_it() {
    for file in library() {
        let module = module(&file);
        assert!(ORDER.contains(&&*module), "{}: give `{module}` its place in the order", file.display());
        let wrong = violations(&module, &read(&file));
        assert!(wrong.is_empty(), "{}: {wrong:?}", file.display());
    }
}

#[test]
fn negative_control_a_use_against_the_order_is_noticed() {
    assert_eq!(violations("frf", "use crate::modal::Modes;"), Vec::<String>::new());
    assert_eq!(violations("frf", "// crate::gpu in words"), Vec::<String>::new());
    assert_eq!(violations("frf", "use crate::gpu::Gpu;").len(), 1);
    assert_eq!(violations("frf", "use crate::{modal::{Modes, track}, export, figures::draw};").len(), 2);
    assert_eq!(violations("linalg", "fn f(x: crate::solid::Mesh) {}").len(), 1);
}

#[test]
fn the_library_lists_its_modules_in_the_order() {
    let text = read(Path::new("src/lib.rs"));
    let listed: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    let mut expected = ORDER.to_vec();
    expected.sort_unstable();
    let mut found = listed.clone();
    found.sort_unstable();
    assert_eq!(found, expected);
}

#[test]
fn only_linalg_names_the_solvers() {
    let names = ["faer", "metis_sys"];
    let names_one = |text: &str| {
        let text = code(text);
        let mut words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        words.any(|word| names.contains(&word))
    };
    let with: Vec<PathBuf> = files("src", "rs").into_iter().filter(|f| names_one(&read(f))).collect();
    assert!(!with.is_empty(), "linalg itself is not noticed");
    for file in with {
        assert!(file.starts_with("src/linalg"), "{} names a solver; only src/linalg does", file.display());
    }
}

#[test]
fn anyhow_stays_with_the_command_line() {
    for file in library() {
        assert!(!code(&read(&file)).contains("anyhow"), "{}: a library's error is its module's enum", file.display());
    }
}

#[test]
fn no_file_is_too_long() {
    let sources = [("src", "rs"), ("tests", "rs"), ("benches", "rs"), ("shaders", "wgsl")];
    for file in sources.iter().flat_map(|(folder, extension)| files(folder, extension)) {
        let lines = read(&file).lines().count();
        assert!(lines <= LONGEST, "{}: {lines} lines, at most {LONGEST}; look for the seam", file.display());
    }
}

#[test]
fn every_shader_has_its_twin_and_its_tests() {
    let stems = files("shaders", "wgsl").into_iter().filter(|f| !f.starts_with("shaders/shared"));
    let tests: Vec<PathBuf> =
        files("tests", "rs").into_iter().filter(|f| *f != Path::new("tests/architecture.rs")).collect();
    for stem in stems {
        let stem = stem.file_stem().unwrap().to_string_lossy().into_owned();
        for room in ["frf", "gpu"] {
            let file = format!("src/{room}/{stem}.rs");
            assert!(root().join(&file).exists(), "shaders/{stem}.wgsl has no {file}");
        }
        let device = |text: &str| text.contains("Gpu::open") || text.contains("device()");
        let tested = tests.iter().map(|f| read(f)).any(|text| text.contains(&stem) && device(&text));
        assert!(tested, "shaders/{stem}.wgsl has no test on a device");
    }
}
