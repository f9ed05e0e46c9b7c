use std::time::Instant;

use glam::{Affine3A, Mat3, Vec3};
use gnomon_metrics::compare;
use gnomon_picture::{ContactSheet, Panel};
use gnomon_renderer::{BumpShadows, Bumps, RenderSettings};
use gnomon_scene::{AreaLight, AreaLightShape, Node, NodeId};

use super::fields::FIELDS;
use crate::columns::stand_ins;
use crate::pictures::shown;
use crate::report::{Section, Table, significant};
use crate::timing::interleaved;
use crate::{Environment, Experiment, Lab, LabError, Setup, TimedRenderer, View};

/// Every way to draw bumps against the traced height field: error, time, and time to prepare.
pub(super) struct Pictures;

/// Ways, each with what it adds to the one before.
const WAYS: [(&str, Bumps, BumpShadows); 5] = [
    ("off", Bumps::Off, BumpShadows::Ellipses),
    ("shade", Bumps::Shade, BumpShadows::Ellipses),
    ("shadow, ellipses", Bumps::Shadow, BumpShadows::Ellipses),
    ("scatter, ellipses", Bumps::Scatter, BumpShadows::Ellipses),
    ("scatter, horizons", Bumps::Scatter, BumpShadows::Horizons),
];

/// Environments, and a lamp above each field beside the last.
const LIGHTINGS: [(&str, bool); 3] = [("stpeters", false), ("galileo", false), ("stpeters", true)];

/// What of the lamp's case the environment still gives.
const DIMMED: f32 = 0.05;

fn add_lamp(view: &mut View) {
    let down = Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
    let parent_from_node = Affine3A::from_mat3_translation(down, Vec3::new(-1.0, 1.2, -0.6));
    view.scene.nodes.push(Node { parent_from_node, ..Node::default() });
    let node = NodeId(view.scene.nodes.len() - 1);
    let shape = AreaLightShape::Disk { radius: 0.2 };
    view.scene.lights.push(AreaLight { node, shape, radiance: Vec3::splat(8.0), spread: Default::default() });
}

fn dimmed(environment: &Environment) -> Environment {
    let mut picture = environment.map.radiance().clone();
    picture.texels_mut().iter_mut().for_each(|texel| *texel *= DIMMED);
    Environment { name: "lamp", map: gnomon_envmap::Equirect::new(picture), stand_in: environment.stand_in }
}

impl Experiment for Pictures {
    fn name(&self) -> &'static str {
        "pictures"
    }

    fn title(&self) -> &'static str {
        "Bumps with and without shadows and scattered light (Heidrich 2001, Figs 9 and 13)"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let size = lab.pick([32, 24], [160, 120], [512, 384]);
        let side = lab.pick(32, 128, 512);
        let columns = [
            ("field", ""),
            ("light", ""),
            ("bumps", ""),
            ("relative RMSE", ""),
            ("frame over shading alone", ""),
            ("preparation", "ms"),
        ];
        let mut table = Table::new("bumps", "Against the traced height field", &columns);
        let mut sheet =
            ContactSheet::new("bumps_pictures", "Bumps, step by step, and traced", WAYS.len() as u32 + 1);
        let fields = lab.pick(&FIELDS[..1], &FIELDS, &FIELDS);
        let lightings = lab.pick(&LIGHTINGS[..1], &LIGHTINGS, &LIGHTINGS);
        let mut environments = Vec::new();
        for (index, field) in fields.iter().enumerate() {
            for &(name, has_lamp) in lightings {
                lab.tell(&format!("bumps: {}", field.name), index as f32 / fields.len() as f32);
                let environment = lab.environment(name)?;
                environments.push(environment.clone());
                let mut view = field.view(side)?;
                let dim = dimmed(&environment);
                let environment = if has_lamp { &dim } else { &*environment };
                if has_lamp {
                    add_lamp(&mut view);
                }
                measured(lab, (&view, environment), size, (&mut table, &mut sheet))?;
            }
        }
        let mut paragraphs = vec![format!(
            "{} x {} pixels; fields of {side} x {side} texels on a square of 2 m. Preparation is the whole of taking the scene over less that \
             of shading alone. Truth: own tracer, through the height field itself, six bounces.",
            size[0], size[1]
        )];
        paragraphs.extend(stand_ins(&[], &environments));
        Ok(Section { paragraphs, tables: vec![table], sheets: vec![sheet], ..Section::default() })
    }
}

fn measured(
    lab: &Lab<'_>,
    (view, environment): (&View, &Environment),
    size: [u32; 2],
    (table, sheet): (&mut Table, &mut ContactSheet),
) -> Result<(), LabError> {
    let lights = lab.lights("optimized", None, view, environment)?;
    let truth = lab.truth(view, environment, size, lab.pick(2, 128, 512))?;
    let stops = environment.map.suitable_exposure();
    let setup = Setup { view, map: &environment.map, lights: &lights, size };
    let (mut renderers, mut taken) = (Vec::new(), Vec::new());
    for (_, bumps, shadows) in WAYS {
        let settings = RenderSettings::default().with(|s| {
            s.techniques.bumps = bumps;
            s.techniques.bump_shadows = shadows;
        });
        let before = Instant::now();
        renderers.push(TimedRenderer::new(lab, settings, setup)?);
        taken.push(1e3 * before.elapsed().as_secs_f64());
    }
    let pictures = renderers.iter_mut().map(TimedRenderer::picture).collect::<Result<Vec<_>, _>>()?;
    let mut rivals: Vec<_> = renderers.iter_mut().map(TimedRenderer::rival).collect();
    let spreads = interleaved(&mut rivals, &lab.timing_plan(6.0))?;
    let shading = spreads.get(1).map(|spread| spread.median);
    for (place, ((name, ..), picture)) in WAYS.iter().zip(&pictures).enumerate() {
        let error = compare(picture, &truth.picture, None)?.relative_rmse;
        table.push([
            view.name.into(),
            environment.name.into(),
            (*name).into(),
            error.into(),
            shading.map(|shading| spreads[place].median / shading).into(),
            (taken[place] - taken[1]).max(0.0).into(),
        ]);
        let caption = format!("{}: {name}\nRMSE {}", view.name, significant(error, 3));
        sheet.panels.push(Panel::new(caption, shown(picture, stops)));
    }
    let caption = format!("{}\n{}", view.name, truth.described());
    sheet.panels.push(Panel::new(caption, shown(&truth.picture, stops)));
    Ok(())
}
