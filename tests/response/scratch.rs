//! scratch
use super::moving::{path_model, sine};
use super::{apart, mill};
use stiffmap::interrupt::Interrupt;
use stiffmap::response::moving::*;
use stiffmap::response::*;

#[test]
fn scratch_path() {
    let _ = mill();
    let range = [-0.3, -0.285];
    let forces = sine(0.03, 20e3);
    let path = Path::constant_speed(-0.285, -0.3, 0.5).unwrap();
    for h in [40, 8] {
        let hold = TravelOptions { hold: h, ..TravelOptions::default() };
        let go = |o: PathOptions| {
            let m = path_model(range, o);
            let t = std::time::Instant::now();
            let out = travel(&m, &path, &forces, hold, &Interrupt::default(), &|| ()).unwrap();
            (m.n(), out.history.displacement, t.elapsed())
        };
        let b = PathOptions::up_to(900.0);
        let whole = go(PathOptions { band: f64::INFINITY, ..b });
        for (band, training, tolerance) in [
            (1800.0, 0.02, 1e-3),
            (1800.0, 0.01, 1e-3),
            (1800.0, 0.02, 3e-3),
            (1800.0, 0.02, 3e-4),
            (1200.0, 0.02, 1e-3),
            (900.0, 0.02, 1e-3),
            (2700.0, 0.02, 1e-3),
        ] {
            let r = go(PathOptions { band, training, tolerance, ..b });
            println!(
                "hold {h} band {band} training {training} tol {tolerance}: n {} of {} err {:.1e}  {:?}",
                r.0,
                whole.0,
                apart(&r.1, &whole.1),
                r.2
            );
        }
    }
    for range in [[-0.3, -0.1], [-0.6, 0.0]] {
        for (band, training, tolerance) in
            [(1800.0, 0.02, 1e-3), (1800.0, 0.02, 3e-3), (1200.0, 0.02, 1e-3), (1200.0, 0.02, 3e-3)]
        {
            let t = std::time::Instant::now();
            let m = path_model(range, PathOptions { band, training, tolerance, spacing: 0.001 });
            println!("{range:?} band {band} tol {tolerance}: n {} {:?}", m.n(), t.elapsed());
        }
    }
}
