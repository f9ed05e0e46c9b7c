//! Buffers that grow at their end.

use crate::Gpu;

/// A buffer to whose end more is written. What lies behind the end nobody reads: there a change may write that fails afterwards.
#[derive(Clone)]
pub(super) struct Store {
    pub buffer: wgpu::Buffer,
    label: &'static str,
    end: u64,
}

impl Store {
    /// A store of `bytes`.
    pub fn new(gpu: &Gpu, label: &'static str, bytes: &[u8], usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_SRC;
        Self { buffer: gpu.buffer_with(label, bytes, usage), label, end: bytes.len() as u64 }
    }

    /// An empty one with room for so many bytes.
    pub fn with_room(gpu: &Gpu, label: &'static str, bytes: u64, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        Self { buffer: gpu.empty_buffer(label, bytes, usage), label, end: 0 }
    }

    /// The same with room for so many more bytes at its end. Where the buffer has none it is copied on the GPU to a larger one, of up to
    /// `most` bytes unless more are needed.
    pub fn grown(&self, gpu: &Gpu, more: u64, most: u64) -> Self {
        let end = self.end + more;
        let mut grown = self.clone();
        if end > self.buffer.size() {
            let size = (self.buffer.size() / 2 * 3).min(most).max(end);
            grown.buffer = gpu.empty_buffer(self.label, size, self.buffer.usage());
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&self.buffer, 0, &grown.buffer, 0, self.end);
            gpu.queue.submit([encoder.finish()]);
        }
        grown
    }

    /// Writes at the end, where there is room.
    pub fn push(&mut self, gpu: &Gpu, bytes: &[u8]) {
        gpu.write_bytes(&self.buffer, self.end, bytes);
        self.end += bytes.len() as u64;
    }

    /// Bytes that count.
    pub fn end(&self) -> u64 {
        self.end
    }
}
