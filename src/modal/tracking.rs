//! Families of modes over the travel.
//!
//! From station to station modes are matched by the assignment with the largest sum of MAC values;
//! in the fixed basis (M = I) the MAC of two shapes is (a . b)^2. Where a mode's match is below 0.9,
//! positions in between are solved and matched one after the other. What is still below 0.9 at the
//! finest spacing is a veering: two families exchange their shapes, and which label goes on is a
//! convention; the pair is reported.

use super::{ModalError, ModeFamilies, ModeTableRow, Modes, TrackedMode, Veering};
use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;

/// A match whose MAC is at least this is taken.
const GOOD_MAC: f64 = 0.9;
/// Bisections between two stations at most.
const BISECTIONS: usize = 6;
/// Modes beyond the reported ones that take part in the matching, so that families may leave and return.
const MARGIN: usize = 8;

/// Tracks the lowest modes over the positions: `reported` elastic ones and all free motions.
///
/// `solve` gives the modes at a position between two stations.
///
/// # Errors
/// What `solve` returns.
pub fn track(
    stations: &[Modes],
    reported: usize,
    solve: &dyn Fn(f64) -> Result<Modes, ModalError>,
) -> Result<ModeFamilies, ModalError> {
    let mut tracker = Tracker::new(reported);
    for (i, modes) in stations.iter().enumerate() {
        tracker.follow(i.checked_sub(1).map(|before| &stations[before]), modes, solve)?;
    }
    Ok(tracker.finish())
}

/// [`track`] station by station, for positions whose shapes are not all kept.
#[derive(Debug)]
pub struct Tracker {
    reported: usize,
    /// Family of each mode followed at the last station.
    families: Vec<usize>,
    next_family: usize,
    veerings: Vec<Veering>,
    out: ModeFamilies,
}

impl Tracker {
    /// A tracker that has seen no station.
    pub fn new(reported: usize) -> Tracker {
        Tracker { reported, families: Vec::new(), next_family: 1, veerings: Vec::new(), out: ModeFamilies::default() }
    }

    /// Follows the modes from the last station, `before`, to the next; there is none before the first.
    ///
    /// # Errors
    /// What `solve` returns.
    pub fn follow(
        &mut self,
        before: Option<&Modes>,
        modes: &Modes,
        solve: &dyn Fn(f64) -> Result<Modes, ModalError>,
    ) -> Result<(), ModalError> {
        assert_eq!(before.is_some(), !self.families.is_empty(), "the station before, but at the first");
        let reported = self.reported;
        let followed = |modes: &Modes| (modes.free + reported + MARGIN).min(modes.eigenvalues.len());
        let listed = |modes: &Modes| (modes.free + reported).min(modes.eigenvalues.len());
        let mut now = vec![0; followed(modes)];
        if let Some(before) = before {
            let matched = bridge(before, modes, &followed, listed(before), solve, BISECTIONS)?;
            for (from, &(to, _)) in matched.to.iter().enumerate() {
                if let Some(to) = to {
                    now[to] = self.families[from];
                }
            }
            for (a, b, mac, from, to) in matched.lost {
                self.veerings.push(Veering { from, to, families: [self.families[a], self.families[b]], mac });
            }
        }
        for family in now.iter_mut().filter(|family| **family == 0) {
            *family = self.next_family;
            self.next_family += 1;
        }
        self.out.positions.push(modes.position);
        let row = now.iter().take(listed(modes)).enumerate().map(|(r, &family)| TrackedMode {
            family,
            rank: r + 1,
            frequency: modes.frequency(r),
            damping_ratio: modes.damping_ratios[r] + 0.5 * modes.loss_factors[r],
        });
        self.out.modes.push(row.collect());
        self.families = now;
        Ok(())
    }

    /// The families.
    pub fn finish(self) -> ModeFamilies {
        ModeFamilies { veerings: merge(self.veerings), ..self.out }
    }
}

/// For each mode at the first position its match at the second and the smallest MAC on the way.
struct Match {
    to: Vec<(Option<usize>, f64)>,
    /// (mode, the mode it exchanges shapes with, MAC, from, to), by ranks at the first position.
    lost: Vec<(usize, usize, f64, f64, f64)>,
}

fn bridge(
    a: &Modes,
    b: &Modes,
    followed: &impl Fn(&Modes) -> usize,
    listed: usize,
    solve: &dyn Fn(f64) -> Result<Modes, ModalError>,
    depth: usize,
) -> Result<Match, ModalError> {
    let (rows, columns) = (followed(a), followed(b));
    let mac = nalgebra::DMatrix::from_fn(rows, columns, |i, j| a.shapes.column(i).dot(&b.shapes.column(j)).powi(2));
    let to = assign(&mac);
    // Free motions at one position span a space; which vector is which has no meaning.
    let weak: Vec<usize> = (a.free..listed.min(rows)).filter(|&i| to[i].1 < GOOD_MAC).collect();
    if weak.is_empty() {
        return Ok(Match { to, lost: Vec::new() });
    }
    if depth == 0 {
        let partner = |i: usize| {
            (0..rows).filter(|&o| o != i).max_by(|&o, &p| {
                let shared = |q: usize| to[i].0.map_or(0.0, |j| mac[(q, j)]);
                shared(o).total_cmp(&shared(p))
            })
        };
        let lost = weak.iter().filter_map(|&i| Some((i, partner(i)?, to[i].1, a.position, b.position))).collect();
        return Ok(Match { to, lost });
    }
    let middle = solve(0.5 * (a.position + b.position))?;
    let left = bridge(a, &middle, followed, listed, solve, depth - 1)?;
    let right = bridge(&middle, b, followed, listed, solve, depth - 1)?;
    let mut lost = left.lost;
    let back = |mode: usize| left.to.iter().position(|(t, _)| *t == Some(mode));
    for (i, j, mac, from, to) in right.lost {
        if let (Some(i), Some(j)) = (back(i), back(j)) {
            lost.push((i, j, mac, from, to));
        }
    }
    let to =
        left.to.iter().map(|&(middle, mac)| middle.map_or((None, 0.0), |m| (right.to[m].0, mac.min(right.to[m].1))));
    Ok(Match { to: to.collect(), lost })
}

/// The assignment of rows to columns with the largest sum.
fn assign(mac: &nalgebra::DMatrix<f64>) -> Vec<(Option<usize>, f64)> {
    let (rows, columns) = mac.shape();
    let (few, transposed) = if rows <= columns { (mac.clone(), false) } else { (mac.transpose(), true) };
    let weights = Matrix::from_fn(few.nrows(), few.ncols(), |(i, j)| (few[(i, j)] * 1e12) as i64);
    let (_, chosen) = kuhn_munkres(&weights);
    let mut to = vec![(None, 0.0); rows];
    for (i, j) in chosen.into_iter().enumerate() {
        let (row, column) = if transposed { (j, i) } else { (i, j) };
        to[row] = (Some(column), mac[(row, column)]);
    }
    to
}

/// One line a pair and a place.
fn merge(mut veerings: Vec<Veering>) -> Vec<Veering> {
    for v in &mut veerings {
        v.families.sort_unstable();
    }
    let mut out: Vec<Veering> = Vec::new();
    for v in veerings {
        let (low, high) = (v.from.min(v.to), v.from.max(v.to));
        let touches = |o: &Veering| o.from.min(o.to) <= high + 1e-12 && low <= o.from.max(o.to) + 1e-12;
        match out.iter_mut().find(|o| o.families == v.families && touches(o)) {
            Some(seen) => {
                seen.mac = seen.mac.min(v.mac);
                // The travel may run either way: the line goes on from where it began.
                let ahead = (v.to - seen.from).abs() > (seen.to - seen.from).abs();
                seen.to = if ahead { v.to } else { seen.to };
            }
            None => out.push(v),
        }
    }
    out
}

/// The paper's table 2: range of each family's frequency over the travel, for families that are
/// listed at every position.
pub fn mode_table(families: &ModeFamilies) -> Vec<ModeTableRow> {
    let Some(first) = families.modes.first() else { return Vec::new() };
    let (start, end) = (families.positions[0], families.positions[families.positions.len() - 1]);
    let row = |family: usize| {
        let curve: Option<Vec<(f64, f64)>> = families
            .modes
            .iter()
            .zip(&families.positions)
            .map(|(modes, &p)| modes.iter().find(|m| m.family == family).map(|m| (p, m.frequency)))
            .collect();
        let curve = curve?;
        let min = curve.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let max = curve.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let ends = curve[0].1.min(curve[curve.len() - 1].1)..=curve[0].1.max(curve[curve.len() - 1].1);
        let slack = 1e-9 * max.1;
        let inside = |p: f64| p != start && p != end;
        let beyond = min.1 < ends.start() - slack && inside(min.0) || max.1 > ends.end() + slack && inside(max.0);
        Some(ModeTableRow {
            family,
            min: min.1,
            max: max.1,
            difference_percent: if min.1 > 0.0 { 100.0 * (max.1 - min.1) / min.1 } else { 0.0 },
            position_of_min: min.0,
            position_of_max: max.0,
            interior_extremum: beyond,
            reduction_error: None,
        })
    };
    first.iter().filter_map(|mode| row(mode.family)).collect()
}
