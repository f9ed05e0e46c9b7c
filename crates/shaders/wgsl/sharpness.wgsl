// What a technique that traces few rays knows of a light's shadow besides its visibility; others leave it as it is here.

// How sharp it is: the share of the light that blockers hide, over the square of the penumbra's width [1/m^2]. Light changes from place to place
// by no more than that (Mehta, Wang and Ramamoorthi 2012).
var<private> shadow_sharpness: f32;
// Variance of the visibility.
var<private> shadow_variance: f32;
// What the light gives without shadows per unit of its radiance [sr], where it is known better than its outline tells; below 0 elsewhere.
var<private> known_form_factor: f32 = -1.0;
