// Hair: dark at the root, bright at the tip, with the highlight of thin cylinders.
// Source: Kajiya and Kay 1989 (PH 4 asks for anisotropic fur shading).
// density: modulated, in [0, 1]; result: linear RGB; extinction: a factor of the opacity rate, by one over the length of the
// hair (ours): the way through a coat is as long as its hair, and what covers the skin at one length does so at each.
// @needs normal
// @groom color
// @color root_color = #2b1509: Color of the hair at the skin.
// @color tip_color = #d9a05f: Color of the hair at its tip.
// @param sheen = 0.25 in [0, 2]: Strength of the highlight.
#include "eye_normal.glsl"
#include <shadow>
#ifdef OPACITY_ALONE
vec3 medium(Sample s, float density) { return vec3(0.0); }
#else
vec3 medium(Sample s, float density) {
    float tip = clamp(1.0 - s.density, 0.0, 1.0);
    vec3 t = eye_normal(s.hair_tangent);
    vec3 n = eye_normal(s.hair_normal);
    vec3 l = safe_normalize(light_position.xyz - position_eye, t);
    vec3 v = to_eye();
    float tl = clamp(dot(t, l), -1.0, 1.0), tv = clamp(dot(t, v), -1.0, 1.0);
    float sin_tl = sqrt(1.0 - tl * tl), sin_tv = sqrt(1.0 - tv * tv);
    float wrap = clamp(0.5 + 0.5 * dot(n, l), 0.0, 1.0);      // hair on the far side is in the shadow of the body
    vec3 lit = shadow(mix(0.25, 1.0, tip) * wrap, vec3(0.0));
    float specular = pow(max(sin_tl * sin_tv - tl * tv, 1e-4), specular_power);     // the mirrored cone: t.r = -t.l
    vec3 base = mix(root_color.rgb, tip_color.rgb, tip) * color.rgb;
    groomed(base = groom_color(base, s.root);)
    return base * (ambient_color.rgb * mix(0.4, 1.0, tip) + lit * sin_tl * light_color.rgb)
         + sheen * lit * specular * light_color.rgb;
}
#endif
float extinction(Sample s, float density) { return 0.2 / max(s.hair_length, 0.005); }
