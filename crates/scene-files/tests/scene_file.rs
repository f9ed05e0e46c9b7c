//! The TOML scene file.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::f32::consts::PI;
use std::path::Path;

use glam::{Vec2, Vec3};
use gnomon_brdf::{Model, Parameter};
use gnomon_scene::{AreaLightShape, Camera, Ground, Spread};
use gnomon_scene_files::{
    EnvironmentSettings, EnvironmentSource, FileResolver, LoadOptions, LoadedScene, SceneFileError, load,
    read_sections,
};

fn attempt(text: &str) -> Result<LoadedScene, SceneFileError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("triangle.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(folder.path().join("other.toml"), "ground = \"none\"\n").unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    load(&path, &LoadOptions::default())
}

#[test]
fn the_sample_scene_is_what_its_comments_say() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/sample.toml");
    let loaded = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 36 + 438, "built-in models come without their ground");
    let camera: Camera = "eye=4.5,3,6.5;target=0,0.9,0;fov=40".parse().unwrap();
    assert_eq!(loaded.scene.camera(None).unwrap(), &camera);
    assert_eq!(loaded.ground, Ground::Plane);
    let expected = EnvironmentSettings {
        source: Some(EnvironmentSource::Builtin("sky".to_owned())),
        exposure_ev: Some(0.0),
    };
    assert_eq!(loaded.environment, Some(expected));
    let clay = loaded.scene.materials.iter().position(|material| material.name == "clay").unwrap();
    let column = loaded.scene.nodes.iter().position(|node| node.name == "small column").unwrap();
    let under = loaded.scene.nodes.iter().filter(|node| node.parent.is_some_and(|parent| parent.0 == column));
    let meshes: Vec<_> = under.flat_map(|node| &node.meshes).collect();
    assert_eq!(meshes.len(), 1);
    assert!(meshes.iter().all(|mesh| loaded.scene.meshes[mesh.0].material.unwrap().0 == clay));
}

#[test]
fn models_are_scaled_then_turned_about_x_y_z_then_moved() {
    let loaded = attempt(
        "[[model]]\nfile = \"triangle.obj\"\nscale = [2, 3, 1]\nrotation = [0, 90, 90]\ntranslation = [10, 0, 0]\n",
    )
    .unwrap();
    let world = loaded.scene.instances()[0].world_from_mesh;
    // x: scaled to (2,0,0), about y by 90 degrees to (0,0,-2), about z stays.
    assert!((world.transform_point3(Vec3::X) - Vec3::new(10.0, 0.0, -2.0)).length() < 1e-5);
    // y: (0,3,0), about z by 90 degrees to (-3,0,0).
    assert!((world.transform_point3(Vec3::Y) - Vec3::new(7.0, 0.0, 0.0)).length() < 1e-5);
}

#[test]
fn cameras_and_materials_of_models_come_along() {
    let loaded = attempt(
        "ground = \"plane\"\n[[model]]\nfile = \"triangle.obj\"\n[[model]]\nbuiltin = \"column\"\ntranslation = [0, 1, 0]\nscale = 2\n",
    )
    .unwrap();
    assert_eq!(loaded.ground, Ground::Plane);
    assert_eq!(loaded.scene.triangle_count(), 439);
    assert_eq!(loaded.scene.ground, None);
    let camera = loaded.scene.camera(None).unwrap();
    assert!((camera.eye() - Vec3::new(7.2, 6.4, 10.4)).length() < 1e-4, "{}", camera.eye());
    assert!((camera.world_from_camera.determinant() - 1.0).abs() < 1e-5, "the scale stays out of it");
    let names: Vec<&str> = loaded.scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert!(names.contains(&"triangle") && names.contains(&"column"), "{names:?}");
}

#[test]
fn lights_are_placed_and_ride_on_models() {
    let loaded = attempt(
        "[[model]]\nfile = \"triangle.obj\"\nname = \"cart\"\ntranslation = [0, 0, 3]\nscale = 2\n\
         [[light]]\nshape = \"rectangle\"\nsize = [2, 1]\nposition = [1, 2, 3]\ntarget = [1, 2, -5]\nroll = 90\nradiance = [1, 2, 3]\n\
         [[light]]\nshape = \"sphere\"\nradius = 0.5\npower = [9.8696044, 0, 0]\nnode = \"cart\"\nposition = [0, 1, 0]\n\
         [[light]]\nshape = \"square\"\nsize = 2\ndirection = [0, -9e30, 0]\nradiance = [1, 1, 1]\n\
         [[light]]\nshape = \"disk\"\nradius = 2\ndirection = [1, 0, 0]\nradiance = [0, 0, 0]\nname = \"dark\"\n",
    )
    .unwrap();
    assert_eq!(loaded.scene.lights.len(), 4);
    assert_eq!(loaded.scene.nodes.last().unwrap().name, "dark");
    let [panel, bulb, lid] = loaded.scene.placed_lights()[..] else { panic!("the dark one is left out") };
    assert_eq!(panel.shape, AreaLightShape::Rectangle { size: Vec2::new(2.0, 1.0) });
    assert_eq!((panel.center, panel.normal), (Vec3::new(1.0, 2.0, 3.0), Vec3::NEG_Z));
    // By the right-hand rule about -z, +x goes to -y.
    assert!((panel.tangent - Vec3::NEG_Y).length() < 1e-6, "{}", panel.tangent);
    assert_eq!(bulb.shape, AreaLightShape::Sphere { radius: 0.5 });
    assert!((bulb.center - Vec3::new(0.0, 2.0, 3.0)).length() < 1e-6, "{}", bulb.center);
    // Power pi^2 over pi times an area of pi.
    assert!((bulb.radiance - Vec3::X).length() < 1e-6, "{}", bulb.radiance);
    assert!((lid.normal - Vec3::NEG_Y).length() < 1e-6 && lid.tangent.y == 0.0);
}

#[test]
fn a_spot_has_the_profile_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let with = |profile: &str, more: &str| {
        std::fs::write(folder.path().join("lamp.ies"), profile).unwrap();
        let text = format!(
            "[[light]]\nshape = \"spot\"\nradius = 0.1\ntarget = [0, -1, 0]\nprofile = \"lamp.ies\"\n{more}"
        );
        std::fs::write(&path, text).unwrap();
        load(&path, &LoadOptions::default())
    };
    let file = "IESNA91\nTILT=NONE\n1 -1 1.5 3 1 1 2 0 0 0\n1 1 10\n0 45 90\n0\n200 100 0\n";
    let light = with(file, "").unwrap().scene.placed_lights()[0];
    assert!((light.radiance * PI * 0.01).abs_diff_eq(Vec3::splat(300.0), 1e-3), "{}", light.radiance);
    let below = light.share_towards(light.center + Vec3::new(1.0, -1.0, 0.0));
    assert!((below - 0.5).abs() < 1e-3 && light.share_towards(light.center + Vec3::Y) == 0.0, "{below}");
    let dimmed = with(file, "intensity = [3, 2, 1]\n").unwrap().scene.placed_lights()[0];
    assert!((dimmed.radiance * PI * 0.01).abs_diff_eq(Vec3::new(3.0, 2.0, 1.0), 1e-4));
    let error = with("IESNA91\nTILT=NONE\n1 -1 x\n", "").unwrap_err().to_string();
    assert!(error.contains("'lamp.ies' cannot be used: the candela multiplier is no number"), "{error}");
    assert!(with(file, "cone = [1, 2]\n").unwrap_err().to_string().contains("either 'cone' or 'profile'"));
}

#[test]
fn spots_and_suns_have_their_own_keys() {
    let scene = attempt(
        "[[light]]\nshape = \"spot\"\nradius = 0.1\ncone = [10, 30]\ntarget = [0, -1, 0]\nintensity = [1, 2, 3]\n\
         [[light]]\nshape = \"sun\"\nangle = 2\ndirection = [1, -1, 0]\nirradiance = [4, 4, 4]\n\
         [[light]]\nshape = \"sphere\"\nradius = 0.5\nintensity = [1, 1, 1]\n",
    )
    .unwrap()
    .scene;
    let [spot, sun, sphere] = scene.placed_lights()[..] else { panic!("three lights") };
    assert_eq!(spot.spread, Spread::Cone { inner: 10_f32.to_radians(), outer: 30_f32.to_radians() });
    assert!((spot.radiance.z * PI * 0.01 - 3.0).abs() < 1e-5);
    assert_eq!(sun.shape, AreaLightShape::Sun { angular_radius: 1_f32.to_radians() });
    assert!((sun.radiance.x * PI * 1_f32.to_radians().sin().powi(2) - 4.0).abs() < 1e-5);
    assert!((sphere.radiance.x * PI * 0.25 - 1.0).abs() < 1e-5);
    for (light, words) in [
        ("shape = \"spot\"\nradius = 1\ntarget = [0, -1, 0]\nradiance = [1, 1, 1]", "needs a 'cone'"),
        (
            "shape = \"spot\"\nradius = 1\ncone = [30, 30]\ntarget = [0, -1, 0]\nradiance = [1, 1, 1]",
            "the first smaller",
        ),
        (
            "shape = \"disk\"\nradius = 1\ncone = [3, 30]\ntarget = [0, -1, 0]\nradiance = [1, 1, 1]",
            "only a spot",
        ),
        ("shape = \"sun\"\nradius = 1\ntarget = [0, -1, 0]\nradiance = [1, 1, 1]", "no 'radius'"),
        ("shape = \"sun\"\nangle = 180\ntarget = [0, -1, 0]\nradiance = [1, 1, 1]", "angle must be"),
        ("shape = \"sun\"\ntarget = [0, -1, 0]\npower = [1, 1, 1]", "'irradiance'"),
        ("shape = \"sun\"\nradiance = [1, 1, 1]", "'target' or 'direction'"),
    ] {
        let error = attempt(&format!("[[light]]\n{light}\n")).unwrap_err().to_string();
        assert!(error.contains(words), "{light}: {error}");
    }
}

#[test]
fn materials_name_their_reflectance() {
    let loaded = attempt(
        "[[model]]\nfile = \"triangle.obj\"\nmaterial = \"gloss\"\n\
         [material.gloss]\nreflectance = \"torrance-sparrow-gaussian\"\nslope = 0.2\nspecular = 0.9\n\
         [material.wax]\nreflectance = \"blinn-phong\"\nshininess = 12\nspecular = 0.5\nspecular_color = [1, 0.5, 0]\n",
    )
    .unwrap();
    let surface = &loaded.scene.materials[0].surface;
    assert_eq!((surface.model, surface.slope, surface.specular), (Model::TorranceSparrowGaussian, 0.2, 0.9));
    let surface = &loaded.scene.materials[1].surface;
    assert_eq!((surface.model, surface.shininess), (Model::BlinnPhong, 12.0));
    assert_eq!(surface.specular_color, Vec3::new(1.0, 0.5, 0.0));
    let warnings = &loaded.scene.warnings;
    assert_eq!(warnings.len(), 1, "0.5 + 0.9 of light is more than there is: {warnings:?}");
    assert!(warnings[0].contains("material 'gloss': torrance-sparrow-gaussian"), "{warnings:?}");
}

#[test]
fn the_format_lists_what_models_declare() {
    let format = include_str!("../SCENE_FORMAT.md");
    let cell = |of: &[&Parameter]| {
        of.iter().map(|parameter| format!("`{}`", parameter.name)).collect::<Vec<_>>().join(", ")
    };
    for model in Model::ALL {
        let name = format!("| `\"{}\"`", model.name());
        let line = format.lines().find(|line| line.starts_with(&name)).unwrap_or_else(|| panic!("{name}"));
        let columns: Vec<_> = line.split('|').map(str::trim).collect();
        assert_eq!((columns[3], columns[4]), (&*cell(model.required()), &*cell(model.optional())), "{name}");
        for parameter in model.parameters() {
            let name = format!("| `{}` |", parameter.name);
            let line =
                format.lines().find(|line| line.starts_with(&name)).unwrap_or_else(|| panic!("{name}"));
            let [least, most] = parameter.range;
            let range =
                if most == f32::MAX { format!("at least {least}") } else { format!("{least} to {most}") };
            assert!(line.contains(&range), "{line} does not say {range}");
        }
    }
}

#[test]
fn mistakes_are_named_with_their_line() {
    for (text, reason) in [
        ("\ngruond = \"plane\"\n", "line 2: unknown field `gruond`"),
        ("ground = \"lawn\"\n", "line 1: unknown variant `lawn`"),
        ("[[model]]\nfile = \"triangle.obj\"\nscael = 2\n", "line 3: unknown field `scael`"),
        ("[[model]]\nscale = 2\n", "line 1: a model has either"),
        ("[[model]]\nfile = \"a.obj\"\nbuiltin = \"column\"\n", "line 1: a model has either"),
        ("[[model]]\nbuiltin = \"cube\"\n", "line 1: there is no built-in scene 'cube'"),
        ("[[model]]\nfile = \"triangle.obj\"\nscale = 0\n", "line 1: scale must not be 0"),
        ("[[model]]\nfile = \"triangle.obj\"\nscale = \"big\"\n", "line 3: "),
        ("[[model]]\nfile = \"triangle.obj\"\ntranslation = [nan, 0, 0]\n", "must be finite"),
        ("[[model]]\nfile = \"triangle.obj\"\nmaterial = \"clay\"\n", "no [material.clay]"),
        ("[[model]]\nfile = \"other.toml\"\n", "cannot place another scene file"),
        ("[[model]]\nfile = \"scene.toml\"\n", "cannot place another scene file"),
        ("[[model]]\nfile = \"absent.obj\"\n", "absent.obj: "),
        ("[camera]\neye = [1, 2, 3]\ntarget = [0, 0, 0]\n", "line 1: missing field `fov`"),
        (
            "[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]\nfov = 40\n",
            "line 1: eye and target are the same point",
        ),
        ("[environment]\nrotation = 3\n", "line 1: an environment has either"),
        ("[environment]\nbuiltin = \"sky\"\nexposure = \"auto\"\n", "line 3: "),
        (
            "[[model]]\nfile = \"triangle.obj\"\nground = true\n",
            "line 1: only a built-in model has a 'ground'",
        ),
        ("[renderer]\n", "line 1: unknown field `renderer`"),
        ("[material.a]\nroughness = 2\n", "line 1: material 'a': roughness must be 0 to 1"),
        (
            "[material.a]\nreflectance = \"phnog\"\n",
            "line 1: material 'a': there is no reflectance 'phnog' (there are: metallic-roughness, lambert,",
        ),
        ("[material.a]\nreflectance = \"phong\"\n", "line 1: material 'a': phong needs 'shininess'"),
        ("[material.a]\nreflectance = \"phong\"\nroughness = 1\n", "'roughness' is no parameter of phong"),
        ("[material.a]\nshininess = 3\n", "'shininess' is no parameter of metallic-roughness"),
        ("[material.a]\nemissive = [1, -1, 0]\n", "line 1: material 'a': emissive must be at least 0"),
        ("\n[[light]]\nradius = 1\n", "line 2: missing field `shape`"),
        ("[[light]]\nshape = \"cone\"\n", "line 2: unknown variant `cone`"),
        ("[[light]]\nshape = \"disk\"\nsize = 1\nradiance = [1, 1, 1]\n", "line 1: a disk has 'radius'"),
        ("[[light]]\nshape = \"sphere\"\nradius = 0\nradiance = [1, 1, 1]\n", "radius must be 0.000001 to"),
        ("[[light]]\nshape = \"sphere\"\nradius = nan\nradiance = [1, 1, 1]\n", "radius must be 0.000001 to"),
        ("[[light]]\nshape = \"square\"\nsize = [1, 1]\nradiance = [1, 1, 1]\n", "a square has 'size', one"),
        ("[[light]]\nshape = \"rectangle\"\nsize = 1\nradiance = [1, 1, 1]\n", "a rectangle has 'size', two"),
        ("[[light]]\nshape = \"rectangle\"\nsize = [1, -1]\nradiance = [1, 1, 1]\n", "size must be"),
        ("[[light]]\nshape = \"sphere\"\nradius = 1\n", "either 'radiance' or 'power'"),
        (
            "[[light]]\nshape = \"sphere\"\nradius = 1\nradiance = [1, -1, 1]\n",
            "radiance must be three finite",
        ),
        (
            "[[light]]\nshape = \"sphere\"\nradius = 1e-5\npower = [1e30, 0, 0]\n",
            "power gives a radiance above",
        ),
        (
            "[[light]]\nshape = \"sphere\"\nradius = 1\nradiance = [1, 1, 1]\nroll = 3\n",
            "a sphere has no 'target'",
        ),
        ("[[light]]\nshape = \"disk\"\nradius = 1\nradiance = [1, 1, 1]\n", "either 'target' or 'direction'"),
        (
            "[[light]]\nshape = \"disk\"\nradius = 1\nradiance = [1, 1, 1]\ntarget = [0, 0, 0]\n",
            "'target' or 'direction' gives no direction",
        ),
        (
            "[[light]]\nshape = \"disk\"\nradius = 1\nradiance = [1, 1, 1]\ntarget = [0, inf, 0]\n",
            "'target' or 'direction' gives no direction",
        ),
        (
            "[[light]]\nshape = \"sphere\"\nradius = 1\nradiance = [1, 1, 1]\nposition = [1e20, 0, 0]\n",
            "lights reach 1.0e20 m",
        ),
        (
            "[[light]]\nshape = \"sphere\"\nradius = 1\nradiance = [1, 1, 1]\nnode = \"cart\"\n",
            "line 1: there is no node 'cart'",
        ),
        ("ground = \n", "line 1: "),
    ] {
        let error = attempt(text).unwrap_err().to_string();
        assert!(error.contains(reason) && !error.contains('\n'), "{text:?}: {error}");
    }
    let not_text = {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, [0xff, 0xfe]).unwrap();
        load(&path, &LoadOptions::default()).unwrap_err().to_string()
    };
    assert!(not_text.contains("UTF-8"));
}

#[test]
fn sections_about_drawing_are_left_to_whoever_draws() {
    #[derive(Debug, Default, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Render {
        shadows: String,
    }
    #[derive(Debug, serde::Deserialize)]
    struct Sections {
        render: Option<Render>,
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let text = "ground = \"plane\"\n[environment]\nbuiltin = \"sky\"\nexposure = \"automatic\"\nprojection = \"equirect\"\n\
        [[model]]\nbuiltin = \"column\"\nground = true\n[render]\nshadows = \"pcf\"\n[animation]\n[[surface]]\n";
    std::fs::write(&path, text).unwrap();
    let loaded = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 440, "with its own ground");
    assert!(loaded.scene.ground.is_some());
    let environment = loaded.environment.unwrap();
    assert_eq!(environment.exposure_ev, None);
    let sections: Sections = read_sections(&path, &FileResolver).unwrap().unwrap();
    assert_eq!(sections.render.unwrap().shadows, "pcf");
    std::fs::write(&path, text.replace("shadows =", "shadow =")).unwrap();
    let error = read_sections::<Sections>(&path, &FileResolver).unwrap_err().to_string();
    assert!(error.contains("line 10: unknown field `shadow`"), "{error}");
    assert!(read_sections::<Sections>(&folder.path().join("scene.glb"), &FileResolver).unwrap().is_none());
}

/// A scene file with a triangle of a material with heights, beside pictures of them.
fn with_heights(heights: &str, texture: &str) -> Result<LoadedScene, SceneFileError> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("bare.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("mapped.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    let gray = image::GrayImage::from_fn(4, 2, |x, _| image::Luma([51 * x as u8]));
    gray.save(folder.path().join("h.png")).unwrap();
    let nan =
        gnomon_picture::RgbImage::from_fn(3, 2, |x, _| Vec3::splat(if x == 1 { f32::NAN } else { 0.0 }));
    gnomon_picture::write(folder.path().join("nan.exr"), &nan).unwrap();
    let path = folder.path().join("scene.toml");
    let text =
        format!("[[model]]\nfile = \"{texture}.obj\"\nmaterial = \"m\"\n[material.m]\nheight = {heights}\n");
    std::fs::write(&path, text).unwrap();
    load(&path, &LoadOptions::default())
}

#[test]
fn heights_of_materials() {
    let scene = with_heights(
        "{ file = \"h.png\", scale = 0.5, tiling = [2, 3], offset = [0.25, 0], wrap = \"mirror\" }",
        "mapped",
    )
    .unwrap()
    .scene;
    let height = scene.materials[0].height.unwrap();
    assert_eq!((height.scale, height.transform(Vec2::ONE)), (0.5, Vec2::new(2.25, 3.0)));
    let map = &scene.height_maps[height.map.0];
    assert_eq!(
        (map.size(), map.texel(1, 0), map.wrap()),
        ([4, 2], 0.2, [gnomon_scene::Wrap::MirroredRepeat; 2])
    );
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // The map lies once along half a metre and a third of one.
    assert!((scene.height_extent(0).unwrap() - Vec2::new(0.5, 1.0 / 3.0)).length() < 1e-6);
    let bare = with_heights("{ file = \"h.png\", scale = 1 }", "bare").unwrap().scene;
    assert!(
        bare.warnings.iter().any(|warning| warning.contains("texture coordinates")),
        "{:?}",
        bare.warnings
    );
    assert_eq!(bare.height_extent(0), None);
}

#[test]
fn heights_that_cannot_be_are_one_clear_error() {
    for (heights, message) in [
        (
            "{ file = \"nan.exr\", scale = 1 }",
            "nan.exr is damaged or invalid: the height in column 1 of row 0 is NaN",
        ),
        ("{ file = \"mapped.obj\", scale = 1 }", "mapped.obj cannot be used: heights are pictures"),
        ("{ file = \"none.png\", scale = 1 }", "cannot read"),
        ("{ file = \"h.png\", scale = inf }", "must be finite"),
        ("{ file = \"h.png\" }", "missing field `scale`"),
        ("{ file = \"h.png\", scale = 1, depth = 2 }", "unknown field `depth`"),
    ] {
        let error = with_heights(heights, "mapped").err().unwrap().to_string();
        assert!(error.contains(message) && !error.contains('\n'), "{heights}: {error}");
    }
}
