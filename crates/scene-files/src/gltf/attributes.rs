//! Vertex attributes of a primitive (specification, section 3.7.2.1), compressed or not.

use glam::{Vec2, Vec3, Vec4};

use super::accessors::Accessors;
use super::draco::Geometry;
use super::schema::{Int, Primitive};
use super::{Budget, Fault};

/// The attributes of one primitive, all as long as its positions.
pub struct Attributes<'a> {
    primitive: &'a Primitive,
    accessors: &'a Accessors<'a>,
    /// Of the primitive, for messages.
    pub name: &'a str,
    /// Number of vertices.
    pub count: usize,
    compressed: Option<Geometry<'a>>,
}

impl<'a> Attributes<'a> {
    /// `None` for a primitive without positions.
    pub fn new(
        primitive: &'a Primitive,
        accessors: &'a Accessors<'a>,
        name: &'a str,
        budget: &mut Budget,
    ) -> Result<Option<Self>, Fault> {
        let Some(&Int(position)) = primitive.attributes.get("POSITION") else { return Ok(None) };
        let mut attributes =
            Self { primitive, accessors, name, count: accessors.count(position, name)?, compressed: None };
        // Where the same is there uncompressed, it needs no decoding.
        let is_plain =
            accessors.root.accessors.get(position).is_some_and(|accessor| accessor.buffer_view.is_some());
        if let (Some(entry), false) = (&primitive.extensions.draco, is_plain) {
            let geometry = Geometry::read(entry, accessors.buffers, name, budget)?;
            attributes.count = geometry.count();
            attributes.compressed = Some(geometry);
        }
        Ok(Some(attributes))
    }

    /// Values of an attribute, if the primitive has it.
    pub fn read<const N: usize>(
        &self,
        semantic: &str,
        budget: &mut Budget,
    ) -> Result<Option<Vec<[f32; N]>>, Fault> {
        self.read_as(semantic, None, budget)
    }

    /// The same of integers that count as normalized, whatever the accessor says, where that is given.
    fn read_as<const N: usize>(
        &self,
        semantic: &str,
        normalized: Option<bool>,
        budget: &mut Budget,
    ) -> Result<Option<Vec<[f32; N]>>, Fault> {
        let Some(&Int(index)) = self.primitive.attributes.get(semantic) else { return Ok(None) };
        if let Some(geometry) = &self.compressed
            && let Some(mut values) = geometry.values(semantic, budget)?
        {
            let largest = self.accessors.range(index, normalized, self.name)?;
            if largest != 1.0 {
                values.iter_mut().flatten().for_each(|value| *value = (*value / largest).max(-1.0));
            }
            return Ok(Some(values));
        }
        let count = self.accessors.count(index, self.name)?;
        if count != self.count {
            let (name, wanted) = (self.name, self.count);
            return Err(Fault::Invalid(format!(
                "{name}: accessor {index} has {count} elements, not {wanted}"
            )));
        }
        self.accessors.floats_as(index, normalized, self.name, budget).map(Some)
    }

    pub fn vec2s(&self, semantic: &str, budget: &mut Budget) -> Result<Vec<Vec2>, Fault> {
        let values = self.read(semantic, budget)?.unwrap_or_default();
        Ok(values.into_iter().map(Vec2::from_array).collect())
    }

    pub fn vec3s(&self, semantic: &str, budget: &mut Budget) -> Result<Vec<Vec3>, Fault> {
        let values = self.read(semantic, budget)?.unwrap_or_default();
        Ok(values.into_iter().map(Vec3::from_array).collect())
    }

    pub fn vec4s(&self, semantic: &str, budget: &mut Budget) -> Result<Vec<Vec4>, Fault> {
        let values = self.read(semantic, budget)?.unwrap_or_default();
        Ok(values.into_iter().map(Vec4::from_array).collect())
    }

    /// Linear colours with alpha, clamped to 0..1 as section 3.7.2.1 asks for. Bytes and shorts may only be normalized ones: tools forget
    /// to say so.
    pub fn colors(&self, budget: &mut Budget, warnings: &mut Vec<String>) -> Result<Vec<Vec4>, Fault> {
        const COLOR: &str = "COLOR_0";
        let Some(&Int(index)) = self.primitive.attributes.get(COLOR) else { return Ok(Vec::new()) };
        if self.accessors.range(index, None, self.name)?
            != self.accessors.range(index, Some(true), self.name)?
        {
            warnings.push(format!("{}: colours in whole numbers are read as normalized", self.name));
        }
        let mut colors: Vec<Vec4> = if self.accessors.width(index, self.name)? == 3 {
            let colors = self.read_as::<3>(COLOR, Some(true), budget)?.unwrap_or_default();
            budget.take(colors.len(), size_of::<Vec4>())?;
            colors.into_iter().map(|[r, g, b]| Vec4::new(r, g, b, 1.0)).collect()
        } else {
            let colors = self.read_as::<4>(COLOR, Some(true), budget)?.unwrap_or_default();
            colors.into_iter().map(Vec4::from_array).collect()
        };
        if colors.iter().any(|color| color.max_element() > 1.0) {
            warnings.push(format!("{}: colours above 1 are clamped", self.name));
        }
        for color in colors.iter_mut().filter(|color| color.is_finite()) {
            *color = color.clamp(Vec4::ZERO, Vec4::ONE);
        }
        Ok(colors)
    }

    /// Vertex numbers of triangles, strips or fans.
    pub fn indices(&self, budget: &mut Budget) -> Result<Vec<u32>, Fault> {
        if let Some(geometry) = &self.compressed {
            return geometry.indices(budget);
        }
        if let Some(Int(accessor)) = self.primitive.indices {
            return self.accessors.indices(accessor, self.name, budget);
        }
        budget.take(self.count, size_of::<u32>())?;
        let count = u32::try_from(self.count);
        Ok((0..count.map_err(|_| Fault::Invalid(format!("{} has too many vertices", self.name)))?).collect())
    }

    /// Whether the indices are those of a list of triangles, whatever the primitive's mode is.
    pub fn is_list(&self) -> bool {
        self.compressed.is_some()
    }
}
