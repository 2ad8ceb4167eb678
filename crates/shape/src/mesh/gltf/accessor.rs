//! Accessors: arrays of scalars or vectors in the bytes of a glTF file.
//!
//! Invariant: every element lies in its view; without a view all elements are zero.

use super::buffer::Data;
use super::document::{Accessor, entry, malformed};
use crate::error::{ShapeError, quoted};
use crate::sample_type::SampleType;

/// Most elements without a view, over all uses of accessors. Real files have none outside of morph targets.
const MAX_ZEROS: u64 = 1 << 20;

/// Type of a number by its code.
fn component_type(code: u32) -> Option<SampleType> {
    Some(match code {
        5120 => SampleType::I8,
        5121 => SampleType::U8,
        5122 => SampleType::I16,
        5123 => SampleType::U16,
        5125 => SampleType::U32,
        5126 => SampleType::F32,
        _ => return None,
    })
}

/// First number in `bytes`; normalized integers become -1 to 1.
fn number(kind: SampleType, bytes: &[u8], normalized: bool) -> f64 {
    let value = kind.value(bytes, false);
    let largest = match kind {
        SampleType::I8 => f64::from(i8::MAX),
        SampleType::U8 => f64::from(u8::MAX),
        SampleType::I16 => f64::from(i16::MAX),
        SampleType::U16 => f64::from(u16::MAX),
        _ => return value,
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}

/// Elements of an accessor, of `N` numbers each.
pub struct Elements<'a, const N: usize> {
    pub count: u64,
    pub component: SampleType,
    normalized: bool,
    /// Divisor of the values.
    pub full: f64,
    /// Bytes from the first element on; empty for zeros.
    bytes: &'a [u8],
    /// Distance between elements in bytes.
    stride: usize,
    /// Sparse replacements by rising index.
    sparse: Vec<(u64, [f64; N])>,
}

impl<'a, const N: usize> Elements<'a, N> {
    /// Reads accessor `index` with a component type out of `types`; `place` names the reference to it.
    pub fn read(
        data: &'a Data,
        index: u32,
        types: &[SampleType],
        place: impl FnOnce() -> String,
    ) -> Result<Elements<'a, N>, ShapeError> {
        let source = data.source;
        let accessor = entry(source, &data.document.accessors, index, place)?;
        let at = |field: &str| format!("accessors[{index}].{field}");
        let (kind, expected) = match N {
            1 => ("SCALAR", "`SCALAR`"),
            2 => ("VEC2", "`VEC2`"),
            4 => ("VEC4", "`VEC4`"),
            _ => ("VEC3", "`VEC3`"),
        };
        if accessor.kind != kind {
            return Err(malformed(source, at("type"), expected, quoted(accessor.kind.as_bytes())));
        }
        let component = component_type(accessor.component_type).filter(|component| types.contains(component));
        let component = component.ok_or_else(|| {
            let expected = if N == 1 { "5121, 5123 or 5125" } else { "5126, or 5120 to 5123 where it is quantized" };
            malformed(source, at("componentType"), expected, accessor.component_type)
        })?;
        if accessor.count == 0 {
            return Err(malformed(source, at("count"), "1 or more", 0));
        }
        let size = N * component.bytes() as usize;
        let (mut bytes, mut stride): (&[u8], _) = (&[], size);
        if let Some(view) = accessor.buffer_view {
            let (view, all) = data.view(view, || at("bufferView"))?;
            stride = match view.byte_stride {
                None => size,
                Some(stride @ 4..=252) if N > 1 && stride % 4 == 0 && stride >= size as u64 => stride as usize,
                Some(stride) => {
                    let expected = "a multiple of 4 up to 252 that holds an element, and none for indices";
                    let place = format!("bufferViews[{}].byteStride", accessor.buffer_view.unwrap_or_default());
                    return Err(malformed(source, place, expected, stride));
                }
            };
            if (accessor.byte_offset.wrapping_add(view.byte_offset)) % component.bytes() != 0 {
                let found = format!("{} in a view from byte {}", accessor.byte_offset, view.byte_offset);
                return Err(malformed(source, at("byteOffset"), "a multiple of the size of a number", found));
            }
            bytes = part(all, accessor.byte_offset, accessor.count, stride, size).ok_or_else(|| {
                let (count, from, length) = (accessor.count, accessor.byte_offset, all.len());
                let found = format!("{count} of {size} bytes, {stride} apart, from byte {from} of {length}");
                malformed(source, at("count"), "as many elements as its view holds", found)
            })?;
        } else {
            let zeros = data.zeros.get().saturating_add(accessor.count);
            if zeros > MAX_ZEROS {
                return Err(source.too_large("elements of accessors without a view", zeros, MAX_ZEROS));
            }
            data.zeros.set(zeros);
        }
        let mut elements = Elements {
            count: accessor.count,
            component,
            normalized: accessor.normalized,
            full: 1.0,
            bytes,
            stride,
            sparse: Vec::new(),
        };
        elements.sparse = elements.replacements(data, accessor, at)?;
        Ok(elements)
    }

    /// Largest value of an index type, which would restart a strip.
    pub(crate) fn largest_index(&self) -> f64 {
        2_f64.powi(8 * self.component.bytes() as i32) - 1.0
    }

    /// Element `index`, which is below `count`.
    pub fn get(&self, index: u64) -> [f64; N] {
        let element = match (self.sparse.binary_search_by_key(&index, |(index, _)| *index), self.bytes) {
            (Ok(at), _) => self.sparse[at].1,
            (_, []) => [0.0; N],
            (_, bytes) => self.element(&bytes[index as usize * self.stride..]),
        };
        element.map(|value| value / self.full)
    }

    /// Declares whole numbers as normalized; returns their full scale if they were not.
    pub fn normalize(&mut self) -> Option<f64> {
        let full = match self.component {
            SampleType::U8 => f64::from(u8::MAX),
            SampleType::U16 => f64::from(u16::MAX),
            _ => return None,
        };
        if self.normalized {
            return None;
        }
        self.full = full;
        Some(full)
    }

    fn element(&self, bytes: &[u8]) -> [f64; N] {
        let size = self.component.bytes() as usize;
        std::array::from_fn(|n| number(self.component, &bytes[n * size..], self.normalized))
    }

    fn replacements(
        &self,
        data: &Data,
        accessor: &Accessor,
        at: impl Fn(&str) -> String,
    ) -> Result<Vec<(u64, [f64; N])>, ShapeError> {
        let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
        let (source, count) = (data.source, sparse.count);
        let refuse = |field, expected, found: String| Err(malformed(source, at(field), expected, found));
        let integers = [SampleType::U8, SampleType::U16, SampleType::U32];
        let code = sparse.indices.component_type;
        let Some(kind) = code.and_then(component_type).filter(|kind| integers.contains(kind)) else {
            let found = code.map_or("none".into(), |code| code.to_string());
            return refuse("sparse.indices.componentType", "5121, 5123 or 5125", found);
        };
        if count == 0 || count > self.count {
            return refuse("sparse.count", "1 or more, and at most `count`", format!("{count} of {}", self.count));
        }
        let (size, index_size) = (N * self.component.bytes() as usize, kind.bytes() as usize);
        let (_, bytes) = data.view(sparse.indices.buffer_view, || at("sparse.indices.bufferView"))?;
        let indices = part(bytes, sparse.indices.byte_offset, count, index_size, index_size);
        let (_, bytes) = data.view(sparse.values.buffer_view, || at("sparse.values.bufferView"))?;
        let values = part(bytes, sparse.values.byte_offset, count, size, size);
        let (Some(indices), Some(values)) = (indices, values) else {
            return refuse("sparse.count", "as many elements as its views hold", count.to_string());
        };
        let indices = indices.chunks_exact(index_size).map(|bytes| kind.value(bytes, false) as u64);
        let replaced: Vec<_> = indices.zip(values.chunks_exact(size).map(|bytes| self.element(bytes))).collect();
        let rises = replaced.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if !rises || replaced.last().is_some_and(|(last, _)| *last >= self.count) {
            let found = if rises { "one that is not below `count`" } else { "one that is not above the one before" };
            return refuse("sparse.indices", "rising indices below `count`", found.into());
        }
        Ok(replaced)
    }
}

/// Bytes of `count` elements from `offset` on, if all are in `bytes`.
fn part(bytes: &[u8], offset: u64, count: u64, stride: usize, size: usize) -> Option<&[u8]> {
    let needed = (count - 1).checked_mul(stride as u64)?.checked_add(size as u64)?;
    bytes.get(usize::try_from(offset).ok()?..)?.get(..usize::try_from(needed).ok()?)
}
