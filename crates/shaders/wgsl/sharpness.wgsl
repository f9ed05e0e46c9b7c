// What a technique that traces few rays knows of a light's shadow besides its visibility; others leave it at 0.

// How sharp it is: the share of the light that blockers hide, over the square of the penumbra's width [1/m^2]. Light changes from place to place
// by no more than that (Mehta, Wang and Ramamoorthi 2012).
var<private> shadow_sharpness: f32;
// Variance of the visibility.
var<private> shadow_variance: f32;
