#import types

// Of every pass that draws or reads surfaces. The last one is that of meshes without a material.
@group(GROUP_SURFACE) @binding(0) var<storage, read> materials: array<Material>;
