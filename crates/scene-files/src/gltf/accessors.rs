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

    /// The component at the start of `bytes`, which has `size()` of them; normalized as in section 3.6.2.2.
    fn to_f32(self, bytes: &[u8], normalized: bool) -> f32 {
        let raw = self.to_bits(bytes);
        let (value, largest) = match self {
            Self::I8 => (f32::from(raw as i8), 127.0),
            Self::U8 => (f32::from(raw as u8), 255.0),
            Self::I16 => (f32::from(raw as i16), 32_767.0),
            Self::U16 => (f32::from(raw as u16), 65_535.0),
            Self::U32 => (raw as f32, u32::MAX as f32),
            Self::F32 => return f32::from_bits(raw),
        };
        if normalized { (value / largest).max(-1.0) } else { value }
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
    normalized: bool,
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

    /// Elements of `N` components as floats; integers are divided by their range where the accessor is normalized.
    pub fn floats<const N: usize>(
        &self,
        index: usize,
        referrer: &str,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; N]>, Fault> {
        let accessor = get(&self.root.accessors, index, "accessor", referrer)?;
        let name = format!("accessor {index}");
        let layout = self.layout::<N>(accessor, &name)?;
        let size = layout.component.size();
        let element = |bytes: &[u8], start: usize| -> [f32; N] {
            std::array::from_fn(|c| layout.component.to_f32(&bytes[start + c * size..], layout.normalized))
        };
        budget.take(layout.count, size_of::<[f32; N]>())?;
        let mut elements = match layout.bytes {
            Some(bytes) => (0..layout.count).map(|i| element(bytes, i * layout.stride)).collect(),
            None => vec![[0.0; N]; layout.count],
        };
        if let Some(sparse) = &accessor.sparse {
            let count = sparse.count.0;
            if count > layout.count {
                return Err(Fault::Invalid(format!(
                    "{name} replaces {count} of its {} elements",
                    layout.count
                )));
            }
            let places = self.integers(
                (sparse.indices.buffer_view.0, sparse.indices.byte_offset.0),
                sparse.indices.component_type.0,
                count,
                &name,
                budget,
            )?;
            let view = self.buffers.view(sparse.values.buffer_view.0, &name)?;
            let values = from_offset(view, sparse.values.byte_offset.0, count, N * size, N * size, &name)?;
            for (i, place) in places.into_iter().enumerate() {
                let target = elements.get_mut(place as usize);
                *target.ok_or_else(|| {
                    Fault::Invalid(format!("{name} replaces an element {place} it lacks"))
                })? = element(values, i * N * size);
            }
        }
        Ok(elements)
    }

    /// Vertex indices.
    pub fn indices(&self, index: usize, referrer: &str, budget: &mut Budget) -> Result<Vec<u32>, Fault> {
        let accessor = get(&self.root.accessors, index, "accessor", referrer)?;
        let name = format!("accessor {index}");
        let layout = self.layout::<1>(accessor, &name)?;
        if layout.normalized || !matches!(layout.component, Component::U8 | Component::U16 | Component::U32) {
            return Err(Fault::Invalid(format!("{name} holds indices that are not unsigned integers")));
        }
        if accessor.sparse.is_some() {
            return Err(Fault::Unsupported(format!("{name} holds sparse indices")));
        }
        budget.take(layout.count, size_of::<u32>())?;
        Ok(match layout.bytes {
            Some(bytes) => {
                (0..layout.count).map(|i| layout.component.to_bits(&bytes[i * layout.stride..])).collect()
            }
            None => vec![0; layout.count],
        })
    }

    fn layout<const N: usize>(&self, accessor: &Accessor, name: &str) -> Result<Layout<'_>, Fault> {
        if width(accessor) != Some(N) {
            let shape = gnomon_messages::quoted(&accessor.shape);
            return Err(Fault::Invalid(format!("{name} is of type {shape} where {N} components are wanted")));
        }
        let component = Component::new(accessor.component_type.0)
            .ok_or_else(|| Fault::Invalid(format!("{name} has an unknown component type")))?;
        if accessor.normalized && matches!(component, Component::U32 | Component::F32) {
            return Err(Fault::Invalid(format!("{name} is normalized, which its component type cannot be")));
        }
        let (element, count) = (N * component.size(), accessor.count.0);
        let mut layout =
            Layout { bytes: None, stride: element, count, component, normalized: accessor.normalized };
        if let Some(view) = accessor.buffer_view {
            let bytes = self.buffers.view(view.0, name)?;
            let stride = self.root.buffer_views.get(view.0).and_then(|view| view.byte_stride);
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
