#import types

// Group 0 of every pass over the screen.

@group(0) @binding(0) var<uniform> view: View;
// Uniform, because every sample of the picture reads the same light at a time.
@group(0) @binding(1) var<uniform> lights: array<Light, MAX_BATCH_LIGHTS>;
// The whole environment as the camera sees it.
@group(0) @binding(2) var background: texture_2d<f32>;
// Irradiance of the whole environment over the sphere of normals.
@group(0) @binding(3) var irradiance_full: texture_2d<f32>;
// GGX-prefiltered radiance, roughness rising linearly over the mip levels: whole environment, residual.
@group(0) @binding(4) var prefiltered_full: texture_2d<f32>;
@group(0) @binding(5) var prefiltered_residual: texture_2d<f32>;
// Scale and bias of f0 in the environment BRDF (Karis 2013) over (n.v, roughness).
@group(0) @binding(6) var dfg_table: texture_2d<f32>;
@group(0) @binding(7) var<uniform> batch: Batch;
