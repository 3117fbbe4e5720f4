//! Names for motions at 0 Hz.

use crate::coupling::CoupledModel;
use crate::solid::axis_name;
use nalgebra::{DVector, Vector3};

/// Says in words which part moves and how: `spindle turns about z`.
pub(super) fn describe(model: &CoupledModel, shape: &DVector<f64>) -> String {
    let shares: Vec<f64> = model.parts.iter().map(|part| (&part.basis * shape).norm_squared()).collect();
    let total: f64 = shares.iter().sum();
    let Some((part, share)) = shares.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) else {
        return "nothing moves".into();
    };
    if *share < 0.99 * total {
        let moving: Vec<&str> = shares
            .iter()
            .zip(&model.parts)
            .filter(|(s, _)| **s > 0.01 * total)
            .map(|(_, part)| part.name.as_str())
            .collect();
        return format!("{} move together", moving.join(", "));
    }
    let part = &model.parts[part];
    let impulse = &part.impulses * shape;
    if impulse.len() < 6 {
        // Single directions are held: its motions are combinations of the six.
        return format!("{} moves as its supports leave it free", part.name);
    }
    let velocity = Vector3::new(impulse[0], impulse[1], impulse[2]) / part.mass;
    let momentum = Vector3::new(impulse[3], impulse[4], impulse[5]);
    let turn = part.inertia.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * momentum);
    let (verb, direction) = if turn.dot(&momentum) > part.mass * velocity.norm_squared() {
        ("turns about", turn)
    } else {
        ("slides along", velocity)
    };
    format!("{} {verb} {}", part.name, axis_name(direction))
}
