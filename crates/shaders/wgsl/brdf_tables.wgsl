#import types
#import brdf_lobe
#import sample_pattern

// Reflectances that are sums of products of tables: `gnomon_brdf::tables`, functions of the same names. `lobe.shape` is the number of the tables.

@group(GROUP_SURFACE) @binding(4) var<uniform> table_sets: array<TableSet, MAX_TABLE_SETS>;
@group(GROUP_SURFACE) @binding(5) var<uniform> table_factors: array<TableFactor, MAX_TABLE_FACTORS>;
@group(GROUP_SURFACE) @binding(6) var table_texels: texture_2d_array<f32>;

const QUARTER: f32 = 1.5707963;

fn spread_place(argument: f32, scale: f32) -> f32 {
    return select(argument, argument * (1.0 + scale) / max(argument + scale, 1e-30), scale > 0.0);
}

fn unspread_place(place: f32, scale: f32) -> f32 {
    return select(place, scale * place / max(1.0 + scale - place, 1e-30), scale > 0.0);
}

fn table_texel(layer: u32, row: u32, column: u32) -> vec3f {
    return textureLoad(table_texels, vec2u(column, row), layer, 0).rgb;
}

// Interpolated at x and y from 0 to 1. Where it is periodic, the first row follows after the last one.
fn table_at(layer: u32, first_row: u32, size: vec2u, at: vec2f, periodic: bool) -> vec3f {
    let x = saturate(at.x) * f32(size.x - 1u);
    let y = saturate(at.y) * f32(select(size.y - 1u, size.y, periodic));
    let left = min(u32(x), size.x - 1u);
    let right = min(left + 1u, size.x - 1u);
    let low = min(u32(y), size.y - 1u);
    let high = select(select(low, 0u, periodic), low + 1u, low + 1u < size.y);
    let along = x - f32(left);
    let lower = mix(table_texel(layer, first_row + low, left), table_texel(layer, first_row + low, right), along);
    if high == low {
        return lower;
    }
    let upper = mix(table_texel(layer, first_row + high, left), table_texel(layer, first_row + high, right), along);
    return mix(lower, upper, y - f32(low));
}

// Part of a quarter turn that the angle of a cosine is.
fn quarters(cosine: f32) -> f32 {
    let c = clamp(cosine, 0.0, 1.0);
    return atan2(sqrt((1.0 - c) * (1.0 + c)), c) / QUARTER;
}

fn quadrant(v: vec3f) -> f32 {
    return select(atan2(abs(v.y), abs(v.x)) / QUARTER, 0.0, v.x == 0.0 && v.y == 0.0);
}

// Angle of a vector in parts of a turn of so many radians, in [0, 1]; 0 of no vector.
fn wrapped_angle(y: f32, x: f32, turn: f32) -> f32 {
    return select(fract(atan2(y, x) / turn), 0.0, x == 0.0 && y == 0.0);
}

// Azimuth of the light in the frame that the rotation of the half vector to the normal brings along, half a turn of it.
fn azimuth_about(h: vec3f, wi: vec3f) -> f32 {
    let sine = length(h.xy);
    let direction = select(vec2f(1.0, 0.0), h.xy / max(sine, 1e-30), sine > 1e-6);
    let along = dot(direction, wi.xy);
    return wrapped_angle(direction.x * wi.y - direction.y * wi.x, h.z * along - sine * wi.z, PI);
}

fn table_arguments(factor: TableFactor, wo: vec3f, wi: vec3f, h: vec3f) -> vec2f {
    let delta = select(atan2(length(h.xy), h.z) / QUARTER, 0.0, h.x == 0.0 && h.y == 0.0 && h.z >= 0.0);
    switch factor.coordinates {
        case TABLE_HALF: {
            return vec2f(delta, wrapped_angle(h.y, h.x, TAU));
        }
        case TABLE_HALF_QUADRANT: {
            return vec2f(delta, quadrant(vec3f(h.x, factor.parameters.x * h.y, h.z)));
        }
        case TABLE_HALF_AND_DIFFERENCE: {
            return vec2f(delta, quarters(dot(wo, h)));
        }
        case TABLE_COSINES: {
            return saturate(vec2f(wi.z, wo.z));
        }
        case TABLE_DIFFERENCE: {
            return vec2f(quarters(dot(wo, h)), azimuth_about(h, wi));
        }
        case TABLE_LIGHT: {
            return vec2f(saturate(wi.z), quadrant(wi));
        }
        case TABLE_VIEW: {
            return vec2f(saturate(wo.z), quadrant(wo));
        }
        case TABLE_TANGENT: {
            return 0.5 + asin(clamp(vec2f(wi.x, wo.x), vec2f(-1.0), vec2f(1.0))) / PI;
        }
        default: {
            let axes = factor.parameters;
            return vec2f(quarters(dot(axes * wo, wi) / max(max_component(abs(axes)), 1e-6)), 0.0);
        }
    }
}

fn turned(v: vec3f, angle: f32) -> vec3f {
    let s = sin(angle);
    let c = cos(angle);
    return vec3f(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
}

fn tables_lobe(lobe: Lobe, wo: vec3f, wi: vec3f) -> vec3f {
    let tables = table_sets[u32(lobe.shape)];
    let own_wo = turned(wo, -tables.turn);
    let own_wi = turned(wi, -tables.turn);
    let h = half_vector(own_wo, own_wi);
    var sum = vec3f(0.0);
    var product = vec3f(0.0);
    for (var i = tables.first_factor; i < tables.end_factor; i++) {
        let factor = table_factors[i];
        let arguments = table_arguments(factor, own_wo, own_wi, h);
        let second = select(0.0, factor.scale, factor.coordinates == TABLE_COSINES);
        let at = vec2f(spread_place(arguments.x, factor.scale), spread_place(arguments.y, second));
        let size = vec2u(factor.columns, factor.rows);
        let value = table_at(factor.layer, factor.first_row, size, at, factor.periodic != 0u);
        if factor.tint == TABLE_MULTIPLIES {
            product *= value;
        } else {
            sum += product;
            product = value * select(lobe.tint.rgb, vec3f(lobe.tint.w), factor.tint == TABLE_GRAZING);
        }
    }
    return max(sum + product, vec3f(0.0));
}

// sin^2(delta / 2) of a column's lower border.
fn proposal_border(tables: TableSet, column: u32) -> f32 {
    let s = sin(0.5 * QUARTER * unspread_place(f32(column) / f32(tables.proposal_columns), tables.proposal_scale));
    return s * s;
}

// A half vector for `u` in the unit square, in the tables' frame.
fn proposal_sample(tables: TableSet, u: vec2f) -> vec3f {
    // The first column whose share exceeds u.x, then the first row there whose share exceeds u.y.
    var column = 0u;
    var end = tables.proposal_columns - 1u;
    while column < end {
        let middle = (column + end) / 2u;
        if table_texel(tables.proposal_layer, tables.proposal_row, middle).z > u.x {
            end = middle;
        } else {
            column = middle + 1u;
        }
    }
    var row = 0u;
    end = tables.proposal_rows - 1u;
    while row < end {
        let middle = (row + end) / 2u;
        if table_texel(tables.proposal_layer, tables.proposal_row + middle, column).x > u.y {
            end = middle;
        } else {
            row = middle + 1u;
        }
    }
    var below = 0.0;
    if column > 0u {
        below = table_texel(tables.proposal_layer, tables.proposal_row, column - 1u).z;
    }
    var before = 0.0;
    if row > 0u {
        before = table_texel(tables.proposal_layer, tables.proposal_row + row - 1u, column).x;
    }
    let cell = table_texel(tables.proposal_layer, tables.proposal_row + row, column);
    let along = (u.x - below) / max(cell.z - below, 1e-12);
    let around = (u.y - before) / max(cell.x - before, 1e-12);
    let low = proposal_border(tables, column);
    let half_sine2 = low + (proposal_border(tables, column + 1u) - low) * along;
    let azimuth = TAU * (f32(row) + around) / f32(tables.proposal_rows);
    let sine = 2.0 * sqrt(max(half_sine2 * (1.0 - half_sine2), 0.0));
    return vec3f(sine * cos(azimuth), sine * sin(azimuth), 1.0 - 2.0 * half_sine2);
}

// Density of it at a half vector above the surface, 1 / sr.
fn proposal_density(tables: TableSet, h: vec3f) -> f32 {
    let is_pole = h.x == 0.0 && h.y == 0.0;
    let delta = select(atan2(length(h.xy), h.z) / QUARTER, 0.0, is_pole);
    let column = min(u32(spread_place(delta, tables.proposal_scale) * f32(tables.proposal_columns)), tables.proposal_columns - 1u);
    let row = min(u32(wrapped_angle(h.y, h.x, TAU) * f32(tables.proposal_rows)), tables.proposal_rows - 1u);
    return table_texel(tables.proposal_layer, tables.proposal_row + row, column).y;
}

fn tables_sample(lobe: Lobe, wo: vec3f, u: vec2f) -> vec3f {
    if u.x >= TABLE_PROPOSAL_SHARE {
        let rest = min((u.x - TABLE_PROPOSAL_SHARE) / (1.0 - TABLE_PROPOSAL_SHARE), 1.0 - 1.1920929e-7);
        let r = sqrt(rest);
        return vec3f(r * cos(TAU * u.y), r * sin(TAU * u.y), sqrt(max(1.0 - rest, 0.0)));
    }
    let tables = table_sets[u32(lobe.shape)];
    let h = turned(proposal_sample(tables, vec2f(u.x / TABLE_PROPOSAL_SHARE, u.y)), tables.turn);
    return 2.0 * dot(h, wo) * h - wo;
}

fn tables_pdf(lobe: Lobe, wo: vec3f, wi: vec3f) -> f32 {
    let tables = table_sets[u32(lobe.shape)];
    let h = half_vector(wo, wi);
    let v_dot_h = dot(wo, h);
    var about = 0.0;
    if h.z > 0.0 && v_dot_h > 0.0 {
        about = proposal_density(tables, turned(h, -tables.turn)) / (4.0 * v_dot_h);
    }
    return TABLE_PROPOSAL_SHARE * about + (1.0 - TABLE_PROPOSAL_SHARE) / PI * wi.z;
}

fn tables_equivalent_roughness(lobe: Lobe) -> f32 {
    return table_sets[u32(lobe.shape)].roughness;
}

fn tables_albedo(lobe: Lobe, n_dot_v: f32, ggx: vec2f) -> vec3f {
    let tables = table_sets[u32(lobe.shape)];
    let x = spread_place(n_dot_v, TABLE_ALBEDO_SCALE);
    let size = vec2u(tables.albedo_columns, 2u);
    return lobe.tint.rgb * table_at(tables.albedo_layer, tables.albedo_row, size, vec2f(x, 0.0), false)
        + lobe.tint.w * table_at(tables.albedo_layer, tables.albedo_row, size, vec2f(x, 1.0), false);
}

// What reflects of a point of the light or a sample of the lobe, weighed by what the other would have found.
fn weighed_lobe(lobe: Lobe, wo: vec3f, wi: vec3f, light_pdf: f32) -> vec3f {
    return tables_lobe(lobe, wo, wi) * (wi.z / (tables_pdf(lobe, wo, wi) + light_pdf));
}

fn tables_light_lobe(lobe: Lobe, wo: vec3f, light: LightPatch) -> vec3f {
    let aa = dot(light.half_width, light.half_width);
    let bb = dot(light.half_height, light.half_height);
    let ab = dot(light.half_width, light.half_height);
    let area2 = max(aa * bb - ab * ab, 1e-30);
    let light_pdf = inverseSqrt(area2) / select(4.0, PI, light.is_disk);
    var sum = vec3f(0.0);
    for (var i = 0u; i < TABLE_LIGHT_POINTS; i++) {
        let u = hammersley(i, TABLE_LIGHT_POINTS);
        let on_disk = sqrt(u.x) * vec2f(cos(TAU * u.y), sin(TAU * u.y));
        let place = select(2.0 * u - 1.0, on_disk, light.is_disk);
        let of_light = normalize(light.direction + light.half_width * place.x + light.half_height * place.y);
        if of_light.z > 0.0 {
            sum += weighed_lobe(lobe, wo, of_light, light_pdf);
        }
        let of_lobe = tables_sample(lobe, wo, u);
        let towards = dot(of_lobe, light.direction);
        if of_lobe.z > 0.0 && towards > 0.0 {
            let a = dot(of_lobe, light.half_width) / towards;
            let b = dot(of_lobe, light.half_height) / towards;
            let seen = vec2f(a * bb - b * ab, b * aa - a * ab) / area2;
            let out = select(max(abs(seen.x), abs(seen.y)), length(seen), light.is_disk);
            let inside = saturate((1.0 + TABLE_LIGHT_BORDER - out) / (2.0 * TABLE_LIGHT_BORDER));
            if inside > 0.0 {
                sum += inside * weighed_lobe(lobe, wo, of_lobe, light_pdf);
            }
        }
    }
    return sum / f32(TABLE_LIGHT_POINTS);
}
