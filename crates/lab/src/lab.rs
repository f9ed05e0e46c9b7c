use std::any::Any;
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

use gnomon_lights::{FitOptions, LightSet, fit};
use gnomon_renderer::Gpu;

use crate::timing::TimingPlan;
use crate::truth::Truth;
use crate::{DataFolder, Environment, LabError, View};

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
    /// Folder where traced truth pictures are kept, and looked for before they are traced again; made if missing.
    pub kept_truth: Option<PathBuf>,
}

/// Told what is being done, and which share of the experiment is.
pub type Progress<'a> = &'a (dyn Fn(&str, f32) + Sync);

/// Where experiments are made: an adapter, data, and what they share. Scenes, environments, fits and truth pictures are made once.
pub struct Lab<'a> {
    gpu: &'a Gpu,
    pub(crate) options: LabOptions,
    progress: Progress<'a>,
    environments: Cache<Environment>,
    views: Cache<View>,
    fits: Cache<LightSet>,
    pub(crate) truths: Cache<Truth>,
    figures: RefCell<HashMap<String, Rc<dyn Any>>>,
}

pub(crate) type Cache<T> = RefCell<HashMap<String, Rc<T>>>;

/// What the cache has for `key`, made first where it has nothing.
pub(crate) fn cached<T>(
    cache: &Cache<T>,
    key: String,
    make: impl FnOnce() -> Result<T, LabError>,
) -> Result<Rc<T>, LabError> {
    if let Some(found) = cache.borrow().get(&key) {
        return Ok(Rc::clone(found));
    }
    let made = Rc::new(make()?);
    cache.borrow_mut().insert(key, Rc::clone(&made));
    Ok(made)
}

/// What the names stand for, in order; of several with the same stand-in, the first.
fn without_twins<T>(
    names: &[&str],
    named: impl Fn(&str) -> Result<Rc<T>, LabError>,
    stand_in: impl Fn(&T) -> Option<&'static str>,
) -> Result<Vec<Rc<T>>, LabError> {
    let mut found: Vec<Rc<T>> = Vec::new();
    for name in names {
        let new = named(name)?;
        if stand_in(&new).is_none() || found.iter().all(|other| stand_in(other) != stand_in(&new)) {
            found.push(new);
        }
    }
    Ok(found)
}

impl<'a> Lab<'a> {
    /// A lab on an adapter.
    ///
    /// # Errors
    /// [`LabError::Request`] for a data or truth folder that is not there.
    pub fn new(gpu: &'a Gpu, options: LabOptions, progress: Progress<'a>) -> Result<Self, LabError> {
        for (what, folder) in [("data", &options.data.0), ("truth", &options.truth)] {
            if let Some(folder) = folder.as_ref().filter(|folder| !folder.is_dir()) {
                return Err(LabError::Request(format!("there is no {what} folder {}", folder.display())));
            }
        }
        Ok(Self {
            gpu,
            options,
            progress,
            environments: Cache::default(),
            views: Cache::default(),
            fits: Cache::default(),
            truths: Cache::default(),
            figures: RefCell::default(),
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

    /// How long rivals are timed; `seconds` is for the full effort.
    pub fn timing_plan(&self, seconds: f64) -> TimingPlan {
        TimingPlan {
            rounds: self.pick(1, 7, 15),
            seconds: self.pick(0.0, 0.3 * seconds, seconds),
            least_rounds: self.pick(1, 2, 5),
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
    pub fn environment(&self, name: &str) -> Result<Rc<Environment>, LabError> {
        cached(&self.environments, name.to_owned(), || self.options.data.environment(name))
    }

    /// The environments of these names; of several for which the same built-in stands in, the first.
    ///
    /// # Errors
    /// As [`DataFolder::environment`].
    pub fn environments(&self, names: &[&str]) -> Result<Vec<Rc<Environment>>, LabError> {
        without_twins(names, |name| self.environment(name), |environment| environment.stand_in)
    }

    /// A scene by its name.
    ///
    /// # Errors
    /// As [`DataFolder::view`].
    pub fn view(&self, name: &str) -> Result<Rc<View>, LabError> {
        cached(&self.views, name.to_owned(), || self.options.data.view(name))
    }

    /// The scenes of these names; of several for which the same built-in stands in, the first.
    ///
    /// # Errors
    /// As [`DataFolder::view`].
    pub fn views(&self, names: &[&str]) -> Result<Vec<Rc<View>>, LabError> {
        without_twins(names, |name| self.view(name), |view| view.stand_in)
    }

    /// The lights that a fit (`FIT` or `samples:SAMPLER`) makes of an environment for a scene when asked for `count`, of which it may
    /// make fewer, or its own choice.
    ///
    /// # Errors
    /// An unknown fit, or one that refuses the count or the map.
    pub fn lights(
        &self,
        method: &str,
        count: Option<usize>,
        view: &View,
        environment: &Environment,
    ) -> Result<Rc<LightSet>, LabError> {
        let ground = view.stands_on_ground;
        cached(&self.fits, format!("{method} {count:?} {ground} {}", environment.name), || {
            let (method, sampler) = match method.split_once(':') {
                Some((method, sampler)) => (method, Some(fit::sampler_by_name(sampler)?)),
                None => (method, None),
            };
            let options = FitOptions { light_count: count, sampler, ground, ..FitOptions::default() };
            Ok(fit::by_name(method, &options)?.fit(&environment.map)?)
        })
    }

    /// What `make` gives, made once in a lab: figures that several experiments read.
    pub(crate) fn once<T: Any>(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<T, LabError>,
    ) -> Result<Rc<T>, LabError> {
        let known = self.figures.borrow().get(key).cloned();
        if let Some(found) = known.and_then(|known| known.downcast().ok()) {
            return Ok(found);
        }
        let made = Rc::new(make()?);
        self.figures.borrow_mut().insert(key.to_owned(), Rc::clone(&made) as Rc<dyn Any>);
        Ok(made)
    }
}
