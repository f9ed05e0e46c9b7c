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
pub(super) struct IndexLayout<'a> {
    pub count: u32,
    /// Ranges of the buffer before, and where they go.
    copies: Vec<(Range<u32>, u32)>,
    /// Triangles to be uploaded, and where to: indices of vertices behind a first one.
    uploads: Vec<(u32, &'a [[u32; 3]], u32)>,
}

/// Indices that are written at a time: all of them would be as much memory again.
const PART: usize = 3 << 18;

impl<'a> IndexLayout<'a> {
    /// Adds triangles at the end, and tells their range; `before` is where the buffer before has them, with the same vertices.
    pub fn push(
        &mut self,
        triangles: &'a [[u32; 3]],
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
            None => self.uploads.push((start, triangles, first_vertex)),
        }
        start..self.count
    }

    /// The buffer.
    pub fn buffer(self, gpu: &Gpu, before: Option<&wgpu::Buffer>) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let buffer = gpu.empty_buffer("indices", 4 * u64::from(self.count), usage);
        let (mut part, mut start): (Vec<u32>, u32) = (Vec::new(), 0);
        let write = |part: &mut Vec<u32>, start: u32| {
            gpu.write_bytes(&buffer, 4 * u64::from(start), bytemuck::cast_slice(part));
            part.clear();
            // What was copied is let go once it has arrived.
            gpu.queue.submit([]);
        };
        for (at, triangles, first_vertex) in self.uploads {
            for (place, triangles) in (0..).step_by(PART).zip(triangles.chunks(PART / 3)) {
                let at = at + place;
                if part.len() >= PART || start + part.len() as u32 != at {
                    write(&mut part, start);
                    start = at;
                }
                part.extend(triangles.iter().flatten().map(|index| first_vertex + index));
            }
        }
        write(&mut part, start);
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
