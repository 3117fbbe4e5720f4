//! The vertical mill that comes with the program.

/// File name and content of every file that the bundled vertical mill needs.
pub fn bundled_vertical_mill() -> &'static [(&'static str, &'static str)] {
    &[
        ("machine.toml", include_str!("../../machines/vertical_mill/machine.toml")),
        ("study.toml", include_str!("../../machines/vertical_mill/study.toml")),
        ("screw.toml", include_str!("../../machines/vertical_mill/screw.toml")),
        ("column.inp", include_str!("../../machines/vertical_mill/column.inp")),
        ("headstock.inp", include_str!("../../machines/vertical_mill/headstock.inp")),
        ("spindle.inp", include_str!("../../machines/vertical_mill/spindle.inp")),
        ("drive.inp", include_str!("../../machines/vertical_mill/drive.inp")),
        ("magazine.inp", include_str!("../../machines/vertical_mill/magazine.inp")),
    ]
}
