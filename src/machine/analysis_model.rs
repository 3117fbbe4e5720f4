//! The types of what is computed.

/// What to compute.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// Reduction of the parts.
    pub component: ComponentAnalysis,
    /// Elastic modes of each position; free motions at 0 Hz come on top.
    pub modes: usize,
    /// Frequencies of the map, Hz, ascending; of a clustered grid its background alone, until the modes are known.
    pub frequencies: Vec<f64>,
    /// How the frequencies are laid.
    pub grid: Grid,
    /// What the map holds.
    pub quantity: Quantity,
    /// Damping of the coupled modes.
    pub damping: Damping,
}

/// How the frequencies of a map are laid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Grid {
    /// Equal steps.
    #[default]
    Uniform,
    /// Equal ratios.
    Logarithmic,
    /// A uniform background, and frequencies around every mode at every position.
    Clustered {
        /// Frequencies a mode.
        points: usize,
    },
    /// One by one.
    Listed,
}

impl Grid {
    /// Name, as in the machine file.
    pub fn name(self) -> &'static str {
        match self {
            Grid::Uniform => "uniform",
            Grid::Logarithmic => "logarithmic",
            Grid::Clustered { .. } => "clustered",
            Grid::Listed => "listed",
        }
    }
}

/// What a map holds: displacement, velocity or acceleration over force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Quantity {
    /// Displacement over force, m/N.
    #[default]
    Receptance,
    /// Velocity over force, m/(s N).
    Mobility,
    /// Acceleration over force, m/(s^2 N).
    Accelerance,
}

impl Quantity {
    /// Every quantity.
    pub const ALL: [Quantity; 3] = [Quantity::Receptance, Quantity::Mobility, Quantity::Accelerance];

    /// The power of j omega that the receptance is multiplied by.
    pub fn power(self) -> u32 {
        match self {
            Quantity::Receptance => 0,
            Quantity::Mobility => 1,
            Quantity::Accelerance => 2,
        }
    }

    /// Name, as in the machine file.
    pub const fn name(self) -> &'static str {
        match self {
            Quantity::Receptance => "receptance",
            Quantity::Mobility => "mobility",
            Quantity::Accelerance => "accelerance",
        }
    }

    /// The quantity of a name.
    pub fn named(name: &str) -> Option<Quantity> {
        Quantity::ALL.into_iter().find(|q| q.name() == name)
    }
}

/// Reduction of the parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComponentAnalysis {
    /// Component modes a part, at most; at least, where their number follows the frequency.
    pub modes: usize,
    /// Whether the number follows the highest frequency asked for: the file gives neither `modes` nor `band`.
    pub follows: bool,
    /// Component modes above this frequency (Hz) are not kept; infinite for no bound.
    pub band: f64,
    /// Reduction method.
    pub method: ReductionMethod,
    /// Whether K^-1 M K^-1 B is added to K^-1 B.
    pub second_moment: bool,
}

/// Component mode synthesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ReductionMethod {
    /// Constraint modes and fixed-interface modes.
    CraigBampton,
    /// Free-interface modes and attachment modes.
    FreeInterface,
}

/// Damping of the coupled modes; joint dampers and loss factors of parts and joints come on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Damping {
    /// Viscous ratios: one for all modes, or one a mode (the last is kept for those beyond the list).
    pub ratios: Vec<f64>,
    /// Rayleigh damping C = alpha M + beta K: (alpha in 1/s, beta in s).
    pub rayleigh: Option<[f64; 2]>,
    /// Structural loss factor of the whole machine.
    pub loss_factor: f64,
    /// Whether dampers and loss factors of joints and parts are projected on the undamped modes, which leaves out what
    /// couples them; otherwise responses are exact.
    pub projected: bool,
}
