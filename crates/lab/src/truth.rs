//! Pictures to measure others by: those of an independent renderer where there are any, else ray traced here and kept.

use std::fmt::{Debug, Write as _};
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use gnomon_envmap::Equirect;
use gnomon_picture::{ImageError, RgbImage, atomic};
use gnomon_reference::{Estimate, ReferenceOptions, ResidualShadows};

use crate::lab::cached;
use crate::pictures::{channel_mean, shrunk_to};
use crate::report::significant;
use crate::{Environment, Lab, LabError, Setup, View};

/// A picture to measure others by.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Linear radiance.
    pub picture: RgbImage,
    /// Who made it, for tables.
    pub source: String,
    /// Standard error of its pixels over its mean, where it is known: no picture can be measured to be nearer.
    pub noise: Option<f64>,
}

impl Truth {
    /// Source and noise in words.
    pub fn described(&self) -> String {
        match self.noise {
            Some(noise) => format!("{}, noise {} of its mean", self.source, significant(noise, 2)),
            None => self.source.clone(),
        }
    }

    fn traced(picture: RgbImage, samples: u32, noise: f64) -> Self {
        let source = format!("own tracer, {samples} samples");
        Self { picture, source, noise: noise.is_finite().then_some(noise) }
    }
}

impl From<Estimate> for Truth {
    fn from(estimate: Estimate) -> Self {
        let mean = channel_mean(&estimate.mean);
        let noise = channel_mean(&estimate.variance).max(0.0).sqrt() / mean;
        Self::traced(estimate.mean, estimate.samples_per_pixel, noise)
    }
}

impl Lab<'_> {
    /// A scene under an environment as an independent renderer made it, where there is such a picture of this size or a whole
    /// multiple of it; else as the project's own tracer makes it with `samples` a pixel, now or in an earlier run.
    ///
    /// # Errors
    /// A picture that cannot be read or kept, a scene that cannot be traced.
    pub fn truth(
        &self,
        view: &View,
        environment: &Environment,
        [width, height]: [u32; 2],
        samples: u32,
    ) -> Result<Rc<Truth>, LabError> {
        let name = format!("{}_{}_{width}x{height}_{samples}", view.name, environment.name);
        cached(&self.truths, name.clone(), || {
            let real = view.stand_in.is_none() && environment.stand_in.is_none();
            let folder = self.options.truth.as_deref();
            let file = self.options.data.truth(folder, view.name, environment.name).filter(|_| real);
            if let Some(file) = file {
                let picture = gnomon_picture::read(&file)?.image;
                if let Some(picture) = shrunk_to(&picture, width, height) {
                    return Ok(Truth { picture, source: "Mitsuba".to_owned(), noise: None });
                }
            }
            let kept = self
                .options
                .kept_truth
                .as_deref()
                .map(|folder| Kept::new(folder, &name, view, &environment.map));
            if let Some(truth) = kept.as_ref().and_then(|kept| kept.read([width, height], samples)) {
                return Ok(truth);
            }
            let options =
                ReferenceOptions { width, height, samples_per_pixel: samples, ..Default::default() };
            let truth =
                gnomon_reference::render(&view.scene, &view.camera, &environment.map, &options)?.into();
            if let Some(kept) = kept {
                kept.write(&truth)?;
            }
            Ok(truth)
        })
    }

    /// What the lights of a setup make of its scene, traced with exact shadows of lights and residual.
    ///
    /// # Errors
    /// A scene that cannot be traced.
    pub fn truth_of_lights(&self, setup: &Setup<'_>, samples: u32) -> Result<Truth, LabError> {
        let [width, height] = setup.size;
        let options = ReferenceOptions { width, height, samples_per_pixel: samples, ..Default::default() };
        let estimate = gnomon_reference::render_lights(
            &setup.view.scene,
            &setup.view.camera,
            setup.lights,
            ResidualShadows::Cast,
            setup.map,
            &options,
        )?;
        Ok(estimate.into())
    }
}

/// The two files of a traced picture: radiance, and its noise as a line of text.
struct Kept {
    picture: PathBuf,
    noise: PathBuf,
}

impl Kept {
    /// The names hold a hash of all that was traced, so that a scene that changed is traced again.
    fn new(folder: &Path, name: &str, view: &View, map: &Equirect) -> Self {
        let stem = format!("{name}_{:016x}", fingerprint(view, map));
        Self { picture: folder.join(format!("{stem}.exr")), noise: folder.join(format!("{stem}.txt")) }
    }

    /// What an earlier run kept, if both files are whole.
    fn read(&self, [width, height]: [u32; 2], samples: u32) -> Option<Truth> {
        let noise = std::fs::read_to_string(&self.noise).ok()?.trim().parse().ok()?;
        let picture = gnomon_picture::read(&self.picture).ok()?.image;
        ((picture.width(), picture.height()) == (width, height))
            .then(|| Truth::traced(picture, samples, noise))
    }

    fn write(&self, truth: &Truth) -> Result<(), LabError> {
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| ImageError::Write { path, source }
        };
        if let Some(folder) = self.picture.parent() {
            std::fs::create_dir_all(folder).map_err(failed(folder))?;
        }
        gnomon_picture::write(&self.picture, &truth.picture)?;
        let noise = truth.noise.unwrap_or(f64::NAN);
        atomic::write(&self.noise, |file| writeln!(file, "{noise}")).map_err(failed(&self.noise))?;
        Ok(())
    }
}

/// A hash of scene, view and environment, the same in every run of one build.
fn fingerprint(view: &View, map: &Equirect) -> u64 {
    let mut hashed = Hashed(DefaultHasher::new());
    hashed.debug(&view.scene);
    hashed.debug(&view.camera);
    hashed.debug(&(map.width(), map.height()));
    for texel in map.radiance().texels() {
        texel.to_array().iter().for_each(|value| hashed.0.write_u32(value.to_bits()));
    }
    hashed.0.finish()
}

/// Text that is hashed instead of kept.
struct Hashed(DefaultHasher);

impl Hashed {
    fn debug(&mut self, value: &dyn Debug) {
        // Writing to a hash cannot fail.
        let _ = write!(self, "{value:?}");
    }
}

impl std::fmt::Write for Hashed {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.write(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::DataFolder;

    #[test]
    fn kept_pictures_are_found_again_and_changed_scenes_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let deep = folder.path().join("deep");
        let data = DataFolder(None);
        let mut view = data.view("three_boxes").unwrap();
        let map = data.environment("grace").unwrap().map;
        let kept = Kept::new(&deep, "x", &view, &map);
        assert!(kept.read([2, 1], 4).is_none());
        let picture = RgbImage::filled(2, 1, Vec3::splat(0.25));
        kept.write(&Truth::traced(picture.clone(), 4, 0.01)).unwrap();
        let found = Kept::new(&deep, "x", &view, &map).read([2, 1], 4).unwrap();
        assert_eq!((found.picture, found.noise), (picture, Some(0.01)));
        assert_eq!(found.source, "own tracer, 4 samples");
        assert!(kept.read([1, 2], 4).is_none(), "another size");

        std::sync::Arc::make_mut(&mut view.scene.meshes[0]).positions[0].x += 1e-3;
        assert!(Kept::new(&deep, "x", &view, &map).read([2, 1], 4).is_none());
        std::fs::write(&kept.picture, b"damaged").unwrap();
        assert!(kept.read([2, 1], 4).is_none());
    }
}
