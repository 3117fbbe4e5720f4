//! Keywords that are not read: which are harmless, and what to do about the others.

/// Keywords that change neither the mesh nor its materials' stiffness and mass.
const HARMLESS: &[&str] = &[
    "AMPLITUDE",
    "CONDUCTIVITY",
    "CONTACTFILE",
    "CONTACTOUTPUT",
    "CONTACTPRINT",
    "ELEMENTOUTPUT",
    "ELFILE",
    "ELPRINT",
    "ENERGYOUTPUT",
    "EXPANSION",
    "FILEFORMAT",
    "MONITOR",
    "NODEFILE",
    "NODEOUTPUT",
    "NODEPRINT",
    "OUTPUT",
    "PHYSICALCONSTANTS",
    "PREPRINT",
    "RESTART",
    "SPECIFICHEAT",
    "TIMEPOINTS",
];

/// Whether a keyword may be passed over.
pub fn is_harmless(name: &str) -> bool {
    HARMLESS.contains(&name)
}

/// What to do about a keyword that is refused.
pub fn advice(name: &str) -> &'static str {
    match name {
        "PART" | "ENDPART" | "INSTANCE" | "ENDINSTANCE" | "ASSEMBLY" | "ENDASSEMBLY" => {
            "write a flat input file, without parts and assembly"
        }
        "TRANSFORM" | "SYSTEM" => "write the nodes in global Cartesian coordinates",
        "ORIENTATION" => "remove it; materials are isotropic",
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
        "CONTACTPAIR" | "SURFACEBEHAVIOR" | "FRICTION" | "GAP" => {
            "contact is not linear; tie by joints in the machine file"
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
