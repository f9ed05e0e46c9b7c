//! Compressed primitives (`KHR_draco_mesh_compression`).

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};

use super::buffers::Buffers;
use super::schema::Draco;
use super::{Budget, Fault};

/// Times the values that come out that decoding takes at most, beside them: corner tables, and integers before they are floats.
const WORKING_SPACE: usize = 4;

/// What a primitive's compressed data holds.
pub struct Geometry<'a> {
    entry: &'a Draco,
    mesh: Mesh,
}

impl<'a> Geometry<'a> {
    /// Decodes it; `name` is the primitive's.
    pub fn read(entry: &'a Draco, buffers: &Buffers, name: &str, budget: &mut Budget) -> Result<Self, Fault> {
        let bytes = buffers.view(entry.buffer_view.0, name)?;
        let mut limits = DecodeLimits::default();
        let most = (budget.left / WORKING_SPACE) as u64;
        limits.max_decoded_bytes = limits.max_decoded_bytes.min(most);
        limits.max_faces = limits.max_faces.min(most / 12);
        limits.max_points = limits.max_points.min(most / 12);
        let mut mesh = Mesh::new();
        let decoded =
            MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh);
        decoded.map_err(|error| Fault::Invalid(format!("{name}: its Draco data cannot be read: {error}")))?;
        Ok(Self { entry, mesh })
    }

    /// Number of its vertices.
    pub fn count(&self) -> usize {
        self.mesh.num_points()
    }

    /// Corners of its triangles.
    pub fn indices(&self, budget: &mut Budget) -> Result<Vec<u32>, Fault> {
        budget.take(self.mesh.num_faces(), 3 * size_of::<u32>())?;
        Ok(self.mesh.faces().iter().flatten().map(|point| point.0).collect())
    }

    /// Values of an attribute, integers as they are; `None` where it has none of that name.
    pub fn values<const N: usize>(
        &self,
        semantic: &str,
        budget: &mut Budget,
    ) -> Result<Option<Vec<[f32; N]>>, Fault> {
        let id = self.entry.attributes.get(semantic).and_then(|id| u32::try_from(id.0).ok());
        let Some(attribute) = id.and_then(|id| self.mesh.attribute_by_unique_id(id)) else { return Ok(None) };
        budget.take(self.count(), size_of::<[f32; N]>())?;
        Ok(Some(attribute.read_f32s(self.count(), N).as_chunks().0.to_vec()))
    }
}
