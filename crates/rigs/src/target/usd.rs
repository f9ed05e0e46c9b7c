//! Universal Scene Description, as text (UsdLux schemas, <https://openusd.org/release/api/usd_lux_page_front.html>).
//!
//! - A stage with `upAxis = "Y"` has Gnomon's axes.
//! - `inputs:intensity` is radiance [nits] where `inputs:normalize` is false, and for a `DistantLight` too: its irradiance is the intensity
//!   times pi sin^2 of half its `inputs:angle`. 50000 is the default there, so that it is always written.
//! - Rectangles and disks emit along their own -z, so that +z points towards the light; width runs along x, height along y. Matrices hold
//!   axes as rows.
//! - A `DomeLight`'s `latlong` map is OpenEXR's, which is Gnomon's own.

use glam::{Vec2, Vec3};
use gnomon_lights::DistantLight;

use super::{Reflections, Target, comment, numbers};
use crate::{FarShape, Outline, Rig, Sun};

pub(super) const TARGET: Target = Target {
    name: "usd",
    extensions: &["usda"],
    summary: "USD: far area lights of their own outlines and a dome",
    reflections: Reflections::Lights,
    most_lights: None,
    loses: "",
    map_extension: "exr",
    text: areas,
};

/// Storm draws area lights as points, and a dome without shadows.
pub(super) const DISTANT: Target = Target {
    name: "usd-distant",
    extensions: &[],
    summary: "USD: distant lights and a dome, for renderers that draw area lights as points",
    reflections: Reflections::Lights,
    most_lights: None,
    loses: "outlines become disks of the same solid angle",
    map_extension: "exr",
    text: distant,
};

/// Distance of area lights [m]: for models of some metres their shadows are those of distant lights within 0.1 %.
const DISTANCE: f32 = 10_000.0;

fn areas(rig: &Rig) -> String {
    stage(rig, area_light)
}

fn distant(rig: &Rig) -> String {
    stage(rig, distant_light)
}

fn stage(rig: &Rig, light: fn(&DistantLight, &str) -> String) -> String {
    let mut text = format!(
        "#usda 1.0\n(\n    defaultPrim = \"Rig\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n{}\ndef Xform \"Rig\"\n{{\n",
        comment(rig, "# ")
    );
    for (index, of) in rig.set.lights.iter().enumerate() {
        text += &light(of, &format!("Light{index:03}"));
    }
    if let Some(file) = &rig.residual {
        text += &format!(
            "    def DomeLight \"Residual\"\n    {{\n        float inputs:intensity = 1\n        color3f inputs:color = (1, 1, 1)\n        \
             asset inputs:texture:file = {}\n        token inputs:texture:format = \"latlong\"\n    }}\n",
            asset(file)
        );
    }
    text + "}\n"
}

/// A path between signs that it does not hold.
fn asset(file: &str) -> String {
    if file.contains('@') { format!("@@@{file}@@@") } else { format!("@{file}@") }
}

/// What all lights have. Colour and intensity are one product: the intensity is that of the brightest channel.
fn emission(value: glam::DVec3) -> String {
    let (color, intensity) = crate::rig::split(value);
    format!(
        "        float inputs:intensity = {}\n        color3f inputs:color = ({})\n        bool inputs:normalize = 0\n",
        numbers([intensity], ""),
        numbers(color.to_array(), ", ")
    )
}

/// Rows of a light's own axes and place.
fn transform(across: Vec3, along: Vec3, towards: Vec3, place: Vec3) -> String {
    let row = |v: Vec3, w: &str| format!("({}, {w})", numbers(v.as_dvec3().to_array(), ", "));
    format!(
        "        matrix4d xformOp:transform = ( {}, {}, {}, {} )\n        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n",
        row(across, "0"),
        row(along, "0"),
        row(towards, "0"),
        row(place, "1")
    )
}

fn area_light(light: &DistantLight, name: &str) -> String {
    let shape = FarShape::of(light);
    let (kind, size) = match shape.outline {
        Outline::Disk(radius) => {
            ("DiskLight", format!("        float inputs:radius = {}\n", radius * DISTANCE))
        }
        Outline::Rectangle(half) => {
            let Vec2 { x, y } = 2.0 * half * DISTANCE;
            ("RectLight", format!("        float inputs:width = {x}\n        float inputs:height = {y}\n"))
        }
    };
    format!(
        "    def {kind} \"{name}\"\n    {{\n{}{size}{}    }}\n",
        emission(shape.radiance.as_dvec3()),
        transform(shape.across, shape.along, shape.towards, shape.towards * DISTANCE)
    )
}

fn distant_light(light: &DistantLight, name: &str) -> String {
    let sun = Sun::of(light);
    let area = std::f64::consts::PI * (0.5 * sun.diameter).sin().powi(2);
    let towards = sun.towards.as_vec3();
    let (across, along) = towards.any_orthonormal_pair();
    format!(
        "    def DistantLight \"{name}\"\n    {{\n{}        float inputs:angle = {}\n{}    }}\n",
        emission(sun.irradiance / area),
        numbers([sun.diameter.to_degrees()], ""),
        transform(across, along, towards, Vec3::ZERO)
    )
}
