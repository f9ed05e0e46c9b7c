//! Fits as people choose them.

use gnomon_options::{Choice, Group, Options, between, choice, number, settings, whole};

use super::{FitError, FitOptions, LightFit, MAX_LIGHTS, by_name, methods, sampler_by_name, samplers};

static GROUP: Group = Group { table: "", heading: "Lights", condition: None };

settings! {
    /// Which lights stand for an environment. By default a fit that leaves no light unshadowed, so that the picture's error stays small
    /// under every environment measured, and the one that does it with the fewest lights.
    pub struct FitSettings in GROUP {
        /// How lights are fitted to the environment.
        method: String = "optimized".to_owned(), choice(method_choices).flag("lights").alias("method");
        /// Number of lights. A fit that covers the whole sphere needs some, and says how many.
        light_count: Option<usize> = None,
            whole(1, MAX_LIGHTS as i64).automatic("the fit's own choice", 64.0).excludes("threshold");
        /// Where the fit stops: disks at a light below this share of those before it (smaller makes more lights), squares and rectangles
        /// grow while a side adds more than this share (larger makes more).
        threshold: Option<f32> = None, between(0.0, 1.0).automatic("the fit's own choice", 0.05).excludes("light_count");
        /// Largest angular width and height of a light. A fit may allow less of the range, and says what.
        max_extent: Option<f32> = None, number(0.0, 360.0).unit("degrees").automatic("the fit's own choice", 30.0);
        /// Where samples are placed.
        sampler: Option<String> = None, choice(sampler_choices).automatic("median-cut", 0.0).only_for("lights", &["samples"]);
        /// Seed of random samplers: the same seed gives the same lights.
        seed: u64 = 0, whole(0, i64::MAX).only_for("lights", &["samples"]);
    }
}

fn method_choices() -> Vec<Choice> {
    let fits = methods().iter().map(|method| Choice { name: method.name, summary: method.summary });
    fits.chain([Choice { name: "none", summary: "ambient light only" }]).collect()
}

fn sampler_choices() -> Vec<Choice> {
    samplers().iter().map(|sampler| Choice { name: sampler.name, summary: sampler.summary }).collect()
}

impl FitSettings {
    /// The fit, for a scene that stands on a ground or does not; `None` for ambient light only.
    ///
    /// # Errors
    /// An option that cannot be what it is, or that the method does not have.
    pub fn fit(&self, ground: bool) -> Result<Option<Box<dyn LightFit>>, FitError> {
        self.fit_with(&self.options(ground)?)
    }

    /// The same with [`FitSettings::options`] that say more of a scene.
    ///
    /// # Errors
    /// As [`FitSettings::fit`].
    pub fn fit_with(&self, options: &FitOptions) -> Result<Option<Box<dyn LightFit>>, FitError> {
        if self.method == "none" { Ok(None) } else { by_name(&self.method, options).map(Some) }
    }

    /// What the fits take, for a scene that stands on a ground or does not.
    ///
    /// # Errors
    /// An option that cannot be what it is.
    pub fn options(&self, ground: bool) -> Result<FitOptions, FitError> {
        self.check()?;
        Ok(FitOptions {
            light_count: self.light_count,
            threshold: self.threshold,
            max_extent: self.max_extent.map(f32::to_radians),
            sampler: self.sampler.as_deref().map(sampler_by_name).transpose()?,
            seed: self.seed,
            ground,
            arrival: None,
        })
    }

    /// Whether a scene that stands on a ground gets other lights for it.
    pub fn heeds_ground(&self) -> bool {
        matches!(self.fit(true), Ok(Some(fit)) if fit.heeds_ground())
    }

    /// Whether an interior gets other lights for what arrives in it.
    pub fn heeds_arrival(&self) -> bool {
        matches!(self.fit(false), Ok(Some(fit)) if fit.heeds_arrival())
    }
}
