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

    /// The same with more at its end. Where the buffer has no room it is copied on the GPU to a larger one, of up to `most` bytes unless
    /// more are needed.
    pub fn with(&self, gpu: &Gpu, bytes: &[u8], most: u64) -> Self {
        let end = self.end + bytes.len() as u64;
        let mut grown = Self { end, ..self.clone() };
        if end > self.buffer.size() {
            let size = (self.buffer.size() / 2 * 3).min(most).max(end);
            grown.buffer = gpu.empty_buffer(self.label, size, self.buffer.usage());
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&self.buffer, 0, &grown.buffer, 0, self.end);
            gpu.queue.submit([encoder.finish()]);
        }
        gpu.write_bytes(&grown.buffer, self.end, bytes);
        grown
    }

    /// Bytes that count.
    pub fn end(&self) -> u64 {
        self.end
    }
}
