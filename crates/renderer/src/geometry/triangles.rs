//! The index buffer of a scene: laid out anew for each, of what the one before holds already and what has to be uploaded.

use std::ops::Range;

use crate::Gpu;

/// Where the triangles of an instance lie in the index buffer.
#[derive(Clone, Default)]
pub(super) struct Run {
    pub whole: Range<u32>,
    /// Simpler ones, level by level.
    pub simpler: Vec<Range<u32>>,
}

/// An index buffer in the making.
#[derive(Default)]
pub(super) struct IndexLayout {
    pub count: u32,
    /// Ranges of the buffer before, and where they go.
    copies: Vec<(Range<u32>, u32)>,
    /// Indices to be uploaded, and where to.
    uploads: Vec<(u32, Vec<u32>)>,
}

impl IndexLayout {
    /// Adds triangles at the end, and tells their range; `before` is where the buffer before has them, with the same vertices.
    pub fn push(
        &mut self,
        triangles: &[[u32; 3]],
        first_vertex: u32,
        before: Option<&Range<u32>>,
    ) -> Range<u32> {
        let start = self.count;
        self.count += 3 * triangles.len() as u32;
        match before {
            Some(source) => match self.copies.last_mut() {
                Some((last, to)) if last.end == source.start && *to + last.len() as u32 == start => {
                    last.end = source.end;
                }
                _ => self.copies.push((source.clone(), start)),
            },
            None => {
                let indices = triangles.iter().flatten().map(|index| first_vertex + index);
                match self.uploads.last_mut() {
                    Some((at, last)) if *at + last.len() as u32 == start => last.extend(indices),
                    _ => self.uploads.push((start, indices.collect())),
                }
            }
        }
        start..self.count
    }

    /// The buffer.
    pub fn buffer(self, gpu: &Gpu, before: Option<&wgpu::Buffer>) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let buffer = gpu.empty_buffer("indices", 4 * u64::from(self.count), usage);
        for (at, indices) in self.uploads {
            gpu.write_bytes(&buffer, 4 * u64::from(at), bytemuck::cast_slice(&indices));
        }
        let Some(before) = before.filter(|_| !self.copies.is_empty()) else { return buffer };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for (from, to) in self.copies {
            let [from, to, bytes] = [from.start, to, from.len() as u32].map(|indices| 4 * u64::from(indices));
            encoder.copy_buffer_to_buffer(before, from, &buffer, to, bytes);
        }
        gpu.queue.submit([encoder.finish()]);
        buffer
    }
}
