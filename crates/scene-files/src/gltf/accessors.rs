//! Accessors (specification, section 3.6.2): typed arrays in buffers, bounds checked before anything is allocated.

use super::buffers::Buffers;
use super::schema::{Accessor, Root};
use super::{Budget, Fault, get};

/// Reads accessors of a file.
pub struct Accessors<'a> {
    pub root: &'a Root,
    pub buffers: &'a Buffers<'a>,
}

/// Type of a component.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: usize) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// What a normalized component is divided by (section 3.6.2.2); floats are as they are.
    fn largest(self) -> f32 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::U32 => u32::MAX as f32,
            Self::F32 => 1.0,
        }
    }

    /// The component at the start of `bytes`, which has `size()` of them.
    fn to_f32(self, bytes: &[u8], normalized: bool) -> f32 {
        let raw = self.to_bits(bytes);
        let value = match self {
            Self::I8 => f32::from(raw as i8),
            Self::U8 => f32::from(raw as u8),
            Self::I16 => f32::from(raw as i16),
            Self::U16 => f32::from(raw as u16),
            Self::U32 => raw as f32,
            Self::F32 => return f32::from_bits(raw),
        };
        if normalized { (value / self.largest()).max(-1.0) } else { value }
    }

    fn to_bits(self, bytes: &[u8]) -> u32 {
        let mut word = [0; 4];
        for (to, from) in word.iter_mut().zip(&bytes[..self.size()]) {
            *to = *from;
        }
        u32::from_le_bytes(word)
    }
}

/// Where an accessor's elements lie.
struct Layout<'a> {
    /// From the first element on; `None` stands for zeros.
    bytes: Option<&'a [u8]>,
    stride: usize,
    count: usize,
    component: Component,
}

impl Accessors<'_> {
    /// Number of elements of an accessor.
    pub fn count(&self, index: usize, referrer: &str) -> Result<usize, Fault> {
        Ok(get(&self.root.accessors, index, "accessor", referrer)?.count.0)
    }

    /// Number of components of an accessor.
    pub fn width(&self, index: usize, referrer: &str) -> Result<usize, Fault> {
        let accessor = get(&self.root.accessors, index, "accessor", referrer)?;
        width(accessor).ok_or_else(|| Fault::Invalid(format!("accessor {index} has an unknown type")))
    }

    /// What values of an accessor are divided by: 1 where they are not normalized. `normalized` goes before what the accessor says.
    pub fn range(&self, index: usize, normalized: Option<bool>, referrer: &str) -> Result<f32, Fault> {
        let accessor = get(&self.root.accessors, index, "accessor", referrer)?;
        let component = component(accessor, &format!("accessor {index}"))?;
        Ok(if normalized.unwrap_or(accessor.normalized) { component.largest() } else { 1.0 })
    }

    /// Elements of `N` components as floats; integers are divided by their range where the accessor is normalized.
    pub fn floats<const N: usize>(
        &self,
        index: usize,
        referrer: &str,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; N]>, Fault> {
        self.floats_as(index, None, referrer, budget)
    }

    /// The same, where `normalized` goes before what the accessor says.
    pub fn floats_as<const N: usize>(
        &self,
        index: usize,
        normalized: Option<bool>,
        referrer: &str,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; N]>, Fault> {
        let accessor = get(&self.root.accessors, index, "accessor", referrer)?;
        let name = format!("accessor {index}");
        let layout = self.layout::<N>(accessor, &name)?;
        let normalized = normalized.unwrap_or(accessor.normalized);
        self.elements(accessor, &layout, &name, |bytes| layout.component.to_f32(bytes, normalized), budget)
    }

    /// Vertex indices.
    pub fn indices(&self, index: usize, referrer: &str, budget: &mut Budget) -> Result<Vec<u32>, Fault> {
        let accessor = get(&self.root.accessors, index, "accessor", referrer)?;
        let name = format!("accessor {index}");
        let layout = self.layout::<1>(accessor, &name)?;
        let is_unsigned = matches!(layout.component, Component::U8 | Component::U16 | Component::U32);
        if accessor.normalized || !is_unsigned {
            return Err(Fault::Invalid(format!("{name} holds indices that are not unsigned integers")));
        }
        let indices = self.elements::<1, u32>(
            accessor,
            &layout,
            &name,
            |bytes| layout.component.to_bits(bytes),
            budget,
        )?;
        Ok(indices.into_flattened())
    }

    /// All elements of an accessor, with those that are stored sparsely (section 3.6.2.3) in their places.
    fn elements<const N: usize, T: Copy + Default>(
        &self,
        accessor: &Accessor,
        layout: &Layout,
        name: &str,
        component: impl Fn(&[u8]) -> T,
        budget: &mut Budget,
    ) -> Result<Vec<[T; N]>, Fault> {
        let size = layout.component.size();
        let element = |bytes: &[u8], start: usize| -> [T; N] {
            std::array::from_fn(|c| component(&bytes[start + c * size..]))
        };
        budget.take(layout.count, size_of::<[T; N]>())?;
        let mut elements = match layout.bytes {
            Some(bytes) => (0..layout.count).map(|i| element(bytes, i * layout.stride)).collect(),
            None => vec![[T::default(); N]; layout.count],
        };
        let Some(sparse) = &accessor.sparse else { return Ok(elements) };
        let count = sparse.count.0;
        if count > layout.count {
            return Err(Fault::Invalid(format!("{name} replaces {count} of its {} elements", layout.count)));
        }
        let places = self.integers(
            (sparse.indices.buffer_view.0, sparse.indices.byte_offset.0),
            sparse.indices.component_type.0,
            count,
            name,
            budget,
        )?;
        let view = self.buffers.view(sparse.values.buffer_view.0, name)?;
        let values = from_offset(view, sparse.values.byte_offset.0, count, N * size, N * size, name)?;
        for (i, place) in places.into_iter().enumerate() {
            let target = elements.get_mut(place as usize);
            *target
                .ok_or_else(|| Fault::Invalid(format!("{name} replaces an element {place} it lacks")))? =
                element(values, i * N * size);
        }
        Ok(elements)
    }

    fn layout<const N: usize>(&self, accessor: &Accessor, name: &str) -> Result<Layout<'_>, Fault> {
        if width(accessor) != Some(N) {
            let shape = gnomon_messages::quoted(&accessor.shape);
            return Err(Fault::Invalid(format!("{name} is of type {shape} where {N} components are wanted")));
        }
        let component = component(accessor, name)?;
        let (element, count) = (N * component.size(), accessor.count.0);
        let mut layout = Layout { bytes: None, stride: element, count, component };
        if let Some(view) = accessor.buffer_view {
            let bytes = self.buffers.view(view.0, name)?;
            let entry = self.root.buffer_views.get(view.0);
            let stride = entry.and_then(|view| match &view.extensions.meshopt {
                Some(packed) => Some(packed.byte_stride),
                None => view.byte_stride,
            });
            layout.stride = stride.map_or(element, |stride| stride.0);
            if layout.stride < element {
                return Err(Fault::Invalid(format!("the elements of {name} overlap")));
            }
            layout.bytes =
                Some(from_offset(bytes, accessor.byte_offset.0, count, layout.stride, element, name)?);
        }
        Ok(layout)
    }

    /// `count` unsigned integers, tightly packed at an offset in a view.
    fn integers(
        &self,
        (view, offset): (usize, usize),
        component: usize,
        count: usize,
        name: &str,
        budget: &mut Budget,
    ) -> Result<Vec<u32>, Fault> {
        let component = Component::new(component)
            .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
            .ok_or_else(|| Fault::Invalid(format!("{name} has sparse indices of a wrong type")))?;
        let view = self.buffers.view(view, name)?;
        let bytes = from_offset(view, offset, count, component.size(), component.size(), name)?;
        budget.take(count, size_of::<u32>())?;
        Ok((0..count).map(|i| component.to_bits(&bytes[i * component.size()..])).collect())
    }
}

/// The view from `offset` on, checked to hold `count` elements of `element` bytes every `stride` bytes.
fn from_offset<'a>(
    view: &'a [u8],
    offset: usize,
    count: usize,
    stride: usize,
    element: usize,
    name: &str,
) -> Result<&'a [u8], Fault> {
    let end = match count {
        0 => Some(offset),
        _ => (count - 1).checked_mul(stride).and_then(|last| last.checked_add(element)?.checked_add(offset)),
    };
    end.filter(|&end| end <= view.len()).and_then(|_| view.get(offset..)).ok_or_else(|| {
        Fault::Invalid(format!("{name} reaches beyond its buffer view ({} bytes)", view.len()))
    })
}

fn component(accessor: &Accessor, name: &str) -> Result<Component, Fault> {
    let component = Component::new(accessor.component_type.0);
    component.ok_or_else(|| Fault::Invalid(format!("{name} has an unknown component type")))
}

/// Components of an element; `None` for types that are not read.
fn width(accessor: &Accessor) -> Option<usize> {
    Some(match accessor.shape.as_str() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        // The only matrices that are read; their columns are never padded.
        "MAT4" => 16,
        _ => return None,
    })
}
