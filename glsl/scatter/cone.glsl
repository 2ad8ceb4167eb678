// Translucency: beside the light that goes straight on, in A, there is light that is scattered forward, in RGB. Each slice
// blurs it, and takes less of it than of the other, by channel.
// Source: Kniss, Premoze, Hansen, Shirley and McPherson 2003 (indirect light, blurred and colored from slice to slice);
// GG 39.5.1. That the blur's variance grows with the path, and so does not depend on the number of slices, is ours.
// ray: across the light's buffer; left: the part of direct light that a slice lets through; path: object units.
// Result: light behind it. Straight light falls by left, scattered light by left^(1 - transport_color).
#include <filter>
vec4 passed(vec2 ray, float left, float path) {
    // A tap n + part texels away is the filter's mean of those n and n + 1 away: with this part, exactly of that variance.
    float texel = 2.0 * shadow_rim * length((shadow_matrix * vec4(position_eye, 1.0)).xyz) / shadow_side;
    float variance = scatter * scatter * path / (texel * texel);
    float n = floor(sqrt(variance)), part = (variance - n * n) / (2.0 * n + 1.0);
    vec2 tap = vec2(n + part, -n - part) / shadow_side;
    vec3 scattered = 0.25 * (lookup_plane(light_before, ray + tap.xx).rgb + lookup_plane(light_before, ray + tap.xy).rgb +
                             lookup_plane(light_before, ray + tap.yx).rgb + lookup_plane(light_before, ray + tap.yy).rgb);
    vec3 through = left >= 1.0 ? vec3(1.0) : left > 0.0 ? pow(vec3(left), 1.0 - transport_color.rgb) : vec3(0.0);
    return vec4(through * scattered, left * texelFetch(light_before, ivec2(gl_FragCoord.xy), 0).a);
}
