// Reading what lp_tables.comp wrote. Needs the block LpTables and `fovea`.

// A column's radii in px: at its centre, its inner edge, its outer edge, and half a texel beyond.
vec4 column_radii_px(uint u) {
    return lp_tables[u];
}

// Unit direction from the gaze of a row's centre.
vec2 row_direction(uint v) {
    return lp_tables[fovea.size.z + v].xy;
}

// Height of a texel at a radius, px.
float row_height_px(float radius_px) {
    return radius_px * (6.2831853 / fovea.size_f.y);
}
