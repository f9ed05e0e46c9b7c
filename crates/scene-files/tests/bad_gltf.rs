//! Damaged and odd glTF files: each loads or ends in one line, in time and without a panic.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gnomon_scene_files::{LoadOptions, LoadedScene, SceneFileError, load};
use gnomon_testing::data_file;

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else {
            found.push(path);
        }
    }
    found.sort();
}

fn attempt(path: &Path) -> Result<LoadedScene, SceneFileError> {
    let start = Instant::now();
    let result = load(path, &LoadOptions::default());
    assert!(start.elapsed() < Duration::from_secs(10), "{} took {:?}", path.display(), start.elapsed());
    if let Err(error) = &result {
        let line = error.to_string();
        assert!(!line.contains('\n') && line.len() < 1_000, "not one line: {line}");
        assert!(
            line.contains(path.file_name().unwrap().to_str().unwrap())
                || matches!(error, SceneFileError::Io { .. })
        );
    }
    result
}

#[test]
fn every_bad_file_ends_well() {
    let Some(folder) = data_file("bad_inputs/gltf") else { return };
    let mut all = Vec::new();
    files(&folder, &mut all);
    all.retain(|path| !path.to_str().unwrap().ends_with(".report.json"));
    assert_eq!(all.len(), 267, "not the set of files that this test was written for");
    let (mut loaded, mut refused) = (0, 0);
    for path in &all {
        match attempt(path) {
            Ok(_) => loaded += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(loaded > 80 && refused > 80, "{loaded} loaded, {refused} refused");
}

/// Reports of the Khronos validator: file, errors, triangles.
fn reports() -> Option<Vec<(PathBuf, u64, u64)>> {
    let folder = data_file("bad_inputs/gltf/validator_data")?;
    let mut all = Vec::new();
    files(&folder, &mut all);
    let report = |path: &PathBuf| {
        let name = path.to_str()?.strip_suffix(".report.json")?;
        let report: serde_json::Value = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
        let triangles = report["info"]["totalTriangleCount"].as_u64().unwrap_or(0);
        Some((PathBuf::from(name), report["issues"]["numErrors"].as_u64()?, triangles))
    };
    Some(all.iter().filter_map(report).collect())
}

#[test]
fn what_the_validator_passes_loads_with_its_triangles() {
    let Some(reports) = reports() else { return };
    let passed: Vec<_> = reports.iter().filter(|(_, errors, _)| *errors == 0).collect();
    assert!(passed.len() > 30);
    let mut wrong = Vec::new();
    for (path, _, triangles) in passed {
        let result = attempt(path);
        // Valid, but not for us: nothing is fetched from a network, 2.1 is not known, and the data is nowhere.
        let refused = [
            ("buffer/non_relative_uri.gltf", "http://example.com"),
            ("asset/min_version_valid.gltf", "needs glTF 2.1"),
            ("root/unused_objects.gltf", "buffer 0 has no data"),
        ];
        if let Some((_, reason)) = refused.iter().find(|(name, _)| path.ends_with(name)) {
            let error = result.unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
            continue;
        }
        let loaded = result.unwrap_or_else(|error| panic!("{error}"));
        // The report counts meshes that no node places, too; those are not shown.
        let document: serde_json::Value =
            match std::fs::read(path).ok().and_then(|b| serde_json::from_slice(&b).ok()) {
                Some(document) => document,
                None => continue,
            };
        let list = |key: &str| document[key].as_array().cloned().unwrap_or_default();
        let all_placed = list("nodes").is_empty()
            || (0..list("meshes").len()).all(|mesh| list("nodes").iter().any(|node| node["mesh"] == mesh));
        let found: usize = loaded.scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        if all_placed && found as u64 != *triangles {
            wrong.push(format!("{}: {found} of {triangles}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn what_cannot_be_drawn_rightly_is_refused_with_the_reason() {
    let refused = [
        ("validator_data/node/node_loop.gltf", "loop"),
        ("validator_data/node/node_loop_scene.gltf", "child of both"),
        ("validator_data/node/node_parent_override.gltf", "child of both"),
        ("validator_data/node/infinite_transform.gltf", "number out of range"),
        ("validator_data/scene/unresolved_node.gltf", "refers to node"),
        ("validator_data/scene/unresolved_child_node.gltf", "refers to node"),
        ("validator_data/scene/unresolved_default_scene.gltf", "refers to scene"),
        ("validator_data/asset/1_0_version.gltf", "glTF version 1.0"),
        ("validator_data/asset/invalid_version.gltf", "is no glTF version"),
        ("validator_data/asset/empty_array.gltf", "asset.version is missing"),
        ("validator_data/buffer/not_found.gltf", "cannot read"),
        ("validator_data/glb/empty_file.glb", ""),
        ("validator_data/glb/chunk_too_big.glb", ""),
        ("validator_data/glb/invalid_magic.glb", ""),
        ("validator_data/glb/invalid_version.glb", "GLB version"),
        ("validator_data/glb/truncated_chunk_data.glb", ""),
        ("validator_data/glb/invalid_json_chunk.glb", ""),
        ("validator_data/json/invalid_syntax.gltf", "no JSON: "),
        ("validator_data/json/invalid_object.gltf", ""),
        ("validator_data/material/unresolved_mr.gltf", "refers to texture"),
        ("validator_data/material/unresolved_normal.gltf", "refers to texture"),
        ("validator_data/mesh/accessor_unequal_count.gltf", "elements, not"),
        ("validator_data/mesh/indices_invalid_format.gltf", "unsigned integers"),
        ("validator_data/mesh/unresolved_indices.gltf", "refers to accessor"),
        ("validator_data/mesh/unresolved_material.gltf", "refers to material"),
        ("validator_data/mesh/unresolved_positions.gltf", "refers to accessor"),
        ("validator_data/mesh/position_accessor_invalid_format.gltf", ""),
        ("validator_data/node/unresolved_camera.gltf", "refers to camera"),
        ("tinygltf/invalid-buffer-index.gltf", ""),
        ("assimp/IndexOutOfRange/IndexOutOfRange.gltf", "refers to vertex"),
        ("assimp/IndexOutOfRange/AllIndicesOutOfRange.gltf", "refers to vertex"),
        ("assimp/wrongTypes/badArray.gltf", ""),
        ("assimp/wrongTypes/badString.gltf", ""),
    ];
    let mut wrong = Vec::new();
    for (name, reason) in refused {
        let Some(path) = data_file(&format!("bad_inputs/gltf/{name}")) else { return };
        match attempt(&path) {
            Ok(loaded) => wrong.push(format!("{name} loads ({:?})", loaded.scene.warnings)),
            Err(error) if !error.to_string().contains(reason) => wrong.push(format!("{name}: {error}")),
            Err(_) => {}
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn what_only_looks_odd_loads() {
    for (name, triangles) in [
        // Its picture is missing.
        ("asset_generator/Positive/Instancing/Instancing_01.gltf", 4),
        ("asset_generator/Positive/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf", 0),
        ("asset_generator/Positive/Mesh_PrimitiveMode/Mesh_PrimitiveMode_04.gltf", 2),
        ("asset_generator/Positive/Mesh_PrimitiveMode/Mesh_PrimitiveMode_05.gltf", 2),
        ("asset_generator/Positive/Mesh_PrimitiveMode/Mesh_PrimitiveMode_06.gltf", 2),
        ("asset_generator/Positive/Mesh_PrimitiveMode/Mesh_PrimitiveMode_13.gltf", 2),
        ("asset_generator/Negative/Mesh_NoPosition/Mesh_NoPosition_00.gltf", 0),
        ("real_world/CesiumMan_2018_unnormalised_weights.glb", 4_672),
        ("validator_data/glb/bom.glb", 0),
        // As Unity's exporter writes scenes.
        ("validator_data/scene/non_root_node.gltf", 0),
        ("validator_data/json/bom.gltf", 0),
    ] {
        let Some(path) = data_file(&format!("bad_inputs/gltf/{name}")) else { return };
        let loaded = attempt(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.scene.triangle_count(), triangles, "{name}: {:?}", loaded.scene.warnings);
    }
}
