//! The reference in a worker of its own.

use gnomon_picture::RgbImage;
use gnomon_picture::ldr::srgb8;
use gnomon_picture::tonemap::tone_mapped;
use gnomon_studio::{Converging, Executor, Look, Project, Slices, Stage};
use wasm_bindgen::prelude::*;

use crate::error::PageError;
use crate::session::FileSet;

/// A reference picture that converges pass by pass. It needs no device.
#[wasm_bindgen]
pub struct Tracer {
    stage: Stage,
    passes: Slices,
    converging: Option<Converging>,
    size: [u32; 2],
    /// The GPU's picture.
    drawn: Option<RgbImage>,
}

#[wasm_bindgen]
impl Tracer {
    /// Reads the scene at `path` among `files`, seen with the look that a session tells.
    pub fn open(files: FileSet, path: &str, look: &str) -> Result<Tracer, PageError> {
        let look: Look = serde_json::from_str(look)?;
        let source = files.into_files().source(path);
        let mut project = Project::open_source(source, look.clone(), &Default::default())?;
        (project.look.map, project.look.environment) = (look.map.clone(), look.environment.clone());
        let mut stage = Stage::new(project)?;
        stage.set_look(look)?;
        Ok(Self { stage, passes: Slices::default(), converging: None, size: [0, 0], drawn: None })
    }

    /// Takes the look of now over, and the GPU's picture with it: linear radiance, three numbers a pixel, top row first.
    pub fn compare(
        &mut self,
        look: &str,
        width: u32,
        height: u32,
        radiance: &[f32],
    ) -> Result<(), PageError> {
        self.stage.set_look(serde_json::from_str(look)?)?;
        self.size = [width, height];
        let texels = radiance.chunks_exact(3).map(glam::Vec3::from_slice).collect();
        self.drawn = RgbImage::from_texels(width, height, texels);
        Ok(())
    }

    /// Adds a pass.
    pub fn pass(&mut self) -> Result<(), PageError> {
        let [width, height] = self.size;
        let before = self.converging.take();
        self.converging = Some(Converging::follow(before, &self.stage, [width, height], &self.passes)?);
        self.passes.run_slices();
        Ok(())
    }

    /// Samples a pixel, relative root mean square error of the GPU's picture, and the reference's own noise in it; nothing before the
    /// first pass.
    pub fn error(&self) -> Result<Option<Vec<f64>>, PageError> {
        let reference = self.converging.as_ref().map_or(Ok(None), Converging::picture)?;
        let (Some(reference), Some(drawn)) = (reference, &self.drawn) else { return Ok(None) };
        let error = reference.relative_rmse(drawn)?;
        Ok(Some(vec![reference.samples_per_pixel.into(), error, reference.noise]))
    }

    /// The reference as it is displayed with the session's exposure, or its difference to the GPU's picture: RGBA, 8 bits a channel.
    pub fn picture(&self, difference: bool) -> Result<Option<Vec<u8>>, PageError> {
        let reference = self.converging.as_ref().map_or(Ok(None), Converging::picture)?;
        let (Some(reference), Some(drawn)) = (reference, &self.drawn) else { return Ok(None) };
        let shown = match difference {
            true => reference.difference(drawn)?,
            false => {
                let rule = self.stage.look().display.tone_mapping;
                tone_mapped(&reference.mean, rule, self.stage.exposure())
            }
        };
        Ok(Some(rgba(&shown)))
    }
}

/// Display-linear values as a page's canvas takes them.
pub fn rgba(picture: &RgbImage) -> Vec<u8> {
    srgb8(picture).chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect()
}
