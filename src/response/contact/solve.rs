//! The laws at the end of a step: a small complementarity problem.

use super::{Element, Law};
use nalgebra::{DMatrix, DVector};

/// Where a law is on its graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Branch {
    /// Friction holds: e' = 0.
    Sticks,
    /// Friction slides in this direction.
    Slides(i8),
    /// Backlash inside its play.
    Inside,
    /// Backlash in contact on this side.
    Touches(i8),
}

/// The motions that the laws see at the end of a step: free + influence times lambda, velocities for
/// friction, displacements for backlash.
pub(super) struct Problem {
    /// Without any lambda of this step.
    pub free: DVector<f64>,
    /// Minus the motion of row a for a unit lambda of column b, with the own flexibility of backlash.
    pub influence: DMatrix<f64>,
}

/// A solution.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    pub lambda: DVector<f64>,
    pub branches: Vec<Branch>,
}

/// Rounds of the active set before it is given up.
const ROUNDS: usize = 200;
/// Singular values below this share belong to forces that the motion does not determine.
const SHARED: f64 = 1e-9;
/// Rounds in which the friction force follows the speed.
const SPEEDS: usize = 60;

/// Solves the laws. `speed_before` gives the sliding speed at the beginning of the step, with which the
/// Stribeck force of a sliding joint is averaged. `None` if the active set does not settle.
pub(super) fn solve(
    problem: &Problem,
    elements: &[Element],
    before: &[Branch],
    speed_before: &[f64],
) -> Option<Solution> {
    let mut branches = before.to_vec();
    let mut speed: Vec<f64> = speed_before.to_vec();
    for round in 0..ROUNDS {
        let (lambda, motion) = linear(problem, elements, &branches, &speed, speed_before)?;
        let mut changed = None;
        let mut worst = 0.0;
        for (i, element) in elements.iter().enumerate() {
            let (next, excess) = check(element, branches[i], lambda[i], motion[i]);
            // One at a time, the worst first, keeps the set from cycling; late rounds take the first found.
            if next != branches[i] && (excess > worst || changed.is_none()) && (round < ROUNDS / 2 || changed.is_none())
            {
                worst = excess;
                changed = Some((i, next));
            }
        }
        if let Some((i, next)) = changed {
            branches[i] = next;
            continue;
        }
        let (mut lambda, mut motion) = (lambda, motion);
        for _ in 0..SPEEDS {
            let mut moved = 0.0f64;
            for (i, element) in elements.iter().enumerate() {
                if let (Law::Friction(f), Branch::Slides(_)) = (&element.law, branches[i]) {
                    if f.breakaway > f.coulomb {
                        moved = moved.max((motion[i].abs() - speed[i]).abs() / f.stribeck);
                    }
                    speed[i] = motion[i].abs();
                }
            }
            if moved < 1e-13 {
                break;
            }
            (lambda, motion) = linear(problem, elements, &branches, &speed, speed_before)?;
        }
        return Some(Solution { lambda, branches });
    }
    None
}

/// lambda and motion for given branches.
fn linear(
    problem: &Problem,
    elements: &[Element],
    branches: &[Branch],
    speed: &[f64],
    speed_before: &[f64],
) -> Option<(DVector<f64>, DVector<f64>)> {
    let n = elements.len();
    let mut matrix = DMatrix::identity(n, n);
    let mut right = DVector::zeros(n);
    for (i, element) in elements.iter().enumerate() {
        match (&element.law, branches[i]) {
            (Law::Friction(f), Branch::Slides(s)) => {
                right[i] = f64::from(s) * 0.5 * (f.at(speed[i]) + f.at(speed_before[i]));
            }
            (Law::Backlash { gap, stiffness }, Branch::Touches(s)) => right[i] = -f64::from(s) * stiffness * gap / 2.0,
            (Law::Backlash { stiffness, .. }, _) => {
                // lambda + k (free - W lambda) = 0.
                for j in 0..n {
                    matrix[(i, j)] -= stiffness * problem.influence[(i, j)];
                }
                right[i] = -stiffness * problem.free[i];
            }
            _ => {
                // Scaled to forces, so that the rows are alike.
                for j in 0..n {
                    matrix[(i, j)] = problem.influence[(i, j)] / problem.influence[(i, i)];
                }
                right[i] = problem.free[i] / problem.influence[(i, i)];
            }
        }
    }
    let sticking = branches.iter().filter(|b| **b == Branch::Sticks).count();
    let lambda = if sticking < 2 {
        matrix.lu().solve(&right)?
    } else {
        // Joints side by side on a stiff part share what holds them: the smallest of the solutions.
        matrix.svd(true, true).solve(&right, SHARED).ok()?
    };
    let motion = &problem.free - &problem.influence * &lambda;
    Some((lambda, motion))
}

/// The branch that a law should be on, and by how much it is off the one that it is on.
fn check(element: &Element, branch: Branch, lambda: f64, motion: f64) -> (Branch, f64) {
    match (&element.law, branch) {
        (Law::Friction(f), Branch::Sticks) => {
            let excess = lambda.abs() / f.breakaway.max(f64::MIN_POSITIVE) - 1.0;
            let slides = excess > 1e-12;
            if slides { (Branch::Slides(if lambda > 0.0 { 1 } else { -1 }), excess) } else { (branch, 0.0) }
        }
        (Law::Friction(_), Branch::Slides(s)) if f64::from(s) * motion < 0.0 => (Branch::Sticks, motion.abs()),
        (Law::Backlash { gap, .. }, Branch::Touches(s)) if f64::from(s) * motion < gap / 2.0 => {
            (Branch::Inside, gap / 2.0 - f64::from(s) * motion)
        }
        (Law::Backlash { gap, .. }, Branch::Inside) if motion.abs() > gap / 2.0 => {
            (Branch::Touches(if motion > 0.0 { 1 } else { -1 }), motion.abs() - gap / 2.0)
        }
        _ => (branch, 0.0),
    }
}
