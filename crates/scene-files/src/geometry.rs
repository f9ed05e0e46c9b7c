//! What every loader does to a mesh before it hands it on: repair, flat normals, tangents.

use glam::{Vec2, Vec3, Vec4};
use gnomon_scene::{LARGEST_COORDINATE, Mesh, MorphTarget, tangents, triangle_normal};

use super::Budget;
use crate::error::Fault;

/// Bytes that one vertex takes at most: position, normal, tangent, two coordinate sets, colour.
pub const VERTEX_BYTES: usize = 12 + 12 + 16 + 2 * 8 + 16;

/// Bytes of one triangle's indices.
pub const TRIANGLE_BYTES: usize = 12;

/// A flat mesh of more triangles shares the vertices of its corners: unshared ones, which have normals of their own, would take five times the
/// memory.
const MOST_UNSHARED: usize = 1 << 20;

/// Makes a mesh as [`Mesh`] promises it. `mesh` has arrays of equal length (or empty ones) and indices in range;
/// `what` names it in warnings. `tangent_set` is the texture coordinate set of the normal map, if there is one.
///
/// - A triangle with a corner that is not finite, or beyond [`LARGEST_COORDINATE`], is dropped with a warning.
/// - Triangles without area stay: they are seen by nobody.
/// - No normals: flat ones, corners unshared; a large mesh that nothing bends stays without any, which means the same. A normal that is zero or not finite: its triangles' mean.
/// - Offsets of morph targets that are no numbers, or beyond [`LARGEST_COORDINATE`], become 0 with a warning. A target
///   brings flat normals where the mesh has them, and none where the mesh is none to add to.
/// - Texture coordinates that are not finite become 0, colours 1; negative colours 0.
pub fn finish(
    mut mesh: Mesh,
    tangent_set: Option<usize>,
    what: &str,
    budget: &mut Budget,
    warnings: &mut Vec<String>,
) -> Result<Mesh, Fault> {
    drop_broken_triangles(&mut mesh, what, warnings);
    repair_targets(&mut mesh, what, warnings);
    for uv in mesh.uvs.iter_mut().flatten().filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
    }
    for color in &mut mesh.colors {
        *color = if color.is_finite() { color.max(Vec4::ZERO) } else { Vec4::ONE };
    }
    let is_plain = tangent_set.is_none() && mesh.targets.is_empty() && mesh.influences.is_empty();
    if mesh.normals.is_empty() && is_plain && mesh.triangles.len() > MOST_UNSHARED {
        mesh.tangents = Vec::new();
        return Ok(mesh);
    }
    if mesh.normals.is_empty() {
        budget.take(mesh.triangles.len(), 3 * (VERTEX_BYTES + deformation_bytes(&mesh)))?;
        mesh = flattened(mesh);
    } else {
        repair_normals(&mut mesh, what, warnings);
    }
    match tangent_set {
        Some(set) if !mesh.uvs[set].is_empty() => {
            let usable = mesh.tangents.iter().all(|t| t.is_finite() && t.truncate().length_squared() > 0.0);
            if mesh.tangents.is_empty() || !usable {
                budget.take(mesh.triangles.len(), 3 * (VERTEX_BYTES + deformation_bytes(&mesh)))?;
                // Offsets from tangents that the file does not give.
                mesh.targets.iter_mut().for_each(|target| target.tangents = Vec::new());
                mesh = tangents::generated(mesh, set);
            } else {
                for tangent in &mut mesh.tangents {
                    let sign = if tangent.w < 0.0 { -1.0 } else { 1.0 };
                    *tangent = tangent.truncate().normalize_or(Vec3::X).extend(sign);
                }
            }
        }
        _ => {
            mesh.tangents = Vec::new();
            mesh.targets.iter_mut().for_each(|target| target.tangents = Vec::new());
        }
    }
    Ok(mesh)
}

/// Bytes that joints and morph targets of one vertex take at most.
fn deformation_bytes(mesh: &Mesh) -> usize {
    let most = mesh.influences.starts.windows(2).map(|pair| (pair[1] - pair[0]) as usize).max();
    36 * mesh.targets.len() + size_of::<(u32, f32)>() * most.unwrap_or(0) + size_of::<u32>()
}

fn repair_targets(mesh: &mut Mesh, what: &str, warnings: &mut Vec<String>) {
    let mut broken = 0;
    for target in &mut mesh.targets {
        for offset in target.positions.iter_mut().chain(&mut target.normals).chain(&mut target.tangents) {
            // False for NaN.
            if !offset.to_array().into_iter().all(|x| x.abs() <= LARGEST_COORDINATE) {
                *offset = Vec3::ZERO;
                broken += 1;
            }
        }
    }
    if broken > 0 {
        warnings.push(format!("{what}: {broken} offsets of morph targets were not finite and are 0"));
    }
}

fn drop_broken_triangles(mesh: &mut Mesh, what: &str, warnings: &mut Vec<String>) {
    // False for NaN.
    let usable = |p: &Vec3| p.abs().max_element() <= LARGEST_COORDINATE && p.is_finite();
    if mesh.positions.iter().all(usable) {
        return;
    }
    let before = mesh.triangles.len();
    let positions = &mesh.positions;
    mesh.triangles.retain(|triangle| triangle.iter().all(|&index| usable(&positions[index as usize])));
    for position in mesh.positions.iter_mut().filter(|p| !usable(p)) {
        *position = Vec3::ZERO;
    }
    let dropped = before - mesh.triangles.len();
    if dropped > 0 {
        warnings.push(format!("{what}: left out {dropped} triangles with corners that are not finite"));
    }
}

/// The mesh with three vertices of its own for every triangle, and the triangle's normal at each.
fn flattened(mesh: Mesh) -> Mesh {
    fn unshared<T: Copy>(values: &[T], triangles: &[[u32; 3]]) -> Vec<T> {
        if values.is_empty() {
            return Vec::new();
        }
        triangles.iter().flatten().map(|&index| values[index as usize]).collect()
    }
    let flat = |positions: &[Vec3]| -> Vec<Vec3> {
        let triangles = positions.chunks_exact(3);
        triangles.flat_map(|c| [triangle_normal([c[0], c[1], c[2]]).unwrap_or(Vec3::Y); 3]).collect()
    };
    let positions = unshared(&mesh.positions, &mesh.triangles);
    let normals = flat(&positions);
    let targets = mesh.targets.iter().map(|target| {
        let offsets = unshared(&target.positions, &mesh.triangles);
        let moved: Vec<Vec3> =
            positions.iter().zip(&offsets).map(|(position, offset)| *position + *offset).collect();
        // Exact for a weight of 0 or 1 (glTF 2.0, section 3.7.2.2, asks for flat normals of the sum).
        let normals = flat(&moved).into_iter().zip(&normals).map(|(moved, normal)| moved - *normal).collect();
        MorphTarget { positions: offsets, normals, tangents: Vec::new() }
    });
    let corners = mesh.triangles.iter().flatten().map(|&index| index as usize);
    Mesh {
        targets: targets.collect(),
        influences: mesh.influences.gathered(corners),
        // The file's tangents belong to normals that it does not give (glTF 2.0, section 3.7.2.1).
        tangents: Vec::new(),
        uvs: mesh.uvs.each_ref().map(|set| unshared(set, &mesh.triangles)),
        colors: unshared(&mesh.colors, &mesh.triangles),
        triangles: (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        material: mesh.material,
        shines: mesh.shines,
        normals,
        positions,
    }
}

fn repair_normals(mesh: &mut Mesh, what: &str, warnings: &mut Vec<String>) {
    let mut broken = Vec::new();
    for (index, normal) in mesh.normals.iter_mut().enumerate() {
        match normal.as_dvec3().try_normalize() {
            Some(unit) => *normal = unit.as_vec3(),
            None => broken.push(index),
        }
    }
    if broken.is_empty() {
        return;
    }
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|index| mesh.positions[index as usize]);
        if let Some(normal) = triangle_normal(corners) {
            for &index in triangle {
                sums[index as usize] += normal;
            }
        }
    }
    for &index in &broken {
        mesh.normals[index] = sums[index].try_normalize().unwrap_or(Vec3::Y);
    }
    warnings.push(format!("{what}: {} normals were zero or not finite and were made anew", broken.len()));
}
