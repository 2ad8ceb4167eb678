// Light that goes straight on.
// Source: GG 39.5.1.
// ray: across the light's buffer; left: the part that a slice lets through; path: object units. Result: light behind it.
vec4 passed(vec2 ray, float left, float path) { return left * texelFetch(light_before, ivec2(gl_FragCoord.xy), 0); }
