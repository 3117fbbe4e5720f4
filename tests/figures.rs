//! Pictures: decoded and looked at by numbers; input that is refused.

use std::collections::HashSet;
use std::path::Path;

use nalgebra::Complex;
use stiffmap::figures::{FigureError, FigureInput, HeightScale, draw_all};
use stiffmap::frf::ComplianceMap;
use stiffmap::modal::ModeFamilies;

mod sample;

/// A decoded picture.
struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    fn open(path: &Path) -> Picture {
        let mut reader = png::Decoder::new(std::fs::File::open(path).unwrap()).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        let pixels = bytes.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        Picture { width: info.width as usize, height: info.height as usize, pixels }
    }

    fn at(&self, x: usize, y: usize) -> [u8; 3] {
        self.pixels[y * self.width + x]
    }

    fn colours(&self) -> usize {
        self.pixels.iter().collect::<HashSet<_>>().len()
    }

    /// Pixels of the outermost ring that are not white: something is clipped there.
    fn clipped(&self) -> usize {
        let (w, h) = (self.width, self.height);
        let rows = (0..w).flat_map(|x| [(x, 0), (x, h - 1)]);
        let columns = (0..h).flat_map(|y| [(0, y), (w - 1, y)]);
        rows.chain(columns).filter(|(x, y)| self.at(*x, *y) != [255; 3]).count()
    }
}

fn draw(
    families: &ModeFamilies,
    map: &ComplianceMap,
    height: HeightScale,
) -> Result<Vec<(String, Picture)>, FigureError> {
    let folder = tempfile::tempdir().unwrap();
    let input = FigureInput { machine: "mill", axis: "z", families, map, height };
    let files = draw_all(&input, folder.path())?;
    assert_eq!(files.len(), std::fs::read_dir(folder.path()).unwrap().count(), "nothing else left");
    let name = |p: &Path| p.file_name().unwrap().to_str().unwrap().to_owned();
    let (png, svg): (Vec<_>, Vec<_>) = files.iter().partition(|p| p.extension().is_some_and(|e| e == "png"));
    assert_eq!(
        png.iter().map(|p| p.with_extension("svg")).collect::<Vec<_>>(),
        svg.into_iter().cloned().collect::<Vec<_>>()
    );
    Ok(png.into_iter().map(|p| (name(p), Picture::open(p))).collect())
}

#[test]
fn the_seven_pictures_are_drawn_whole() {
    let (families, map) = sample::mill(15, 120);
    let pictures = draw(&families, &map, HeightScale::Linear).unwrap();
    let names: Vec<&str> = pictures.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "eigenfrequencies.png",
            "frf_xx_amplitude.png",
            "frf_xx_frequency.png",
            "frf_yy_amplitude.png",
            "frf_yy_frequency.png",
            "frf_zz_amplitude.png",
            "frf_zz_frequency.png",
        ]
    );
    for (name, picture) in &pictures {
        assert!(picture.width == 1600 && picture.height >= 1100, "{name}");
        assert!(picture.colours() > 200, "{name} has {} colours", picture.colours());
        assert_eq!(picture.clipped(), 0, "{name} reaches its edge");
    }
}

/// Whether a colour is near the upper end of the colour scale.
fn yellow(c: [u8; 3]) -> bool {
    c[0] > 200 && c[1] > 190 && c[2] < 80
}

/// Rows of the frequency view's map, above the colour bar's reach to the right, that are yellow.
fn bright_rows(picture: &Picture, x: usize) -> Vec<usize> {
    (0..picture.height).filter(|y| yellow(picture.at(x, *y))).collect()
}

#[test]
fn the_frequency_view_shows_a_peak_where_it_is() {
    let (families, mut map) = sample::mill(11, 1801);
    // One sample in a flat map, at 600 of 900 Hz: five times narrower than a row of pixels.
    map.values.fill(Complex::new(1e-9, 0.0));
    for p in 0..11 {
        map.values[(p * 1801 + 1200) * 9] = Complex::new(0.0, -1e-7);
    }
    let pictures = draw(&families, &map, HeightScale::Linear).unwrap();
    let rows = bright_rows(&pictures[2].1, 700);
    assert!(!rows.is_empty(), "the peak is lost");
    // The map fills rows 92 to 970 from 900 Hz down to 0 Hz.
    let expected = 970.0 - 600.0 / 900.0 * (970.0 - 92.0);
    assert!(rows.iter().all(|r| (*r as f64 - expected).abs() < 2.5), "{rows:?} for {expected}");
    let other = bright_rows(&pictures[4].1, 700);
    assert!(other.len() != rows.len(), "control: the y response has no peak there");
}

#[test]
fn the_amplitude_view_differs_between_linear_and_logarithmic_heights() {
    let (families, map) = sample::mill(9, 90);
    let linear = draw(&families, &map, HeightScale::Linear).unwrap();
    let logarithmic = draw(&families, &map, HeightScale::Logarithmic).unwrap();
    let differ = |k: usize| linear[k].1.pixels != logarithmic[k].1.pixels;
    assert!(differ(1) && differ(3) && differ(5));
    assert!(!differ(0) && !differ(2) && !differ(4), "the other pictures do not depend on it");
}

#[test]
fn the_order_of_positions_does_not_matter() {
    let (families, map) = sample::mill(7, 60);
    let (mut turned_families, mut turned) = (families.clone(), map.clone());
    turned_families.positions.reverse();
    turned_families.modes.reverse();
    turned.positions.reverse();
    turned.values = map.values.chunks(60 * 9).rev().flatten().copied().collect();
    let pairs = draw(&families, &map, HeightScale::Linear).unwrap();
    let turned = draw(&turned_families, &turned, HeightScale::Linear).unwrap();
    for ((name, a), (_, b)) in pairs.iter().zip(&turned) {
        assert!(a.pixels == b.pixels, "{name}");
    }
    let control = draw(&turned_families, &map, HeightScale::Linear).unwrap();
    assert!(control[0].1.pixels == pairs[0].1.pixels);
    let mut moved = map.clone();
    moved.values.rotate_right(60 * 9);
    let control = draw(&families, &moved, HeightScale::Linear).unwrap();
    assert!(control[2].1.pixels != pairs[2].1.pixels, "control: other values, other picture");
}

#[test]
fn one_position_or_one_frequency_gives_curves() {
    for (positions, frequencies) in [(1, 80), (9, 1), (1, 1)] {
        let (families, map) = sample::mill(positions, frequencies);
        let pictures = draw(&families, &map, HeightScale::Linear).unwrap();
        assert_eq!(pictures.len(), 7);
        for (name, picture) in &pictures {
            assert!(picture.colours() > 20, "{name} of {positions} x {frequencies}");
            assert_eq!(picture.clipped(), 0, "{name} of {positions} x {frequencies}");
        }
    }
}

#[test]
fn a_constant_map_and_a_map_of_zeros_are_drawn() {
    let (families, mut map) = sample::mill(5, 40);
    for value in [1e-8, 0.0] {
        map.values.fill(Complex::new(value, 0.0));
        for height in [HeightScale::Linear, HeightScale::Logarithmic] {
            let pictures = draw(&families, &map, height).unwrap();
            assert!(pictures.iter().all(|(_, p)| p.colours() > 20 && p.clipped() == 0));
        }
    }
}

#[test]
fn families_that_are_all_free_leave_an_empty_frame() {
    let (mut families, map) = sample::mill(3, 20);
    families.modes.iter_mut().for_each(|modes| modes.truncate(1));
    let pictures = draw(&families, &map, HeightScale::Linear).unwrap();
    assert!(pictures[0].1.colours() > 20);
}

#[test]
fn numbers_that_are_not_finite_are_refused_with_their_place() {
    let (families, map) = sample::mill(3, 20);
    let mut bad = map.clone();
    bad.values[(2 * 20 + 4) * 9 + 4].re = f64::NAN;
    let error = draw(&families, &bad, HeightScale::Linear).err().unwrap().to_string();
    assert!(error.starts_with("frf_yy_"), "{error}");
    assert!(error.contains("response at -0.6 m and 189.4") && error.contains("NaN"), "{error}");
    let mut bad = families.clone();
    bad.modes[1][3].frequency = f64::INFINITY;
    let error = draw(&bad, &map, HeightScale::Linear).err().unwrap().to_string();
    assert!(error.contains("frequency of family 4 at -0.3 m is inf"), "{error}");
    let mut bad = map.clone();
    bad.values.pop();
    let error = draw(&families, &bad, HeightScale::Linear).err().unwrap().to_string();
    assert!(error.contains("the map has 539 entries, expected 540"), "{error}");
}

#[test]
fn the_svg_holds_the_same_strokes_and_the_words_as_outlines() {
    let (families, map) = sample::mill(9, 120);
    let folder = tempfile::tempdir().unwrap();
    let input =
        FigureInput { machine: "a & b", axis: "z", families: &families, map: &map, height: HeightScale::Linear };
    let files = draw_all(&input, folder.path()).unwrap();
    assert_eq!(files.len(), 14);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let lines = read("eigenfrequencies.svg");
    assert!(lines.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"160mm\""));
    assert!(lines.contains("aria-label=\"a &amp; b: eigenfrequencies over position\""), "the heading, escaped");
    assert!(!lines.contains("<image") && !lines.contains("<text"), "lines alone, and no font is asked for");
    // Each of the thirty drawn families is one line through the nine positions.
    let through = |points: usize| {
        let counts =
            lines.split("<polyline points=\"").skip(1).map(|p| p.split('"').next().unwrap().split(' ').count());
        counts.filter(|n| *n == points).count()
    };
    assert_eq!((through(9), through(8)), (30, 0));
    for name in ["frf_xx_amplitude.svg", "frf_xx_frequency.svg"] {
        assert!(read(name).contains("href=\"data:image/png;base64,iVBOR"), "{name}: the surface is an image");
    }
}

#[test]
fn the_answer_to_a_push_is_the_modal_systems() {
    use nalgebra::DMatrix;
    use stiffmap::figures::{ImpulseInput, draw_impulse};
    use stiffmap::frf::{FrfRequest, ModalSystem, Quantity, modal_sum};
    use stiffmap::response::{Plant, spectrum::modal_response};
    let system = ModalSystem {
        frequencies: vec![120.0, 310.0],
        damping_ratios: vec![0.03, 0.02],
        loss_factors: vec![0.0; 2],
        outputs: DMatrix::from_row_slice(1, 2, &[0.2, -0.1]),
        inputs: DMatrix::from_row_slice(2, 2, &[0.2, 0.1, 0.1, 0.3]),
        residual: vec![DMatrix::from_element(1, 2, Complex::new(3e-8, 0.0))],
        exact: None,
    };
    let (outputs, inputs) = (vec!["x".to_owned()], vec!["x".to_owned(), "y".to_owned()]);
    let frequencies: Vec<f64> = (1..500).map(f64::from).collect();
    let request = FrfRequest {
        positions: &[-0.1],
        systems: std::slice::from_ref(&system),
        frequencies: &frequencies,
        outputs: &outputs,
        inputs: &inputs,
        quantity: Quantity::Receptance,
    };
    let map = modal_sum(&request).unwrap();
    let plant = Plant::of_modal_system(-0.1, &system);
    let apart = |plant: &Plant| {
        let difference = |(k, f): (usize, &f64)| {
            (modal_response(plant, &[1.0, 1.0], *f)[0] - map.at(0, k, 0, 0) - map.at(0, k, 0, 1)).norm()
        };
        frequencies.iter().enumerate().map(difference).fold(0.0, f64::max)
    };
    assert!(apart(&plant) < 1e-18, "{:.1e}", apart(&plant));
    assert!(apart(&Plant { direct: plant.direct.scale(0.0), ..plant }) > 1e-8, "control: without the residual");
    let folder = tempfile::tempdir().unwrap();
    let input = ImpulseInput {
        machine: "m",
        axis: "z",
        position: -0.1,
        system: &system,
        outputs: &outputs,
        inputs: &inputs,
        highest: 500.0,
    };
    let files = draw_impulse(&input, folder.path()).unwrap();
    assert_eq!(files.len(), 4);
    for png in files.iter().filter(|f| f.extension().is_some_and(|e| e == "png")) {
        let picture = Picture::open(png);
        assert!(picture.colours() > 8 && picture.clipped() == 0, "{}", png.display());
    }
}
