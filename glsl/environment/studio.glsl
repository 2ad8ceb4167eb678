// A studio: a tiled floor that runs into a backdrop, a window with panes, and strips of light. It stays level and turns
// with the eye, as the light does: the object stands on a turntable.
// Source: PH 2.4 and 3.1 (refraction and reflection need something to show); the room is ours.
// from: of the ray, where it would have no width, object's center, axes of the eye; along: unit; spread: radians between rays of
// neighboring pixels, of which the pattern of the floor and the lights are the mean; result: opaque linear RGBA, brighter than 1 in
// the lights.
// @color backdrop_color = #4d5b73: Color of the backdrop at its top.
// @color horizon_color = #d5dade: Color of the backdrop where the floor runs into it.
// @color tile_color = #f2efe8: Color of the light tiles of the floor.
// @color tile_color_2 = #6a717d: Color of the dark tiles of the floor.
// @param tile_size = 0.6 in [0.05, 10]: Side of a tile, object units.
// @param studio_light = 5 in [0, 50]: Brightness of the window and of the strips of light.

// Mean of stripes of -1 and 1, each one wide, over a footprint of this width: a box filter.
float stripes(float x, float width) {
    float w = max(width, 1e-4), a = x - 0.5 * w, b = x + 0.5 * w;
    float ramp_a = 2.0 * abs(2.0 * fract(0.5 * a) - 1.0), ramp_b = 2.0 * abs(2.0 * fract(0.5 * b) - 1.0);
    return clamp((ramp_a - ramp_b) / (2.0 * w), -1.0, 1.0);
}

// Part of a footprint that lies in a panel of light around `center`, along each axis: a box filter, at least as wide as the
// soft edge, 0.03. Directions projected on a plane at distance 1.
vec2 covered(vec2 p, vec2 center, vec2 half_size, float spread) {
    float width = max(spread * (1.0 + dot(p, p)), 0.03);
    vec2 from = max(p - center - 0.5 * width, -half_size), to = min(p - center + 0.5 * width, half_size);
    return clamp((to - from) / width, 0.0, 1.0);
}

vec4 environment(vec3 from, vec3 along, float spread) {
    vec3 up = safe_normalize(object_matrix[1].xyz, vec3(0.0, 1.0, 0.0));
    vec3 front = vec3(0.0, -up.z, up.y);                            // level, toward the eye
    vec3 d = vec3(along.x, dot(along, up), dot(along, front));
    vec3 p = vec3(from.x, dot(from, up), dot(from, front));

    vec3 light = mix(horizon_color.rgb, backdrop_color.rgb, smoothstep(0.0, 0.45, d.y));
    float floor_height = box_min.y * length(object_matrix[1].xyz);
    if (d.y < -1e-4) {
        float away = (p.y - floor_height) / -d.y;
        vec2 tile = (p.xz + away * d.xz) / tile_size;
        float footprint = abs(away) * spread / tile_size;
        float checks = stripes(tile.x, footprint) * stripes(tile.y, footprint / max(-d.y, 0.02));
        vec3 ground = mix(tile_color_2.rgb, tile_color.rgb, 0.5 + 0.5 * checks);
        light = mix(ground, horizon_color.rgb, smoothstep(2.0, 14.0, length(p.xz + away * d.xz)));
    }

    float shine = 0.0;
    vec2 left = d.zy / max(-d.x, 1e-3), right = d.zy / max(d.x, 1e-3), above = d.xz / max(d.y, 1e-3);
    if (d.x < 0.0) {                                                // a window, two by two panes
        vec2 part = covered(left, vec2(0.09, 0.36), vec2(0.205), spread)
                  + covered(left, vec2(0.61, 0.88), vec2(0.205), spread);
        shine += part.x * part.y;
    }
    if (d.x > 0.0) {
        vec2 part = covered(right, vec2(-0.3, 0.45), vec2(0.085, 0.735), spread);
        shine += 0.6 * part.x * part.y;
    }
    if (d.y > 0.0) {
        vec2 part = covered(above, vec2(0.1, -0.2), vec2(0.685, 0.205), spread);
        shine += 0.8 * part.x * part.y;
    }
    return vec4(light + studio_light * shine, 1.0);
}
