#import gbuffer_surface

// The points of a stage, one for every invocation of an indirect dispatch. The importer binds `points: array<ShadingPoint>`,
// `work: array<u32>` and `stage: PointStage`.

// Number of the point of an invocation, `NO_POINT` past the last one.
fn stage_point(workgroup: vec2u, local: u32) -> u32 {
    let words = WORK_STAGES + WORK_STAGE * stage.stage;
    let point = work[words + 4u] + (workgroup.y * work[words] + workgroup.x) * LIGHT_WORKGROUP + local;
    return select(NO_POINT, point, point < work[words + 3u]);
}

fn surface_of(point: u32) -> Surface {
    let sample = unpack_place(points[point].sample);
    return surface_at(sample, depth_at(sample));
}
