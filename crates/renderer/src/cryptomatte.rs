//! Cryptomatte: which shares of a pixel show what, under hashes of names that compositing programs pick from (Friedman and Jones 2015;
//! specification 1.2.0).

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec2;
use gnomon_scene::{Camera, Node, Scene};

/// Samples along a pixel's side.
const SIDE: u32 = 4;
/// What covers a pixel most, so many of it; two to four channels of a file.
const RANKS: usize = 6;

/// Channels of a matte: the layer's name and a number, and in each a hash and its share twice.
macro_rules! channels {
    ($name:literal) => {
        &[
            concat!($name, "00.R"),
            concat!($name, "00.G"),
            concat!($name, "00.B"),
            concat!($name, "00.A"),
            concat!($name, "01.R"),
            concat!($name, "01.G"),
            concat!($name, "01.B"),
            concat!($name, "01.A"),
            concat!($name, "02.R"),
            concat!($name, "02.G"),
            concat!($name, "02.B"),
            concat!($name, "02.A"),
        ]
    };
}

pub(crate) const OBJECT_CHANNELS: &[&str] = channels!("CryptoObject");
pub(crate) const MATERIAL_CHANNELS: &[&str] = channels!("CryptoMaterial");

/// Names of what labels count from 1, each once; empty for what is never seen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Labels {
    pub objects: Vec<String>,
    pub materials: Vec<String>,
}

impl Labels {
    /// Of a scene's nodes that place meshes and of its materials, the default one last.
    pub fn of(scene: &Scene) -> Self {
        let node = |node: &Node| (!node.meshes.is_empty()).then(|| node.name.clone());
        let nodes: Vec<_> = scene.nodes.iter().map(node).collect();
        let default = Some("default".to_owned());
        let materials: Vec<_> =
            scene.materials.iter().map(|material| Some(material.name.clone())).chain([default]).collect();
        Self { objects: unique("object", &nodes), materials: unique("material", &materials) }
    }
}

/// The same names. The first with a name keeps it, so that what comes later in a file changes none; others have the next free number behind it.
fn unique(what: &str, names: &[Option<String>]) -> Vec<String> {
    let mut taken: BTreeSet<String> = names.iter().flatten().cloned().collect();
    let (mut kept, mut numbers) = (BTreeSet::new(), BTreeMap::new());
    let mut unique = Vec::with_capacity(names.len());
    for name in names {
        unique.push(match name.as_deref() {
            None => String::new(),
            Some(name) if !name.is_empty() && kept.insert(name) => name.to_owned(),
            Some(name) => {
                let stem = if name.is_empty() { what } else { name };
                let number = numbers.entry(stem).or_insert(0_usize);
                loop {
                    *number += 1;
                    let numbered = format!("{stem}_{number}");
                    if taken.insert(numbered.clone()) {
                        break numbered;
                    }
                }
            }
        });
    }
    unique
}

/// Cameras whose pixels' middles are the samples of the pixels of this one.
pub(crate) fn sample_cameras(camera: &Camera, width: u32) -> impl Iterator<Item = Camera> {
    (0..SIDE * SIDE).map(move |i| {
        let place = (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32 - 0.5;
        let mut moved = camera.clone();
        moved.film.shift += place * Vec2::new(1.0, camera.film.pixel_aspect) / width as f32;
        moved
    })
}

/// A name as a float's bits, none of which is infinite, no number or denormal ("uint32_to_float32").
fn float_of(name: &str) -> f32 {
    let hash = murmur3(name.as_bytes());
    let exponent = hash >> 23 & 255;
    f32::from_bits(if exponent == 0 || exponent == 255 { hash ^ 1 << 23 } else { hash })
}

/// MurmurHash3_x86_32 (Appleby), seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let scrambled = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
    let chunks = bytes.chunks_exact(4);
    let rest = chunks.remainder();
    let mut hash = chunks.fold(0_u32, |hash, chunk| {
        (hash ^ scrambled(word(chunk))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    if !rest.is_empty() {
        hash ^= scrambled(word(rest));
    }
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

/// Texts of a file's header, by their names.
pub(crate) fn attributes(channels: &[&str], names: &[String]) -> Vec<(String, String)> {
    let layer = channels.first().map_or("", |channel| channel.trim_end_matches("00.R"));
    let hex = |hash: u32| format!("{hash:08x}");
    let seen = names.iter().filter(|name| !name.is_empty());
    let manifest: serde_json::Map<String, serde_json::Value> =
        seen.map(|name| (name.clone(), hex(float_of(name).to_bits()).into())).collect();
    let key = &hex(murmur3(layer.as_bytes()))[..7];
    [
        ("name", layer.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", serde_json::Value::Object(manifest).to_string()),
    ]
    .map(|(what, text)| (format!("cryptomatte/{key}/{what}"), text))
    .to_vec()
}

/// Values of the channels of pixels, by what their samples show: a list of labels for each sample.
pub(crate) fn mattes(samples: &[Vec<u32>], names: &[String]) -> Vec<f32> {
    let floats: Vec<f32> = names.iter().map(|name| float_of(name)).collect();
    let pixels = samples.first().map_or(0, Vec::len);
    (0..pixels)
        .flat_map(|pixel| {
            let mut counts = BTreeMap::new();
            for label in samples.iter().map(|sample| sample[pixel]).filter(|&label| label > 0) {
                *counts.entry(label).or_insert(0) += 1;
            }
            let mut ranked: Vec<(u32, u32)> = counts.into_iter().collect();
            ranked.sort_by_key(|&(label, count)| (std::cmp::Reverse(count), label));
            let value = |&(label, count): &(u32, u32)| {
                let float = floats.get(label as usize - 1).copied().unwrap_or(0.0);
                [float, count as f32 / samples.len() as f32]
            };
            let mut ranks = [[0.0; 2]; RANKS];
            ranks.iter_mut().zip(&ranked).for_each(|(rank, found)| *rank = value(found));
            ranks.into_iter().flatten()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use gnomon_scene::{Material, MaterialId, Mesh};

    /// Of the specification's text, and of the hash's own vectors.
    #[test]
    fn hashes_are_those_of_the_specification() {
        assert_eq!(murmur3(b""), 0);
        assert_eq!(murmur3(b"hello"), 0x248b_fa47);
        assert_eq!(murmur3(b"The quick brown fox jumps over the lazy dog"), 0x2e4f_f723);
        let published = [
            ("hello", 6.070_562_7e-17_f64),
            ("cube", -4.084_619_1e15),
            ("sphere", 2.790_186e15),
            ("plane", 3.665_576_2e-11),
        ];
        for (name, float) in published {
            assert!((f64::from(float_of(name)) / float - 1.0).abs() < 1e-6, "{name}: {}", float_of(name));
        }
    }

    #[test]
    fn shares_are_ranked_and_names_are_unique() {
        let names = ["box", "", "box", "ball"].map(|name| Some(name.to_owned()));
        let names = unique("object", &names);
        assert_eq!(names, ["box", "object_1", "box_1", "ball"]);
        let samples = [vec![4, 0], vec![1, 0], vec![4, 2], vec![4, 2]];
        let values = mattes(&samples, &names);
        assert_eq!(values.len(), 2 * OBJECT_CHANNELS.len());
        assert_eq!(values[..4], [float_of("ball"), 0.75, float_of("box"), 0.25]);
        assert_eq!(values[12..16], [float_of("object_1"), 0.5, 0.0, 0.0]);
    }

    #[test]
    fn no_number_makes_a_name_that_another_has() {
        let names = |names: &[&str]| {
            unique("object", &names.iter().map(|name| Some((*name).to_owned())).collect::<Vec<_>>())
        };
        assert_eq!(names(&["box", "box", "box_1"]), ["box", "box_2", "box_1"]);
        assert_eq!(
            names(&["", "object_1", "object", "", "object"]),
            ["object_2", "object_1", "object", "object_3", "object_4"]
        );
        assert_eq!(unique("object", &[None, Some("box".to_owned())]), ["", "box"]);
    }

    #[test]
    fn lights_of_emission_change_no_name() {
        let material =
            |name: &str, emissive| Material { name: name.to_owned(), emissive, ..Material::default() };
        let mut scene = Scene {
            materials: vec![material("grey", Vec3::ZERO), material("lamp", Vec3::ONE)],
            ..Scene::default()
        };
        for (name, material) in [("emission", 0), ("panel", 1)] {
            let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
            let mesh = Mesh { positions: corners, triangles: vec![[0, 1, 2]], ..Mesh::default() };
            scene.push_mesh(name, Mesh { material: Some(MaterialId(material)), ..mesh });
        }
        let seen = Labels::of(&scene);
        scene.light_emission();
        let lit = Labels::of(&scene);
        assert_eq!(scene.lights.len(), 1);
        assert_eq!(seen.objects, ["emission", "panel"]);
        assert_eq!(lit.objects, ["emission", "panel", ""]);
        assert_eq!((&seen.materials, lit.materials.len()), (&lit.materials, 3));
    }

    #[test]
    fn the_manifest_tells_what_hash_stands_for_what_name() {
        let texts = attributes(OBJECT_CHANNELS, &["hello".to_owned(), "a \"name\"".to_owned()]);
        let (key, _) = texts[0].0.rsplit_once('/').unwrap();
        assert!(key.len() == "cryptomatte/".len() + 7 && texts[0].1 == "CryptoObject", "{texts:?}");
        let manifest: serde_json::Value = serde_json::from_str(&texts[3].1).unwrap();
        assert_eq!(manifest["hello"], "248bfa47");
        assert_eq!(manifest.as_object().unwrap().len(), 2);
    }
}
