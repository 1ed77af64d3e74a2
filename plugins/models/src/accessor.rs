//! Numbers out of buffers, within their bounds.

use crate::model::{Model, ReadFile};
use gltf::Accessor;
use gltf::accessor::{DataType, sparse::IndexType};

/// What is wrong with an accessor, with its number.
fn fault(accessor: &Accessor, what: &str) -> String {
    format!("its accessor {} {what}", accessor.index())
}

fn size_of(ty: DataType) -> usize {
    match ty {
        DataType::I8 | DataType::U8 => 1,
        DataType::I16 | DataType::U16 => 2,
        DataType::U32 | DataType::F32 => 4,
    }
}

/// A number of a type; integers that are normalized stand for numbers between -1 and 1.
fn component(bytes: &[u8], ty: DataType, normalized: bool) -> f32 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    let (value, largest) = match ty {
        DataType::I8 => (f32::from(bytes[0] as i8), 127.0),
        DataType::U8 => (f32::from(bytes[0]), 255.0),
        DataType::I16 => (f32::from(i16::from_le_bytes(two())), 32767.0),
        DataType::U16 => (f32::from(u16::from_le_bytes(two())), 65535.0),
        DataType::U32 => (u32::from_le_bytes(four()) as f32, u32::MAX as f32),
        DataType::F32 => return f32::from_le_bytes(four()),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}

/// Where the elements of an accessor lie.
struct Layout {
    offset: usize,
    stride: usize,
    size: usize,
    count: usize,
}

impl Layout {
    /// `length`: bytes of the view that the elements lie in.
    fn new(accessor: &Accessor, view: &gltf::buffer::View) -> Result<Self, String> {
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        let (offset, count) = (accessor.offset(), accessor.count());
        if stride < size {
            return Err(fault(accessor, "has elements that overlap"));
        }
        let last = count.checked_sub(1).and_then(|n| n.checked_mul(stride));
        let end = last.and_then(|last| last.checked_add(offset)?.checked_add(size));
        match end {
            _ if count == 0 => Ok(Self { offset: 0, stride, size, count }),
            Some(end) if end <= view.length() => Ok(Self { offset, stride, size, count }),
            _ => Err(fault(accessor, "reaches out of its buffer view")),
        }
    }

    fn elements<'b>(&self, view: &'b [u8]) -> impl Iterator<Item = &'b [u8]> {
        let Self { offset, stride, size, count } = *self;
        (0..count).map(move |i| &view[offset + i * stride..][..size])
    }
}

/// The elements of an accessor: `N` numbers each. Where elements have fewer, `fill` stands for the rest.
///
/// # Errors
/// What is wrong with it.
pub fn floats<const N: usize>(model: &Model, accessor: &Accessor, fill: f32, read: ReadFile) -> Result<Vec<[f32; N]>, String> {
    let (ty, normalized) = (accessor.data_type(), accessor.normalized());
    let components = accessor.dimensions().multiplicity();
    if components > N || components * size_of(ty) != accessor.size() {
        return Err(fault(accessor, &format!("has elements of {components} numbers where up to {N} are needed")));
    }
    let element = |bytes: &[u8]| {
        let mut element = [fill; N];
        for (value, bytes) in element.iter_mut().zip(bytes.chunks_exact(size_of(ty))) {
            *value = component(bytes, ty, normalized);
        }
        element
    };
    let mut all = match accessor.view() {
        Some(view) => {
            let layout = Layout::new(accessor, &view)?;
            let (bytes, range) = model.view(&view, read)?;
            layout.elements(&bytes[range]).map(element).collect()
        }
        None if accessor.count() > model.length => return Err(fault(accessor, "has more elements than its file has bytes")),
        None => {
            let mut zero = [fill; N];
            zero[..components].fill(0.0);
            vec![zero; accessor.count()]
        }
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, values) = (sparse.indices(), sparse.values());
        let width = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let part = |view: gltf::buffer::View, offset: usize, size: usize| -> Result<Vec<u8>, String> {
            let (bytes, range) = model.view(&view, read)?;
            let length = sparse.count().checked_mul(size);
            let part = bytes[range].get(offset..).and_then(|rest| rest.get(..length?));
            part.map(<[u8]>::to_vec).ok_or_else(|| fault(accessor, "has sparse values that reach out of their buffer view"))
        };
        let at = part(indices.view(), indices.offset(), width)?;
        let by = part(values.view(), values.offset(), accessor.size())?;
        for (at, by) in at.chunks_exact(width).zip(by.chunks_exact(accessor.size())) {
            let index = at.iter().rev().fold(0usize, |n, byte| n << 8 | usize::from(*byte));
            match all.get_mut(index) {
                Some(value) => *value = element(by),
                None => return Err(fault(accessor, "has a sparse value for an element that it does not have")),
            }
        }
    }
    Ok(all)
}

/// The elements of an accessor of whole numbers.
///
/// # Errors
/// What is wrong with it.
pub fn indices(model: &Model, accessor: &Accessor, read: ReadFile) -> Result<Vec<u32>, String> {
    let width = size_of(accessor.data_type());
    let is_whole = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
    if !is_whole || accessor.size() != width || accessor.sparse().is_some() {
        return Err(fault(accessor, "has no plain indices"));
    }
    let Some(view) = accessor.view() else { return Err(fault(accessor, "has no buffer view")) };
    let layout = Layout::new(accessor, &view)?;
    let (bytes, range) = model.view(&view, read)?;
    let index = |bytes: &[u8]| bytes.iter().rev().fold(0u32, |n, byte| n << 8 | u32::from(*byte));
    Ok(layout.elements(&bytes[range]).map(index).collect())
}
