// The samples of an eye that is rendered by itself.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "lp_classify/classify.glsl"
