// Two phases of a loop: while noise drifts on, it fades into the noise that drifted here one loop before, so that the loop
// ends as it began. The weights keep the variance, also where the noise moves so little that both phases are alike.
// Source: ours, of Heitz and Neyret 2018 (blends that keep the variance), for the two phases of a flow map.
// SECOND_PHASE and UNTIL: as one.glsl has them. now, then: noise of both phases; velocity: of the place, cells of noise per
// second; range: lowest value, mean, and highest value of the noise; results: the noise, and the place one loop before.
// @param loop_seconds = 4 in [0.01, 1e6]: Length of the loop, seconds: that of animation.loop.
#define SECOND_PHASE(code) code
#define UNTIL(enough) ALL
const vec3 NOISE_RANGE = vec3(-0.8660254, 0.0, 0.8660254), SUM_RANGE = vec3(0.0, 0.3, 1.7320508);

vec2 phase_weights(vec3 velocity) {
    float part = 1.5707963 * clamp(time / loop_seconds, 0.0, 1.0);
    vec2 weights = vec2(cos(part), sin(part));
    float alike = 1.0 - smoothstep(0.0, 1.0, loop_seconds * length(velocity));     // correlation, of noise a cell apart none
    return weights * inversesqrt(1.0 + 2.0 * alike * weights.x * weights.y);
}

vec3 earlier(vec3 p, vec3 velocity) { return p - loop_seconds * velocity; }

float passing(float now, float then, vec3 velocity, vec3 range) {
    return clamp(range.y + dot(phase_weights(velocity), vec2(now, then) - range.y), range.x, range.z);
}

vec3 passing(vec3 now, vec3 then, vec3 velocity) { return mat2x3(now, then) * phase_weights(velocity); }

mat3 passing(mat3 now, mat3 then, vec3 velocity) {
    vec2 weights = phase_weights(velocity);
    return weights.x * now + weights.y * then;
}

// Of a noise with its gradient.
vec4 passing(vec4 now, vec4 then, vec3 velocity, vec3 range) {
    return vec4(passing(now.xyz, then.xyz, velocity), passing(now.w, then.w, velocity, range));
}
