//! Files to start from: small ones of the external data, and a few made here, so that there are always some.

use std::path::{Path, PathBuf};

use glam::Vec3;
use gnomon_picture::{RgbImage, exr, ldr};

use crate::Target;

/// Folders of the external data that hold files of the formats.
const FOLDERS: [&str; 6] = ["field", "bad_inputs", "scenes", "models", "env", "brdf"];
/// Longest file to start from [bytes]: damage is found faster in short ones.
const LONGEST: u64 = 1 << 16;
/// Most files of the data for one target.
const MOST: usize = 400;

/// Files for a target.
pub fn seeds(target: &Target) -> Vec<Vec<u8>> {
    let mut seeds = made(target.extensions);
    if let Some(data) = gnomon_testing::data_dir() {
        let mut found = Vec::new();
        for folder in FOLDERS {
            walk(&data.join(folder), target.extensions, &mut found);
        }
        found.sort();
        // Evenly spread, so that each folder has its share.
        let step = found.len().div_ceil(MOST).max(1);
        seeds.extend(found.iter().step_by(step).filter_map(|path| std::fs::read(path).ok()));
    }
    seeds
}

fn walk(folder: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let Ok(metadata) = entry.metadata() else { continue };
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        if metadata.is_dir() {
            walk(&path, extensions, found);
        } else if metadata.len() <= LONGEST
            && extension.is_some_and(|extension| extensions.contains(&extension.as_str()))
        {
            found.push(path);
        }
    }
}

fn picture() -> RgbImage {
    RgbImage::from_fn(16, 8, |x, y| Vec3::new(x as f32, y as f32, 0.5))
}

/// A small PNG.
pub fn small_png() -> Vec<u8> {
    ldr::encode_png(&picture()).unwrap_or_default()
}

/// A measurement of the RGL of two views, 2 x 2 values each.
fn small_bsdf() -> Vec<u8> {
    let tensors: [(&str, &[u64], usize); 6] = [
        ("phi_i", &[1], 1),
        ("theta_i", &[2], 2),
        ("ndf", &[2, 2], 4),
        ("sigma", &[2, 2], 4),
        ("vndf", &[1, 2, 2, 2], 8),
        ("rgb", &[1, 2, 3, 2, 2], 24),
    ];
    let mut bytes = b"tensor_file\0\x01\0".to_vec();
    bytes.extend(7_u32.to_le_bytes());
    let text = b"made";
    let of_list = |name: &str, dimensions: usize| 2 + name.len() + 2 + 1 + 8 + 8 * dimensions;
    let list: usize = tensors.iter().map(|(name, shape, _)| of_list(name, shape.len())).sum();
    let mut at = bytes.len() + list + of_list("description", 1);
    let mut add = |bytes: &mut Vec<u8>, name: &str, kind: u8, shape: &[u64], size: usize| {
        bytes.extend((name.len() as u16).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.extend((shape.len() as u16).to_le_bytes());
        bytes.push(kind);
        bytes.extend((at as u64).to_le_bytes());
        shape.iter().for_each(|side| bytes.extend(side.to_le_bytes()));
        at += size;
    };
    add(&mut bytes, "description", 1, &[text.len() as u64], text.len());
    tensors.iter().for_each(|(name, shape, count)| add(&mut bytes, name, 10, shape, 4 * count));
    bytes.extend(text);
    for (_, _, count) in tensors {
        (0..count).for_each(|i| bytes.extend((0.5 * i as f32 + 0.1).to_le_bytes()));
    }
    bytes
}

/// Small sound files of these formats.
fn made(extensions: &[&str]) -> Vec<Vec<u8>> {
    let one = |extension: &&str| {
        match *extension {
        "exr" => exr::encode(&picture()).ok(),
        "png" => Some(small_png()),
        "hdr" => {
            let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n-Y 4 +X 8\n".to_vec();
            (0..4_u8).for_each(|row| {
                bytes.extend([2, 2, 0, 8]);
                // Four planes: a run, values, a run, values.
                (0..4_u8).for_each(|plane| bytes.extend([132, 100 + row + plane, 4, 1, 2, 3, 128]));
            });
            Some(bytes)
        }
        "obj" => Some(b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 3/1/1 4/1/1\n".to_vec()),
        "mtl" => Some(b"newmtl a\nKd 0.5 0.5 0.5\nKs 0.1 0.1 0.1\nNs 20\nmap_Kd -s 2 2 1 a.png\nd 0.5\n".to_vec()),
        "ply" => Some(b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_vec()),
        "gltf" => Some(br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"a.bin"}]}"#.to_vec()),
        "toml" => Some(b"[environment]\nbuiltin = \"sky\"\n\n[[model]]\nfile = \"a.obj\"\n\n[camera]\neye = [0, 1, 3]\ntarget = [0, 0, 0]\nfov = 50\n\n[[light]]\nshape = \"disk\"\n".to_vec()),
        "ies" => Some(
            b"IESNA:LM-63-2002\nTILT=NONE\n1 1000 2 4 2 1 2 0.1 0.1 0\n1 1 10\n0 30 60 90\n0 180\n50 32 6 0\n50 33 6.5 0\n".to_vec(),
        ),
        "bsdf" => Some(small_bsdf()),
        "tables" => Some(br#"{"gnomon_tables":1,"terms":[{"tint":"color","factors":[{"coordinates":"half","scale":0.1,"columns":2,"values":[1,1,1,0,0,0]}]}]}"#.to_vec()),
        _ => None,
    }
    };
    extensions.iter().filter_map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{target, targets};

    #[test]
    fn every_reader_takes_what_there_is_to_start_from() {
        for target in targets() {
            made(target.extensions).iter().for_each(|bytes| target.run(bytes));
            target.run(b"");
        }
        let picture = target("hdr").unwrap();
        let seed = &made(picture.extensions)[0];
        assert!(gnomon_picture::decode(seed).is_ok());
    }
}
