//! Textures and their pictures (specification, section 3.8). A picture that cannot be had is left out with a warning: the model is whole
//! without it.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine2, Vec2};
use gnomon_picture::tonemap::srgb_decode;
use gnomon_scene::{Scene, Texture, TextureId, TextureRef, Wrap};

use super::buffers::Buffers;
use super::materials::CoordinateSets;
use super::schema::{Int, Root, TextureInfo};
use super::{Budget, Fault, Source, get, uri};
use crate::SceneFileError;
use crate::texture::{self, Texels};

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
        let Some(set) = sets.iter().position(|set| *set == info.set()) else {
            let set = info.set();
            scene.warnings.push(format!(
                "{referrer}: a texture on coordinate set {set} is left out: a material has two sets at most"
            ));
            return Ok(None);
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
        Ok(Some(TextureRef { texture, uv_from_mesh, set }))
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
        let (mut wrap, mut nearest) = ([Wrap::Repeat; 2], false);
        if let Some(Int(sampler)) = texture.sampler {
            let sampler = get(&self.root.samplers, sampler, "sampler", &name)?;
            wrap = [wrap_mode(sampler.wrap_s), wrap_mode(sampler.wrap_t)];
            nearest = sampler.mag_filter == Some(Int(9728));
        }
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

    /// A picture, or why there is none.
    fn picture(&self, index: usize, may_be_webp: bool, budget: &mut Budget) -> Result<Texels, String> {
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
        if texture::is_webp(bytes) && !may_be_webp {
            return Err(format!("{name} is a WebP, which only EXT_texture_webp may name"));
        }
        texture::decode(bytes, budget).map_err(said)
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
