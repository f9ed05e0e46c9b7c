use gnomon_envmap::Equirect;
use gnomon_lights::LightSet;
use gnomon_picture::RgbImage;
use gnomon_renderer::{PassTiming, RenderError, RenderSettings, Renderer};

use crate::timing::{Rival, Spread, TimingPlan};
use crate::{Lab, LabError, View};

/// Everything that a picture depends on, apart from how it is drawn.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// Scene and view.
    pub view: &'a View,
    /// What the camera and mirrors see.
    pub map: &'a Equirect,
    /// What lights the scene.
    pub lights: &'a LightSet,
    /// Pixels across and down.
    pub size: [u32; 2],
}

/// A renderer that has taken a setup over.
pub struct TimedRenderer<'a> {
    renderer: Renderer,
    setup: Setup<'a>,
}

impl<'a> TimedRenderer<'a> {
    /// Takes a setup over.
    ///
    /// # Errors
    /// Settings out of range, a setup that the adapter cannot hold, a device that failed.
    pub fn new(lab: &Lab<'a>, settings: RenderSettings, setup: Setup<'a>) -> Result<Self, RenderError> {
        let mut renderer = Renderer::new(lab.gpu(), settings)?;
        renderer.set_scene(&setup.view.scene)?;
        renderer.set_lighting(setup.map, setup.lights)?;
        Ok(Self { renderer, setup })
    }

    /// The same, or `None` where the adapter cannot hold it.
    ///
    /// # Errors
    /// As [`TimedRenderer::new`], but for [`RenderError::OverLimit`].
    pub fn if_it_fits(
        lab: &Lab<'a>,
        settings: RenderSettings,
        setup: Setup<'a>,
    ) -> Result<Option<Self>, LabError> {
        match Self::new(lab, settings, setup) {
            Ok(renderer) => Ok(Some(renderer)),
            Err(RenderError::OverLimit { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// One frame's radiance.
    ///
    /// # Errors
    /// The device failed.
    pub fn picture(&mut self) -> Result<RgbImage, LabError> {
        let [width, height] = self.setup.size;
        Ok(self.renderer.render(&self.setup.view.camera, width, height)?.radiance)
    }

    /// Draws one frame and waits for it: what is timed. Gives the times of its passes where the settings ask for them.
    ///
    /// # Errors
    /// The device failed.
    pub fn draw(&mut self) -> Result<Vec<PassTiming>, LabError> {
        let [width, height] = self.setup.size;
        Ok(self.renderer.draw(&self.setup.view.camera, width, height)?)
    }

    /// GPU memory of shadow maps and their filtered images [bytes].
    pub fn shadow_bytes(&self) -> u64 {
        self.renderer.shadow_bytes()
    }

    /// For [`crate::timing::interleaved`].
    pub fn rival(&mut self) -> Rival<'_> {
        Box::new(move || self.draw().map(|_| ()))
    }

    /// Median time of every pass [ms], by name and in order, of a renderer whose settings profile.
    ///
    /// # Errors
    /// The device failed.
    pub fn pass_times(&mut self, plan: &TimingPlan) -> Result<Vec<(&'static str, f64)>, LabError> {
        // The first frame compiles pipelines.
        self.draw()?;
        let mut passes: Vec<(&'static str, Vec<f64>)> = Vec::new();
        let start = std::time::Instant::now();
        for round in 0..plan.rounds.max(1) {
            if round >= plan.least_rounds.max(1) && start.elapsed().as_secs_f64() > plan.seconds {
                break;
            }
            for pass in self.draw()? {
                match passes.iter_mut().find(|(name, _)| *name == pass.name) {
                    Some((_, times)) => times.push(pass.milliseconds),
                    None => passes.push((pass.name, vec![pass.milliseconds])),
                }
            }
        }
        let median = |times| Spread::of(times).map_or(f64::NAN, |spread| spread.median);
        Ok(passes.into_iter().map(|(name, times)| (name, median(times))).collect())
    }
}
