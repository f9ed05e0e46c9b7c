//! Summed-area tables of the basis images, 32-bit floats.

use gnomon_shaders::layout;

use super::{DEPTH_FORMAT, IMAGES, Images};
use crate::bindings::{Binding, D2_ARRAY, array_view};
use crate::recorder::Recorder;
use crate::shadow::depth_maps::DepthMaps;
use crate::{Gpu, RenderError};

const BASIS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Bytes of one light's images: four tables and the row sums of one, of 16 bytes a texel and group, and linear depth of 4.
pub(super) fn bytes_per_light(groups: u32, resolution: u32) -> u64 {
    u64::from(resolution).pow(2) * (u64::from(groups) * 5 * 16 + 4)
}

/// Makes the tables one after the other, so that one image of row sums serves all of them.
pub(super) struct SummedAreaTables {
    rows_group: wgpu::BindGroup,
    tables: Vec<Table>,
    columns_rgba32: wgpu::ComputePipeline,
    columns_r32: wgpu::ComputePipeline,
    resolution: u32,
    groups: u32,
}

struct Table {
    rows: wgpu::ComputePipeline,
    columns_group: wgpu::BindGroup,
    basis: bool,
}

impl SummedAreaTables {
    pub fn new(
        gpu: &Gpu,
        parameters: &wgpu::Buffer,
        groups: u32,
        maps: &DepthMaps,
    ) -> Result<(Self, Images), RenderError> {
        let resolution = maps.resolution;
        let capacity = maps.capacity.max(1);
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let image =
            |label, layers, format| gpu.texture(label, [resolution, resolution, layers], 1, format, usage);
        let images = Images {
            basis: IMAGES.map(|label| image(label, capacity * groups, BASIS_FORMAT)),
            depth: image("linear depth", capacity, DEPTH_FORMAT),
        };
        let row_sums = array_view(&image("row sums", capacity * groups, BASIS_FORMAT));

        let compute = wgpu::ShaderStages::COMPUTE;
        let written = |format| Binding::StorageTexture { format, dimension: D2_ARRAY };
        let module = gpu.shader("summed_area", &[])?;
        let rows_layout = gpu.layout(
            "row sums",
            compute,
            &[(0, Binding::Uniform), (1, Binding::Depth { dimension: D2_ARRAY }), (2, written(BASIS_FORMAT))],
        );
        let rows_group = gpu.bind_group(
            "row sums",
            &rows_layout,
            &[
                (0, parameters.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(&maps.array)),
                (2, wgpu::BindingResource::TextureView(&row_sums)),
            ],
        );
        let loaded = Binding::Texture { dimension: D2_ARRAY, filterable: false };
        let columns_layout = |binding, format| {
            gpu.layout("summed-area table", compute, &[(3, loaded), (binding, written(format))])
        };
        let (rgba32_layout, r32_layout) = (columns_layout(4, BASIS_FORMAT), columns_layout(5, DEPTH_FORMAT));
        let entries = ["rows_sin", "rows_cos", "rows_z_sin", "rows_z_cos", "rows_depth"];
        let tables = (entries.into_iter())
            .zip(images.basis.iter().map(|image| (image, true)).chain([(&images.depth, false)]))
            .map(|(entry, (image, basis))| {
                let view = array_view(image);
                let (columns_layout, binding) = if basis { (&rgba32_layout, 4) } else { (&r32_layout, 5) };
                let columns_group = gpu.bind_group(
                    "summed-area table",
                    columns_layout,
                    &[
                        (3, wgpu::BindingResource::TextureView(&row_sums)),
                        (binding, wgpu::BindingResource::TextureView(&view)),
                    ],
                );
                let rows = gpu.compute_pipeline(&module, entry, &[(layout::GROUP_PASS, &rows_layout)]);
                Table { rows, columns_group, basis }
            })
            .collect();
        let tables = Self {
            rows_group,
            tables,
            columns_rgba32: gpu.compute_pipeline(
                &module,
                "columns_rgba32",
                &[(layout::GROUP_PASS, &rgba32_layout)],
            ),
            columns_r32: gpu.compute_pipeline(&module, "columns_r32", &[(layout::GROUP_PASS, &r32_layout)]),
            resolution,
            groups,
        };
        Ok((tables, images))
    }

    pub fn encode(&self, recorder: &mut Recorder<'_>, light_count: u32) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        let lines = self.resolution.div_ceil(layout::LINE_WORKGROUP);
        for table in &self.tables {
            let layers = if table.basis { light_count * self.groups } else { light_count };
            pass.set_pipeline(&table.rows);
            pass.set_bind_group(layout::GROUP_PASS, &self.rows_group, &[]);
            pass.dispatch_workgroups(lines, 1, layers);
            pass.set_pipeline(if table.basis { &self.columns_rgba32 } else { &self.columns_r32 });
            pass.set_bind_group(layout::GROUP_PASS, &table.columns_group, &[]);
            pass.dispatch_workgroups(lines, 1, layers);
        }
    }
}
