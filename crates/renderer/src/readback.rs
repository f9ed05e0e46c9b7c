use crate::{Gpu, RenderError};

impl Gpu {
    /// Copies level 0 of a two-dimensional texture back: tightly packed rows of `texel_bytes` bytes a texel.
    pub(crate) fn read_texture(
        &self,
        texture: &wgpu::Texture,
        texel_bytes: u32,
    ) -> Result<Vec<u8>, RenderError> {
        let (width, height) = (texture.width(), texture.height());
        let row = width * texel_bytes;
        let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(padded_row) * u64::from(height);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let buffer = self.empty_buffer("readback", size, usage);
        let mut encoder = self.device.create_command_encoder(&Default::default());
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
        self.queue.submit([encoder.finish()]);
        let mapped = self.read_buffer(&buffer)?;
        Ok(mapped
            .chunks(padded_row as usize)
            .take(height as usize)
            .flat_map(|padded| &padded[..row as usize])
            .copied()
            .collect())
    }

    /// Bytes of a mappable buffer.
    pub(crate) fn read_buffer(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, RenderError> {
        let (send, receive) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only if waiting failed, and that is reported already.
            let _ = send.send(result);
        });
        self.wait()?;
        match receive.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(RenderError::Device(error.to_string())),
            Err(_) => return Err(RenderError::Device("reading a buffer back did not finish".to_owned())),
        }
        let bytes =
            buffer.get_mapped_range(..).map_err(|error| RenderError::Device(error.to_string()))?.to_vec();
        buffer.unmap();
        Ok(bytes)
    }
}
