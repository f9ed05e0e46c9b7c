// Edges between the triangles that rays meet. The first word of an edge is four times its first triangle plus the corner from which it runs to the
// next; the second one four times its second triangle, plus 1 where it runs in the sense of that one, too, or `NO_WING`. The importer binds
// `ray_triangles`.

// Slab tests round: boxes a little larger than what they hold make them safe.
const BOX_PADDING: f32 = 5e-7;

fn ray_corner(triangle: u32, corner: u32) -> vec3f {
    return bitcast<vec3f>(ray_triangles[3u * triangle + corner].xyz);
}

// Where an edge begins and where it ends.
fn edge_ends(first_wing: u32) -> array<vec3f, 2> {
    let triangle = first_wing / 4u;
    let corner = first_wing % 4u;
    return array(ray_corner(triangle, corner), ray_corner(triangle, (corner + 1u) % 3u));
}
