//! Superelements on disk, by the hash of everything they depend on.
//!
//! A file holds a magic word, the format version, the payload's length and BLAKE3 hash, the key of the part that it
//! belongs to, and the payload: little-endian 64-bit integers and floats in the order of the struct's fields. The key
//! hashes what the machine file says of the part and the bytes that were parsed of its files
//! ([`Inputs`](crate::files::Inputs)); nothing is read again for it. A file that does not match its own hash, or is that
//! of another part, is reported and rebuilt, never trusted. Files are written aside and renamed, with the permissions
//! that the umask leaves, so that a team may share a folder.

use super::skin::ReducedSkin;
use super::superelement::{ReducedInterface, ReducedRail};
use super::{Beyond, ReductionError, ReductionRequest, Superelement, reduce};
use crate::files::aside;
use crate::interrupt::Interrupt;
use crate::mesh::Mesh;
use crate::solid::{Face, Surface};
use nalgebra::{DMatrix, Matrix3};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 16] = b"stiffmap-reduced";
/// Raised whenever the layout or the numbers of a superelement change.
const VERSION: u64 = 14;
const HEADER: usize = 16 + 8 + 8 + 32 + 32;

/// Why the cache could not serve.
#[derive(Debug, thiserror::Error)]
pub enum CacheError {
    /// A file is there but is not what was written.
    #[error("cache file {file} is damaged ({reason}); it is rebuilt")]
    Damaged {
        /// File.
        file: String,
        /// What was found.
        reason: String,
    },
    /// A file could not be read or written.
    #[error("cache file {file}: {source}; the run goes on without it")]
    Io {
        /// File.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
}

/// A folder of superelements.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

/// A superelement, where it came from, and what was wrong with the cache on the way.
#[derive(Debug)]
pub struct Cached {
    /// The superelement.
    pub superelement: Superelement,
    /// Whether it was read instead of computed.
    pub hit: bool,
    /// What the user should be told.
    pub warnings: Vec<CacheError>,
}

impl Cache {
    /// A cache in a folder, which need not exist yet.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file in which a request's superelement is kept; none for a mesh that was made in memory, of which nothing
    /// is known that could be compared.
    pub fn file(&self, request: &ReductionRequest, mesh: &Mesh) -> Option<PathBuf> {
        Some(self.place(&key(request, mesh)?))
    }

    fn place(&self, key: &blake3::Hash) -> PathBuf {
        self.folder.join(format!("{}.superelement", &key.to_hex()[..32]))
    }

    /// The superelement of a request, read if it is there and whole, otherwise computed and kept.
    ///
    /// # Errors
    /// [`ReductionError`] if it has to be computed and cannot be.
    pub fn reduce(
        &self,
        request: &ReductionRequest,
        mesh: &Mesh,
        interrupt: Option<&Interrupt>,
    ) -> Result<Cached, ReductionError> {
        let mut warnings = Vec::new();
        let Some(key) = key(request, mesh) else {
            let superelement = reduce(request, mesh, interrupt)?;
            return Ok(Cached { superelement, hit: false, warnings });
        };
        let file = self.place(&key);
        match read(&file, &key) {
            Ok(Some(superelement)) => return Ok(Cached { superelement, hit: true, warnings }),
            Ok(None) => {}
            Err(error) => warnings.push(error),
        }
        let superelement = reduce(request, mesh, interrupt)?;
        if let Err(error) = write(&file, &key, &superelement) {
            warnings.push(error);
        }
        Ok(Cached { superelement, hit: false, warnings })
    }
}

/// The hash of all that a superelement depends on.
fn key(request: &ReductionRequest, mesh: &Mesh) -> Option<blake3::Hash> {
    let part = &request.part;
    let mut hasher = blake3::Hasher::new();
    hasher.update(&VERSION.to_le_bytes());
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    let described = (
        &part.name,
        &part.material,
        (&part.clamped, &part.supported, &part.interfaces),
        (part.mesh_units, part.plain_bricks, part.placement),
        part.matrices.as_ref().map(|m| {
            let files = [&m.dofs, &m.nodes, &m.sets].map(Option::is_some);
            (&m.stiffness_name, &m.mass_name, m.free, m.with_mesh, &m.interfaces, files)
        }),
        (request.component, request.reach),
        &request.rails,
    );
    hasher.update(format!("{described:?}").as_bytes());
    let files = mesh.inputs.files();
    for file in files {
        let extension = file.path.extension().unwrap_or_default().to_string_lossy();
        hasher.update(&(extension.len() as u64).to_le_bytes());
        hasher.update(extension.as_bytes());
        hasher.update(file.hash.as_bytes());
    }
    (!files.is_empty()).then(|| hasher.finalize())
}

fn io_error(file: &Path) -> impl Fn(std::io::Error) -> CacheError + '_ {
    |source| CacheError::Io { file: file.display().to_string(), source }
}

fn read(file: &Path, key: &blake3::Hash) -> Result<Option<Superelement>, CacheError> {
    let bytes = match std::fs::read(file) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(io_error(file)(error)),
    };
    let damaged = |reason: String| CacheError::Damaged { file: file.display().to_string(), reason };
    if bytes.len() < HEADER || &bytes[..16] != MAGIC {
        return Err(damaged(format!("{} bytes without the header", bytes.len())));
    }
    let word = |at: usize| bytes[at..at + 8].try_into().map_or(0, u64::from_le_bytes);
    let (version, length) = (word(16), word(24));
    let payload = &bytes[HEADER..];
    if version != VERSION || length != payload.len() as u64 {
        return Err(damaged(format!("version {version}, {} of {length} bytes", payload.len())));
    }
    if &bytes[64..HEADER] != key.as_bytes() {
        return Err(damaged("it is the file of another part, or of another state of this one".into()));
    }
    if blake3::hash(payload).as_bytes() != &bytes[32..64] {
        return Err(damaged("its hash does not match its content".into()));
    }
    let mut reader = Reader { bytes: payload };
    reader.superelement().map(Some).ok_or_else(|| damaged("its content ends early".into()))
}

fn write(file: &Path, key: &blake3::Hash, superelement: &Superelement) -> Result<(), CacheError> {
    std::fs::create_dir_all(aside::folder_of(file)).map_err(io_error(file))?;
    let mut payload = Writer::default();
    payload.superelement(superelement);
    let payload = payload.bytes;
    let hash = blake3::hash(&payload);
    let (version, length) = (VERSION.to_le_bytes(), (payload.len() as u64).to_le_bytes());
    let pieces = [&MAGIC[..], &version, &length, hash.as_bytes(), key.as_bytes(), &payload];
    aside::write(file, &pieces).map_err(io_error(file))
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    fn count(&mut self, value: usize) {
        self.bytes.extend_from_slice(&(value as u64).to_le_bytes());
    }

    fn numbers(&mut self, values: &[f64]) {
        for value in values {
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
    }

    fn list(&mut self, values: &[f64]) {
        self.count(values.len());
        self.numbers(values);
    }

    fn matrix(&mut self, matrix: &DMatrix<f64>) {
        self.count(matrix.nrows());
        self.count(matrix.ncols());
        self.numbers(matrix.as_slice());
    }

    fn superelement(&mut self, s: &Superelement) {
        self.count(s.part.len());
        self.bytes.extend_from_slice(s.part.as_bytes());
        self.list(&s.eigenvalues);
        self.count(s.interfaces.len());
        for interface in &s.interfaces {
            self.numbers(&interface.centroid);
            self.numbers(&[interface.area]);
            self.matrix(&interface.rows);
        }
        self.count(s.rails.len());
        for rail in &s.rails {
            self.count(rail.interface);
            self.count(rail.nodes.len());
            rail.nodes.iter().for_each(|x| self.numbers(x));
            self.count(rail.surface.faces.len());
            for face in &rail.surface.faces {
                self.count(face.nodes.len());
                face.nodes.iter().for_each(|&n| self.count(n));
                face.coordinates.iter().for_each(|x| self.numbers(x));
            }
            self.matrix(&rail.basis);
        }
        self.count(s.skin.nodes.len());
        s.skin.nodes.iter().for_each(|x| self.numbers(x));
        self.count(s.skin.triangles.len());
        s.skin.triangles.iter().flatten().for_each(|&n| self.count(n));
        self.matrix(&s.skin.basis);
        self.matrix(&s.impulses);
        self.numbers(&s.centre_of_mass);
        self.numbers(&[s.mass]);
        self.numbers(s.inertia.as_slice());
        self.list(&s.component_frequencies);
        self.list(&s.beyond.eigenvalues);
        self.matrix(&s.beyond.stiffness);
        self.matrix(&s.beyond.mass);
        [s.n_nodes, s.n_elements, s.n_dof].iter().for_each(|&n| self.count(n));
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl Reader<'_> {
    fn word(&mut self) -> Option<[u8; 8]> {
        let (word, rest) = self.bytes.split_first_chunk::<8>()?;
        self.bytes = rest;
        Some(*word)
    }

    fn count(&mut self) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.word()?)).ok()
    }

    fn number(&mut self) -> Option<f64> {
        self.word().map(f64::from_le_bytes)
    }

    fn numbers(&mut self, n: usize) -> Option<Vec<f64>> {
        let (values, rest) = self.bytes.split_at_checked(n.checked_mul(8)?)?;
        self.bytes = rest;
        Some(values.chunks_exact(8).map(|w| f64::from_le_bytes(w.try_into().unwrap_or_default())).collect())
    }

    fn list(&mut self) -> Option<Vec<f64>> {
        let n = self.count()?;
        self.numbers(n)
    }

    fn point(&mut self) -> Option<[f64; 3]> {
        self.numbers(3)?.try_into().ok()
    }

    fn matrix(&mut self) -> Option<DMatrix<f64>> {
        let (rows, columns) = (self.count()?, self.count()?);
        Some(DMatrix::from_vec(rows, columns, self.numbers(rows.checked_mul(columns)?)?))
    }

    fn repeat<T>(&mut self, mut item: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        (0..self.count()?).map(|_| item(self)).collect()
    }

    fn superelement(&mut self) -> Option<Superelement> {
        let length = self.count()?;
        let (name, rest) = self.bytes.split_at_checked(length)?;
        self.bytes = rest;
        Some(Superelement {
            part: String::from_utf8(name.to_vec()).ok()?,
            eigenvalues: self.list()?,
            interfaces: self
                .repeat(|r| Some(ReducedInterface { centroid: r.point()?, area: r.number()?, rows: r.matrix()? }))?,
            rails: self.repeat(|r| {
                Some(ReducedRail {
                    interface: r.count()?,
                    nodes: r.repeat(Self::point)?,
                    surface: Surface { faces: r.repeat(Self::face)? },
                    basis: r.matrix()?,
                })
            })?,
            skin: ReducedSkin {
                nodes: self.repeat(Self::point)?,
                triangles: self.repeat(|r| Some([r.count()?, r.count()?, r.count()?]))?,
                basis: self.matrix()?,
            },
            impulses: self.matrix()?,
            centre_of_mass: self.point()?,
            mass: self.number()?,
            inertia: Matrix3::from_column_slice(&self.numbers(9)?),
            component_frequencies: self.list()?,
            beyond: Beyond { eigenvalues: self.list()?, stiffness: self.matrix()?, mass: self.matrix()? },
            n_nodes: self.count()?,
            n_elements: self.count()?,
            n_dof: self.count()?,
        })
    }

    fn face(&mut self) -> Option<Face> {
        let nodes = self.repeat(Self::count)?;
        let coordinates = nodes.iter().map(|_| self.point()).collect::<Option<_>>()?;
        Some(Face { nodes, coordinates })
    }
}
