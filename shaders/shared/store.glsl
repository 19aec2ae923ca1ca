// Radiance as the half-float images hold it: clamped where it is stored, not where it is computed.
const float MAX_HALF = 65504.0;

vec3 storable(vec3 radiance) {
    // min and max drop a NaN on most hardware but need not: say it.
    vec3 clean = mix(radiance, vec3(0.0), isnan(radiance));
    return clamp(clean, vec3(0.0), vec3(MAX_HALF));
}
