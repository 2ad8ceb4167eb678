#version 450
// Places on a line for a function in crates/measure/src/cases, which follows.
// Source: -
// place: one of 4096 from setting.x up to setting.y, f32.
layout(set = 0, binding = 0) uniform Setting { vec4 setting; };
layout(location = 0) out vec4 fragment;
float part() { return (floor(gl_FragCoord.x) + 64.0 * floor(gl_FragCoord.y)) / 4096.0; }
float place() { return setting.x + (setting.y - setting.x) * part(); }
