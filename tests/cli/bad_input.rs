//! Input that is refused: exit code 2, a message that says what, where and what is allowed, and no file.

use super::*;

/// Expects exit code 2, all words in the message, no panic and no file in `out`.
fn assert_refused(run: &Output, out: &Path, words: &[&str]) {
    let said = stderr(run);
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    for word in words {
        assert!(said.contains(word), "{word:?} is missing in: {said}");
    }
    assert_eq!(stdout(run), "");
    assert!(files_below(out).is_empty(), "{:?}", files_below(out));
}

/// Expects that `check` and `run` refuse a machine alike.
fn refused(mill: &Mill, words: &[&str]) {
    let (folder, cache) = (tempfile::tempdir().unwrap(), copied_cache());
    let out = folder.path().join("out");
    let check = stiffmap(cache.path()).arg("check").arg(mill.0.path()).output().unwrap();
    assert_refused(&check, &out, words);
    let mut run = stiffmap(cache.path());
    run.arg("run").arg(mill.0.path()).arg("--out").arg(&out);
    assert_refused(&run.output().unwrap(), &out, words);
}

/// Lines of a mesh file with one block's data lines replaced.
fn with_block(text: &str, keyword: &str, lines: &[&str]) -> String {
    let mut inside = false;
    let mut kept = Vec::new();
    for line in text.lines() {
        if line.starts_with('*') {
            inside = line.starts_with(keyword);
            kept.push(line);
            if inside {
                kept.extend(lines);
            }
        } else if !inside {
            kept.push(line);
        }
    }
    assert!(text.contains(keyword), "no {keyword}");
    kept.join("\n") + "\n"
}

#[test]
fn the_unchanged_mill_is_accepted() {
    let mill = Mill::new();
    let cache = tempfile::tempdir().unwrap();
    let check = stiffmap(cache.path()).arg("check").arg(mill.0.path()).output().unwrap();
    assert_eq!(check.status.code(), Some(0), "{}", stderr(&check));
}

#[test]
fn a_missing_machine_file() {
    let (folder, cache) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let out = folder.path().join("out");
    let run = stiffmap(cache.path()).args(["run", "no_such_machine.toml", "--out"]).arg(&out).output().unwrap();
    assert_refused(&run, &out, &["no_such_machine.toml", "cannot read the machine file"]);
}

#[test]
fn a_missing_mesh() {
    let mill = Mill::new();
    std::fs::remove_file(mill.file("magazine.inp")).unwrap();
    refused(&mill, &["machine.toml:", "parts.magazine.mesh", "magazine.inp does not exist"]);
}

#[test]
fn a_misspelt_mesh_names_the_nearest() {
    let mill = Mill::new();
    mill.replace("machine.toml", "\"magazine.inp\"", "\"magazin.inp\"");
    refused(&mill, &["parts.magazine.mesh", "magazin.inp does not exist", "did you mean `magazine.inp`"]);
}

#[test]
fn a_truncated_mesh() {
    let mill = Mill::new();
    mill.edit("magazine.inp", |text| text[..60_000].to_owned());
    refused(&mill, &["magazine.inp:", "*NODE", "allowed"]);
    // Cut between two lines of the elements: the sets and the material are missing.
    let mill = Mill::new();
    mill.edit("magazine.inp", |text| text[..text.find("*NSET, NSET=PAD").unwrap()].to_owned());
    refused(&mill, &["magazine.inp"]);
}

#[test]
fn an_inverted_element() {
    let mill = Mill::new();
    mill.edit("magazine.inp", |text| {
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        let at = 1 + lines.iter().position(|l| l.starts_with("*ELEMENT")).unwrap();
        let mut labels: Vec<&str> = lines[at].split(',').map(str::trim).collect();
        labels.swap(1, 2);
        lines[at] = labels.join(", ");
        lines.join("\n") + "\n"
    });
    refused(&mill, &["part \"magazine\"", "element 762", "inverted", "Jacobian", "order of its nodes"]);
}

#[test]
fn a_node_set_that_makes_no_face() {
    let mill = Mill::new();
    mill.edit("magazine.inp", |text| with_block(&text, "*NSET, NSET=PAD", &["1, 2"]));
    refused(&mill, &["part \"magazine\"", "interface \"pad\"", "2 nodes", "\"PAD\"", "face"]);
}

#[test]
fn a_joint_that_names_a_missing_interface() {
    let mill = Mill::new();
    mill.replace("machine.toml", "column.magazine_pad", "column.magazine_pat");
    refused(
        &mill,
        &["machine.toml:", "\"magazine bolts\"", "magazine_pat", "did you mean `magazine_pad`", "rail_left"],
    );
}

#[test]
fn a_carriage_that_leaves_its_rail() {
    let mill = Mill::new();
    mill.replace("machine.toml", "\"-600 mm\"", "\"-900 mm\"");
    refused(&mill, &["\"guide A\"", "position -0.", "leaves the rail", "shorten the travel or the footprint"]);
}

#[test]
fn a_part_without_any_joint() {
    let mill = Mill::new();
    mill.edit("machine.toml", |text| {
        let from = text.find("[[joints]]\nname = \"magazine bolts\"").unwrap();
        let to = text.find("# ---- Ports").unwrap();
        format!("{}{}", &text[..from], &text[to..])
    });
    refused(&mill, &["machine.toml", "magazine", "joint"]);
}

#[test]
fn a_density_that_is_negative_or_no_number() {
    let material =
        "mesh = \"magazine.inp\"\nmaterial = { young = \"115 GPa\", poisson = 0.26, density = \"-7200 kg/m3\" }";
    let mill = Mill::new();
    mill.replace("machine.toml", "mesh = \"magazine.inp\"", material);
    refused(&mill, &["machine.toml:", "parts.magazine.material.density", "-7200 kg/m3", "positive"]);
    for (value, allowed) in [("-7850", "positive"), ("nan", "finite")] {
        let mill = Mill::new();
        mill.edit("magazine.inp", |text| with_block(&text, "*DENSITY", &[value]));
        refused(&mill, &["magazine.inp:", "*DENSITY", value, allowed]);
    }
}

#[test]
fn a_coordinate_that_is_no_number() {
    let mill = Mill::new();
    mill.replace("magazine.inp", "1, -0.35, 0.3, 1.44", "1, -0.35, NaN, 1.44");
    refused(&mill, &["magazine.inp:", "*NODE", "NaN", "finite"]);
}

#[test]
fn a_setting_that_is_no_number() {
    let mill = Mill::new();
    mill.replace("machine.toml", "ratio = 0.02", "ratio = nan");
    refused(&mill, &["machine.toml:", "analysis.damping.ratio", "nan", "not finite"]);
}

#[test]
fn an_unknown_key_with_the_nearest_known_one() {
    let mill = Mill::new();
    mill.replace("machine.toml", "footprint = \"90 mm\"", "footprint = \"90 mm\"\ndampin = 1");
    refused(&mill, &["machine.toml:", "\"guide A\"", "unknown key `dampin`", "did you mean `damping`", "allowed here"]);
    let mill = Mill::new();
    mill.replace("machine.toml", "stiffness = { x", "stifness = { x");
    refused(&mill, &["machine.toml:", "\"guide A\"", "`stiffness`", "`stifness`"]);
}

#[test]
fn a_travel_with_step_zero() {
    let mill = Mill::new();
    mill.replace("machine.toml", "step = \"5 mm\"", "step = 0");
    refused(&mill, &["machine.toml:", "axes.z.step", "found 0", "positive"]);
}

#[test]
fn text_that_is_no_toml() {
    let mill = Mill::new();
    mill.edit("machine.toml", |text| text + "[parts.empty\n");
    refused(&mill, &["machine.toml:", "not valid TOML"]);
}

#[test]
fn command_line_values_that_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let cases: [(&[&str], &[&str]); 23] = [
        (&["--position", "-0.7"], &["--positions", "-0.7 m", "outside the travel", "-0.6 m"]),
        (&["--position", "0.1"], &["--positions", "0.1 m", "outside the travel"]),
        (&["--positions", "0,-0.3,0"], &["--positions", "given twice"]),
        (&["--positions", "0:-0.6"], &["--positions", "0:-0.6", "from:to:step"]),
        (&["--positions", "0:-0.6:0"], &["--positions", "step", "0"]),
        (&["--positions", "0,nan"], &["--positions", "\"nan\"", "not a number"]),
        (&["--positions", "top"], &["--positions", "\"top\"", "not a number"]),
        (&["--positions", ""], &["--positions"]),
        (&["--frequencies", "-5,10"], &["--frequencies", "-5 Hz", "negative"]),
        (&["--frequencies", "-5:10:5"], &["--frequencies", "-5 Hz", "negative"]),
        (&["--frequencies", "10,5"], &["--frequencies", "5 Hz follows 10 Hz", "ascend"]),
        (&["--frequencies", "0:1e9:0.001"], &["--frequencies", "at most"]),
        (&["--frequencies", "log:1:900:5"], &["--frequencies", "\"log\" is no grid", "logarithmic:1:900:500"]),
        (&["--frequencies", "logarithmic:0:900:5"], &["--frequencies", "from 0 to 900 Hz", "0 < from < to"]),
        (&["--frequencies", "logarithmic:1:900"], &["--frequencies", "has 2 of the three numbers"]),
        (&["--frequencies", "logarithmic:1:900:1.5"], &["--frequencies", "count is 1.5", "whole number from 2"]),
        (&["--frequencies", "clustered:900:0"], &["--frequencies", "from 900 to 0 Hz", "0 <= from < to"]),
        (&["--frequencies", "clustered:0:900:0"], &["--frequencies", "frequencies a mode is 0", "from 1 to 1000"]),
        (&["--quantity", "stiffness"], &["--quantity", "\"stiffness\"", "receptance, mobility, accelerance"]),
        (&["--map-memory", "large"], &["--map-memory", "\"large\" is no size", "512MB"]),
        (&["--damping", "-0.02"], &["--damping", "-0.02"]),
        (&["--modes", "0"], &["--modes", "0 is not allowed"]),
        (&["--backend", "tpu"], &["--backend", "tpu", "auto", "cpu", "gpu"]),
    ];
    for (arguments, words) in cases {
        let run = run_into(folder.path(), &out, arguments);
        assert_refused(&run, &out, words);
    }
}

#[test]
fn an_unknown_subcommand_or_flag() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let cases: [(&[&str], &[&str]); 3] =
        [(&["rum"], &["rum", "run"]), (&["run", "--positon", "0"], &["--positon", "--position"]), (&[], &["Usage"])];
    for (arguments, words) in cases {
        let run = stiffmap(folder.path()).args(arguments).output().unwrap();
        assert_refused(&run, &out, words);
    }
}

#[test]
fn more_positions_than_a_state_space_file_holds() {
    let out = tempfile::tempdir().unwrap();
    let run = run_into(warm_cache(), out.path(), &["--positions", "0:-0.6:0.000005"]);
    let said = stderr(&run);
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(said.contains("120001 positions of 30 modes") && said.contains("state_space.mat"), "{said}");
    assert!(!said.contains("modes   "), "before the long computation: {said}");
    assert!(files_below(out.path()).is_empty());
}
