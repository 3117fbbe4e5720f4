//! Pictures: decoded, looked at by numbers; refused input.

mod sample;

#[test]
fn timing() {
    let (families, map) = sample::mill(121, 901);
    let input = stiffmap::figures::FigureInput { machine: "vertical mill", axis: "z", families: &families, map: &map, height: Default::default() };
    let dir = std::path::Path::new("/tmp/figs");
    for _ in 0..2 {
        let t = std::time::Instant::now();
        stiffmap::figures::draw_all(&input, dir).unwrap();
        println!("figures {:?}", t.elapsed());
    }
    let (f1, m1) = sample::mill(1, 901);
    let one = stiffmap::figures::FigureInput { families: &f1, map: &m1, ..input };
    stiffmap::figures::draw_all(&one, &dir.join("one")).unwrap();
    let log = stiffmap::figures::FigureInput { height: stiffmap::figures::HeightScale::Logarithmic, ..input };
    stiffmap::figures::draw_all(&log, &dir.join("log")).unwrap();
    let t = std::time::Instant::now();
    stiffmap::export::mat::write_compliance(&dir.join("compliance.mat"), &map).unwrap();
    println!("compliance {:?}", t.elapsed());
    let t = std::time::Instant::now();
    stiffmap::export::surface::write_direct_surfaces(dir, &map).unwrap();
    println!("surfaces {:?}", t.elapsed());
    let t = std::time::Instant::now();
    stiffmap::export::vts::write_surface(&dir.join("s.vts"), &map, &stiffmap::export::response::direct_responses(&map)[0]).unwrap();
    println!("vts {:?}", t.elapsed());
    use nalgebra::DMatrix;
    let s: Vec<_> = (0..121).map(|i| stiffmap::state_space::StateSpace { position: i as f64, a: DMatrix::zeros(60,60), b: DMatrix::zeros(60,3), c: DMatrix::zeros(3,60), d: DMatrix::zeros(3,3), eigenvalues: vec![1.0;30], eigenvectors: DMatrix::zeros(30,3), damping: vec![0.02;30] }).collect();
    let t = std::time::Instant::now();
    stiffmap::export::mat::write_state_space(&dir.join("state_space.mat"), &s, &map.outputs, &map.inputs).unwrap();
    println!("states {:?}", t.elapsed());
    let t = std::time::Instant::now();
    stiffmap::export::eigenfrequencies::write_families(&dir.join("e.csv"), &families).unwrap();
    println!("families {:?}", t.elapsed());
}
