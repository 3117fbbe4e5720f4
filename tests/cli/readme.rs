//! The commands that the documents promise: each `sh` block under `<!-- tested -->` is run.

use super::*;

/// The commands of the marked blocks, in order.
fn tested_commands(text: &str) -> Vec<String> {
    let mut commands = Vec::new();
    let (mut marked, mut inside) = (false, false);
    for line in text.lines().map(str::trim) {
        if inside {
            inside = line != "```";
            let is_command = line.starts_with("stiffmap ") || line.starts_with("cargo run --release -- ");
            if inside && is_command {
                commands.push(line.to_owned());
            }
        } else {
            inside = marked && line == "```sh";
            marked = line == "<!-- tested -->";
        }
    }
    commands
}

/// A command's arguments for the built binary; a comment at its end does not count.
fn arguments(command: &str) -> Vec<&str> {
    let command = command.split(" #").next().unwrap_or(command);
    let after = command.strip_prefix("cargo run --release -- ").or_else(|| command.strip_prefix("stiffmap "));
    after.unwrap_or_else(|| panic!("{command}")).split_whitespace().collect()
}

fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = vec![root.join("README.md")];
    let docs = files_below(&root.join("docs")).into_iter().map(|f| root.join("docs").join(f));
    found.extend(docs.filter(|f| f.extension().is_some_and(|e| e == "md")));
    found
}

#[test]
fn every_tested_command_of_the_documents_works() {
    let mut run = 0;
    for document in documents() {
        let text = std::fs::read_to_string(&document).unwrap_or_else(|e| panic!("{}: {e}", document.display()));
        // The commands of one document build on each other.
        let folder = tempfile::tempdir().unwrap();
        for command in tested_commands(&text) {
            let mut program = stiffmap(warm_cache());
            let output = program.args(arguments(&command)).current_dir(folder.path()).output().unwrap();
            let place = document.file_name().unwrap_or_default().to_string_lossy();
            assert_eq!(output.status.code(), Some(0), "{place}: {command}: {}", stderr(&output));
            run += 1;
        }
    }
    assert!(run >= 3, "only {run} commands stand under <!-- tested -->");
}

#[test]
fn only_marked_blocks_count() {
    let text = "```sh\nstiffmap run\n```\n<!-- tested -->\n```sh\n$ ls\nstiffmap check  # says\n```\nstiffmap init\n\
                <!-- tested -->\n\n```sh\nstiffmap devices\n```\n<!-- tested -->\n```sh\ncargo run --release -- run --out a\n```\n";
    let commands = tested_commands(text);
    assert_eq!(commands, ["stiffmap check  # says", "cargo run --release -- run --out a"]);
    assert_eq!(arguments(&commands[0]), ["check"]);
    assert_eq!(arguments(&commands[1]), ["run", "--out", "a"]);
}
