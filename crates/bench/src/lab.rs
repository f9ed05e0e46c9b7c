use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

use gnomon_image::RgbImage;
use gnomon_lights::{FitOptions, LightSet, fit};
use gnomon_reference::{Estimate, ReferenceOptions, ResidualShadows};
use gnomon_renderer::Gpu;

use crate::pictures::{channel_mean, shrunk_to};
use crate::{BenchError, DataFolder, Environment, Setup, Stage};

/// How much work there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Seconds: shows that everything works, measures nothing of use.
    Smoke,
    /// Minutes on two cores without a GPU: small pictures, few rows.
    Quick,
    /// Everything.
    Full,
}

impl Effort {
    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Smoke => "smoke",
            Self::Quick => "quick",
            Self::Full => "full",
        }
    }
}

/// What a [`Lab`] is told.
#[derive(Clone, Debug)]
pub struct LabOptions {
    /// How much work there is.
    pub effort: Effort,
    /// Scenes and environments.
    pub data: DataFolder,
    /// Folder with truth pictures by another renderer, `SCENE_ENVIRONMENT.exr`.
    pub truth: Option<PathBuf>,
}

/// Told what is being done, and which share of the experiment is.
pub type Progress<'a> = &'a (dyn Fn(&str, f32) + Sync);

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

/// Where experiments are made: an adapter, data, and what they share. Scenes, environments, fits and truth pictures are made once.
pub struct Lab<'a> {
    gpu: &'a Gpu,
    options: LabOptions,
    progress: Progress<'a>,
    environments: Cache<Environment>,
    stages: Cache<Stage>,
    fits: Cache<LightSet>,
    truths: Cache<Truth>,
}

type Cache<T> = RefCell<HashMap<String, Rc<T>>>;

fn cached<T>(
    cache: &Cache<T>,
    key: String,
    make: impl FnOnce() -> Result<T, BenchError>,
) -> Result<Rc<T>, BenchError> {
    if let Some(found) = cache.borrow().get(&key) {
        return Ok(Rc::clone(found));
    }
    let made = Rc::new(make()?);
    cache.borrow_mut().insert(key, Rc::clone(&made));
    Ok(made)
}

impl<'a> Lab<'a> {
    /// A lab on an adapter.
    ///
    /// # Errors
    /// [`BenchError::Request`] for a data or truth folder that is not there.
    pub fn new(gpu: &'a Gpu, options: LabOptions, progress: Progress<'a>) -> Result<Self, BenchError> {
        for (what, folder) in [("data", &options.data.0), ("truth", &options.truth)] {
            if let Some(folder) = folder.as_ref().filter(|folder| !folder.is_dir()) {
                return Err(BenchError::Request(format!("there is no {what} folder {}", folder.display())));
            }
        }
        Ok(Self {
            gpu,
            options,
            progress,
            environments: Cache::default(),
            stages: Cache::default(),
            fits: Cache::default(),
            truths: Cache::default(),
        })
    }

    /// The adapter.
    pub fn gpu(&self) -> &'a Gpu {
        self.gpu
    }

    /// How much work there is.
    pub fn effort(&self) -> Effort {
        self.options.effort
    }

    /// The value for the effort at hand.
    pub fn pick<T>(&self, smoke: T, quick: T, full: T) -> T {
        match self.options.effort {
            Effort::Smoke => smoke,
            Effort::Quick => quick,
            Effort::Full => full,
        }
    }

    /// Tells what is being done, and which share (0..1) of the experiment is.
    pub fn tell(&self, what: &str, share: f32) {
        (self.progress)(what, share);
    }

    /// An environment by its name.
    ///
    /// # Errors
    /// As [`DataFolder::environment`].
    pub fn environment(&self, name: &str) -> Result<Rc<Environment>, BenchError> {
        cached(&self.environments, name.to_owned(), || self.options.data.environment(name))
    }

    /// The environments of these names; of several for which the same built-in stands in, the first.
    ///
    /// # Errors
    /// As [`DataFolder::environment`].
    pub fn environments(&self, names: &[&str]) -> Result<Vec<Rc<Environment>>, BenchError> {
        let mut found: Vec<Rc<Environment>> = Vec::new();
        for name in names {
            let environment = self.environment(name)?;
            let twin = |other: &Rc<Environment>| {
                environment.stand_in.is_some() && other.stand_in == environment.stand_in
            };
            if !found.iter().any(twin) {
                found.push(environment);
            }
        }
        Ok(found)
    }

    /// A scene by its name.
    ///
    /// # Errors
    /// As [`DataFolder::stage`].
    pub fn stage(&self, name: &str) -> Result<Rc<Stage>, BenchError> {
        cached(&self.stages, name.to_owned(), || self.options.data.stage(name))
    }

    /// The scenes of these names; of several for which the same built-in stands in, the first.
    ///
    /// # Errors
    /// As [`DataFolder::stage`].
    pub fn stages(&self, names: &[&str]) -> Result<Vec<Rc<Stage>>, BenchError> {
        let mut found: Vec<Rc<Stage>> = Vec::new();
        for name in names {
            let stage = self.stage(name)?;
            if !found.iter().any(|other| stage.stand_in.is_some() && other.stand_in == stage.stand_in) {
                found.push(stage);
            }
        }
        Ok(found)
    }

    /// The lights that a fit makes of an environment when asked for `count`, of which it may make fewer, or its own choice.
    ///
    /// # Errors
    /// An unknown fit, or one that refuses the count or the map.
    pub fn lights(
        &self,
        method: &str,
        count: Option<usize>,
        environment: &Environment,
    ) -> Result<Rc<LightSet>, BenchError> {
        cached(&self.fits, format!("{method} {count:?} {}", environment.name), || {
            let options = FitOptions { light_count: count, ..FitOptions::default() };
            Ok(fit::by_name(method, &options)?.fit(&environment.map)?)
        })
    }

    /// A scene under an environment as an independent renderer made it, where there is such a picture of this size or a whole
    /// multiple of it; else as the project's own tracer makes it with `samples` a pixel.
    ///
    /// # Errors
    /// A picture that cannot be read, a scene that cannot be traced.
    pub fn truth(
        &self,
        stage: &Stage,
        environment: &Environment,
        [width, height]: [u32; 2],
        samples: u32,
    ) -> Result<Rc<Truth>, BenchError> {
        let key = format!("{} {} {width}x{height} {samples}", stage.name, environment.name);
        cached(&self.truths, key, || {
            let real = stage.stand_in.is_none() && environment.stand_in.is_none();
            let folder = self.options.truth.as_deref();
            let file = self.options.data.truth(folder, stage.name, environment.name).filter(|_| real);
            if let Some(file) = file {
                let picture = gnomon_image::read(&file)?.image;
                if let Some(picture) = shrunk_to(&picture, width, height) {
                    return Ok(Truth { picture, source: "Mitsuba".to_owned(), noise: None });
                }
            }
            let options =
                ReferenceOptions { width, height, samples_per_pixel: samples, ..Default::default() };
            let estimate = gnomon_reference::render(&stage.scene, &stage.camera, &environment.map, &options)?;
            Ok(traced(estimate))
        })
    }

    /// What the lights of a setup make of its scene, traced with exact shadows of lights and residual.
    ///
    /// # Errors
    /// A scene that cannot be traced.
    pub fn truth_of_lights(&self, setup: &Setup<'_>, samples: u32) -> Result<Truth, BenchError> {
        let [width, height] = setup.size;
        let options = ReferenceOptions { width, height, samples_per_pixel: samples, ..Default::default() };
        let estimate = gnomon_reference::render_lights(
            &setup.stage.scene,
            &setup.stage.camera,
            setup.lights,
            ResidualShadows::Cast,
            setup.map,
            &options,
        )?;
        Ok(traced(estimate))
    }
}

fn traced(estimate: Estimate) -> Truth {
    let mean = channel_mean(&estimate.mean);
    let noise = channel_mean(&estimate.variance).max(0.0).sqrt() / mean;
    Truth {
        picture: estimate.mean,
        source: format!("own tracer, {} samples", estimate.samples_per_pixel),
        noise: noise.is_finite().then_some(noise),
    }
}
