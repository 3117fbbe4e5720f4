//! The cache of superelements: hits, damage, and what its key depends on.

mod support;

use std::path::{Path, PathBuf};
use stiffmap::machine::{Material, ReductionMethod, SurfaceCoupling};
use stiffmap::mesh::Mesh;
use stiffmap::reduction::{Cache, CacheError, Cached, ReductionRequest};
use support::{box_mesh, craig_bampton, on, part, slab, steel};

struct Room {
    folder: tempfile::TempDir,
    cache: Cache,
    request: ReductionRequest,
    mesh: Mesh,
}

impl Room {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut part = part("post", &["ZMIN"], vec![on("ZMAX")]);
        part.mesh = folder.path().join("post.inp");
        let request = ReductionRequest { part, component: craig_bampton(4), reach: 0.0, rails: Vec::new() };
        let cache = Cache::in_folder(folder.path().join("cache"));
        let mut mesh = box_mesh([0.0; 3], [0.1, 0.1, 0.3], [1, 1, 2]);
        mesh.inputs.add(&request.part.mesh, b"the bytes of the mesh").expect("one content");
        Self { cache, request, mesh, folder }
    }

    fn reduce(&self) -> Cached {
        self.cache.reduce(&self.request, &self.mesh, None).expect("reduces")
    }

    fn file(&self) -> PathBuf {
        self.cache.file(&self.request, &self.mesh).expect("a mesh with its files")
    }
}

#[test]
fn a_second_call_reads_what_the_first_one_computed() {
    let room = Room::new();
    let first = room.reduce();
    assert!(!first.hit && first.warnings.is_empty() && room.file().exists());
    let second = room.reduce();
    assert!(second.hit && second.warnings.is_empty());
    assert_eq!(first.superelement, second.superelement, "to the last bit");
    let entries = std::fs::read_dir(room.cache.folder()).expect("folder").count();
    assert_eq!(entries, 1, "nothing written aside is left");
}

fn damage(room: &Room, spoil: impl Fn(&mut Vec<u8>)) -> Cached {
    let file = room.file();
    let mut bytes = std::fs::read(&file).expect("reads");
    spoil(&mut bytes);
    std::fs::write(&file, bytes).expect("writes");
    room.reduce()
}

#[test]
fn a_damaged_file_is_reported_and_rebuilt_with_the_same_result() {
    let room = Room::new();
    let good = room.reduce().superelement;
    let length = std::fs::metadata(room.file()).expect("file").len() as usize;
    let untouched = damage(&room, |_| {});
    assert!(untouched.hit && untouched.warnings.is_empty(), "control: rewritten as it was it is a hit");
    let places = [0, 17, 25, 40, 64, 100, length / 2, length - 1];
    for place in places {
        let cached = damage(&room, |bytes| bytes[place] ^= 0x10);
        assert!(!cached.hit, "byte {place}");
        assert!(matches!(&cached.warnings[..], [CacheError::Damaged { .. }]), "byte {place}: {:?}", cached.warnings);
        assert_eq!(cached.superelement, good, "byte {place}");
        assert!(room.reduce().hit, "rebuilt");
    }
    for kept in [0, 10, 63, 64, 70, length / 2, length - 1] {
        let cached = damage(&room, |bytes| bytes.truncate(kept));
        assert!(!cached.hit && matches!(&cached.warnings[..], [CacheError::Damaged { .. }]), "{kept} bytes left");
        assert_eq!(cached.superelement, good);
    }
    let longer = damage(&room, |bytes| bytes.push(0));
    assert!(!longer.hit && longer.warnings.len() == 1);
}

#[test]
fn the_key_depends_on_all_that_the_superelement_depends_on_and_on_nothing_else() {
    let room = Room::new();
    let original = room.file();
    assert_eq!(original, room.file());
    let mut names = vec![original.clone()];
    let mut changed = |what: &str, change: &dyn Fn(&mut ReductionRequest)| {
        let mut request = room.request.clone();
        change(&mut request);
        let name = room.cache.file(&request, &room.mesh).expect("a mesh with its files");
        assert!(!names.contains(&name), "{what}");
        names.push(name);
    };
    changed("a material", &|r| r.part.material = Some(steel()));
    changed("its stiffness in the last digit", &|r| {
        r.part.material = Some(Material { young: f64::from_bits(210e9f64.to_bits() + 1), ..steel() });
    });
    changed("more modes", &|r| r.component.modes += 1);
    changed("a band", &|r| r.component.band = 1000.0);
    changed("the method", &|r| r.component.method = ReductionMethod::FreeInterface);
    changed("second moments", &|r| r.component.second_moment = false);
    changed("the clamp", &|r| r.part.clamped = vec!["ZMAX".into()]);
    changed("an interface", &|r| r.part.interfaces[0].nodes = "XMAX".into());
    changed("its region", &|r| r.part.interfaces[0].within = Some(slab(0, 0.0, 0.05)));
    changed("its coupling", &|r| r.part.interfaces[0].coupling = SurfaceCoupling::Rigid);
    changed("the unit of the mesh", &|r| r.part.mesh_units.length = 1e-3);
    let mut loss = room.request.clone();
    loss.part.loss_factor = Some(0.01);
    assert_eq!(
        room.cache.file(&loss, &room.mesh).expect("a mesh with its files"),
        original,
        "a loss factor does not touch the superelement"
    );

    let of = |files: &[(&str, &[u8])]| {
        let mut mesh = Mesh::default();
        files.iter().for_each(|(name, bytes)| mesh.inputs.add(Path::new(name), bytes).expect("one content"));
        room.cache.file(&room.request, &mesh)
    };
    let bytes: &[u8] = b"the bytes of the mesh";
    assert_eq!(of(&[("elsewhere/moved.inp", bytes)]).as_ref(), Some(&original), "wherever the mesh lies");
    let others: [&[(&str, &[u8])]; 4] = [
        &[("post.inp", b"the bytes of the Mesh")],
        &[("post.msh", bytes)],
        &[("post.inp", bytes), ("nodes.inp", b"1, 0, 0, 0")],
        &[("post.inp", bytes), ("nodes.inp", b"1, 0, 0, 1")],
    ];
    let mut found: Vec<_> = others.iter().map(|files| of(files).expect("a mesh with its files")).collect();
    found.push(original);
    found.sort();
    found.dedup();
    assert_eq!(found.len(), 5, "a byte of the mesh, its format, a file that it includes and a byte of that");
    assert_eq!(of(&[]), None, "a mesh of which nothing is known has no place");
}

#[test]
fn a_folder_that_cannot_be_written_is_reported_and_the_result_still_comes() {
    let mut room = Room::new();
    let blocked = room.folder.path().join("a file, not a folder");
    std::fs::write(&blocked, "").expect("writes");
    room.cache = Cache::in_folder(&blocked);
    let cached = room.reduce();
    assert!(!cached.hit && cached.warnings.iter().any(|w| matches!(w, CacheError::Io { .. })), "{:?}", cached.warnings);
    let good = Room::new().reduce().superelement;
    assert_eq!(cached.superelement, good);
}
