//! Numbers with units.

use super::*;

#[test]
fn a_quantity_of_the_wrong_dimension_or_unit_is_refused_with_the_units_allowed() {
    refused_change(
        "\"77 N/um\"",
        "\"77 mm\"",
        &[
            "machine.toml:30: joints[1] \"guide\".stiffness.x",
            "found \"77 mm\", which is a length",
            "a stiffness in N/m, N/um",
        ],
    );
    refused_change("\"77 N/um\"", "\"77 N/mu\"", &["unknown unit \"N/mu\"", "did you mean \"N/"]);
    refused_change(
        "\"40 mm\"",
        "\"40\"",
        &["joints[2] \"screw\".diameter", "\"40\" without a unit", "a length in m, mm, um", "without quotes"],
    );
    refused_change("\"40 mm\"", "\"forty mm\"", &["does not begin with a number"]);
    refused_change(
        "\"100 N s/m\"",
        "\"100 N/m\"",
        &["joints[1] \"guide\".damping.x", "which is a stiffness", "a damping in N s/m"],
    );
    refused_change("to = \"10 Hz\"", "to = \"10 rad/s\"", &["analysis.frequencies.to", "a frequency in Hz"]);
    refused_change("\"40 mm\"", "true", &["found true", "a length in m"]);
}

#[test]
fn negative_infinite_and_nan_values_are_refused() {
    refused_change("\"77 N/um\"", "\"-77 N/um\"", &["stiffness.x: found \"-77 N/um\"", "positive", "a stiffness"]);
    refused_change("77e6", "0", &["stiffness.y: found 0", "positive"]);
    refused_change("77e6", "nan", &["stiffness.y: found nan, which is not finite"]);
    refused_change("77e6", "inf", &["stiffness.y: found inf, which is not finite"]);
    refused_change("77e6", "1e999", &["not finite"]);
    refused_change("\"77 N/um\"", "\"nan\"", &["found nan, which is not finite"]);
    refused_change("\"77 N/um\"", "\"inf N/um\"", &["\"inf N/um\"", "does not begin with a number"]);
    refused_change("\"77 N/um\"", "\"1e307 N/um\"", &["not finite"]);
    refused_change("\"100 N s/m\"", "-1", &["damping.x: found -1", "zero or a positive value"]);
    refused_change("\"210 GPa\"", "\"-210 GPa\"", &["joints[2] \"screw\".young", "positive"]);
    refused_change("\"90 mm\"", "0", &["footprint: found 0", "positive"]);
}

#[test]
fn materials_outside_physics_are_refused() {
    let material = |young: &str, poisson: &str, density: &str| {
        changed(
            "mesh = \"head.inp\"",
            &format!("mesh = \"head.inp\"\nmaterial = {{ young = {young}, poisson = {poisson}, density = {density} }}"),
        )
    };
    assert!(read(&material("210e9", "-0.9", "7850")).is_ok());
    refused(&material("210e9", "0.3", "-7850"), &["parts.head.material.density: found -7850", "positive"]);
    refused(&material("210e9", "0.5", "7850"), &["parts.head.material.poisson: found 0.5", "less than 0.5"]);
    refused(&material("210e9", "-1", "7850"), &["poisson: found -1", "more than -1"]);
    refused(&material("210e9", "nan", "7850"), &["poisson: found nan", "finite"]);
    refused(&material("0", "0.3", "7850"), &["young: found 0", "positive"]);
    refused_change(
        "mesh = \"head.inp\"",
        "mesh = \"head.inp\"\nunits = \"mm-kp-s\"",
        &["parts.head.units", "\"mm-t-s\""],
    );
    refused_change(
        "mesh = \"head.inp\"",
        "mesh = \"head.inp\"\nloss_factor = 5",
        &["parts.head.loss_factor: found 5", "0 to 2"],
    );
}

#[test]
fn quantities_are_the_doubles_one_would_write() {
    use Dimension::*;
    for (text, dimension, value) in [
        ("77 N/um", Stiffness, 77e6),
        ("77N/µm", Stiffness, 77e6),
        ("77 N/μm", Stiffness, 77e6),
        ("0.077 kN/um", Stiffness, 77e6),
        ("40 mm", Length, 0.04),
        ("-600 mm", Length, -0.6),
        ("1e3mm", Length, 1.0),
        ("-.5 m", Length, -0.5),
        ("210 GPa", Pressure, 210e9),
        ("115e3 N/mm2", Pressure, 115e9),
        ("115e3 N/mm^2", Pressure, 115e9),
        ("7200 kg/m3", Density, 7200.0),
        ("7.2 t/m3", Density, 7200.0),
        ("1400 Hz", Frequency, 1400.0),
        ("1e8 N m/rad", RotationalStiffness, 1e8),
        ("1e8 N*m/rad", RotationalStiffness, 1e8),
        ("100 N s/m", Damping, 100.0),
        ("3 N m s/rad", RotationalDamping, 3.0),
        ("2 %", Ratio, 0.02),
        ("0.02", Ratio, 0.02),
        ("5 1/s", InverseTime, 5.0),
        ("8 us", Time, 8e-6),
        ("-0.45", Length, -0.45),
    ] {
        assert_eq!(parse_quantity(text, dimension), Ok(value), "{text}");
    }
    for (text, dimension) in [
        ("", Length),
        ("mm", Length),
        ("1 mm mm", Length),
        ("1 m/", Length),
        ("1 /m", Length),
        ("1 N/m/s", Stiffness),
        ("1 kN m", RotationalStiffness),
        ("1 1/s", Frequency),
        ("1 m99999999999", Length),
        ("1 mm-", Length),
        ("NaN", Length),
        ("1e400 m", Length),
    ] {
        assert!(parse_quantity(text, dimension).is_err(), "{text}");
    }
}
