vec3 sdf_radiance(vec3 o, vec3 d, float a) { return d*0.5+0.5; }
