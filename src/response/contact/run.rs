//! Stepping with friction and backlash.

use super::reduced::reduced;
use super::solve::{Branch, Problem, Solution, solve};
use super::span::Span;
use super::{Element, Law};
use crate::interrupt::Interrupt;
use crate::response::{Forces, History, Plant, Recording, ResponseError};
use crate::state_space::ModeStep;
use nalgebra::DVector;

/// What happened to a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// A sliding joint stopped.
    Stops,
    /// A sticking joint began to slide.
    Slides,
    /// The play was taken up.
    Touches,
    /// The contact was left.
    Leaves,
}

/// One event.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When, s. Stops are located inside a step; the others are given at the step's end.
    pub time: f64,
    /// Index into the elements.
    pub element: usize,
    /// What happened.
    pub kind: EventKind,
}

/// A time history with nonlinear joints.
#[derive(Clone, Debug)]
pub struct ContactHistory {
    /// Motions of the outputs.
    pub history: History,
    /// Relative motion e of each element, side 1 against side 0, `[sample, element]`, m.
    pub relative: Vec<f64>,
    /// Its rate, `[sample, element]`, m/s; 0 where friction holds.
    pub speed: Vec<f64>,
    /// Tension lambda of each element over the step before each sample, `[sample, element]`, N.
    pub tension: Vec<f64>,
    /// Force with which each joint draws side 1 back to side 0, `[sample, element]`, N: friction's lambda, against the
    /// sliding; of a screw with play its spring's whole force k e + lambda, 0 inside the play.
    pub force: Vec<f64>,
    /// Events in order.
    pub events: Vec<Event>,
}

/// Reversals that are located in one step; further ones wait for its end.
const SPLITS: usize = 8;
/// Share of a holding joint's drift that is taken back in a step.
const RECOVERED: f64 = 0.2;

struct Stepper<'a> {
    plant: Plant,
    elements: &'a [Element],
    q: Vec<f64>,
    v: Vec<f64>,
    /// Tensions at the end of the last step.
    held: Vec<f64>,
    /// Where each joint with friction holds, m.
    anchors: Vec<f64>,
    branches: Vec<Branch>,
    events: Vec<Event>,
    /// The static part of each relative motion at the last recorded sample, m.
    still: Vec<f64>,
}

/// The response from an initial state (rest if `initial` is `None`: modal displacements and rates).
///
/// Modes with omega h above 2 follow the force statically and do not move the joints. Friction starts
/// sticking.
///
/// # Errors
/// [`ResponseError::Contact`] if a law's step is not well-posed; [`ResponseError::Interrupted`].
///
/// # Accuracy
/// Second order in the step; a Coulomb slider's stop is exact.
pub fn simulate_contact(
    plant: &Plant,
    elements: &[Element],
    forces: &Forces,
    recording: Recording,
    initial: Option<[&[f64]; 2]>,
    interrupt: &Interrupt,
) -> Result<ContactHistory, ResponseError> {
    let h = forces.step;
    let (plant, elements) = reduced(plant, elements, h);
    let n = plant.omega.len();
    let start = |of: usize| initial.map_or_else(|| vec![0.0; n], |state| state[of][..n].to_vec());
    let mut stepper = Stepper {
        q: start(0),
        v: start(1),
        held: vec![0.0; elements.len()],
        anchors: vec![0.0; elements.len()],
        branches: Vec::new(),
        events: Vec::new(),
        still: Vec::new(),
        elements: &elements,
        plant,
    };
    stepper.begin();
    let whole = Span::new(&stepper.plant, &elements, h)?;
    let (m, n_inputs) = (elements.len(), forces.inputs.len());
    let mut out = ContactHistory {
        history: History { step: h, n_outputs: stepper.plant.outputs.nrows(), ..History::default() },
        relative: Vec::with_capacity(m * forces.samples()),
        speed: Vec::with_capacity(m * forces.samples()),
        force: Vec::with_capacity(m * forces.samples()),
        tension: Vec::with_capacity(m * forces.samples()),
        events: Vec::new(),
    };
    let room = |wanted: bool| wanted.then(Vec::new);
    (out.history.velocity, out.history.acceleration) = (room(recording.velocity), room(recording.acceleration));
    let mut tension = stepper.held.clone();
    for (k, u) in forces.values.chunks_exact(n_inputs).enumerate() {
        if k > 0 {
            let before = &forces.values[(k - 1) * n_inputs..][..n_inputs];
            tension = stepper.advance(forces.time(k - 1), h, &whole, before, u)?;
            if k % 1024 == 0 && interrupt.requested() {
                return Err(ResponseError::Interrupted);
            }
        }
        stepper.record(&mut out, u, &tension);
    }
    out.history.last = [stepper.q.clone(), stepper.v.clone()];
    out.events = stepper.events;
    Ok(out)
}

impl Stepper<'_> {
    /// Branches and backlash tensions of the initial state.
    fn begin(&mut self) {
        for (i, element) in self.elements.iter().enumerate() {
            let dot = |x: &[f64]| element.row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
            self.anchors[i] = dot(&self.q);
            self.branches.push(match element.law {
                Law::Friction(_) => match dot(&self.v) {
                    0.0 => Branch::Sticks,
                    speed => Branch::Slides(if speed > 0.0 { 1 } else { -1 }),
                },
                Law::Backlash { gap, stiffness } => {
                    // e = j q - c lambda with lambda = -k clamp(e).
                    let free = dot(&self.q);
                    let inside = free / (1.0 - element.flexibility * stiffness);
                    let e = if inside.abs() <= gap / 2.0 { inside } else { gap / 2.0 * free.signum() };
                    self.held[i] = -stiffness * e;
                    if inside.abs() <= gap / 2.0 {
                        Branch::Inside
                    } else {
                        Branch::Touches(if free > 0.0 { 1 } else { -1 })
                    }
                }
            });
        }
    }

    /// One sample's step, split where sliding reverses; returns the tensions at its end.
    fn advance(
        &mut self,
        start: f64,
        h: f64,
        whole: &Span,
        before: &[f64],
        after: &[f64],
    ) -> Result<Vec<f64>, ResponseError> {
        let force = |t: f64| -> Vec<f64> { before.iter().zip(after).map(|(a, b)| a + (b - a) * t / h).collect() };
        let mut done = 0.0;
        let mut splits = 0;
        loop {
            let left = h - done;
            let own;
            let span = if done == 0.0 {
                whole
            } else {
                own = Span::new(&self.plant, self.elements, left)?;
                &own
            };
            let (from, to) = (force(done), after);
            let solution = self.solution(span, left, &from, to)?;
            let reversal = (splits < SPLITS).then(|| self.reversal(&solution, left, &from, to)).flatten();
            let Some((element, time)) = reversal else {
                self.commit(span, &from, to, &solution, start + h);
                return Ok(solution.lambda.as_slice().to_vec());
            };
            splits += 1;
            // A reversal at the very beginning needs no step of its own.
            if time > 1e-9 * h {
                let part = Span::new(&self.plant, self.elements, time)?;
                let until = force(done + time);
                let mut partial = self.solution(&part, time, &from, &until)?;
                partial.branches[element] = Branch::Sticks;
                self.commit(&part, &from, &until, &partial, start + done + time);
                done += time;
            } else {
                self.branches[element] = Branch::Sticks;
                self.events.push(Event { time: start + done, element, kind: EventKind::Stops });
            }
            if h - done <= 1e-9 * h {
                return Ok(self.held.clone());
            }
        }
    }

    fn modal_force(&self, r: usize, u: &[f64]) -> f64 {
        u.iter().enumerate().map(|(j, u)| self.plant.inputs[(j, r)] * u).sum()
    }

    /// Modal state after a step with given tensions (none of this step's where `lambda` is `None`).
    fn flow(&self, steps: &[ModeStep], from: &[f64], to: &[f64], lambda: Option<&[f64]>) -> (Vec<f64>, Vec<f64>) {
        let mut out = (vec![0.0; steps.len()], vec![0.0; steps.len()]);
        for (r, s) in steps.iter().enumerate() {
            let (mut f0, mut f1, mut constant) = (self.modal_force(r, from), self.modal_force(r, to), 0.0);
            for (i, e) in self.elements.iter().enumerate() {
                match e.law {
                    Law::Friction(_) => constant -= lambda.map_or(0.0, |l| e.row[r] * l[i]),
                    Law::Backlash { .. } => {
                        f0 -= e.row[r] * self.held[i];
                        f1 -= lambda.map_or(0.0, |l| e.row[r] * l[i]);
                    }
                }
            }
            let row = |k: usize| {
                s.phi[k][0] * self.q[r]
                    + s.phi[k][1] * self.v[r]
                    + s.from[k] * f0
                    + s.to[k] * f1
                    + s.constant[k] * constant
            };
            (out.0[r], out.1[r]) = (row(0), row(1));
        }
        out
    }

    fn seen(&self, i: usize, q: &[f64], v: &[f64]) -> f64 {
        let e = &self.elements[i];
        let of = if matches!(e.law, Law::Friction(_)) { v } else { q };
        e.row.iter().zip(of).map(|(a, b)| a * b).sum()
    }

    /// Relative motion e of an element under forces u, m.
    fn relative(&self, i: usize, u: &[f64]) -> f64 {
        let e = &self.elements[i];
        let motion: f64 = e.row.iter().zip(&self.q).map(|(a, b)| a * b).sum();
        let ports: f64 = e.inputs.iter().zip(u).map(|(c, u)| c * u).sum();
        motion + ports - self.held.iter().enumerate().map(|(k, l)| e.towards(i, k) * l).sum::<f64>()
    }

    fn solution(&self, span: &Span, time: f64, from: &[f64], to: &[f64]) -> Result<Solution, ResponseError> {
        let (q, v) = self.flow(&span.steps, from, to, None);
        let m = self.elements.len();
        let rubs = |i: usize| matches!(self.elements[i].law, Law::Friction(_));
        let end = span.end;
        let free = DVector::from_fn(m, |i, _| {
            let e = &self.elements[i];
            let by_ports = |u: &[f64]| e.inputs.iter().zip(u).map(|(c, u)| c * u).sum::<f64>();
            let held = |k: usize| e.towards(i, k) * self.held[k];
            let now = self.seen(i, &q, &v);
            if rubs(i) {
                let before = if end < 1.0 { (1.0 - end) * self.seen(i, &self.q, &self.v) } else { 0.0 };
                let recovers = |k: usize| if rubs(k) { held(k) / (end * span.time) } else { held(k) / span.time };
                let ports = (by_ports(to) - by_ports(from)) / span.time;
                // A sum of speeds drifts from the place where the joint holds; a share of it is taken back each step.
                let drift =
                    if e.flexibility > 0.0 { RECOVERED * (self.relative(i, from) - self.anchors[i]) } else { 0.0 };
                before + end * now + ports + drift / span.time + (0..m).map(recovers).sum::<f64>()
            } else {
                let before = |k: usize| if rubs(k) { (1.0 - end) / end * held(k) } else { 0.0 };
                now + by_ports(to) + (0..m).map(before).sum::<f64>()
            }
        });
        let speeds: Vec<f64> = (0..m).map(|i| self.seen(i, &self.q, &self.v).abs()).collect();
        let problem = Problem { free, influence: span.influence.clone() };
        solve(&problem, self.elements, &self.branches, &speeds).ok_or_else(|| ResponseError::Contact {
            joint: self.elements.first().map_or_else(String::new, |e| e.joint.clone()),
            problem: "the joints find no common state".into(),
            step: time,
        })
    }

    /// The first place inside a step where a joint that slides comes to rest. Until then all that slide go on.
    fn reversal(&self, solution: &Solution, time: f64, from: &[f64], to: &[f64]) -> Option<(usize, f64)> {
        let mut lambda = solution.lambda.as_slice().to_vec();
        let mut turning = Vec::new();
        for (i, element) in self.elements.iter().enumerate() {
            // A joint whose sides give comes to rest while its force falls, without a jump that had to be located.
            if let (Law::Friction(f), Branch::Slides(s)) = (&element.law, self.branches[i])
                && element.flexibility == 0.0
                && solution.branches[i] != Branch::Slides(s)
            {
                let speed = self.seen(i, &self.q, &self.v);
                lambda[i] = f64::from(s) * 0.5 * (f.at(speed.abs()) + f.at(0.0));
                turning.push((i, f64::from(s), speed));
            }
        }
        let mut first: Option<(usize, f64)> = None;
        for (i, sign, speed) in turning {
            if sign * speed <= 0.0 {
                return Some((i, 0.0));
            }
            let at = |t: f64| {
                let until: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + (b - a) * t / time).collect();
                let now: Vec<f64> = (0..lambda.len())
                    .map(|k| match self.elements[k].law {
                        Law::Friction(_) => lambda[k],
                        Law::Backlash { .. } => self.held[k] + (lambda[k] - self.held[k]) * t / time,
                    })
                    .collect();
                let (q, v) = self.flow(&self.plant.steps(t), from, &until, Some(&now));
                sign * self.seen(i, &q, &v)
            };
            if at(time) >= 0.0 {
                continue;
            }
            let (mut low, mut high) = (0.0, time);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if at(middle) > 0.0 { low = middle } else { high = middle }
            }
            if first.is_none_or(|(_, t)| high < t) {
                first = Some((i, high));
            }
        }
        first
    }

    fn commit(&mut self, span: &Span, from: &[f64], to: &[f64], solution: &Solution, time: f64) {
        let lambda = solution.lambda.as_slice();
        let (q, v) = self.flow(&span.steps, from, to, Some(lambda));
        (self.q, self.v) = (q, v);
        for (i, element) in self.elements.iter().enumerate() {
            self.held[i] = match (element.law, solution.branches[i]) {
                // Friction's tension is the mean over the step; of a joint that holds, its end follows from its beginning.
                (Law::Friction(_), Branch::Sticks) => (lambda[i] - (1.0 - span.end) * self.held[i]) / span.end,
                _ => lambda[i],
            };
            let kind = match (self.branches[i], solution.branches[i]) {
                (Branch::Slides(_), Branch::Sticks) => EventKind::Stops,
                (Branch::Sticks, Branch::Slides(_)) => EventKind::Slides,
                (Branch::Inside, Branch::Touches(_)) => EventKind::Touches,
                (Branch::Touches(_), Branch::Inside) => EventKind::Leaves,
                _ => continue,
            };
            self.events.push(Event { time, element: i, kind });
        }
        for (i, branch) in solution.branches.iter().enumerate() {
            if *branch != Branch::Sticks {
                self.anchors[i] = self.relative(i, to);
            }
        }
        self.branches.clone_from(&solution.branches);
    }

    fn record(&mut self, out: &mut ContactHistory, u: &[f64], tension: &[f64]) {
        let p = &self.plant;
        for i in 0..p.outputs.nrows() {
            let sum = |x: &dyn Fn(usize) -> f64| (0..p.omega.len()).map(|r| p.outputs[(i, r)] * x(r)).sum::<f64>();
            let of_ports: f64 = u.iter().enumerate().map(|(j, u)| p.direct[(i, j)] * u).sum();
            let of_joints: f64 =
                self.elements.iter().zip(&self.held).map(|(e, l)| e.outputs.get(i).copied().unwrap_or(0.0) * l).sum();
            let direct = of_ports - of_joints;
            out.history.displacement.push(sum(&|r| self.q[r]) + direct);
            if let Some(list) = &mut out.history.velocity {
                list.push(sum(&|r| self.v[r]));
            }
            if let Some(list) = &mut out.history.acceleration {
                list.push(sum(&|r| {
                    let joints: f64 = self.elements.iter().zip(tension).map(|(e, l)| e.row[r] * l).sum();
                    self.modal_force(r, u)
                        - joints
                        - 2.0 * p.zeta[r] * p.omega[r] * self.v[r]
                        - p.omega[r].powi(2) * self.q[r]
                }));
            }
        }
        for (i, l) in tension.iter().enumerate() {
            let e = self.relative(i, u);
            out.relative.push(e);
            out.tension.push(*l);
            out.force.push(match self.elements[i].law {
                Law::Friction(_) => *l,
                Law::Backlash { gap, stiffness } => stiffness * (e - e.clamp(-gap / 2.0, gap / 2.0)),
            });
        }
        let dot = |i: usize, x: &[f64]| self.elements[i].row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
        let still: Vec<f64> = (0..tension.len()).map(|i| self.relative(i, u) - dot(i, &self.q)).collect();
        for (i, now) in still.iter().enumerate() {
            let given_way = self.still.get(i).map_or(0.0, |before| (now - before) / out.history.step);
            let holds = self.branches[i] == Branch::Sticks;
            out.speed.push(if holds { 0.0 } else { dot(i, &self.v) + given_way });
        }
        self.still = still;
    }
}
