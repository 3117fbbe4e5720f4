//! Keywords that are not read: which are harmless, and what to do about the others.

use super::lines::{Keyword, Lines};
use super::raw::Raw;
use crate::mesh::{MeshError, Warning};

/// Keywords that change neither the mesh nor its materials' stiffness and mass.
const HARMLESS: &[&str] = &[
    "AMPLITUDE",
    "CONDUCTIVITY",
    "CONTACTFILE",
    "CONTACTOUTPUT",
    "CONTACTPRINT",
    "CONTROLS",
    "ELEMENTOUTPUT",
    "ELFILE",
    "ELPRINT",
    "ENERGYOUTPUT",
    "EXPANSION",
    "FILEFORMAT",
    // Without a contact pair, which is refused, the properties of a contact serve nothing.
    "FRICTION",
    "MONITOR",
    "NODEFILE",
    "NODEOUTPUT",
    "NODEPRINT",
    // Materials are isotropic: turned axes change nothing.
    "ORIENTATION",
    "OUTPUT",
    "PHYSICALCONSTANTS",
    "PREPRINT",
    "RESTART",
    "SECTIONPRINT",
    "SPECIFICHEAT",
    "SURFACEBEHAVIOR",
    "SURFACEINTERACTION",
    "TIMEPOINTS",
];

/// Properties of a material beside its name: passed over where the material of the file does not matter.
pub const PROPERTIES: &[&str] = &[
    "CREEP",
    "CYCLICHARDENING",
    "DAMPING",
    "DENSITY",
    "DEPVAR",
    "ELASTIC",
    "HYPERELASTIC",
    "HYPERFOAM",
    "PLASTIC",
    "USERMATERIAL",
    "VISCOELASTIC",
];

/// Passes over a keyword that does not change the `result`, with a warning, and refuses any other.
///
/// # Errors
/// [`MeshError::Keyword`].
pub fn pass_over(keyword: &Keyword<'_>, result: &str, lines: &mut Lines<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let name = keyword.name.as_str();
    if !HARMLESS.contains(&name) {
        return Err(MeshError::Keyword {
            spot: lines.spot(keyword.line),
            keyword: keyword.spelling.to_owned(),
            advice: advice(name),
        });
    }
    say_passed_over(keyword, result, lines, raw);
    Ok(())
}

/// Passes over a keyword that the caller knows not to change the `result`, with a warning.
pub fn say_passed_over(keyword: &Keyword<'_>, result: &str, lines: &mut Lines<'_>, raw: &mut Raw) {
    let text = format!("*{} is passed over; it does not change the {result}", keyword.spelling);
    raw.warnings.push(Warning { line: keyword.line, text });
    lines.skip_data();
}

/// What to do about a keyword that is refused.
fn advice(name: &str) -> &'static str {
    match name {
        "PART" | "ENDPART" | "INSTANCE" | "ENDINSTANCE" | "ASSEMBLY" | "ENDASSEMBLY" => {
            "write a flat input file, without parts and assembly"
        }
        "TRANSFORM" | "SYSTEM" => "write the nodes in global Cartesian coordinates",
        "MPC"
        | "EQUATION"
        | "TIE"
        | "COUPLING"
        | "RIGIDBODY"
        | "KINEMATIC"
        | "DISTRIBUTING"
        | "DISTRIBUTINGCOUPLING" => {
            "connect parts by joints in the machine file, and mesh what belongs together as one body"
        }
        "CYCLICSYMMETRYMODEL" => "model the whole body",
        "SHELLSECTION" | "MEMBRANESECTION" | "BEAMSECTION" | "BEAMGENERALSECTION" | "NODALTHICKNESS" => {
            "mesh the body with solid elements"
        }
        "CONTACTPAIR" | "GAP" => "contact is not linear; tie by joints in the machine file",
        "CLOAD" | "DLOAD" => {
            "remove it: CalculiX adds the stress of loads to the stiffness in a step with PERTURBATION, Abaqus does not"
        }
        "INITIALCONDITIONS" => "remove it; the model is linear and at rest",
        "SPRING" | "DASHPOT" => "write it as a spring-damper joint in the machine file",
        "MASS" | "ROTARYINERTIA" | "NONSTRUCTURALMASS" => "mesh the mass as a body",
        "PLASTIC" | "HYPERELASTIC" | "HYPERFOAM" | "VISCOELASTIC" | "USERMATERIAL" => {
            "describe the material by *ELASTIC and *DENSITY alone"
        }
        "DAMPING" => "remove it and give the damping in the machine file",
        "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "ELGEN" | "ELCOPY" => "write out the nodes and elements",
        _ => "remove it if it does not matter",
    }
}
