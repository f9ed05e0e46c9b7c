//! Blender, as a Python script (<https://docs.blender.org/api/current/bpy.types.SunLight.html>).
//!
//! - +z is up: a scene turns as glTF's importer turns it, `(x, y, z)` to `(x, -z, y)`, so that models of a `.glb` fit.
//! - An environment texture shows its middle towards +x and the column a quarter left of it towards +y. Turned by a quarter about z it fits.
//! - A `SUN`'s energy is the irradiance of a surface that faces it, its `angle` the diameter [rad]; it shines along its own -z. Cycles and
//!   EEVEE agree on it, and not on the radiance of an `AREA` light, so that outlines become disks.
//! - Cycles lights by the world by rays of surfaces alone where one map lights and another is mirrored: the map that mirrors show would be
//!   sampled as a light, too.

use gnomon_lights::DistantLight;
use serde_json::{Value, json};

use super::{Reflections, Target, comment, numbers};
use crate::rig::z_up;
use crate::{Rig, Sun};

pub(super) const TARGET: Target = Target {
    name: "blender",
    extensions: &["py"],
    summary: "Blender: a script that makes sun lamps and a world, for Cycles and EEVEE",
    reflections: Reflections::OwnMap,
    most_lights: None,
    loses: "outlines become disks of the same solid angle, and EEVEE shows no other map in mirrors",
    map_extension: "exr",
    text,
};

fn text(rig: &Rig) -> String {
    let lights: String = rig.set.lights.iter().map(|light| format!("    ({}),\n", entry(light))).collect();
    let name = |file: &Option<String>| match file {
        // A string of JSON is one of Python.
        Some(file) => json!(file),
        None => Value::Null,
    };
    SCRIPT
        .replace("# ABOUT\n", &comment(rig, "# "))
        .replace("LIGHT_LIST", &format!("[\n{lights}]"))
        .replace("RESIDUAL_FILE", &python(&name(&rig.residual)))
        .replace("REFLECTION_FILE", &python(&name(&rig.whole)))
}

fn python(value: &Value) -> String {
    if value.is_null() { "None".to_owned() } else { value.to_string() }
}

fn entry(light: &DistantLight) -> String {
    let sun = Sun::of(light);
    let (color, energy) = sun.color_and_intensity();
    let triple = |v: glam::DVec3| format!("({})", numbers(v.to_array(), ", "));
    format!("{}, {}, {}", triple(z_up(sun.towards)), triple(color), numbers([energy, sun.diameter], ", "))
}

const SCRIPT: &str = r#"# ABOUT
#
# Run it in Blender's text editor, or: blender scene.blend --python rig.py

import os

import bpy
from mathutils import Vector

# Direction towards it, colour, irradiance, angle across [rad].
LIGHTS = LIGHT_LIST
# Maps beside this file: what lights leave, and what mirrors and the camera show in its place.
RESIDUAL = RESIDUAL_FILE
REFLECTION = REFLECTION_FILE


def folder():
    text = getattr(bpy.context.space_data, "text", None)
    return os.path.dirname(bpy.path.abspath(text.filepath) if text and text.filepath else os.path.abspath(__file__))


def background(tree, file):
    node = tree.nodes.new("ShaderNodeBackground")
    node.inputs["Strength"].default_value = 1.0
    node.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    if file:
        place = tree.nodes.new("ShaderNodeTexCoord")
        turn = tree.nodes.new("ShaderNodeMapping")
        turn.inputs["Rotation"].default_value = (0.0, 0.0, 0.5 * 3.141592653589793)
        texture = tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(os.path.join(folder(), file), check_existing=True)
        tree.links.new(place.outputs["Generated"], turn.inputs["Vector"])
        tree.links.new(turn.outputs["Vector"], texture.inputs["Vector"])
        tree.links.new(texture.outputs["Color"], node.inputs["Color"])
    return node


rig = bpy.data.collections.new("Rig")
bpy.context.scene.collection.children.link(rig)
for number, (towards, color, energy, angle) in enumerate(LIGHTS):
    data = bpy.data.lights.new(f"Rig {number}", "SUN")
    data.color, data.energy, data.angle = color, energy, angle
    lamp = bpy.data.objects.new(data.name, data)
    lamp.rotation_mode = "QUATERNION"
    lamp.rotation_quaternion = Vector(towards).to_track_quat("Z", "Y")
    if REFLECTION:
        lamp.visible_glossy = False
        data.specular_factor = 0.0
    rig.objects.link(lamp)

world = bpy.data.worlds.new("Rig")
world.use_nodes = True
if hasattr(world, "sun_threshold"):
    # Else EEVEE takes a sun of its own out of the map.
    world.sun_threshold = 0.0
tree = world.node_tree
tree.nodes.clear()
shown = background(tree, RESIDUAL)
if REFLECTION:
    mix = tree.nodes.new("ShaderNodeMixShader")
    path = tree.nodes.new("ShaderNodeLightPath")
    tree.links.new(path.outputs["Is Diffuse Ray"], mix.inputs[0])
    tree.links.new(background(tree, REFLECTION).outputs[0], mix.inputs[1])
    tree.links.new(shown.outputs[0], mix.inputs[2])
    shown = mix
    if hasattr(world, "cycles"):
        world.cycles.sampling_method = "NONE"
tree.links.new(shown.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
bpy.context.scene.world = world
"#;
