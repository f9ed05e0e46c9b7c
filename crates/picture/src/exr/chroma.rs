//! Luminance-chroma pictures: chroma of every second column and row is interpolated and turned into colours as the OpenEXR library
//! does (*Technical Introduction to OpenEXR*, "Luminance/Chroma Images"), but not across edges of suns and lamps: there a hundredth of
//! the chroma of the sky would be a colour as bright as it.

use glam::Vec3;

use crate::RgbImage;

/// Weights of the samples on either side of one that is missing, from 1 to 13 texels away in steps of two.
const TAPS: [f32; 7] = [0.627_123, -0.186_077, 0.087_929, -0.043_159, 0.019_597, -0.007_54, 0.002_128];

/// Luminances that differ by more than this factor have chroma of their own: no surface under one light does.
const EDGE: f32 = 32.0;
/// Least sum of the weights that are left, of 1.
const LEAST_WEIGHT: f32 = 0.25;

/// Fills what is missing of the chroma: `x` and `z` of texels in odd columns or rows.
pub(super) fn fill(picture: &mut RgbImage) {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    for y in (0..height).step_by(2) {
        let row = picture.row_mut(y as u32);
        for x in (1..width).step_by(2) {
            let sum = interpolated(x, width, |column| row[column]);
            (row[x].x, row[x].z) = (sum.x, sum.z);
        }
    }
    for y in (1..height).step_by(2) {
        for x in 0..width {
            let sum = interpolated(y, height, |row| picture.get(x as u32, row as u32));
            let texel = picture.get_mut(x as u32, y as u32);
            (texel.x, texel.z) = (sum.x, sum.z);
        }
    }
}

/// Interpolates at an odd place of `count` from even ones whose luminance (`y`) is like that place's own; past the ends the last even one
/// counts.
fn interpolated(at: usize, count: usize, sample: impl Fn(usize) -> Vec3) -> Vec3 {
    let last = (count - 1) & !1;
    let luminance = sample(at).y;
    // How many times one is the other; what is no luminance is unlike everything.
    let ratio = |other: Vec3| {
        let ratio = other.y.max(luminance) / other.y.min(luminance);
        if other.y == luminance {
            1.0
        } else if ratio >= 1.0 {
            ratio
        } else {
            f32::INFINITY
        }
    };
    let pair = |distance: usize| [sample(at.saturating_sub(distance)), sample((at + distance).min(last))];
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for (index, &weight) in TAPS.iter().enumerate() {
        for value in pair(2 * index + 1).into_iter().filter(|&value| ratio(value) <= EDGE) {
            sum += value * weight;
            weights += weight;
        }
    }
    let [before, after] = pair(1);
    if ratio(before).min(ratio(after)) <= EDGE && weights >= LEAST_WEIGHT {
        sum / weights
    } else if ratio(before) <= ratio(after) {
        before
    } else {
        after
    }
}

/// Turns rows of red less luminance, luminance, and blue less luminance, both over luminance, into red, green and blue.
pub(super) fn colors(row: &mut [Vec3], luminance_weights: Vec3) {
    for texel in row {
        let Vec3 { x: ry, y: luminance, z: by } = *texel;
        *texel = if ry == 0.0 && by == 0.0 {
            Vec3::splat(luminance)
        } else {
            let (r, b) = ((ry + 1.0) * luminance, (by + 1.0) * luminance);
            let g = (luminance - r * luminance_weights.x - b * luminance_weights.z) / luminance_weights.y;
            Vec3::new(r, g, b)
        };
    }
}

/// A row of colours whose saturation is brought down to what its neighbours in the rows `above` and `below` have: sharp edges of colour
/// overshoot when chroma is interpolated.
pub(super) fn saturation_fixed([above, row, below]: [&[Vec3]; 3], luminance_weights: Vec3) -> Vec<Vec3> {
    let texel = |(x, &color): (usize, &Vec3)| {
        let (left, right) = (x.saturating_sub(1), (x + 1).min(row.len() - 1));
        let corners = [above[left], above[right], below[left], below[right]];
        let mean = (0.25 * corners.into_iter().map(saturation).sum::<f32>()).min(1.0);
        let most = (1.0 - (1.0 - mean) * 0.25).min(1.0);
        let own = saturation(color);
        if own > mean && own > most { desaturated(color, most / own, luminance_weights) } else { color }
    };
    row.iter().enumerate().map(texel).collect()
}

fn saturation(color: Vec3) -> f32 {
    let most = color.max_element();
    if most > 0.0 { 1.0 - color.min_element() / most } else { 0.0 }
}

/// Less saturated, of the same luminance.
fn desaturated(color: Vec3, factor: f32, luminance_weights: Vec3) -> Vec3 {
    let most = color.max_element();
    let paler = (most - (most - color) * factor).max(Vec3::ZERO);
    let luminance = paler.dot(luminance_weights);
    if luminance > 0.0 { paler * (color.dot(luminance_weights) / luminance) } else { paler }
}
