//! Machines that cannot be.

use super::*;

#[test]
fn an_axis_that_cannot_travel_is_refused() {
    refused_change("step = \"5 mm\"", "step = 0", &["axes.z.step: found 0", "positive", "a length"]);
    refused_change("step = \"5 mm\"", "step = \"-5 mm\"", &["axes.z.step: found \"-5 mm\"", "positive"]);
    refused_change("step = \"5 mm\"", "step = nan", &["axes.z.step", "not finite"]);
    refused_change("step = \"5 mm\"", "step = \"1 nm\"", &["axes.z.step", "at most 100000 intervals", "larger"]);
    refused_change("moves = [\"head\"]", "moves = []", &["axes.z.moves: found []", "not none and not all"]);
    refused_change("moves = [\"head\"]", "moves = [\"head\", \"column\"]", &["not none and not all"]);
    let second = "[axes.y]\ndirection = [0, 1, 0]\ntravel = [0, 1]\nstep = 1\nmoves = [\"head\"]\n[parts.column]\n";
    refused_change("[parts.column]\n", second, &["axes: found 2 axes (z, y)", "exactly one axis"]);
}

#[test]
fn joints_whose_sides_move_wrongly_are_refused() {
    refused_change(
        "\"head.carriage\"",
        "\"column.mount\"",
        &[
            "joints[1] \"guide\".carriage",
            "\"column\" and \"column\", of which neither moves",
            "exactly one moves",
            "axes.z.moves",
        ],
    );
    refused_change("\"column.rail\"", "\"head.nut\"", &["of which both move"]);
    refused_change(
        "[\"column.mount\", \"head.nut\"]",
        "[\"head.tip\", \"head.nut\"]",
        &["joints[2] \"screw\".between", "a ball screw between \"head\" and \"head\", of which both move"],
    );
    refused_change(
        "[\"column.mount\", \"head.nut\"]",
        "[\"column.mount\"]",
        &["joints[2] \"screw\".between", "give 2 values, not 1"],
    );
    refused_change(
        "[\"column.mount\", \"head.nut\"]",
        "[\"column.mount\", \"column.mount\"]",
        &["two different interfaces"],
    );
    refused_change(
        "axis = \"z\"\nyoung",
        "axis = \"x\"\nyoung",
        &["joints[2] \"screw\".axis", "direction of the axis of travel"],
    );
    let bolted =
        "[[joints]]\nname = \"bolts\"\ntype = \"bolted\"\nbetween = [\"column.mount\", \"head.tip\"]\n[ports.tool]";
    refused_change(
        "[ports.tool]",
        bolted,
        &["joints[3] \"bolts\".between", "one moves along the axis \"z\"", "two sides that move together"],
    );
}

#[test]
fn joints_with_missing_or_impossible_stiffness_are_refused() {
    refused_change(
        "{ x = \"77 N/um\", y = 77e6 }",
        "{ x = 1e6, z = 1e6 }",
        &["joints[1] \"guide\".stiffness", "no stiffness along z, the direction of travel"],
    );
    refused_change(
        "{ x = \"77 N/um\", y = 77e6 }\ndamping = { x = \"100 N s/m\" }",
        "{ }",
        &["at least one of x, y, z, rx, ry, rz"],
    );
    refused_change(
        "nodes = \"RAIL\"",
        "nodes = \"RAIL\", coupling = \"rigid\"",
        &["joints[1] \"guide\".rail", "\"distributing\"", "footprint moves"],
    );
    let bolted = "[[joints]]\nname = \"bolts\"\ntype = \"bolted\"\nbetween = [\"head.nut\", \"head.tip\"]\nstiffness = { x = 1, y = 1, z = 1, rx = 1, rz = 1 }\n[ports.tool]";
    refused_change("[ports.tool]", bolted, &["joints[3] \"bolts\".stiffness", "all six", "ry is missing"]);
    refused_change(
        "nodes = \"RAIL\"",
        "nodes = \"RAIL\", coupling = \"stiff\"",
        &["interfaces.rail.coupling: found \"stiff\"", "\"rigid\""],
    );
    refused_change(
        "from = \"10 mm\", to = \"30 mm\"",
        "from = \"30 mm\", to = \"10 mm\"",
        &["parts.head.interfaces.tip.within", "a smaller length, then a larger one"],
    );
    refused_change(
        "{ axis = \"z\", from = \"10 mm\", to = \"30 mm\" }",
        "{ }",
        &["interfaces.tip.within", "take the whole surface"],
    );
}

#[test]
fn a_part_without_any_joint_is_refused() {
    refused_change(
        "[[joints]]",
        "[parts.spare]\nmesh = \"head.inp\"\n[[joints]]",
        &["parts.spare", "the part \"spare\" without any joint", "[[joints]]"],
    );
}

#[test]
fn ports_without_inputs_or_outputs_are_refused() {
    refused_change(
        "[\"x\", \"z\"]",
        "[\"x\"]\ninput = false",
        &["ports: found 1 ports without an input", "at least one input"],
    );
    refused_change("[\"x\", \"z\"]", "[\"x\"]\noutput = false", &["without an output"]);
    refused_change(
        "[\"x\", \"z\"]",
        "[\"x\"]\ninput = false\noutput = false",
        &["ports.tool", "neither input nor output"],
    );
    refused_change("[\"x\", \"z\"]", "[]", &["ports.tool.directions: found []", "at least one direction"]);
    refused_change("[\"x\", \"z\"]", "[\"u\"]", &["ports.tool.directions[1]: found \"u\""]);
}

#[test]
fn frequencies_that_make_no_grid_are_refused() {
    let range = "{ from = \"0 Hz\", to = \"10 Hz\", step = \"1 Hz\" }";
    refused_change(range, "[]", &["analysis.frequencies: found []", "at least one"]);
    refused_change(range, "[2, 1]", &["analysis.frequencies[2]: found 1", "more than the one before, 2 Hz"]);
    refused_change(range, "[1, 1]", &["analysis.frequencies[2]"]);
    refused_change(range, "[-1]", &["analysis.frequencies[1]: found -1", "zero or a positive"]);
    refused_change(range, "5", &["analysis.frequencies: found 5", "ascending list"]);
    refused_change(
        "from = \"0 Hz\"",
        "from = \"11 Hz\"",
        &["analysis.frequencies.to: found \"10 Hz\"", "at least `from`, 11 Hz"],
    );
    refused_change("step = \"1 Hz\"", "step = 0", &["analysis.frequencies.step: found 0"]);
    refused_change("step = \"1 Hz\"", "step = 1e-300", &["at most 1000000 intervals"]);
}

#[test]
fn damping_outside_its_range_is_refused() {
    refused_change("ratio = 0.02", "ratio = 1", &["analysis.damping.ratio: found 1", "from 0 to less than 1", "2 %"]);
    refused_change("ratio = 0.02", "ratio = -0.02", &["analysis.damping.ratio: found -0.02"]);
    refused_change("ratio = 0.02", "ratio = nan", &["not finite"]);
    refused_change("ratio = 0.02", "ratios = [0.1, 2]", &["analysis.damping.ratios[2]: found 2"]);
    refused_change("ratio = 0.02", "ratios = []", &["analysis.damping.ratios", "at least one"]);
    refused_change("ratio = 0.02", "ratio = 0.1, ratios = [0.1]", &["either `ratio` or `ratios`"]);
    refused_change("{ ratio = 0.02 }", "{ }", &["analysis.damping", "{ ratio = 0 }"]);
    refused_change("ratio = 0.02", "rayleigh = { alpha = -1, beta = 0 }", &["rayleigh.alpha: found -1"]);
    refused_change("ratio = 0.02", "rayleigh = { alpha = 1 }", &["`beta` is missing"]);
}

#[test]
fn grids_and_quantities_that_make_no_sense_are_refused() {
    let table = "{ from = \"0 Hz\", to = \"10 Hz\", step = \"1 Hz\" }";
    for (text, fragments) in [
        ("{ grid = \"log\", from = 1, to = 2 }", &["frequencies.grid: found \"log\"", "\"logarithmic\""][..]),
        ("{ grid = \"logarithmic\", from = 0, to = 2, count = 5 }", &["frequencies.from: found 0", "positive"]),
        ("{ grid = \"logarithmic\", from = 2, to = 2, count = 5 }", &["frequencies.to: found 2", "more than `from`"]),
        ("{ grid = \"logarithmic\", from = 1, to = 2, count = 1 }", &["frequencies.count: found 1", "from 2 to"]),
        ("{ grid = \"logarithmic\", from = 1, to = 2 }", &["`count` is missing", "count = 500"]),
        ("{ grid = \"logarithmic\", from = 1, to = 2, count = 5, step = 1 }", &["unknown key `step`", "count"]),
        ("{ grid = \"clustered\", from = 3, to = 2 }", &["frequencies.to: found 2", "exchange"]),
        ("{ grid = \"clustered\", from = 0, to = 2, points = 2000 }", &["frequencies.points: found 2000", "1 to 1000"]),
        ("{ grid = \"clustered\", from = 0, to = 2, background = 1 }", &["background: found 1", "from 2 to"]),
    ] {
        refused_change(table, text, fragments);
    }
    let damping = "damping = { ratio = 0.02 }";
    refused_change(
        damping,
        "damping = { ratio = 0.02 }\nquantity = \"stiffness\"",
        &["analysis.quantity: found \"stiffness\"", "\"receptance\", \"mobility\" or \"accelerance\""],
    );
}

#[test]
fn supports_of_a_ball_screw_that_do_not_fit_are_refused() {
    let with = |keys: &str| format!("diameter = \"40 mm\"\n{keys}");
    let diameter = "diameter = \"40 mm\"";
    refused_change(diameter, &with("support = \"both\""), &["\"screw\".support: found \"both\"", "\"both-ends\""]);
    refused_change(diameter, &with("support = \"both-ends\""), &["the key `span` is missing"]);
    refused_change(diameter, &with("span = \"1 m\""), &["\"screw\".span: found \"1 m\"", "add support"]);
    refused_change(diameter, &with("free_length = 0"), &["\"screw\".free_length: found 0", "positive"]);
}
