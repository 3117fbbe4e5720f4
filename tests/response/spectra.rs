//! Spectra by way of time against the map.

use super::{mill, modes, names};
use nalgebra::Complex;
use stiffmap::frf::{FrfRequest, Quantity, Selection, modal_sum, modal_systems};
use stiffmap::interrupt::Interrupt;
use stiffmap::response::spectrum::{difference_less_folding, difference_to_modes, smoothed, spectra};
use stiffmap::response::{Forces, Plant, Recording, parse_force, simulate_all};

fn impulse(shape: &str, inputs: &[usize], duration: f64) -> Forces {
    let mut forces = Forces::none(&names(), duration, 20e3).unwrap();
    for &j in inputs {
        forces.add(j, &parse_force(&format!("impulse,shape={shape}")).unwrap());
    }
    forces
}

#[test]
fn the_impulse_responses_spectrum_is_the_map_to_a_thousandth_of_the_peak() {
    assert_eq!(mill().machine.analysis.damping.ratios, [0.02]);
    let positions = [0.0, -0.2025, -0.6];
    let solved: Vec<_> = positions.iter().map(|p| modes(*p)).collect();
    let plants: Vec<Plant> = solved.iter().map(Plant::whole).collect();
    // The map as `run` makes it: modes to 1800 Hz and a residual polynomial.
    let (systems, _) = modal_systems(&solved, 900.0, Selection::Controlled { tolerance: 1e-4 }).unwrap();
    for (shape, inputs) in [("half-sine", vec![0, 1, 2]), ("rectangle", vec![0, 1, 2]), ("triangle", vec![0])] {
        let forces = impulse(shape, &inputs, 1.0);
        let histories = simulate_all(&plants, &forces, Recording::default(), &Interrupt::default(), &|| ()).unwrap();
        let found = spectra(&plants, &histories, &forces, &names(), 900.0).unwrap();
        assert_eq!(found.frequencies.len(), 900);
        let request = FrfRequest {
            positions: &positions,
            systems: &systems,
            frequencies: &found.frequencies,
            outputs: &names(),
            inputs: &names(),
            quantity: Quantity::Receptance,
        };
        let map = modal_sum(&request).unwrap();
        let (mut worst, mut control) = (0.0f64, f64::INFINITY);
        for p in 0..positions.len() {
            for i in 0..3 {
                let all: Vec<Complex<f64>> =
                    (0..900).map(|k| inputs.iter().map(|&j| map.at(p, k, i, j)).sum()).collect();
                let peak = all.iter().map(|h| h.norm()).fold(0.0, f64::max);
                let apart = |shift: usize| {
                    let pairs = (4..900 - shift).map(|k| (found.at(p, k + shift, i, 0) - all[k]).norm());
                    pairs.fold(0.0, f64::max) / peak
                };
                worst = worst.max(apart(0));
                control = control.min(apart(1));
            }
        }
        println!("{shape}: {worst:.1e} of the peak");
        assert!(worst < 1e-3, "{shape}: {worst:.1e}");
        assert!(control > 1e-3, "control: one line further it is another response, {control:.1e}");
        let own = difference_to_modes(&found, &plants, &forces, 5.0).unwrap();
        assert!(own < 1e-3, "{own:.1e}");
    }
}

#[test]
fn what_a_blow_of_a_microsecond_leaves_above_half_the_rate_is_known() {
    let plants = [Plant::whole(&modes(-0.35))];
    // The rate is so low that the mill's modes lie on both sides of its half.
    let mut forces = Forces::none(&names(), 2.0, 4e3).unwrap();
    forces.add(0, &parse_force("impulse,shape=rectangle,length=1e-6,amplitude=1e3").unwrap());
    let histories = simulate_all(&plants, &forces, Recording::default(), &Interrupt::default(), &|| ()).unwrap();
    let found = spectra(&plants, &histories, &forces, &names(), 900.0).unwrap();
    let off = difference_to_modes(&found, &plants, &forces, 5.0).unwrap();
    let [left, folded] = difference_less_folding(&found, &plants, &forces, 5.0).unwrap();
    println!("{off:.2e}, less folding {left:.2e}, folded {folded:.2e}");
    // What is left falls as the images that are left out: far below what they explain.
    assert!(left < 1e-3 && left < 0.05 * off, "{off:.1e} {left:.1e} {folded:.1e}");
    assert!(off > 1e-3 && (folded / off - 1.0).abs() < 0.1, "{off:.1e} {folded:.1e}");
    // Another force's images do not explain it.
    let mut longer = forces.clone();
    longer.values[3] += 0.3 * longer.values[0];
    let [control, _] = difference_less_folding(&found, &plants, &longer, 5.0).unwrap();
    assert!(control > 50.0 * left, "{control:.1e}");
}

#[test]
fn the_length_of_the_record_does_not_matter_once_the_pulse_is_over() {
    let plants = [Plant::whole(&modes(-0.35))];
    let spectrum = |duration: f64| {
        let forces = impulse("half-sine", &[0, 1, 2], duration);
        let histories = simulate_all(&plants, &forces, Recording::default(), &Interrupt::default(), &|| ()).unwrap();
        spectra(&plants, &histories, &forces, &names(), 900.0).unwrap()
    };
    let (long, short) = (spectrum(1.0), spectrum(0.05));
    let peak = long.values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    // The short record's lines are every twentieth of the long one's.
    let worst = (0..short.frequencies.len())
        .flat_map(|k| (0..3).map(move |i| (k, i)))
        .map(|(k, i)| (short.at(0, k, i, 0) - long.at(0, 20 * k + 19, i, 0)).norm())
        .fold(0.0, f64::max);
    assert!(worst < 1e-9 * peak, "{:.1e}", worst / peak);
}

#[test]
fn zeros_of_the_pulse_are_left_out_and_endless_forces_refused() {
    let plants = [Plant::whole(&modes(0.0))];
    let forces = impulse("triangle", &[0], 0.5);
    let histories = simulate_all(&plants, &forces, Recording::default(), &Interrupt::default(), &|| ()).unwrap();
    let map = spectra(&plants, &histories, &forces, &names(), 2500.0).unwrap();
    let near = |reach: f64| map.frequencies.iter().filter(|f| (*f - 2000.0).abs() < reach).count();
    assert_eq!(near(3.0), 0, "the pulse has a zero at 2 / length, 2000 Hz");
    assert!(near(200.0) > 50, "{}", near(200.0));
    let mut endless = Forces::none(&names(), 0.1, 20e3).unwrap();
    endless.add(0, &parse_force("sine,frequency=100,phase=50").unwrap());
    let error = spectra(&plants, &histories, &endless, &names(), 900.0).unwrap_err().to_string();
    assert!(error.contains("must be over before the last sample"), "{error}");
    let mut different = impulse("triangle", &[0], 0.5);
    different.add(1, &parse_force("impulse").unwrap());
    let error = spectra(&plants, &histories, &different, &names(), 900.0).unwrap_err().to_string();
    assert!(error.contains("not a multiple"), "{error}");
}

#[test]
fn the_average_over_five_lines_cuts_peaks_and_is_therefore_for_pictures() {
    let plants = [Plant::whole(&modes(0.0))];
    let forces = impulse("half-sine", &[0, 1, 2], 0.5);
    let histories = simulate_all(&plants, &forces, Recording::default(), &Interrupt::default(), &|| ()).unwrap();
    let map = spectra(&plants, &histories, &forces, &names(), 900.0).unwrap();
    let peak = |m: &stiffmap::frf::ComplianceMap| m.values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let cut = peak(&smoothed(&map, 5)) / peak(&map);
    assert!((0.3..0.9).contains(&cut), "{cut}");
    assert_eq!(peak(&smoothed(&map, 1)), peak(&map));
}
