#import types

// Where the marks of a light lie (`silhouettes.wgsl`). The importer binds `counts: SilhouetteCounts`, and `marks`.

// Of the triangles that face it.
fn triangle_word(triangle: u32, light: u32) -> u32 {
    return triangle * counts.words + light / 32u;
}

// Of the edges of its silhouettes.
fn edge_word(edge: u32, light: u32) -> u32 {
    return (counts.triangles + edge) * counts.words + light / 32u;
}

// Of the nodes around such edges.
fn node_word(node: u32, light: u32) -> u32 {
    return (counts.triangles + counts.edges + node - counts.first_marked) * counts.words + light / 32u;
}
