//! What the GPU wrote, on its way back. Nothing here waits.

use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use crate::{Gpu, RenderError};

/// Bytes of a buffer: ready once the GPU has written them and the device was polled after that (browsers do so by themselves).
pub(crate) struct ReadBack {
    gpu: Gpu,
    buffer: wgpu::Buffer,
    mapping: Arc<Mutex<Mapping>>,
}

#[derive(Default)]
struct Mapping {
    result: Option<Result<(), wgpu::BufferAsyncError>>,
    waker: Option<Waker>,
}

impl ReadBack {
    /// Of a mappable buffer, as it is after the commands of `encoder` so far; it may not be used by later ones.
    pub fn of_buffer(gpu: &Gpu, encoder: &wgpu::CommandEncoder, buffer: wgpu::Buffer) -> Self {
        let mapping = Arc::new(Mutex::new(Mapping::default()));
        let told = Arc::clone(&mapping);
        encoder.map_buffer_on_submit(&buffer, wgpu::MapMode::Read, .., move |result| {
            let mut mapping = locked(&told);
            mapping.result = Some(result);
            if let Some(waker) = mapping.waker.take() {
                waker.wake();
            }
        });
        Self { gpu: gpu.clone(), buffer, mapping }
    }
}

impl Future for ReadBack {
    type Output = Result<Vec<u8>, RenderError>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let mut mapping = locked(&self.mapping);
        let failed = |words: String| Err(RenderError::Device(words));
        Poll::Ready(match mapping.result {
            None => {
                mapping.waker = Some(context.waker().clone());
                return Poll::Pending;
            }
            Some(Ok(())) => match self.buffer.get_mapped_range(..) {
                Ok(bytes) => Ok(bytes.to_vec()),
                Err(error) => failed(error.to_string()),
            },
            // A lost device explains it better.
            Some(Err(ref error)) => self.gpu.check().and(failed(error.to_string())),
        })
    }
}

fn locked(mapping: &Mutex<Mapping>) -> MutexGuard<'_, Mapping> {
    mapping.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Level 0 of a two-dimensional texture.
pub(crate) struct TextureReadBack {
    rows: ReadBack,
    row: usize,
    padded_row: usize,
    height: usize,
}

impl TextureReadBack {
    /// Of a texture of `texel_bytes` bytes a texel, as it is after the commands of `encoder` so far.
    pub fn new(
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        texel_bytes: u32,
    ) -> Self {
        let (width, height) = (texture.width(), texture.height());
        let row = width * texel_bytes;
        let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(padded_row) * u64::from(height);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let buffer = gpu.empty_buffer("read back", size, usage);
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row),
                    rows_per_image: Some(height),
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        Self {
            rows: ReadBack::of_buffer(gpu, encoder, buffer),
            row: row as usize,
            padded_row: padded_row as usize,
            height: height as usize,
        }
    }

    /// Rows without padding, top row first.
    pub async fn texels(self) -> Result<Vec<u8>, RenderError> {
        let bytes = self.rows.await?;
        let rows = bytes.chunks(self.padded_row).take(self.height);
        Ok(rows.flat_map(|padded| &padded[..self.row]).copied().collect())
    }
}
