#import stage_points
#import stored_sums

// What passes that sum light at the points of a stage read and write.

@group(GROUP_PASS) @binding(0) var<storage, read> points: array<ShadingPoint>;
@group(GROUP_PASS) @binding(1) var<storage, read> work: array<u32>;
@group(GROUP_PASS) @binding(2) var<storage, read_write> diffuse_sums: array<vec4u>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> specular_sums: array<u32>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> near_sums: array<u32>;
@group(GROUP_PASS) @binding(5) var<uniform> stage: PointStage;
