//! Milling: forces against closed forms, and directions across the spindle.

use super::mill;
use std::f64::consts::TAU;
use stiffmap::response::{CutterPort, Forces, parse_milling};

const TEXT: &str = "teeth=1,speed=3000,feed=0.1,depth=2,kt=2000,kr=0.3";

fn port(name: &str, spindle: Option<[f64; 3]>) -> CutterPort {
    let unit = |k: usize| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
    let inputs = (0..3).map(|k| (format!("{name}.{}", ["x", "y", "z"][k]), unit(k))).collect();
    CutterPort { name: name.into(), inputs, spindle }
}

/// Sensor on the slide, which carries the bearings, and the tool on a spindle along y.
fn sensor_and_tool() -> [CutterPort; 2] {
    [port("sensor", None), port("tool", Some([0.0, 1.0, 0.0]))]
}

#[test]
fn one_tooth_in_a_slot_has_altintas_mean_force() {
    // Slotting: mean feed force -N a c Kt Kr / 4, mean normal force N a c Kt / 4.
    let ports = [port("tool", Some([0.0, 0.0, 1.0]))];
    let cut = parse_milling(TEXT, &ports).unwrap();
    let names: Vec<String> = ports[0].inputs.iter().map(|(n, _)| n.clone()).collect();
    let mut forces = Forces::none(&names, 0.2, 100e3).unwrap();
    forces.add_milling(&cut).unwrap();
    let mean = |j: usize| forces.input(j).iter().sum::<f64>() / forces.samples() as f64;
    let unit = 2e-3 * 1e-4 * 2e9;
    assert!((mean(0) / (-unit * 0.3 / 4.0) - 1.0).abs() < 1e-6, "{}", mean(0));
    assert!((mean(1) / (unit / 4.0) - 1.0).abs() < 1e-6, "{}", mean(1));
    // Four teeth in a slot: a constant force, as two teeth always cut.
    let four = parse_milling(&TEXT.replace("teeth=1", "teeth=4"), &ports).unwrap();
    assert_eq!((four.engaged(), cut.engaged()), ([2, 2], [0, 1]));
    let first = four.at(0.0);
    assert!((0..100).all(|k| (four.at(1.1e-4 * f64::from(k))[1] - first[1]).abs() < 1e-9 * first[1]));
    assert!((0..100).any(|k| (cut.at(1.1e-4 * f64::from(k))[1] - first[1]).abs() > 0.1 * first[1]), "control");
}

#[test]
fn teeth_that_leave_between_samples_keep_their_momentum() {
    // Six samples a tooth; entry and exit lie anywhere between them. A tooth passing has
    // int F_normal dt = Kt a c / (2 pi n) [phi/2 - sin(2 phi)/4 + Kr cos(2 phi)/4] from entry to exit.
    let ports = [port("tool", Some([0.0, 0.0, 1.0]))];
    let names: Vec<String> = ports[0].inputs.iter().map(|(n, _)| n.clone()).collect();
    let cut = parse_milling(&format!("{},entry=33,exit=71", TEXT.replace("teeth=1", "teeth=3")), &ports).unwrap();
    // 40 passings and a rest in which no tooth cuts.
    let mut forces = Forces::none(&names, 40.2 / 150.0, 907.0).unwrap();
    forces.add_milling(&cut).unwrap();
    let integral = |phi: f64| phi / 2.0 - (2.0 * phi).sin() / 4.0 + 0.3 * (2.0 * phi).cos() / 4.0;
    let one = 2e-3 * 1e-4 * 2e9 / (TAU * 50.0) * (integral(cut.exit) - integral(cut.entry));
    let found: f64 = forces.input(1).iter().sum::<f64>() * forces.step;
    assert!((found / (40.0 * one) - 1.0).abs() < 1e-9, "{found} N s, {}", 40.0 * one);
    let plain: f64 = (0..forces.samples()).map(|k| cut.at(forces.time(k))[1]).sum::<f64>() * forces.step;
    assert!((plain / (40.0 * one) - 1.0).abs() > 1e-3, "control: values at the samples have {plain} N s");
}

#[test]
fn directions_lie_across_the_spindle_or_are_asked_for() {
    let both = |more: &str, ports: &[CutterPort]| {
        parse_milling(&format!("{TEXT}{more}"), ports).map(|m| (m.feed_input, m.normal_input, m.signs))
    };
    let found = |feed: &str, normal: &str, signs: [f64; 2]| (feed.to_owned(), normal.to_owned(), signs);
    let ports = sensor_and_tool();
    assert_eq!(both("", &ports).unwrap(), found("tool.x", "tool.z", [1.0, 1.0]));
    assert_eq!(both(",along=tool.z", &ports).unwrap(), found("tool.z", "tool.x", [1.0, 1.0]));
    assert_eq!(both(",along=-x,across=z", &ports).unwrap(), found("tool.x", "tool.z", [-1.0, 1.0]));
    assert_eq!(both(",across=-tool.x,port=tool", &ports).unwrap(), found("tool.z", "tool.x", [1.0, -1.0]));
    assert_eq!(both(",port=sensor,along=x,across=y", &ports).unwrap(), found("sensor.x", "sensor.y", [1.0, 1.0]));
    let refused = |more: &str, ports: &[CutterPort], parts: &[&str]| {
        let error = both(more, ports).unwrap_err().to_string();
        assert!(parts.iter().all(|p| error.contains(p)), "{more}: {error}");
    };
    refused(",port=sensor", &ports, &["no directions of the cut", "along=INPUT,across=INPUT", "sensor.x"]);
    refused("", &[port("sensor", None)], &["no directions of the cut", "sensor.x, sensor.y"]);
    refused("", &[port("a", Some([1.0, 0.0, 0.0])), port("b", Some([1.0, 0.0, 0.0]))], &["which is the tool's"]);
    refused("", &[port("a", Some([0.0, 0.6, 0.8]))], &["not two directions across the spindle"]);
    refused(",port=head", &ports, &["port: found \"head\"", "sensor, tool"]);
    refused(",along=tool.w", &ports, &["along: found \"tool.w\"", "tool.z"]);
    refused(",along=tool.x,across=-tool.x", &ports, &["two different inputs"]);
    refused(",entry=180,exit=360", &ports, &["180 to 360 degrees", "exit <= 180"]);
    assert!(ports[1].is_along_spindle("tool.y") && !ports[1].is_along_spindle("tool.x"));
}

#[test]
fn a_part_that_bearings_alone_hold_is_the_spindle() {
    let machine = &mill().machine;
    let ports = CutterPort::of(machine);
    assert_eq!(ports[0].spindle.map(|a| a[2].abs()), Some(1.0), "the bundled mill's spindle is along z");
    let inputs: Vec<&str> = ports[0].inputs.iter().map(|(n, _)| n.as_str()).collect();
    assert_eq!(inputs, ["x", "y", "z"]);
    // On the headstock, which carries the bearings and runs on guides, nothing turns.
    let mut other = machine.clone();
    other.ports[0].interface.part = machine.parts.iter().position(|p| p.name == "headstock").unwrap();
    assert_eq!(CutterPort::of(&other)[0].spindle, None);
    // Nor on the drive that is bolted to it.
    other.ports[0].interface.part = machine.parts.iter().position(|p| p.name == "drive").unwrap();
    assert_eq!(CutterPort::of(&other)[0].spindle, None);
}

#[test]
fn few_samples_a_tooth_are_told_and_fewer_than_two_refused() {
    let ports = sensor_and_tool();
    let forces = |rate: f64| Forces::none(&["x".to_owned()], 1.0, rate).unwrap();
    // Four teeth at 3000/min pass at 200 Hz.
    let cut = parse_milling(&TEXT.replace("teeth=1", "teeth=4"), &ports).unwrap();
    assert_eq!(cut.check(&forces(20e3)).unwrap(), Vec::<String>::new());
    let told = cut.check(&forces(1000.0)).unwrap();
    assert!(told.len() == 1 && told[0].contains("5.0 samples while a tooth passes, at 200 Hz"), "{told:?}");
    let error = cut.check(&forces(400.0)).unwrap_err().to_string();
    assert!(error.contains("found 200 Hz") && error.contains("--rate 4000"), "{error}");
}
