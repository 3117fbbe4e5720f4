//! Named arrays in one run of bytes, little-endian, each from a multiple of eight bytes on.

use serde::{Deserialize, Serialize};

/// Numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// 64-bit floats.
    F64,
    /// 32-bit floats.
    F32,
    /// 32-bit counts.
    U32,
    /// 16-bit integers.
    I16,
}

/// Where an array is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Name.
    pub name: String,
    /// Kind of its numbers.
    pub kind: Kind,
    /// Extents, the last fastest.
    pub shape: Vec<usize>,
    /// First byte.
    pub offset: usize,
}

/// Arrays and their list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrays {
    /// The list.
    pub entries: Vec<Entry>,
    /// The bytes.
    pub bytes: Vec<u8>,
}

impl Kind {
    fn size(self) -> usize {
        match self {
            Kind::F64 => 8,
            Kind::F32 | Kind::U32 => 4,
            Kind::I16 => 2,
        }
    }
}

impl Arrays {
    /// Appends f64 values.
    pub fn push_f64(&mut self, name: &str, shape: &[usize], values: impl IntoIterator<Item = f64>) {
        self.push(name, Kind::F64, shape, values.into_iter().map(f64::to_le_bytes));
    }

    /// Appends values as f32.
    pub fn push_f32(&mut self, name: &str, shape: &[usize], values: impl IntoIterator<Item = f64>) {
        self.push(name, Kind::F32, shape, values.into_iter().map(|v| (v as f32).to_le_bytes()));
    }

    /// Appends counts.
    pub fn push_u32(&mut self, name: &str, shape: &[usize], values: impl IntoIterator<Item = usize>) {
        self.push(name, Kind::U32, shape, values.into_iter().map(|v| (v as u32).to_le_bytes()));
    }

    /// Appends 16-bit integers.
    pub fn push_i16(&mut self, name: &str, shape: &[usize], values: impl IntoIterator<Item = i16>) {
        self.push(name, Kind::I16, shape, values.into_iter().map(i16::to_le_bytes));
    }

    fn push<const N: usize>(&mut self, name: &str, kind: Kind, shape: &[usize], values: impl Iterator<Item = [u8; N]>) {
        let offset = self.bytes.len();
        values.for_each(|v| self.bytes.extend_from_slice(&v));
        let expected = kind.size() * shape.iter().product::<usize>();
        assert_eq!(self.bytes.len() - offset, expected, "bytes of array {name} of shape {shape:?}");
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        self.entries.push(Entry { name: name.into(), kind, shape: shape.to_vec(), offset });
    }

    /// The list's entry of a name and its bytes, if they are all there.
    fn slice(&self, name: &str) -> Option<(&Entry, &[u8])> {
        let entry = self.entries.iter().find(|e| e.name == name)?;
        let count = entry.shape.iter().try_fold(entry.kind.size(), |n, extent| n.checked_mul(*extent))?;
        let end = entry.offset.checked_add(count)?;
        Some((entry, self.bytes.get(entry.offset..end)?))
    }

    /// Extents and values of an f64 array.
    pub fn f64(&self, name: &str) -> Option<(&[usize], Vec<f64>)> {
        let (entry, bytes) = self.slice(name).filter(|(e, _)| e.kind == Kind::F64)?;
        Some((&entry.shape, bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()))
    }

    /// Extents and values of an array of counts.
    pub fn u32(&self, name: &str) -> Option<(&[usize], Vec<usize>)> {
        let (entry, bytes) = self.slice(name).filter(|(e, _)| e.kind == Kind::U32)?;
        Some((&entry.shape, bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b) as usize).collect()))
    }
}
