// Share of its radiance that a light has in a direction of this cosine with its front.
fn cone_share(cosine: f32, cone: vec2f) -> f32 {
    let share = saturate(cosine * cone.x + cone.y);
    return share * share;
}
