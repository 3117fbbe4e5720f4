//! Every shader parses and validates, and agrees with the Rust side. Needs no adapter.

use std::mem::{offset_of, size_of};

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};
use stiffmap::gpu::shader::{CHUNK, Extrema, Kernel, MAX_DUOS, Params, Precision, Variant, WORKGROUP};

fn variants() -> impl Iterator<Item = Variant> {
    let kernels = Kernel::ALL.into_iter();
    kernels.flat_map(|kernel| {
        [Precision::F32, Precision::F64]
            .into_iter()
            .flat_map(move |precision| (1..=MAX_DUOS).map(move |duos| Variant { kernel, precision, duos, split: true }))
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
        };
        let expected = [
            (0, 0, "params".to_string(), AddressSpace::Uniform),
            (0, 1, "frequencies".to_string(), read),
            (0, 2, "modes".to_string(), read),
            (0, 3, "residual".to_string(), read),
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
    for variant in variants() {
        let module = parse(variant);
        assert_eq!(layout(&module, "Params"), (params.clone(), size_of::<Params>()), "{variant:?}");
    }
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
    for variant in variants() {
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
