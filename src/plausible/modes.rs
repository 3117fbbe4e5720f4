//! The first modes, once they are known.

use super::Finding;
use super::range::number;

/// Lowest elastic frequency of a machine on the softest mounts, and beyond the smallest stiff one, Hz.
const LOWEST: [f64; 2] = [2.0, 1e4];

/// What is far from any machine in its modes at one position: frequency (Hz) and damping ratio of each, ascending in
/// frequency; free motions at 0 Hz are passed over.
///
/// The ratio is the viscous equivalent zeta + eta / 2.
pub fn modal_findings(position: f64, modes: impl IntoIterator<Item = (f64, f64)>) -> Vec<Finding> {
    let elastic: Vec<(f64, f64)> = modes.into_iter().filter(|(frequency, _)| *frequency > 0.0).collect();
    let mut found = Vec::new();
    let Some(&(lowest, _)) = elastic.first() else { return found };
    if !(LOWEST[0]..=LOWEST[1]).contains(&lowest) {
        let slip = if lowest < LOWEST[0] {
            "likely a stiffness in N/m for N/um, a forgotten joint, or a mesh in the wrong units"
        } else {
            "likely a mesh in the wrong units, or a density in t/mm3 for kg/m3"
        };
        found.push(Finding {
            key: format!("lowest elastic mode at {} m", number(position)),
            seen: format!("{} Hz", number(lowest)),
            usual: "10 to 1000 Hz for a machine tool, from 2 Hz on soft mounts".to_owned(),
            slip: slip.to_owned(),
        });
    }
    if let Some((frequency, ratio)) =
        elastic.iter().max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, ratio)| *ratio > 1.0)
    {
        found.push(Finding {
            key: format!("damping at {} m", number(position)),
            seen: format!("a damping ratio of {} at {} Hz", number(*ratio), number(*frequency)),
            usual: "0.001 to 0.1 for a machine's modes".to_owned(),
            slip: "likely a damper in N s/mm for N s/m; a mode that does not swing back has no resonance in the map"
                .to_owned(),
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::modal_findings;

    #[test]
    fn soft_stiff_and_overdamped_modes_are_told_and_ordinary_ones_are_not() {
        let words = |modes: &[(f64, f64)]| -> Vec<String> {
            modal_findings(0.0, modes.iter().copied()).iter().map(ToString::to_string).collect()
        };
        assert_eq!(words(&[]), Vec::<String>::new());
        assert_eq!(words(&[(0.0, 0.0), (3.0, 0.02), (40.0, 0.9)]), Vec::<String>::new());
        assert!(words(&[(0.0, 0.0), (0.3, 0.02)])[0].contains("0.3 Hz") && words(&[(0.3, 0.02)]).len() == 1);
        assert!(words(&[(3e4, 0.02)])[0].contains("wrong units"));
        let told = words(&[(40.0, 0.02), (300.0, 319.0)]);
        assert!(told.len() == 1 && told[0].contains("ratio of 319 at 300 Hz") && told[0].contains("N s/mm"));
    }
}
