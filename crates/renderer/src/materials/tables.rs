//! Reflectances that are tables, as layers of one texture array.

use std::sync::Arc;

use glam::Vec3;
use gnomon_brdf::Surface;
use gnomon_brdf::tables::{Table, Tables};
use gnomon_scene::Material;
use gnomon_shaders::layout;

use crate::bindings::{Binding, D2_ARRAY, array_view};
use crate::{Gpu, RenderError};

/// Full precision: what samples are drawn from are sums near 1.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Rows of a layer, more where a table has more.
const ROWS: usize = 128;

/// Bindings 4 to 6 of passes that evaluate reflectances.
pub(crate) fn bindings() -> [(u32, Binding); 3] {
    let texels = Binding::Texture { dimension: D2_ARRAY, filterable: false };
    [(4, Binding::Uniform), (5, Binding::Uniform), (6, texels)]
}

/// What tables of a material are made of: the parameters that they depend on, or the file's own tables.
type Origin = (Surface, Option<Arc<Tables>>);

/// Tables of a scene's materials, each once.
#[derive(Default)]
pub(crate) struct TabulatedMaterials {
    known: Vec<(Origin, Arc<Tables>)>,
    /// Of every material.
    numbers: Vec<Option<usize>>,
}

impl TabulatedMaterials {
    /// Tables of these materials; those that `before` has are not made again.
    pub fn new<'a>(materials: impl Iterator<Item = &'a Material>, before: Option<&Self>) -> Self {
        let mut tabulated = Self::default();
        for material in materials {
            let number = tabulated.number_of(material, before);
            tabulated.numbers.push(number);
        }
        tabulated
    }

    fn number_of(&mut self, material: &Material, before: Option<&Self>) -> Option<usize> {
        let is_same = |a: &Origin, b: &Origin| match (&a.1, &b.1) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        } && a.0 == b.0;
        let origin = (material.surface.tabulated(), material.tables.clone());
        let place = self.known.iter().position(|(known, _)| is_same(known, &origin));
        place.or_else(|| {
            let mut known = before.into_iter().flat_map(|before| &before.known);
            let made = known.find(|(known, _)| is_same(known, &origin)).map(|(_, tables)| Arc::clone(tables));
            let tables = made.or_else(|| material.reflectance_tables())?;
            self.known.push((origin, tables));
            Some(self.known.len() - 1)
        })
    }

    /// Whether materials have the same tables by the same numbers.
    pub fn has_those_of(&self, other: &Self) -> bool {
        let tables = |set: &Self| set.known.iter().map(|(_, tables)| Arc::as_ptr(tables)).collect::<Vec<_>>();
        tables(self) == tables(other)
    }

    /// The number of a material's tables in the shaders.
    pub fn number(&self, material: usize) -> Option<usize> {
        self.numbers.get(material).copied().flatten()
    }

    /// What the GPU holds of them.
    pub fn packed(&self, gpu: &Gpu) -> Result<PackedTables, RenderError> {
        let packed = PackedTables::new(self.known.iter().map(|(_, tables)| tables.as_ref()));
        let over = |what, wanted: usize, limit: u32| RenderError::OverLimit {
            what,
            wanted: wanted as u64,
            limit: u64::from(limit),
            adapter: gpu.adapter().name.clone(),
        };
        if packed.sets.len() > layout::MAX_TABLE_SETS as usize {
            return Err(over("reflectances that are tables", packed.sets.len(), layout::MAX_TABLE_SETS));
        }
        if packed.factors.len() > layout::MAX_TABLE_FACTORS as usize {
            return Err(over("tables of reflectances", packed.factors.len(), layout::MAX_TABLE_FACTORS));
        }
        Ok(packed)
    }
}

/// Tables side by side in layers of one size, under each other.
pub(crate) struct PackedTables {
    sets: Vec<layout::TableSet>,
    factors: Vec<layout::TableFactor>,
    /// Texels a row, rows a layer.
    size: [usize; 2],
    layers: Vec<Vec<Vec3>>,
    /// Rows in use of the last layer.
    rows: usize,
}

impl PackedTables {
    pub fn new<'a>(sets: impl Iterator<Item = &'a Tables> + Clone) -> Self {
        let tables = sets.clone().flat_map(|set| {
            let factors = set.terms().iter().flat_map(|term| &term.factors).map(|factor| &factor.table);
            factors.chain([set.albedo_table(), set.proposal().table()])
        });
        let size = tables
            .fold([1, ROWS], |[columns, rows], table| [columns.max(table.columns()), rows.max(table.rows())]);
        let layers = vec![vec![Vec3::ZERO; size[0] * size[1]]];
        let mut packed = Self { sets: Vec::new(), factors: Vec::new(), size, layers, rows: 0 };
        for set in sets {
            packed.add(set);
        }
        packed
    }

    fn add(&mut self, set: &Tables) {
        let first_factor = self.factors.len() as u32;
        for term in set.terms() {
            for (index, factor) in term.factors.iter().enumerate() {
                let (layer, first_row) = self.place(&factor.table);
                self.factors.push(layout::TableFactor {
                    coordinates: factor.coordinates.number(),
                    tint: if index == 0 { term.tint as u32 } else { layout::TABLE_MULTIPLIES },
                    layer,
                    first_row,
                    columns: factor.table.columns() as u32,
                    rows: factor.table.rows() as u32,
                    periodic: u32::from(factor.coordinates.is_periodic()),
                    scale: factor.scale,
                    parameters: factor.coordinates.parameters(),
                });
            }
        }
        let (albedo_layer, albedo_row) = self.place(set.albedo_table());
        let proposal = set.proposal();
        let (proposal_layer, proposal_row) = self.place(proposal.table());
        self.sets.push(layout::TableSet {
            first_factor,
            end_factor: self.factors.len() as u32,
            albedo_layer,
            albedo_row,
            albedo_columns: set.albedo_table().columns() as u32,
            proposal_layer,
            proposal_row,
            proposal_columns: proposal.table().columns() as u32,
            proposal_rows: proposal.table().rows() as u32,
            proposal_scale: proposal.scale(),
            turn: set.turn(),
            roughness: set.roughness(),
        });
    }

    /// Puts a table into a layer. Returns that and its first row there.
    fn place(&mut self, table: &Table) -> (u32, u32) {
        let [columns, rows] = self.size;
        if self.rows + table.rows() > rows {
            self.layers.push(vec![Vec3::ZERO; columns * rows]);
            self.rows = 0;
        }
        let layer = self.layers.len() - 1;
        for (row, values) in table.values().chunks(table.columns()).enumerate() {
            let start = (self.rows + row) * columns;
            self.layers[layer][start..start + values.len()].copy_from_slice(values);
        }
        let first_row = self.rows;
        self.rows += table.rows();
        (layer as u32, first_row as u32)
    }

    fn extent(&self) -> [u32; 3] {
        [self.size[0] as u32, self.size[1] as u32, self.layers.len() as u32]
    }
}

/// Tables on the GPU.
pub(crate) struct TableTextures {
    sets: wgpu::Buffer,
    factors: wgpu::Buffer,
    texels: wgpu::Texture,
    view: wgpu::TextureView,
    /// [`bindings`] of it alone.
    pub group: wgpu::BindGroup,
}

impl TableTextures {
    pub fn new(gpu: &Gpu, packed: &PackedTables) -> Self {
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let buffer = |label, size: u64, count: u32| gpu.empty_buffer(label, size * u64::from(count), uniform);
        let sets = buffer("sets of tables", layout::size::<layout::TableSet>(), layout::MAX_TABLE_SETS);
        let factors =
            buffer("factors of tables", layout::size::<layout::TableFactor>(), layout::MAX_TABLE_FACTORS);
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texels = gpu.texture("tables", packed.extent(), 1, FORMAT, usage);
        let view = array_view(&texels);
        let layout = gpu.layout("tables", wgpu::ShaderStages::COMPUTE, &bindings());
        let group = gpu.bind_group("tables", &layout, &resources(&sets, &factors, &view));
        let textures = Self { sets, factors, texels, view, group };
        textures.write(gpu, packed);
        textures
    }

    /// Whether these tables can take the place of its own.
    pub fn has_room_for(&self, packed: &PackedTables) -> bool {
        let size = self.texels.size();
        [size.width, size.height, size.depth_or_array_layers] == packed.extent()
    }

    /// Takes tables over, where it has room for them.
    pub fn write(&self, gpu: &Gpu, packed: &PackedTables) {
        gpu.write(&self.sets, packed.sets.as_slice());
        gpu.write(&self.factors, packed.factors.as_slice());
        let [width, height, _] = packed.extent();
        for (layer, texels) in (0..).zip(&packed.layers) {
            let texels: Vec<[f32; 4]> = texels.iter().map(|texel| texel.extend(0.0).to_array()).collect();
            gpu.write_texture(&self.texels, [0, layer], [width, height], bytemuck::cast_slice(&texels));
        }
    }

    pub fn resources(&self) -> [(u32, wgpu::BindingResource<'_>); 3] {
        resources(&self.sets, &self.factors, &self.view)
    }
}

fn resources<'a>(
    sets: &'a wgpu::Buffer,
    factors: &'a wgpu::Buffer,
    texels: &'a wgpu::TextureView,
) -> [(u32, wgpu::BindingResource<'a>); 3] {
    let texels = wgpu::BindingResource::TextureView(texels);
    [(4, sets.as_entire_binding()), (5, factors.as_entire_binding()), (6, texels)]
}
