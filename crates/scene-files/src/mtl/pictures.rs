//! The pictures of material libraries, as textures of a scene.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use gnomon_scene::{Height, HeightMap, HeightMapId, Scene, Texture, TextureId, TextureRef, Wrap};

use super::map::Map;
use crate::error::Fault;
use crate::{Budget, Source, heights, text, texture};

/// Pictures by name, and textures by what they are made of, each once.
#[derive(Default)]
pub struct Pictures {
    decoded: HashMap<String, Option<Arc<Texture>>>,
    textures: HashMap<Recipe, TextureId>,
    /// By name and whether it ends at its edges; `None` for one that cannot be had.
    heights: HashMap<(String, bool), Option<HeightMapId>>,
}

/// Pictures of colours and of holes, the channel of the holes, and whether it ends at its edges.
type Recipe = (Option<String>, Option<(String, Option<char>)>, bool);

impl Pictures {
    /// The texture of a map, with the holes of another, which lies on the surface alike, in its alpha. Without a map it is white. `None` with a
    /// warning where no picture can be had. Pictures are looked for in the folder given, then in that of the source.
    pub fn texture(
        &mut self,
        map: Option<&Map>,
        holes: Option<&Map>,
        places: (&Source, &Path),
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<TextureRef>, Fault> {
        let colors = map.map(|map| self.picture(&map.name, places, budget, scene)).transpose()?.flatten();
        let shape = holes.map(|map| self.picture(&map.name, places, budget, scene)).transpose()?.flatten();
        let map = map.filter(|_| colors.is_some());
        let holes = holes.filter(|_| shape.is_some());
        let Some(placed) = map.or(holes) else { return Ok(None) };
        let recipe =
            (map.map(|map| map.name.clone()), holes.map(|map| (map.name.clone(), map.channel)), placed.clamp);
        let texture = match self.textures.get(&recipe) {
            Some(&known) => known,
            None => {
                let texture = match (colors, shape) {
                    (Some(picture), None) if !placed.clamp => picture,
                    (colors, shape) => {
                        let channel = holes.and_then(|map| map.channel);
                        let wrap = if placed.clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
                        Arc::new(composed(
                            colors.as_deref(),
                            shape.as_deref().map(|shape| (shape, channel)),
                            wrap,
                            budget,
                        )?)
                    }
                };
                scene.textures.push(texture);
                let id = TextureId(scene.textures.len() - 1);
                self.textures.insert(recipe, id);
                id
            }
        };
        Ok(Some(TextureRef { texture, uv_from_mesh: placed.uv_from_mesh, set: 0 }))
    }

    /// The heights of a map, its strength for their scale. `None` with a warning where no picture can be had.
    pub fn heights(
        &mut self,
        map: &Map,
        (source, folder): (&Source, &Path),
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<Height>, Fault> {
        let key = (map.name.clone(), map.clamp);
        let id = match self.heights.get(&key) {
            Some(&known) => known,
            None => {
                let wrap = if map.clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
                let found = source.find(text::names(&map.name), &[folder], budget);
                let warn = |warning| scene.warnings.push(warning);
                let decoded = found.and_then(|(path, bytes)| {
                    let map = heights::decode(&bytes, [wrap; 2], budget, warn);
                    map.map_err(|fault| match fault {
                        Fault::TooLarge { .. } => fault,
                        fault => fault.at(&path).into(),
                    })
                });
                let id = match decoded {
                    Ok(map) => Some(push(scene, map)),
                    Err(Fault::TooLarge { limit_mib }) => return Err(Fault::TooLarge { limit_mib }),
                    Err(fault) => {
                        scene.warnings.push(format!("heights are left out: {}", fault.at(source.path)));
                        None
                    }
                };
                self.heights.insert(key, id);
                id
            }
        };
        let height =
            |map_id| Height { map: map_id, uv_from_mesh: map.uv_from_mesh, set: 0, scale: map.strength };
        Ok(id.filter(|_| map.strength.is_finite()).map(height))
    }

    /// A picture by name, read once.
    fn picture(
        &mut self,
        name: &str,
        (source, folder): (&Source, &Path),
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<Arc<Texture>>, Fault> {
        if let Some(known) = self.decoded.get(name) {
            return Ok(known.clone());
        }
        let found = source.find(text::names(name), &[folder], budget);
        let picture = found.and_then(|(path, bytes)| {
            let texels = texture::decode(&bytes, budget);
            texels.map_err(|fault| match fault {
                Fault::TooLarge { .. } => fault,
                fault => fault.at(&path).into(),
            })
        });
        let picture = match picture {
            Ok(picture) => Some(Arc::new(Texture {
                width: picture.width,
                height: picture.height,
                rgba8: picture.rgba8,
                wrap: [Wrap::Repeat; 2],
                nearest: false,
            })),
            Err(Fault::TooLarge { limit_mib }) => return Err(Fault::TooLarge { limit_mib }),
            Err(fault) => {
                scene.warnings.push(format!("a texture is left out: {}", fault.at(source.path)));
                None
            }
        };
        self.decoded.insert(name.to_owned(), picture.clone());
        Ok(picture)
    }
}

fn push(scene: &mut Scene, map: HeightMap) -> HeightMapId {
    scene.height_maps.push(Arc::new(map));
    HeightMapId(scene.height_maps.len() - 1)
}

/// Colours of one picture, white without one, and holes of another, as large as the larger of both.
fn composed(
    colors: Option<&Texture>,
    holes: Option<(&Texture, Option<char>)>,
    wrap: Wrap,
    budget: &mut Budget,
) -> Result<Texture, Fault> {
    let both = || colors.into_iter().chain(holes.map(|(picture, _)| picture));
    let [width, height] = both()
        .fold([1, 1], |[width, height], picture| [width.max(picture.width), height.max(picture.height)]);
    budget.take(width as usize * height as usize, size_of::<[u8; 4]>())?;
    let texel = |picture: &Texture, x: u32, y: u32| {
        let scaled =
            |at: u32, size: u32, all: u32| (u64::from(at) * u64::from(size) / u64::from(all)) as usize;
        let (x, y) = (scaled(x, picture.width, width), scaled(y, picture.height, height));
        picture.rgba8[y * picture.width as usize + x]
    };
    // Where nobody says: alpha where the picture has any, else brightness.
    let has_alpha = holes.is_some_and(|(picture, _)| picture.rgba8.iter().any(|texel| texel[3] < 255));
    let opacity = |[r, g, b, a]: [u8; 4], channel: Option<char>| match channel {
        Some('r') => r,
        Some('g') => g,
        Some('b') => b,
        Some('m') => a,
        None if has_alpha => a,
        _ => ((2 * u32::from(r) + 5 * u32::from(g) + u32::from(b)) / 8) as u8,
    };
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let rgba8 = texels.map(|(x, y)| {
        let [r, g, b, a] = colors.map_or([255; 4], |picture| texel(picture, x, y));
        [r, g, b, holes.map_or(a, |(picture, channel)| opacity(texel(picture, x, y), channel))]
    });
    Ok(Texture { width, height, rgba8: rgba8.collect(), wrap: [wrap; 2], nearest: false })
}
