#version 450
// A function at 4096 places of a line: the beginning of each function in crates/measure/src/cases.
// Source: -
// setting: ends of the line and parameters; place: from setting.x in steps of a 4096th of the way to setting.y, f32.
layout(set = 0, binding = 0) uniform Setting { vec4 setting; };
layout(location = 0) out vec4 fragment;
float part() { return (floor(gl_FragCoord.x) + 64.0 * floor(gl_FragCoord.y)) / 4096.0; }
float place() { return setting.x + (setting.y - setting.x) * part(); }
