//! Textures and their pictures (specification, section 3.8). A picture that cannot be had is left out with a warning: the model is whole
//! without it.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine2, Vec2};
use gnomon_picture::tonemap::srgb_decode;
use gnomon_scene::{Height, HeightMapId, Scene, Texture, TextureId, TextureRef, Wrap};

use super::buffers::Buffers;
use super::materials::CoordinateSets;
use super::schema::{HeightEntry, Int, Root, TextureEntry, TextureInfo};
use super::{Budget, Fault, Source, get, uri};
use crate::texture::{self, Texels};
use crate::{SceneFileError, heights};

/// The textures of a file, each read when a material first uses it.
pub struct Textures<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    source: &'a Source<'a>,
    /// By texture; `None` for one that is left out.
    read: HashMap<usize, Option<TextureId>>,
    /// By picture and sampling.
    known: HashMap<(usize, [Wrap; 2], bool), TextureId>,
    /// Made of a texture and factors, as bits.
    converted: HashMap<(TextureId, [u32; 4]), TextureId>,
}

impl<'a> Textures<'a> {
    pub fn new(root: &'a Root, buffers: &'a Buffers<'a>, source: &'a Source<'a>) -> Self {
        let (read, known, converted) = Default::default();
        Self { root, buffers, source, read, known, converted }
    }

    /// A texture as a material uses it; `sets` tells which coordinates its meshes have.
    pub fn reference(
        &mut self,
        info: Option<&TextureInfo>,
        (sets, referrer): (CoordinateSets, &str),
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<TextureRef>, Fault> {
        let Some(info) = info else { return Ok(None) };
        let Some(texture) = self.texture(info.index.0, referrer, budget, scene)? else { return Ok(None) };
        let placed = placement(info, (sets, referrer), scene);
        Ok(placed.map(|(uv_from_mesh, set)| TextureRef { texture, uv_from_mesh, set }))
    }

    /// Heights as a material uses them.
    pub fn height(
        &mut self,
        entry: &HeightEntry,
        (sets, referrer): (CoordinateSets, &str),
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<Height>, Fault> {
        let texture = get(&self.root.textures, entry.texture.index.0, "texture", referrer)?;
        let (wrap, _) = self.sampling(texture, referrer)?;
        let Some(Int(image)) = texture.source else {
            scene.warnings.push(format!("{referrer}: heights are left out: their texture has no picture"));
            return Ok(None);
        };
        get(&self.root.images, image, "image", referrer)?;
        let mut told = Vec::new();
        let map =
            self.image(image, budget, |bytes, budget| heights::decode(bytes, wrap, budget, |w| told.push(w)));
        scene.warnings.extend(told.into_iter().map(|warning| format!("{referrer}: {warning}")));
        let map = match map {
            Ok(map) => map,
            Err(reason) => {
                scene.warnings.push(format!("{referrer}: heights are left out: {reason}"));
                return Ok(None);
            }
        };
        let placed = placement(&entry.texture, (sets, referrer), scene);
        scene.height_maps.push(Arc::new(map));
        let map = HeightMapId(scene.height_maps.len() - 1);
        Ok(placed.map(|(uv_from_mesh, set)| Height { map, uv_from_mesh, set, scale: entry.scale }))
    }

    fn texture(
        &mut self,
        index: usize,
        referrer: &str,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<TextureId>, Fault> {
        if let Some(known) = self.read.get(&index) {
            return Ok(*known);
        }
        let texture = get(&self.root.textures, index, "texture", referrer)?;
        let name = format!("texture {index}");
        let (wrap, nearest) = self.sampling(texture, &name)?;
        let webp = texture.extensions.webp.as_ref().and_then(|webp| webp.source);
        let mut found = None;
        let mut reasons = Vec::new();
        // The plain picture is what every program shows; a WebP stands in where there is none.
        let pictures = [texture.source.map(|image| (image, false)), webp.map(|image| (image, true))];
        for (Int(image), may_be_webp) in pictures.into_iter().flatten() {
            get(&self.root.images, image, "image", &name)?;
            if let Some(&known) = self.known.get(&(image, wrap, nearest)) {
                found = Some(known);
                break;
            }
            match self.picture(image, may_be_webp, budget) {
                Ok(Texels { width, height, rgba8 }) => {
                    let id = push(scene, Texture { width, height, rgba8, wrap, nearest });
                    self.known.insert((image, wrap, nearest), id);
                    found = Some(id);
                    break;
                }
                Err(reason) => reasons.push(reason),
            }
        }
        if found.is_none() && reasons.is_empty() {
            reasons.push(match texture.extensions.basisu {
                Some(_) => {
                    "its picture is KTX2, which `gltf-transform ktxdecompress` makes a PNG of".to_owned()
                }
                None => "it has no PNG or JPEG picture".to_owned(),
            });
        }
        if found.is_none() {
            scene.warnings.push(format!("{name} is left out: {}", reasons.join("; ")));
        }
        self.read.insert(index, found);
        Ok(found)
    }

    /// How a texture is addressed, and whether it is not filtered.
    fn sampling(&self, texture: &TextureEntry, name: &str) -> Result<([Wrap; 2], bool), Fault> {
        let Some(Int(sampler)) = texture.sampler else { return Ok(([Wrap::Repeat; 2], false)) };
        let sampler = get(&self.root.samplers, sampler, "sampler", name)?;
        let wrap = [wrap_mode(sampler.wrap_s), wrap_mode(sampler.wrap_t)];
        Ok((wrap, sampler.mag_filter == Some(Int(9728))))
    }

    /// A picture, or why there is none.
    fn picture(&self, index: usize, may_be_webp: bool, budget: &mut Budget) -> Result<Texels, String> {
        self.image(index, budget, |bytes, budget| {
            if texture::is_webp(bytes) && !may_be_webp {
                return Err(Fault::invalid("it is a WebP, which only EXT_texture_webp may name"));
            }
            texture::decode(bytes, budget)
        })
    }

    /// What `decode` makes of a picture's bytes, or why there is nothing.
    fn image<T>(
        &self,
        index: usize,
        budget: &mut Budget,
        decode: impl FnOnce(&[u8], &mut Budget) -> Result<T, Fault>,
    ) -> Result<T, String> {
        let image = &self.root.images[index];
        let name = format!("image {index}");
        let said = |fault: Fault| match fault {
            Fault::Invalid(message) | Fault::Unsupported(message) => format!("{name}: {message}"),
            Fault::TooLarge { .. } | Fault::Elsewhere(SceneFileError::TooLarge { .. }) => {
                format!("{name} takes more memory than is left")
            }
            Fault::Elsewhere(error) => error.to_string(),
        };
        let owned;
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), None) => {
                owned = uri::resolve(uri, self.source, budget).map_err(said)?;
                owned.as_slice()
            }
            (None, Some(view)) => self.buffers.view(view.0, &name).map_err(said)?,
            _ => return Err(format!("{name} has neither a URI nor a buffer view, or both")),
        };
        decode(bytes, budget).map_err(said)
    }

    /// Of a texture with reflectance in RGB (sRGB) and glossiness in A, each with its factor, one with roughness in G and the strength of the
    /// reflection in A, as [`super::specular_glossiness`] has them.
    pub fn roughness_and_strength(
        &mut self,
        texture: TextureId,
        (factor, glossiness): ([f32; 3], f32),
        strength: impl Fn([f32; 3]) -> f32,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<TextureId, Fault> {
        let [r, g, b] = factor;
        let key = (texture, [r, g, b, glossiness].map(f32::to_bits));
        if let Some(&known) = self.converted.get(&key) {
            return Ok(known);
        }
        let original = &scene.textures[texture.0];
        budget.take(original.rgba8.len(), 4)?;
        let linear: [f32; 256] = std::array::from_fn(|code| srgb_decode(code as f32 / 255.0));
        // A cast rounds towards zero and clips.
        let code = |value: f32| (255.0 * value + 0.5) as u8;
        let rgba8 = original.rgba8.iter().map(|&[red, green, blue, gloss]| {
            let color = [r * linear[red as usize], g * linear[green as usize], b * linear[blue as usize]];
            [255, code(1.0 - glossiness * f32::from(gloss) / 255.0), 255, code(strength(color))]
        });
        let (width, height, wrap, nearest) =
            (original.width, original.height, original.wrap, original.nearest);
        let made = Texture { width, height, rgba8: rgba8.collect(), wrap, nearest };
        let id = push(scene, made);
        self.converted.insert(key, id);
        Ok(id)
    }
}

/// How a texture lies on a mesh: its transform and which of the mesh's coordinates it takes. `None` with a warning for others than those.
fn placement(
    info: &TextureInfo,
    (sets, referrer): (CoordinateSets, &str),
    scene: &mut Scene,
) -> Option<(Affine2, usize)> {
    let Some(set) = sets.iter().position(|set| *set == info.set()) else {
        let set = info.set();
        scene.warnings.push(format!(
            "{referrer}: a texture on coordinate set {set} is left out: a material has two sets at most"
        ));
        return None;
    };
    let mut uv_from_mesh = Affine2::IDENTITY;
    if let Some(transform) = &info.extensions.transform {
        let scale = transform.scale.map_or(Vec2::ONE, Vec2::from_array);
        // Counter-clockwise as the picture is seen, with v pointing down: the negative angle in (u, v).
        let affine = Affine2::from_scale_angle_translation(
            scale,
            -transform.rotation,
            Vec2::from_array(transform.offset),
        );
        if affine.is_finite() {
            uv_from_mesh = affine;
        } else {
            scene.warnings.push(format!("{referrer}: a texture transform that is not finite is ignored"));
        }
    }
    Some((uv_from_mesh, set))
}

fn push(scene: &mut Scene, texture: Texture) -> TextureId {
    scene.textures.push(Arc::new(texture));
    TextureId(scene.textures.len() - 1)
}

fn wrap_mode(code: Option<Int>) -> Wrap {
    match code {
        Some(Int(33_071)) => Wrap::ClampToEdge,
        Some(Int(33_648)) => Wrap::MirroredRepeat,
        // 10497, or nothing.
        _ => Wrap::Repeat,
    }
}
