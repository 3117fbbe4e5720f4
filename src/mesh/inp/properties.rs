//! Materials, and the elements that have them.

use super::lines::{Keyword, Lines, bad_value, canonical, fields, key, number, told_apart, unquoted};
use super::parameters::{Neutral, check_parameters};
use super::raw::{Raw, RawMaterial, RawSection};
use super::sections::need_name;
use crate::mesh::MeshError;

type Result<T> = std::result::Result<T, MeshError>;

pub fn read_material(keyword: &Keyword<'_>, lines: &Lines<'_>, raw: &mut Raw) -> Result<()> {
    check_parameters(keyword, "MATERIAL", &["NAME"], &[], "NAME", lines)?;
    let name = need_name(keyword, "MATERIAL", "NAME", "NAME", lines)?;
    if let Some(other) = raw.materials.iter().find(|other| key(&other.name) == key(name)) {
        let spot = lines.spot(keyword.line);
        if told_apart(&other.name, name) {
            let (first, second) = (other.name.clone(), name.to_owned());
            return Err(MeshError::AlmostEqualNames { spot, first, second });
        }
        return Err(MeshError::Duplicate { spot, kind: "material", label: unquoted(name).to_owned() });
    }
    raw.materials.push(RawMaterial { name: name.to_owned(), elastic: None, density: None });
    Ok(())
}

pub fn read_elastic(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const ALLOWED: &str = "TYPE=ISO (or none)";
    // The moduli are those of a viscoelastic material, which is refused.
    const NEUTRAL: [Neutral; 1] = [("MODULI", &["INSTANTANEOUS", "LONGTERM"])];
    check_parameters(keyword, "ELASTIC", &["TYPE"], &NEUTRAL, ALLOWED, lines)?;
    if let Some(kind) = keyword.get("TYPE").filter(|kind| !["ISO", "ISOTROPIC"].contains(&canonical(kind).as_str())) {
        return Err(MeshError::Parameter {
            spot: lines.spot(keyword.line),
            keyword: "ELASTIC",
            seen: format!("TYPE={kind} is not supported"),
            allowed: ALLOWED,
            advice: "describe the material by Young's modulus and Poisson's ratio",
        });
    }
    let (line, data, values) = single_row("ELASTIC", 2, keyword, lines)?;
    let &[young, poisson] = values.as_slice() else {
        return bad_value(lines.spot(line), "ELASTIC", data, "Young's modulus and Poisson's ratio");
    };
    if young <= 0.0 {
        return bad_value(lines.spot(line), "ELASTIC", data, "a positive Young's modulus");
    }
    if !(poisson > -1.0 && poisson < 0.5) {
        return bad_value(lines.spot(line), "ELASTIC", data, "a Poisson's ratio of more than -1 and less than 0.5");
    }
    current_material("ELASTIC", keyword, lines, raw, |m| m.elastic.replace((young, poisson)).is_some())
}

pub fn read_density(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    check_parameters(keyword, "DENSITY", &[], &[], "no parameter", lines)?;
    let (line, data, values) = single_row("DENSITY", 1, keyword, lines)?;
    let &[density] = values.as_slice() else {
        return bad_value(lines.spot(line), "DENSITY", data, "a density");
    };
    if density <= 0.0 {
        return bad_value(lines.spot(line), "DENSITY", data, "a positive density");
    }
    current_material("DENSITY", keyword, lines, raw, |m| m.density.replace(density).is_some())
}

/// The only data line of a material property: `count` numbers, and a temperature that does not matter.
fn single_row<'a>(
    name: &'static str,
    count: usize,
    keyword: &Keyword<'_>,
    lines: &mut Lines<'a>,
) -> Result<(usize, &'a str, Vec<f64>)> {
    let Some((line, data)) = lines.next_data() else {
        return Err(MeshError::Truncated {
            spot: lines.spot(keyword.line),
            what: "a material",
            detail: format!("*{name} lacks its data line"),
        });
    };
    let mut values = Vec::with_capacity(count + 1);
    for field in fields(data).take(count + 2) {
        match number(field) {
            Some(value) => values.push(value),
            None => return bad_value(lines.spot(line), name, field, "finite numbers"),
        }
    }
    if values.len() == count + 1 {
        values.pop();
    }
    if let Some((line, data)) = lines.next_data() {
        let allowed = "one row; properties that depend on temperature are not supported";
        return bad_value(lines.spot(line), name, data, allowed);
    }
    Ok((line, data, values))
}

/// Gives the latest material a property; `set` says whether it had one.
fn current_material(
    name: &'static str,
    keyword: &Keyword<'_>,
    lines: &Lines<'_>,
    raw: &mut Raw,
    set: impl FnOnce(&mut RawMaterial) -> bool,
) -> Result<()> {
    let refused = |seen: String, advice| {
        let spot = lines.spot(keyword.line);
        Err(MeshError::Parameter { spot, keyword: name, seen, allowed: "one in each *MATERIAL", advice })
    };
    let Some(material) = raw.materials.last_mut() else {
        return refused("it stands before the first *MATERIAL".to_owned(), "put it after its *MATERIAL");
    };
    if set(material) {
        return refused(format!("the material {:?} has two", unquoted(&material.name)), "remove one of them");
    }
    Ok(())
}

pub fn read_solid_section(keyword: &Keyword<'_>, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<()> {
    const ALLOWED: &str = "ELSET, MATERIAL, ORIENTATION";
    // Materials are isotropic: turned axes change nothing.
    const NEUTRAL: [Neutral; 1] = [("ORIENTATION", &[])];
    check_parameters(keyword, "SOLID SECTION", &["ELSET", "MATERIAL"], &NEUTRAL, ALLOWED, lines)?;
    let element_set = need_name(keyword, "SOLID SECTION", "ELSET", ALLOWED, lines)?.to_owned();
    let material = need_name(keyword, "SOLID SECTION", "MATERIAL", ALLOWED, lines)?.to_owned();
    raw.sections.push(RawSection { element_set, material, line: keyword.line });
    // A thickness means nothing to a solid element.
    lines.skip_data();
    Ok(())
}

/// Passes over the section of surface elements, which have neither stiffness nor, without DENSITY, mass.
pub fn read_surface_section(keyword: &Keyword<'_>, lines: &mut Lines<'_>) -> Result<()> {
    const ALLOWED: &str = "ELSET, and no DENSITY, which would give the surface a mass";
    check_parameters(keyword, "SURFACE SECTION", &["ELSET"], &[], ALLOWED, lines)?;
    lines.skip_data();
    Ok(())
}
