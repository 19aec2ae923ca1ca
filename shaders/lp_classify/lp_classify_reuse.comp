// The samples of the right eye that the left eye does not have.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#define LP_REUSE
#include "lp_classify/classify.glsl"
