//! Every shader parses and validates, and agrees with the Rust side. Needs no adapter.

use std::mem::{offset_of, size_of};

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};
use stiffmap::gpu;
use stiffmap::gpu::shader::{
    CHUNK, CORE, Extrema, Kernel, MAX_DUOS, MAX_ROWS, Maxima, Params, Precision, SHARE, SpringParams, Variant,
    WORKGROUP,
};

fn changes_springs(kernel: Kernel) -> bool {
    matches!(kernel, Kernel::Modification | Kernel::Extrema)
}

fn variants() -> impl Iterator<Item = Variant> {
    const SIZES: [(usize, usize); 4] = [(0, 1), (1, 3), (7, 6), (MAX_ROWS - 6, 6)];
    Kernel::ALL.into_iter().flat_map(|kernel| {
        [Precision::F32, Precision::F64].into_iter().flat_map(move |precision| -> Vec<Variant> {
            if changes_springs(kernel) {
                return SIZES.map(|(springs, ports)| Variant::of_springs(kernel, precision, springs, ports)).to_vec();
            }
            (1..=MAX_DUOS).map(|duos| Variant { duos, ..Variant::new(kernel, precision, 1) }).collect()
        })
    })
}

fn parse(variant: Variant) -> Module {
    let source = variant.source();
    naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{variant:?}: {}", e.emit_to_string(&source)))
}

/// Offsets of a struct's members by name, and its size.
fn layout(module: &Module, name: &str) -> (Vec<(String, usize)>, usize) {
    let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some((_, naga::Type { inner: TypeInner::Struct { members, span }, .. })) = found else {
        panic!("no struct {name}")
    };
    let offsets = members.iter().map(|m| (m.name.clone().unwrap(), m.offset as usize)).collect();
    (offsets, *span as usize)
}

fn named(pairs: &[(&str, usize)]) -> Vec<(String, usize)> {
    pairs.iter().map(|(name, offset)| (name.to_string(), *offset)).collect()
}

#[test]
fn every_variant_parses_and_validates() {
    for variant in variants() {
        let capabilities = match variant.precision {
            Precision::F32 => Capabilities::empty(),
            Precision::F64 => Capabilities::FLOAT64,
        };
        let module = parse(variant);
        Validator::new(ValidationFlags::all(), capabilities)
            .validate(&module)
            .unwrap_or_else(|e| panic!("{variant:?}: {}", e.emit_to_string(&variant.source())));
    }
}

#[test]
fn validation_notices_f64_where_it_is_not_offered() {
    let module = parse(Variant::new(Kernel::ModalSum, Precision::F64, 6));
    assert!(Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).is_err());
}

#[test]
fn bindings_and_workgroups_are_those_that_the_host_makes() {
    for variant in variants() {
        let module = parse(variant);
        let mut bindings: Vec<_> = module
            .global_variables
            .iter()
            .filter_map(|(_, v)| v.binding.map(|b| (b.group, b.binding, v.name.clone().unwrap(), v.space)))
            .collect();
        bindings.sort_by_key(|b| (b.0, b.1));
        let read = AddressSpace::Storage { access: StorageAccess::LOAD };
        let write = AddressSpace::Storage { access: StorageAccess::LOAD | StorageAccess::STORE };
        let output = match variant.kernel {
            Kernel::ModalSum => "values",
            Kernel::Metrics => "extrema",
            Kernel::Modification => "values",
            Kernel::Extrema => "maxima",
        };
        let inputs = if changes_springs(variant.kernel) {
            ["receptances", "changes", "pairs"]
        } else {
            ["frequencies", "modes", "residual"]
        };
        let expected = [
            (0, 0, "params".to_string(), AddressSpace::Uniform),
            (0, 1, inputs[0].to_string(), read),
            (0, 2, inputs[1].to_string(), read),
            (0, 3, inputs[2].to_string(), read),
            (1, 0, output.to_string(), write),
        ];
        assert_eq!(bindings, expected, "{variant:?}");
        let [entry] = &module.entry_points[..] else { panic!("{variant:?}: one entry point") };
        assert_eq!((entry.name.as_str(), entry.workgroup_size), ("main", [WORKGROUP, 1, 1]), "{variant:?}");
    }
}

#[test]
fn structs_have_the_offsets_of_the_host() {
    let params = named(&[
        ("n_frequencies", offset_of!(Params, n_frequencies)),
        ("n_positions", offset_of!(Params, n_positions)),
        ("n_modes", offset_of!(Params, n_modes)),
        ("n_degrees", offset_of!(Params, n_degrees)),
        ("n_pairs", offset_of!(Params, n_pairs)),
        ("n_duos", offset_of!(Params, n_duos)),
        ("power", offset_of!(Params, power)),
        ("zero", offset_of!(Params, zero)),
    ]);
    let spring_params = named(&[
        ("n_frequencies", offset_of!(SpringParams, n_frequencies)),
        ("n_slots", offset_of!(SpringParams, n_slots)),
        ("n_designs", offset_of!(SpringParams, n_designs)),
        ("n_pairs", offset_of!(SpringParams, n_pairs)),
        ("zero", offset_of!(SpringParams, zero)),
    ]);
    for variant in variants() {
        let module = parse(variant);
        let expected = if changes_springs(variant.kernel) {
            (spring_params.clone(), size_of::<SpringParams>())
        } else {
            (params.clone(), size_of::<Params>())
        };
        assert_eq!(layout(&module, "Params"), expected, "{variant:?}");
    }
    macro_rules! maxima {
        ($real:ty) => {{
            let offsets = named(&[
                ("peak", offset_of!(Maxima<$real>, peak)),
                ("dip", offset_of!(Maxima<$real>, dip)),
                ("peaks", offset_of!(Maxima<$real>, peaks)),
                ("dips", offset_of!(Maxima<$real>, dips)),
            ]);
            (offsets, size_of::<Maxima<$real>>())
        }};
    }
    let of_maxima = |precision| layout(&parse(Variant::of_springs(Kernel::Extrema, precision, 2, 3)), "Maxima");
    assert_eq!(of_maxima(Precision::F32), maxima!(f32));
    assert_eq!(of_maxima(Precision::F64), maxima!(f64));
    macro_rules! extrema {
        ($real:ty) => {{
            let offsets = named(&[
                ("peak", offset_of!(Extrema<$real>, peak)),
                ("real_part", offset_of!(Extrema<$real>, real_part)),
                ("peak_at", offset_of!(Extrema<$real>, peak_at)),
                ("real_part_at", offset_of!(Extrema<$real>, real_part_at)),
            ]);
            (offsets, size_of::<Extrema<$real>>())
        }};
    }
    let f32_module = parse(Variant::new(Kernel::Metrics, Precision::F32, 6));
    let f64_module = parse(Variant::new(Kernel::Metrics, Precision::F64, 6));
    assert_eq!(layout(&f32_module, "Extrema"), extrema!(f32));
    assert_eq!(layout(&f64_module, "Extrema"), extrema!(f64));
    assert_ne!(layout(&f32_module, "Extrema"), extrema!(f64), "the comparison tells layouts apart");
}

#[test]
fn no_kernel_exceeds_what_webgpu_guarantees() {
    const { assert!(WORKGROUP <= 256) };
    let records = WORKGROUP as usize * size_of::<Extrema<f64>>();
    assert!(records <= 16384, "workgroup memory {records} bytes");
    // The reduction halves the workgroup.
    const { assert!(WORKGROUP.is_power_of_two()) };
    // A bit for each frequency of a chunk, and what the processor refines is never left out.
    const { assert!(CORE <= 64 && SHARE > 0.3) };
    for variant in variants().filter(|v| !changes_springs(v.kernel)) {
        assert_eq!(CHUNK % (WORKGROUP * variant.ways()), 0, "whole steps make a chunk: {variant:?}");
    }
}

#[test]
fn groups_of_duos_are_as_few_and_as_even_as_they_can_be() {
    let duos = |pairs| Variant::new(Kernel::ModalSum, Precision::F32, pairs).duos;
    let found = [1, 2, 3, 6, 9, 12, 13, 25].map(duos);
    assert_eq!(found, [1, 1, 2, 3, 5, 6, 4, 5]);
}

#[test]
fn the_header_holds_the_constants_of_the_host() {
    let source = Variant { split: false, ..Variant::new(Kernel::Metrics, Precision::F32, 6) }.source();
    for line in [
        format!("const WORKGROUP: u32 = {WORKGROUP}u;"),
        "const WAYS: u32 = 4u;".to_string(),
        format!("const STEPS: u32 = {}u;", CHUNK / (4 * WORKGROUP)),
        "const DUOS: u32 = 3u;".to_string(),
        "const SPLIT: bool = false;".to_string(),
    ] {
        assert!(source.contains(&line), "{line} in\n{source}");
    }
}

#[test]
fn the_springs_and_ports_are_constants_of_the_variant() {
    let source = Variant::of_springs(Kernel::Extrema, Precision::F32, 21, 3).source();
    for line in ["const SPRINGS: u32 = 21u;", "const ROWS: u32 = 24u;", "const ENTRIES: u32 = 300u;"] {
        assert!(source.contains(line), "{line} in\n{source}");
    }
    let refused = gpu::modification::check_rows(MAX_ROWS - 2, 3).unwrap_err();
    assert!(refused.to_string().contains(&format!("takes {MAX_ROWS} in all")), "{refused}");
    assert!(gpu::modification::check_rows(MAX_ROWS - 3, 3).is_ok());
}
