//! What the experiments of this suite share.

use std::rc::Rc;
use std::slice;

use gnomon_lights::LightSet;
use gnomon_metrics::{DISPLAY_MAPPING, Exposure, Mask, compare_displayed};
use gnomon_picture::RgbImage;
use gnomon_renderer::{GlossPath, RenderSettings};

use crate::columns::stand_ins;
use crate::{Environment, Lab, LabError, Setup, TimedRenderer, Truth, View};

/// One column of the paper's Fig. 3, or the landscape of its Fig. 4.
pub(super) struct Case {
    pub view: &'static str,
    pub environment: &'static str,
    pub paper: &'static [Paper],
}

/// What the paper's Fig. 3 says of one picture (GeForce 8800, 1280 x 800, stencil shadow volumes).
pub(super) struct Paper {
    pub rule: &'static str,
    pub lights: usize,
    /// Samples of the picture's side for one of the shadow buffer's.
    pub sampling: u32,
    /// Frames per second.
    pub rate: f64,
    /// Of displayed values in 0..1.
    pub rms: Option<f64>,
}

const fn paper(rule: &'static str, lights: usize, sampling: u32, rate: f64, rms: Option<f64>) -> Paper {
    Paper { rule, lights, sampling, rate, rms }
}

pub(super) static CASES: [Case; 4] = [
    Case {
        view: "glossy_bunny",
        environment: "grace",
        paper: &[
            paper("additive", 40, 1, 28.0, Some(0.069)),
            paper("subtractive", 40, 1, 23.0, Some(0.026)),
            paper("subtractive", 15, 1, 40.0, Some(0.043)),
        ],
    },
    Case {
        view: "glossy_triceratops",
        environment: "stpeters",
        paper: &[
            paper("additive", 100, 1, 20.0, Some(0.093)),
            paper("subtractive", 100, 1, 18.0, Some(0.039)),
            paper("subtractive", 20, 1, 56.0, Some(0.043)),
        ],
    },
    Case {
        view: "glossy_horse",
        environment: "rnl",
        paper: &[
            paper("additive", 30, 1, 19.0, None),
            paper("subtractive", 30, 4, 30.0, None),
            paper("subtractive", 30, 32, 30.0, None),
        ],
    },
    Case { view: "terrain", environment: "sky", paper: &[] },
];

/// The cases of the effort at hand.
pub(super) fn cases(lab: &Lab<'_>) -> &'static [Case] {
    lab.pick(&CASES[..1], &CASES, &CASES)
}

/// How an environment becomes lights, and how they cast shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Family {
    pub fit: &'static str,
    pub technique: &'static str,
}

impl Family {
    pub fn name(self) -> String {
        format!("{}, {}", self.fit, self.technique)
    }
}

/// The paper's own: points of the map by structured importance sampling, hard shadows.
pub(super) const POINTS: Family = Family { fit: "samples:structured", technique: "hard" };

/// Lights with an extent, and shadows as soft as they make them.
pub(super) const AREAS: [Family; 2] =
    [Family { fit: "partition", technique: "convolution" }, Family { fit: "partition", technique: "pcss" }];

/// A case with its truth.
pub(super) struct Subject {
    pub case: &'static Case,
    pub view: Rc<View>,
    pub environment: Rc<Environment>,
    pub truth: Rc<Truth>,
    size: [u32; 2],
    /// Pixels that show the scene's models.
    models: Mask,
}

impl Subject {
    pub fn new(lab: &Lab<'_>, case: &'static Case) -> Result<Self, LabError> {
        let view = lab.view(case.view)?;
        let environment = lab.environment(case.environment)?;
        let size = lab.pick([32, 24], [96, 72], [192, 144]);
        let truth = lab.truth(&view, &environment, size, lab.pick(2, 4096, 16_384))?;
        let models = models(lab, &view, &environment, size)?;
        Ok(Self { case, view, environment, truth, size, models })
    }

    pub fn setup<'a>(&'a self, lights: &'a LightSet) -> Setup<'a> {
        Setup { view: &self.view, map: &self.environment.map, lights, size: self.size }
    }

    /// The paper's measure: root mean square of displayed values in 0..1 over the picture, at the exposure that `gnomon render`
    /// chooses.
    pub fn displayed_rms(&self, picture: &RgbImage) -> Result<f64, LabError> {
        self.rms_within(picture, None)
    }

    /// The same over the pixels that show the models: of their glossy surfaces alone.
    pub fn models_rms(&self, picture: &RgbImage) -> Result<f64, LabError> {
        self.rms_within(picture, Some(&self.models))
    }

    fn rms_within(&self, picture: &RgbImage, mask: Option<&Mask>) -> Result<f64, LabError> {
        let exposure = Exposure::Stops(self.environment.map.suitable_exposure());
        let comparison = compare_displayed(picture, &self.truth.picture, mask, exposure)?;
        // Peak signal-to-noise ratio is -20 log10 of it.
        Ok(10_f64.powf(-comparison.psnr / 20.0))
    }

    /// Scene, environment and truth in a sentence, and what stands in for them.
    pub fn described(&self, lab: &Lab<'_>) -> Vec<String> {
        let samples = samples(lab);
        let what = format!(
            "{} under {}: {} triangles, {} x {} pixels of {samples} x {samples} samples, truth: {}.",
            self.case.view,
            self.environment.name,
            self.view.scene.triangle_count(),
            self.size[0],
            self.size[1],
            self.truth.described()
        );
        let (views, environments) = (slice::from_ref(&self.view), slice::from_ref(&self.environment));
        [vec![what], stand_ins(views, environments)].concat()
    }
}

/// How figures are to be read, for every section.
pub(super) fn reading() -> String {
    format!(
        "RMS is the paper's measure: the root mean square over the picture and over channels of {DISPLAY_MAPPING}, at the exposure of \
         `gnomon render`, which brings the environment's mean luminance to 0.5; where there is a column for it, also over the pixels of the \
         models alone, which does not depend on how much of the picture they fill. Relative RMSE is of linear radiance over the picture. The truth is ray \
         traced; the paper's is its own picture with 1000 lights. Models are grey, matte 0.1 and Phong 0.8 with exponent 40 (bunny, \
         horse) or 500 (triceratops), stand free and fill the picture; the terrain is matte 0.5."
    )
}

/// Samples along the side of a pixel: narrow highlights of small models alias with fewer, which hides what rules and lights do.
fn samples(lab: &Lab<'_>) -> u32 {
    lab.pick(2, 4, 4)
}

/// A frame as the paper draws it: every sample has its own shadows, highlights are those of the lights, unshadowed ones come from the radiance
/// cache. Large sets of lights take turns.
pub(super) fn frame(lab: &Lab<'_>) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.supersample = samples(lab);
        s.techniques.shadow_resolution = lab.pick(32, 256, 512);
        s.techniques.shadow_sampling = 1;
        s.techniques.shadow_memory = 256;
        s.techniques.gloss = GlossPath::Lights;
        s.techniques.unshadowed = "cache".to_owned();
    })
}

/// The same with a family, a rule and fewer samples of shadows.
pub(super) fn settings(frame: &RenderSettings, family: Family, rule: &str, sampling: u32) -> RenderSettings {
    frame.clone().with(|s| {
        s.techniques.shadows = family.technique.to_owned();
        s.techniques.compositing = rule.to_owned();
        s.techniques.shadow_sampling = sampling;
    })
}

/// The pixels that show models: those that are not black where there is neither background nor ground.
fn models(lab: &Lab<'_>, view: &View, environment: &Environment, size: [u32; 2]) -> Result<Mask, LabError> {
    let mut view = view.clone();
    if let Some(ground) = view.scene.ground.and_then(|ground| view.scene.nodes.get_mut(ground.0)) {
        ground.meshes.clear();
    }
    let lights = lab.lights("samples", Some(1), &view, environment)?;
    let setup = Setup { view: &view, map: &environment.map, lights: &lights, size };
    let unshadowed = RenderSettings::default().with(|s| {
        s.techniques.shadows = "none".to_owned();
        s.display.background = gnomon_renderer::Background::None;
    });
    let picture = TimedRenderer::new(lab, unshadowed, setup)?.picture()?;
    Ok(Mask::from_fn(size[0], size[1], |x, y| picture.get(x, y).max_element() > 0.0))
}
