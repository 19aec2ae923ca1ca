// The block that the passes over LP texels read their places from; mapping.glsl knows what is in it.
// Needs LP_TABLES_BINDING.
layout(set = 0, binding = LP_TABLES_BINDING, std430) readonly buffer LpTables { vec4 lp_tables[]; };
