// Shading over a footprint larger than a pixel: what its normals' variance does to the roughness.

// Side of the tiles of the image `footprint`. Larger ones are cheaper and change the mip level in coarser
// steps.
const int FOOTPRINT_TILE_PX = 8;

// What GGX's squared alpha grows by where normals vary: twice their variance along one axis, as for a
// Beckmann lobe that is convolved with a Gaussian (Kaplanyan et al. 2016; Tokuyoshi and Kaplanyan 2019,
// Eq. 4). `lost`: 1 less the squared length of the mean of the unit normals, 0 to 1; the variance is that
// of the von Mises-Fisher lobe of that mean length r, 1 / kappa = (1 - r^2) / (3 r - r^3) (Banerjee et al.
// 2005). 0 for equal normals; finite for a mean of length 0.
float alpha2_of_normals(float lost) {
    float v = clamp(lost, 0.0, 1.0);
    float r = sqrt(1.0 - v);
    return 2.0 * v / max(r * (2.0 + v), 1e-3);
}

// A perceptual roughness (the root of alpha) whose squared alpha has grown.
float widened(float roughness, float alpha2) {
    float square = roughness * roughness;
    return alpha2 > 0.0 ? sqrt(sqrt(min(square * square + alpha2, 1.0))) : roughness;
}
