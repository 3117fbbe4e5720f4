//! Paths into a machine: what a study may vary, and under which name.
//!
//! A path reads as the machine file does, with points between its steps: `joints.guide A.stiffness.x`. Names hold no
//! points, so nothing is quoted. An asterisk stands for any run of characters within one step, so that
//! `joints.guide *.stiffness.x` names the same spring of every guide.

use crate::machine::{Dimension, JointKind, Machine, Motion, ScrewSupport, SpringStiffness, nearest};

/// A place in a machine that a design may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// Stiffness of a spring: joint and spring by index.
    Stiffness(usize, usize),
    /// Viscous damper beside a spring: joint and spring by index.
    Damper(usize, usize),
    /// Loss factor of a joint.
    JointLoss(usize),
    /// Diameter of a ball screw.
    Diameter(usize),
    /// Young's modulus of a ball screw.
    ScrewYoung(usize),
    /// Free length of a ball screw at position 0.
    FreeLength(usize),
    /// Distance between a ball screw's two supports.
    Span(usize),
    /// Which ends of a ball screw are held.
    Support(usize),
    /// The viscous ratio of all modes.
    Ratio,
    /// The loss factor of the whole machine.
    LossFactor,
    /// Young's modulus of a part.
    PartYoung(usize),
    /// Density of a part.
    PartDensity(usize),
}

/// A path with everything it stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The path.
    pub path: String,
    /// The places it names: `radial` names two springs.
    pub targets: Vec<Target>,
    /// What its values measure; `None` for the names of supports.
    pub dimension: Option<Dimension>,
    /// The machine's own value, SI, where the machine file gives one; for supports 0 (one end) or 1 (both).
    pub nominal: Option<f64>,
}

/// Every path of a machine.
pub fn catalogue(machine: &Machine) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut add = |path: String, targets: Vec<Target>, dimension: Option<Dimension>, nominal: Option<f64>| {
        entries.push(Entry { path, targets, dimension, nominal });
    };
    for (j, joint) in machine.joints.iter().enumerate() {
        let at = format!("joints.{}", joint.name);
        for (way, springs) in ways(machine, j) {
            let spring = &joint.springs[springs[0]];
            let step = if way.is_empty() { String::new() } else { format!(".{way}") };
            let (stiffness, damping) = match spring.motion {
                Motion::Translation => (Dimension::Stiffness, Dimension::Damping),
                Motion::Rotation => (Dimension::RotationalStiffness, Dimension::RotationalDamping),
            };
            let each = |target: fn(usize, usize) -> Target| springs.iter().map(|&s| target(j, s)).collect();
            if let SpringStiffness::Constant(k) = spring.stiffness {
                add(format!("{at}.stiffness{step}"), each(Target::Stiffness), Some(stiffness), Some(k));
            }
            add(format!("{at}.damping{step}"), each(Target::Damper), Some(damping), Some(spring.damping));
        }
        add(format!("{at}.loss_factor"), vec![Target::JointLoss(j)], Some(Dimension::Ratio), joint.loss_factor);
        for spring in &joint.springs {
            let SpringStiffness::BallScrew { young, diameter, free_length, support } = spring.stiffness else {
                continue;
            };
            let length = Some(Dimension::Length);
            add(format!("{at}.diameter"), vec![Target::Diameter(j)], length, Some(diameter));
            add(format!("{at}.young"), vec![Target::ScrewYoung(j)], Some(Dimension::Pressure), Some(young));
            add(format!("{at}.free_length"), vec![Target::FreeLength(j)], length, free_length);
            if let ScrewSupport::BothEnds { span } = support {
                add(format!("{at}.span"), vec![Target::Span(j)], length, Some(span));
            }
            let both = f64::from(u8::from(support != ScrewSupport::OneEnd));
            add(format!("{at}.support"), vec![Target::Support(j)], None, Some(both));
        }
    }
    let damping = &machine.analysis.damping;
    let ratio = (damping.ratios.len() == 1).then(|| damping.ratios[0]);
    add("analysis.damping.ratio".into(), vec![Target::Ratio], Some(Dimension::Ratio), ratio);
    let loss = Some(damping.loss_factor);
    add("analysis.damping.loss_factor".into(), vec![Target::LossFactor], Some(Dimension::Ratio), loss);
    for (p, part) in machine.parts.iter().enumerate() {
        let at = format!("parts.{}.material", part.name);
        let material = part.material.as_ref();
        let young = material.map(|m| m.young);
        add(format!("{at}.young"), vec![Target::PartYoung(p)], Some(Dimension::Pressure), young);
        let density = material.map(|m| m.density);
        add(format!("{at}.density"), vec![Target::PartDensity(p)], Some(Dimension::Density), density);
    }
    entries
}

/// Keys of a joint's `stiffness` table with the springs they stand for; an empty key for a plain value.
fn ways(machine: &Machine, joint: usize) -> Vec<(&str, Vec<usize>)> {
    let joint = &machine.joints[joint];
    let mut ways: Vec<(&str, Vec<usize>)> = Vec::new();
    for (s, spring) in joint.springs.iter().enumerate() {
        let plain = matches!(joint.kind, JointKind::SpringDamper | JointKind::BallScrew) && spring.label == "axial";
        let key = if plain { "" } else { spring.label.split(' ').next().unwrap_or_default() };
        match ways.iter_mut().find(|(way, _)| *way == key) {
            Some((_, springs)) => springs.push(s),
            None => ways.push((key, vec![s])),
        }
    }
    ways
}

/// The entries that a path names, in the machine's order; none if it names nothing.
pub fn find<'a>(entries: &'a [Entry], path: &str) -> Vec<&'a Entry> {
    entries.iter().filter(|entry| matches(path, &entry.path)).collect()
}

/// What a path that names nothing was probably meant to be, and what exists in place of its first wrong step.
pub fn suggest(entries: &[Entry], path: &str) -> (Option<String>, Vec<String>) {
    let plain = path.replace('*', "");
    let near = nearest(&plain, entries.iter().map(|entry| entry.path.as_str())).map(str::to_owned);
    let steps: Vec<&str> = path.split('.').collect();
    let agrees = |entry: &Entry, n: usize| {
        let own: Vec<&str> = entry.path.split('.').collect();
        own.len() >= n && steps[..n].iter().zip(&own).all(|(a, b)| step_matches(a, b))
    };
    let right = (0..=steps.len()).rev().find(|&n| entries.iter().any(|e| agrees(e, n))).unwrap_or(0);
    let mut next: Vec<String> = Vec::new();
    for entry in entries.iter().filter(|e| agrees(e, right)) {
        let own: Vec<&str> = entry.path.split('.').collect();
        let shown = own[right.min(own.len() - 1)].to_owned();
        if !next.contains(&shown) {
            next.push(shown);
        }
    }
    (near, next)
}

fn matches(path: &str, own: &str) -> bool {
    let (a, b): (Vec<&str>, Vec<&str>) = (path.split('.').collect(), own.split('.').collect());
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| step_matches(a.trim(), b))
}

/// Whether a step with asterisks matches a name.
fn step_matches(pattern: &str, name: &str) -> bool {
    let Some((head, tail)) = pattern.split_once('*') else { return pattern == name };
    let Some(rest) = name.strip_prefix(head) else { return false };
    let cuts = rest.char_indices().map(|(i, _)| i).chain([rest.len()]);
    cuts.into_iter().any(|cut| step_matches(tail, &rest[cut..]))
}

#[cfg(test)]
mod tests {
    use super::{matches, step_matches};

    #[test]
    fn asterisks_stay_within_a_step() {
        assert!(matches("joints.guide *.stiffness.x", "joints.guide A.stiffness.x"));
        assert!(!matches("joints.*", "joints.guide A.stiffness.x"));
        assert!(!matches("joints.guide *.stiffness.x", "joints.guide A.stiffness.y"));
        assert!(step_matches("*bearing*", "front bearing 1") && !step_matches("*bearing", "front bearing 1"));
        assert!(step_matches("*", "") && !step_matches("", "a"));
    }
}
