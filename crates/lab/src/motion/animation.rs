use std::time::Instant;

use gnomon_metrics::compare;
use gnomon_picture::{ContactSheet, Panel};
use gnomon_renderer::{RenderSettings, Renderer, ShadowSizing};
use gnomon_scene::{Ground, NodeId, Scene, default_camera};

use crate::columns::stand_ins;
use crate::data::ASPECT;
use crate::pictures::shown;
use crate::report::{Cell, Section, Table, significant};
use crate::timing::{Spread, TimingPlan};
use crate::{Experiment, Lab, LabError, Setup, TimedRenderer, View};

/// Dancing against standing still: the same pictures, with and without a new pose before each.
pub(super) struct Animation;

/// Scene and the clip that it plays.
const DANCERS: [(&str, usize); 2] = [("brainstem", 0), ("fox", 2)];

/// Frames a second of what is played.
const RATE: f32 = 30.0;

/// Most that a moving scene may take over the same at rest.
const MOST: f64 = 1.15;

/// Texels along the sides of all shadow maps, and number of lights: those of Annen et al. 2008.
const RESOLUTION: u32 = 256;
const LIGHTS: usize = 30;

/// A scene that moves: by a clip, or, without one, by turning about +y as a whole.
struct Mover {
    scene: Scene,
    clip: Option<(usize, f32)>,
    /// Placements of the nodes that turn.
    turning: Vec<(NodeId, glam::Affine3A)>,
}

impl Mover {
    fn new(scene: &Scene, clip: usize) -> Self {
        let duration = scene.animations.get(clip).map(|clip| clip.duration());
        let turns = |(index, node): (usize, &gnomon_scene::Node)| {
            let free = node.parent.is_none() && scene.ground != Some(NodeId(index));
            (free && duration.is_none()).then_some((NodeId(index), node.parent_from_node))
        };
        Self {
            turning: scene.nodes.iter().enumerate().filter_map(turns).collect(),
            clip: duration.filter(|duration| *duration > 0.0).map(|duration| (clip, duration)),
            scene: scene.clone(),
        }
    }

    /// The pose of frame `number`.
    fn go_to(&mut self, number: usize) -> Result<&Scene, LabError> {
        let seconds = number as f32 / RATE;
        if let Some((clip, duration)) = self.clip {
            self.scene.animate(clip, seconds.rem_euclid(duration))?;
        }
        let turn = glam::Affine3A::from_rotation_y(seconds);
        for (node, place) in &self.turning {
            if let Some(node) = self.scene.nodes.get_mut(node.0) {
                node.parent_from_node = turn * *place;
            }
        }
        Ok(&self.scene)
    }
}

/// Times of frames at rest and in motion, both of the same poses, and of what the latter do before they draw.
fn time(
    renderers: [&mut Renderer; 2],
    mover: &mut Mover,
    view: &View,
    [width, height]: [u32; 2],
    plan: &TimingPlan,
) -> Result<[Option<Spread>; 3], LabError> {
    let [still, moving] = renderers;
    let mut times = [Vec::new(), Vec::new(), Vec::new()];
    let start = Instant::now();
    for round in 0..plan.rounds.max(1) {
        if round >= plan.least_rounds.max(1) && start.elapsed().as_secs_f64() > plan.seconds {
            break;
        }
        // One that stands has been in its pose for a frame already.
        still.move_scene(mover.go_to(round)?)?;
        still.draw(&view.camera, width, height)?;
        for turn in [round % 2, (round + 1) % 2] {
            let before = Instant::now();
            if turn == 0 {
                still.draw(&view.camera, width, height)?;
            } else {
                moving.move_scene(mover.go_to(round)?)?;
                times[2].push(1e3 * before.elapsed().as_secs_f64());
                moving.draw(&view.camera, width, height)?;
            }
            times[turn].push(1e3 * before.elapsed().as_secs_f64());
        }
    }
    Ok(times.map(Spread::of))
}

impl Experiment for Animation {
    fn name(&self) -> &'static str {
        "animation"
    }

    fn title(&self) -> &'static str {
        "Skinned models dancing and at rest"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let environment = lab.environment("galileo")?;
        let size = lab.pick([32, 24], [320, 240], [1280, 960]);
        let resolution = lab.pick(16, RESOLUTION, RESOLUTION);
        let settings = RenderSettings::default().with(|s| {
            s.techniques.shadow_sizing = ShadowSizing::Uniform;
            s.techniques.shadow_resolution = resolution;
            // No maps but those of the lights that are counted.
            s.lighting.ambient = "unshadowed".to_owned();
        });
        let columns = [
            ("scene", ""),
            ("triangles", ""),
            ("lights", ""),
            ("map side", "texels"),
            ("at rest, median", "ms"),
            ("moving, median", "ms"),
            ("of it new pose", "ms"),
            ("moving over at rest", ""),
            ("at most", ""),
            ("met", ""),
            ("frames moving", "1/s"),
            ("relative RMSE", ""),
        ];
        let mut table = Table::new("motion", "Frame time of the same poses, at rest and in motion", &columns);
        let mut passes = Table::new(
            "motion_passes",
            "Median time of every pass, each submitted alone",
            &[("scene", ""), ("pass", ""), ("median", "ms")],
        );
        let mut sheet = ContactSheet::new("motion_pictures", "In the middle of the clip", 2);
        sheet.enlargement = lab.pick(1, 2, 1);
        let stops = environment.map.suitable_exposure() - 1.0;
        let mut files = Vec::new();
        for (index, (name, clip)) in DANCERS.into_iter().enumerate() {
            lab.tell(&format!("animation: {name}"), index as f32 / DANCERS.len() as f32);
            let file = lab.view(name)?;
            let view = dancing(&file, clip)?;
            files.push(file);
            let lights = lab.lights("partition", Some(lab.pick(6, LIGHTS, LIGHTS)), &view, &environment)?;
            let truth = lab.truth(&view, &environment, size, lab.pick(2, 32, 64))?;
            let setup = Setup { view: &view, map: &environment.map, lights: &lights, size };
            let picture = TimedRenderer::new(lab, settings.clone(), setup)?.picture()?;
            let error = compare(&picture, &truth.picture, None)?.relative_rmse;
            for (what, picture) in [("drawn", &picture), ("traced", &truth.picture)] {
                let caption = match what {
                    "drawn" => format!("{name}\nRMSE {}", significant(error, 3)),
                    _ => format!("{name}\n{}", truth.described()),
                };
                sheet.panels.push(Panel::new(caption, shown(picture, stops)));
            }
            let mut mover = Mover::new(&view.scene, clip);
            let mut new = || -> Result<Renderer, LabError> {
                let mut renderer = Renderer::new(lab.gpu(), settings.clone())?;
                renderer.set_scene(mover.go_to(0)?)?;
                renderer.set_lighting(&environment.map, &lights)?;
                renderer.draw(&view.camera, size[0], size[1])?;
                Ok(renderer)
            };
            let (mut still, mut moving) = (new()?, new()?);
            let plan = TimingPlan {
                rounds: lab.pick(1, 15, 61),
                least_rounds: lab.pick(1, 7, 15),
                ..lab.timing_plan(40.0)
            };
            let spreads = time([&mut still, &mut moving], &mut mover, &view, size, &plan)?;
            let [rest, motion, pose] = spreads.map(|spread| spread.map(|spread| spread.median));
            let ratio = rest.zip(motion).map(|(rest, motion)| motion / rest);
            table.push([
                view.name.into(),
                view.scene.triangle_count().into(),
                lights.lights.len().into(),
                resolution.into(),
                rest.into(),
                motion.into(),
                pose.into(),
                ratio.into(),
                MOST.into(),
                ratio.map(|ratio| if ratio <= MOST { "yes" } else { "no" }).into(),
                motion.map(|motion| 1e3 / motion).into(),
                error.into(),
            ]);
            let profiled = settings.clone().with(|s| s.measure.profile = true);
            for (pass, median) in
                TimedRenderer::new(lab, profiled, setup)?.pass_times(&lab.timing_plan(8.0))?
            {
                passes.push([Cell::from(view.name), pass.into(), median.into()]);
            }
        }
        let mut paragraphs = vec![format!(
            "{} x {} pixels of 2 x 2 samples under {}. At rest and in motion the same poses are drawn in turns, {RATE} of them a second \
             of the clip. In motion the time includes finding the pose and bringing it to the GPU; at rest the pose has been there for \
             a frame. Vertices are bent anew in every frame of either. Truth: own tracer in the same pose.",
            size[0], size[1], environment.name
        )];
        paragraphs.extend(stand_ins(&files, &[environment]));
        Ok(Section { paragraphs, tables: vec![table, passes], sheets: vec![sheet], ..Section::default() })
    }
}

/// The view in the middle of a clip, on a ground and in sight there.
fn dancing(file: &View, clip: usize) -> Result<View, LabError> {
    let mut scene = file.scene.clone();
    let Some(duration) = scene.animations.get(clip).map(|clip| clip.duration()) else {
        return Ok(file.clone());
    };
    scene.animate(clip, 0.45 * duration)?;
    scene.add_ground(Ground::Plane);
    let camera = default_camera(&scene, ASPECT);
    Ok(View { stand_in: file.stand_in, ..View::new(file.name, scene, camera) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DataFolder;

    #[test]
    fn every_mover_moves_and_its_ground_does_not() {
        for data in [DataFolder(None), DataFolder(gnomon_testing::data_dir())] {
            for (name, clip) in DANCERS {
                let view = dancing(&data.view(name).unwrap(), clip).unwrap();
                let mut mover = Mover::new(&view.scene, clip);
                let mut places = |number: usize| {
                    let scene = mover.go_to(number).unwrap();
                    let ground = scene.ground.map(|ground| scene.world_from_nodes()[ground.0]);
                    (ground, scene.bounds_without_ground().unwrap())
                };
                let (first, second) = (places(3), places(10));
                assert!(first.0.is_some() && first.0 == second.0, "{name}");
                assert_ne!(first.1, second.1, "{name}");
            }
        }
    }
}
