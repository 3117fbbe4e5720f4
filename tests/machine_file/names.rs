//! The file itself, its keys and its names.

use super::*;

#[test]
fn a_missing_file_and_a_folder_without_one_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let message = read_machine(folder.path()).unwrap_err().to_string();
    assert!(message.contains("machine.toml") && message.contains("stiffmap init"), "{message}");
    let message = read_machine(&folder.path().join("mill.toml")).unwrap_err().to_string();
    assert!(message.contains("mill.toml: cannot read"), "{message}");
    std::fs::write(folder.path().join("machine.toml"), [0xff, 0xfe]).unwrap();
    let message = read_machine(folder.path()).unwrap_err().to_string();
    assert!(message.contains("UTF-8"), "{message}");
}

#[test]
fn a_slip_of_toml_is_refused_with_line_and_column() {
    refused("name = \"a\"\nunits = \n", &["machine.toml:2:", "not valid TOML"]);
    refused("name = \"a\"\nname = \"b\"\n", &["machine.toml:2:1", "duplicate key"]);
}

#[test]
fn unknown_keys_are_refused_with_the_nearest_known_one() {
    refused_change("footprint =", "fotprint =", &["joints[1] \"guide\"", "`footprint` is missing", "`fotprint`"]);
    refused_change(
        "modes = 30",
        "mods = 30",
        &["analysis", "unknown key `mods`", "did you mean `modes`?", "frequencies"],
    );
    refused_change(
        "{ ratio = 0.02 }",
        "{ ratio = 0.02, colour = 1 }",
        &["analysis.damping: unknown key `colour`;", "ratio, ratios, rayleigh, loss_factor"],
    );
    refused_change(
        "[analysis]",
        "[analisys]\nmodes = 1\n[analysis]",
        &["unknown key `analisys`", "did you mean `analysis`?"],
    );
    refused_change("y = 77e6", "Y = 77e6", &["joints[1] \"guide\".stiffness", "unknown key `Y`", "`y`"]);
    refused_change(
        "nodes = \"RAIL\"",
        "nodes = \"RAIL\", couplng = \"rigid\"",
        &["parts.column.interfaces.rail", "did you mean `coupling`?"],
    );
}

#[test]
fn missing_keys_are_refused_with_what_to_add() {
    for (line, key) in [
        ("name = \"small mill\"", "name"),
        ("direction = [0, 0, 2]", "direction"),
        ("travel = [\"0 mm\", \"-100 mm\"]", "travel"),
        ("step = \"5 mm\"", "step"),
        ("moves = [\"head\"]", "moves"),
        ("mesh = \"column.inp\"", "mesh"),
        ("rail = \"column.rail\"", "rail"),
        ("carriage = \"head.carriage\"", "carriage"),
        ("footprint = \"90 mm\"", "footprint"),
        ("type = \"ball-screw\"", "type"),
        ("between = [\"column.mount\", \"head.nut\"]", "between"),
        ("young = \"210 GPa\"", "young"),
        ("interface = \"head.tip\"", "interface"),
        ("damping = { ratio = 0.02 }", "damping"),
        ("frequencies = { from = \"0 Hz\", to = \"10 Hz\", step = \"1 Hz\" }", "frequencies"),
    ] {
        refused_change(line, "", &[&format!("the key `{key}` is missing"), "; add "]);
    }
    refused_change(
        "stiffness = { x = \"77 N/um\", y = 77e6 }\ndamping = { x = \"100 N s/m\" }",
        "",
        &["`stiffness` is missing"],
    );
}

#[test]
fn values_of_the_wrong_type_are_refused() {
    refused_change("name = \"small mill\"", "name = 3", &["name: found 3", "a text in quotes"]);
    refused_change("modes = 30", "modes = 2.5", &["analysis.modes: found 2.5", "whole number"]);
    refused_change("modes = 30", "modes = 0", &["analysis.modes: found 0", "at least 1"]);
    refused_change("moves = [\"head\"]", "moves = \"head\"", &["axes.z.moves: found \"head\"", "a list"]);
    refused_change("component = { modes = 50 }", "component = 50", &["analysis.component: found 50", "a table"]);
    refused_change("{ modes = 50 }", "{ second_moment = \"yes\" }", &["second_moment: found \"yes\"", "true or false"]);
    refused_change(
        "{ modes = 50 }",
        "{ method = \"guyan\" }",
        &["found \"guyan\"", "\"craig-bampton\" or \"free-interface\""],
    );
    refused_change("[0, 0, 2]", "[0, 0, 0]", &["axes.z.direction: found [0, 0, 0]", "not zero"]);
    refused_change("[0, 0, 2]", "[0, 1]", &["give 3 values, not 2"]);
    refused_change(
        "axis = \"z\"\nyoung",
        "axis = \"w\"\nyoung",
        &["joints[2] \"screw\".axis: found \"w\"", "\"x\", \"y\", \"z\""],
    );
    refused_change("name = \"small mill\"", "name = \"a/b\"", &["the name \"a/b\"", "letters"]);
}

#[test]
fn names_that_do_not_exist_are_refused_with_the_nearest_one() {
    refused_change(
        "moves = [\"head\"]",
        "moves = [\"haed\"]",
        &["axes.z.moves[1]", "no part is called \"haed\"", "did you mean `head`?", "existing: column, head"],
    );
    refused_change(
        "\"column.rail\"",
        "\"colum.rail\"",
        &["joints[1] \"guide\".rail", "no part is called \"colum\"", "`column`"],
    );
    refused_change(
        "\"column.rail\"",
        "\"column.rial\"",
        &["no interface of the part \"column\" is called \"rial\"", "`rail`", "rail, mount"],
    );
    refused_change("\"column.rail\"", "\"rail\"", &["found \"rail\"", "PART.INTERFACE"]);
    refused_change(
        "interface = \"head.tip\"",
        "interface = \"head.top\"",
        &["ports.tool.interface", "called \"top\"", "`tip`"],
    );
    refused_change(
        "\"ball-screw\"",
        "\"ballscrew\"",
        &["no joint type is called \"ballscrew\"", "`ball-screw`", "spring-damper"],
    );
    refused_change("\"head.inp\"", "\"haed.inp\"", &["parts.head.mesh", "haed.inp does not exist", "`head.inp`"]);
}

#[test]
fn names_given_twice_are_refused() {
    refused_change(
        "name = \"screw\"",
        "name = \"guide\"",
        &["joints[2].name", "\"guide\" is given twice", "each joint once"],
    );
    refused_change("moves = [\"head\"]", "moves = [\"head\", \"head\"]", &["axes.z.moves[2]", "each part once"]);
    refused_change("[\"x\", \"z\"]", "[\"x\", \"x\"]", &["ports.tool.directions[2]", "each direction once"]);
    refused_change("[\"BASE\"]", "[\"BASE\", \"base\"]", &["parts.column.clamped[2]", "each node set once"]);
    refused_change("[parts.head]", "[parts.column]", &["duplicate key"]);
}
