// Distance from the last sample of a ray to the soft region, less than 0 inside of it: how far the ray may skip.
// Source: MJ 7 (empty-space skipping by the distance field).
// Object units; 0 where no distance is sampled, and then no ray skips. Set by what classifies the ray's own samples alone.
float distance_bound = 0.0;
