//! What can be wrong with a request or a grid.

/// Why a map could not be computed.
#[derive(Debug, thiserror::Error)]
pub enum FrfError {
    /// No degree of the residual polynomial meets the tolerance.
    #[error(
        "the modes above twice the band differ from a polynomial of degree {degree} by {error:.1e}, {tolerance:.0e} is \
         allowed; raise the number of component modes"
    )]
    Truncation {
        /// Highest degree tried.
        degree: usize,
        /// Relative Frobenius difference left.
        error: f64,
        /// Difference allowed.
        tolerance: f64,
    },
    /// A damper, projected on the modes, leaves one of them without oscillation.
    #[error(
        "the mode at {frequency:.1} Hz has a damping ratio of {ratio:.2} by dampers that are projected on it, which \
         describes no mode; take solution = \"exact\" in the damping table, or look for a damper that is too strong"
    )]
    Overdamped {
        /// Natural frequency, Hz.
        frequency: f64,
        /// Damping ratio.
        ratio: f64,
    },
    /// The complex modes of parts with loss factors could not be had.
    #[error(
        "the complex modes of parts with loss factors, {n} of them, could not be had; give the damping table          solution = \"projected\""
    )]
    Eigen {
        /// Number of modes.
        n: usize,
    },
    /// There is nothing to compute.
    #[error("the list of {what} is empty; give at least one")]
    Empty {
        /// Positions, frequencies, outputs or inputs.
        what: &'static str,
    },
    /// A frequency of the grid is no frequency.
    #[error("frequency {index} of the grid is {value} Hz; allowed are 0 and {LOWEST:e} to {HIGHEST:e} Hz", LOWEST = crate::frf::LOWEST_FREQUENCY, HIGHEST = crate::frf::HIGHEST_FREQUENCY)]
    BadFrequency {
        /// Index in the grid.
        index: usize,
        /// Value seen, Hz.
        value: f64,
    },
    /// The grid does not ascend.
    #[error("frequency {index} of the grid is {value} Hz after {previous} Hz; the grid must ascend strictly")]
    NotAscending {
        /// Index in the grid.
        index: usize,
        /// The frequency before, Hz.
        previous: f64,
        /// Value seen, Hz.
        value: f64,
    },
    /// A position is NaN or infinite.
    #[error("position {index} is {value} m; it must be finite")]
    BadPosition {
        /// Index of the position.
        index: usize,
        /// Value seen, m.
        value: f64,
    },
    /// A mode's frequency, damping or shape is not usable.
    #[error("mode {mode} at position {position}: {what} is {value}; allowed: {allowed}")]
    BadMode {
        /// Index of the position.
        position: usize,
        /// Index of the mode, from 0.
        mode: usize,
        /// Which number.
        what: &'static str,
        /// Value seen.
        value: f64,
        /// Values allowed.
        allowed: &'static str,
    },
    /// A residual coefficient is NaN or infinite.
    #[error("residual coefficient {degree} at position {position} holds a value that is not finite")]
    BadResidual {
        /// Index of the position.
        position: usize,
        /// Power of j omega.
        degree: usize,
    },
    /// An undamped mode is evaluated exactly at its own frequency, where the response has no bound.
    #[error(
        "mode {mode} at position {position} has no damping and the grid holds its frequency {frequency} Hz, where the response is unbounded; give damping, leave the mode out, or move the grid"
    )]
    Singular {
        /// Index of the position.
        position: usize,
        /// Index of the mode, from 0.
        mode: usize,
        /// Frequency, Hz.
        frequency: f64,
    },
    /// Receptance or mobility at 0 Hz of a machine that moves freely.
    #[error(
        "at position {position} m nothing resists {}, so the {quantity} at 0 Hz is infinite; hold what moves (a joint to \
         a part that is held, a stiffness in that direction, `clamped` or `supported` nodes), or begin the frequencies \
         above 0 Hz; the accelerance is finite there",
        motions(*count, moves)
    )]
    FreeMotion {
        /// Position, m.
        position: f64,
        /// Free motions that the ports feel.
        count: usize,
        /// What moves and how; empty where that is not known.
        moves: Vec<String>,
        /// Receptance or mobility.
        quantity: &'static str,
    },
    /// A grid's description is not usable.
    #[error("frequency grid: {what} is {value}; allowed: {allowed}")]
    BadGrid {
        /// Which number.
        what: &'static str,
        /// Value seen.
        value: f64,
        /// Values allowed.
        allowed: &'static str,
    },
    /// The receiver of tiles failed.
    #[error("the receiver of the map's tiles failed at position {position}: {source}")]
    Sink {
        /// Index of the tile's first position.
        position: usize,
        /// What the receiver said.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// Free motions in words.
fn motions(count: usize, moves: &[String]) -> String {
    let plural = if count == 1 { "" } else { "s" };
    let counted = format!("{count} rigid motion{plural} that the ports feel");
    if moves.is_empty() { counted } else { format!("{counted} ({})", moves.join("; ")) }
}
