// Where a DMF acts: in a ball.
// Source: MJ 6: DMFs chosen by spatial coordinates; Satherley and Jones 2002: hypertexture applied in chosen places.
// Result in [0, 1]; object space.
// @param ball_x = 0.0 in [-4, 4]: Center, object units.
// @param ball_y = 0.5 in [-4, 4]: Center, object units.
// @param ball_z = 0.0 in [-4, 4]: Center, object units.
// @param ball_radius = 0.7 in [0, 8]: Radius, object units.
// @param ball_blend = 0.2 in [0.001, 4]: Length over which it fades, object units.
float ball(Sample s) {
    float half_blend = 0.5 * ball_blend;
    float away = length(s.x - vec3(ball_x, ball_y, ball_z));
    return 1.0 - smoothstep(ball_radius - half_blend, ball_radius + half_blend, away);
}
