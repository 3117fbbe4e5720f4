//! Mass, size and materials of the parts.

use super::range::{Usual, length, number};
use super::{Finding, Survey};
use crate::machine::{Machine, Material, MeshUnits};

/// Largest mass of a part, kg: the bed of a gantry of 500 t has some 200 t.
const HEAVIEST: f64 = 3e6;
/// Smallest mass of a meshed part, kg.
const LIGHTEST: f64 = 1e-4;
/// Largest diagonal of a part, m: beds of long lathes and gantries reach 50 m.
const LARGEST: f64 = 500.0;
/// Smallest diagonal of a meshed part, m: a micro tool is 30 mm long.
const SMALLEST: f64 = 5e-3;

/// From rubber to diamond, with a factor beyond.
const YOUNG: Usual = Usual {
    from: 5e5,
    to: 2e12,
    units: &[("Pa", 1.0), ("MPa", 1e6), ("GPa", 1e9)],
    of: "a material",
    slips: &[
        (1e9, "GPa given as Pa: write young = \"210 GPa\""),
        (1e6, "N/mm2 given as Pa: write young = \"210 GPa\", or units = \"mm-t-s\" if the mesh file gives it"),
        (1e3, "MPa for GPa"),
        (1e-6, "Pa in a mesh file read in mm-t-s: units = \"m-kg-s\""),
        (1e-3, "kPa or MPa for GPa"),
    ],
};

/// From foam to osmium, with a factor beyond.
const DENSITY: Usual = Usual {
    from: 15.0,
    to: 25_000.0,
    units: &[("kg/m3", 1.0)],
    of: "a material",
    slips: &[
        (1e3, "g/cm3 for kg/m3: write density = \"7.85 g/cm3\""),
        (1e12, "t/mm3 for kg/m3: units = \"mm-t-s\" if the mesh file gives it, else write density = \"7850 kg/m3\""),
        (1e9, "kg/mm3 for kg/m3: units = \"mm-kg-ms\" if the mesh file gives it, else write density = \"7850 kg/m3\""),
        (1e-12, "kg/m3 in a mesh file read in mm-t-s: units = \"m-kg-s\", or density = \"7850 kg/m3\""),
        (1e-3, "g/cm3 for kg/m3"),
    ],
};

/// A dense material is a metal or a ceramic, and none of them is softer than this, Pa (lead has 16 GPa).
const SOFTEST_DENSE: f64 = 2e9;
const DENSE: f64 = 3_000.0;
/// Poisson's ratio of what is stiffer than this, Pa, is that of a metal, a ceramic or a composite.
const STIFF: f64 = 1e10;

pub(super) fn findings(machine: &Machine, survey: &Survey) -> Vec<Finding> {
    let mut found = Vec::new();
    for (part, measured) in survey.parts.iter().enumerate() {
        let (units, of_mesh) = (machine.parts[part].mesh_units, machine.parts[part].material.is_none());
        let fitting = |material: &Material| units_that_fit(material, units).filter(|_| of_mesh);
        found.extend(body(machine, survey, part, measured.materials.iter().find_map(|(_, m)| fitting(m))));
        for (place, material) in &measured.materials {
            // The mesh file's materials are in the same units as its nodes: one cause, one warning.
            match fitting(material) {
                Some(units) if !is_out_of_scale(machine, survey, part) => {
                    found.push(in_other_units(place, material, units));
                }
                Some(_) => {}
                None => found.extend(of_material(place, material)),
            }
        }
    }
    found
}

/// Unit systems that mesh files are written in.
const SYSTEMS: [(&str, MeshUnits); 5] = [
    ("m-kg-s", MeshUnits::METRE_KILOGRAM_SECOND),
    ("mm-t-s", MeshUnits::MILLIMETRE_TONNE_SECOND),
    ("mm-kg-ms", MeshUnits { length: 1e-3, mass: 1.0, time: 1e-3 }),
    ("in-slinch-s", MeshUnits { length: 0.0254, mass: 4.448_221_615_260_5 / 0.0254, time: 1.0 }),
    ("ft-slug-s", MeshUnits { length: 0.3048, mass: 4.448_221_615_260_5 / 0.3048, time: 1.0 }),
];

/// The unit system in which a material's numbers are those of a metal, if in the given one they are of nothing.
fn units_that_fit(material: &Material, units: MeshUnits) -> Option<&'static str> {
    let fits = |young: f64, density: f64| {
        (YOUNG.from..=YOUNG.to).contains(&young) && (DENSITY.from..=DENSITY.to).contains(&density)
    };
    if fits(material.young, material.density) {
        return None;
    }
    let metal = |(_, other): &&(&str, MeshUnits)| {
        let young = material.young / units.stress() * other.stress();
        let density = material.density / units.density() * other.density();
        (1e10..1e12).contains(&young) && (1e3..2e4).contains(&density)
    };
    SYSTEMS.iter().find(metal).map(|(name, _)| *name)
}

fn in_other_units(place: &str, material: &Material, name: &str) -> Finding {
    Finding {
        key: place.to_owned(),
        seen: format!("{} GPa and {} kg/m3", number(material.young * 1e-9), number(material.density)),
        usual: format!("{}; {}", YOUNG.words(), DENSITY.words()),
        slip: format!("likely a mesh file in other units: units = \"{name}\" makes it a metal"),
    }
}

/// Whether a part is too large or heavy, and whether too small or light.
fn scale(machine: &Machine, survey: &Survey, part: usize) -> [bool; 2] {
    let (mass, size) = (survey.parts[part].mass, survey.parts[part].size());
    // Matrices may hold a few nodes alone, and of a clamped superelement a part of the mass.
    let meshed = machine.parts[part].matrices.is_none();
    [size > LARGEST || mass > HEAVIEST, meshed && (size < SMALLEST || mass < LIGHTEST)]
}

/// Whether a part is so large or small that its mesh is in other units.
pub(super) fn is_out_of_scale(machine: &Machine, survey: &Survey, part: usize) -> bool {
    scale(machine, survey, part) != [false; 2]
}

/// A part that is too large, too small, too heavy or too light, in one finding.
///
/// `fitting` is the unit system in which the materials of its mesh file would be metals, if they are of nothing now.
fn body(machine: &Machine, survey: &Survey, part: usize, fitting: Option<&str>) -> Option<Finding> {
    let [large, small] = scale(machine, survey, part);
    if !large && !small {
        return None;
    }
    let (mass, size) = (survey.parts[part].mass, survey.parts[part].size());
    let give = |units: &str| format!("give units = \"{units}\" to this part (or the unit its mesh is drawn in)");
    let slip = match fitting {
        Some(units) => format!("likely a mesh file in other units: units = \"{units}\" makes its material a metal"),
        None if small => format!("likely millimetres for metres: {}", give("m-kg-s")),
        None if size > 1e-2 * LARGEST => format!("likely metres for millimetres: {}", give("mm-t-s")),
        None => "check the density and the units of the mesh".to_owned(),
    };
    Some(Finding {
        key: format!("parts.{}", machine.parts[part].name),
        seen: format!("{} across and {} kg", length(size), number(mass)),
        usual: format!(
            "{} to {}, at most {} kg for a part of a machine tool",
            length(SMALLEST),
            length(LARGEST),
            number(HEAVIEST)
        ),
        slip,
    })
}

fn of_material(place: &str, material: &Material) -> Vec<Finding> {
    let Material { young, poisson, density, .. } = *material;
    let mut found: Vec<Finding> = Vec::new();
    found.extend(YOUNG.check(|| format!("{place}.young"), young));
    found.extend(DENSITY.check(|| format!("{place}.density"), density));
    if found.is_empty() && density > DENSE && young < SOFTEST_DENSE {
        found.push(Finding {
            key: format!("{place}.young"),
            seen: format!("{} GPa with a density of {} kg/m3", number(young * 1e-9), number(density)),
            usual: format!("at least {} GPa for a material denser than {DENSE} kg/m3", number(SOFTEST_DENSE * 1e-9)),
            slip: "likely MPa for GPa".to_owned(),
        });
    }
    let (from, to) = if young > STIFF { (0.0, 0.47) } else { (0.0, 0.4999) };
    if !(from..=to).contains(&poisson) {
        found.push(Finding {
            key: format!("{place}.poisson"),
            seen: poisson.to_string(),
            usual: format!("{from} to {to} (steel 0.3, cast iron 0.26)"),
            slip: "check the sign and the decimal point".to_owned(),
        });
    }
    found
}
